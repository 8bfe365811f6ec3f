"""The document of a diagnosis: what it is, how sure, what next, then every figure behind it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from scara_iso.diagnosis import (
    SECOND,
    UNKNOWN,
    ByAxis,
    Diagnosis,
    Foretold,
    Found,
    Repeatabilities,
    Reversal,
    RunReversals,
    UnseenRP,
    Verdict,
)
from scara_iso.reporting.backlash import gear_blocks, gear_errors
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Headline,
    NextStep,
    Notice,
    Number,
    Report,
    Section,
    Strip,
    Table,
    Text,
    U_of_scatter,
    answer_lines,
    at_depth,
    digits_of,
    p_equals,
    p_value,
    rounded,
    words,
)
from scara_iso.reporting.named_effects import (
    Failure,
    cause_and_test,
    is_of_a_kind,
    length,
    odd_in_words,
    page_of,
    parameters_in_words,
    rivals_in_words,
    sizes_in_words,
    sureness,
    unexplained_in_words,
)
from scara_iso.run import FloatArray

_UNSEEN = "cycles that the fit did not see, the choice of effect repeated"
_UNITS = "lengths in mm, angles in degrees"
_MOST_NOTES = 3
_GAP = "   "
_RARE = 0.01
Again = Callable[..., str]
"""Names the table in a command line, with the options that read it and further ones."""


def diagnosis_report(diagnosis: Diagnosis, again: Again | None = None) -> Report:
    """Return the document of one pose's diagnosis; ``again`` names its table in a command line."""
    following = None if again is None else _next(diagnosis, again)
    sizes = (Text(_sizes(found, diagnosis)) for found in diagnosis.effects)
    lines = [*_answer(diagnosis), *sizes, *_RP_in_words(diagnosis), *_why(diagnosis)]
    error = [Text(text) for text in (_error_in_words(diagnosis),) if text]
    notes = notes_in_short(diagnosis.notes, "errors, shares, rivals", _MOST_NOTES)
    return (
        Section("", answer_lines([*lines, *doubts(diagnosis)], following)),
        Section("", tuple(_courses(diagnosis))),
        Section("", (*error, *notes), depth="more"),
        *at_depth("detail", _details(diagnosis)),
    )


def notes_in_short(notes: Sequence[str], what: str, most: int) -> Iterator[Text]:
    """Yield the first notes, and what else the long form has."""
    yield from (Text(f"- {note}", "quiet") for note in notes[:most])
    more = f"{len(notes) - most} more notes, " if len(notes) > most else ""
    yield Text(f"{_UNITS}; {more}{what}: `full=`", "quiet")


def _details(diagnosis: Diagnosis) -> Iterator[Section]:
    yield Section("structure", (*_structure(diagnosis), Text(_UNITS, "quiet")))
    for found in diagnosis.effects:
        yield Section(words(found.effect), tuple(_effect(found)))
    if diagnosis.reversals is not None:
        yield reversals_section(diagnosis.reversals)
    yield Section("error and repeatability", tuple(_figures(diagnosis)))
    yield Section("what RP is made of", (_shares(diagnosis),))
    if notices := tuple(_notices(diagnosis)):
        yield Section("notes", notices)


def of_pose(name: str, one: Diagnosis) -> Iterator[Section]:
    """Yield what was found at one of several poses, nothing where that is nothing."""
    for found in one.effects:
        yield Section(f"{name}: {words(found.effect)}", tuple(_effect(found)))
    if one.effects:
        yield Section(f"{name}: error and repeatability", tuple(_figures(one)))
    if text := tuple(map(Text, courses_in_words(one))):
        yield Section(f"{name}: unexplained", text)
    if notices := tuple(_notices(one)):
        yield Section(f"{name}: notes", notices)


