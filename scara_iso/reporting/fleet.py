"""The report on a fleet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from scara_iso.diagnosis import UNKNOWN
from scara_iso.reporting.blocks import Block, Cell, Number, Report, Section, Table, Text
from scara_iso.reporting.digits import four_digits, words

if TYPE_CHECKING:
    from scara_iso.fleets import (
        Figure,
        FleetDrift,
        FleetFigures,
        FleetRun,
        FleetSummary,
        NameAlone,
        RobotFigures,
        RobotResult,
    )

_WORST, _FAILURES, _NAMED = 20, 10, 5


def fleet_report(found: FleetSummary, *, full: bool = False) -> Report:
    """Return which robots stand out, by which effects, and what could not be read.

    ``full`` lists every robot and every failure; else the worst of them.
    """
    sections = [Section("", tuple(_answer(found, full=full)))]
    shown = found.robots if full else found.robots[: max(_WORST, 0)]
    if not full:
        shown = tuple(one for one in shown if one.found) or shown[:5]
    if shown:
        left = len(found.robots) - len(shown)
        note = f"and {left} more: `full=`" if left and not full else ""
        sections.append(Section("Worst first", (_robots(shown, note),)))
    if found.effects:
        sections.append(Section("Effects of the robots found", (_effects(found),)))
    return (*sections, *_of_both(found, full=full))


def fleet_figures_report(found: FleetFigures, *, full: bool = False) -> Report:
    """Return which robots scatter most; ``full`` lists every failure, else the first of them."""
    sections = [Section("", tuple(_counts(found, full=full)))]
    shown = found.worst if full else found.worst[:_WORST]
    if shown:
        left = found.robots - len(shown)
        more = f"and {left} more: {found.files}" if left else ""
        names = [name for name in shown[0].RP if any(one.RP[name] for one in shown)]
        rows = tuple((one.robot, Number(one.tables), *_cells(one, names)) for one in shown)
        head = ("robot", "tables", *(f"RP {name}" for name in names))
        sections.append(Section("Largest RP of a pose first", (Table(head, rows, more),)))
    return (*sections, *_of_both(found, full=full))


def _cells(one: RobotFigures, names: Sequence[Figure]) -> Iterator[Cell]:
    for name in names:
        value = one.RP[name]
        yield "" if value is None else Number(value, ".4f")


def _counts(found: FleetFigures, *, full: bool) -> Iterator[Block]:
    said = f"RP of {found.tables} tables of {found.robots} robots"
    yield Text(said, "good" if found.robots else "warn")
    yield Text(f"{_parts(found.run)}; the figures of every pose are in {found.files}")
    yield from _troubles(found, full=full)


def _of_both(found: FleetSummary | FleetFigures, *, full: bool) -> Iterator[Section]:
    if found.RP_quantiles:
        yield Section("RP of the tables", (_RP(found),))
    if found.drift is not None:
        yield Section(f"RP {found.drift.figure} over time", tuple(_drift(found.drift, full=full)))
    failures = list(_failures(found))
    if failures:
        most = len(failures) if full else _FAILURES
        more = len(failures) - most
        note = [Text(f"and {more} more: `full=`", "quiet")] if more > 0 else []
        yield Section("Nothing of these", (*failures[:most], *note))


def _answer(found: FleetSummary, *, full: bool) -> Iterator[Block]:
    named = len(found.found)
    said = f"Found: {named} of {len(found.robots)} robots"
    yield Text(said, "warn" if named or not found.robots else "good")
    false = found.level * named
    if named:
        yield Text(
            f"of them {false:.1f} by chance at most, on average: false discovery rate "
            f"{found.level:g}",
            "quiet",
        )
    yield Text(f"{found.tables} tables in {_parts(found.run)}; results in {found.run.folder}")
    yield from _troubles(found, full=full)
    if found.undecided:
        names = _some(tuple(one.robot for one in found.undecided))
        yield Text(
            f"! {names}: nothing drawn came as far, and too "
            "little was drawn to name them among so many: look at them",
            "warn",
        )


def _parts(run: FleetRun) -> str:
    done = f"; {run.before} of them were done before" if run.before else ""
    return f"{run.parts} parts{done}"


def _troubles(found: FleetSummary | FleetFigures, *, full: bool) -> Iterator[Text]:
    count = len(found.failed) + len(found.run.failed)
    if count:
        yield Text(f"! {count} could not be used: they are listed below", "warn")
    for doubts in _doubts(found):
        shown = doubts if full else doubts[:_FAILURES]
        yield from (Text(f"! {said}", "warn") for said in shown)
        if len(shown) < len(doubts):
            yield Text(f"and {len(doubts) - len(shown)} more like that: `full=`", "warn")


def _doubts(found: FleetSummary | FleetFigures) -> Iterator[list[str]]:
    """Yield what the names leave open, kind by kind."""
    yield [
        f"{one.robot} {one.test} is there twice, in {', '.join(one.parts)}: both "
        "count; remove the one that is too much"
        for one in found.twice
    ]
    yield [_alone(one) for one in found.names_alone]
    yield [
        f"serial number {one.robot} stands with the names {_some(one.names)}: they are taken "
        "for one robot; if they are several, state the serial number of each"
        for one in found.several_names
    ]
    yield [
        f"{_some(names)} are alike but for case, blanks or zeros in front, and count as several "
        "robots; if they are one, write it in one way"
        for names in found.alike
    ]


def _some(names: tuple[str, ...]) -> str:
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f"{', '.join(names[:_NAMED])}{more}"


def _alone(one: NameAlone) -> str:
    numbers, where = ", ".join(one.serial_numbers), f"where the name stands alone ({one.tables})"
    if len(one.serial_numbers) == 1:
        return (
            f"{one.name} and serial number {numbers} are taken for one robot: if they are two, "
            f"state the serial number {where}"
        )
    return (
        f"{one.name} is the name of serial numbers {numbers}: {where} it counts as a robot of "
        "its own; state the serial number there"
    )


def _robots(robots: tuple[RobotResult, ...], note: str) -> Table:
    rows: list[tuple[Cell, ...]] = [
        (
            one.robot,
            Number(one.tables),
            four_digits(one.p_value),
            four_digits(one.q_value),
            "" if one.RP_XY is None else Number(one.RP_XY, ".4f"),
            ", ".join(map(words, one.effects)) or (words(UNKNOWN) if one.found else ""),
        )
        for one in robots
    ]
    return Table(("robot", "tables", "p", "q", "RP XY mm", "effects"), tuple(rows), note)


def _effects(found: FleetSummary) -> Table:
    rows = tuple((words(name), Number(count)) for name, count in found.effects.items())
    return Table(("effect", "robots"), rows)


def _RP(found: FleetSummary | FleetFigures) -> Table:  # noqa: N802 - the field's symbol
    rows: list[tuple[Cell, ...]] = [
        (name, *(Number(end, ".4f") for end in ends)) for name, ends in found.RP_quantiles.items()
    ]
    return Table(
        ("RP", "5 %", "25 %", "50 %", "75 %", "95 %"), tuple(rows), "mm; an angle in degrees"
    )


def _drift(found: FleetDrift, *, full: bool) -> Iterator[Block]:
    ends = found.interval
    apart = "" if ends is None else f" (95 %: {_percent(ends[0])} to {_percent(ends[1])})"
    yield Text(f"the median of {found.robots} robots: {_percent(found.per_month)} a month{apart}")
    rows: list[tuple[Cell, ...]] = [
        (
            one.period,
            Number(one.robots),
            *(Number(end, ".4f") for end in one.RP_quantiles[::2]),
            f"{one.worse} of {one.compared}" if one.compared else "",
        )
        for one in found.periods
    ]
    yield Table(("tested", "robots", "5 %", "50 %", "95 %", "worse than before"), tuple(rows))
    count = len(found.growing)
    yield Text(
        f"grows in {count} of the {found.asked} robots with three dates or more",
        "warn" if count else "quiet",
    )
    if count:
        shown = found.growing if full else found.growing[:_WORST]
        note = f"and {count - len(shown)} more: `full=`" if len(shown) < count else ""
        yield Table(
            ("robot", "dates", "a month", "p", "q"),
            tuple(
                (
                    one.robot,
                    Number(one.dates),
                    _percent(one.per_month),
                    four_digits(one.p_value),
                    four_digits(one.q_value),
                )
                for one in shown
            ),
            note,
        )


def _percent(share: float) -> str:
    return f"{100 * share:+.1f} %"


def _failures(found: FleetSummary | FleetFigures) -> Iterator[Text]:
    each = [*sorted(found.run.failed.items()), *((one.part, one.error) for one in found.failed)]
    yield from (Text(said if part in said else f"{part}: {said}") for part, said in each)
