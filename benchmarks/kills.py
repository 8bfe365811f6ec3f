"""What a kill, a signal or a full disk leaves of a file being written: the old or the new one.

Prints the table of benchmarks/results/durability.md.
``python benchmarks/kills.py --kills 1000``. Needs fork,
SIGKILL and RLIMIT_FSIZE (Linux, macOS). The processes are forks of this one, which has imported
everything and diagnosed the table once: a kill meets the writing and not what goes before it.
After SIGTERM and SIGINT no part of a file may be left; its code is 130, or 0 if it was done.
"""

from __future__ import annotations

import argparse
import builtins
import io
import json
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import chdir, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ["OPENBLAS_NUM_THREADS"] = "1"

from scara_iso import Run  # noqa: E402
from scara_iso.base import process  # noqa: E402
from scara_iso.base.errors import ScaraIsoError  # noqa: E402
from scara_iso.base.files import Disk  # noqa: E402
from scara_iso.commands import main as scara_iso, selftest as selftests  # noqa: E402
from scara_iso.commands.operator.guide import Terminal  # noqa: E402
from scara_iso.diagnosis import closed_loop as closing  # noqa: E402
from scara_iso.fleets import engines, screening  # noqa: E402
from scara_iso.rawfile import raw_path, read_history  # noqa: E402
from scara_iso.recorder import rebuild  # noqa: E402

EXAMPLES = ROOT / "examples"
MODEL, TABLE = str(EXAMPLES / "fum_scara.toml"), str(EXAMPLES / "fum_scara_table1.csv")
PAIR = [str(EXAMPLES / "before_repair.csv"), str(EXAMPLES / "after_repair.csv")]
GAUGES = ["--gauge", "X=opto-rs232@sim:?pace=0", "--gauge", "Y=mitutoyo-mux@sim:?pace=0"]
STREAM = str(EXAMPLES / "stream.csv")
STUDY = [str(EXAMPLES / "dial_type_1.csv"), "--tolerance", "1"]
TIMER = [*GAUGES, "--trigger", "timer:1"]
FIVE = [str(EXAMPLES / "five_poses.csv"), "--model", str(EXAMPLES / "five_poses.toml")]
PACED = ["--poses", "P1,P2,P3,P4,P5", "--line", "192.168.1.10:5000"]
FLEET = ["fleet", str(EXAMPLES / "fleet"), "--workers", "1", "-o", "out"]
GUIDE = "record, asked"
BENCH = '[gauges]\nY = "opto-rs232@sim:?pace=0"\n'
ANSWERS = ("timer:1", "run.csv")

COMMANDS: dict[str, tuple[str, list[str]]] = {
    "record": ("run.csv", ["record", "run.csv", *TIMER]),
    "record --resume": ("run.csv", ["record", "run.csv", *TIMER, "--cycles", "60", "--resume"]),
    "record --rebuild": ("run.csv", ["record", "--rebuild", "run.raw.jsonl"]),
    GUIDE: ("bench.toml", ["record", "--gauge", "X=opto-rs232@sim:?pace=0", "--cycles", "3"]),
    **{
        f"report {kind}": (f"out{kind}", ["report", TABLE, "--model", MODEL, "-o", f"out{kind}"])
        for kind in (".html", ".md", ".csv", ".xlsx", ".pdf", ".json")
    },
    "report --archive": ("out.zip", ["report", TABLE, "--json", "--archive", "out.zip"]),
    "test new": ("new/test.toml", ["test", "new", "new", "--model", MODEL]),
    "tables": ("out.csv", ["tables", TABLE, "-o", "out.csv"]),
    "visits": ("out.csv", ["visits", STREAM, "--poses", "P1,-", "-o", "out.csv"]),
    "history": ("out.html", ["history", str(EXAMPLES / "months"), "-o", "out.html"]),
    "gauge-study": ("out.html", ["gauge-study", *STUDY, "-o", "out.html"]),
    "gauge-study --plot": ("out.svg", ["gauge-study", *STUDY, "--plot", "out.svg"]),
    "plan as a test": ("out.toml", ["plan", MODEL, "-o", "out.toml"]),
    "program": ("out.src", ["program", "krl", *PACED, "--replace", "-o", "out.src"]),
    "simulate": ("out.csv", ["simulate", MODEL, "--cycles", "2000", "-o", "out.csv"]),
    "plan": ("out.csv", ["plan", MODEL, "-o", "out.csv"]),
    "plan --picture": ("out.svg", ["plan", MODEL, "--picture", "out.svg"]),
    "compare --plot": ("out.png", ["compare", *PAIR, "--plot", "out.png"]),
    "diagnose --plot": ("out.svg", ["diagnose", TABLE, "--plot", "out.svg"]),
    "diagnose --map": ("out.csv", ["diagnose", *FIVE, "--map", "out.csv"]),
    "fleet": ("out/manifest.jsonl", FLEET),
    "fleet --figures": ("out/manifest.jsonl", [*FLEET, "--figures"]),
    "selftest --report": ("out.html", ["selftest", "--report", "out.html"]),
    "diagnose --save-model": (
        "out.toml",
        ["diagnose", TABLE, "--model", MODEL, "--save-model", "out.toml"],
    ),
}
"""Each command that writes a file: the file, and the arguments."""
NEW_ONLY = ("test new", "plan as a test")
"""These refuse a file that is there."""
SIGNALS = {"kill -9": signal.SIGKILL, "SIGTERM": signal.SIGTERM, "Ctrl-C": signal.SIGINT}
MOST_OPERATIONS = 20
OPERATIONS = ("create", "write", "sync", "replace", "sync_folder")


