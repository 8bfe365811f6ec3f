"""The document of a fleet: who stands out and who wears first, then every robot."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

from scara_iso.diagnosis import UNKNOWN
from scara_iso.reporting.blocks import (
    Block,
    Columns,
    Headline,
    Report,
    Row,
    Section,
    Table,
    Text,
    tabulated,
)
from scara_iso.reporting.digits import Cell, Number, Tone, four_digits, words

if TYPE_CHECKING:
    from scara_iso.fleets import (
        Figure,
        FleetDrift,
        FleetFigures,
        FleetRun,
        FleetSummary,
        NameAlone,
        NamesAndNumbers,
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
    effects = Table(
        ("effect", "robots"),
        tuple((words(effect), Number(count)) for effect, count in found.effects.items()),
    )
    return (
        Section("", tuple(_answer(found))),
        *_in_brief_and_full("", list(_doubts(found)), "more like that"),
        *_tables("Worst first", _ROBOTS, found.robots, named[:_WORST]),
        Section("Effects of the robots found", (effects,)),
        *_of_both(found),
    )


def fleet_figures_report(found: FleetFigures) -> Report:
    """Return the document of a fleet's figures: which robots scatter most, every failure."""
    shown = found.worst[0].RP if found.worst else ()
    names = [name for name in shown if any(one.RP[name] for one in found.worst)]
    columns: Columns[RobotFigures] = {
        "robot": lambda one: one.robot,
        "tables": lambda one: one.tables,
        **{f"RP {name}": partial(_RP_of, name=name) for name in names},
    }
    tone: Tone = "good" if found.robots else "warn"
    text = Text(f"RP of {found.tables} tables of {found.robots} robots", tone)
    where = Text(f"{_parts(found.run)}; the figures of every pose are in {found.files}")
    more = found.robots - len(found.worst)
    left = f"and {more} more: {found.files}" if more > 0 else ""
    return (
        Section("", (text, *_wearing(found), where)),
        *_in_brief_and_full("", list(_doubts(found)), "more like that"),
        *_tables("Largest RP of a pose first", columns, found.worst, found.worst[:_WORST], left),
        *_of_both(found),
    )


def _RP_of(one: RobotFigures, name: Figure) -> Cell:  # noqa: N802 - the field's symbol
    return _four_places(one.RP[name])


def _four_places(value: float | None) -> Cell:
    return "" if value is None else Number(value, ".4f")


def _tables(
    heading: str, columns: Columns[Row], every: Sequence[Row], few: Sequence[Row], note: str = ""
) -> Iterator[Section]:
    """Yield the rows that a short screen has room for, and all of them for who wants these."""
    left = len(every) - len(few)
    more = f"and {left} more: `full=`" if left else note
    yield Section(heading, (tabulated(few, columns, more),), depth="brief")
    yield Section(heading, (tabulated(every, columns, note),), depth="detail")


def _in_brief_and_full(
    heading: str, kinds: Sequence[Sequence[str]], more_of_it: str
) -> Iterator[Section]:
    """Yield the first lines of each kind for a short screen, and all of them."""
    tone: Tone = "plain" if heading else "warn"
    few: list[Block] = []
    for lines in kinds:
        few += [Text(line, tone) for line in lines[:_FAILURES]]
        more = len(lines) - _FAILURES
        few += [Text(f"and {more} {more_of_it}: `full=`", "warn")] if more > 0 else []
    every = tuple(Text(line, tone) for lines in kinds for line in lines)
    yield Section(heading, tuple(few), depth="brief")
    yield Section(heading, every, depth="detail")


def _of_both(found: FleetSummary | FleetFigures) -> Iterator[Section]:
    """Yield the RP of all tables, how it grows over time, and what could not be used."""
    heads = ("RP", "5 %", "25 %", "50 %", "75 %", "95 %")
    rows = tuple((name, *map(_four_places, ends)) for name, ends in found.RP_quantiles.items())
    yield Section("RP of the tables", (Table(heads, rows, "mm; an angle in degrees"),))
    if (drift := found.drift) is not None:
        yield Section(f"RP {drift.figure} over time", tuple(_drift(drift)))
        yield from _tables("Robots whose RP grows", _GROWTH, drift.growing, drift.growing[:_WORST])
    each = [*sorted(found.run.failed.items()), *((one.part, one.error) for one in found.failed)]
    failures = [text if part in text else f"{part}: {text}" for part, text in each]
    yield from _in_brief_and_full("Not used", [failures], "more")


