"""Figures against the limits that the user gave, and the result table of page 1 with its verdicts.

The table is made from `Analysis.characteristics` alone: a new characteristic needs nothing here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from scara_iso.iso9283 import (
    MOST_CYCLES,
    Analysis,
    Characteristic,
    Conformity,
    DecisionRule,
    LimitCheck,
)
from scara_iso.reporting.blocks import (
    Block,
    Columns,
    Section,
    Table,
    Text,
    table_by_name,
    tabulated,
)
from scara_iso.reporting.digits import (
    Cell,
    Interval,
    Number,
    Result,
    Tone,
    U_of_scatter,
    decimals,
    half_of,
    places,
    places_that_decide,
    words,
)
from scara_iso.tables import listed

_FIGURES = "In mm; an angle in degrees, by ± 3 s. XY by 7.2.2, XY_eq23 by eq. 23 of the paper. "
_INTERVAL = (
    "Pass: the whole 95 % interval of the figure is at most the limit. Fail: all of it is above. "
    "Else these cycles prove neither. Chance, dial and stated calibration are counted; either end "
    "is wrong in one test of forty or fewer with Gaussian scatter. Cycles needed: about this many "
    "in one run would prove it if the true figure is the one read; no number suffices where the "
    "dial hides the scatter, or the calibration alone reaches the limit."
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
TONES: Mapping[Conformity, Tone] = {
    Conformity.PASS: "good",
    Conformity.FAIL: "bad",
    Conformity.NOT_PROVABLE: "warn",
}


def conformity(analysis: Analysis) -> Iterator[Text]:
    """Yield whether the limits are kept, by which rule, and what would prove it."""
    checks = analysis.limits
    void = [one for one in checks if one.interval_void and one.decision is DecisionRule.INTERVAL]
    yield from verdicts(checks, proof="" if void else f"; {_would_prove(checks, analysis)}")
    if void:
        moved = dict.fromkeys(one.axis for one in analysis.findings if one.voids_interval)
        axes = " and ".join(filter(None, moved)) or "The readings"
        yield Text(
            f"{axes} drifted, so the interval of {_figures_of(void)} does not hold. "
            "Find the cause first.",
            "warn",
        )


def verdicts(
    checks: Sequence[LimitCheck], counted: str = "cycles", proof: str = ""
) -> Iterator[Text]:
    """Yield which figures fail and which are open, else that all are inside, and by which rule."""
    by_verdict = {one: [c for c in checks if c.verdict is one] for one in STRICTEST}
    simple = any(check.decision is DecisionRule.SIMPLE for check in checks)
    how = "by simple acceptance" if simple else "with the whole 95 % interval"
    text = {
        Conformity.FAIL: f"FAIL: OUTSIDE the limit {how}",
        Conformity.NOT_PROVABLE: f"NOT PROVABLE with these {counted}",
        Conformity.PASS: f"PASS: inside the limits {how}",
    }
    for verdict, found in by_verdict.items():
        if found and (verdict is not Conformity.PASS or len(found) == len(checks)):
            open_ = proof if verdict is Conformity.NOT_PROVABLE else ""
            yield Text(f"{text[verdict]}: {figures_by_limit(found)}{open_}", TONES[verdict])


def table_of_limits(checks: Sequence[LimitCheck], of_loops: str = "") -> Iterator[Section]:
    """Yield figures against their limits, where there are any; ``of_loops`` is their rule."""
    heading = "RP" if all(check.code.startswith("RP") for check in checks) else "figure"
    columns: Columns[LimitCheck] = {
        "limit of": _name,
        heading: lambda one: _decided(one)[0],
        "95 % interval": lambda one: _decided(one)[1],
        "limit": limit_cell,
        "verdict": lambda one: VERDICTS[one.verdict],
        **({} if of_loops else {"cycles needed": _wanted}),
    }
    simple: Columns[LimitCheck] = {
        "limit of": _name,
        heading: lambda one: _decided(one)[0],
        "limit": limit_cell,
        "guard band": lambda one: "not known" if one.guard is None else _guard_band(one.guard),
        "verdict": lambda one: (
            VERDICTS[one.verdict]
            + (", in the guard band" if one.guard is not None and not one.clear else "")
        ),
    }
    if checks and checks[0].decision is DecisionRule.SIMPLE:
        yield Section("limits", (tabulated(checks, simple, _FIGURES + _SIMPLE),))
    else:
        yield Section("limits", (tabulated(checks, columns, of_loops or _FIGURES + _INTERVAL),))


def _decided(check: LimitCheck) -> tuple[Number, Interval | str]:
    """Return the figure and its interval, with as many places as show on which side they are."""
    ends = check.interval if check.decision is DecisionRule.INTERVAL else None
    found = places_that_decide(check.limit, (check.RP, *(ends or ())), decimals([check.RP]))
    RP, *text = (Number(value, f".{found}f") for value in (check.RP, *(ends or ())))
    return RP, Interval(*text) if text else "none"


def limit_cell(check: LimitCheck) -> Number | str:
    """Return the limit, or the smallest and the largest value that are allowed."""
    if check.lower is None:
        return Number(check.limit, ".15g", check.unit)
    return f"{check.lower:.15g} to {check.limit:.15g} {check.unit}"


def _guard_band(half_width: float) -> Number:
    return Number(half_width, f".{decimals([half_width])}f", mark="± ")


def _wanted(check: LimitCheck) -> Number | str:
    if check.verdict is not Conformity.NOT_PROVABLE:
        return ""
    if check.interval_void:
        return "find the cause first"
    if check.cycles_wanted is None:
        return "no number suffices"
    wanted = Number(check.cycles_wanted)
    return f"over {wanted}" if check.cycles_wanted >= MOST_CYCLES else wanted


def _would_prove(checks: Sequence[LimitCheck], analysis: Analysis) -> str:
    """Return what would: so many cycles, to two digits, or a finer dial where none would.

    No number of them, where something else than scatter is in the readings.
    """
    open_ = [check for check in checks if check.verdict is Conformity.NOT_PROVABLE]
    if any(one.code in _OPEN_CAUSES for one in analysis.findings):
        return "find the cause first"
    wanted = [check.cycles_wanted for check in open_]
    if None in wanted:
        return "more cycles would not, a finer or better calibrated dial may"
    most = max((cycles for cycles in wanted if cycles is not None), default=0)
    if most >= MOST_CYCLES:
        return f"more than {MOST_CYCLES} cycles would"
    magnitude = 10 ** max(len(str(most)) - 2, 0)
    return f"about {math.ceil(most / magnitude) * magnitude} cycles would"


def _name(check: LimitCheck) -> str:
    return check.figure if check.pose is None else f"{check.figure} at {check.pose}"


def figures_by_limit(checks: Sequence[LimitCheck]) -> str:
    """Return each figure with the poses at which it is meant, and its limit."""
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


_COLUMNS = 8
"""Of characteristics, beside which a page has room for those of pose and conditions."""
_PAIRS = 3
"""More results of one characteristic than these are given by the one that decides."""
_COVERED_BY = {"X": ("XY", "XYZ"), "Y": ("XY", "XYZ"), "XY": ("XYZ",), "Z": ("XYZ",)}
"""Which figures stand for others; of RP, plane and height are what a robot is bought by."""

_Column = tuple[str, str]
"""Code of a characteristic, and of what."""
_Row = tuple[tuple[str, ...], Mapping[_Column, Characteristic]]
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
    every = dict.fromkeys(column for _, found in rows for column in found)
    common = [c for c in every if 2 * sum(c in found for _, found in rows) > len(rows) > 1]
    shown = [column for column in common if not _is_covered(column, rows)]
    shown.sort(key=lambda column: (not column[0].startswith("RP"), column[0]))
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


def _is_covered(column: _Column, rows: Sequence[_Row]) -> bool:
    """Whether a column decides no more than one that stands for it, which is there in each row."""
    code, of = column
    by = [(code, one) for one in _COVERED_BY.get(of, ())]
    if code in ("RP", "RP_rss"):
        by = [("RP", "XY")] if code == "RP_rss" or of in ("X", "Y") else []
    mine = [found for _, found in rows if column in found]
    return any(
        all(plane in found and _agree(found[column].limit, found[plane].limit) for found in mine)
        for plane in by
    )


def _agree(one: LimitCheck | None, plane: LimitCheck | None) -> bool:
    if one is None or plane is None:
        return one is None
    return one.limit == plane.limit and one.verdict is plane.verdict


def _matrix(labels: Sequence[str], rows: Sequence[_Row], columns: Sequence[_Column]) -> Table:
    body: list[tuple[Cell, ...]] = [
        (*of, *(_result(found.get(column)) for column in columns)) for of, found in rows
    ]
    each = [[found[column] for _, found in rows if column in found] for column in columns]
    limits = [next((limit for one in some if (limit := _limit(one))), "") for some in each]
    if any(limits):
        body.append(("limit", *[""] * (len(labels) - 1), *limits))
    heads = [some[0] for some in each]
    return Table((*labels, *map(_column_name, heads)), tuple(body), _note(heads))


def _list(names: Sequence[str], found: Sequence[_Stated], *, many: bool) -> Table:
    """Return a row for each figure, with its conditions and, of many poses, with its own."""
    rows: list[dict[str, Cell]] = []
    limited = any(one.limit for _, one, _ in found)
    for conditions, one, number in found:
        at = f"{one.pose or ''}{f' (decides, of {number})' if number > 1 else ''}"
        result, verdict = _result(one), one.limit and VERDICTS[one.limit.verdict]
        row: dict[str, Cell] = {"characteristic": _column_name(one)}
        row |= {name: conditions.get(name, "") for name in names} | ({"pose": at} if many else {})
        if isinstance(result, Result):
            row |= {"figure": result.value, "95 % interval": result.interval}
        rows.append(row | ({"limit": _limit(one), "verdict": verdict or ""} if limited else {}))
    return table_by_name(rows, _note([one for _, one, _ in found]))


def _column_name(one: Characteristic) -> str:
    """Return what a figure is called on page 1: ``RP XY [mm]``, ``lost motion joint [arcmin]``."""
    name = f"{one.code} {one.of}"
    return f"{words(name) if one.code.islower() else name} [{one.estimate.unit}]"


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


def _result(one: Characteristic | None) -> Result | str:
    """Return a figure to the second digit of its U, or as many as show its verdict."""
    if one is None:
        return ""
    estimate, check = one.estimate, one.limit
    ends = estimate.interval or ()
    U = half_of(estimate.interval) if ends else U_of_scatter(estimate.value, estimate.n)
    found = places(U)
    if check is not None:
        found = places_that_decide(check.limit, (estimate.value, *ends), found)
    value, *text = (Number(v, f".{found}f") for v in (estimate.value, *ends))
    if one.half_width:
        value = Number(value.value, value.spec, mark="± ")
    between = Interval(*text) if text else ""
    if check is None:
        return Result(value, between)
    drifts = check.interval_void and check.verdict is not Conformity.FAIL
    verdict = VERDICTS[check.verdict] + (", drift" if drifts else "")
    return Result(value, between, verdict, TONES[check.verdict])


def _limit(one: Characteristic | None) -> Number | str:
    return "" if one is None or one.limit is None else limit_cell(one.limit)


def _note(found: Iterable[Characteristic]) -> str:
    """Return what each figure is counted of, and its clause."""
    clauses: dict[str, dict[str, None]] = {}
    numbers: dict[str, list[int]] = {}
    for one in found:
        code = words(one.code) if one.code.islower() else one.code
        clauses.setdefault(one.estimate.clause, {})[code] = None
        numbers.setdefault(one.counted, []).append(one.estimate.n)
    text = "; ".join(f"{', '.join(codes)}: {clause}" for clause, codes in clauses.items())
    spans = {what: dict.fromkeys((min(n), max(n))) for what, n in numbers.items()}
    of = listed([f"{' to '.join(map(str, span))} {what}" for what, span in spans.items()])
    return f"figure and its 95 % interval, of {of}; {text}"
