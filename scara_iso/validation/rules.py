"""Which cycles count, and how a figure stands to a limit."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence

from scara_iso.errors import ScaraIsoError
from scara_iso.iso9283 import analyze
from scara_iso.tables import read_table
from scara_iso.validation.result import ReferenceCheck

_SOURCE = "ISO 9283 7.2: 30 cycles; the paper's 31st, run first and discarded"


def rule_checks() -> Iterator[ReferenceCheck]:
    """Yield what becomes of tables of 31 and 30 rows, and of a figure at three limits."""
    for name, numbers, expected in (
        ("31 rows", range(1, 32), "1 discarded, 30 used"),
        ("30 rows from 2", range(2, 32), "none discarded, 30 used"),
        ("30 rows from 1", range(1, 31), "refused"),
        ("a gap", [*range(1, 10), *range(11, 32)], "refused"),
    ):
        yield ReferenceCheck("procedure", name, _SOURCE, expected, _counted(numbers))
    for limit, verdict in ((0.05, "pass"), (0.01, "not-provable"), (0.002, "fail")):
        (check,) = analyze(read_table(_table(range(1, 32))), limits={"X": limit}).limits
        name = f"RP X against {limit:g} mm"
        source = "the 95 % interval inside, about or beyond the limit (ISO/IEC 17025 7.1.3)"
        yield ReferenceCheck("procedure", name, source, verdict, check.verdict.value)


def _counted(numbers: Sequence[int]) -> str:
    try:
        cycles = analyze(read_table(_table(numbers))).cycles
    except ScaraIsoError:
        return "refused"
    return f"{', '.join(map(str, cycles.discarded)) or 'none'} discarded, {cycles.used} used"


def _table(numbers: Sequence[int]) -> bytes:
    rng = random.Random(9283)  # noqa: S311 - readings
    rows = [f"{number},{rng.gauss(0, 0.004):.4f}" for number in numbers]
    return "\n".join(["# unit: mm", "# resolution: 0.0001", "cycle,X", *rows, ""]).encode()
