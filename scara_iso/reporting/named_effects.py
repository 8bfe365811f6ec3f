"""What is said of an effect: how sure, which rivals, size and cause; the warning of the watch."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from scara_iso.diagnosis import (
    LEVEL,
    ODD,
    SIZE_AT,
    UNKNOWN,
    Diagnosis,
    DiagnosisOfPoses,
    Found,
    FoundAtPoses,
    ParameterValue,
    Rival,
    Verdict,
    Watched,
)
from scara_iso.effects import find_effects
from scara_iso.reporting.shared.blocks import Block, Facts, NextStep, Text, note
from scara_iso.reporting.shared.digits import p_equals, result, words
from scara_iso.tables import listed

_SURE, _LIKELY = 0.9, 0.6
_MOST_KINDS = 3
_MOST_ODD, _MOST_NAMED = 3, 4
_SECONDS = "_s"
"""Ends the name of a time that is given in seconds as well as in cycles."""
_OF_JOINT = re.compile(r"T([1-9])(?:_C)?")
_DUST = 1e-9
"""Share of a size below which its standard error is the rounding of the arithmetic."""
NOTHING = "nothing besides scatter and the dial's division"
NOTHING_MORE = "nothing besides what the model declares, scatter and the dial's division"


@dataclass(frozen=True, slots=True)
class Failure:
    """A table that could not be diagnosed."""

    message: str
    """What is wrong with it."""
    exit_code: int
    """The one with which the command ends."""


def sureness(found: Found, *, on_axes: bool = True, in_full: bool = False) -> str:
    """Return how sure the name is: 0.9 names it, 0.6 says "or", below the whole set is listed.

    Probabilities are those of the name alone, or ``in_full`` of its rivals too.
    """
    named = found.probability >= _SURE or not found.rivals

    def with_its(name: str, one: Found | Rival) -> str:
        return f"{name} ({one.probability:.0%})" if named or in_full else name

    cycles = found.parameters.get("cycles")
    where = ""
    if isinstance(cycles, tuple):
        where = f" in cycle{'s' if len(cycles) > 1 else ''} {listed(list(map(str, cycles)))}"
    if on_axes:
        where += f" on {', '.join(found.axes)}" if found.axes else ""
        if isinstance(found, FoundAtPoses) and found.joint and found.place:
            where += f", {found.place}"
    if named:
        return with_its(f"{words(found.effect)}{where}", found)
    if found.effect == ODD:
        return with_its(f"odd reading{where}, or scatter with heavy tails", found)
    others = found.rivals[:1] if found.probability >= _LIKELY else found.rivals
    names = [with_its(words(rival.effect), rival) for rival in others]
    names = [with_its(_unproven(found), found), *names]
    if is_of_a_kind(found):
        return f"{' or '.join(names)}{where}"
    likeliest = f"{', '.join(names[:_MOST_KINDS])} or {len(names) - _MOST_KINDS} others"
    return f"more than scatter{where}, its kind not clear: {likeliest}"


def _unproven(found: Found) -> str:
    """Return the name of an effect that is not sure; two levels alone prove no contact."""
    name = words(found.effect)
    unseen = {effect.name for effect in find_effects() if effect.by_flank and not effect.needs}
    return f"two levels, {name}" if found.effect in unseen else name


def is_suspected(found: Diagnosis | DiagnosisOfPoses) -> bool:
    """Return whether the effects found foretell no unseen cycle better: then they are no fact."""
    axes = {axis for one in found.effects for axis in one.axes}
    before, after = (
        sum(rms**2 for axis, rms in error.held_out_rms.items() if axis in axes)
        for error in (found.error.before, found.error.after)
    )
    return bool(found.effects) and after >= before > 0


def how_likely(found: Diagnosis | DiagnosisOfPoses, one: Found) -> str:
    """Return how a cause is said: of what may be no known effect it is no more than possible."""
    may_be_none = one.probability < _SURE and UNKNOWN in {rival.effect for rival in one.rivals}
    return "Possible" if may_be_none or is_suspected(found) else "Likely"


def odd_in_words(found: Diagnosis | DiagnosisOfPoses) -> str:
    """Return what the readings to look at may be where nothing was found; empty for none."""
    poses = found.poses if isinstance(found, DiagnosisOfPoses) else {"": found}
    at = [
        f"{pose} {flag.axis} in cycle {flag.cycle}".strip()
        for pose, one in poses.items()
        for flag in one.flags
    ]
    if found.verdict is not Verdict.NOTHING or not at:
        return ""
    more = [f"{len(at) - _MOST_ODD} more"] if len(at) > _MOST_ODD else []
    return f"odd reading, or scatter with heavy tails: {listed([*at[:_MOST_ODD], *more])}"


def is_of_a_kind(found: Found) -> bool:
    """Return whether so few effects are left that a cause can be looked for."""
    return found.probability >= _LIKELY or len(found.rivals) <= _MOST_KINDS


def rivals_in_words(rivals: Sequence[Rival]) -> str:
    """Return effects with their probabilities."""
    return ", ".join(f"{words(rival.effect)} ({rival.probability:.0%})" for rival in rivals)


def probability_in_words(probability: float, rivals: Sequence[Rival]) -> str:
    """Return the probability of an effect, and which others are not excluded."""
    others = f"; not excluded: {rivals_in_words(rivals)}" if rivals else ""
    return f"probability {probability:.0%}{others}"


def unexplained(found: Diagnosis | DiagnosisOfPoses) -> Iterator[Text]:
    """Yield that there is more than scatter, and more than the effects found."""
    if found.verdict is not Verdict.UNEXPLAINED:
        return
    gears = found.reversals if isinstance(found, Diagnosis) else None
    if gears is not None and UNKNOWN in gears.accounts_for:
        what = "Unexplained as a course over the cycles: the effects on the gear account for it"
        yield Text(f"{what} (`full=`)", "warn")
        return
    what = "what is left is more than scatter" if found.effects else "more than scatter"
    yield Text(f"Unexplained: {what}, and no known effect fits it", "warn")


def nearest(found: Diagnosis | DiagnosisOfPoses) -> Text:
    """Return which known effects are nearest to what no effect explains; empty where none is."""
    near = [rival for rival in found.candidates if rival.effect != UNKNOWN]
    left_over = near and found.verdict is Verdict.UNEXPLAINED
    return Text(f"Nearest known effects: {rivals_in_words(near)}" if left_over else "")


def diagnosis_in_words(found: Diagnosis | Failure) -> str:
    """Return what was found as a clause of a sentence, for who knows no statistics."""
    if isinstance(found, Failure):
        return f"the readings could not be diagnosed ({found.message})"
    named = "; ".join(sureness(one, in_full=True) for one in found.effects)
    p = p_equals(found)
    match found.verdict:
        case Verdict.EXPLAINED if is_suspected(found):
            return f"{named} is suspected, and predicts no unseen cycle better ({p})"
        case Verdict.EXPLAINED:
            return f"the readings show {named} ({p})"
        case Verdict.UNEXPLAINED if named:
            more = "and besides more that no known effect accounts for"
            return f"the readings show {named}, {more} ({p})"
        case Verdict.UNEXPLAINED:
            return f"the readings show more than scatter, and no known effect accounts for it ({p})"
    odd = odd_in_words(found)
    of_all = f" ({p})" if found.p_value > LEVEL else ""  # else it is that of other poses
    return f"{NOTHING} was found{odd and f', but an {odd}'}{of_all}"


def page_of(found: Found) -> NextStep | None:
    """Return the command that explains an effect; None for a user's own, which it does not know."""
    if found.effect not in {effect.name for effect in find_effects()}:
        return None
    return NextStep(f"scara-iso explain {found.effect}", "what it means, and how to be sure")


