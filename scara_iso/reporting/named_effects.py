"""What is said of an effect that was found: how sure, which rivals, its size, its cause."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from scara_iso.diagnosis import (
    ODD,
    Diagnosis,
    DiagnosisOfPoses,
    Found,
    FoundAtPoses,
    ParameterValue,
    Rival,
    Verdict,
)
from scara_iso.effects import find_effects
from scara_iso.reporting.blocks import Block, Facts, NextStep, Text, digits_of, p_equals, words
from scara_iso.tables import listed

_SURE, _LIKELY = 0.9, 0.6
_MOST_KINDS = 3
_SECONDS = "_s"
_OF_JOINT = re.compile(r"T([1-9])(?:_C)?")
"""Ends the name of a time that is given in seconds as well as in cycles."""
_DUST = 1e-9
"""Share of a size below which its standard error is the rounding of the arithmetic."""
_CHANCE = (
    "p-value: probability of at least this much structure if there is only scatter. Where nothing "
    "was found, an effect too small for these cycles may still be there."
)


@dataclass(frozen=True, slots=True)
class Failure:
    """A table that could not be diagnosed."""

    message: str
    """What is wrong with it."""
    exit_code: int
    """The one with which the command ends."""


def sureness(found: Found, *, on_axes: bool = True) -> str:
    """Return how sure the name is: 0.9 names it, 0.6 says "or", below the whole set is said."""
    where = f" on {', '.join(found.axes)}" if found.axes and on_axes else ""
    if on_axes and isinstance(found, FoundAtPoses) and found.joint and found.place:
        where += f", {found.place}"
    where = f"{_in_cycles(found)}{where}"
    if found.probability >= _SURE or not found.rivals:
        return f"{words(found.effect)}{where} ({found.probability:.0%})"
    if found.effect == ODD:
        return f"odd reading{where}, or scatter with heavy tails"
    others = found.rivals[:1] if found.probability >= _LIKELY else found.rivals
    names = [_unproven(found), *(words(rival.effect) for rival in others)]
    if is_of_a_kind(found):
        return f"{' or '.join(names)}{where}"
    likeliest = f"{', '.join(names[:_MOST_KINDS])} or {len(names) - _MOST_KINDS} others"
    return f"more than scatter{where}, its kind not clear: {likeliest}"


def _in_cycles(found: Found) -> str:
    cycles = found.parameters.get("cycles")
    if not isinstance(cycles, tuple):
        return ""
    return f" in cycle{'s' if len(cycles) > 1 else ''} {listed(list(map(str, cycles)))}"


def _unproven(found: Found) -> str:
    """Return the name of an effect that is not sure; two levels alone prove no contact."""
    name = words(found.effect)
    unseen = {effect.name for effect in find_effects() if effect.by_flank and not effect.needs}
    return f"two levels, {name}" if found.effect in unseen else name


def odd_in_words(found: Diagnosis) -> str:
    """Return what the readings to look at may be where nothing was found; empty for none."""
    if found.verdict is not Verdict.NOTHING or not found.flags:
        return ""
    at = listed([f"{flag.axis} in cycle {flag.cycle}" for flag in found.flags])
    return f"odd reading, or scatter with heavy tails: {at}"


def is_of_a_kind(found: Found) -> bool:
    """Return whether so few effects are left that a cause can be looked for."""
    return found.probability >= _LIKELY or len(found.rivals) <= _MOST_KINDS


def rivals_in_words(rivals: Sequence[Rival]) -> str:
    """Return effects with their probabilities."""
    return ", ".join(f"{words(rival.effect)} ({rival.probability:.0%})" for rival in rivals)


def unexplained_in_words(found: Diagnosis | DiagnosisOfPoses) -> str:
    """Return that there is more than scatter, and more than the effects found."""
    what = "what is left is more than scatter" if found.effects else "more than scatter"
    return f"Unexplained: {what}, and no known effect fits it"


def diagnosis_in_words(found: Diagnosis | Failure) -> str:
    """Return what was found as a clause of a sentence, for who knows no statistics."""
    if isinstance(found, Failure):
        return f"the readings could not be diagnosed ({found.message})"
    match found.verdict:
        case Verdict.EXPLAINED:
            return f"the readings show {'; '.join(map(sureness, found.effects))}"
        case Verdict.UNEXPLAINED if found.effects:
            named = "; ".join(map(sureness, found.effects))
            return f"the readings show {named}, and besides more that no known effect accounts for"
        case Verdict.UNEXPLAINED:
            return "the readings show more than scatter, and no known effect accounts for it"
    text = "nothing besides scatter and the dial's division was found"
    return f"{text}, but an {odd}" if (odd := odd_in_words(found)) else text


def cause_and_test(found: Found) -> Iterator[Text]:
    """Yield the likely cause and how to be sure of it, as far as the effect is named."""
    if is_of_a_kind(found):
        yield Text(f"Likely: {found.cause}")
        yield Text(f"To be sure: {found.confirm_by}")
    else:
        yield Text("To be sure: repeat the run; chance does not come back, a cause does")


def page_of(found: Found) -> NextStep | None:
    """Return the command that explains an effect; None for a user's own, which it does not know."""
    if found.effect not in {effect.name for effect in find_effects()}:
        return None
    return NextStep(f"scara-iso explain {found.effect}", "what it means, and how to be sure")


