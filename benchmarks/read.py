"""Time and memory of reading a million rows: `read_table` against ``pandas.read_csv``.

Run: python benchmarks/read.py [rows]. Each reading is a process of its own, so that the peak
memory is its own; the time is that of the call, imports of the libraries excluded. Medians of 3.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

CYCLES = 31
OURS = "from scara_iso.tables import read_table; import numpy; read = read_table"
PANDAS = "import pandas; read = lambda p: pandas.read_csv(p, comment='#')"
MEASURE = """
import sys, time
{library}
start = time.perf_counter()
table = read(sys.argv[1])
seconds = time.perf_counter() - start
try:
    status = open("/proc/self/status").read()
    peak = int(status.split("VmHWM:")[1].split()[0]) / 1024
except OSError:
    peak = float("nan")
print(seconds, peak, len(table))
"""


def write_rows(path: Path, rows: int, separator: str = ",", mark: str = ".") -> None:
    """Write a table of ``rows`` rows, 31 to a pose."""
    readings = np.random.default_rng(1).normal(0.5, 0.01, (rows, 4)).round(3)
    with path.open("w") as file:
        file.write("# unit: mm\n# resolution: 0.001\n")
        file.write(separator.join(("pose", "cycle", "X", "Y", "Z", "theta")) + "\n")
        for k, values in enumerate(readings.tolist()):
            cells = [f"{v:.3f}".replace(".", mark) for v in values]
            file.write(separator.join((f"P{k // CYCLES + 1}", str(k % CYCLES + 1), *cells)) + "\n")


def measure(library: str, path: Path) -> tuple[float, float]:
    """Return median seconds and peak memory [MB] of reading ``path`` in a new process."""
    runs = []
    for _ in range(3):
        script = MEASURE.format(library=library)
        out = subprocess.run(
            [sys.executable, "-c", script, str(path)], capture_output=True, text=True, check=True
        ).stdout
        runs.append(tuple(map(float, out.split()[:2])))
    return statistics.median(r[0] for r in runs), max(r[1] for r in runs)


def main() -> None:
    """Print time, ratio and peak memory."""
    rows = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    with tempfile.TemporaryDirectory() as folder:
        path, german = Path(folder, "rows.csv"), Path(folder, "german.csv")
        write_rows(path, rows)
        write_rows(german, rows, ";", ",")
        base, base_peak = measure(PANDAS, path)
        print(f"{rows} rows, {path.stat().st_size / 1e6:.1f} MB")
        print(f"pandas.read_csv              {base:6.2f} s            peak {base_peak:4.0f} MB")
        for name, file in (("canonical", path), ("semicolon, decimal comma", german)):
            seconds, peak = measure(OURS, file)
            print(
                f"{name:<28} {seconds:6.2f} s  x {seconds / base:4.1f}    peak {peak:4.0f} MB"
                f"    {seconds / rows * 1e6:.2f} s per million rows"
            )


if __name__ == "__main__":
    main()
