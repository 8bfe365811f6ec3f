"""What survives: kills, power cuts, disks that fail or fill; and a long session's memory.

Prints a table of benchmarks/results/durability.md. ``benchmarks/durability.py --kills 1000``;
``--only kills`` or another row's word for one row; ``--hours 8`` adds the long session.
Needs fork and SIGKILL (Linux, macOS).
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support")]

from bench import run_session  # noqa: E402
from disks import Disk, FailingDisk, FullDisk, LoggedDisk, UnsyncedDisk, crash_states  # noqa: E402

from scara_iso import read_table  # noqa: E402
from scara_iso.base.errors import ScaraIsoError  # noqa: E402
from scara_iso.rawfile import raw_path, read_history  # noqa: E402
from scara_iso.recorder import Stored  # noqa: E402

GAUGES = ["X=opto-rs232@sim:?pace=0", "Y=mitutoyo-mux@sim:?pace=0"]
FOUR = [*GAUGES, "Z=cdi-starrett-iq@sim:?pace=0", "theta=heidenhain-nd@sim:?pace=0"]
KILLS_PER_FOLDER = 25
MOST_ANNOUNCED = 20
LONGEST_LIFE_S = 0.05


@dataclass
class Row:
    """One line of the table: how often, how many readings were announced, lost, unreadable."""

    what: str
    trials: int = 0
    announced: int = 0
    lost: int = 0
    unreadable: int = 0

    def judge(self, told: dict[tuple[str, int], float], folder: Path) -> None:
        """Count what was announced and is not to be read from the folder."""
        self.trials += 1
        self.announced += len(told)
        try:
            raw = raw_path(folder / "run.csv")
            history = read_history(raw) if raw.exists() else None
            kept = history.readings() if history else {}
            if history is not None and history.header:
                history.check()
        except ScaraIsoError:
            self.unreadable += 1
            return
        self.lost += sum(kept.get(axis, {}).get(c) != value for (axis, c), value in told.items())

    def __str__(self) -> str:
        return (
            f"| {self.what} | {self.trials} | {self.announced} | {self.lost} | {self.unreadable} |"
        )


def readings(said: list[object]) -> dict[tuple[str, int], float]:
    """Return what the listener was told is stored."""
    return {(s.axis, s.cycle): s.value for s in said if isinstance(s, Stored)}


def kills(count: int, folder: Path) -> Row:
    """Kill a recording process at random moments; each one goes on with the file of the last."""
    row, rng = Row("kill -9 at a random moment"), random.Random(20261121)  # noqa: S311
    told: dict[tuple[str, int], float] = {}
    _record_once(folder / "warm")
    for k in range(count):
        place = folder / f"kill{k // KILLS_PER_FOLDER}"
        if k % KILLS_PER_FOLDER == 0:
            told = {}
            place.mkdir()
        life = rng.uniform(0.0, LONGEST_LIFE_S)
        new = _record_until_killed(place, rng.randrange(MOST_ANNOUNCED), life)
        told |= new
        row.judge(told, place)
        row.announced -= len(told) - len(new)  # each reading counts once
    return row


def _record_once(place: Path) -> None:
    """Import what a session uses, so that the kills of the forks meet the recording."""
    place.mkdir()
    run_session(place, GAUGES, cycles=1, disk=Disk())


def _record_until_killed(place: Path, announced: int, life: float) -> dict[tuple[str, int], float]:
    """Kill a recording ``life`` seconds after it announced so many readings."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        _record_for_ever(place, writer)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        said = "".join(pipe.readline() for _ in range(announced))
        time.sleep(life)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        said += pipe.read()
    lines = [line.split() for line in said.split("\n")[:-1]]
    return {(axis, int(cycle)): float(value) for axis, cycle, value in lines}


def _record_for_ever(place: Path, pipe: int) -> None:
    def tell(said: object) -> None:
        if isinstance(said, Stored):
            os.write(pipe, f"{said.axis} {said.cycle} {said.value!r}\n".encode())

    try:
        resume = raw_path(place / "run.csv").exists()
        run_session(
            place,
            GAUGES,
            trigger="timer:0.001",
            cycles=10**6,
            resume=resume,
            tell=tell,
            disk=Disk(),
        )
    finally:
        os._exit(1)


