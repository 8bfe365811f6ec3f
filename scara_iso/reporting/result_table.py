"""The table that a test is made for: pose by characteristic, with interval, limit and verdict.

It is made from `Analysis.characteristics` alone, so that a new characteristic needs nothing here.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from scara_iso.iso9283 import Characteristic, Conformity, LimitCheck
from scara_iso.reporting.blocks import Block, Cell, Interval, Number, Result, Table
from scara_iso.reporting.digits import U_of_scatter, places, places_that_decide, words
from scara_iso.reporting.limits import VERDICTS, limit_cell
from scara_iso.tables import listed

_COLUMNS = 8
"""Of characteristics, beside which a page has room for those of pose and conditions."""
_PAIRS = 3
"""More results of one characteristic than these are said by the one that decides."""
_COVERED_BY = {"X": ("XY", "XYZ"), "Y": ("XY", "XYZ"), "XY": ("XYZ",), "Z": ("XYZ",)}
"""Which figures stand for others; of RP, plane and height are what a robot is bought by."""
_GRAVITY = (Conformity.FAIL, Conformity.NOT_PROVABLE, Conformity.PASS)
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
    header = [_name(one) for one in heads]
    return Table((*labels, *header), tuple(body), _note(heads))


def _list(
    names: Sequence[str],
    found: Iterable[tuple[Mapping[str, str], Characteristic, int]],
    poses: Sequence[str | None],
) -> Table:
    rows = []
    several = len(poses) > 1
    for conditions, one, number in found:
        at = f"{one.pose or ''}{f' (decides, of {number})' if number > 1 else ''}"
        rows.append(
            (
                _name(one),
                *(conditions.get(name, "") for name in names),
                *((at,) if several else ()),
                *_apart(_result(one)),
                _limit(one),
                "" if one.limit is None else VERDICTS[one.limit.verdict],
            )
        )
    where = (*names, "pose") if several else tuple(names)
    header = ("characteristic", *where, "figure", "95 % interval", "limit", "verdict")
    return Table(header, tuple(rows), _note([one for _, one, _ in found]))


def _name(one: Characteristic) -> str:
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
    said = []
    for key, group in groups.items():
        if len(group) > _PAIRS:
            said.append((stated[key], max(group, key=_grave), len(group)))
        else:
            said += [(stated[key], one, 1) for one in group]
    return said


def _grave(one: Characteristic) -> tuple[int, float]:
    gravity = 0 if one.limit is None else -_GRAVITY.index(one.limit.verdict)
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
    value, *said = (Number(v, f".{decimals}f") for v in (estimate.value, *ends))
    if one.half_width:
        value = Number(value.value, value.spec, mark="± ")
    interval = Interval(*said) if said else ""
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
    said = "; ".join(f"{', '.join(codes)}: {clause}" for clause, codes in clauses.items())
    of = listed([f"{_range(n)} {what}" for what, n in numbers.items()])
    return f"figure and its 95 % interval, of {of}; {said}"


def _range(numbers: Sequence[int]) -> str:
    low, high = min(numbers), max(numbers)
    return f"{low}" if low == high else f"{low} to {high}"