def _answer(diagnosis: Diagnosis) -> Iterator[Headline]:
    if diagnosis.verdict is Verdict.NOTHING:
        odd = odd_in_words(diagnosis)
        text = "Nothing besides scatter and the dial's division"
        yield Headline((f"{text}; {odd}" if odd else text,), "warn" if odd else "good")
    if diagnosis.effects:
        yield Headline((f"Found: {'; '.join(map(sureness, diagnosis.effects))}",))
    if diagnosis.verdict is Verdict.UNEXPLAINED:
        yield Headline((unexplained_in_words(diagnosis),), "warn")


def _sizes(found: Found, diagnosis: Diagnosis) -> str:
    of = f"{words(found.effect)}: " if len(diagnosis.effects) > 1 else ""
    return f"{of}{_GAP.join(sizes_in_words(found) or ['size not estimated'])}"


def _RP_in_words(diagnosis: Diagnosis) -> Iterator[Text]:  # noqa: N802 - the field's symbol
    """Return RP as measured, were the effects cured, and in a new test by the completed model."""
    RP = diagnosis.repeatability
    named = [name for name in RP.measured if name != "XYZ"]
    name = "XY" if "XY" in named else named[0]
    n = len(diagnosis.series.cycle)
    parts = [f"RP  {name} {of_scatter(RP.measured[name], n)} {length(name)}".rstrip()]
    removed = RP.with_effect_removed.get(name)
    if diagnosis.effects and removed is not None:
        parts.append(f"without the effect {of_scatter(removed, n)}")
    yield Text("; ".join(parts))
    if (expected := RP.completed.get(name)) is not None:
        spec = f".{digits_of(expected.value, expected.interval)}f"
        ends = "[{:{spec}}, {:{spec}}]".format(*expected.interval, spec=spec)
        value = f"{expected.value:{spec}} {length(name)}".rstrip()
        expected_in = "Expected in a repeat test with the same scatter"
        yield Text(f"{expected_in}: {name} {value}, 95 % prediction interval {ends}")


def _next(diagnosis: Diagnosis, again: Again) -> NextStep:
    if diagnosis.verdict is Verdict.NOTHING:
        return NextStep(f"scara-iso report {again()}", "the report to sign")
    page = None if diagnosis.verdict is Verdict.UNEXPLAINED else page_of(diagnosis.effects[0])
    course = f"scara-iso diagnose {again(plot='course.svg')}"
    return page or NextStep(course, "look at the course")


def _why(diagnosis: Diagnosis) -> Iterator[Block]:
    for found in diagnosis.effects:
        yield from cause_and_test(found)
    near = [rival for rival in diagnosis.candidates if rival.effect != UNKNOWN]
    yield from map(Text, courses_in_words(diagnosis))
    if diagnosis.verdict is Verdict.UNEXPLAINED and near:
        yield Text(f"Nearest known effects: {rivals_in_words(near)}")
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
    learned = {} if diagnosis.learned is None else diagnosis.learned.axes
    named = {axis for found in diagnosis.effects for axis in found.axes}
    moved = {axis for axis in series.measured if axis in named or axis in learned}
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
    return f"range {np.ptp(readings):.2g} {length(axis)}".rstrip()


def _error_in_words(diagnosis: Diagnosis) -> str:
    before, after = diagnosis.error.before.held_out_rms, diagnosis.error.after.held_out_rms
    n = len(diagnosis.series.cycle)
    learned = {} if diagnosis.learned is None else diagnosis.learned.axes
    named = {axis for one in diagnosis.effects for axis in one.axes}
    changed = [axis for axis in before if axis in named or axis in learned]
    parts = (f"{axis} {_rms(after[axis], n)}, before {_rms(before[axis], n)}" for axis in changed)
    return f"Error on cycles that the model has not seen: {'; '.join(parts)}" if changed else ""


def _rms(figure: float, n: int) -> str:
    return str(rounded(figure, 2 * U_of_scatter(figure, n)))


