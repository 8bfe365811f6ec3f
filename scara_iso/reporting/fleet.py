"""The document of a fleet: who stands out and who wears first, then every robot."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

from scara_iso.diagnosis import UNKNOWN
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Columns,
    Headline,
    Number,
    Report,
    Row,
    Section,
    Table,
    Text,
    four_digits,
    table_by_column,
    words,
)

if TYPE_CHECKING:
    from scara_iso.fleets import (
        Figure,
        FleetDrift,
        FleetFigures,
        FleetRun,
        FleetSummary,
        NameAlone,
        RobotFigures,
        RobotGrowth,
        RobotResult,
    )

_WORST, _FAILURES, _NAMED = 20, 10, 5
_AT_ONCE = 3
"""Robots that the first lines name."""


def fleet_report(found: FleetSummary) -> Report:
    """Return the document of a fleet: who stands out, who wears, every robot and failure."""
    named = found.found or found.robots[:5]
    effects = table_by_column(
        found.effects.items(),
        {"effect": lambda one: words(one[0]), "robots": lambda one: Number(one[1])},
    )
    return (
        Section("", tuple(_answer(found))),
        *_troubles(found),
        *_tables("Worst first", _ROBOTS, found.robots, named[:_WORST]),
        *([Section("Effects of the robots found", (effects,))] if found.effects else []),
        *_of_both(found),
    )


def fleet_figures_report(found: FleetFigures) -> Report:
    """Return the document of a fleet's figures: which robots scatter most, every failure."""
    shown = found.worst[0].RP if found.worst else ()
    names = [name for name in shown if any(one.RP[name] for one in found.worst)]
    columns: Columns[RobotFigures] = {
        "robot": lambda one: one.robot,
        "tables": lambda one: Number(one.tables),
        **{f"RP {name}": partial(_RP_of, name=name) for name in names},
    }
    text = Text(
        f"RP of {found.tables} tables of {found.robots} robots", "good" if found.robots else "warn"
    )
    where = Text(f"{_parts(found.run)}; the figures of every pose are in {found.files}")
    left = f"and {found.robots - len(found.worst)} more: {found.files}"
    return (
        Section("", (text, *_wearing(found), where)),
        *_troubles(found),
        *_tables(
            "Largest RP of a pose first",
            columns,
            found.worst,
            found.worst[:_WORST],
            left if found.robots > len(found.worst) else "",
        ),
        *_of_both(found),
    )


def _RP_of(one: RobotFigures, name: Figure) -> Cell:  # noqa: N802 - the field's symbol
    value = one.RP[name]
    return "" if value is None else Number(value, ".4f")


def _tables(
    heading: str, columns: Columns[Row], every: Sequence[Row], few: Sequence[Row], note: str = ""
) -> Iterator[Section]:
    """Yield the rows that a short screen has room for, and all of them for who wants these."""
    if not every:
        return
    left = len(every) - len(few)
    more = f"and {left} more: `full=`" if left else note
    yield Section(heading, (table_by_column(few, columns, more),), depth="brief")
    yield Section(heading, (table_by_column(every, columns, note),), depth="detail")


def _of_both(found: FleetSummary | FleetFigures) -> Iterator[Section]:
    if found.RP_quantiles:
        heads = ("RP", "5 %", "25 %", "50 %", "75 %", "95 %")
        rows: tuple[tuple[Cell, ...], ...] = tuple(
            (name, *(Number(end, ".4f") for end in ends))
            for name, ends in found.RP_quantiles.items()
        )
        yield Section("RP of the tables", (Table(heads, rows, "mm; an angle in degrees"),))
    if (drift := found.drift) is not None:
        yield Section(f"RP {drift.figure} over time", tuple(_drift(drift)))
        yield from _tables("Robots whose RP grows", _GROWTH, drift.growing, drift.growing[:_WORST])
    if failures := list(_failures(found)):
        more = len(failures) - _FAILURES
        note = [Text(f"and {more} more: `full=`", "quiet")] if more > 0 else []
        few = (*failures[:_FAILURES], *note)
        yield Section("Nothing of these", few, depth="brief")
        yield Section("Nothing of these", tuple(failures), depth="detail")


