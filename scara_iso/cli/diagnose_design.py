"""``scara-iso diagnose --design``: what a planned test will be able to tell."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from scara_iso.cli.output import write_json, write_report
from scara_iso.diagnosis import CyclesWanted, PlannedRun, design, planned_columns
from scara_iso.effects import Conditions, find_effects
from scara_iso.errors import DataError, UsageError
from scara_iso.iso9283 import CYCLES_RUN
from scara_iso.library import TableOptions, defined
from scara_iso.quantities import Dimension
from scara_iso.render import design_json
from scara_iso.reporting import design_report
from scara_iso.run import FloatArray, Run

_SIGMA_MM, _RESOLUTION_MM = 0.005, 0.001


def show_design(
    tables: Sequence[str],
    reading: TableOptions,
    wanted: CyclesWanted,
    *,
    sigma: float | None,
    columns: str | None,
    effects: str | None,
    seed: int,
    as_json: bool,
) -> None:
    """Write what a test like that of a table, or of the options, will find."""
    if len(tables) > 1:
        raise UsageError("--design takes one table at most")
    if sigma is not None and not 0 < sigma < math.inf:
        raise UsageError(f"--sigma {sigma:g}: not a positive, finite length")
    plan = (
        _like(wanted.take(reading.read(tables[0])), sigma)
        if tables
        else _planned(wanted.cycles or CYCLES_RUN, sigma, reading.resolution, columns or "")
    )
    found = design(plan, seed=seed, effects=find_effects(defined(effects or ())))
    if as_json:
        write_json(design_json(plan, found))
    else:
        write_report(design_report(plan, found))


def _like(run: Run, sigma: float | None) -> PlannedRun:
    """Return the test of a table: its columns, its dial, its scatter from cycle to cycle."""
    lengths = [axis for axis in run.axes.values() if axis.dimension is Dimension.LENGTH]
    if not lengths:
        raise DataError(
            "no axis in mm",
            where=run.origin.source,
            remedy="plan without the table: --sigma and --resolution, angles read as mm",
        )
    axis = max(lengths, key=lambda axis: _scatter(axis.readings))
    scatter = sigma or _scatter(axis.readings) or (axis.resolution or _RESOLUTION_MM)
    return PlannedRun(Conditions(run.cycle, run.covariates), scatter, axis.resolution or 0.0)


def _scatter(readings: FloatArray) -> float:
    """Return the standard deviation from successive differences, which a slow course leaves."""
    return float(np.sqrt((np.diff(readings) ** 2).mean() / 2)) if len(readings) > 1 else 0.0


def _planned(
    cycles: int, sigma: float | None, resolution: float | None, columns: str
) -> PlannedRun:
    cycle = np.arange(2, cycles + 1)
    known = planned_columns(cycle)
    names = [name.strip() for name in columns.split(",") if name.strip()]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise UsageError(
            f"--columns {unknown[0]}: no such column", remedy=f"known are {', '.join(known)}"
        )
    return PlannedRun(
        Conditions(cycle, {name: known[name] for name in names}),
        sigma or _SIGMA_MM,
        _RESOLUTION_MM if resolution is None else resolution,
    )
