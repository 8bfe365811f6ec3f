"""Series of readings, cut into tests, and what the program says of each.

A folder holds tables that the program reads; every axis of a table is a series. The program is
asked through `analyze --json` and `diagnose --json`, so that any version of it can be.
"""

from __future__ import annotations

import contextlib
import io
import json
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import scara_iso
from benchmarks.study.courses import NEXT, Array
from benchmarks.study.judge import NOTHING, UNEXPLAINED, judged
from scara_iso.commands import main as program

SHIPPED = tuple(Path(__file__).parents[1] / "data" / name for name in ("probe_thermal", "nist"))


@dataclass(frozen=True)
class Series:
    """Readings in whole divisions of a dial."""

    set: str
    name: str
    divisions: Array
    division: float


@dataclass(frozen=True)
class Statement:
    """What the program states about one test."""

    names: tuple[str, ...]
    """Effects in the order found; NOTHING, or UNEXPLAINED."""
    probability: float | None
    """Of the first name."""
    sampling: tuple[float, float] | None
    """95 % interval of RP from the cycles of this test [mm]; None where none is given."""
    predicted: tuple[float, float] | None
    """95 % prediction interval of RP of a next test of 30 cycles [mm]."""
    held_out: float
    """Error on cycles that the fit did not see [mm]."""


@dataclass(frozen=True)
class Outcome:
    """One test and the readings that came next."""

    set: str
    series: str
    start: int
    rows: int
    stated: Statement
    next_nothing: bool
    """Nothing was found in the next test either."""
    RP: float
    """Of the next test [mm]."""
    scatter: tuple[float, float]
    """Of the next readings, about their mean and by successive differences [mm]."""
    verdict: str
    goes_on: bool


def series_in(folder: Path) -> Iterator[Series]:
    """Yield every axis of every table of a folder; a table that cannot be read is named."""
    for path in sorted(folder.glob("*.csv")):
        try:
            run = scara_iso.read_table(path)
        except Exception as error:  # noqa: BLE001 - of a folder of anybody's
            print(f"{path}: left out: {error}")
            continue
        for name, axis in run.axes.items():
            label = path.stem if len(run.axes) == 1 else f"{path.stem} {name}"
            yield Series(folder.name, label, np.rint(axis.readings / axis.resolution),
                         axis.resolution)  # fmt: skip


def starts(series: Series, rows: int) -> range:
    """Return where tests begin, one after the other, each with NEXT readings after it."""
    return range(0, len(series.divisions) - rows - NEXT + 1, rows)


def outcome(series: Series, start: int, rows: int) -> Outcome | None:
    """Return what became of a test; None where no reading moves."""
    y = series.divisions[start : start + rows]
    z = series.divisions[start + rows : start + rows + NEXT]
    if not np.ptp(y) or not np.ptp(z):
        return None
    stated = statement(tuple(y), series.division)
    first, second = stated.names[0], stated.names[1] if len(stated.names) > 1 else None
    came = judged(first, y, z, second)
    nothing = first == NOTHING and statement(tuple(z), series.division).names[0] == NOTHING
    apart = float(np.sqrt((np.diff(z) ** 2).mean() / 2))
    return Outcome(
        series.set, series.name, start, rows, stated, nothing, repeatability(z) * series.division,
        (float(z.std(ddof=1)) * series.division, apart * series.division), came.verdict,
        came.goes_on,
    )  # fmt: skip


def repeatability(z: Array) -> float:
    """Return RP of readings along one axis: ISO 9283 7.2.2, mean distance and three deviations."""
    distance = np.abs(z - z.mean())
    return float(distance.mean() + 3 * distance.std(ddof=1))


@cache
def statement(y: tuple[float, ...], division: float) -> Statement:
    """Return what `analyze` and `diagnose` say of readings in divisions [mm]."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "test.csv")
        rows = [f"{k},{v * division:.9f}" for k, v in enumerate(y, 1)]
        head = ["# unit: mm", f"# resolution: {division:.9f}", "# first_cycle: counts", "cycle,Z"]
        path.write_text("\n".join([*head, *rows, ""]), encoding="utf-8")
        given = [str(path), "--cycles", str(len(y)), "--json"]
        analysis, diagnosis = (answer([name, *given]) for name in ("analyze", "diagnose"))
    found, kind = diagnosis["effects"], diagnosis["verdict"]
    unnamed = NOTHING if kind == "nothing-to-explain" else UNEXPLAINED
    completed = diagnosis["repeatability"]["completed"].get("Z")
    sampling = analysis["poses"][0]["axes"]["Z"]["RP_interval"]
    return Statement(
        tuple(one["effect"] for one in found) or (unnamed,),
        found[0]["probability"] if found else None,
        sampling and tuple(sampling),
        completed and tuple(completed["interval"]),
        diagnosis["error"]["after"]["held_out_rms"]["Z"],
    )  # fmt: skip


def answer(arguments: Sequence[str]) -> dict:
    """Return the JSON object of a command."""
    words = io.StringIO()
    with contextlib.redirect_stdout(words), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        program(list(arguments))
    return json.loads(words.getvalue())
