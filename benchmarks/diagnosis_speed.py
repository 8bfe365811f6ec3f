"""How long `diagnose` takes: one table in this process, and 200 in one call from the shell.

    python benchmarks/diagnosis_speed.py [--tables 200]

Processor time of one core per table (31 cycles); wall clock, processor time and memory of the call.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from diagnosis_data import shape

from scara_iso.diagnosis.readings import diagnose_readings as diagnose
from scara_iso.run import AXES, Axis, Run

N = 31
SIZE = 4
KINDS = ((), ("step",), ("sticky",), ("step", "alternating"))


def run_of(seed: int, axes: int, kinds: tuple[str, ...]) -> Run:
    """Return scatter on a dial and structures four scatters large; covariates beside four axes."""
    rng = np.random.default_rng(seed)
    course = sum((SIZE * shape(rng, kind, N) for kind in kinds), np.zeros(N))
    values = np.round(3 * (rng.normal(size=(N, axes)) + course[:, np.newaxis]))
    covariates = {
        "temperature_C": 22 + np.cumsum(rng.normal(0, 0.1, N)).round(2),
        "payload_kg": rng.choice([0.0, 2.0, 4.0], N),
        "approach": rng.choice([-1.0, 1.0], N),
    }
    named = {name: Axis(name, values[:, a], resolution=1.0) for a, name in enumerate(AXES[:axes])}
    return Run(np.arange(1, N + 1), named, covariates=covariates if axes > 1 else {})


def seconds(axes: int, kinds: tuple[str, ...]) -> float:
    """Return the median processor time of one diagnosis."""
    spent = []
    for seed in range(15):
        run, start = run_of(seed, axes, kinds), time.process_time()
        diagnose(run)
        spent.append(time.process_time() - start)
    return float(np.median(spent))


def write(run: Run, to: Path) -> None:
    """Write a table of hundredths of a millimetre (and of a degree)."""
    units = [f"{name}_{'deg' if name == 'theta' else 'mm'}" for name in run.axes]
    readings = [axis.readings / 100 for axis in run.axes.values()]
    table = np.column_stack([run.cycle, *readings, *run.covariates.values()])
    header = ",".join(["cycle", *units, *run.covariates])
    np.savetxt(to, table, delimiter=",", header=header, comments="", fmt="%.5g")


def many(tables: int, kinds: tuple[str, ...]) -> str:
    """Return what one call over all tables takes."""
    with tempfile.TemporaryDirectory() as folder:
        names = [Path(folder, f"{i:03}.csv") for i in range(tables)]
        for i, name in enumerate(names):
            write(run_of(i, 4, kinds), name)
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        call = [sys.executable, "-m", "scara_iso", "diagnose", *map(str, names)]
        subprocess.run(call, check=True, capture_output=True)
        wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    rate, memory = tables / wall, after.ru_maxrss / 1e3
    return f"{rate:6.1f} tables/s, {spent / tables:.3f} s of core, {memory:.0f} MB"


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tables", type=int, default=200)
    tables = parser.parse_args().tables
    for kinds in KINDS:
        name = " and ".join(kinds) or "no effect"
        print(f"{name:20} 1 axis {seconds(1, kinds):.3f} s, 4 axes {seconds(4, kinds):.3f} s")
    print("tables, no effect   ", many(tables, ()))
    print("tables, a step      ", many(tables, ("step",)))


if __name__ == "__main__":
    main()
