"""Right pose, nothing lost, nothing invented: robots that are heard badly, and strangers.

Prints the tables of benchmarks/results/robot_line.md.
``python benchmarks/robot_line.py --sessions 300`` records
sessions over a socket of this machine. The dial shows which pose the arm is at and how often it
has arrived, so that each reading says where and when it was taken. ``--visits 300`` times the
answer: from the bytes of the last gauge to ``OK``, beside a bare write and fsync of such a line.
"""

from __future__ import annotations

import argparse
import os
import random
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from itertools import product
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support")]

from controllers import Dial  # noqa: E402
from robots import Arm, Serving, close_all  # noqa: E402

from scara_iso import Run  # noqa: E402

POSES = ("P1", "P2", "P3")
CYCLES = 4
FAULTS = ("none", "dropped", "answer lost", "doubled", "late", "foreign", "hostile")
HOSTILE = (
    b"AT P9 cycle=1\n", b"AT ../P1 cycle=1\n", b"AT P1 cycle=-1\n", b"AT P1 cycle=1 X=9\n",
    b"AT P1 cycle=99\n", b"\xff\xfe\x00 AT P1\n", b"AT P1" + b" x" * 400 + b"\n",
    b"AT P1 a=1 a=2\n", b"HELLO program=00000000\n", b"OK 1\n", b"END now\n", b"AT P1 T1=nan\n",
)  # fmt: skip


class Robot:
    """An arm that asks again until a visit is answered, on a line with faults."""

    def __init__(self, serving: Serving, dial: Dial, chance: random.Random) -> None:
        self.arm = Arm(serving.where)
        self._dial = dial
        self._chance = chance
        self.answers: Counter[str] = Counter()

    def visit(self, pose: str, cycle: int, following: str, fault: str) -> None:
        """Bring the arm to a pose and say so, with a fault on the way."""
        self._dial.move(pose)
        line = f"AT {pose} cycle={cycle}"
        if fault == "dropped":
            self.arm.send(f"{line}\n".encode()[: self._chance.randrange(1, len(line) + 2)])
        elif fault in ("doubled", "late"):
            again = line if fault == "doubled" else f"AT {following} cycle={cycle}"
            self.arm.send(f"{line}\n{again}\n".encode())
            self._hear()
            self._hear()
        elif fault == "foreign":
            self._stranger()
        elif fault == "hostile":
            self.arm.send(self._chance.choice(HOSTILE))
            self._hear()
        elif fault == "answer lost":
            self.arm.says(line)
        if fault in ("dropped", "answer lost"):
            self.arm.leave()
            self.arm = Arm(self.arm.where)
        answer = self.arm.says(line)
        while answer != f"OK {cycle}":
            self.answers[answer[:2]] += 1
            answer = self.arm.says(line)

    def _hear(self) -> None:
        self.answers[self.arm.answer()[:2]] += 1

    def _stranger(self) -> None:
        other = Arm(self.arm.where)
        other.send(f"AT {POSES[0]} cycle=1")
        self.answers[other.answer()[:2]] += 1
        other.leave()


def session(folder: Path, seed: int, fault: str) -> tuple[Run, Dial]:
    """Record a session with a fault at every third visit, on average."""
    chance, dial = random.Random(seed), Dial()  # noqa: S311 - faults, no secrets
    serving = Serving(folder / "run.csv", poses=POSES, cycles=CYCLES, gauge=dial.gauge)
    robot = Robot(serving, dial, chance)
    robot.arm.says(f"HELLO poses={len(POSES)} cycles={CYCLES}")
    visits = list(product(range(1, CYCLES + 1), POSES))
    for k, (cycle, pose) in enumerate(visits):
        following = visits[(k + 1) % len(visits)][1]
        robot.visit(pose, cycle, following, fault if chance.random() < 1 / 3 else "none")
    robot.arm.says("END")
    run = serving.ended()
    close_all()
    return run, dial


