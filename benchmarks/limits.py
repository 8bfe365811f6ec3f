"""Limits of work: many lines above a header, many columns, many files, a large file.

Run: python benchmarks/limits.py [files [rows]]. Each row is a process of its own: seconds of
processor and peak memory of it, as ``os.wait4`` has them, beside half the size.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from read import write_rows

READ = "import sys; from scara_iso.tables import read_table\ntry: read_table(sys.argv[1])\n"
READ += "except Exception as error: print(str(error)[:80])"
FIGURES = "import sys, scara_iso; scara_iso.fleet_figures(*sys.argv[1:], workers=1)"
ROWS = "".join(f"{k},0.1{k % 7}\n" for k in range(1, 32))


def child(script: str, *given: object) -> tuple[float, float]:
    """Return seconds of processor and the peak of memory [MB] of a process."""
    process = subprocess.Popen([sys.executable, "-c", script, *map(str, given)])
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"a child ended with {process.returncode}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def doubled(what: str, size: int, write: object, folder: Path) -> None:
    """Print what reading takes, and how many times that of half the size."""
    path, taken = folder / "table.csv", []
    for count in (size // 2, size):
        write(path, count)  # type: ignore[operator]
        taken.append(child(READ, path))
    (half, _), (whole, peak) = taken
    print(f"{size:,} {what}: {whole:.1f} s, {whole / half:.1f} times half; {peak:.0f} MB")


def head(path: Path, count: int) -> None:
    """Write a header below ``count`` statements."""
    path.write_text("# unit: mm\n" + "# operator: Smith\n" * count + "cycle,X\n" + ROWS)


def wide(path: Path, count: int) -> None:
    """Write a table of ``count`` columns, X in the middle and Y last."""
    names = ["cycle", *(f"c{k}" for k in range(count - 1))]
    names[count // 2], names[-1] = "X", "Y"
    rows = (",".join([str(k), *["0.1"] * (count - 1)]) for k in range(1, 32))
    path.write_text("# unit: mm\n" + "\n".join([",".join(names), *rows]) + "\n")


def fleets(folder: Path, count: int) -> None:
    """Print what ``count`` files of a table take beside one file of the same rows."""
    one, many = folder / "one", folder / "many"
    one.mkdir()
    many.mkdir()
    lines = ROWS.splitlines()
    rows = (f"R{k},{line}\n" for k in range(count) for line in lines)
    (one / "all.csv").write_text("# unit: mm\nrobot,cycle,X\n" + "".join(rows))
    for k in range(count):
        (many / f"R{k}.csv").write_text("# unit: mm\ncycle,X\n" + ROWS)
    single, _ = child(FIGURES, one, folder / "a")
    several, _ = child(FIGURES, many, folder / "b")
    print(f"{count:,} files: {several:.1f} s, {several / single:.2f} times one of the same rows")


def main() -> None:
    """Print the limits."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        doubled("lines above the header", 2_000_000, head, folder)
        doubled("columns", 10_000, wide, folder)
        fleets(folder, int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
        doubled("rows", int(sys.argv[2]) if len(sys.argv) > 2 else 6_000_000, write_rows, folder)


if __name__ == "__main__":
    main()
