"""Many robots: what is found among 1,000 of which 30 are ill, and what each engine takes.

    python benchmarks/fleet.py                      every table, one after the other
    python benchmarks/fleet.py --only sums dated    some of them
    python benchmarks/fleet.py --sums 1e6 --robots 500 --compared 50 --fleets 2 --dated 1e5  smaller

Found: what stands out. Engines: the same tables by one process, two, and Dask.
One table of 31 cycles and three axes for each robot; the ill have a step of four standard
deviations in one axis. Times are of one run. Beside them stand seconds of processor of the busiest
process, whose ratio is what the work can be shared where the cores have no other. Memory is the
largest of any process (Linux).

Sums: tables of 31 cycles and three axes in Parquet files of 3.3 million rows, their figures by
`fleet_figures` (with manifest and summary) beside one bare DuckDB query for the same figures, and
one for means and standard deviations only; each in a process of its own, two threads.

Drift: 1,000 robots tested monthly; tests of a robot differ by 5 % beside their sampling, and of 30
robots the scatter grows evenly by a share of the first a month.

Dated: the same from figures of monthly tests, 24 a robot, that are there already: in a process of
its own, with the memory that the summary of figures lets DuckDB have.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import duckdb
import numpy as np

import scara_iso
from scara_iso.fleets.database import results_in
from scara_iso.fleets.drift import fleet_drift
from scara_iso.fleets.summary import LEVEL

SIGMA, STEP, PART = 0.003, 4, 25
TABLES, READINGS = 107_526, 93
"""Tables of a Parquet file, readings of a table."""
DATES = 24
GROWTHS = ((4, 0.1), (12, 0.0), (12, 0.02), (12, 0.05), (24, 0.02))
"""Dates, and the share by which the scatter grows in a month."""
TABLES_MADE = ("found", "engines", "sums", "drift", "dated")
NORMAL = f"round({SIGMA} * sqrt(-2 * ln(1 - random())) * cos(2 * pi() * random()), 3)"
MANY = f"""SELECT 'R' || (k // 20) AS robot, 't' || (k % 20) AS test, c::INTEGER AS cycle,
    {NORMAL} AS X, {NORMAL} AS Y, {NORMAL} AS Z FROM range(?, ?) a(k), range(1, 32) b(c)
    ORDER BY k, c"""  # noqa: S608 - of these constants
ONLY_SUMS = """SELECT robot, test, avg(X), stddev(X), avg(Y), stddev(Y), avg(Z), stddev(Z)
    FROM readings WHERE cycle > 1 GROUP BY robot, test"""
FIGURES = """WITH own AS (FROM readings WHERE cycle > 1),
    mean AS (SELECT robot, test, avg(X) mx, avg(Y) my, avg(Z) mz FROM own GROUP BY robot, test),
    l AS (SELECT robot, test, abs(X - mx) x, abs(Y - my) y, abs(Z - mz) z,
          sqrt((X - mx)**2 + (Y - my)**2) xy, sqrt((X - mx)**2 + (Y - my)**2 + (Z - mz)**2) xyz
          FROM own JOIN mean USING (robot, test))
    SELECT robot, test, avg(x) + 3 * stddev(x), avg(y) + 3 * stddev(y), avg(z) + 3 * stddev(z),
    avg(xy) + 3 * stddev(xy), avg(xyz) + 3 * stddev(xyz) FROM l GROUP BY robot, test"""


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
    with looking(peak) as found:
        most: list[float] = []
        yield most
    most.append(max(found.values()))


@contextmanager
def looking(at: Callable[[Path], float]) -> Iterator[dict[str, float]]:
    """Yield what is last seen of each process."""
    seen, done = dict[str, float](), threading.Event()

    def look() -> None:
        while not done.wait(0.1):
            seen.update({path.name: at(path) for path in Path("/proc").glob("[0-9]*")})

    thread = threading.Thread(target=look)
    thread.start()
    try:
        yield seen
    finally:
        done.set()
        thread.join()


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


def processor(process: Path) -> float:
    """Return the seconds of processor that another process of this group has taken."""
    try:
        pid = int(process.name)
        if pid == os.getpid() or os.getpgid(pid) != os.getpgid(0):
            return 0.0
        fields = (process / "stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")


def digest(to: Path) -> int:
    """Return a number that two runs share where their results are the same."""
    return hash(tuple(sorted(map(repr, duckdb.sql(f"FROM '{to}/parts/*.parquet'").fetchall()))))


def dask(source: Path, to: Path) -> tuple[float, float]:
    """Return what is `shared` with a scheduler and two workers as processes of their own."""
    from distributed import LocalCluster  # noqa: PLC0415 - an extra

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        address = cluster.scheduler_address.removeprefix("tcp://")
        return shared(source, to, engine=f"dask://{address}")


def shared(source: Path, to: Path, **options: object) -> tuple[float, float]:
    """Return the seconds of a run, and those of processor of the busiest process."""
    before = {path.name: processor(path) for path in Path("/proc").glob("[0-9]*")}
    with looking(processor) as seen:
        taken, _ = seconds(source, to, **options)
    return taken, max(used - before.get(name, 0.0) for name, used in seen.items())


def compare(folder: Path, robots: int, ill: int) -> None:
    """Print what each engine takes for the same robots."""
    source = folder / "few"
    write(source, robots, ill)
    found = {
        "1 process": shared(source, folder / "one", workers=1),
        "2 processes": shared(source, folder / "two", workers=2),
        "Dask, 2 workers": dask(source, folder / "dask"),
    }
    same = len({digest(folder / name) for name in ("one", "two", "dask")}) == 1
    print(f"{robots} robots in {-(-robots // PART)} parts, {ill} of them with a step; "
          f"equal results: {same}")  # fmt: skip
    one, busy = found["1 process"]
    without = bare(source)
    print(f"  bare DuckDB, sums only  {without:7.2f} s  {one / without:.0f} times as fast as one "
          "process")  # fmt: skip
    for name, (taken, used) in found.items():
        wall = f"{taken:7.2f} s  {robots / taken:5.1f} tables/s  {one / taken:.2f} x"
        print(f"  {name:22}  {wall}; busiest process {used:6.2f} s of processor  "
              f"{busy / used:.2f} x", flush=True)  # fmt: skip


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


def by_query(source: Path, to: Path, sql: str) -> None:
    """Write what a bare query gives."""
    connection = duckdb.connect()
    connection.execute("SET threads = 2")
    connection.execute("SET enable_progress_bar = false")
    connection.execute(f"CREATE VIEW readings AS FROM '{source}/*.parquet'")
    connection.execute(f"COPY ({sql}) TO '{to}.parquet'")


def by_figures(source: Path, to: Path) -> None:
    """Write the figures as the program does."""
    scara_iso.fleet_figures(source, to, unit="mm", resolution=0.001, workers=2)


def measured(work: Callable[..., None], *given: object) -> tuple[float, float, float]:
    """Return seconds, those of processor, and the peak of memory [MB]."""
    start, used = time.perf_counter(), time.process_time()
    work(*given)
    taken = time.perf_counter() - start, time.process_time() - used
    return *taken, peak(Path("/proc", str(os.getpid())))


def apart(work: Callable[..., None], *given: object) -> tuple[float, float, float]:
    """Return what is `measured` in a process of its own."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        return pool.submit(measured, work, *given).result()


def sums(folder: Path, readings: int) -> None:
    """Print what the figures of so many readings take."""
    source, tables = folder / "many", readings // READINGS
    source.mkdir()
    for first in range(0, tables, TABLES):
        made, ends = f"{source}/{first:08}.parquet", [first, min(first + TABLES, tables)]
        duckdb.execute(f"COPY ({MANY}) TO '{made}'", ends)
    found = {
        "this program": apart(by_figures, source, folder / "out"),
        "bare, same figures": apart(by_query, source, folder / "figures", FIGURES),
        "bare, sums only": apart(by_query, source, folder / "sums", ONLY_SUMS),
    }
    print(f"{readings:,} readings in {tables:,} tables; {differing(source, folder / 'out')}")
    seconds, used, _ = found["this program"]
    for name, (wall, processor, peak_MB) in found.items():
        ratios = f"this program {seconds / wall:.2f} and {used / processor:.2f} times"
        taken = f"{wall:7.2f} s, of processor {processor:7.2f} s, {peak_MB:5.0f} MB"
        print(f"  {name:20} {taken}; {ratios}", flush=True)


def drifting(folder: Path, fleets: int, dates: int, growth: float, robots: int, ill: int) -> None:
    """Print how many of the growing robots are named, and how many others."""
    import pandas as pd  # noqa: PLC0415 - it would count as memory of the sums

    named, false, covered = 0, 0.0, 0
    for k in range(fleets):
        rng, source = np.random.default_rng(k), folder / str(k)
        source.mkdir()
        grown = 1 + growth * np.arange(dates) * (np.arange(robots) < ill)[:, None]
        size = SIGMA * grown * np.exp(rng.normal(0, 0.05, (robots, dates)))
        X, Y = (rng.normal(0, 1, (2, robots, dates, 31)) * size[..., None]).round(3).reshape(2, -1)
        frame = pd.DataFrame({"robot": np.repeat(np.arange(robots), dates * 31)})
        months = [f"{2024 + m // 12}-{m % 12 + 1:02}-05" for m in range(dates)]
        frame["test"] = np.tile(np.repeat(months, 31), robots)
        frame["cycle"] = np.tile(np.arange(1, 32), robots * dates)
        duckdb.from_df(frame.assign(X=X, Y=Y)).write_parquet(str(source / "a.parquet"))
        drift = scara_iso.fleet_figures(source, folder / f"o{k}", unit="mm").drift
        ill_ones = [one for one in drift.growing if int(one.robot) < ill]
        named += len(ill_ones)
        false += (len(drift.growing) - len(ill_ones)) / max(len(drift.growing), 1)
        covered += drift.interval[0] <= 0 <= drift.interval[1]
    print(f"{dates} dates, {growth:.0%} a month: {named / fleets:.1f} of {ill} named; of the named "
          f"{false / fleets:.3f} healthy; no drift of the fleet in the interval of {covered} of "
          f"{fleets}", flush=True)  # fmt: skip


def dated(folder: Path, tests: int) -> None:
    """Print what the drift of so many dated tests takes."""
    made = f"""SELECT 'R' || (k // {DATES}) AS robot, robot AS name, NULL AS error,
        strftime(DATE '2024-01-05' + to_months((k % {DATES})::INTEGER), '%Y-%m-%d') AS test,
        NULL::VARCHAR AS date, NULL::DOUBLE AS RP_X, NULL::DOUBLE AS RP_Y, NULL::DOUBLE AS RP_Z,
        NULL::DOUBLE AS RP_theta,
        {SIGMA} * exp(0.1 * sqrt(-2 * ln(1 - random())) * cos(2 * pi() * random())) AS RP_XY
        FROM range({tests}) a(k)"""  # noqa: S608
    duckdb.execute(f"COPY ({made}) TO '{folder}/a.parquet'")
    _, used, peak_MB = apart(by_drift, folder)
    print(f"{tests:,} dated tests, {-(-tests // DATES):,} robots: of processor {used:.1f} s, "
          f"{peak_MB:.0f} MB", flush=True)  # fmt: skip


def by_drift(folder: Path) -> None:
    """Look how the figures in a folder move, as the summary does."""
    with results_in(folder) as query:
        drift = fleet_drift(query, LEVEL)
    if drift is None or len(drift.periods) != DATES:
        raise SystemExit("the drift is not of the dates that were made")


def differing(source: Path, to: Path, sample: int = 50) -> str:
    """Return how far the figures of some tables are from those of `analyze`."""
    part = min(source.glob("*.parquet"))
    rows = (
        duckdb.sql(f"FROM '{to}/parts/{part.name}-*.parquet'").df().sample(sample, random_state=1)
    )
    worst = 0.0
    for row in rows.itertuples():
        mine = f"robot = '{row.robot}' AND test = '{row.test}'"
        table = duckdb.read_parquet(str(part)).filter(mine).order("cycle")
        run = scara_iso.Run.from_frame(table.select("cycle, X, Y, Z").df(), unit="mm")
        pose = scara_iso.analyze(run).poses[0]
        own = {**pose.axes, "XY": pose.XY, "XYZ": pose.XYZ}
        worst = max(*(abs(getattr(row, f"RP_{k}") / one.RP - 1) for k, one in own.items()), worst)
    return f"{sample} of them differ from analyze by at most {worst:.0e} of a figure"


def in_a_folder(work: Callable[..., None], *given: object) -> None:
    """Print what some work takes, with a folder that ends with it."""
    with tempfile.TemporaryDirectory() as name:
        work(Path(name), *given)


def main() -> None:
    """Print what is found, and what it takes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", choices=TABLES_MADE, default=TABLES_MADE)
    parser.add_argument("--sums", type=float, nargs="*", default=(1e6, 1e7, 1e8), help="readings")
    parser.add_argument("--compared", type=int, default=100, help="robots, by each engine")
    parser.add_argument("--robots", type=int, default=1000, help="of the fleet, and a tenth")
    parser.add_argument("--ill", type=int, default=30)
    parser.add_argument("--fleets", type=int, default=10, help="whose RP moves")
    parser.add_argument("--dated", type=float, nargs="*", default=(1e5, 1e6, 1e7), help="tests")
    given = parser.parse_args()
    few, tenth = given.compared // 4, given.robots // 10
    tables: dict[str, list[tuple[object, ...]]] = {
        "sums": [(sums, int(readings)) for readings in given.sums],
        "engines": [(compare, given.compared, 0), (compare, few, few)],
        "found": [(find, given.robots, given.ill), (find, tenth, 1)],
        "drift": [(drifting, given.fleets, dates, growth, 1000, 30 if growth else 0)
                  for dates, growth in GROWTHS],
        "dated": [(dated, int(tests)) for tests in given.dated],
    }  # fmt: skip
    for name in given.only:
        print(f"\n{name}", flush=True)
        for row in tables[name]:
            in_a_folder(*row)


if __name__ == "__main__":
    main()
