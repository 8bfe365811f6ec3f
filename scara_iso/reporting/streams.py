"""The report on the visits that were found in a stream."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from scara_iso.base.quantities import Dimension
from scara_iso.iso9283 import Characteristic, StreamVisits
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Headline,
    NextStep,
    Number,
    Report,
    Section,
    Table,
    Text,
    answer_lines,
    at_depth,
)
from scara_iso.reporting.digits import figure_said, rounded, words
from scara_iso.reporting.figure_tables import characteristics_table
from scara_iso.signals import Doubt, Rule, Visit

_SHOWN, _SHOWN_IN_BRIEF = 40, 6


def visits_report(found: StreamVisits, following: NextStep | None = None) -> Report:
    """Return the document of a stream: how many visits, how the arm arrives, what is doubtful."""
    count, *doubts = _verdict(found)
    arrival = Headline(tuple(map(_arrives, found.characteristics)) or (_no_arrival(found),))
    return (
        Section("", answer_lines([count, arrival, *doubts], following)),
        Section("", tuple(_first_visits(found)), depth="more"),
        *at_depth("detail", _details(found)),
    )


def _first_visits(found: StreamVisits) -> Iterator[Block]:
    shown = _visits(found)
    yield replace(shown, rows=shown.rows[:_SHOWN_IN_BRIEF])
    more = len(found.visits) - _SHOWN_IN_BRIEF
    if more > 0:
        yield Text(f"and {more} more visits", "quiet")
    for one in found.doubts[:_SHOWN_IN_BRIEF]:
        yield Text(f"! {one.code}: {one.message}", "warn")
    yield Text("the rule for a rest, scatter at each, all arrivals: `full=`", "quiet")


def _details(found: StreamVisits) -> Iterator[Section]:
    yield Section("rule", tuple(_rule(found.rule, found)))
    yield Section("visits", (_visits(found), *_more(len(found.visits), "visits")))
    if found.characteristics:
        table = characteristics_table(found.characteristics)
        yield Section("arrivals (7.4, 7.5)", (table, Text(_longest(found), "quiet")))
    if found.doubts:
        rest = _more(len(found.doubts), "of them")
        yield Section("to be looked at", (_doubts(found.doubts), *rest))


def _arrives(one: Characteristic) -> str:
    estimate = one.estimate
    name = " ".join(part for part in (words(one.code), one.pose, one.of) if part)
    return figure_said(name, estimate.value, estimate.interval, estimate.unit)


def _no_arrival(found: StreamVisits) -> str:
    return f"no arrival is measured in {len(found.visits)} visits"


def _verdict(found: StreamVisits) -> Iterator[Block]:
    out = sum(not doubt.counted for doubt in found.doubts)
    yield Text(
        f"{len(found.visits)} visits in {found.samples} samples at {found.rate_hz:.4g} Hz", "strong"
    )
    if found.doubts:
        yield Text(f"to be looked at: {len(found.doubts)}, of which {out} do not count", "warn")
    yield from (Text(note) for note in found.notes)
    yield Text(found.run.origin.understood, "quiet")


def _rule(rule: Rule, found: StreamVisits) -> Iterator[Block]:
    unit = _unit(found)
    still = "as stated" if rule.still_stated else "the threshold on which the count depends least"
    band = "as stated" if rule.band_stated else "five times the scatter at rest"
    bands = ", ".join(f"{n} ± {b:g} {found.run.axes[n].unit}" for n, b in rule.band.items())
    yield Text(
        f"at rest: the readings stay within {rule.still:g} {unit} ({still}) in a window of "
        f"{rule.window_s:.3g} s ({rule.samples_in_window} samples)"
    )
    yield Text(f"a visit: a rest of {rule.dwell_s:g} s or more that was seen to begin")
    yield Text(f"limit band: {bands} ({band})")
    yield Text(
        "the reading is the mean of the middle half of the rest, from where the band is kept",
        "quiet",
    )


def _unit(found: StreamVisits) -> str:
    lengths = any(axis.dimension is Dimension.LENGTH for axis in found.run.axes.values())
    return str((Dimension.LENGTH if lengths else Dimension.ANGLE).value)


def _visits(found: StreamVisits) -> Table:
    axes = list(found.run.axes)
    labelled = any(visit.pose for visit in found.visits)
    header = ["visit", *(["pose"] if labelled else []), "start [s]", "settled [s]", "end [s]"]
    for name in axes:
        header += [name, f"scatter {name}", "from"]
    rows = [
        _row(k, visit, axes, labelled=labelled) for k, visit in enumerate(found.visits[:_SHOWN], 1)
    ]
    return Table(tuple(header), tuple(rows), "from: + where the reading rose to the pose")


def _more(number: int, of_them: str) -> Iterator[Text]:
    if number > _SHOWN:
        yield Text(f"and {number - _SHOWN} more {of_them}: `json=True` shows all")


def _row(k: int, visit: Visit, axes: list[str], *, labelled: bool) -> tuple[Cell, ...]:
    cells: list[Cell] = [str(k), *([visit.pose or ""] if labelled else [])]
    cells += [Number(time, ".3f") for time in (visit.start, visit.settled, visit.end)]
    for name in axes:
        scatter = visit.scatter[name]
        sign = {1: "+", -1: "-", 0: ""}[visit.approach[name]]
        cells += [rounded(visit.mean[name], scatter), Number(scatter, ".2g"), sign]
    return tuple(cells)


def _longest(found: StreamVisits) -> str:
    times = [t for v in found.visits for t in v.stabilisation_s.values() if t is not None]
    peaks = [o for v in found.visits for o in v.overshoot.values() if o is not None]
    return (
        f"figures are means over the arrivals; the longest stabilisation is {max(times):.4g} s "
        f"(the dwell must not be shorter), the largest overshoot {max(peaks):.4g}"
    )


def _doubts(doubts: tuple[Doubt, ...]) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            doubt.code,
            Number(doubt.start, ".3f"),
            Number(doubt.end, ".3f"),
            "yes" if doubt.counted else "no",
            doubt.message,
        )
        for doubt in doubts[:_SHOWN]
    )
    return Table(("what", "from [s]", "to [s]", "visit", "why"), rows)
