"""Right cycle, right unit: sessions on instruments that answer late, twice, damaged or not at all.

Prints the table of benchmarks/results/durability.md.
``python benchmarks/line_faults.py --sessions 30`` runs 30
sessions of each test, on two to four simulated gauges and a clock of their own, the same each time.

Each measurement has a value of its own. A reading is wrong where it was measured before the cycle
before it was complete, where a row holds two visits, or where it is not what was measured [mm].
"""

from __future__ import annotations

import argparse
import math
import random
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from unittest.mock import patch

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support")]

from bench import Orders, run_session  # noqa: E402

from scara_iso import read_table  # noqa: E402
from scara_iso.base.errors import ScaraIsoError  # noqa: E402
from scara_iso.recorder import Quit, recording  # noqa: E402
from scara_iso.recorder.indicators import Dialect, find_dialect  # noqa: E402
from scara_iso.recorder.ports.port import Port, StreamClock  # noqa: E402

KEYS = {"X": "opto-rs232", "Y": "mitutoyo-mux", "Z": "opto-rs232-ibr", "theta": "magnescale"}
PERIOD_S = 4.0
CYCLES = 31
LEVEL = 8.0


@dataclass(frozen=True)
class Faults:
    """How often [of one answer] what happens, and at which measurement unit or zero are lost."""

    late: float = 0.0
    doubled: float = 0.0
    damaged: float = 0.0
    apart_s: float = 1.3 * PERIOD_S
    missing: float = 0.0
    inch_from: float = math.inf
    decimals: int = 5
    off_from: float = math.inf


