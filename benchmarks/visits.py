"""Streams to visits: time and memory of an hour at 500 Hz, and what the intervals hold.

Run: python benchmarks/visits.py. The streams are those of tests/support/streams.py. Coverage is of
the closed form by the intervals of three and of five arrivals; found are visits of all that there
are, invented those that are none, over noise and rates.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))
import streams
from streams import Arm

from scara_iso import visits
from scara_iso.run import Axis, Run

HOUR = 3600
RUNS = 100
MEASURE = """
import resource, sys, time
import scara_iso
start, cpu = time.perf_counter(), time.process_time()
found = scara_iso.visits(sys.argv[1], poses=["P1", "-"])
print(len(found.visits), time.perf_counter() - start, time.process_time() - cpu,
      resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, found.samples)
"""


def speed() -> None:
    """Print time and memory for one and four axes."""
    time, reading, _ = streams.visits(np.random.default_rng(1), count=490, noise=0.001)
    rows = min(len(time), 500 * HOUR)
    with tempfile.TemporaryDirectory() as folder:
        for axes in ("X", "XY", ("X", "Y", "Z", "theta")):
            path = Path(folder) / "stream.csv"
            values = reading[:rows].tolist()
            with path.open("w") as file:
                file.write("# unit: mm\n# resolution: 0.001\n" + ",".join(["time_s", *axes]) + "\n")
                for t, x in zip(time[:rows].tolist(), values, strict=True):
                    file.write(f"{t:.3f}" + f",{x:.3f}" * len(axes) + "\n")
            out = subprocess.run(
                [sys.executable, "-c", MEASURE, str(path)],
                capture_output=True, text=True, check=True,
            ).stdout.split()  # fmt: skip
            print(f"{len(axes)} axes, {out[4]} rows: {out[0]} visits, {float(out[1]):.1f} s "
                  f"({float(out[2]):.1f} s of the processor), {float(out[3]):.0f} MB")  # fmt: skip


def as_run(time: np.ndarray, reading: np.ndarray) -> Run:
    """Return a stream of one axis."""
    axes = {"X": Axis("X", reading, resolution=0.001)}
    return Run(np.arange(1, len(time) + 1), axes, covariates={"time_s": time})


def coverage(count: int, noise: float, hz: float) -> None:
    """Print how often the intervals hold the closed form's figures."""
    arm, band = Arm(), 0.02
    truth = {"stabilisation_time": arm.stabilisation(0.3, band), "overshoot": arm.overshoot(0.3)}
    inside = dict.fromkeys(truth, 0)
    for seed in range(RUNS):
        rng = np.random.default_rng(seed)
        how = {"noise": noise, "hz": hz, "division": 0.001, "dwell": 4.0}
        time, reading, _ = streams.visits(rng, count=count, **how)
        time = time + rng.uniform(0, 1 / hz)
        for one in visits(as_run(time, reading), poses=["P1", "-"], band=band).characteristics:
            low, high = one.estimate.interval or (0.0, 0.0)
            inside[one.code] += low <= truth[one.code] <= high
    said = ", ".join(f"{code} {n / RUNS:.0%}" for code, n in inside.items())
    print(f"{count} arrivals, {hz:g} Hz, noise {noise} mm: {said}")


def found(noise: float, hz: float) -> None:
    """Print how many of twelve visits are found, and how many that are none."""
    right = wrong = refused = 0
    for seed in range(RUNS // 4):
        rng = np.random.default_rng(seed)
        time, reading, poses = streams.visits(rng, count=12, noise=noise, hz=hz, division=0.001)
        try:
            means = [v.mean["X"] for v in visits(as_run(time, reading), poses=["P1", "-"]).visits]
        except Exception as error:  # noqa: BLE001 - counted
            refused += 1
            print("  refused:", str(error)[:90])
            continue
        near = [np.abs(poses - mean).min() < 0.002 + noise for mean in means]
        right, wrong = right + sum(near), wrong + len(near) - sum(near)
    whole = 12 * (RUNS // 4 - refused)
    print(f"noise {noise} mm, {hz:g} Hz: {right} of {whole} found, {wrong} invented, "
          f"{refused} of {RUNS // 4} streams refused")  # fmt: skip


if __name__ == "__main__":
    speed()
    for hz in (50.0, 500.0):
        for noise in (0.0002, 0.002, 0.01):
            found(noise, hz)
    for count in (3, 5):
        for noise, hz in ((0.0005, 500.0), (0.002, 500.0), (0.0005, 100.0)):
            coverage(count, noise, hz)