def sizes_in_words(found: Found) -> list[str]:
    """Return the sizes of an effect, each with its 95 % interval if it has one, and the rest."""
    sizes = found.parameters.get("size")
    by_axis = sizes if isinstance(sizes, Mapping) else {}
    errors, unit = _errors(found, "size"), unit_of(found, "size")
    parts = [
        f"{_size(axis, size, errors.get(axis))} {length(axis)} {unit}".rstrip()
        for axis, size in by_axis.items()
    ]
    others = [name for name in found.parameters if not by_axis or name != "size"]
    return [*parts, *([parameters_in_words(found, others)] if others else [])]


def parameters_in_words(found: Found, only: Iterable[str] | None = None) -> str:
    """Return the parameters of an effect with their units, those of each axis with intervals."""
    names = found.parameters if only is None else only
    return ", ".join(
        _parameter(name, found.parameters[name], found)
        for name in names
        if name.removesuffix(_SECONDS) not in found.parameters or not name.endswith(_SECONDS)
    )


def _parameter(name: str, value: ParameterValue, found: Found) -> str:
    if isinstance(value, tuple):
        return f"{words(name)} {listed(list(map(str, value)))}"
    if not isinstance(value, Mapping):
        text = value if isinstance(value, str) else f"{value:.3g}"
        if name == "column" and (joint := _OF_JOINT.fullmatch(text)):
            text += f" (temperature of joint {joint[1]})"
        seconds = found.parameters.get(f"{name}{_SECONDS}")
        also = f" ({seconds:.3g} s)" if isinstance(seconds, float) else ""
        return f"{words(name)} {text} {unit_of(found, name)}".rstrip() + also
    errors = _errors(found, name)
    parts = [
        _size(axis, size, errors[axis]) if errors.get(axis) else f"{axis} {size:+.3g}"
        for axis, size in value.items()
    ]
    return f"{words(name)} {', '.join(parts)} {unit_of(found, name)}".rstrip()


def _errors(found: Found, name: str) -> Mapping[str, float]:
    """Return standard errors of a parameter by axis, none where the readings do not bound it."""
    bounded = not any(line.startswith(name) for line in found.unidentified)
    return found.standard_errors.get(name, {}) if bounded else {}


def _size(axis: str, size: float, error: float | None) -> str:
    if not error or error < _DUST * abs(size):
        return f"{axis} about {size:+.2g}"
    ends = size - 2 * error, size + 2 * error
    text, low, high = (f"{x:+.{digits_of(size, ends)}f}" for x in (size, *ends))
    return f"{axis} {text} [{low}, {high}]"


def length(axis: str) -> str:
    """Return mm of an axis that is a length whatever the indicator: theta may be either."""
    return "" if axis == "theta" else "mm"


def unit_of(found: Found, parameter: str) -> str:
    """Return the unit of a parameter, as far as it is not that of the reading."""
    unit = found.units.get(parameter, "")
    return unit.replace("reading/", "per ").removeprefix("reading")


def interpretation(diagnoses: Mapping[str | None, Diagnosis | Failure]) -> Iterator[Block]:
    """Yield what was found at which poses, and of each effect sizes, cause and test."""
    poses: dict[str, list[str]] = {}
    for pose, found in diagnoses.items():
        p = "" if isinstance(found, Failure) else f" ({p_equals(found)})"
        poses.setdefault(diagnosis_in_words(found) + p, []).append(pose or "")
    yield Facts(tuple((listed(at) or "all cycles", text) for text, at in poses.items()))
    yield Text(_CHANCE, "quiet")
    effects: dict[str, list[tuple[str | None, Found]]] = {}
    for pose, found in diagnoses.items():
        if isinstance(found, Diagnosis):
            for one in found.effects:
                effects.setdefault(one.effect, []).append((pose, one))
            if found.verdict is Verdict.UNEXPLAINED and found.candidates:
                yield Text(f"{_at(pose)}nearest: {rivals_in_words(found.candidates)}")
    for name, places in effects.items():
        yield from _at_poses(name, places)


def _at_poses(name: str, places: Sequence[tuple[str | None, Found]]) -> Iterator[Text]:
    yield Text(words(name).capitalize(), "strong")
    for pose, found in places:
        others = f"; not excluded: {rivals_in_words(found.rivals)}" if found.rivals else ""
        axes = f" on {', '.join(found.axes)}" if found.axes else ""
        sure = f"probability {found.probability:.0%}{others}"
        yield Text(f"{_at(pose)}{parameters_in_words(found)}{axes}; {sure}")
    one = places[0][1]
    yield Text(f"Cause: {one.cause}.")
    yield Text(f"To confirm: {one.confirm_by}.")


def _at(pose: str | None) -> str:
    return f"{pose}: " if pose else ""
