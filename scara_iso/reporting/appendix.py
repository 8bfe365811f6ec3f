"""What a report holds for who checks it: every value up to RP, and every reading.

The rows of the table stand as they were read, each with its line.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from decimal import Decimal

import numpy as np

from scara_iso.iso9283 import (
    Analysis,
    AxisResult,
    OtherTests,
    PoseResult,
    RadialResult,
    poses_in_cycles,
)
from scara_iso.reporting.blocks import Block, Report, Section, Table, Text
from scara_iso.reporting.digits import Cell, Number, decimals
from scara_iso.reporting.figures import characteristics, pose_figures
from scara_iso.reporting.limits import table_of_limits
from scara_iso.reporting.stated import conditions
from scara_iso.run import Axis, FloatArray, IntArray, Run

_MORE_PLACES = 1
"""Than show three digits of the finest dial's step: sums then agree to the last one printed."""
_SUMS = (
    "l_j: distance of cycle j from the mean (of an axis, eq. 2) or from the barycentre "
    "(XY and XYZ, 7.2.2); S_l with n - 1; eq. 23 is the root of RP² of X plus RP² of Y. "
    "Computed with all digits; more of them are printed here than the figures bear, so that "
    "each can be checked by hand."
)
Columns = dict[str, list[Number] | list[str]]


def intermediates(pose: PoseResult) -> Iterator[Block]:
    """Yield sums, means and standard deviations behind each RP, eq. 2-6 and 7.2.2."""
    places = _places(pose)
    found: list[tuple[str, str, AxisResult | RadialResult]] = [
        *((axis.name, axis.unit, axis) for axis in pose.axes.values()),
        *((name, "mm", one) for name, one in (("XY", pose.XY), ("XYZ", pose.XYZ)) if one),
    ]
    sums = ("sum", "mean", "sum of l_j", "l_bar", "sum of (l_j - l_bar)²", "S_l")
    yield Table(
        ("figure", "unit", "n", *sums, "RP = l_bar + 3 S_l"),
        tuple((name, unit, *_sums(one, places, len(pose.rows))) for name, unit, one in found),
        _SUMS,
    )
    for axis in pose.axes.values():
        if axis.unit == "deg":
            figures = (axis.three_sigma / 3, axis.three_sigma)
            row: tuple[Cell, ...] = (axis.name, *(Number(v, f".{places}f") for v in figures))
            yield Table(("angle", "S [deg]", "RP = ± 3 S [deg]"), (row,), "7.2.2, S with n - 1")


def _sums(found: AxisResult | RadialResult, places: int, n: int) -> tuple[Cell, ...]:
    spec, mean = f".{places}f", None
    if isinstance(found, AxisResult):
        n, mean = found.n, found.mean
    return (
        Number(n),
        *("" if mean is None else Number(v * mean, spec) for v in (n, 1)),
        Number(n * found.l_bar, spec),
        Number(found.l_bar, spec),
        Number((n - 1) * found.S_l**2, ".6g"),
        Number(found.S_l, spec),
        Number(found.RP, spec),
    )


def by_cycle(pose: PoseResult) -> Table:
    """Return the deviation of each cycle from the mean, and its distance to the barycentre."""
    places, axes = _places(pose), pose.axes.values()
    columns = {f"{one.name} - mean [{one.unit}]": one.readings - one.mean for one in axes}
    cells = [[Number(v, f"+.{places}f") for v in values.tolist()] for values in columns.values()]
    radial = [name for name in ("XY", "XYZ") if name in pose.figures]
    for name in radial:
        deviations = [pose.axes[axis].readings - pose.axes[axis].mean for axis in name]
        distances = np.linalg.norm(deviations, axis=0)
        cells.append([Number(v, f".{places}f") for v in distances.tolist()])
    return Table(
        ("cycle", *columns, *(f"l_j {name} [mm]" for name in radial)),
        tuple(zip(map(Number, pose.cycle.tolist()), *cells, strict=True)),
        "l_j of an axis is the deviation without its sign",
    )