def _answer(found: FleetSummary) -> Iterator[Block]:
    named = len(found.found)
    of = f"{named} of {len(found.robots)} robots"
    yield Headline(
        (f"Found: {_first([f'{one.robot} ({_shown_by(one)})' for one in found.found])}", of)
        if named
        else (f"Found: {of}",),
        "warn" if named or not found.robots else "good",
    )
    yield from _wearing(found)
    if named:
        yield Text(
            f"of them {found.level * named:.1f} by chance at most, on average: false discovery "
            f"rate {found.level:g}",
            "quiet",
        )
    yield Text(f"{found.tables} tables in {_parts(found.run)}; results in {found.run.folder}")
    if found.undecided:
        names = _some(tuple(one.robot for one in found.undecided))
        yield Text(
            f"! {names}: nothing drawn came as far, and too "
            "little was drawn to name them among so many: look at them",
            "warn",
        )


def _wearing(found: FleetSummary | FleetFigures) -> Iterator[Headline]:
    growing = () if found.drift is None else found.drift.growing
    if growing:
        of_each = [
            f"{one.robot} {_percent(one.per_month)} a month (p = {four_digits(one.p_value)})"
            for one in growing
        ]
        yield Headline((f"Wears: {_first(of_each)}",), "warn")


def _first(of_each: Sequence[str]) -> str:
    more = len(of_each) - _AT_ONCE
    return ", ".join(of_each[:_AT_ONCE]) + (f" and {more} more" if more > 0 else "")


def _shown_by(one: RobotResult) -> str:
    """Return what is found in a robot, and by which of its tests where it has several."""
    effects = ", ".join(map(words, one.effects)) or (words(UNKNOWN) if one.found else "")
    return f"{effects}, test {one.test}" if one.found and one.tables > 1 else effects


_ROBOTS: Columns[RobotResult] = {
    "robot": lambda one: one.robot,
    "tables": lambda one: Number(one.tables),
    "p": lambda one: four_digits(one.p_value),
    "q": lambda one: four_digits(one.q_value),
    "RP XY mm": lambda one: "" if one.RP_XY is None else Number(one.RP_XY, ".4f"),
    "effects": _shown_by,
}
_GROWTH: Columns[RobotGrowth] = {
    "robot": lambda one: one.robot,
    "dates": lambda one: Number(one.dates),
    "a month": lambda one: _percent(one.per_month),
    "p": lambda one: four_digits(one.p_value),
    "q": lambda one: four_digits(one.q_value),
}


def _parts(run: FleetRun) -> str:
    done = f"; {run.before} of them were done before" if run.before else ""
    return f"{run.parts} parts{done}"


def _troubles(found: FleetSummary | FleetFigures) -> Iterator[Section]:
    count = len(found.failed) + len(found.run.failed)
    few = [Text(f"! {count} could not be used: they are listed below", "warn")] if count else []
    every = [*few]
    for doubts in _doubts(found):
        lines = [Text(f"! {doubt}", "warn") for doubt in doubts]
        more = len(lines) - _FAILURES
        rest = [Text(f"and {more} more like that: `full=`", "warn")] if more > 0 else []
        few += [*lines[:_FAILURES], *rest]
        every += lines
    if every:
        yield Section("", tuple(few), depth="brief")
        yield Section("", tuple(every), depth="detail")


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


def _drift(found: FleetDrift) -> Iterator[Block]:
    ends = found.interval
    apart = "" if ends is None else f" (95 %: {_percent(ends[0])} to {_percent(ends[1])})"
    yield Text(f"the median of {found.robots} robots: {_percent(found.per_month)} a month{apart}")
    yield table_by_column(
        found.periods,
        {
            "tested": lambda one: one.period,
            "robots": lambda one: Number(one.robots),
            "5 %": lambda one: Number(one.RP_quantiles[0], ".4f"),
            "50 %": lambda one: Number(one.RP_quantiles[2], ".4f"),
            "95 %": lambda one: Number(one.RP_quantiles[4], ".4f"),
            "worse than before": lambda one: (
                f"{one.worse} of {one.compared}" if one.compared else ""
            ),
        },
    )
    count = len(found.growing)
    yield Text(
        f"grows in {count} of the {found.asked} robots with three dates or more",
        "warn" if count else "quiet",
    )


def _percent(share: float) -> str:
    return f"{100 * share:+.1f} %"


def _failures(found: FleetSummary | FleetFigures) -> Iterator[Text]:
    each = [*sorted(found.run.failed.items()), *((one.part, one.error) for one in found.failed)]
    yield from (Text(text if part in text else f"{part}: {text}") for part, text in each)