def places_in_words(effects: Sequence[FoundAtPoses]) -> list[str]:
    """Return where each effect acts, as far as the poses tell, and how sure that is.

    What stands alone at a pose tells of the bench there: that is said once, of the last one.
    """
    last = max((k for k, one in enumerate(effects) if one.place in one.poses), default=-1)
    places = [_place_in_words(one) for one in effects]
    return [
        f"{at}: a fixture or an indicator there" if k == last else at for k, at in enumerate(places)
    ]


def _place_in_words(found: FoundAtPoses) -> str:
    if found.joint_candidates:
        names = " or ".join(f"joint {number}" for number in found.joint_candidates)
        return f"in {names}: these poses do not tell"
    if found.place is None or found.place not in found.places or found.place == "every axis":
        return f"at {', '.join(found.poses)}"
    p = found.places[found.place]
    sure = "" if p >= _SURE else f" ({p:.0%})"
    if found.place in found.poses:
        return f"at {found.place} alone{sure}"
    if found.joint == found.place == "along the arm":
        return f"along the arm{sure}: the links grow"
    if found.place.endswith(" everywhere"):
        return f"in {found.place.removesuffix(' everywhere')} alike at every pose{sure}"
    or_dial = " or the theta indicator" if found.joint == "joint 4" else ""
    return f"in {found.place}{or_dial}{sure}"


