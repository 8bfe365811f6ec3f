"""What each step takes beside what a user would take instead: ratios within one run.

    python -m benchmarks.performance [--runs 5] [--write]

Processor seconds (user's and system's) of processes that take turns; medians. From the shell it is
the whole process, else the work alone, without imports. Needs the extras benchmark and fleet.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import duckdb
import numpy as np

from benchmarks.fleet import FIGURES, MANY, write
from benchmarks.page import DOCS, put
from benchmarks.read import write_rows
from benchmarks.startup import COMMANDS, PANDAS_SCRIPT, ROOT, TABLE, seconds

ROWS, TABLES, HZ = 200_000, 20_000, 500
PAGE = DOCS / "evidence" / "program.md"
WORK = """
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
import time
{setup}
def used():
    both = getrusage(RUSAGE_SELF), getrusage(RUSAGE_CHILDREN)
    return sum(one.ru_utime + one.ru_stime for one in both)
{work}
start = used()
{work}
print(used() - start)
"""
"""The second time: the first imports what it needs."""

FORMULA = f"""
import csv
from statistics import fmean, stdev
with open({str(TABLE)!r}) as file:
    rows = [*csv.DictReader(line for line in file if not line.startswith("#"))]
for axis in ["X", "Y", "Z", "theta"]:
    x = [float(row[axis]) / 100 for row in rows]
    l = [abs(one - fmean(x)) for one in x]
    print(axis, fmean(l) + 3 * stdev(l))
