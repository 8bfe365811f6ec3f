"""What reading survives: fuzzed tables, texts, junk and workbooks, each with a limit.

Prints the tables of benchmarks/results/durability.md.
``python benchmarks/fuzz_tables.py --tables 100000``. A
try fails where it raises anything but an error of the house, takes longer than its limit, or, for a
workbook of at most 1.2 MB, more memory. The limits are of processor time: a busy machine fails
nothing. Needs SIGPROF and fork (Linux, macOS).
"""

from __future__ import annotations

import argparse
import io
import multiprocessing
import random
import resource
import signal
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import openpyxl
from openpyxl.utils import get_column_letter

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support")]

from hostile import TEXTS  # noqa: E402

from scara_iso import analyze, read_table  # noqa: E402
from scara_iso.base.errors import ScaraIsoError  # noqa: E402
from scara_iso.diagnosis.sweeps import read_sweep  # noqa: E402

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


MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
SHEET = (
    f'<worksheet xmlns="{MAIN}"><sheetData><row r="1"><c r="A1" t="inlineStr"><is><t>X [mm]</t>'
    "</is></c></row>%s</sheetData></worksheet>"
)
PACKED_MB = 1.2


def workbook(rows: str, strings: str = "") -> bytes:
    """Return a workbook whose sheet is replaced, with shared texts."""
    plain, packed = io.BytesIO(), io.BytesIO()
    book = openpyxl.Workbook()
    book.active["A1"] = 1
    book.save(plain)
    with zipfile.ZipFile(plain) as old, zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            sheet = name.endswith("sheet1.xml")
            new.writestr(name, (SHEET % rows).encode() if sheet else old.read(name))
        new.writestr("xl/sharedStrings.xml", f'<sst xmlns="{MAIN}">{strings}</sst>')
    return packed.getvalue()


def column(cell: str, count: int) -> str:
    """Return rows of one cell each; ``{r}`` in it stands for its row."""
    return "".join(f'<row r="{r}">{cell.format(r=r)}</row>' for r in range(2, count + 2))


def sheet_of(cell: str, width: int, height: int) -> str:
    """Return a rectangle of cells; ``{r}`` stands for a cell's place."""
    names = [get_column_letter(k) for k in range(1, width + 1)]
    return "".join(
        f'<row r="{r}">{"".join(cell.format(r=f"{name}{r}") for name in names)}</row>'
        for r in range(2, height + 2)
    )


def workbooks() -> Iterator[tuple[str, bytes]]:
    """Yield what a workbook holds, and the workbook."""
    far = ("CV9999", "J99999", "XFD60", "A1000000", "XFD1048576")
    for place in far:
        row = "".join(filter(str.isdigit, place))
        cell = f'<row r="{row}"><c r="{place}"><v>1</v></c></row>'
        yield f"one cell far away, {place}", workbook(cell)
    for count in (200_000, 240_000, 900_000):
        yield f"{count} numbers", workbook(column('<c r="A{r}"><v>1</v></c>', count))
    text = '<c r="A{r}" t="inlineStr"><is><t>%s</t></is></c>'
    for size, count in ((60, 200_000), (30_000, 700), (30_000, 1_400), (30_000, 9_000)):
        cells = column(text % ("a" * size), count)
        yield f"{count} texts of {size} characters", workbook(cells)
    wide = "\U0001f600" + "a" * 29_000
    yield "750 texts of four bytes a character", workbook(column(text % wide, 750))
    for size, count in ((20, 240_000), (30_000, 700), (30_000, 200_000)):
        cells = column('<c r="A{r}" t="s"><v>0</v></c>', count)
        name = f"one shared text of {size} characters in {count} cells"
        yield name, workbook(cells, f"<si><t>{'a' * size}</t></si>")
    rectangle = sheet_of('<c r="{r}" t="s"><v>0</v></c>', 900, 1_100)
    yield "one shared text in 990000 cells", workbook(rectangle, "<si><t>0.812 mm</t></si>")
    yield "400000 error cells", workbook(sheet_of('<c r="{r}" t="e"/>', 800, 500))
    for one, count in (("<si><t>a</t></si>", 990_000), ("<si/>", 8_000_000)):
        yield f"{count} shared texts", workbook("", one * count)
    yield "a directory that lies", lying()


def lying() -> bytes:
    """Return a workbook of 400 MB whose directory says 9 bytes."""
    strings = f"<si><t>{'a' * 1000}</t></si>" * 390_000
    data = workbook("", strings)
    directory = data.index(b"PK\x01\x02")
    size = len(f'<sst xmlns="{MAIN}">{strings}</sst>').to_bytes(4, "little")
    return data[:directory] + data[directory:].replace(size, (9).to_bytes(4, "little"))


def _peak(path: str, queue: multiprocessing.Queue[tuple[bool, float]]) -> None:
    with Path(path).open("rb") as file:
        good = survives(file.read(), read_table, 60)
    queue.put((good, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))


def in_a_process(path: str) -> tuple[bool, float]:
    """Return whether reading survives, and the most memory that a process takes for it [MB].

    To be called from a small process: a child's peak begins at its parent's.
    """
    context = multiprocessing.get_context("spawn")
    queue = context.Queue()
    process = context.Process(target=_peak, args=(path, queue))
    process.start()
    found: tuple[bool, float] = queue.get(timeout=240)
    process.join()
    return found


def write_workbooks(folder: str, queue: multiprocessing.Queue[list[tuple[str, str, int]]]) -> None:
    """Write each workbook to a file of the folder, and put name, path and bytes of all."""
    written = []
    for k, (name, data) in enumerate(workbooks()):
        path = Path(folder, f"{k}.xlsx")
        path.write_bytes(data)
        written.append((name, str(path), len(data)))
    queue.put(written)


def packed_workbooks() -> None:
    """Print a row for each workbook, and how many fail."""
    print("| workbook | packed [MB] | most memory [MB] |\n|---|---|---|")
    tries = failures = 0
    with tempfile.TemporaryDirectory() as folder:
        context = multiprocessing.get_context("spawn")
        queue = context.Queue()
        process = context.Process(target=write_workbooks, args=(folder, queue))
        process.start()
        written = queue.get(timeout=600)
        process.join()
        for name, path, size in written:
            good, peak = in_a_process(path)
            print(f"| {name} | {size / 1e6:.2f} | {peak:.0f} |", flush=True)
            tries += 1
            failures += not good or (peak > MEMORY_MB and size <= PACKED_MB * 1e6)
    print(f"\n{tries} workbooks, {failures} failures")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--tables", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=20261122)
    parser.add_argument("--workbooks", action="store_true", help="only the packed workbooks")
    options = parser.parse_args()
    signal.signal(signal.SIGPROF, late)
    packed_workbooks()
    if not options.workbooks:
        texts(options.tables, options.seed)


def texts(count: int, seed: int) -> None:
    """Print tries and failures of fuzzed tables, hostile texts and junk."""
    print("| test | tries | failures |\n|---|---|---|")
    longest, failures = 0.0, 0
    for k, data in enumerate(fuzzed(count, seed)):
        start = time.process_time()
        failures += not survives(data, judged if k % ANALYSED == 1 else read_table, LIMIT_S)
        longest = max(longest, time.process_time() - start)
    print(f"| fuzzed tables, {LIMIT_S} s each | {count} | {failures} |", flush=True)
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
    print(f"\nslowest table {longest:.2f} s, slowest junk {slowest:.1f} s (processor time)")


if __name__ == "__main__":
    main()
