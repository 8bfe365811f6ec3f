"""What the program says of real readings, held against the readings that came next.

    python -m benchmarks.study [--data FOLDER ...] [--quick] [--write]

Every series is cut into tests of 20, 30, 45 and 60 readings, one after the other. `analyze` and
`diagnose` are asked of each as a user would; what they state is held against the 30 readings that
came next. --data takes folders of tables beside those of benchmarks/data; --every N takes each
N-th test only, --quick a few. --write puts tables and figure into results/study.md.
"""

from __future__ import annotations

import argparse
import datetime as dt
import os
import time
from collections.abc import Iterator
from itertools import chain
from multiprocessing import Pool
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from benchmarks.page import put
from benchmarks.study import mounts, tables, trial
from benchmarks.study.windows import SHIPPED, Outcome, Series, outcome, series_in, starts

PAGE = Path(__file__).parents[1] / "results" / "study.md"
FIGURE = PAGE.parents[2] / "docs" / "figures" / "study.svg"
ROWS = (20, 30, 45, 60)


def jobs(folders: list[Path], every: int) -> list[tuple[Series, int, int]]:
    """Return the tests: series, first reading and length of each."""
    series = list(chain.from_iterable(map(series_in, folders)))
    cuts = [(one, start, rows) for one in series for rows in ROWS for start in starts(one, rows)]
    return cuts[::every]


def main() -> None:
    """Print the tables, and write them."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.study", description=__doc__)
    parser.add_argument("--data", type=Path, nargs="+", default=[])
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--tables", type=int, default=20, help="of each cause, for the judge")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    every, count = (60, 2) if given.quick else (given.every, given.tables)
    begun = time.monotonic()
    cuts = jobs([*SHIPPED, *given.data], every)
    with Pool(given.processes, initializer=os.nice, initargs=(10,)) as pool:
        outcomes = [one for one in pool.starmap(outcome, cuts, chunksize=4) if one]
        judge = dict(pool.starmap(trial.of_cause, [(c, count) for c in trial.FALSE], chunksize=1))
    minutes = (time.monotonic() - begun) / 60
    parts = dict(page_parts(outcomes, judge, f"every {every}" if every > 1 else "all", minutes))
    for name, body in parts.items():
        print(f"{name}\n{body}\n")
    if given.write:
        text = PAGE.read_text(encoding="utf-8")
        for name, body in parts.items():
            text = put(text, name, body)
        PAGE.write_text(text, encoding="utf-8")
        tables.draw(outcomes, FIGURE)


def page_parts(
    outcomes: list[Outcome], judge: trial.Verdicts, taken: str, minutes: float
) -> Iterator[tuple[str, str]]:
    """Yield name and text of every part of the page."""
    today = dt.datetime.now(dt.UTC).date()
    certain = tables.sure(outcomes)
    wrong = sum(one.verdict == "wrong" for one in certain)
    null = [one for one in outcomes if one.next_nothing]
    names = tables.share(wrong, len(certain))
    pairs = tables.share(*tables.inside(null, "predicted"))
    yield (
        "run",
        f"""{today}, {len(outcomes)} tests ({taken}), {minutes:.0f} minutes.

- Names stated at 0.9 or more that are wrong: {names}. Aim: at most 3 %.
- RP of the next test in the prediction interval, null pairs: {pairs}. Aim: 93 to 97 %.""",
    )
    yield "sets", "\n".join(tables.by_set(outcomes))
    yield "names", "\n".join(tables.by_name(outcomes))
    yield "reliability", "\n".join(tables.reliable(outcomes))
    yield "next", "\n".join(tables.next_tests(outcomes))
    yield "judge", "\n".join(tables.trials(judge))
    yield "mounts", "\n".join(tables.mounts(mounts.every()))


if __name__ == "__main__":
    main()
