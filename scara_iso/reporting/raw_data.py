"""The rows of the table as they were read, each with its line."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal

import numpy as np

from scara_iso.iso9283 import Analysis, PoseResult
from scara_iso.reporting.blocks import Block, Number, Report, Section, Table, Text
from scara_iso.run import Axis, FloatArray, IntArray, Run

Columns = dict[str, list[Number] | list[str]]


def readings_report(run: Run) -> Report:
    """Return every row of a run; lengths in mm, angles in degrees."""
    poses: Columns = {} if run.pose is None else {"pose": run.pose.tolist()}
    columns = {**poses, **_columns(run, np.arange(len(run)))}
    return (Section(run.origin.source, (Text(run.origin.understood), _table(run, columns))),)


def raw_data(analysis: Analysis, pose: PoseResult) -> Iterator[Block]:
    """Yield every row of a pose, the discarded ones marked; lengths in mm, angles in degrees."""
    run = analysis.run
    rows = dict(run.rows_by_pose())[pose.label]
    counted = set(pose.rows.tolist())
    counts = ["yes" if row in counted else "discarded" for row in rows.tolist()]
    yield _table(run, {**_columns(run, rows), "counts": counts})


def _columns(run: Run, rows: IntArray) -> Columns:
    numbers = {"line": run.lines, "cycle": run.cycle}
    columns: Columns = {
        name: [Number(n) for n in values[rows].tolist()]
        for name, values in numbers.items()
        if values is not None
    }
    columns |= {
        f"{axis.name} [{axis.unit}]": _digits(axis, axis.readings[rows])
        for axis in run.axes.values()
    }
    columns |= {
        f"{axis.name} displayed [{axis.unit}]": _digits(axis, axis.displayed[rows])
        for axis in run.axes.values()
        if axis.displayed is not None
    }
    columns |= {
        name: [Number(v, ".12g") for v in values[rows].tolist()]
        for name, values in run.covariates.items()
    }
    return columns


def _table(run: Run, columns: Columns) -> Table:
    note = "" if run.lines is None else f"line: where the row stands in {run.origin.source}"
    return Table(tuple(columns), tuple(zip(*columns.values(), strict=True)), note)


def _digits(axis: Axis, values: FloatArray) -> list[Number]:
    """Return readings with the digits of the dial, or with all where those do not hold them."""
    if axis.resolution is None:
        return [Number(v, ".12g") for v in values.tolist()]
    places = max(0, -int(Decimal(repr(axis.resolution)).normalize().as_tuple().exponent))
    exact = f".{places}f"
    return [Number(v, exact if round(v, places) == v else ".12g") for v in values.tolist()]
