"""The document of a fleet: who stands out and who wears first, then every robot."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from statistics import median
from typing import TYPE_CHECKING, Any

from scara_iso.diagnosis import UNKNOWN
from scara_iso.reporting.shared.blocks import Block, Columns, Report, Row, Section, Table, Text
from scara_iso.reporting.shared.digits import Cell, Tone, few, four_digits, many, share, words

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
_FAR_ABOVE = 1.5


def fleet_report(found: FleetSummary) -> Report:
    """Return the document of a fleet: who stands out, who wears, every robot and failure."""
    named = found.found or found.robots[:_NAMED]
    effects: Columns[tuple[str, int]] = {
        "effect": lambda row: words(row[0]),
        "robots": lambda row: row[1],
    }
    return (
        Section("", tuple(_answer(found))),
        *_lines("", list(_doubts(found)), "warn"),
        *_tables("Worst first", _ROBOTS, found.robots, named[:_WORST]),
        Section("Effects of the robots found", (Table.of(found.effects.items(), effects),)),
        *_of_both(found),
    )


def fleet_figures_report(found: FleetFigures) -> Report:
    """Return the document of a fleet's figures: which robots scatter most, every failure."""
    shown = found.worst[0].RP if found.worst else ()
    names = [name for name in shown if any(one.RP[name] for one in found.worst)]
    columns: Columns[RobotFigures] = {
        "robot": lambda one: one.robot,
        "tables": lambda one: one.tables,
        **{f"RP {_labelled(name)}": partial(_RP_of, name=name) for name in names},
    }
    tone: Tone = "good" if found.robots else "warn"
    text = Text(f"RP of {many(found.tables, 'table')} of {many(found.robots, 'robot')}", tone)
    where = Text(f"{_parts(found.run)}; the figures of every pose are in {found.files}")
    more = found.robots - len(found.worst)
    left = f"and {more} more: {found.files}" if more > 0 else ""
    return (
        Section("", (text, *_wearing(found), where)),
        *_lines("", list(_doubts(found)), "warn"),
        *_tables("Largest RP of a pose first", columns, found.worst, found.worst[:_WORST], left),
        *_of_both(found),
    )


def _labelled(name: str) -> str:
    """Return of what an RP is; that of an angle by ISO 9283 7.2.2 is another, +/- 3 S."""
    return f"{name} (eq. 2-6)" if name == "theta" else name


def _RP_of(one: RobotFigures, name: Figure) -> Cell:  # noqa: N802 - the field's symbol
    return share(one.RP[name], ".4f")


def _tables(
    heading: str, columns: Columns[Row], every: Sequence[Row], first: Sequence[Row], note: str = ""
) -> Iterator[Section]:
    left = len(every) - len(first)
    more = f"and {left} more: `full=`" if left else note
    yield Section(heading, (Table.of(first, columns, more),), depth="brief")
    yield Section(heading, (Table.of(every, columns, note),), depth="detail")


def _lines(heading: str, kinds: Sequence[Sequence[str]], tone: Tone) -> Iterator[Section]:
    shown: list[Block] = []
    for lines in kinds:
        shown += [Text(line, tone) for line in lines[:_FAILURES]]
        more = len(lines) - _FAILURES
        shown.append(Text(f"and {more} more like that: `full=`" if more > 0 else "", "warn"))
    yield Section(heading, tuple(shown), depth="brief")
    every = tuple(Text(line, tone) for lines in kinds for line in lines)
    yield Section(heading, every, depth="detail")


def _of_both(found: FleetSummary | FleetFigures) -> Iterator[Section]:
    levels = ("5 %", "25 %", "50 %", "75 %", "95 %")
    rows: list[dict[str, Cell]] = [
        {"RP": _labelled(name), **{of: share(v, ".4f") for of, v in zip(levels, ends, strict=True)}}
        for name, ends in found.RP_quantiles.items()
    ]
    table = Table.by_name(rows, "mm; an angle in degrees")
    yield Section("RP of the tables", (table,))
    if (drift := found.drift) is not None:
        yield Section(f"RP {_labelled(drift.figure)} over time", tuple(_drift(drift)))
        yield from _tables("Robots whose RP grows", _GROWTH, drift.growing, drift.growing[:_WORST])
    each = [*sorted(found.run.failed.items()), *((one.part, one.error) for one in found.failed)]
    failures = [text if part in text else f"{part}: {text}" for part, text in each]
    yield from _lines("Not used", [failures], "plain")