def cause_by_place(found: FoundAtPoses) -> str:
    """Return what the place says of the cause; nothing where it says no more than a single pose."""
    place = found.place or ""
    if found.joint == "along the arm":
        return "the links grow, as when warm: every pose moves away from the base axis"
    if found.joint == "joint 4":
        return "joint 4, or the theta indicator: theta turns alike at every pose"
    if found.joint is not None:
        return (
            f"gear, belt, encoder or bearing of {place or found.joint}, as all poses move with it"
        )
    if place.endswith(" everywhere"):
        axis = place.removesuffix(" everywhere")
        return f"the {axis} indicator, its stand or its datum: {axis} moves alike at every pose"
    return ""


def confirm_by_place(found: FoundAtPoses) -> str:
    """Return what shows that it is of the place: that of the effect would look elsewhere."""
    if found.joint is None or found.joint in ("along the arm", "joint 4"):
        return found.confirm_by
    joint = found.place or found.joint
    return f"look at coupling, belt and encoder of {joint}, then repeat the run: it must be gone"


def sizes_in_words(found: Found) -> list[str]:
    """Return the sizes of an effect, each with its 95 % interval if it has one, and the rest."""
    if odd := [name for name in found.parameters if name.startswith(SIZE_AT)]:
        return [
            f"cycle {name.removeprefix(SIZE_AT)}: {', '.join(_sizes(found, name))}" for name in odd
        ]
    parts = _sizes(found, "size")
    others = [name for name in found.parameters if not parts or name != "size"]
    return [*parts, *([parameters_in_words(found, others)] if others else [])]


def _sizes(found: Found, name: str) -> list[str]:
    sizes = found.parameters.get(name)
    by_axis = sizes if isinstance(sizes, Mapping) else {}
    errors, unit = _errors(found, name), _unit_of(found, name)
    return [
        _size(axis, size, errors.get(axis), f"{length(axis)} {unit}".strip())
        for axis, size in by_axis.items()
    ]


def parameters_in_words(found: Found, only: Iterable[str] | None = None) -> str:
    """Return the parameters of an effect with their units, those of each axis with intervals."""
    names = found.parameters if only is None else only
    cycles = found.parameters.get("cycles")
    single = isinstance(cycles, tuple) and len(cycles) == 1
    twice = {"cycles" if single else "at_cycle"} if cycles else set()
    if any(name.startswith(SIZE_AT) for name in names):
        twice = {"cycles", "at_cycle", "size"}
    return ", ".join(
        _parameter(name, found.parameters[name], found)
        for name in names
        if name not in twice
        and (name.removesuffix(_SECONDS) not in found.parameters or not name.endswith(_SECONDS))
    )


def _parameter(name: str, value: ParameterValue, found: Found) -> str:
    unit = _unit_of(found, name)
    if isinstance(value, tuple):
        return f"{words(name)} {listed(list(map(str, value)))}"
    if isinstance(value, Mapping):
        errors = _errors(found, name)
        parts = [
            _size(axis, size, errors[axis]) if errors.get(axis) else f"{axis} {size:+.3g}"
            for axis, size in value.items()
        ]
        return f"{words(name)} {', '.join(parts)} {unit}".rstrip()
    text = value if isinstance(value, str) else f"{value:.3g}"
    if name == "column" and (joint := _OF_JOINT.fullmatch(text)):
        text += f" (temperature of joint {joint[1]})"
    seconds = found.parameters.get(f"{name}{_SECONDS}")
    also = f" ({seconds:.3g} s)" if isinstance(seconds, float) else ""
    return f"{words(name)} {text} {unit}".rstrip() + also


def _errors(found: Found, name: str) -> Mapping[str, float]:
    bounded = not any(line.startswith(name) for line in found.unidentified)
    return found.standard_errors.get(name, {}) if bounded else {}


def _size(axis: str, size: float, error: float | None, unit: str = "") -> str:
    if not error or error < _DUST * abs(size):
        return f"{axis} about {size:+.2g} {unit}".rstrip()
    return f"{axis} {result(size, (size - 2 * error, size + 2 * error), unit, sign='+')}"


