"""The report on a diagnosis: what was found, how sure, what else, what to do, what it brings.

What structure of no name looks like, said.

RP as the completed model foretells it: of the next test, and of cycles that no fit saw.

The report on the reversals in a run's readings.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scara_iso.diagnosis import (
    SECOND,
    ByAxis,
    Diagnosis,
    DiagnosisOfPoses,
    Foretold,
    Found,
    Repeatabilities,
    Rival,
    UnseenRP,
    Verdict,
)
from scara_iso.reporting.backlash import gear_blocks, gear_errors
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Notice,
    Number,
    Report,
    Section,
    Strip,
    Table,
    Text,
)
from scara_iso.reporting.digits import U_of_scatter, p_equals, p_value, rounded, words

if TYPE_CHECKING:
    from scara_iso.diagnosis import Reversal, RunReversals


_HELD_OUT = ("without", "with_formula")


def courses_said(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield what the unexplained looks like in each axis, in words and as a formula."""
    n = len(diagnosis.series.cycle)
    for one in diagnosis.courses:
        if one.words:
            yield f"{one.axis} {one.words}"
        if one.formula is not None:
            before, after = (
                rounded(figure, U_of_scatter(figure, n))
                for figure in (one.held_out_rms[key] for key in _HELD_OUT)
            )
            yield (
                f"{one.axis} goes about like {one.formula} (k is the cycle): error on cycles that "
                f"it has not seen {before} without it, {after} with it"
            )


def next_test(RP: Repeatabilities, n: int) -> Table:
    """Return what the completed model foretells of the next test beside what was measured."""
    return Table(
        ("RP of the next test", "measured", "completed model", "95 % from", "to"),
        tuple(_row(name, told, (RP.measured,), n) for name, told in RP.completed.items()),
        "completed model: effects, scatter and the dial's rounding; the interval holds the RP of a "
        "new test of 30 cycles, its own sampling included",
    )


def unseen_cycles(RP: UnseenRP) -> Table:
    """Return RP of cycles that no fit saw beside what the model said of it before and after."""
    columns = {"measured": RP.measured, **before_model(RP)}
    beside = tuple(columns.values())
    return Table(
        ("RP of unseen cycles", *columns, "completed model", "95 % from", "to"),
        tuple(_row(name, told, beside, RP.cycles) for name, told in RP.completed.items()),
        f"of {RP.of}: {RP.cycles} cycles that the completed model has not seen",
    )


def before_model(RP: Repeatabilities | UnseenRP) -> Mapping[str, ByAxis]:
    """Return the column of the model before; without a model, which foretells no scatter, none."""
    return {"model before": RP.model_before} if any(RP.model_before.values()) else {}


def _row(name: str, told: Foretold, beside: tuple[ByAxis, ...], n: int) -> tuple[Cell, ...]:
    figures = (*(column[name] for column in beside), told.value, told.low, told.high)
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


_SURE, _LIKELY = 0.9, 0.6
_MOST_KINDS = 3
_UNSEEN = "cycles that the fit did not see, the choice of effect repeated"
_SECONDS = "_s"
"""Ends the name of a time that is given in seconds beside that in cycles."""
_DUST = 1e-9
"""Share of a size below which its standard error is the rounding of the arithmetic."""
_UNITS = "lengths in mm, angles in degrees"


def diagnosis_report(diagnosis: Diagnosis, title: str) -> Report:
    """Return the report on one pose's diagnosis; ``title`` names the table."""
    head = (Text(f"diagnosis of {title}", "strong"), Text(_UNITS, "quiet"))
    sections = [Section("", (*head, *_verdict(diagnosis)))]
    sections += [Section(words(f.effect), tuple(_effect(f))) for f in diagnosis.effects]
    if diagnosis.reversals is not None:
        sections.append(reversals_section(diagnosis.reversals))
    sections.append(Section("error and repeatability", tuple(_figures(diagnosis))))
    sections.append(Section("what RP is made of", (_shares(diagnosis),)))
    sections.append(Section("measured minus predicted", tuple(_strips(diagnosis))))
    notices = tuple(_notices(diagnosis))
    return (*sections, *((Section("notes", notices),) if notices else ()))


def of_pose(name: str, one: Diagnosis) -> Iterator[Section]:
    """Yield what was found at one of several poses, nothing where that is nothing."""
    for found in one.effects:
        yield Section(f"{name}: {words(found.effect)}", tuple(_effect(found)))
    if one.effects:
        yield Section(f"{name}: error and repeatability", tuple(_figures(one)))
    if said := tuple(map(Text, courses_said(one))):
        yield Section(f"{name}: unexplained", said)
    if notices := tuple(_notices(one)):
        yield Section(f"{name}: notes", notices)


@dataclass(frozen=True, slots=True)
class Failure:
    """A table that could not be diagnosed."""

    message: str
    """What is wrong with it."""
    exit_code: int
    """The one with which the command ends."""


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
    return "nothing besides scatter and the dial's division was found"


def unexplained_said(found: Diagnosis | DiagnosisOfPoses) -> str:
    """Return that there is more than scatter, and more than the effects found."""
    what = "what is left is more than scatter" if found.effects else "more than scatter"
    return f"Unexplained: {what}, and no known effect fits it"


