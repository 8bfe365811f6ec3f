"""Right pose: tours at the DATA key, the keys in random order, with a fault of the line or none.

Prints a table of benchmarks/results/durability.md. ``benchmarks/tours.py --tours 300`` records
300 tours of each kind on two to four simulated gauges and a clock of their own, the same each time.

Every visit has a value of its own at each gauge. After a stop the arm goes back to the pose that
is asked for, and the tour is resumed. A reading is *invented* where no gauge measured it, *at a
wrong pose* where the arm stood at another one, *mixed* where it is of another visit to the pose
than the others of its row, and *lost* where a visit of the tour is not in the table.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from unittest.mock import patch

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support")]

from bench import Orders, Script, run_session  # noqa: E402

from scara_iso import read_table  # noqa: E402
from scara_iso.base.errors import InstrumentError  # noqa: E402
from scara_iso.rawfile import raw_path, read_history  # noqa: E402
from scara_iso.recorder import Quit, Voided, recording  # noqa: E402
from scara_iso.recorder.ports.port import StreamClock  # noqa: E402

AXES = ("X", "Y", "Z", "theta")
POSES = ("P1", "P2", "P3", "P4", "P5")
CYCLES = 4
WAY_S = (4.0, 30.0)
"""Of a way from pose to pose [s]."""
KEYS_S = 0.35
"""Longest time from the first key to the last, of the shortest way."""
UNEVEN = 2.0
"""By so much the pauses of an uneven hand spread, visit by visit; its keys come in a third."""
TWICE_S = (0.6, 1.5)
"""Until a frame comes again, beyond what `--rearm` refuses [s]."""


@dataclass
class Bench:
    """The arm and its gauges: each value is its visit; ``fault`` strikes at ``at``."""

    rng: random.Random
    axes: tuple[str, ...]
    fault: str
    at: int
    uneven: bool = False
    visited: list[int] = field(default_factory=list)
    """The pose of each visit that the arm made."""

    def __post_init__(self) -> None:
        self.ways = [self.rng.uniform(*WAY_S) for _ in POSES]

    def frames(self, first: int) -> dict[str, list[tuple[float, bytes]]]:
        """Go through the tour from visit ``first`` (from 0) on; return what every gauge sends."""
        sent: dict[str, list[tuple[float, bytes]]] = {axis: [] for axis in self.axes}
        time = 1.0
        for visit in range(first, CYCLES * len(POSES)):
            pose = visit % len(POSES)
            longest = (1 / 3 if self.uneven else KEYS_S) * min(self.ways)
            delays = [self.rng.uniform(0.0, longest) for _ in self.axes]
            struck = self.rng.choice(self.axes) if len(self.visited) == self.at else ""
            for axis, delay in zip(self.axes, delays, strict=True):
                text = b"+%03d.%03d\r" % (pose + 1, len(self.visited))
                sent[axis] += self._sent(time + delay, text, self.fault if axis == struck else "")
            self.visited.append(pose)
            time += self.ways[pose] * (self.rng.uniform(1.0, UNEVEN) if self.uneven else 1.0)
        return sent

    def _sent(self, at: float, frame: bytes, fault: str) -> list[tuple[float, bytes]]:
        match fault:
            case "missing":
                return []
            case "sent twice":
                return [(at, frame), (at + self.rng.uniform(*TWICE_S), frame)]
            case "late":
                return [(at + self.rng.uniform(0.5, 1.0) * min(self.ways), frame)]
            case "damaged":
                return [(at, frame[:3] + b"#" + frame[4:])]
        return [(at, frame)]


@dataclass
class Row:
    """One line of the table."""

    fault: str
    uneven: bool = False
    tours: int = 0
    readings: int = 0
    struck: int = 0
    stops: int = 0
    lost: int = 0
    wrong: int = 0
    mixed: int = 0
    invented: int = 0

    def run(self, seed: int) -> None:
        """Record one tour, resumed after every stop, and judge its table."""
        rng = random.Random(f"{self.name} {seed}")  # noqa: S311 - faults, not secrets
        axes = AXES[: 2 + seed % 3]
        bench = Bench(rng, axes, self.fault, rng.randrange(CYCLES * len(POSES)), self.uneven)
        with tempfile.TemporaryDirectory() as name:
            folder, first = Path(name), 0
            while not self._record(
                folder, bench, first, resume=raw_path(folder / "run.csv").exists()
            ):
                self.stops += 1
                raw = raw_path(folder / "run.csv")
                first = read_history(raw).visit - 1 if raw.exists() else 0
            self._judge(folder / "run.csv", bench)
        self.tours += 1

    def _record(self, folder: Path, bench: Bench, first: int, *, resume: bool) -> bool:
        """Return whether the tour came to its end."""
        clock, sent = StreamClock(paced=False), bench.frames(first)
        end = max(time for frames in sent.values() for time, _ in frames) + 60.0

        class UntilTheEnd(Orders):
            def poll(self) -> Quit | None:
                return Quit() if clock.now() >= end else None

        clock.watch(lambda: end if clock.now() < end else math.inf)
        ports = {axis: Script(clock, pushes=sent[axis]) for axis in bench.axes}
        gauges = [f"{axis}=opto-rs232?unit=mm@{axis}" for axis in bench.axes]
        with patch.object(recording, "open_port", lambda *_, axis, **__: ports[axis]):
            try:
                said = run_session(
                    folder, gauges, clock=clock, cycles=CYCLES, trigger="data", poses=POSES,
                    operator=UntilTheEnd(), resume=resume,
                )  # fmt: skip
            except InstrumentError:
                said, ended = run_session.said, False
            else:
                ended = clock.now() < end
        self.struck += sum(isinstance(one, Voided) for one in said)
        return ended

    def _judge(self, table: Path, bench: Bench) -> None:
        run = read_table(table)
        self.lost += CYCLES * len(POSES) - len(run.cycle)
        for row, pose in enumerate(run.pose.tolist()):
            shown = [round(1000 * float(axis.readings[row])) for axis in run.axes.values()]
            visits = [value % 1000 for value in shown]
            known = [v < len(bench.visited) and value // 1000 == bench.visited[v] + 1
                     for v, value in zip(visits, shown, strict=True)]  # fmt: skip
            self.readings += len(shown)
            self.invented += known.count(False)
            self.wrong += sum(f"P{value // 1000}" != pose for value in shown)
            self.mixed += len(set(visits)) > 1

    @property
    def name(self) -> str:
        """What the row is called."""
        return f"{self.fault or 'none'}, uneven" if self.uneven else self.fault

    def __str__(self) -> str:
        cells = (self.name or "none", self.tours, self.readings, self.struck, self.stops,
                 self.lost, self.wrong, self.mixed, self.invented)  # fmt: skip
        return f"| {' | '.join(map(str, cells))} |"


def main() -> int:
    """Print the table; exit 1 where a reading is wrong, or a visit is struck without a fault."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tours", type=int, default=300, help="of each fault")
    parser.add_argument("--first", type=int, default=0, help="seed of the first tour")
    options = parser.parse_args()
    print("| fault | tours | readings | struck | stops | lost | wrong pose | mixed | invented |")
    print(f"|{'---|' * 9}")
    faults = ("", "missing", "sent twice", "late", "damaged")
    rows = [Row(fault, uneven) for uneven in (False, True) for fault in faults]
    for row in rows:
        for seed in range(options.first, options.first + options.tours):
            row.run(seed)
        print(row, flush=True)
    wrong = any(row.wrong or row.mixed or row.invented for row in rows)
    return int(wrong or any(row.struck for row in rows if not row.fault))


if __name__ == "__main__":
    sys.exit(main())
