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
    Cell,
    Interval,
    Number,
    Result,
    Section,
    Table,
    Text,
    U_of_scatter,
    decimals,
    places,
    places_that_decide,
    words,
)
from scara_iso.tables import listed

_USUAL = ("mm", "deg")
_FIGURES = "In mm; an angle in degrees, by ± 3 s. XY by 7.2.2, XY_eq23 by eq. 23 of the paper. "
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
        yield Text(f"FAIL: OUTSIDE the limit {how}: {figures_by_limit(failed)}", "bad")
    if open_:
        yield Text(
            f"NOT PROVABLE with these cycles: {figures_by_limit(open_)}; "
            f"{_would_prove(open_, analysis)}",
            "warn",
        )
    if analysis.conformity is Conformity.PASS:
        yield Text(f"PASS: inside the limits {how}: {figures_by_limit(analysis.limits)}", "good")
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
        RP, *text = (Number(value, f".{places}f") for value in (check.RP, *ends))
        interval = Interval(*text) if text else "none"
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


def _name(check: LimitCheck) -> str:
    figure = check.figure if check.unit in _USUAL else f"{check.figure} in {check.unit}"
    return figure if check.pose is None else f"{figure} at {check.pose}"


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
"""More results of one characteristic than these are said by the one that decides."""
_COVERED_BY = {"X": ("XY", "XYZ"), "Y": ("XY", "XYZ"), "XY": ("XYZ",), "Z": ("XYZ",)}
"""Which figures stand for others; of RP, plane and height are what a robot is bought by."""
_TONES = {Conformity.FAIL: "bad", Conformity.NOT_PROVABLE: "warn", Conformity.PASS: "good"}

_Column = tuple[str, str]
"""Code of a characteristic, and of what."""
_Key = tuple[tuple[tuple[str, str], ...], str, str]


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


@dataclass(frozen=True, slots=True)
class _Row:
    labels: tuple[str, ...]
    of: Mapping[_Column, Characteristic]


def result_tables(parts: Sequence[ResultPart]) -> Iterator[Block]:
    """Yield pose by characteristic, and below it what is of no single pose, or at few of them.

    Of one pose alone each characteristic has a row. What `_COVERED_BY` another figure is left to
    the appendix, where its verdict is the same.
    """
    rows = [row for part in parts for row in _rows(part)]
    poses = list(dict.fromkeys(label for part in parts for label in part.poses))
    every = dict.fromkeys(column for row in rows for column in row.of)
    many = [] if len(rows) < 2 else [c for c in every if _is_common(c, rows)]
    shown = sorted((c for c in many if not _is_covered(c, rows)), key=_rank)
    names = list(dict.fromkeys(name for part in parts for name in part.conditions))
    for k in range(0, len(shown), _COLUMNS):
        yield _matrix([*names, "pose"], rows, shown[k : k + _COLUMNS])
    others = [
        (part.conditions, one)
        for part in parts
        for one in part.characteristics
        if (one.code, one.of) not in many or one.pose not in poses
    ]
    if others:
        yield _list(names, _that_decide(others), poses)


def _rows(part: ResultPart) -> Iterator[_Row]:
    labels = tuple(part.conditions.values())
    for pose in part.poses:
        found = {(c.code, c.of): c for c in part.characteristics if c.pose == pose}
        if found:
            yield _Row((*labels, pose or ""), found)


def _is_common(column: _Column, rows: Sequence[_Row]) -> bool:
    return 2 * sum(column in row.of for row in rows) > len(rows)


def _is_covered(column: _Column, rows: Sequence[_Row]) -> bool:
    """Whether a column decides no more than one that stands for it, which is there in each row."""
    code, of = column
    of_it = [("RP", "XY")] if code == "RP_rss" else [(code, one) for one in _COVERED_BY.get(of, ())]
    if code == "RP":
        of_it = [("RP", "XY")] if of in ("X", "Y") else []
    return any(
        all(
            plane in row.of and _agree(row.of[column].limit, row.of[plane].limit)
            for row in rows
            if column in row.of
        )
        for plane in of_it
    )


def _agree(one: LimitCheck | None, plane: LimitCheck | None) -> bool:
    if one is None or plane is None:
        return one is None
    return one.limit == plane.limit and one.verdict is plane.verdict


def _rank(column: _Column) -> tuple[bool, str]:
    return (not column[0].startswith("RP"), column[0])