def _verdict(diagnosis: Diagnosis) -> Iterator[Text]:
    match diagnosis.verdict:
        case Verdict.NOTHING:
            yield Text(
                f"nothing to explain: no structure beyond chance ({p_equals(diagnosis)})",
                "good",
            )
            yield Text("an effect that is too small for these cycles would not show")
        case Verdict.EXPLAINED:
            said = "; ".join(sureness(found) for found in diagnosis.effects)
            yield Text(f"explained: {said}", "strong")
        case Verdict.UNEXPLAINED:
            if diagnosis.effects:
                yield Text(f"found: {'; '.join(map(sureness, diagnosis.effects))}", "strong")
                there = "what is left is more than scatter"
            else:
                there = f"structure is there ({p_equals(diagnosis)})"
            yield Text(f"unexplained: {there}, and no known effect accounts for it", "warn")
            if diagnosis.candidates:
                yield Text(f"nearest: {rivals_said(diagnosis.candidates)}")
            yield from map(Text, courses_said(diagnosis))


def sureness(found: Found, *, on_axes: bool = True) -> str:
    """Return how sure the name is: 0.9 names it, 0.6 says "or", below the whole set is said."""
    where = f" on {', '.join(found.axes)}" if found.axes and on_axes else ""
    if on_axes and found.joint is not None and found.place is not None:
        where += f", {found.place}"
    if found.probability >= _SURE or not found.rivals:
        return f"{words(found.effect)}{where} ({found.probability:.0%})"
    others = found.rivals[:1] if found.probability >= _LIKELY else found.rivals
    names = [words(found.effect), *(words(rival.effect) for rival in others)]
    if is_of_a_kind(found):
        return f"{' or '.join(names)}{where}"
    likeliest = f"{', '.join(names[:_MOST_KINDS])} or {len(names) - _MOST_KINDS} others"
    return f"more than scatter{where}, its kind not clear: {likeliest}"


def is_of_a_kind(found: Found) -> bool:
    """Return whether so few effects are left that a cause can be looked for."""
    return found.probability >= _LIKELY or len(found.rivals) <= _MOST_KINDS


def rivals_said(rivals: Sequence[Rival]) -> str:
    """Return effects with their probabilities."""
    return ", ".join(f"{words(rival.effect)} ({rival.probability:.0%})" for rival in rivals)


def _effect(found: Found) -> Iterator[Block]:
    yield Text(
        f"{p_equals(found)}, probability {found.probability:.0%}"
        + (f"; not excluded: {rivals_said(found.rivals)}" if found.rivals else "")
    )
    yield Text(parameters_said(found))
    if found.joint is not None and found.joint in found.angles:
        angle = found.angles[found.joint]
        yield Text(f"moves along {found.joint.removeprefix('along ')}, within {angle:.0f} degrees")
    elif found.angles:
        angles = ", ".join(f"{name} {angle:.0f}" for name, angle in found.angles.items())
        yield Text(f"names no joint: degrees from {angles}", "quiet")
    yield Text(f"cause: {found.cause}")
    yield Text(f"confirm: {found.confirm_by}")
    for line in found.unidentified:
        yield Text(f"not identifiable: {line}", "warn")


def parameters_said(found: Found, only: Iterable[str] | None = None) -> str:
    """Return the parameters of an effect with their units, and with standard errors."""
    names = found.parameters if only is None else only
    return ", ".join(
        _parameter(name, found.parameters[name], found)
        for name in names
        if name.removesuffix(_SECONDS) not in found.parameters or not name.endswith(_SECONDS)
    )


def _parameter(name: str, value: float | str | Mapping[str, float], found: Found) -> str:
    if not isinstance(value, Mapping):
        said = value if isinstance(value, str) else f"{value:.3g}"
        seconds = found.parameters.get(f"{name}{_SECONDS}")
        beside = f" ({seconds:.3g} s)" if isinstance(seconds, float) else ""
        return f"{words(name)} {said} {unit_of(found, name)}".rstrip() + beside
    errors = found.standard_errors.get(name, {})
    parts = [_size(axis, size, errors.get(axis)) for axis, size in value.items()]
    return f"{words(name)} {', '.join(parts)} {unit_of(found, name)}".rstrip()


def _size(axis: str, size: float, error: float | None) -> str:
    """Return a size to the last of the two digits that its standard error has (GUM, 7.2.6)."""
    if not error or error < _DUST * abs(size):
        return f"{axis} {size:+.3g}"
    return f"{axis} {rounded(size, error, sign='+')} ± {rounded(error, error)}"


def unit_of(found: Found, parameter: str) -> str:
    """Return the unit of a parameter, as far as it is not that of the reading."""
    unit = found.units.get(parameter, "")
    return unit.replace("reading/", "per ").removeprefix("reading")


def _figures(diagnosis: Diagnosis) -> Iterator[Block]:
    before, after = diagnosis.error_before, diagnosis.error_after
    n, unseen = len(diagnosis.series.cycle), diagnosis.repeatability.unseen
    second = unseen is not None and unseen.of == SECOND
    said = "the second table" if second else _UNSEEN
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
        f"held out: on {said}",
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


def _strips(diagnosis: Diagnosis) -> Iterator[Block]:
    series = diagnosis.series
    for axis, measured in series.measured.items():
        for name, predicted in (
            ("before", series.predicted_before[axis]),
            ("after", series.predicted_after[axis]),
        ):
            left = (measured - predicted).round(12) + 0.0
            caption = f"{left.min():+.2g} .. {left.max():+.2g}"
            yield Strip(f"{axis} {name}", series.cycle, left, caption)


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
