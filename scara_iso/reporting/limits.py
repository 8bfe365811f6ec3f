"""The report on figures against the limits that the user gave."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from scara_iso.iso9283 import MOST_CYCLES, Analysis, Conformity, DecisionRule, LimitCheck
from scara_iso.reporting.blocks import Interval, Number, Section, Table, Text
from scara_iso.reporting.digits import decimals, places_that_decide

_USUAL = ("mm", "deg")
GRAVER = (
    "XY has two figures, radial (7.2.2) and eq. 23 of the paper: the stricter of the two decides."
)
_FIGURES = f"In mm; an angle in degrees, by ± 3 s. {GRAVER} "
_INTERVAL = (
    "Pass: the whole 95 % interval of the figure is at most the limit. Fail: all of it is above. "
    "Else these cycles prove neither. Chance, dial and stated calibration are counted; either end "
    "is wrong in one test of forty or fewer with Gaussian scatter. Cycles needed: about this many "
    "in one run would prove it if the true figure is the one read; no number would where the dial "
    "hides the scatter, or the calibration alone reaches the limit."
)
_SIMPLE = (
    "Simple acceptance was chosen: pass where RP is at most the limit; the uncertainty of so few "
    "cycles is not counted. Guard band: U = 2 u of the indicator (ISO 14253-1)."
)
RULES = {
    DecisionRule.INTERVAL: (
        "Decision rule: pass where the whole 95 % interval of a figure is at most its limit, fail "
        "where all of it is above, else not provable with these cycles."
    ),
    DecisionRule.SIMPLE: (
        "Decision rule: simple acceptance, pass where a figure is at most its limit; the "
        "uncertainty of so few cycles is not counted."
    ),
}
"""In one sentence."""
STRICTEST = (Conformity.FAIL, Conformity.NOT_PROVABLE, Conformity.PASS)
_OPEN_CAUSES = ("trend", "gross-reading")
"""Findings whose cause is to be found before more cycles are run."""
VERDICTS = {
    Conformity.PASS: "pass",
    Conformity.FAIL: "FAIL",
    Conformity.NOT_PROVABLE: "not provable",
}


def conformity(analysis: Analysis) -> Iterator[Text]:
    """Yield whether the limits are kept, by which rule, and what would prove it."""
    by_verdict: dict[Conformity, list[LimitCheck]] = {}
    for check in analysis.limits:
        by_verdict.setdefault(check.verdict, []).append(check)
    simple = any(check.decision is DecisionRule.SIMPLE for check in analysis.limits)
    how = "by simple acceptance" if simple else "with the whole 95 % interval"
    failed = by_verdict.get(Conformity.FAIL, [])
    open_ = by_verdict.get(Conformity.NOT_PROVABLE, [])
    if failed:
        yield Text(f"FAIL: OUTSIDE the limit {how}: {_names(failed)}", "bad")
    if open_:
        yield Text(
            f"NOT PROVABLE with these cycles: {_names(open_)}; {_would_prove(open_, analysis)}",
            "warn",
        )
    if analysis.conformity is Conformity.PASS:
        yield Text(f"PASS: inside the limits {how}: {_names(analysis.limits)}", "good")
    void = [check for check in analysis.limits if check.interval_void and not simple]
    if void:
        moved = dict.fromkeys(one.axis for one in analysis.findings if one.voids_interval)
        axes = " and ".join(filter(None, moved)) or "The readings"
        yield Text(
            f"{axes} drifted, so the interval of {_figures_of(void)} does not hold. "
            "Find the cause first.",
            "warn",
        )


def limits(analysis: Analysis) -> Iterator[Section]:
    """Yield the figures against their limits, where the user gave any."""
    yield from table_of_limits(analysis.limits)


def table_of_limits(checks: Sequence[LimitCheck]) -> Iterator[Section]:
    """Yield figures against their limits, where there are any."""
    if checks:
        simple = checks[0].decision is DecisionRule.SIMPLE
        table = (_simple_table if simple else _interval_table)(checks)
        yield Section("limits", (table,))


def limit_cell(check: LimitCheck) -> Number | str:
    """Return the limit, or the smallest and the largest value that are allowed."""
    if check.lower is None:
        return Number(check.limit, ".15g", check.unit)
    return f"{check.lower:.15g} to {check.limit:.15g} {check.unit}"


def _interval_table(checks: Sequence[LimitCheck]) -> Table:
    rows = []
    for check in checks:
        ends = check.interval or ()
        places = places_that_decide(check.limit, (check.RP, *ends), decimals([check.RP]))
        RP, *said = (Number(value, f".{places}f") for value in (check.RP, *ends))
        interval = Interval(*said) if said else "none"
        limit, verdict = limit_cell(check), VERDICTS[check.verdict]
        rows.append((_name(check), RP, interval, limit, verdict, _wanted(check)))
    header = ("limit of", _figure(checks), "95 % interval", "limit", "verdict", "cycles needed")
    return Table(header, tuple(rows), _FIGURES + _INTERVAL)


def _simple_table(checks: Sequence[LimitCheck]) -> Table:
    rows = []
    for check in checks:
        places = places_that_decide(check.limit, (check.RP,), decimals([check.RP]))
        guard = "not known" if check.guard is None else _guard_band(check.guard)
        near = ", in the guard band" if check.guard is not None and not check.clear else ""
        rows.append(
            (
                _name(check),
                Number(check.RP, f".{places}f"),
                limit_cell(check),
                guard,
                VERDICTS[check.verdict] + near,
            )
        )
    return Table(
        ("limit of", _figure(checks), "limit", "guard band", "verdict"),
        tuple(rows),
        _FIGURES + _SIMPLE,
    )


def _figure(checks: Sequence[LimitCheck]) -> str:
    return "RP" if all(check.code.startswith("RP") for check in checks) else "figure"


def _guard_band(half_width: float) -> Number:
    return Number(half_width, f".{decimals([half_width])}f", mark="± ")


def _wanted(check: LimitCheck) -> Number | str:
    if check.verdict is not Conformity.NOT_PROVABLE:
        return ""
    if check.interval_void:
        return "find the cause first"
    if check.cycles_wanted is None:
        return "none would do"
    wanted = Number(check.cycles_wanted)
    return f"over {wanted}" if check.cycles_wanted >= MOST_CYCLES else wanted


def _would_prove(checks: Sequence[LimitCheck], analysis: Analysis) -> str:
    """Return what would: so many cycles, to two digits, or a finer dial where none would.

    No number of them, where something else than scatter is in the readings.
    """
    if any(check.interval_void for check in checks) or any(
        one.code in _OPEN_CAUSES for one in analysis.findings
    ):
        return "find the cause first"
    wanted = [check.cycles_wanted for check in checks]
    if None in wanted:
        return "no more would, a finer or better calibrated dial may"
    most = max(cycles for cycles in wanted if cycles is not None)
    if most >= MOST_CYCLES:
        return f"more than {MOST_CYCLES} would"
    magnitude = 10 ** max(len(str(most)) - 2, 0)
    return f"about {math.ceil(most / magnitude) * magnitude} would"


def figure_held(check: LimitCheck) -> str:
    """Return the figure that a limit is held against, where it has two: which of them."""
    return f"{check.figure} eq. 23" if check.code == "RP_rss" else check.figure


def _name(check: LimitCheck) -> str:
    held = figure_held(check)
    figure = held if check.unit in _USUAL else f"{held} in {check.unit}"
    return figure if check.pose is None else f"{figure} at {check.pose}"


def _names(checks: Sequence[LimitCheck]) -> str:
    """Return each figure with the poses at which it is meant, and its limit."""
    by_limit: dict[str, list[LimitCheck]] = {}
    for check in checks:
        by_limit.setdefault(str(limit_cell(check)), []).append(check)
    return "; ".join(f"{_figures_of(held)}, limit {limit}" for limit, held in by_limit.items())


def _figures_of(checks: Sequence[LimitCheck]) -> str:
    poses: dict[str, list[str]] = {}
    for check in checks:
        poses.setdefault(figure_held(check), []).append(check.pose or "")
    if not any(check.pose for check in checks):
        return ", ".join(poses)
    return "; ".join(f"{figure} at {', '.join(labels)}" for figure, labels in poses.items())