def _matrix(labels: Sequence[str], rows: Sequence[_Row], columns: Sequence[_Column]) -> Table:
    heads = [next(row.of[c] for row in rows if c in row.of) for c in columns]
    body: list[tuple[Cell, ...]] = [
        (*row.labels, *(_result(row.of.get(column)) for column in columns)) for row in rows
    ]
    limits = [
        next((_limit(row.of.get(c)) for row in rows if _limit(row.of.get(c))), "") for c in columns
    ]
    if any(limits):
        body.append(("limit", *[""] * (len(labels) - 1), *limits))
    header = [_column_name(one) for one in heads]
    return Table((*labels, *header), tuple(body), _note(heads))


def _list(
    names: Sequence[str],
    found: Iterable[tuple[Mapping[str, str], Characteristic, int]],
    poses: Sequence[str | None],
) -> Table:
    rows = []
    many = len(poses) > 1
    for conditions, one, number in found:
        at = f"{one.pose or ''}{f' (decides, of {number})' if number > 1 else ''}"
        rows.append(
            (
                _column_name(one),
                *(conditions.get(name, "") for name in names),
                *((at,) if many else ()),
                *_apart(_result(one)),
                _limit(one),
                "" if one.limit is None else VERDICTS[one.limit.verdict],
            )
        )
    where = (*names, "pose") if many else tuple(names)
    header = ("characteristic", *where, "figure", "95 % interval", "limit", "verdict")
    return Table(header, tuple(rows), _note([one for _, one, _ in found]))


def _column_name(one: Characteristic) -> str:
    """Return what a figure is called on page 1: ``RP XY [mm]``, ``lost motion joint [arcmin]``."""
    name = f"{one.code} {one.of}"
    return f"{words(name) if one.code.islower() else name} [{one.estimate.unit}]"


def _apart(cell: Result | str) -> tuple[Cell, Cell]:
    return (cell.value, cell.interval) if isinstance(cell, Result) else ("", "")


def _that_decide(
    found: Sequence[tuple[Mapping[str, str], Characteristic]],
) -> list[tuple[Mapping[str, str], Characteristic, int]]:
    """Return each with 1; of many results of one characteristic the gravest, with their number."""
    groups: dict[_Key, list[Characteristic]] = {}
    stated: dict[_Key, Mapping[str, str]] = {}
    for conditions, one in found:
        key = (tuple(conditions.items()), one.code, one.of)
        groups.setdefault(key, []).append(one)
        stated[key] = conditions
    parts = []
    for key, group in groups.items():
        if len(group) > _PAIRS:
            parts.append((stated[key], max(group, key=_grave), len(group)))
        else:
            parts += [(stated[key], one, 1) for one in group]
    return parts


def _grave(one: Characteristic) -> tuple[int, float]:
    gravity = 0 if one.limit is None else -STRICTEST.index(one.limit.verdict)
    return (gravity, abs(one.estimate.value))


def _result(one: Characteristic | None) -> Result | str:
    """Return a figure to the second digit of its U, or as many as show its verdict."""
    if one is None:
        return ""
    estimate, check = one.estimate, one.limit
    ends = estimate.interval or ()
    U = (ends[1] - ends[0]) / 2 if ends else U_of_scatter(estimate.value, estimate.n)
    decimals = places(U)
    if check is not None:
        decimals = places_that_decide(check.limit, (estimate.value, *ends), decimals)
    value, *text = (Number(v, f".{decimals}f") for v in (estimate.value, *ends))
    if one.half_width:
        value = Number(value.value, value.spec, mark="± ")
    interval = Interval(*text) if text else ""
    if check is None:
        return Result(value, interval)
    drifts = check.interval_void and check.verdict is not Conformity.FAIL
    verdict = VERDICTS[check.verdict] + (", drift" if drifts else "")
    return Result(value, interval, verdict, _TONES[check.verdict])  # type: ignore[arg-type]  # a dict of tones


def _limit(one: Characteristic | None) -> Number | str:
    return "" if one is None or one.limit is None else limit_cell(one.limit)


def _note(found: Iterable[Characteristic]) -> str:
    clauses: dict[str, list[str]] = {}
    numbers: dict[str, list[int]] = {}
    for one in found:
        code = words(one.code) if one.code.islower() else one.code
        codes = clauses.setdefault(one.estimate.clause, [])
        codes += [] if code in codes else [code]
        numbers.setdefault(one.counted, []).append(one.estimate.n)
    text = "; ".join(f"{', '.join(codes)}: {clause}" for clause, codes in clauses.items())
    of = listed([f"{_range(n)} {what}" for what, n in numbers.items()])
    return f"figure and its 95 % interval, of {of}; {text}"


def _range(numbers: Sequence[int]) -> str:
    low, high = min(numbers), max(numbers)
    return f"{low}" if low == high else f"{low} to {high}"