@dataclass(eq=False)
class Instrument(Port):
    """A gauge that measures when asked, or once a visit, and whose line is at fault."""

    clock: StreamClock
    dialect: Dialect
    faults: Faults
    rng: random.Random
    pushes: bool = False
    settle_s: float = 0.15
    address: str = "faulty"
    identity: str = "faulty"
    answered: float = 0.0
    measured: list[float] = field(default_factory=list)
    waiting: list[tuple[float, bytes]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.clock.watch(lambda: min((t for t, _ in self.waiting), default=math.inf))
        for pose in range(2 * CYCLES if self.pushes else 0):
            self._send(pose, 1.0 + PERIOD_S * pose + self.rng.uniform(0.0, 0.8))

    def read(self) -> bytes:
        """Return what is due, in order."""
        now = self.clock.now()
        due = sorted(one for one in self.waiting if one[0] <= now)
        self.waiting = [one for one in self.waiting if one[0] > now]
        return b"".join(data for _, data in due)

    def write(self, data: bytes) -> None:
        """Take a request."""
        if data == self.dialect.request:
            self.measured.append(self.clock.now())
            self._send(len(self.measured) - 1, self.clock.now() + self.rng.uniform(0.01, 0.2))
        elif data == self.dialect.unit_request:
            inch = len(self.measured) > self.faults.inch_from
            at = max(self.clock.now(), self.answered) + 0.02  # one command at a time
            self.waiting.append((at, b"IN\r" if inch else b"MM\r"))

    def _send(self, number: int, at: float) -> None:
        faults, chance = self.faults, self.rng.random
        frame = self._frame(number)
        if number == faults.off_from:
            self.waiting.append((at - 0.005, b"SY270.101\r"))
        if chance() < faults.missing:
            return
        if chance() < faults.late:
            at += self.dialect.answer_time_s * self.rng.uniform(0.9, 4.7)
        self.answered = at
        if chance() < faults.damaged:
            frame = self._damage(frame)
        self.waiting.append((at, frame))
        if chance() < faults.doubled:
            self.waiting.append((at + self.rng.uniform(0.0, faults.apart_s), frame))

    def _frame(self, number: int) -> bytes:
        value, decimals = LEVEL + number / 1000, 3
        if number >= self.faults.inch_from:
            value, decimals = value / 25.4, self.faults.decimals
        if number >= self.faults.off_from:
            value -= LEVEL
        return self.dialect.compose(f"{value:.{decimals}f}", None, self.dialect.channel)

    def _damage(self, frame: bytes) -> bytes:
        at = self.rng.randrange(len(frame) - len(self.dialect.terminator))
        how = self.rng.choice([b"", b"\xff\x00" + frame[at : at + 1], b"#", b"\r"])
        return frame[:at] + how + frame[at + 1 :]


@dataclass
class Row:
    """One line of the table."""

    test: str
    faults: Faults
    data: bool = False
    must_stop: bool = False
    sessions: int = 0
    readings: int = 0
    wrong: int = 0
    stopped: int = 0

    def run(self, seed: int) -> None:
        """Record once, with two to four gauges, and judge every row of the table."""
        rng = random.Random(f"{self.test} {seed}")  # noqa: S311 - faults, not secrets
        axes = list(KEYS)[: 2 + seed % 3]
        clock = StreamClock(paced=False)
        made = {
            axis: Instrument(clock, find_dialect(KEYS[axis]), self.faults, rng, self.data)
            for axis in axes
        }
        with tempfile.TemporaryDirectory() as name:
            stopped = self._record(Path(name), made, clock)
            table = Path(name) / "run.csv"
            wrong, count = _judge(table, made, data=self.data) if table.exists() else (0, 0)
        self.sessions += 1
        self.readings += count
        self.stopped += stopped
        self.wrong += wrong + (self.must_stop and not stopped)

    def _record(self, folder: Path, made: dict[str, Instrument], clock: StreamClock) -> bool:
        gauges = [f"{axis}={KEYS[axis]}?unit=mm@{axis}" for axis in made]
        end = 1.0 + PERIOD_S * 2 * CYCLES

        class UntilTheEnd(Orders):
            def poll(self) -> Quit | None:
                return Quit() if clock.now() >= end else None

        if self.data:
            clock.watch(lambda: end if clock.now() < end else math.inf)
        opened: Callable[..., Instrument] = lambda *_, axis, **__: made[axis]  # noqa: E731
        with patch.object(recording, "open_port", opened):
            try:
                run_session(
                    folder, gauges, clock=clock, cycles=CYCLES,
                    trigger="data" if self.data else f"timer:{PERIOD_S:g}",
                    operator=UntilTheEnd() if self.data else Orders(),
                )  # fmt: skip
            except ScaraIsoError:
                return True
        return False

    def __str__(self) -> str:
        cells = (self.test, self.sessions, self.readings, self.wrong, self.stopped)
        return f"| {' | '.join(map(str, cells))} |"


def _judge(table: Path, made: dict[str, Instrument], *, data: bool) -> tuple[int, int]:
    """Return how many readings of the table are wrong, and how many there are."""
    run = read_table(table)
    wrong = count = 0
    done = -math.inf
    for row, time in enumerate(run.covariates["time_s"].tolist()):
        numbers = {a: _number(float(run.axes[a].readings[row])) for a in made}
        for axis, number in numbers.items():
            count += 1
            if data:
                wrong += number != numbers[next(iter(made))]
            else:
                at = made[axis].measured
                wrong += not (0 <= number < len(at) and done < at[number] <= time + 0.001)
        done = time
    return wrong, count


def _number(reading: float) -> int:
    """Return which measurement a reading is; -1 for a value that was never measured."""
    number = (reading - LEVEL) * 1000
    return round(number) if abs(number - round(number)) < 0.01 and number > -0.5 else -1


TESTS = (
    Row("late answers", Faults(late=0.1)),
    Row("doubled answers, up to 5 s apart", Faults(doubled=0.2)),
    Row("damaged answers", Faults(damaged=0.1)),
    Row("missing answers", Faults(missing=0.06)),
    Row("all of these", Faults(late=0.04, doubled=0.05, damaged=0.04, missing=0.03)),
    Row("mm to inch, five decimals", Faults(inch_from=12), must_stop=True),
    Row("mm to inch, three decimals", Faults(inch_from=12, decimals=3), must_stop=True),
    Row("switched off and on", Faults(off_from=12), must_stop=True),
    Row("DATA key: doubled, up to 1.5 s apart", Faults(doubled=0.1, apart_s=1.5), data=True),
    Row("DATA key: damaged", Faults(damaged=0.1), data=True),
    Row("DATA key: missing", Faults(missing=0.06), data=True),
)


def main() -> int:
    """Print the table; exit 1 where a reading is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sessions", type=int, default=30, help="of each test")
    options = parser.parse_args()
    print("| test | sessions | readings in tables | failures | stopped and said so |")
    print("|---|---|---|---|---|")
    for row in TESTS:
        for seed in range(options.sessions):
            row.run(seed)
        print(row, flush=True)
    return int(any(row.wrong for row in TESTS))


if __name__ == "__main__":
    sys.exit(main())