@dataclass
class Row:
    """One line of the table."""

    what: str
    tries: int = 0
    failures: int = 0

    def __str__(self) -> str:
        return f"| {self.what} | {self.tries} | {self.failures} |"


class Command:
    """One command, its file before and after, and how long it takes."""

    def __init__(self, name: str, folder: Path) -> None:
        self.name = name
        self.file, self.arguments = COMMANDS[name]
        self.folder = folder
        self.before = folder / "before"
        self.before.mkdir()
        self.answer: object = None
        """What a fleet's command says once it is done."""
        self._prepare()
        self.old = self._read(self.before)
        with chdir(self.place("warm")), redirect_stdout(io.StringIO()):
            _called(self.arguments)
        place = self.place("whole")
        start = time.perf_counter()
        code = run(lambda: None, self.arguments, place)
        self.takes_s = time.perf_counter() - start
        self.new = self._read(place)
        if code != 0 or self.new is None:
            raise SystemExit(f"{name}: exit code {code}")
        self.is_whole(place)

    def _prepare(self) -> None:
        if self.name in NEW_ONLY or self.name.startswith("fleet"):
            return
        if self.name == GUIDE:
            (self.before / self.file).write_text(BENCH)
        elif not self.name.startswith("record"):
            (self.before / self.file).write_bytes(b"the old one\n")
        elif self.name != "record":
            run(lambda: None, COMMANDS["record"][1], self.before)
        if self.name == "record --rebuild":
            (self.before / self.file).unlink()

    def _read(self, place: Path) -> bytes | None:
        path = place / self.file
        return path.read_bytes() if path.exists() else None

    def place(self, name: str) -> Path:
        """Return a new folder as it is before the command."""
        place = self.folder / name
        shutil.copytree(self.before, place)
        return place

    def is_whole(self, place: Path) -> bool:
        """Say whether the file is the old or the new one and a recording is as it was or more."""
        if self.name.startswith("fleet"):
            return self._goes_on(place)
        found = self._read(place)
        raw = raw_path(place / self.file)
        if not raw.exists():
            return found in (self.old, self.new)
        history = read_history(raw)
        if not history.header:
            return found == self.old
        if history.doubts or history.faults:
            return False
        if found == self.old:
            return True
        rebuilt, _ = rebuild(raw, place / "rebuilt.csv", disk=Disk())
        return found == rebuilt.read_bytes()

    def _goes_on(self, place: Path) -> bool:
        """Say whether the same command goes on and, done, says what one that was not killed does.

        Once more it says so too, and that every part was done before.
        """
        before = []
        for name in ("said", "again"):
            said = place / name
            code = run(lambda: _say_into(said), [*self.arguments, "--json"], place)  # noqa: B023
            if code != 0:
                return False
            found = json.loads(said.read_bytes())
            before.append(found.pop("parts"))
            if self.answer and found != self.answer:
                return False
            self.answer = found
        return before[1]["done_before"] == before[1]["count"]


def _say_into(path: Path) -> None:
    os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), 1)


def run(
    prepare: Callable[[], object],
    arguments: list[str],
    place: Path,
    life: float = 0,
    number: int = signal.SIGKILL,
) -> int:
    """Run a command in a fork, ended after ``life`` seconds; return its code, -9 where killed."""
    waiting = {signal.SIGTERM, signal.SIGINT}  # until the fork listens
    signal.pthread_sigmask(signal.SIG_BLOCK, waiting)
    child = os.fork()
    if child == 0:
        code = process.INTERRUPTED
        try:
            process.listen()
            signal.pthread_sigmask(signal.SIG_UNBLOCK, waiting)
            os.chdir(place)
            nowhere = os.open(os.devnull, os.O_RDWR)
            for stream in (0, 1, 2):
                os.dup2(nowhere, stream)
            prepare()
            code = _called(arguments)
        finally:
            os._exit(code)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, waiting)
    if life:
        time.sleep(life)
        os.kill(child, number)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def _called(arguments: list[str]) -> int:
    """Return the code of a command as the program's door does."""
    code = 0
    builtins.input = _answers().__next__
    try:
        code = scara_iso(arguments)
        process.stop_listening()
    except KeyboardInterrupt:
        process.stop_listening()
    return process.INTERRUPTED if process.were_heard() else code


def _answers() -> Iterator[str]:
    yield from ANSWERS
    raise EOFError


