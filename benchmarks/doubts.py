"""False doubt: readings named as perhaps sent twice, on dials that repeat them by chance.

Prints a table of benchmarks/results/durability.md. ``python benchmarks/doubts.py --sessions 60``
records 60 sessions of each kind on two to four simulated gauges, whose readings scatter by 0.01 mm,
and a clock of their own, the same each time. Only where frames are lost and sent twice may one be
named rightly.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import line_faults
from line_faults import KEYS, LEVEL, Faults, Instrument, Row

from scara_iso import read_table
from scara_iso.recorder.indicators import find_dialect
from scara_iso.recorder.ports.port import StreamClock

SCATTER = 0.01
DIALS = (0.01, 0.001)
KINDS = (
    Row("no fault", Faults()),
    *(row for row in line_faults.TESTS if not row.must_stop),
)


@dataclass
class Dial(Instrument):
    """Shows a scattering value in steps; the same each time that a frame is sent."""

    step: float = DIALS[0]
    name: str = ""

    def _frame(self, number: int) -> bytes:
        value = LEVEL + random.Random(f"{self.name} {number}").gauss(0, SCATTER)  # noqa: S311
        shown = round(value / self.step) * self.step
        return self.dialect.compose(f"{shown:.3f}", None, self.dialect.channel)


def _named(row: Row, seed: int, step: float) -> tuple[int, int]:
    """Record once; return how many readings are named, and how many there are."""
    rng = random.Random(f"{row.test} {seed}")  # noqa: S311 - faults, not secrets
    clock = StreamClock(paced=False)
    made = {
        axis: Dial(
            clock,
            find_dialect(KEYS[axis]),
            row.faults,
            rng,
            row.data,
            step=step,
            name=f"{axis} {seed}",
        )
        for axis in list(KEYS)[: 2 + seed % 3]
    }
    with tempfile.TemporaryDirectory() as name:
        row._record(Path(name), made, clock)
        table = Path(name) / "run.csv"
        if not table.exists():
            return 0, 0
        run = read_table(table)
    return run.metadata.get("record_doubted", "").count("cycle"), len(run.cycle) * len(made)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sessions", type=int, default=60, help="of each kind")
    options = parser.parse_args()
    print("| line | dial [mm] | sessions | readings | sessions that name some | readings named |")
    print(f"|{'---|' * 6}")
    for row in KINDS:
        for step in DIALS:
            found = [_named(row, seed, step) for seed in range(options.sessions)]
            named, readings = (sum(column) for column in zip(*found, strict=True))
            cells = (row.test, step, len(found), readings, sum(n > 0 for n, _ in found), named)
            print(f"| {' | '.join(map(str, cells))} |", flush=True)


if __name__ == "__main__":
    main()
