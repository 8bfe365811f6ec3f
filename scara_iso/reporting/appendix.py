"""What a report holds for who checks it: every figure, every step to it, every reading.

Every value between the readings and RP, so that each figure can be checked by hand.

The rows of the table as they were read, each with its line.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from decimal import Decimal

import numpy as np

from scara_iso.iso9283 import Analysis, AxisResult, PoseResult, RadialResult, poses_in_cycles
from scara_iso.reporting.backlash import backlash_report
from scara_iso.reporting.blocks import Block, Cell, Number, Report, Section, Table, Text, decimals
from scara_iso.reporting.figure_tables import characteristics, pose_figures
from scara_iso.reporting.limits import limits
from scara_iso.robot import Gearbox
from scara_iso.run import Axis, FloatArray, IntArray, Run

_MORE_PLACES = 3  # than a reading has: enough that sums of them agree to the last one printed


def intermediates(pose: PoseResult) -> Iterator[Block]:
    """Yield sums, means and standard deviations behind each RP, eq. 2-6 and 7.2.2."""
    places = _places(pose)
    rows = [_row(axis.name, axis.unit, places, axis, axis.n) for axis in pose.axes.values()]
    n = len(pose.rows)
    radial = (("XY", pose.XY), ("XYZ", pose.XYZ))
    rows += [_row(name, "mm", places, found, n) for name, found in radial if found is not None]
    yield Table(
        (
            "figure",
            "unit",
            "n",
            "sum",
            "mean",
            "sum of l_j",
            "l_bar",
            "sum of (l_j - l_bar)²",
            "S_l",
            "RP = l_bar + 3 S_l",
        ),
        tuple(rows),
        "l_j: distance of cycle j from the mean (of an axis, eq. 2) or from the barycentre "
        "(XY and XYZ, 7.2.2); S_l with n - 1; eq. 23 is the root of RP² of X plus RP² of Y. "
        "Computed with all digits; more of them are printed here than the figures bear, so that "
        "each can be checked by hand.",
    )
    angles = [axis for axis in pose.axes.values() if axis.unit == "deg"]
    for axis in angles:
        yield _angle(axis, _places(pose))


def by_cycle(pose: PoseResult) -> Iterator[Block]:
    """Yield the deviation of each cycle from the mean, and its distance to the barycentre."""
    places = _places(pose)
    columns = {
        f"{axis.name} - mean [{axis.unit}]": axis.readings - axis.mean
        for axis in pose.axes.values()
    }
    cells = [[Number(v, f"+.{places}f") for v in values.tolist()] for values in columns.values()]
    radial = [name for name in ("XY", "XYZ") if name in pose.figures]
    cells += [
        [Number(v, f".{places}f") for v in _distances(pose, name).tolist()] for name in radial
    ]
    yield Table(
        ("cycle", *columns, *(f"l_j {name} [mm]" for name in radial)),
        tuple(zip(map(Number, pose.cycle.tolist()), *cells, strict=True)),
        "l_j of an axis is the deviation without its sign",
    )


def _row(
    name: str, unit: str, places: int, found: AxisResult | RadialResult, n: int
) -> tuple[Cell, ...]:
    spec = f".{places}f"
    mean: tuple[Cell, Cell] = ("", "")
    if isinstance(found, AxisResult):
        mean = (Number(n * found.mean, spec), Number(found.mean, spec))
    return (
        name,
        unit,
        Number(n),
        *mean,
        Number(n * found.l_bar, spec),
        Number(found.l_bar, spec),
        Number((n - 1) * found.S_l**2, ".6g"),
        Number(found.S_l, spec),
        Number(found.RP, spec),
    )


def _angle(axis: AxisResult, places: int) -> Table:
    s = axis.three_sigma / 3
    row: tuple[Cell, ...] = (axis.name, *(Number(v, f".{places}f") for v in (s, axis.three_sigma)))
    return Table(("angle", "S [deg]", "RP = ± 3 S [deg]"), (row,), "7.2.2, S with n - 1")


def _distances(pose: PoseResult, names: str) -> FloatArray:
    """Return the distance of each cycle to the barycentre of the named axes, shape (n,)."""
    squares = [(pose.axes[name].readings - pose.axes[name].mean) ** 2 for name in names]
    return np.asarray(np.sqrt(np.sum(squares, axis=0)))


def _places(pose: PoseResult) -> int:
    """Return decimal places: some more than the finest dial shows."""
    steps = [axis.resolution or axis.three_sigma for axis in pose.axes.values()]
    return decimals([step for step in steps if step]) + _MORE_PLACES - 2


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


def appendix(
    analysis: Analysis,
    diagnoses: Iterable[Section],
    gearboxes: Mapping[int, tuple[Gearbox, float | None]],
) -> Iterator[Section]:
    """Yield figures, limits, diagnosis, backlash, intermediate values and readings of a test."""
    poses = poses_in_cycles(analysis)
    for pose in poses:
        yield Section(at_pose("Repeatability", pose), tuple(pose_figures(pose)))
    for section in (*characteristics(analysis, advice=False), *limits(analysis)):
        yield replace(section, heading=section.heading.capitalize())
    yield from diagnoses
    for joint, (gearbox, arm) in gearboxes.items():
        yield from _gear(joint, gearbox, arm, poses)
    for pose in poses:
        yield Section(at_pose("Intermediate values", pose), tuple(intermediates(pose)))
        yield Section(at_pose("Deviations of each cycle", pose), tuple(by_cycle(pose)))
    for pose in analysis.poses:
        yield Section(at_pose("Raw data", pose), tuple(raw_data(analysis, pose)))


def at_pose(heading: str, pose: PoseResult) -> str:
    """Return a heading with the pose that it is of, where it has a name."""
    return heading if pose.label is None else f"{heading} at pose {pose.label}"


def _gear(
    joint: int, gearbox: Gearbox, arm: float | None, poses: Sequence[PoseResult]
) -> Iterator[Section]:
    actual = poses[0] if len(poses) == 1 else None
    opening, *others = backlash_report(gearbox.backlash(arm), actual)
    blocks = list(opening.blocks[1:])
    if arm is not None:
        blocks.append(
            Text(f"Joint to tool: {arm:g} m, the arm stretched, as in the paper.", "quiet")
        )
    yield Section(f"Backlash of joint {joint}", tuple(blocks))
    for section in others:
        name = section.heading and f"Backlash of joint {joint}: {section.heading}"
        yield Section(name, section.blocks)