def kills(command: Command, how: str, count: int, rng: random.Random) -> Row:
    """End it at random moments of the time that the command takes."""
    row, number = Row(f"{how} in `{command.name}`"), SIGNALS[how]
    for k in range(count):
        place = command.place(f"{how}{k}")
        life = rng.uniform(0.003, 1.1 * command.takes_s)
        code = run(lambda: None, command.arguments, place, life, number)
        kill = number == signal.SIGKILL
        row.failures += not kill and code not in (0, process.INTERRUPTED)
        judge(row, command, place, parts=kill)
    return row


def judge(row: Row, command: Command, place: Path, *, parts: bool = True) -> None:
    """Count a try; without ``parts`` none may be left."""
    row.tries += 1
    try:
        whole = command.is_whole(place) and (parts or not [*place.rglob("*.part")])
    except (ScaraIsoError, OSError):
        whole = False
    row.failures += not whole
    shutil.rmtree(place)


def kills_at_operations(command: Command, row: Row) -> None:
    """Kill before, within and behind every operation on the disk that writing consists of."""
    for operation in OPERATIONS:
        for when in ("before", "within", "behind"):
            for nth in range(MOST_OPERATIONS):
                place = command.place(f"{operation}-{when}-{nth}")
                code = run(lambda: _kill_at(operation, when, nth), command.arguments, place)  # noqa: B023
                if code == -signal.SIGKILL:
                    judge(row, command, place)
                else:  # there are not so many of them
                    shutil.rmtree(place)
                    break


def _kill_at(operation: str, when: str, nth: int) -> None:
    whole, left = getattr(Disk, operation), [nth]

    def killing(self: Disk, *arguments: object) -> object:
        left[0] -= 1
        if left[0] >= 0:
            return whole(self, *arguments)
        if when == "within" and operation == "write":
            file, data = arguments
            os.write(file, data[: len(data) // 2])  # type: ignore[index, arg-type]
        if when == "behind":
            whole(self, *arguments)
        os.kill(os.getpid(), signal.SIGKILL)
        return None

    setattr(Disk, operation, killing)


def full_disks(command: Command, count: int, rng: random.Random, row: Row) -> None:
    """Let no file grow beyond a number of bytes that is too small for the new one."""
    size = len(command.new or b"")
    for k in range(count):
        place = command.place(f"full{k}")
        room = rng.randrange(size)
        code = run(lambda: _limit(room), command.arguments, place)  # noqa: B023
        row.failures += code not in ((2,) if command.name == GUIDE else (73, 74))  # asks again
        judge(row, command, place)


def _limit(room: int) -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))


def _compute_once() -> None:
    """Let what takes long be computed once, before the forks; let questions be answered."""

    def once(module: object, name: str, key: Callable[..., object]) -> None:
        whole, found = getattr(module, name), {}

        def remembered(*arguments: object, **options: object) -> object:
            of_these = key(*arguments, **options)
            if of_these not in found:
                found[of_these] = whole(*arguments, **options)
            return found[of_these]

        setattr(module, name, remembered)

    def of_a_run(run: Run, model: object, *_: object, **options: object) -> object:
        return run.origin.source, model is None, bool(options.get("reach"))

    once(closing, "close_the_loop", of_a_run)
    once(closing, "close_the_loop_at_poses", of_a_run)
    once(screening, "examine", lambda piece, task: (piece, repr(task)))
    checks = tuple(selftests.validate())
    selftests.validate = lambda: iter(checks)
    engines.open_processes = ThreadPoolExecutor  # processes are not forked with what is computed
    Terminal.guided = property(lambda _: True)  # for one without a table


def main() -> int:
    """Print the table; exit 1 where a file was neither the old nor the new one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=1000, help="of each signal")
    parser.add_argument("--full", type=int, default=20, help="full disks for each command")
    parser.add_argument("--only", choices=list(COMMANDS), action="append")
    options = parser.parse_args()
    _compute_once()
    names = options.only or list(COMMANDS)
    rng = random.Random(20261122)  # noqa: S311
    operations = Row("kill -9 before, within or behind each operation on the disk, all commands")
    full = Row("disk full after n bytes, all commands")
    rows: dict[str, list[Row]] = {how: [] for how in SIGNALS}
    print("| test | tries | failures |")
    print("|---|---|---|")
    for k, name in enumerate(names):
        with tempfile.TemporaryDirectory() as folder:
            command = Command(name, Path(folder))
            count = options.kills // len(names) + (k < options.kills % len(names))
            for how, of_it in rows.items():
                of_it.append(kills(command, how, count, rng))
                print(of_it[-1], flush=True)
            kills_at_operations(command, operations)
            full_disks(command, options.full, rng, full)
    totals = [_total(how, of_it) for how, of_it in rows.items()]
    for row in (*totals, operations, full):
        print(row, flush=True)
    return int(any(row.failures for row in (*totals, operations, full)))


def _total(how: str, rows: list[Row]) -> Row:
    tries, failures = sum(row.tries for row in rows), sum(row.failures for row in rows)
    return Row(f"{how} at a random moment, all commands", tries, failures)


if __name__ == "__main__":
    sys.exit(main())