def power_cuts(folder: Path) -> Row:
    """Cut the power after every operation of a session that was resumed once."""
    row, disk, live = Row("power cut (simulated)"), LoggedDisk(), folder / "live"
    live.mkdir()
    for cycles in (3, 6):
        run_session(live, GAUGES, cycles=cycles, resume=cycles > 3, disk=disk, tell=disk.announce)
    for end in range(len(disk.log) + 1):
        told = readings([what[1] for what in disk.log[:end] if what[0] == "said"])
        for _, files in crash_states([w for w in disk.log[:end] if w[0] != "said"]):
            after = folder / f"cut{row.trials}"
            after.mkdir()
            for path, data in files.items():
                (after / path.name).write_bytes(data)
            row.judge(told, after)
            if raw_path(after / "run.csv").exists():
                run_session(after, GAUGES, cycles=7, resume=True, disk=UnsyncedDisk())
                row.unreadable += len(read_table(after / "run.csv")) != 7
    return row


def failures(folder: Path) -> Row:
    """Let the n-th operation fail, for every n."""
    row = Row("n-th disk operation fails, every n")
    for n in range(10_000):
        place, disk = folder / f"fail{n}", FailingDisk(n)
        place.mkdir()
        _record_till_error(place, disk)
        if disk.failed is None:
            break
        row.judge(readings(run_session.said), place)
    return row


def full_disks(folder: Path) -> Row:
    """Give the disk room for every number of bytes that a short session needs, 7 apart."""
    row = Row("disk full after n bytes")
    for room in range(0, 4000, 7):
        place = folder / f"full{room}"
        place.mkdir()
        _record_till_error(place, FullDisk(room))
        row.judge(readings(run_session.said), place)
    return row


def _record_till_error(place: Path, disk: object) -> None:
    try:
        run_session(place, GAUGES, cycles=4, disk=disk)
    except ScaraIsoError:
        return


def long_session(hours: float, folder: Path) -> Iterator[str]:
    """Record four gauges at 10 readings a second in simulated time; yield what it took."""
    cycles = round(hours * 3600 * 10 / 4)
    marks: list[tuple[int, int]] = []

    def tell(said: object) -> None:
        if isinstance(said, Stored) and said.axis == "X" and said.cycle % (cycles // 8) == 0:
            marks.append((said.cycle, _resident_kb()))
        run_session.said.clear()

    start = time.perf_counter()
    run_session(folder, FOUR, trigger="timer:0.4", cycles=cycles, tell=tell, disk=Disk())
    took = time.perf_counter() - start
    rows = len(read_history(raw_path(folder / "run.csv")).times)
    yield f"{4 * rows} readings of 4 gauges, {hours:g} simulated hours, in {took:.0f} s"
    yield from (f"  after {4 * cycle} readings: {kb / 1024:.1f} MB resident" for cycle, kb in marks)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    yield f"  highest, with the table written: {peak:.1f} MB"


def _resident_kb() -> int:
    text = Path("/proc/self/statm").read_text(encoding="ascii")
    return int(text.split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


def main() -> int:
    """Print the table; exit 1 where anything was lost, or a row announced nothing to lose."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--only", choices=["kills", "cuts", "failures", "full", "hours"])
    parser.add_argument("--hours", type=float, default=0.0)
    options = parser.parse_args()
    jobs = {
        "kills": lambda folder: kills(options.kills, folder),
        "cuts": power_cuts,
        "failures": failures,
        "full": full_disks,
    }
    rows = []
    print("| what | trials | readings announced | lost | sessions unreadable |")
    print("|---|---|---|---|---|")
    for name, job in jobs.items():
        if options.only in (None, name):
            with tempfile.TemporaryDirectory() as folder:
                rows.append(job(Path(folder)))
            print(rows[-1], flush=True)
    if options.hours:
        with tempfile.TemporaryDirectory() as folder:
            for line in long_session(options.hours, Path(folder)):
                print(line, flush=True)
    return int(any(row.lost or row.unreadable or not row.announced for row in rows))


if __name__ == "__main__":
    sys.exit(main())