def _answer(found: FleetSummary) -> Iterator[Block]:
    named, robots = len(found.found), len(found.robots)
    of = f"{named} of {robots} robots"
    first = _first([f"{one.robot} ({_shown_by(one)})" for one in found.found])
    parts = (f"Found: {first}", of) if named else (f"Found: {of}",)
    yield Headline(parts, "warn" if named or not robots else "good")
    yield from _wearing(found)
    by_chance = (
        f"expected false alarms among them: at most {found.level * named:.1f} "
        f"(false discovery rate {found.level:g})"
    )
    yield Text(by_chance if named else "", "quiet")
    yield Text(f"{found.tables} tables in {_parts(found.run)}; results in {found.run.folder}")
    undecided = (
        f"! {_some([one.robot for one in found.undecided])}: no random draw came as far, but "
        "the draws are too few to name them among so many robots: look at them"
    )
    yield Text(undecided if found.undecided else "", "warn")


def _wearing(found: FleetSummary | FleetFigures) -> Iterator[Headline]:
    growing = () if found.drift is None else found.drift.growing
    if growing:
        of_each = [
            f"{one.robot} {_percent(one.per_month)} a month (p = {four_digits(one.p_value)})"
            for one in growing
        ]
        yield Headline((f"Wears: {_first(of_each)}",), "warn")


def _first(of_each: Sequence[str], most: int = _AT_ONCE) -> str:
    more = len(of_each) - most
    return ", ".join(of_each[:most]) + (f" and {more} more" if more > 0 else "")


def _some(names: Sequence[str]) -> str:
    return _first(names, _NAMED)


def _shown_by(one: RobotResult) -> str:
    """Return what is found in a robot, and by which of its tests where it has several."""
    effects = ", ".join(map(words, one.effects)) or (words(UNKNOWN) if one.found else "")
    return f"{effects}, test {one.test}" if one.found and one.tables > 1 else effects


_ROBOTS: Columns[RobotResult] = {
    "robot": lambda one: one.robot,
    "tables": lambda one: one.tables,
    "p": lambda one: four_digits(one.p_value),
    "q": lambda one: four_digits(one.q_value),
    "RP XY mm": lambda one: _four_places(one.RP_XY),
    "effects": _shown_by,
}
_GROWTH: Columns[RobotGrowth] = {
    "robot": lambda one: one.robot,
    "dates": lambda one: one.dates,
    "a month": lambda one: _percent(one.per_month),
    "p": lambda one: four_digits(one.p_value),
    "q": lambda one: four_digits(one.q_value),
}


def _parts(run: FleetRun) -> str:
    done = f"; {run.before} of them were done before" if run.before else ""
    return f"{run.parts} parts{done}"


def _doubts(found: FleetSummary | FleetFigures) -> Iterator[list[str]]:
    """Yield how much could not be used, and what the names leave open, kind by kind."""
    count = len(found.failed) + len(found.run.failed)
    yield [f"! {count} could not be used: they are listed below"] if count else []
    yield [
        f"! {one.robot} {one.test} is there twice, in {', '.join(one.parts)}: both "
        "count; remove one of them"
        for one in found.twice
    ]
    yield [f"! {_alone(one)}" for one in found.names_alone]
    yield [
        f"! serial number {one.robot} stands with the names {_some(one.names)}: they are taken "
        "for one robot; if they are several, state the serial number of each"
        for one in found.several_names
    ]
    yield [f"! {_apart(one)}" for one in (found.names_and_numbers,) if one is not None]
    yield [
        f"! {_some(names)} are alike but for case, blanks or zeros in front, and count as several "
        "robots; if they are one, write it in one way"
        for names in found.alike
    ]


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


def _apart(one: NamesAndNumbers) -> str:
    name, number = one.such_as
    return (
        f"some robots are stated by name alone ({one.names}, as {name}), others by serial number "
        f"alone ({one.serial_numbers}, as {number}), and count as several; if two of them are one "
        "robot, state both in one of its tables"
    )


def _drift(found: FleetDrift) -> Iterator[Block]:
    ends = found.interval
    apart = "" if ends is None else f" (95 %: {_percent(ends[0])} to {_percent(ends[1])})"
    yield Text(f"the median of {found.robots} robots: {_percent(found.per_month)} a month{apart}")
    rows = tuple(
        (
            one.period,
            Number(one.robots),
            *(_four_places(one.RP_quantiles[k]) for k in (0, 2, 4)),
            f"{one.worse} of {one.compared}" if one.compared else "",
        )
        for one in found.periods
    )
    yield Table(("tested", "robots", "5 %", "50 %", "95 %", "worse than before"), rows)
    count = len(found.growing)
    grows = f"grows in {count} of the {found.asked} robots with three dates or more"
    yield Text(grows, "warn" if count else "quiet")


def _percent(share: float) -> str:
    return f"{100 * share:+.1f} %"
