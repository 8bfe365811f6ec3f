"""The report on a push test."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

from scara_iso.iso9283 import Characteristic, Conformity, LimitCheck, PushResult
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
)
from scara_iso.reporting.digits import (
    decimals,
    figure_said,
    interval,
    places_that_decide,
    rounded,
    words,
)
from scara_iso.reporting.limits import limit_cell

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
    said = []
    for one in rows:
        if one.code in BOUGHT_BY:
            unit, ends = one.estimate.unit, one.estimate.interval
            said.append(figure_said(words(one.code), one.estimate.value, ends, unit))
    return Headline(tuple(said) or (f"{found.fit.loops} loops",))


def _verdict(found: PushResult) -> Iterator[Block]:
    fit = found.fit
    low, high = fit.ends
    arm = "" if found.arm_m is None else f", {found.arm_m:g} m from the joint"
    yield Text(f"Push test: {fit.loops} loops from {low:g} to {high:g} N{arm}", "strong")
    for verdict in (Conformity.FAIL, Conformity.NOT_PROVABLE, Conformity.PASS):
        held = [check for check in found.limits if check.verdict is verdict]
        if held:
            said = f"{_WORDS[verdict]}: {', '.join(check.figure for check in held)}"
            yield Text(said, _TONE[verdict])
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
        value, *said = (Number(x, f".{places}f") for x in (check.RP, *ends))
        between = Interval(*said) if said else "none"
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
