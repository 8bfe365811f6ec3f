"""What the program costs from the shell, as ratios to bare Python in the same run.

    python benchmarks/startup.py [--runs 15]

Processor seconds, user's and system's together: other programs on the machine count for less in
them than in wall time. Goals: --help at most 8 times bare Python; analyze of 31 rows at most 20
times, and 0.7 of the pandas script that a user would write; diagnose of Table I at most 35
times, report at most 80.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
TABLE = ROOT / "examples" / "fum_scara_table1.csv"
PANDAS_SCRIPT = f"""
import pandas as pd
table = pd.read_csv({str(TABLE)!r}, comment="#")
for axis in ["X", "Y", "Z", "theta"]:
    x = table[axis] / 100
    l = (x - x.mean()).abs()
    print(axis, l.mean() + 3 * l.std())
"""
COMMANDS = {
    "bare Python": ["-c", "pass"],
    "--help": ["-m", "scara_iso", "--help"],
    "analyze, 31 rows": ["-m", "scara_iso", "analyze", str(TABLE)],
    "analyze --json": ["-m", "scara_iso", "analyze", str(TABLE), "--json"],
    "diagnose, Table I": ["-m", "scara_iso", "diagnose", str(TABLE)],
    "report, Table I": ["-m", "scara_iso", "report", str(TABLE), "-o", "report.html"],
    "backlash": ["-m", "scara_iso", "backlash", "--Im", "1e-4", "--IL", "1", "--arcmin", "1"],
    "pandas script": ["-c", PANDAS_SCRIPT],
}


def seconds(arguments: list[str], folder: str) -> float:
    """Return the processor time of one call in a folder."""
    # An installed program has its byte code on disk: do not measure its compiler.
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    environment["PYTHONPATH"] = str(ROOT)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, *arguments], check=True, capture_output=True, cwd=folder, env=environment
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main() -> None:
    """Print medians and ratios; the commands take turns, so that a slow moment hits all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=15)
    runs = parser.parse_args().runs
    times: dict[str, list[float]] = {name: [] for name in COMMANDS}
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(runs + 1):  # the first fills byte code and file cache
            for name, arguments in COMMANDS.items():
                found = seconds(arguments, folder)
                times[name] += [found] if turn else []
    medians = {name: statistics.median(found) for name, found in times.items()}
    bare, pandas = medians["bare Python"], medians["pandas script"]
    print(f"{'':18} {'ms':>7} {'x bare':>7} {'x pandas':>9}   median of {runs}")
    for name, median in medians.items():
        print(f"{name:18} {median * 1e3:7.1f} {median / bare:7.1f} {median / pandas:9.2f}")


if __name__ == "__main__":
    main()