def summary_report(tables: Sequence[str], found: Sequence[Diagnosis | Failure]) -> Report:
    """Return one row for each of several tables, and how many there are of each verdict."""
    rows = tuple(_summary(table, one) for table, one in zip(tables, found, strict=True))
    verdicts = [row[1] for row in rows]
    counts = ", ".join(f"{verdicts.count(v)} {v}" for v in dict.fromkeys(verdicts))
    table = Table(("", "verdict", "effects", "p"), rows)
    failures = [
        Notice("error", "not-diagnosed", name, one.message)
        for name, one in zip(tables, found, strict=True)
        if isinstance(one, Failure)
    ]
    return (Section("", (Text(f"{len(tables)} diagnosed: {counts}", "strong"), table, *failures)),)


def _summary(table: str, one: Diagnosis | Failure) -> tuple[str, str, str, Number | str]:
    if isinstance(one, Failure):
        return (table, "not diagnosed", "", "")
    effects = "; ".join(sureness(found) for found in one.effects)
    return (
        table,
        one.verdict.value,
        effects,
        p_value(one),
    )


def _structure(diagnosis: Diagnosis) -> Iterator[Text]:
    """Yield how often scatter alone shows as much, and what the unexplained looks like."""
    yield Text(f"p-value of any structure at all: {p_equals(diagnosis)}")
    if diagnosis.verdict is Verdict.UNEXPLAINED and diagnosis.candidates:
        yield Text(f"nearest: {rivals_in_words(diagnosis.candidates)}")
    yield from map(Text, courses_in_words(diagnosis))


def _effect(found: Found) -> Iterator[Block]:
    yield Text(
        f"{p_equals(found)}, probability {found.probability:.0%}"
        + (f"; not excluded: {rivals_in_words(found.rivals)}" if found.rivals else "")
    )
    yield Text(parameters_in_words(found))
    if found.joint is not None and found.joint in found.angles:
        angle = found.angles[found.joint]
        yield Text(f"moves along {found.joint.removeprefix('along ')}, within {angle:.0f} degrees")
    elif found.angles:
        angles = ", ".join(f"{name} {angle:.0f}" for name, angle in found.angles.items())
        yield Text(f"names no joint: degrees from {angles}", "quiet")
    if not is_of_a_kind(found):
        yield Text(f"cause: {found.cause}")
        yield Text(f"confirm: {found.confirm_by}")
    for line in found.unidentified:
        yield Text(f"not identifiable: {line}", "warn")


def _figures(diagnosis: Diagnosis) -> Iterator[Block]:
    before, after = diagnosis.error.before, diagnosis.error.after
    n, unseen = len(diagnosis.series.cycle), diagnosis.repeatability.unseen
    second = unseen is not None and unseen.of == SECOND
    text = "the second table" if second else _UNSEEN
    yield Table(
        ("rms error", "before", "after", "held out, before", "held out, after"),
        tuple(
            (
                axis,
                *(of_scatter(rms, n) for rms in (before.rms[axis], after.rms[axis])),
                *(of_scatter(error.held_out_rms[axis], n) for error in (before, after)),
            )
            for axis in before.rms
        ),
        f"held out: on {text}",
    )
    RP = diagnosis.repeatability
    yield _repeatability(RP, n)
    grown = [n for n, value in RP.with_effect_removed.items() if value > RP.measured[n] * 1.001]
    if diagnosis.effects and grown:
        yield Text(
            f"{', '.join(grown)}: RP grows though the readings scatter less, because distances to "
            "a mean between two levels are nearly equal and hide in S_l",
            "quiet",
        )
    yield next_test(RP, n)
    if RP.unseen is not None:
        yield unseen_cycles(RP.unseen)


def _repeatability(RP: Repeatabilities, n: int) -> Table:
    columns = {
        "measured": RP.measured,
        **before_model(RP),
        "model after": RP.model_after,
        "effect removed": RP.with_effect_removed,
    }
    return Table(
        ("RP", *columns),
        tuple(
            (
                name,
                *(of_scatter(of[name], n) if name in of else "" for of in columns.values()),
            )
            for name in RP.measured
        ),
        "effect removed: what the robot would reach if the cause were cured; the ISO figure itself "
        "is the measured one",
    )


