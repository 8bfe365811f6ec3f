"""A diagnosis in short: what it is, what RP has to do with it, what next, and the course.

The diagnosis of every pose in plain words: what was found, how sure, why, and how to tell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from scara_iso.diagnosis import UNKNOWN, Diagnosis, Found, Verdict
from scara_iso.effects import find_effects
from scara_iso.reporting.blocks import (
    Block,
    Facts,
    Headline,
    NextStep,
    Report,
    Section,
    Strip,
    Text,
    answer_lines,
)
from scara_iso.reporting.diagnosis import (
    Failure,
    diagnosis_in_words,
    is_of_a_kind,
    parameters_said,
    rivals_said,
    sureness,
    unexplained_said,
    unit_of,
)
from scara_iso.reporting.digits import U_of_scatter, digits_of, p_equals, rounded, words
from scara_iso.run import FloatArray
from scara_iso.tables import listed

_MOST_NOTES = 3
_GAP = "   "
_RARE = 0.01
_DUST = 1e-9
Again = Callable[..., str]
"""Names the table in a command line, with the options that read it and further ones."""


def diagnosis_brief(diagnosis: Diagnosis, again: Again) -> Report:
    """Return a diagnosis in ten to twenty lines; ``again`` names its table."""
    lines: list[Block] = [*_answer(diagnosis), *_sizes_said(diagnosis), _repeatability(diagnosis)]
    head = answer_lines([*lines, *_why(diagnosis), *doubts(diagnosis)], _next(diagnosis, again))
    return (
        Section("", head),
        Section("", tuple(_courses(diagnosis))),
        Section("", tuple(_behind(diagnosis))),
    )


def _answer(diagnosis: Diagnosis) -> Iterator[Headline]:
    if diagnosis.verdict is Verdict.NOTHING:
        yield Headline(("Nothing besides scatter and the dial's division",), "good")
    if diagnosis.effects:
        yield Headline((f"Found: {'; '.join(map(sureness, diagnosis.effects))}",))
    if diagnosis.verdict is Verdict.UNEXPLAINED:
        yield Headline((unexplained_said(diagnosis),), "warn")


def _sizes_said(diagnosis: Diagnosis) -> Iterator[Text]:
    for found in diagnosis.effects:
        of = f"{words(found.effect)}: " if len(diagnosis.effects) > 1 else ""
        yield Text(f"{of}{_GAP.join(_sizes(found) or ['of no size'])}")


def _sizes(found: Found) -> list[str]:
    """Return the sizes of an effect, each with its 95 % interval if it has one, and the rest."""
    bounded = not any(line.startswith("size") for line in found.unidentified)
    sizes = found.parameters.get("size")
    errors = found.standard_errors.get("size", {}) if bounded else {}
    by_axis = sizes if isinstance(sizes, Mapping) else {}
    unit = unit_of(found, "size")
    said = [
        f"{_size(axis, size, errors.get(axis))} {_length(axis)} {unit}".rstrip()
        for axis, size in by_axis.items()
    ]
    others = [name for name in found.parameters if not by_axis or name != "size"]
    return [*said, *([parameters_said(found, others)] if others else [])]


def _size(axis: str, size: float, error: float | None) -> str:
    if not error or error < _DUST * abs(size):
        return f"{axis} about {size:+.2g}"
    ends = size - 2 * error, size + 2 * error
    said, low, high = (f"{x:+.{digits_of(size, ends)}f}" for x in (size, *ends))
    return f"{axis} {said} [{low}, {high}]"


def _length(axis: str) -> str:
    """Return mm of an axis that is a length whatever the indicator: theta may be either."""
    return "" if axis == "theta" else "mm"


def _repeatability(diagnosis: Diagnosis) -> Text:
    """Return RP as measured, were the effects cured, and in a new test by the completed model."""
    RP = diagnosis.repeatability
    named = [name for name in RP.measured if name != "XYZ"]
    name = "XY" if "XY" in named else named[0]
    n = len(diagnosis.series.cycle)
    said = [f"RP  {name} {rounded(RP.measured[name], U_of_scatter(RP.measured[name], n))}"]
    removed = RP.with_effect_removed.get(name)
    if diagnosis.effects and removed is not None:
        said.append(f"without the effect {rounded(removed, U_of_scatter(removed, n))}")
    if (told := getattr(RP, "completed", {}).get(name)) is not None:
        spec = f".{digits_of(told.value, (told.low, told.high))}f"
        ends = f"[{told.low:{spec}}, {told.high:{spec}}]"
        said.append(f"if repeated {told.value:{spec}} {ends}")
    return Text("; ".join(said))


def _next(diagnosis: Diagnosis, again: Again) -> NextStep:
    if diagnosis.verdict is Verdict.NOTHING:
        return NextStep(f"scara-iso report {again()}", "the report to sign")
    if diagnosis.verdict is Verdict.UNEXPLAINED or not is_explained(diagnosis.effects[0]):
        return NextStep(f"scara-iso diagnose {again(plot='course.svg')}", "look at the course")
    effect = diagnosis.effects[0].effect
    return NextStep(f"scara-iso explain {effect}", "what it means, and how to be sure")


def is_explained(found: Found) -> bool:
    """Return whether ``explain`` knows the effect: it does not know a user's own."""
    return found.effect in {effect.name for effect in find_effects()}


