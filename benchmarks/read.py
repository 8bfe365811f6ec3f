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
start, cpu = time.perf_counter(), time.process_time()
table = read(sys.argv[1])
seconds, cpu = time.perf_counter() - start, time.process_time() - cpu
try:
    status = open("/proc/self/status").read()
    peak = int(status.split("VmHWM:")[1].split()[0]) / 1024
except OSError:
    peak = float("nan")
print(seconds, cpu, peak, len(table))
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


def measure(library: str, path: Path) -> tuple[float, float, float]:
    """Return median seconds by the clock and of the processor, and peak memory [MB].

    Each reading of ``path`` is a new process.
    """
    runs = []
    for _ in range(3):
        script = MEASURE.format(library=library)
        out = subprocess.run(
            [sys.executable, "-c", script, str(path)], capture_output=True, text=True, check=True
        ).stdout
        runs.append(tuple(map(float, out.split()[:3])))
    wall, cpu, peak = zip(*runs, strict=True)
    return statistics.median(wall), statistics.median(cpu), max(peak)


def main() -> None:
    """Print time, ratio and peak memory."""
    rows = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    with tempfile.TemporaryDirectory() as folder:
        path, german = Path(folder, "rows.csv"), Path(folder, "german.csv")
        write_rows(path, rows)
        write_rows(german, rows, ";", ",")
        print(f"{rows} rows, {path.stat().st_size / 1e6:.1f} MB")
        base = 0.0
        for name, library, file in (
            ("pandas.read_csv", PANDAS, path),
            ("canonical", OURS, path),
            ("semicolon, decimal comma", OURS, german),
        ):
            wall, cpu, peak = measure(library, file)
            base = base or wall
            print(
                f"{name:<26}{wall:6.2f} s ({cpu:.2f} s of processor)  x{wall / base:5.1f}"
                f"  peak {peak:4.0f} MB  {wall / rows * 1e6:.2f} s per million rows"
            )


if __name__ == "__main__":
    main()
