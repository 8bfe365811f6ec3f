"""How long the program takes from the shell, as ratios to bare Python in the same run.

    python benchmarks/startup.py [--runs 15]

Goals: --help at most 15 times bare Python; analyze of 31 rows at most 20 times bare Python and at
most 0.6 of the pandas script that a user would write.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import time
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
    "backlash": ["-m", "scara_iso", "backlash", "--Im", "1e-4", "--IL", "1", "--arcmin", "1"],
    "pandas script": ["-c", PANDAS_SCRIPT],
}


def seconds(arguments: list[str]) -> float:
    """Return the wall time of one call."""
    # An installed program has its byte code on disk: do not measure its compiler.
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    start = time.perf_counter()
    subprocess.run(
        [sys.executable, *arguments], check=True, capture_output=True, cwd=ROOT, env=environment
    )
    return time.perf_counter() - start


def main() -> None:
    """Print medians and ratios; the commands take turns, so that a slow moment hits all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=15)
    runs = parser.parse_args().runs
    times: dict[str, list[float]] = {name: [] for name in COMMANDS}
    for name, arguments in COMMANDS.items():
        seconds(arguments)  # byte code, file cache
        del name
    for _ in range(runs):
        for name, arguments in COMMANDS.items():
            times[name].append(seconds(arguments))
    medians = {name: statistics.median(found) for name, found in times.items()}
    bare, pandas = medians["bare Python"], medians["pandas script"]
    print(f"{'':18} {'ms':>7} {'x bare':>7} {'x pandas':>9}   median of {runs}")
    for name, median in medians.items():
        print(f"{name:18} {median * 1e3:7.1f} {median / bare:7.1f} {median / pandas:9.2f}")


if __name__ == "__main__":
    main()