def _why(diagnosis: Diagnosis) -> Iterator[Block]:
    for found in diagnosis.effects:
        if is_of_a_kind(found):
            yield Text(f"Likely: {found.cause}")
            yield Text(f"To be sure: {found.confirm_by}")
        else:
            yield Text("To be sure: repeat the run; chance does not come back, a cause does")
    near = [rival for rival in diagnosis.candidates if rival.effect != UNKNOWN]
    yield from (Text(f"{one.axis} {one.words}") for one in diagnosis.courses if one.words)
    if diagnosis.verdict is Verdict.UNEXPLAINED and near:
        yield Text(f"Nearest known effects: {rivals_said(near)}")
    if diagnosis.verdict is Verdict.NOTHING:
        cycles = len(diagnosis.series.cycle)
        yield Text(f"An effect that is too small for {cycles} cycles would not show.")


def doubts(diagnosis: Diagnosis, *, effects: bool = True) -> Iterator[Text]:
    """Yield what speaks against the effects, and the readings to look at."""
    if effects and diagnosis.effects and diagnosis.p_value > _RARE:
        often = f"{100 * diagnosis.p_value:.0f} of 100 tests"
        yield Text(f"! scatter alone shows as much in {often}", "warn")
    for found in diagnosis.effects if effects else ():
        yield from (Text(f"! {line}", "warn") for line in found.unidentified)
    for flag in diagnosis.flags:
        yield Text(
            f"! {flag.axis}: the reading of cycle {flag.cycle} stands apart; look at the record",
            "warn",
        )


def _courses(diagnosis: Diagnosis) -> Iterator[Block]:
    """Yield the axes that an effect moves, before and after; the others in one line."""
    series = diagnosis.series
    moved = {axis for axis in series.measured if any(axis in f.axes for f in diagnosis.effects)}
    is_all = bool(moved) and diagnosis.verdict is Verdict.EXPLAINED
    still = [axis for axis in series.measured if is_all and axis not in moved]
    for axis, measured in series.measured.items():
        if axis in still:
            continue
        yield Strip(f"{axis} measured", series.cycle, measured, _spread(axis, measured))
        if axis in moved:
            left = (measured - series.predicted_after[axis]).round(12)
            yield Strip(f"{axis} left", series.cycle, left, _spread(axis, left))
    if still:
        yield Text(f"{', '.join(still)}: nothing besides scatter and the dial's division")


def _spread(axis: str, readings: FloatArray) -> str:
    return f"range {np.ptp(readings):.2g} {_length(axis)}".rstrip()


def _behind(diagnosis: Diagnosis) -> Iterator[Text]:
    before, after = diagnosis.error_before.held_out_rms, diagnosis.error_after.held_out_rms
    n = len(diagnosis.series.cycle)
    changed = [axis for axis in before if any(axis in one.axes for one in diagnosis.effects)]
    if changed:
        said = "; ".join(
            f"{axis} {_rms(after[axis], n)}, before {_rms(before[axis], n)}" for axis in changed
        )
        yield Text(f"Error on cycles that the model has not seen: {said}")
    yield from (Text(f"- {note}", "quiet") for note in diagnosis.notes[:_MOST_NOTES])
    more = len(diagnosis.notes) - _MOST_NOTES
    rest = f"{more} more notes, " if more > 0 else ""
    yield Text(f"lengths in mm, angles in degrees; {rest}errors, shares, rivals: `full=`", "quiet")


def _rms(figure: float, n: int) -> str:
    return str(rounded(figure, 2 * U_of_scatter(figure, n)))


_CHANCE = (
    "p: how often scatter alone would look this structured. Where nothing was found, an effect too "
    "small for these cycles may still be there."
)


def interpretation(diagnoses: Mapping[str | None, Diagnosis | Failure]) -> Iterator[Block]:
    """Yield what was found at which poses, and of each effect sizes, cause and test."""
    poses: dict[str, list[str]] = {}
    for pose, found in diagnoses.items():
        poses.setdefault(diagnosis_in_words(found) + _chance(found), []).append(pose or "")
    yield Facts(tuple((listed(at) or "all cycles", said) for said, at in poses.items()))
    yield Text(_CHANCE, "quiet")
    effects: dict[str, list[tuple[str | None, Found]]] = {}
    for pose, found in diagnoses.items():
        if isinstance(found, Diagnosis):
            for one in found.effects:
                effects.setdefault(one.effect, []).append((pose, one))
            if found.verdict is Verdict.UNEXPLAINED and found.candidates:
                yield Text(f"{_at(pose)}nearest: {rivals_said(found.candidates)}")
    for name, places in effects.items():
        yield from _effect(name, places)


def _chance(found: Diagnosis | Failure) -> str:
    return "" if isinstance(found, Failure) else f" ({p_equals(found)})"


def _effect(name: str, places: list[tuple[str | None, Found]]) -> Iterator[Text]:
    yield Text(words(name).capitalize(), "strong")
    for pose, found in places:
        others = f"; not excluded: {rivals_said(found.rivals)}" if found.rivals else ""
        axes = f" on {', '.join(found.axes)}" if found.axes else ""
        sure = f"probability {found.probability:.0%}{others}"
        yield Text(f"{_at(pose)}{parameters_said(found)}{axes}; {sure}")
    one = places[0][1]
    yield Text(f"Cause: {one.cause}.")
    yield Text(f"To confirm: {one.confirm_by}.")


def _at(pose: str | None) -> str:
    return f"{pose}: " if pose else ""
