"""Distance repeatability: how much the distance between two poses varies from cycle to cycle.

RD = +/- 3 S_D, where D_j is the distance between the poses attained in cycle j and S_D their
standard deviation with n - 1, as two secondary sources give the clause. Along an axis it needs no
common scale of the two poses: a dial that is set to zero at each of them shifts every D_j alike.
In XY and XYZ it does, so it is given there only with `# dial_zero: command` and two different
command poses. Both poses must be visited in each cycle, so tables that finish one pose before they
begin the next have no RD, nor have tests of more than ten poses. It is +/- of lengths, in mm; its
interval rests on the chi-square distribution of a variance, as that of RP_a.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from scara_iso.dial import step_of
from scara_iso.iso9283.estimates import (
    largest_calibration,
    reading_uncertainty,
    scatter_estimates,
)
from scara_iso.iso9283.figures import PoseResult
from scara_iso.iso9283.results import Characteristic, Measured
from scara_iso.iso9283.statistics import standard_deviation, three_sigma_interval
from scara_iso.quantities import Dimension, Estimate
from scara_iso.run import Axis, IntArray, Run

CODE = "RD"
CLAUSE = "7.3"
_FEWEST_CYCLES = 2
_MOST_POSES = 10


def compute(test: Measured) -> Iterator[Characteristic]:
    """Yield it for each pair of poses: along each length axis, in XY and in XYZ."""
    if len(test.poses) > _MOST_POSES:
        return
    for first, second in combinations(test.poses, 2):
        rows = _visited_in_turn(first, second)
        if rows is not None:
            for of, axes in _groups(test.run, first, second):
                yield _characteristic((str(first.label), str(second.label)), of, axes, rows)


def _characteristic(
    between: tuple[str, str], of: str, axes: Sequence[Axis], rows: tuple[IntArray, IntArray]
) -> Characteristic:
    pose = "-".join(between)
    stated = [u for u in map(reading_uncertainty, axes) if u is not None]
    return Characteristic(
        CODE,
        pose,
        of,
        _estimate(axes, *rows),
        limited_by=(f"{CODE}:{pose}", CODE),
        reading_u=math.sqrt(2) * max(stated) if len(stated) == len(axes) else None,
        calibration=largest_calibration(axes),
        between=between,
        half_width=True,
    )


def _visited_in_turn(first: PoseResult, second: PoseResult) -> tuple[IntArray, IntArray] | None:
    """Return the rows of the cycles that both have, None unless cycle follows cycle."""
    _, i, j = np.intersect1d(first.cycle, second.cycle, return_indices=True)
    one, other = first.rows[i], second.rows[j]
    ends, starts = np.maximum(one, other)[:-1], np.minimum(one, other)[1:]
    return (one, other) if len(one) >= _FEWEST_CYCLES and np.all(ends < starts) else None


def _groups(run: Run, first: PoseResult, second: PoseResult) -> Iterator[tuple[str, list[Axis]]]:
    """Yield the axes that are lengths, and those together in which a distance is known."""
    lengths = {n: axis for n, axis in run.axes.items() if axis.dimension is Dimension.LENGTH}
    yield from ((name, [axis]) for name, axis in lengths.items())
    for names in ("XY", "XYZ"):
        if set(names) <= set(lengths) and _on_one_scale(run, names, first.label, second.label):
            yield names, [lengths[name] for name in names]


def _on_one_scale(run: Run, names: str, first: str | None, second: str | None) -> bool:
    pairs = [(run.command_of(name, first), run.command_of(name, second)) for name in names]
    stated = all(command is not None for pair in pairs for command in pair)
    return run.dial_zero_is_command and stated and any(one != other for one, other in pairs)


def _estimate(axes: Sequence[Axis], one: IntArray, other: IntArray) -> Estimate:
    apart = np.stack([axis.readings[other] - axis.readings[one] for axis in axes])
    # Signed along one axis: what two zeros of the dial add is then the same in every cycle.
    D = apart[0] if len(axes) == 1 else np.sqrt((apart**2).sum(axis=0))
    positions = D[np.newaxis, np.newaxis, :]
    (found,) = scatter_estimates(
        three_sigma_interval,
        3 * standard_deviation(positions[:, 0, :]),
        positions,
        steps=[math.sqrt(2) * max(step_of(axis) for axis in axes)],  # both readings are rounded
        calibration=largest_calibration(axes),
        unit=axes[0].unit,
        clause=CLAUSE,
    )
    return found
