"""The documents of a push test, and of the visits found in a stream."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

from scara_iso.base.quantities import Dimension
from scara_iso.iso9283 import Characteristic, Conformity, LimitCheck, PushResult, StreamVisits
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Headline,
    Interval,
    NextStep,
    Number,
    Report,
    Section,
    Table,
    Text,
    answer_lines,
    at_depth,
    decimals,
    figure_in_words,
    interval,
    places_that_decide,
    rounded,
    words,
)
from scara_iso.reporting.figure_tables import characteristics_table
from scara_iso.reporting.limits import figures_by_limit, limit_cell
from scara_iso.signals import Doubt, Rule, Visit

BOUGHT_BY = ("lost_motion", "stiffness", "friction_torque", "compliance")
_MEANING = (
    "lost motion: between the flanks, spring and friction taken off; friction width: between the "
    "ways to and fro on one flank; hysteresis: both together, at no force; deflection: between the "
    "ends of the loop; friction: Coulomb's, one side; stiffness: of all behind the dial"
)
_OF = {"joint": "of the joint", "reading": "of the reading"}
_TONE: dict[Conformity, Literal["good", "bad", "warn"]] = {
    Conformity.PASS: "good",
    Conformity.FAIL: "bad",
    Conformity.NOT_PROVABLE: "warn",
}
_WORDS = {
    Conformity.PASS: "PASS: inside the limit",
    Conformity.FAIL: "FAIL: OUTSIDE the limit",
    Conformity.NOT_PROVABLE: "NOT PROVABLE with these loops",
}


def push_report(found: PushResult, following: NextStep | None = None) -> Report:
    """Return the document of a push test: the verdict, the figures, how they were found."""
    of = "reading" if found.arm_m is None else "joint"
    rows = {name: [one for one in found.characteristics if one.of == name] for name in _OF}
    doubts = [block for block in _how(found) if block.tone != "quiet"]
    title, *verdicts = _verdict(found)
    figure = _largest(rows[of], found)
    lines = [*verdicts, figure, title] if found.limits else [figure, title, *verdicts]
    answer = len(lines) - 1 if found.limits else 2
    limits = (_limits(found.limits),) if found.limits else ()
    behind = Text(f"figures of the {of}; how they are found, and the others: `full=`", "quiet")
    others = [
        Section(heading, (_figures(rows[name]),))
        for name, heading in _OF.items()
        if name != of and rows[name]
    ]
    rules = [Section("", (Text(table.note, "quiet"),)) for table in limits]
    how = Section("", tuple(block for block in _how(found) if block.tone == "quiet"))
    return (
        Section("", (*answer_lines(lines, following, answer=answer), *doubts)),
        Section("", (_figures(rows[of]), *(replace(table, note="") for table in limits))),
        Section("", (behind,), depth="more"),
        *at_depth("detail", (*others, how, *rules)),
    )


def _largest(rows: list[Characteristic], found: PushResult) -> Headline:
    parts = []
    for one in rows:
        if one.code in BOUGHT_BY:
            unit, ends = one.estimate.unit, one.estimate.interval
            parts.append(figure_in_words(words(one.code), one.estimate.value, ends, unit))
    return Headline(tuple(parts) or (f"{found.fit.loops} loops",))


def _verdict(found: PushResult) -> Iterator[Block]:
    fit = found.fit
    low, high = fit.ends
    arm = "" if found.arm_m is None else f", {found.arm_m:g} m from the joint"
    yield Text(f"Push test: {fit.loops} loops from {low:g} to {high:g} N{arm}", "strong")
    for verdict in (Conformity.FAIL, Conformity.NOT_PROVABLE, Conformity.PASS):
        checks = [check for check in found.limits if check.verdict is verdict]
        if checks:
            text = f"{_WORDS[verdict]}: {figures_by_limit(checks)}"
            yield Text(text, _TONE[verdict])
    if found.arm_m is None:
        yield Text("Without `arm=` no angle of the joint is known.")


def _figures(found: list[Characteristic]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for one in found:
        estimate = one.estimate
        ends = estimate.interval
        U = 0.0 if ends is None else (ends[1] - ends[0]) / 2
        rows.append((one.code, rounded(estimate.value, U), interval(ends), estimate.unit))
    return Table(("figure", "", "95 % interval", "in"), tuple(rows))


def _limits(checks: tuple[LimitCheck, ...]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for check in checks:
        ends = check.interval or ()
        places = places_that_decide(check.limit, (check.RP, *ends), decimals([check.RP]))
        value, *text = (Number(x, f".{places}f") for x in (check.RP, *ends))
        between = Interval(*text) if text else "none"
        rows.append((check.figure, value, between, limit_cell(check), check.verdict.value))
    return Table(
        ("limit of", "figure", "95 % interval", "limit", "verdict"),
        tuple(rows),
        "pass: the whole interval is at most the limit; fail: all of it is above; else these loops "
        "prove neither. Simple acceptance, where chosen, takes the figure alone.",
    )


def _how(found: PushResult) -> Iterator[Text]:
    fit = found.fit
    if fit.misfit is not None:
        yield Text(
            f"the loops repeat a shape that spring, play and friction do not explain "
            f"({fit.misfit:.2g} mm rms): the intervals are widened for it; look at the loop",
            "warn",
        )
    yield from (Text(note) for note in found.loop.notes)
    run_in = f"; {fit.run_in} before the first end do not count" if fit.run_in else ""
    yield Text(_MEANING, "quiet")
    yield Text(
        f"{fit.readings} readings{run_in}; reading = force through friction x compliance ± half "
        f"the lost motion, each loop with its own zero; residual {fit.residual:.2g} mm; 95 %, "
        "Student; the force, and the arm, are taken as exact",
        "quiet",
    )


_SHOWN, _SHOWN_IN_BRIEF = 40, 6


def visits_report(found: StreamVisits, following: NextStep | None = None) -> Report:
    """Return the document of a stream: how many visits, how the arm arrives, what is doubtful."""
    count, *doubts = _visits_counted(found)
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
    return figure_in_words(name, estimate.value, estimate.interval, estimate.unit)


def _no_arrival(found: StreamVisits) -> str:
    return f"no arrival is measured in {len(found.visits)} visits"


def _visits_counted(found: StreamVisits) -> Iterator[Block]:
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
