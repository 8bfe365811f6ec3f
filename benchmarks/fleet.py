"""Many robots: what is found among 1,000 of which 30 are ill, and what each engine takes.

    python benchmarks/fleet.py [--robots 1000] [--ill 30] [--compared 100]
    python benchmarks/fleet.py --robots 0          only what each engine takes

One table of 31 cycles and three axes for each robot; the ill have a step of four standard
deviations in one axis. Times are of one run; the ratios are to one process of this machine, and
say little where it has other work. Memory is the largest of any process (Linux).
"""

from __future__ import annotations

import argparse
import os
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import duckdb
import numpy as np

import scara_iso

SIGMA, STEP, PART = 0.003, 4, 25


def write(folder: Path, robots: int, ill: int) -> set[str]:
    """Write parts of 25 robots each; return the names of the ill."""
    folder.mkdir()
    rng = np.random.default_rng(1)
    chosen = {f"R{k:05}" for k in rng.choice(robots, ill, replace=False)}
    for first in range(0, robots, PART):
        lines = ["# unit: mm", "# resolution: 0.001", "robot,test,cycle,X,Y,Z"]
        for k in range(first, min(first + PART, robots)):
            name, values = f"R{k:05}", rng.normal(0, SIGMA, (31, 3))
            if name in chosen:
                values[int(rng.integers(8, 24)) :, int(rng.integers(3))] += STEP * SIGMA
            lines += [f"{name},t,{n}," + ",".join(f"{x:.3f}" for x in row)
                      for n, row in enumerate(values, 1)]  # fmt: skip
        (folder / f"{first:05}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return chosen


def bare(source: Path) -> float:
    """Return the seconds that a bare DuckDB query takes for the sums of the same readings."""
    start = time.perf_counter()
    sql = "SELECT robot, avg(X), stddev(X), avg(Y), stddev(Y), avg(Z), stddev(Z) FROM read_csv(?,"
    duckdb.execute(f"{sql} comment='#') GROUP BY robot", [str(source / "*.csv")]).fetchall()
    return time.perf_counter() - start


def seconds(source: Path, to: Path, **options: object) -> tuple[float, scara_iso.FleetSummary]:
    """Return the seconds of a run, and its summary."""
    start = time.perf_counter()
    found = scara_iso.fleet(source, to, **options)
    return time.perf_counter() - start, found


@contextmanager
def watched() -> Iterator[list[float]]:
    """Yield a list that ends with the most memory [MB] that a process of this group took."""
    most, done = [0.0], threading.Event()

    def look() -> None:
        while not done.wait(0.5):
            most.append(max(map(peak, Path("/proc").glob("[0-9]*")), default=0.0))

    thread = threading.Thread(target=look)
    thread.start()
    try:
        yield most
    finally:
        done.set()
        thread.join()
        most.append(max(most))


def peak(process: Path) -> float:
    """Return the most memory that a process of this group took [MB], 0 for another."""
    try:
        if os.getpgid(int(process.name)) != os.getpgid(0):
            return 0.0
        status = (process / "status").read_text(encoding="utf-8")
    except OSError:
        return 0.0
    found = [line.split()[1] for line in status.splitlines() if line.startswith("VmHWM")]
    return float(found[0]) / 1e3 if found else 0.0


def digest(to: Path) -> int:
    """Return a number that two runs share where their results are the same."""
    return hash(tuple(sorted(map(repr, duckdb.sql(f"FROM '{to}/parts/*.parquet'").fetchall()))))


def dask(source: Path, to: Path) -> float:
    """Return the seconds with a scheduler and two workers as processes of their own."""
    from distributed import LocalCluster  # noqa: PLC0415 - an extra

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        address = cluster.scheduler_address.removeprefix("tcp://")
        return seconds(source, to, engine=f"dask://{address}")[0]


def compare(folder: Path, robots: int, ill: int) -> None:
    """Print what each engine takes for the same robots."""
    source = folder / "few"
    write(source, robots, ill)
    one, _ = seconds(source, folder / "one", workers=1)
    two, _ = seconds(source, folder / "two", workers=2)
    cluster = dask(source, folder / "dask")
    same = len({digest(folder / name) for name in ("one", "two", "dask")}) == 1
    print(f"{robots} robots, {ill} of them with a step; equal results: {same}")
    print(f"  bare DuckDB, sums only  {bare(source):7.2f} s")
    for name, taken in (("1 process", one), ("2 processes", two), ("Dask, 2 workers", cluster)):
        print(f"  {name:22}  {taken:7.2f} s  {robots / taken:5.1f} tables/s  {one / taken:.2f} x")


def closer(to: Path) -> str:
    """Return how many tables were compared with more orders, and with how many."""
    rows = duckdb.sql(f"FROM '{to}/parts/*.parquet'").filter("orders > 999").select("orders")
    found = [orders for (orders,) in rows.fetchall()]
    return f"{len(found)} tables compared with up to {max(found, default=999)} orders"


def find(folder: Path, robots: int, ill: int) -> None:
    """Print which robots are found, and what it takes."""
    chosen = write(folder / "all", robots, ill)
    with watched() as most:
        taken, found = seconds(folder / "all", folder / "results")
    named = {one.robot for one in found.found}
    alone = sum(one.p_value <= found.level for one in found.robots)
    print(f"{robots} robots, {ill} ill: {len(named & chosen)} found, {len(named - chosen)} "
          f"healthy ones named; at 5 % each by itself: {alone}")  # fmt: skip
    first = [one.robot in chosen for one in found.robots[:ill]]
    print(f"  of the first {ill} of the list, {sum(first)} are ill; {closer(folder / 'results')}")
    print(
        f"  {taken:.0f} s, {robots / taken:.1f} tables/s, at most {most[-1]:.0f} MB a process",
        flush=True,
    )


def main() -> None:
    """Print what is found, and what it takes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=1000)
    parser.add_argument("--ill", type=int, default=30)
    parser.add_argument("--compared", type=int, default=100)
    given = parser.parse_args()
    asked = [(given.robots, given.ill), (given.robots // 10, 1)] if given.robots else []
    for robots, ill in asked:
        with tempfile.TemporaryDirectory() as name:
            find(Path(name), robots, ill)
    for ill in (0, given.compared // 4):
        with tempfile.TemporaryDirectory() as name:
            compare(Path(name), given.compared // (4 if ill else 1), ill)


if __name__ == "__main__":
    main()
