"""What reading survives: fuzzed tables, hostile texts, junk, packed workbooks, each with a limit.

Prints the table of docs/durability.md. ``python benchmarks/fuzz_tables.py --tables 100000``. A try
fails where it raises anything but an error of the house, takes longer than its limit, or more
memory. The limits are of processor time: a busy machine fails nothing. Needs SIGPROF and fork
(Linux, macOS).
"""

from __future__ import annotations

import argparse
import io
import multiprocessing
import random
import resource
import signal
import sys
import time
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import openpyxl

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from hostile import TEXTS  # noqa: E402

from scara_iso import analyze, read_table  # noqa: E402
from scara_iso.diagnosis.reversals.sweeps import read_sweep  # noqa: E402
from scara_iso.errors import ScaraIsoError  # noqa: E402

TABLE = (ROOT / "examples" / "fum_scara_table1.csv").read_text(encoding="utf-8")
PIECES = [
    *TEXTS, "cycle", "X", "Y_mm", "theta", "pose", ",", ";", "\t", "  ", "\n", "\r\n", '"', "#",
    ":", "=", "unit", "mm", "1,234", "0,5", "-", "1e5", "Mean", "nan", "inf", "\u2212", "\u00a0",
    "sep=;", "# unit: mm\n", "cycle,X\n", "1,0.1\n", "[", "(", "9" * 4400, "1e400", "1e-400", "°",
    "-" * 60 + "a", "--- " * 30, "_" * 80, " " * 500, "2024-05-13T14:03:22", "1e99 mm", "\u0661",
    "# resolution: 0", "# command_X: 1e308", "# indicator_uncertainty: -1", "P1", "+x", "\x1a",
]  # fmt: skip
SHORT = [piece for piece in PIECES if len(piece) <= 100]
ANALYSED = 20
"""Every so many tables are analysed too: that takes ten times as long."""
LIMIT_S = 2
JUNK_S = 5
MEMORY_MB = 300


class LateError(Exception):
    """A try took longer than its limit."""


def late(*_: object) -> None:
    """Answer the alarm."""
    raise LateError


def mutate(text: str, rng: random.Random) -> str:
    """Return a table with one to five pieces put in, cut out or doubled."""
    for _ in range(rng.choice((1, 1, 2, 5))):
        k = rng.randrange(len(text) + 1)
        cut = rng.choice((0, 0, 1, 20, 300))
        text = text[:k] + rng.choice((rng.choice(SHORT), text[k : k + 40])) + text[k + cut :]
    return text


def fuzzed(count: int, seed: int) -> Iterator[bytes]:
    """Yield tables of three kinds: a real one changed, words of tables, and any bytes."""
    rng = random.Random(seed)  # noqa: S311
    for k in range(count):
        if k % 20 == 0:
            yield rng.randbytes(rng.randrange(400))
            continue
        words = "".join(rng.choices(SHORT, k=rng.randrange(1, 30)))
        text = words if k % 4 == 0 else mutate(TABLE, rng)
        yield text.encode(rng.choice(("utf-8", "utf-8", "utf-16", "cp1252")), "replace")


def survives(data: bytes, read: Callable[[bytes], object], limit: int) -> bool:
    """Say whether reading ends in time, in a result or in an error of the house."""
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        read(data)
    except ScaraIsoError:
        return True
    except Exception as error:  # noqa: BLE001 - what is counted
        sys.stderr.write(f"{type(error).__name__}: {error}: {data[:200]!r}\n")
        return False
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return True


def judged(data: bytes) -> object:
    """Read and analyse, as a command would."""
    return analyze(read_table(data, unit="mm"), cycles=None)


