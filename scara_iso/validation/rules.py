"""Which cycles count, and how a figure stands to a limit."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from scara_iso.base.errors import DataError
from scara_iso.iso9283 import Counting, analyze
from scara_iso.tables import read_table
from scara_iso.validation.result import ReferenceCheck

_SOURCE = "ISO 9283 7.2: 30 cycles; the paper's 31st, run first and discarded"
_FEW = "docs/repeatability.md: fewer than five cycles have no interval"
_GONE = {"first_cycle_discarded": True}

_GAP = [*range(1, 10), *range(12, 32)]
_CASES: tuple[tuple[str, Sequence[int], Mapping[str, Any], str], ...] = (
    ("31 rows", range(1, 32), {}, "1 discarded, 30 used"),
    ("30 rows from 2", range(2, 32), {}, "none discarded, 30 used"),
    ("30 rows from 1", range(1, 31), {}, "refused: either the first of 31 was discarded"),
    ("30 rows from 1, first gone", range(1, 31), _GONE, "none discarded, 30 used"),
    ("30 rows from 2, first gone", range(2, 32), _GONE, "none discarded, 30 used"),
    ("30 run, rows from 1", range(1, 31), {"cycles": 30, **_GONE}, "none discarded, 30 used"),
    ("30 run, rows from 2", range(2, 32), {"cycles": 30, **_GONE}, "none discarded, 30 used"),
    ("30 run, all count", range(1, 31), {"all_count": True}, "none discarded, 30 used"),
    ("20 run", range(1, 21), {"cycles": 20}, "1 discarded, 19 used"),
    ("one cycle missing", [*range(1, 10), *range(11, 32)], {}, "refused: cycle 10 is missing"),
    (
        "one cycle missing, allowed",
        [*range(1, 10), *range(11, 32)],
        {"allow_gaps": True},
        "1 discarded, 29 used, 10 to 10 missing",
    ),
    (
        "one cycle left",
        [1, 2],
        {"cycles": 2},
        "refused: 1 cycle counts: no scatter can be computed",
    ),
    ("two cycles left", [1, 2, 3], {"cycles": 3}, "1 discarded, 2 used"),
    ("a gap", _GAP, {}, "refused: cycles 10 to 11 are missing"),
    ("a gap, allowed", _GAP, {"allow_gaps": True}, "1 discarded, 28 used, 10 to 11 missing"),
    (
        "from 4, gaps allowed",
        range(4, 32),
        {"allow_gaps": True},
        "none discarded, 28 used, 2 to 3 missing",
    ),
    ("a cycle twice", [*range(1, 10), 9, *range(10, 31)], {}, "refused: cycle 9 is there twice"),
)


def rule_checks() -> Iterator[ReferenceCheck]:
    """Yield what becomes of tables of 31 cycles and others, and of a figure at three limits."""
    for name, numbers, options, expected in _CASES:
        obtained = _counted(numbers, options)
        if expected.startswith("refused") and expected in obtained:
            obtained = expected
        yield ReferenceCheck("procedure", name, _SOURCE, expected, obtained)
    for n, expected in ((4, "none"), (5, "an interval")):
        (pose,) = analyze(read_table(_table(range(1, n + 2))), Counting(cycles=n + 1)).poses
        interval = pose.axes["X"].RP_interval
        obtained = "none" if interval is None else "an interval"
        yield ReferenceCheck("procedure", f"interval of {n} cycles", _FEW, expected, obtained)
    for limit, verdict in ((0.05, "pass"), (0.01, "not-provable"), (0.002, "fail")):
        (check,) = analyze(read_table(_table(range(1, 32))), limits={"X": limit}).limits
        name = f"RP X against {limit:g} mm"
        source = "the 95 % interval inside, about or beyond the limit (ISO/IEC 17025 7.1.3)"
        yield ReferenceCheck("procedure", name, source, verdict, check.verdict.value)


def _counted(numbers: Sequence[int], options: Mapping[str, Any]) -> str:
    try:
        found = analyze(read_table(_table(numbers)), Counting(**options))
    except DataError as error:
        said = error.faults[0].message if error.faults else error.what
        return f"refused: {said[said.index('either') :] if 'either' in said else said}"
    gone = ", ".join(map(str, found.cycles.discarded)) or "none"
    gaps = "".join(f", {first} to {last} missing" for first, last in found.poses[0].missing)
    return f"{gone} discarded, {found.cycles.used} used{gaps}"


def _table(numbers: Sequence[int]) -> bytes:
    rng = random.Random(9283)  # noqa: S311 - readings
    rows = [f"{number},{rng.gauss(0, 0.004):.4f}" for number in numbers]
    return "\n".join(["# unit: mm", "# resolution: 0.0001", "cycle,X", *rows, ""]).encode()
