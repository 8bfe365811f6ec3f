"""Figures against the limits that the user gave, and the result table of page 1 with its verdicts.

The table is made from `Analysis.characteristics` alone: a new characteristic needs nothing here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from scara_iso.iso9283 import (
    FEWEST_FOR_INTERVAL,
    MOST_CYCLES,
    Analysis,
    Characteristic,
    Conformity,
    DecisionRule,
    LimitCheck,
)
from scara_iso.reporting.shared.blocks import Block, Columns, Section, Table, Text, note
from scara_iso.reporting.shared.digits import (
    FIGURE,
    OF_EQ_23,
    Cell,
    Number,
    Result,
    Tone,
    result,
    words,
)
from scara_iso.reporting.shared.stated import is_one_of, stated_limits
from scara_iso.run import AXES
from scara_iso.tables import listed

if TYPE_CHECKING:
    from scara_iso.testfolder import Condition

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
_AS_MEASURED = "A figure whose interval does not hold is judged as measured, drift included."
_OPEN_CAUSES = ("trend", "gross-reading")
"""Findings whose cause is to be found before more cycles are run."""
VERDICTS: Mapping[Conformity, tuple[str, Tone]] = {
    Conformity.FAIL: ("FAIL", "bad"),
    Conformity.NOT_PROVABLE: ("not provable", "warn"),
    Conformity.PASS: ("pass", "good"),
}
"""The strictest first: how each is said, and its tone."""
STRICTEST = tuple(VERDICTS)
_FARTHEST = 100.0
"""Times the figure: a limit beyond is of another unit, as 20 (mm) in place of 20um."""


def conformity(analysis: Analysis) -> Iterator[Text]:
    """Yield whether the limits are kept, by which rule, and what would prove it."""
    checks = analysis.limits
    void = [one for one in checks if one.interval_void and one.decision is DecisionRule.INTERVAL]
    partly = any(one.code == "parts-missing" for one in analysis.findings)
    for found in verdicts(checks, proof="" if void else f"; {_would_prove(checks, analysis)}"):
        so_far = found.text.replace("PASS:", "PASS SO FAR, parts are not recorded:")
        yield Text(so_far, "warn") if partly and so_far != found.text else found
    if void:
        moved = dict.fromkeys(one.axis for one in analysis.findings if one.voids_interval)
        axes = " and ".join(filter(None, moved)) or "The readings"
        text = f"{axes} drifted, so the interval of {_figures_of(void)} does not hold"
        yield Text(f"{text}. Find the cause first.", "warn")
    sizes = [one.limit for one in checks]
    stated = stated_limits(analysis.run)
    others = [words for _, words, size in stated if not is_one_of(sizes, size)]
    if others:
        yield Text(f"! the table states {listed(others)}: not held against it", "warn")
    scatter = (one for one in checks if one.code.startswith("RP") and one.RP > 0)
    far = next((one for one in scatter if one.limit > _FARTHEST * one.RP), None)
    if far is not None:
        times = f"{far.limit / far.RP:.0f} times {far.figure}"
        yield Text(f"! the limit of {limit_cell(far)} is {times}: is its unit meant?", "warn")


def rule_of(checks: Sequence[LimitCheck]) -> str:
    """Return by which rule it was decided, and what holds where readings moved."""
    if not checks:
        return "No limit was given: nothing is decided."
    moved = any(one.interval_void for one in checks) and checks[0].decision is DecisionRule.INTERVAL
    return RULES[checks[0].decision] + f" {_AS_MEASURED}" * moved


def verdicts(
    checks: Sequence[LimitCheck], counted: str = "cycles", proof: str = ""
) -> Iterator[Text]:
    """Yield which figures fail and which are open, else that all are inside, and by which rule."""
    simple = any(check.decision is DecisionRule.SIMPLE for check in checks)
    how = "by simple acceptance" if simple else "with the whole 95 % interval"
    drifts = not simple and any(check.interval_void for check in checks)
    kept = "as measured, drift included" if drifts else how
    text = {
        Conformity.FAIL: f"FAIL: OUTSIDE the limit {how}",
        Conformity.NOT_PROVABLE: f"NOT PROVABLE with these {counted}",
        Conformity.PASS: f"PASS: inside the limits {kept}",
    }
    for verdict, (_, tone) in VERDICTS.items():
        found = [check for check in checks if check.verdict is verdict]
        if found and (verdict is not Conformity.PASS or len(found) == len(checks)):
            open_ = proof if verdict is Conformity.NOT_PROVABLE else ""
            yield Text(f"{text[verdict]}: {_figures_by_limit(found)}{open_}", tone)


def table_of_limits(checks: Sequence[LimitCheck], of_loops: str = "") -> Iterator[Section]:
    """Yield figures against their limits, where there are any; ``of_loops`` is their rule."""
    if not checks:
        return
    simple = checks[0].decision is DecisionRule.SIMPLE
    columns: Columns[LimitCheck] = {
        "limit of": lambda one: one.figure + (f" at {one.pose}" if one.pose else ""),
        "figure" if simple else FIGURE: _figure,
        "limit": limit_cell,
        **({"guard band": _guard_band} if simple else {}),
        "verdict": _verdict,
        **({} if simple or of_loops else {"cycles needed": _wanted}),
    }
    rule = of_loops or note("limits_simple" if simple else "limits_interval")
    yield Section("limits", (Table.of(checks, columns, rule),))


def _figure(check: LimitCheck) -> Result:
    ends = check.interval if check.decision is DecisionRule.INTERVAL else None
    return result(check.RP, ends, limit=check.limit)


def _verdict(check: LimitCheck) -> str:
    behind = _drift(check)
    if check.decision is DecisionRule.SIMPLE:
        behind = ", in the guard band" * (check.guard is not None and not check.clear)
    return VERDICTS[check.verdict][0] + behind


def _drift(check: LimitCheck) -> str:
    """Return that a verdict holds with the drift only, where no interval does."""
    return ", drift" * (check.interval_void and check.verdict is not Conformity.FAIL)


def limit_cell(check: LimitCheck) -> Number | str:
    """Return the limit, or the smallest and the largest value that are allowed."""
    if check.lower is None:
        return Number(check.limit, ".15g", check.unit)
    return f"{check.lower:.15g} to {check.limit:.15g} {check.unit}"


def _guard_band(check: LimitCheck) -> Cell:
    return "not known" if check.guard is None else result(check.guard, None, mark="± ").value


def _wanted(check: LimitCheck) -> Number | str:
    if check.verdict is not Conformity.NOT_PROVABLE:
        return ""
    if check.interval_void:
        return "find the cause first"
    if check.interval is None:
        return "no interval"
    if check.cycles_wanted is None:
        return "no number suffices"
    wanted = Number(check.cycles_wanted)
    return f"over {wanted}" if check.cycles_wanted >= MOST_CYCLES else wanted


def _would_prove(checks: Sequence[LimitCheck], analysis: Analysis) -> str:
    """Return what would: so many cycles, to two digits, or a finer dial where none would.

    No number of them, where something else than scatter is in the readings. Where a figure is
    outside its limit, more cycles would prove that it fails.
    """
    if any(one.code in _OPEN_CAUSES for one in analysis.findings):
        return "find the cause first"
    if analysis.cycles.used < FEWEST_FOR_INTERVAL:
        return f"an interval takes {FEWEST_FOR_INTERVAL} cycles that count"
    open_ = [one for one in checks if one.verdict is Conformity.NOT_PROVABLE]
    wanted = [one.cycles_wanted for one in open_ if one.cycles_wanted is not None]
    if len(wanted) < len(open_):
        return "more cycles would not suffice, a finer or better calibrated dial may"
    outside = [one.cycles_wanted or 0 for one in open_ if not one.inside]
    most = min(outside) if outside else max(wanted, default=0)
    what = " to prove that it fails" if outside else ""
    if most >= MOST_CYCLES:
        return f"it takes more than {MOST_CYCLES} cycles{what}"
    magnitude = 10 ** max(len(str(most)) - 2, 0)
    return f"it takes about {math.ceil(most / magnitude) * magnitude} cycles{what}"


def _figures_by_limit(checks: Sequence[LimitCheck]) -> str:
    by_limit: dict[str, list[LimitCheck]] = {}
    for check in checks:
        by_limit.setdefault(str(limit_cell(check)), []).append(check)
    return "; ".join(f"{_figures_of(kept)}, limit {limit}" for limit, kept in by_limit.items())


def _figures_of(checks: Sequence[LimitCheck]) -> str:
    poses: dict[str, list[str]] = {}
    for check in checks:
        poses.setdefault(check.figure, []).append(check.pose or "")
    if not any(check.pose for check in checks):
        return ", ".join(poses)
    return "; ".join(f"{figure} at {', '.join(labels)}" for figure, labels in poses.items())


def estimate_result(one: Characteristic, unit: str = "") -> Result:
    """Return a figure with its interval."""
    estimate, limit = one.estimate, None if one.limit is None else one.limit.limit
    ends, n, mark = estimate.interval, estimate.n, "± " if one.half_width else ""
    return result(estimate.value, ends, unit, n=n, limit=limit, mark=mark)


def _decided(one: Characteristic) -> Result:
    if (check := one.limit) is None:
        return estimate_result(one)
    verdict, tone = VERDICTS[check.verdict]
    return replace(estimate_result(one), verdict=verdict + _drift(check), tone=tone)


_COLUMNS = 8
"""Of characteristics, beside which a page has room for those of pose and conditions."""
_PAIRS = 3
"""More results of one characteristic than these are given by the one that decides."""
_COVERED_BY = {"X": ("XY", "XYZ"), "Y": ("XY", "XYZ"), "XY": ("XYZ",), "Z": ("XYZ",)}
"""Which figures stand for others; of RP, plane and height are what a robot is bought by."""

_Key = tuple[str, str]
"""Code of a characteristic, and of what."""
_Row = tuple[tuple[str, ...], Mapping[_Key, Characteristic]]
"""Labels of conditions and pose, and the figures there."""
_Stated = tuple[Mapping[str, str], Characteristic, int]
"""Conditions, a figure there, and of how many results it is the one that decides."""


@dataclass(frozen=True, slots=True)
class ResultPart:
    """What was measured under one set of conditions, such as ``{"velocity": "50 %"}``.

    ``poses`` are the labels of those that were measured.
    """

    characteristics: Sequence[Characteristic]
    """The figures under these conditions."""
    poses: Sequence[str | None]
    conditions: Mapping[str, str] = field(default_factory=dict)
    """By name, as they are shown."""

    @classmethod
    def of(cls, analysis: Analysis, under: Condition | None = None) -> ResultPart:
        """Return all that was measured in an analysis, ``under`` one of several conditions."""
        labels = tuple(pose.label for pose in analysis.poses)
        shown = {"velocity": f"{under.velocity:g} %", "load": f"{under.load:g} %"} if under else {}
        return cls(analysis.characteristics, labels, shown)


def result_tables(parts: Sequence[ResultPart]) -> Iterator[Block]:
    """Yield pose by characteristic, and below it what is of no single pose, or at few of them.

    Of one pose alone each characteristic has a row. What `_COVERED_BY` another figure is left to
    the appendix, where its verdict is the same.
    """
    rows: list[_Row] = [
        ((*part.conditions.values(), pose or ""), found)
        for part in parts
        for pose in part.poses
        if (found := {(c.code, c.of): c for c in part.characteristics if c.pose == pose})
    ]
    poses = list(dict.fromkeys(label for part in parts for label in part.poses))
    every = dict.fromkeys(key for _, found in rows for key in found)
    common = [key for key in every if 2 * sum(key in found for _, found in rows) > len(rows) > 1]
    shown = [key for key in common if not _is_covered(key, rows)]
    shown.sort(key=lambda key: (not key[0].startswith("RP"), key[0]))
    names = list(dict.fromkeys(name for part in parts for name in part.conditions))
    for k in range(0, len(shown), _COLUMNS):
        yield _matrix([*names, "pose"], rows, shown[k : k + _COLUMNS])
    others = [
        (part.conditions, one)
        for part in parts
        for one in part.characteristics
        if (one.code, one.of) not in common or one.pose not in poses
    ]
    if others:
        yield _list(names, list(_that_decide(others)), many=len(poses) > 1)


def _is_covered(key: _Key, rows: Sequence[_Row]) -> bool:
    """Whether a column decides no more than one that stands for it, which is there in each row."""
    code, of = key
    by = [(code, one) for one in _COVERED_BY.get(of, ())]
    if code in ("RP", "RP_rss"):
        by = [("RP", "XY")] if code == "RP_rss" or of in ("X", "Y") else []
    mine = [found for _, found in rows if key in found]
    return any(
        all(plane in found and _agree(found[key].limit, found[plane].limit) for found in mine)
        for plane in by
    )


def _agree(one: LimitCheck | None, plane: LimitCheck | None) -> bool:
    if one is None or plane is None:
        return one is None
    return one.limit == plane.limit and one.verdict is plane.verdict


def _matrix(labels: Sequence[str], rows: Sequence[_Row], keys: Sequence[_Key]) -> Table:
    body: list[tuple[Cell, ...]] = [
        (*of, *(_decided(found[key]) if key in found else "" for key in keys)) for of, found in rows
    ]
    each = [[found[key] for _, found in rows if key in found] for key in keys]
    limits = [next((limit_cell(one.limit) for one in some if one.limit), "") for some in each]
    if any(limits):
        body.append(("limit", *[""] * (len(labels) - 1), *limits))
    heads = [some[0] for some in each]
    return Table((*labels, *map(_column_name, heads)), tuple(body), _note(heads))


def _list(names: Sequence[str], found: Sequence[_Stated], *, many: bool) -> Table:
    rows: list[dict[str, Cell]] = []
    limited = any(one.limit for _, one, _ in found)
    for conditions, one, number in found:
        row: dict[str, Cell] = {"characteristic": _column_name(one)}
        row |= {name: conditions.get(name, "") for name in names}
        if many:
            row["pose"] = f"{one.pose or ''}{f' (decides, of {number})' if number > 1 else ''}"
        row[FIGURE] = estimate_result(one)
        if limited:
            row["limit"] = "" if one.limit is None else limit_cell(one.limit)
            row["verdict"] = _decided(one).verdict
        rows.append(row)
    return Table.by_name(rows, _note([one for _, one, _ in found]))


def _column_name(one: Characteristic) -> str:
    """Return what a figure is called on page 1: ``RP XY [mm]``, ``lost motion joint [arcmin]``."""
    name = _of_eq_23(one) or f"{one.code} {one.of}"
    return f"{words(name) if one.code.islower() else name} [{one.estimate.unit}]"


def _of_eq_23(one: Characteristic) -> str:
    return f"{one.of}{OF_EQ_23}" if one.code == "RP_rss" else ""


def _that_decide(
    found: Sequence[tuple[Mapping[str, str], Characteristic]],
) -> Iterator[_Stated]:
    """Yield each with 1; of many results of one characteristic the gravest, with their number."""
    groups: dict[object, list[tuple[Mapping[str, str], Characteristic]]] = {}
    for conditions, one in found:
        key = (tuple(conditions.items()), one.code, one.of)
        groups.setdefault(key, []).append((conditions, one))
    for group in groups.values():
        if len(group) > _PAIRS:
            yield (*max(group, key=lambda stated: _gravity(stated[1])), len(group))
        else:
            yield from ((*stated, 1) for stated in group)


def _gravity(one: Characteristic) -> tuple[int, float]:
    gravity = 0 if one.limit is None else -STRICTEST.index(one.limit.verdict)
    return (gravity, abs(one.estimate.value))


def _note(found: Iterable[Characteristic]) -> str:
    clauses: dict[str, dict[str, None]] = {}
    numbers: dict[str, list[int]] = {}
    for one in found:
        code, clause = words(one.code) if one.code.islower() else one.code, one.estimate.clause
        if one.code == "RP" and one.of in AXES:  # the estimate has the clause that allows it
            code, clause = "RP of one axis", "paper eq. 2-6"
        code = _of_eq_23(one) or code
        clauses.setdefault(clause, {})[code] = None
        numbers.setdefault(one.counted, []).append(one.estimate.n)
    text = "; ".join(f"{', '.join(codes)}: {clause}" for clause, codes in clauses.items())
    spans = {what: dict.fromkeys((min(n), max(n))) for what, n in numbers.items()}
    of = listed([f"{' to '.join(map(str, span))} {what}" for what, span in spans.items()])
    return f"figure and its 95 % interval, of {of}; {text}"