def junk() -> Iterator[bytes]:
    """Yield files of 20 MB that hold no table below their header."""
    head = "# unit: mm\ncycle,X,Y\n"
    rng = random.Random(20261122)  # noqa: S311
    lines = ("".join(chr(rng.randrange(32, 127)) for _ in range(60)) for _ in range(500))
    rows = [
        "\n".join(lines), "a", "Mean,1,2", "# abc", "-------", "-" * 50 + "a", "-" * 99_000 + "a",
        "--- " * 24_000 + "a", " " * 90_000 + "a", "Inspector: A", "1,abc,2", '1,"0.1,0.2',
        "a," * 49_000, "a" + " " * 98_000 + "b", "1," * 49_000, "," + "9" * 90_000, ";;;;",
        "x axis," * 12_000, "_" * 90_000, "(" * 90_000,
    ]  # fmt: skip
    for row in rows:
        for start in (head, ""):
            yield (start + f"{row}\n" * (20_000_000 // (len(row) + 1))).encode()


SHEET = (
    '<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><sheetData>'
    '<row r="1"><c r="A1" t="inlineStr"><is><t>X [mm]</t></is></c></row>%s</sheetData></worksheet>'
)


def workbook(rows: str, strings: str = "") -> bytes:
    """Return a workbook whose sheet, and shared texts, are replaced."""
    plain, packed = io.BytesIO(), io.BytesIO()
    book = openpyxl.Workbook()
    book.active["A1"] = "X"
    book.save(plain)
    with zipfile.ZipFile(plain) as old, zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            text = old.read(name)
            if name.endswith("sheet1.xml"):
                text = (SHEET % rows).encode()
            elif name.endswith("sharedStrings.xml") and strings:
                text = strings.encode()
            new.writestr(name, text)
    return packed.getvalue()


def workbooks() -> Iterator[bytes]:
    """Yield workbooks of at most 1.2 MB that unpack to much."""
    cell = '<row r="{r}"><c r="A{r}"><v>1</v></c></row>'
    text = '<row r="{r}"><c r="A{r}" t="inlineStr"><is><t>{t}</t></is></c></row>'
    sst = '<sst xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main">'
    for far in ("CV99999", "J99999", "XFD60", "A1048576", "XFD1048576"):
        row = "".join(filter(str.isdigit, far))
        yield workbook(f'<row r="{row}"><c r="{far}"><v>1</v></c></row>')
    for count in (200_000, 700_000):
        yield workbook("".join(cell.format(r=r) for r in range(2, count)))
    for size, count in ((60, 200_000), (30_000, 1_400), (30_000, 9_000)):
        yield workbook("".join(text.format(r=r, t="a" * size) for r in range(2, count)))
    for count in (2_500_000, 10_000_000):
        yield workbook("", sst + "<si><t>a</t></si>" * count + "</sst>")


def _peak(data: bytes, queue: multiprocessing.Queue[tuple[bool, float]]) -> None:
    good = survives(data, read_table, 60)
    queue.put((good, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))


def in_a_process(data: bytes) -> tuple[bool, float]:
    """Return whether reading survives, and the most memory that a process takes for it [MB]."""
    context = multiprocessing.get_context("spawn")
    queue = context.Queue()
    process = context.Process(target=_peak, args=(data, queue))
    process.start()
    found: tuple[bool, float] = queue.get(timeout=120)
    process.join()
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--tables", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=20261122)
    options = parser.parse_args()
    signal.signal(signal.SIGPROF, late)
    print("| test | tries | failures |\n|---|---|---|")
    longest, failures = 0.0, 0
    for k, data in enumerate(fuzzed(options.tables, options.seed)):
        start = time.process_time()
        failures += not survives(data, judged if k % ANALYSED == 1 else read_table, LIMIT_S)
        longest = max(longest, time.process_time() - start)
    print(f"| fuzzed tables, {LIMIT_S} s each | {options.tables} | {failures} |", flush=True)
    tries = failures = 0
    for text in PIECES:
        for place in ("{}", "# unit: {}\ncycle,X\n1,0.1\n", "# unit: mm\ncycle,{}\n1,0.1\n",
                      "# unit: mm\ncycle,X\n1,{}\n", "# robot: {}\ncycle,X_mm\n1,0.1\n",
                      "Im,IL,arcmin,deviation_rad\n1,2,3,{}\n"):  # fmt: skip
            for read in (judged, read_sweep):
                tries += 1
                data = place.format(text).encode("utf-8", "replace")
                failures += not survives(data, read, LIMIT_S)
    print(f"| hostile texts in six places, {LIMIT_S} s each | {tries} | {failures} |", flush=True)
    tries = failures = 0
    slowest = 0.0
    for data in junk():
        start = time.process_time()
        survives(data, read_table, 60)
        slowest = max(slowest, time.process_time() - start)
        tries, failures = tries + 1, failures + (time.process_time() - start > JUNK_S)
    print(f"| 20 MB of junk rows, {JUNK_S} s each | {tries} | {failures} |", flush=True)
    found = [in_a_process(data) for data in workbooks()]
    failures = sum(not good or peak > MEMORY_MB for good, peak in found)
    print(f"| packed workbooks, {MEMORY_MB} MB each | {len(found)} | {failures} |")
    print(
        f"\nslowest table {longest:.2f} s, slowest junk {slowest:.1f} s (processor time), "
        f"most memory {max(peak for _, peak in found):.0f} MB"
    )


if __name__ == "__main__":
    main()