def _shares(diagnosis: Diagnosis) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (axis, *(Number(v, ".0%") for v in (part.effects, part.resolution, part.unexplained)))
        for axis, part in diagnosis.shares.items()
    )
    left = "unexplained" if diagnosis.verdict is Verdict.UNEXPLAINED else "scatter"
    return Table(("variance", "effects", "resolution", left), rows)


def _notices(diagnosis: Diagnosis) -> Iterator[Block]:
    for flag in diagnosis.flags:
        yield Notice(
            "warning",
            "check-the-sheet",
            flag.axis,
            f"the reading of cycle {flag.cycle} stands apart ({p_equals(flag)} in Gaussian "
            "scatter): look at the raw record",
        )
    for note in diagnosis.notes:
        yield Text(note)


def courses_in_words(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield what the unexplained looks like in each axis, in words."""
    yield from (f"{one.axis} {one.words}" for one in diagnosis.courses if one.words)


def next_test(RP: Repeatabilities, n: int) -> Table:
    """Return what the completed model predicts of the next test and what was measured."""
    return Table(
        ("RP of the next test", "measured", "completed model", "95 % from", "to"),
        tuple(_row(name, predicted, (RP.measured,), n) for name, predicted in RP.completed.items()),
        "completed model: effects, scatter and the dial's rounding; the interval holds the RP of a "
        "new test of 30 cycles, its own sampling included",
    )


def unseen_cycles(RP: UnseenRP) -> Table:
    """Return RP of cycles that no fit saw beside what the model said of it before and after."""
    columns = {"measured": RP.measured, **before_model(RP)}
    before = tuple(columns.values())
    return Table(
        ("RP of unseen cycles", *columns, "completed model", "95 % from", "to"),
        tuple(_row(name, predicted, before, RP.cycles) for name, predicted in RP.completed.items()),
        f"of {RP.of}: {RP.cycles} cycles that the completed model has not seen",
    )


def before_model(RP: Repeatabilities | UnseenRP) -> Mapping[str, ByAxis]:
    """Return the column of the model before; without a model, which predicts no scatter, none."""
    return {"model before": RP.model_before} if any(RP.model_before.values()) else {}


def _row(name: str, predicted: Foretold, before: tuple[ByAxis, ...], n: int) -> tuple[Cell, ...]:
    figures = (
        *(column[name] for column in before),
        predicted.value,
        *predicted.interval,
    )
    return (name, *(of_scatter(figure, n) for figure in figures))


def of_scatter(figure: float, n: int) -> Number:
    """Return a figure of n scattering readings to the digits that it has."""
    return rounded(figure, U_of_scatter(figure, n))


def reversals_section(found: RunReversals) -> Section:
    """Return the half width of the reversal per payload, and what the model's gears leave of it."""
    blocks: list[Block] = []
    if found.missing:
        blocks.append(
            Text(f"not compared with the gears: the model lacks {', '.join(found.missing)}", "warn")
        )
    if found.gear is not None:
        blocks += [*gear_blocks(found.gear)]
    if found.reversals:
        blocks.append(_table_of_reversals(found.reversals))
    if found.gear is not None:
        blocks.append(gear_errors(found.gear, "mm", "each payload"))
    return Section("reversals and gears", (*blocks, *(Text(note) for note in found.notes)))


def _table_of_reversals(reversals: tuple[Reversal, ...]) -> Table:
    return Table(
        ("", "payload [kg]", "half width [mm]", "u [mm]", "model before [mm]", "model after [mm]"),
        tuple(
            (
                one.axis,
                Number(one.payload_kg, "g"),
                *(
                    "" if value is None else rounded(value, one.uncertainty_mm)
                    for value in (
                        one.half_width_mm,
                        one.uncertainty_mm,
                        one.predicted_before_mm,
                        one.predicted_after_mm,
                    )
                ),
            )
            for one in reversals
        ),
        "half width: (mean of approach +1 minus mean of approach -1) / 2",
    )