def _answer(found: FleetSummary) -> Iterator[Block]:
    named, robots = len(found.found), len(found.robots)
    of = f"{named} of {many(robots, 'robot')}"
    first = few([f"{one.robot} ({_shown_by(one)})" for one in found.found], _AT_ONCE)
    tone: Tone = "warn" if named or not robots else "good"
    yield Text(f"Found: {first}", tone, (of,)) if named else Text(f"Found: {of}", tone)
    yield from _wearing(found)
    yield from _largest(found)
    by_chance = (
        f"expected false alarms among them: at most {found.level * named:.1f} "
        f"(false discovery rate {found.level:g})"
    )
    yield Text(by_chance if named else "", "quiet")
    yield Text("each by its likeliest effect; diagnose says how sure it is" * bool(named), "quiet")
    yield Text(
        f"{many(found.tables, 'table')} in {_parts(found.run)}; results in {found.run.folder}"
    )
    undecided = few([one.robot for one in found.undecided], _NAMED)
    draws = (
        "no random draw came as far, but the draws are too few to name them among so many robots"
    )
    yield Text(f"! {undecided}: {draws}: look at them" if undecided else "", "warn")


def _largest(found: FleetSummary) -> Iterator[Text]:
    known = {one.robot: one.RP_XY for one in found.robots if one.RP_XY}
    if len(known) < _NAMED:
        return
    middle, largest = median(known.values()), max(known, key=lambda robot: known[robot])
    named = {one.robot for one in found.found}
    if known[largest] > _FAR_ABOVE * middle and largest not in named:
        times = f"{known[largest] / middle:.1f} times the median of the robots"
        yield Text(f"Largest RP XY: {largest}, {known[largest]:.4f} mm, {times}", "warn")


def _wearing(found: FleetSummary | FleetFigures) -> Iterator[Text]:
    growing = () if found.drift is None else found.drift.growing
    of_each = [
        f"{one.robot} {share(one.per_month, '+.1%')} a month (p = {four_digits(one.p_value)})"
        for one in growing
    ]
    if growing:
        yield Text(f"Wears: {few(of_each, _AT_ONCE)}", "warn")


def _shown_by(one: RobotResult) -> str:
    effects = ", ".join(map(words, one.effects)) or (words(UNKNOWN) if one.found else "")
    return f"{effects}, test {one.test}" if one.found and one.tables > 1 else effects


_ROBOTS: Columns[RobotResult] = {
    "robot": lambda one: one.robot,
    "tables": lambda one: one.tables,
    "p": lambda one: four_digits(one.p_value),
    "q": lambda one: four_digits(one.q_value),
    "RP XY mm": lambda one: share(one.RP_XY, ".4f"),
    "effects": _shown_by,
}
_GROWTH: Columns[RobotGrowth] = {
    "robot": lambda one: one.robot,
    "dates": lambda one: one.dates,
    "a month": lambda one: share(one.per_month, "+.1%"),
    "p": lambda one: four_digits(one.p_value),
    "q": lambda one: four_digits(one.q_value),
}


def _parts(run: FleetRun) -> str:
    done = f"; {run.before} of them were done before" if run.before else ""
    return f"{many(run.parts, 'part')}{done}"


def _doubts(found: FleetSummary | FleetFigures) -> Iterator[list[str]]:
    count = len(found.failed) + len(found.run.failed)
    yield [f"! {count} could not be used: they are listed below"] if count else []
    yield [
        f"! {one.robot} {one.test} is there twice, in {', '.join(one.parts)}: both "
        "count; remove one of them"
        for one in found.twice
    ]
    yield [f"! {one}" for one in found.run.doubts]
    yield [f"! {_alone(one)}" for one in found.names_alone]
    yield [
        f"! serial number {one.robot} stands with the names {few(one.names, _NAMED)}: they are "
        "taken for one robot; if they are several, state the serial number of each"
        for one in found.several_names
    ]
    yield [f"! {_apart(one)}" for one in (found.names_and_numbers,) if one is not None]
    yield [
        f"! {few(names, _NAMED)} are alike but for case, blanks or zeros in front, and count as "
        "several robots; if they are one, write it in one way"
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
    ends = [str(share(end, "+.1%")) for end in found.interval or ()]
    apart = f" (95 %: {' to '.join(ends)})" if ends else ""
    rate = share(found.per_month, "+.1%")
    yield Text(f"the median of {found.robots} robots: {rate} a month{apart}")
    columns: Columns[Any] = {
        "tested": lambda one: one.period,
        "robots": lambda one: one.robots,
        "5 %": lambda one: share(one.RP_quantiles[0], ".4f"),
        "50 %": lambda one: share(one.RP_quantiles[2], ".4f"),
        "95 %": lambda one: share(one.RP_quantiles[4], ".4f"),
        "worse than before": lambda one: f"{one.worse} of {one.compared}" if one.compared else "",
    }
    yield Table.of(found.periods, columns)
    count = len(found.growing)
    grows = f"grows in {count} of the {found.asked} robots with three dates or more"
    yield Text(grows, "warn" if count else "quiet")