def length(axis: str) -> str:
    """Return mm of an axis that is a length whatever the indicator: theta may be either."""
    return "" if axis == "theta" else "mm"


def _unit_of(found: Found, parameter: str) -> str:
    unit = found.units.get(parameter, "")
    return unit.replace("reading/", "per ").removeprefix("reading")


def _by_wording(diagnoses: Mapping[str | None, Diagnosis | Failure]) -> Mapping[str, list[str]]:
    poses: dict[str, list[str]] = {}
    for pose, found in diagnoses.items():
        poses.setdefault(diagnosis_in_words(found), []).append(pose or "")
    return poses


def found_in_words(
    diagnoses: Mapping[str | None, Diagnosis | Failure], together: Sequence[FoundAtPoses]
) -> str:
    """Return what was found at which poses, and where of all poses together; else nothing."""
    parts: list[str] = []
    for what, at in _by_wording(diagnoses).items():
        named = ", ".join(at) if len(at) <= _MOST_NAMED else f"{len(at)} poses"
        begin = "At" if parts else "at"
        parts.append(f"{begin} {named} {what}" if len(diagnoses) > 1 else what)
    placed = [one for one in together if cause_by_place(one)]
    places = [
        f"{words(one.effect)} {at}" for one, at in zip(placed, places_in_words(placed), strict=True)
    ]
    of_all = f"All poses together: {'; '.join(places)}. " if places else ""
    measured = "The figures above are the measured ones; nothing was taken out of them."
    return f"Interpretation: {'. '.join(parts)}. {of_all}{measured}" if parts else ""


def interpretation(diagnoses: Mapping[str | None, Diagnosis | Failure]) -> Iterator[Block]:
    """Yield what was found at which poses, and of each effect sizes, cause and test."""
    poses = _by_wording(diagnoses)
    yield Facts(tuple((listed(at) or "all cycles", text) for text, at in poses.items()))
    yield Text(note("p_value"), "quiet")
    effects: dict[str, list[tuple[str, Found]]] = {}
    for pose, found in diagnoses.items():
        at = f"{pose}: " if pose else ""
        if isinstance(found, Diagnosis):
            for one in found.effects:
                effects.setdefault(one.effect, []).append((at, one))
            if found.verdict is Verdict.UNEXPLAINED and found.candidates:
                yield Text(f"{at}nearest: {rivals_in_words(found.candidates)}")
    for name, places in effects.items():
        yield Text(words(name).capitalize(), "strong")
        for at, one in places:
            axes = f" on {', '.join(one.axes)}" if one.axes else ""
            sure = probability_in_words(one.probability, one.rivals)
            yield Text(f"{at}{parameters_in_words(one)}{axes}; {sure}")
        yield Text(f"Cause: {places[0][1].cause}.")
        yield Text(f"To confirm: {places[0][1].confirm_by}.")


_RIVALS = 2
_STANDS_OUT = 0.5
"""Share from which a cause is called the likeliest: below, fewer than half are right (watch.py)."""
_UNKNOWN = "look at robot, fixture and indicator"
_YOURS = "A test that is stopped early does not conform to ISO 9283"


def warning(watched: Watched) -> tuple[str, ...]:
    """Return the lines of an alarm: what, since when, what to do now; none where there is none."""
    if watched.says != "structure":
        return ()
    since = watched.since or 1
    named = {effect.name: effect for effect in find_effects()}
    effect = named.get(watched.effect or "")
    likeliest = _named(watched) if effect else f"nothing known fits yet{_others(watched)}"
    begun = f"since cycle {since}" if since > 2 else "from the start"
    do = effect.at_once if effect else _UNKNOWN
    strike = f"strike cycles {since}-{watched.cycle}, or" if since > 2 else "then"
    return (
        f"More than scatter: {likeliest}, {begun} (evidence {watched.evidence:.3g}, alarm at 20)",
        f"{do[0].upper()}{do[1:]}; {strike} start again",
        _YOURS,
    )


def _named(watched: Watched) -> str:
    name = words(watched.effect or "")
    if watched.share is None:
        return f"likeliest {name}"
    so_far = "likeliest so far" if watched.rivals else "likeliest"
    if watched.share < _STANDS_OUT:
        so_far = "too early for a cause:"
    return f"{so_far} {name} ({watched.share:.0%}){_others(watched)}"


def _others(watched: Watched) -> str:
    first = list((watched.rivals or {}).items())[:_RIVALS]
    return "".join(f" or {words(name)} ({share:.0%})" for name, share in first)