def judged(run: Run) -> Iterator[str]:
    """Yield what is wrong with a table: a reading at another pose, one lost, one invented."""
    poses = [] if run.pose is None else run.pose.tolist()
    rows = list(zip(run.cycle.tolist(), poses, strict=True))
    wanted = set(product(range(1, CYCLES + 1), POSES))
    yield from ["lost"] * len(wanted - set(rows))
    yield from ["invented"] * (len(rows) - len(wanted & set(rows)))
    for (cycle, pose), value in zip(rows, run.axes["X"].readings.tolist(), strict=True):
        if int(value) != int(pose[1]) or round(value % 1 * 1000) != cycle:
            yield "wrong"


def faults(sessions: int) -> None:
    """Print a row for each kind of fault."""
    print("| fault at each third visit | sessions | readings | wrong pose | lost | invented |")
    print("|---|---|---|---|---|---|")
    for number, fault in enumerate(FAULTS[1:]):
        found: Counter[str] = Counter()
        share = [seed for seed in range(sessions) if seed % (len(FAULTS) - 1) == number]
        readings = 0
        for seed in share:
            with tempfile.TemporaryDirectory() as folder:
                run, _ = session(Path(folder), seed, fault)
            readings += len(run)
            found.update(judged(run))
        cells = (found["wrong"], found["lost"], found["invented"])
        print(f"| {fault} | {len(share)} | {readings} | {' | '.join(map(str, cells))} |")


class TimedDial(Dial):
    """A dial that knows when its last bytes left, and when its last reading did [s]."""

    sent = read = 0.0

    def answer(self, request: bytes) -> bytes:
        """Return its answer, which is sent in the next microseconds."""
        self.sent = time.perf_counter()
        if not request.startswith(b"UNI"):
            self.read = self.sent
        return bytes(super().answer(request))


def answer_times(visits: int) -> None:
    """Print how long the answer takes, and how long a bare write and fsync of the same bytes.

    The recorder is a process of its own, as at a bench; the dial and the robot are this one.
    """
    with tempfile.TemporaryDirectory(dir=ROOT) as place:
        folder, dial = Path(place), TimedDial()
        with socket.create_server(("127.0.0.1", 0)) as free:
            where = free.getsockname()
        words = ["record", str(folder / "run.csv"), "--quiet", "--cycles", str(visits)]
        words += ["--gauge", dial.gauge, "--trigger", f"listen://127.0.0.1:{where[1]}"]
        recorder = subprocess.Popen([sys.executable, "-m", "scara_iso", *words], cwd=ROOT)
        arm, taken = connected(where), []
        arm.says(f"HELLO poses=1 cycles={visits}")
        line = b'{"event":"stored","cycle":5,"pose":"P1","axis":"X","text":"1.001"}\n'
        file = os.open(folder / "bare", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        for cycle in range(1, visits + 1):
            dial.move("P1")
            began = time.perf_counter()
            arm.says(f"AT P1 cycle={cycle}")
            answered = time.perf_counter()
            time.sleep(answered - began)  # a flush right behind another is a cheap one
            bare = time.perf_counter()
            os.write(file, line)
            os.fsync(file)
            bare = time.perf_counter() - bare
            taken.append((answered - dial.sent, answered - dial.read, bare))
        os.close(file)
        arm.says("END")
        close_all()
        recorder.wait(30)
    last, reading, bare = (1000 * statistics.median(one) for one in zip(*taken, strict=True))
    # visit by visit: a disk may be slow and fast by turns
    times = [statistics.median(one[k] / one[2] for one in taken) for k in (0, 1)]
    print("\n| to OK, median | [ms] | times a bare write and fsync |")
    print("|---|---|---|")
    print(f"| from the last bytes of the gauge, its unit | {last:.2f} | {times[0]:.1f} |")
    print(f"| from those of its reading | {reading:.2f} | {times[1]:.1f} |")
    print(f"| bare write and fsync | {bare:.2f} | 1 |")


def connected(where: tuple[str, int]) -> Arm:
    """Return the robot's end of the line, once the recorder listens."""
    for _ in range(200):
        with suppress(OSError):
            return Arm(where)
        time.sleep(0.1)
    raise TimeoutError


def main() -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sessions", type=int, default=300)
    parser.add_argument("--visits", type=int, default=300)
    given = parser.parse_args()
    if given.sessions:
        faults(given.sessions)
    if given.visits:
        answer_times(given.visits)


if __name__ == "__main__":
    main()
