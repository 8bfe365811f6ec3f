"""How long a report takes from the shell: 31 cycles, and 5 poses of 4 axes.

    python benchmarks/report.py [--runs 3]

Goals: 3 s and 6 s; printed as parts of them. The median of processor time (user and system) is
printed beside the wall time, which other work on the machine lengthens.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
MODEL = ROOT / "examples" / "fum_scara.toml"
WARM_UP = ROOT / "examples" / "warm_up.csv"


def five_poses(path: Path) -> Path:
    """Write a table of 5 poses and 4 axes, a warm-up in two of them."""
    rng = np.random.default_rng(9283)
    lines = ["# unit: mm", "# resolution: 0.001", "pose,cycle,X,Y,Z,theta"]
    for pose in range(1, 6):
        readings = rng.normal(0, 0.005, (31, 4))
        readings[:, :2] += 0.02 * (1 - np.exp(-np.arange(31) / 8))[:, np.newaxis]
        for cycle, row in enumerate(readings.round(3), start=1):
            lines.append(f"P{pose},{cycle},{','.join(f'{x:.3f}' for x in row)}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def seconds(arguments: list[str]) -> tuple[float, float]:
    """Return wall and processor time of one call."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "scara_iso", "report", *arguments],
        check=True, capture_output=True, cwd=ROOT, env=environment,
    )  # fmt: skip
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print each median and its part of the goal."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=3)
    runs = parser.parse_args().runs
    with tempfile.TemporaryDirectory() as folder:
        page = ["-o", str(Path(folder) / "report.html")]
        cases = {
            "31 cycles, with model": (3.0, [str(WARM_UP), "--model", str(MODEL), *page]),
            "5 poses x 4 axes": (6.0, [str(five_poses(Path(folder) / "five.csv")), *page]),
        }
        print(
            f"{'':24} {'wall s':>7} {'of goal':>8} {'cpu s':>7} {'of goal':>8}   median of {runs}"
        )
        for name, (goal, arguments) in cases.items():
            found = [seconds(arguments) for _ in range(runs)]
            wall, cpu = (statistics.median(times) for times in zip(*found, strict=True))
            print(f"{name:24} {wall:7.2f} {wall / goal:8.2f} {cpu:7.2f} {cpu / goal:8.2f}")


if __name__ == "__main__":
    main()