def _places(pose: PoseResult) -> int:
    """Return decimal places: some more than the finest dial shows."""
    steps = [axis.resolution or axis.three_sigma for axis in pose.axes.values()]
    return decimals([step for step in steps if step]) + _MORE_PLACES


def readings_report(run: Run) -> Report:
    """Return every row of a run; lengths in mm, angles in degrees."""
    poses: Columns = {} if run.pose is None else {"pose": run.pose.tolist()}
    columns = {**poses, **_columns(run, np.arange(len(run)))}
    return (Section(run.origin.source, (Text(run.origin.understood), _table(run, columns))),)


def raw_data(analysis: Analysis, pose: PoseResult) -> Table:
    """Return every row of a pose, the discarded ones marked; lengths in mm, angles in degrees."""
    run = analysis.run
    rows = dict(run.rows_by_pose())[pose.label]
    counted = set(pose.rows.tolist())
    counts = ["yes" if row in counted else "discarded" for row in rows.tolist()]
    return _table(run, {**_columns(run, rows), "counts": counts})


def _columns(run: Run, rows: IntArray) -> Columns:
    columns: Columns = {}
    for name, numbers in (("line", run.lines), ("cycle", run.cycle)):
        if numbers is not None:
            columns[name] = [Number(n) for n in numbers[rows].tolist()]
    for axis in run.axes.values():
        columns[f"{axis.name} [{axis.unit}]"] = _digits(axis, axis.readings[rows])
    for axis in run.axes.values():
        if axis.displayed is not None:
            name = f"{axis.name} displayed [{axis.unit}]"
            columns[name] = _digits(axis, axis.displayed[rows])
    for name, values in run.covariates.items():
        columns[name] = [Number(v, ".12g") for v in values[rows].tolist()]
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


def appendix(analysis: Analysis, interpreted: Sequence[Section]) -> Iterator[Section]:
    """Yield figures, limits, what is ``interpreted``, intermediate values and readings."""
    poses = poses_in_cycles(analysis)
    for pose in poses:
        yield Section(at_pose("Repeatability", pose), tuple(pose_figures(pose)))
    every = (*characteristics(analysis, advice=False), *table_of_limits(analysis.limits))
    yield from (replace(section, heading=section.heading.capitalize()) for section in every)
    yield from interpreted
    for pose in poses:
        yield Section(at_pose("Intermediate values", pose), tuple(intermediates(pose)))
        yield Section(at_pose("Deviations of each cycle", pose), (by_cycle(pose),))
    for pose in analysis.poses:
        yield Section(at_pose("Raw data", pose), (raw_data(analysis, pose),))


def at_pose(heading: str, pose: PoseResult) -> str:
    """Return a heading with the pose that it is of, where it has a name."""
    return heading if pose.label is None else f"{heading} at pose {pose.label}"


def of_part(heading: str, name: str) -> str:
    """Return a heading with the joint that a push test is of, where it has one."""
    joint = name.partition("-")[2]
    return f"{heading} of {joint}" if joint else heading


def other_readings(other_tests: OtherTests) -> Iterator[Section]:
    """Yield the conditions and every reading of the drift and push tests."""
    if (drift := other_tests.drift) is not None:
        yield Section("Conditions of the drift test", conditions(drift.run, drift.cycles))
        for pose in drift.poses:
            yield Section("Raw data of the drift test", (raw_data(drift, pose),))
    for name, found in other_tests.pushes.items():
        pairs = zip(found.loop.force.tolist(), found.loop.reading.tolist(), strict=True)
        rows = tuple(
            (Number(k), Number(force, ".12g"), Number(reading, ".12g"))
            for k, (force, reading) in enumerate(pairs, 1)
        )
        steps = Table(("step", "force [N]", "reading [mm]"), rows)
        yield Section(of_part("Raw data of the push test", name), (steps,))