"""
PAGE_SCRIPT = f"""{PANDAS_SCRIPT}
import matplotlib
matplotlib.use("Agg")
table.plot(subplots=True)[0].figure.savefig("runs.png")
open("page.html", "w").write(table.describe().to_html() + "<img src='runs.png'>")
"""
SERIES = f"""
import numpy as np, scara_iso
run = scara_iso.read_table({str(TABLE)!r})
series = [axis.readings for axis in run.axes.values()]
"""
SUMS = """duckdb.sql("SELECT robot, avg(X), stddev(X) FROM read_csv('robots/*.csv', comment='#') \\
GROUP BY robot").fetchall()"""
ROLLING = "pandas.read_csv('stream.csv', comment='#').X.rolling(250).std()"
CUSUM = """
for y in series:
    fit = sm.OLS(y, sm.add_constant(np.arange(len(y)))).fit()
    breaks_cusumolsresid(fit.resid, 2), acorr_ljungbox(fit.resid, lags=[5])
"""


@dataclass(frozen=True)
class Work:
    """A script whose work is timed apart from its setup; without a work the whole is."""

    setup: str
    work: str = ""

    def seconds(self, folder: str) -> float:
        """Return the processor time of one process."""
        if not self.work:
            return seconds(["-c", self.setup], folder)
        script = WORK.format(setup=self.setup, work=self.work)
        environment = {"PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
        told = subprocess.run(
            [sys.executable, "-c", script],
            check=True, capture_output=True, text=True, cwd=folder, env=environment,
        )  # fmt: skip
        return float(told.stdout.split()[-1])


@dataclass(frozen=True)
class Pair:
    """A step of this program and what does a part of it, or the same, elsewhere."""

    what: str
    ours: Work
    beside: str
    other: Work
    more: str
    """What this program does more, which is where the time goes."""

    def seconds(self, folder: str) -> tuple[float, float]:
        """Return the processor time of both, one right after the other."""
        return self.ours.seconds(folder), self.other.seconds(folder)


def command(name: str) -> Work:
    """Return a command as a whole process, as from the shell."""
    words = COMMANDS[name][2:]
    run = "runpy.run_module('scara_iso', run_name='__main__')"
    return Work(f"import sys, runpy\nsys.argv[1:] = {words}\n{run}")


def ours(call: str) -> Work:
    """Return a call of a public function."""
    return Work(f"{SERIES}\nfrom scara_iso import *", call)


SMALL, PAGE_OF_ONE = command("analyze, 31 rows"), command("report, Table I")
FIGURES_IN_SQL = FIGURES.replace("FROM readings", "FROM 'many/*.parquet'")
NUMPY = Work(
    SERIES, "for y in series:\n    l = abs(y - y.mean())\n    l.mean() + 3 * l.std(ddof=1)"
)
PELT = "for y in series:\n    ruptures.Pelt('l2').fit(y).predict(pen=3 * y.var())"
STATSMODELS = """
import statsmodels.api as sm
from statsmodels.stats.diagnostic import acorr_ljungbox, breaks_cusumolsresid
"""
PAIRS = (
    Pair("start: `--help`", command("--help"), "bare Python", Work("pass"), "its commands"),
    Pair("`analyze`, 31 rows", SMALL, "a pandas script", Work(PANDAS_SCRIPT),
         "intervals and checks"),
    Pair("`analyze`, 31 rows", SMALL, "the formula in plain Python", Work(FORMULA),
         "numpy and the reader are loaded"),
    Pair("`report`, Table I", PAGE_OF_ONE, "pandas and a picture", Work(PAGE_SCRIPT),
         "diagnosis, held-out error, pictures"),
    Pair(f"read {ROWS:,} rows", ours("read_table('rows.csv')"), "`pandas.read_csv`",
         Work("import pandas", "pandas.read_csv('rows.csv', comment='#')"),
         "finds layout and unit, refuses a doubtful cell"),
    Pair("`analyze` of a `Run`", ours("analyze(run)"), "RP by numpy", NUMPY,
         "jackknife intervals, all checks"),
    Pair("`diagnose` of a `Run`", ours("diagnose(run)"), "ruptures, one step an axis",
         Work(f"{SERIES}\nimport ruptures", PELT), "999 orders, 250 hypotheses, ten folds"),
    Pair("`diagnose` of a `Run`", ours("diagnose(run)"), "statsmodels: trend, CUSUM, Ljung-Box",
         Work(SERIES + STATSMODELS, CUSUM), "the same"),
    Pair(f"RP of {TABLES:,} tables", ours("fleet_figures('many', str(time.time_ns()), unit='mm')"),
         "DuckDB, the same figures",
         Work("import duckdb", f"duckdb.sql({FIGURES_IN_SQL!r}).write_parquet('out.parquet')"),
         "intervals, findings, drift"),
    Pair("100 robots diagnosed", ours("fleet('robots', str(time.time_ns()), workers=1)"),
         "DuckDB, sums only", Work("import duckdb", SUMS), "a diagnosis of each"),
    Pair(f"`visits`, ten minutes at {HZ} Hz", ours("visits('stream.csv', poses=['P1', '-'])"),
         "pandas, rolling deviation", Work("import pandas", ROLLING),
         "visits, stabilisation time, overshoot"),
)  # fmt: skip


def make(folder: Path) -> None:
    """Write the tables, the many robots and the stream."""
    write_rows(folder / "rows.csv", ROWS)
    write(folder / "robots", robots=100, ill=3)
    (folder / "many").mkdir()
    duckdb.sql("SELECT setseed(0.5)").fetchall()
    duckdb.sql(MANY, params=[0, TABLES]).write_parquet(str(folder / "many" / "readings.parquet"))
    time = np.arange(600 * HZ) / HZ
    reading = np.where(time % 6 < 3, 0.4, 2.0) + np.random.default_rng(1).normal(0, 5e-4, len(time))
    table = np.column_stack([time, reading])
    head = "# unit: mm\n# resolution: 0.001\ntime_s,X"
    np.savetxt(folder / "stream.csv", table, "%.3f", ",", header=head, comments="")


def rows(runs: int) -> Iterator[str]:
    """Yield the table of the page."""
    with tempfile.TemporaryDirectory() as folder:
        make(Path(folder))
        times = [[pair.seconds(folder) for pair in PAIRS] for _ in range(runs + 1)]
    yield f"{datetime.now(UTC):%Y-%m-%d}, medians of {runs}, processor seconds.\n"
    yield "| step | s | beside | s | times | what the step does more |\n|---|---|---|---|---|---|"
    # the first turn fills byte code and file cache
    for pair, found in zip(PAIRS, zip(*times[1:], strict=True), strict=True):
        own, other = (statistics.median(column) for column in zip(*found, strict=True))
        ratio = f"{own / other:{'.0f' if own > 10 * other else '.2g'}}"
        yield (f"| {pair.what} | {own:.2g} | {pair.beside} | {other:.2g} | {ratio} |"
               f" {pair.more} |")  # fmt: skip


def main() -> None:
    """Print the table, or write it into the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--write", action="store_true", help=f"write it into {PAGE.name}")
    asked = parser.parse_args()
    body = "\n".join(rows(asked.runs))
    print(body)
    if asked.write:
        text = PAGE.read_text(encoding="utf-8")
        PAGE.write_text(put(text, "beside others", body), encoding="utf-8")


if __name__ == "__main__":
    main()
