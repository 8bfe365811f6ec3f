"""The documents of a push test, and of the visits found in a stream."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from scara_iso.base.quantities import Dimension
from scara_iso.iso9283 import Characteristic, PushResult, StreamVisits
from scara_iso.reporting.shared.blocks import (
    Block,
    Columns,
    NextStep,
    Report,
    Section,
    Table,
    Text,
    note,
)
from scara_iso.reporting.shared.digits import FIGURE, Cell, Number, rounded, words
from scara_iso.reporting.shared.figures import characteristics_table
from scara_iso.reporting.shared.limits import estimate_result, table_of_limits, verdicts
from scara_iso.signals import Doubt

BOUGHT_BY = ("lost_motion", "stiffness", "friction_torque", "compliance")
_OF = {"joint": "of the joint", "reading": "of the reading"}
_SHOWN, _SHOWN_IN_BRIEF = 40, 6


def push_report(found: PushResult, following: NextStep | None = None) -> Report:
    """Return the document of a push test: the verdict, the figures, how they were found."""
    fit, of = found.fit, "reading" if found.arm_m is None else "joint"
    rows = {name: [one for one in found.characteristics if one.of == name] for name in _OF}
    shown = tuple(_in_words(one, of) for one in rows[of] if one.code in BOUGHT_BY)
    arm = "" if found.arm_m is None else f", {found.arm_m:g} m from the joint"
    low, high = fit.ends
    title = Text(f"Push test: {fit.loops} loops from {low:g} to {high:g} N{arm}", "strong")
    decided = list(verdicts(found.limits, "loops"))
    first, *others = shown or (f"{fit.loops} loops",)
    figures = Text(first, "strong", tuple(others))
    no_arm = Text("" if arm else "Without `arm=` no angle of the joint is known.")
    lines: list[Block] = [*decided, figures, title, no_arm, *_doubts_of_loops(found)]
    limits = [b for one in table_of_limits(found.limits, note("loops")) for b in one.blocks]
    brief = [replace(one, note="") for one in limits if isinstance(one, Table)]
    behind = f"figures of the {of}; how they are found, and the others: `full=`"
    tables = (Section(_OF[name], (_figures(rows[name]),)) for name in _OF if name != of)
    rule = Text(note("loops") if found.limits else "", "quiet")
    return (
        Section.of_answer(lines, following, answer=len(decided) + 1),
        Section("", (_figures(rows[of]), *brief)),
        Section("", (Text(behind, "quiet"),), depth="more"),
        *Section.in_detail((*tables, Section("", (*_how(found), rule)))),
    )


def _in_words(one: Characteristic, of: str = "") -> str:
    named = (words(one.code), one.pose, one.of if one.of != of else "")
    return " ".join(filter(None, (*named, str(estimate_result(one, one.estimate.unit)))))


def _figures(found: list[Characteristic]) -> Table:
    columns: Columns[Characteristic] = {
        "": lambda one: one.code,
        FIGURE: lambda one: estimate_result(one, one.estimate.unit),
    }
    return Table.of(found, columns)


def _doubts_of_loops(found: PushResult) -> Iterator[Text]:
    if (misfit := found.fit.misfit) is not None:
        shape = "the loops repeat a shape that spring, play and friction do not explain"
        widened = "the intervals are widened for it; look at the loop"
        yield Text(f"{shape} ({misfit:.2g} mm rms): {widened}", "warn")
    yield from map(Text, found.loop.notes)


def _how(found: PushResult) -> Iterator[Text]:
    fit = found.fit
    run_in = f"; {fit.run_in} before the first end do not count" if fit.run_in else ""
    residual = f"residual {fit.residual:.2g} mm"
    yield Text(note("push_figures"), "quiet")
    yield Text(f"{fit.readings} readings{run_in}; {residual}; {note('push_model')}", "quiet")


def visits_report(found: StreamVisits, following: NextStep | None = None) -> Report:
    """Return the document of a stream: how many visits, how the arm arrives, what is doubtful."""
    n, doubts = len(found.visits), found.doubts
    out = sum(not doubt.counted for doubt in doubts)
    count = f"{n} visits in {found.samples} samples at {found.rate_hz:.4g} Hz"
    look = f"rests to check: {len(doubts)}, not counted: {out}" if doubts else ""
    nothing = f"no arrival is measured in {n} visits"
    arrives, *others = [*map(_in_words, found.characteristics)] or [nothing]
    lines: list[Block] = [
        Text(count, "strong"),
        Text(arrives, "strong", tuple(others)),
        Text(look, "warn"),
        *map(Text, found.notes),
        Text(found.run.origin.understood, "quiet"),
    ]
    first: list[Block] = [
        _visits(found, _SHOWN_IN_BRIEF, narrow=len(found.run.axes) > 1),
        Text(f"and {n - _SHOWN_IN_BRIEF} more visits" if n > _SHOWN_IN_BRIEF else "", "quiet"),
        *(Text(f"! {one.code}: {one.message}", "warn") for one in doubts[:_SHOWN_IN_BRIEF]),
        Text("the rule for a rest, scatter at each, all arrivals: `full=`", "quiet"),
    ]
    details = (
        Section("rule", tuple(_rule(found))),
        Section("visits", (_visits(found, _SHOWN), _more(n, "visits"))),
        Section("arrivals (7.4, 7.5)", tuple(_arrivals(found))),
        Section("to be checked", (_doubts(doubts), _more(len(doubts), "of them"))),
    )
    return (
        Section.of_answer(lines, following),
        Section("", tuple(first), depth="more"),
        *Section.in_detail(details),
    )


def _rule(found: StreamVisits) -> Iterator[Block]:
    rule, axes = found.rule, found.run.axes
    lengths = any(axis.dimension is Dimension.LENGTH for axis in axes.values())
    unit = (Dimension.LENGTH if lengths else Dimension.ANGLE).value
    still = "as stated" if rule.still_stated else "the threshold on which the count depends least"
    band = "as stated" if rule.band_stated else "five times the scatter at rest"
    bands = ", ".join(f"{name} ± {b:g} {axes[name].unit}" for name, b in rule.band.items())
    yield Text(
        f"at rest: the readings stay within {rule.still:g} {unit} ({still}) in a window of "
        f"{rule.window_s:.3g} s ({rule.samples_in_window} samples)"
    )
    yield Text(f"a visit: a rest of {rule.dwell_s:g} s or more that was seen to begin")
    yield Text(f"limit band: {bands} ({band})")
    yield Text(note("reading_of_a_rest"), "quiet")


def _visits(found: StreamVisits, most: int, *, narrow: bool = False) -> Table:
    """Return a row for each visit; ``narrow`` without columns for which a screen has no room."""
    labelled = any(visit.pose for visit in found.visits)
    rows: list[dict[str, Cell]] = []
    for k, visit in enumerate(found.visits[:most], 1):
        row: dict[str, Cell] = {"visit": str(k), **({"pose": visit.pose or ""} if labelled else {})}
        times = {"start": visit.start, "settled": visit.settled, "end": visit.end}
        if narrow:
            del times["settled"]
        row |= {f"{name} [s]": Number(time, ".3f") for name, time in times.items()}
        for name, scatter in visit.scatter.items():
            row[name] = rounded(visit.mean[name], scatter)
            if not narrow:
                row[f"scatter {name}"] = Number(scatter, ".2g")
                row[f"from {name}"] = ("", "+", "-")[visit.approach[name]]
        rows.append(row)
    return Table.by_name(rows, "" if narrow else "from: + where the reading rose to the pose")


def _more(number: int, of_them: str) -> Text:
    more = f"and {number - _SHOWN} more {of_them}: `json=True` shows all"
    return Text(more if number > _SHOWN else "")


def _arrivals(found: StreamVisits) -> Iterator[Block]:
    if found.characteristics:
        times = [t for v in found.visits for t in v.stabilisation_s.values() if t is not None]
        peaks: dict[str, float] = {}
        for name, size in ((n, o) for v in found.visits for n, o in v.overshoot.items()):
            if size is not None:
                peaks[found.units[name]] = max(size, peaks.get(found.units[name], 0.0))
        largest = " and ".join(f"{size:.4g} {unit}" for unit, size in peaks.items())
        yield characteristics_table(found.characteristics)
        yield Text(
            "figures are means over the arrivals; the longest stabilisation is "
            f"{max(times):.4g} s (the dwell must not be shorter), the largest overshoot "
            f"{largest}",
            "quiet",
        )


def _doubts(doubts: tuple[Doubt, ...]) -> Table:
    columns: Columns[Doubt] = {
        "what": lambda doubt: doubt.code,
        "from [s]": lambda doubt: Number(doubt.start, ".3f"),
        "to [s]": lambda doubt: Number(doubt.end, ".3f"),
        "visit": lambda doubt: "yes" if doubt.counted else "no",
        "why": lambda doubt: doubt.message,
    }
    return Table.of(doubts[:_SHOWN], columns)
