"""Figures against the limits that a user gives.

The decision is simple acceptance, RP at most the limit; the guard band of the indicator's
expanded uncertainty, by which ISO 14253-1 would shorten it, is said beside it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from scara_iso.errors import UsageError
from scara_iso.quantities import Dimension
from scara_iso.results import LimitCheck, PoseResult

EVERY_LENGTH = ""
"""Key of a limit that holds for every figure that is a length and has no limit of its own."""


def check_limits(poses: Sequence[PoseResult], limits: Mapping[str, float]) -> Iterator[LimitCheck]:
    """Yield the comparison of each pose's figures with the limit that holds for them.

    ``limits`` by figure, in mm, or degrees for an angle. Raises `UsageError` for a limit that is
    not positive and finite, or of a figure that the run does not have.
    """
    wrong = [f"{limit:g}" for limit in limits.values() if not (math.isfinite(limit) and limit > 0)]
    if wrong:
        raise UsageError(f"--limit {wrong[0]}: not a positive, finite length")
    unknown = sorted(set(limits) - {EVERY_LENGTH} - set(_figures(poses[0])))
    if unknown:
        raise UsageError(
            f"--limit {unknown[0]}=...: this table has no such figure",
            remedy=f"it has {', '.join(_figures(poses[0]))}",
        )
    lengths = [
        name for name, (_, _, kind) in _figures(poses[0]).items() if kind is Dimension.LENGTH
    ]
    if EVERY_LENGTH in limits and not lengths:
        raise UsageError(
            f"--limit {limits[EVERY_LENGTH]:g} is a length, and this table has none",
            remedy="name the figure, as in --limit theta=0.05 (degrees)",
        )
    for pose in poses:
        for name, (RP, uncertainty, dimension) in _figures(pose).items():
            general = limits.get(EVERY_LENGTH) if dimension is Dimension.LENGTH else None
            limit = limits.get(name, general)
            if limit is not None:
                guard = None if uncertainty is None else 2 * uncertainty
                yield LimitCheck(name, RP, limit, guard, pose.label)


def _figures(pose: PoseResult) -> dict[str, tuple[float, float | None, Dimension]]:
    """Return RP, uncertainty and dimension by name.

    Of XY it is the larger of eq. 23 and 7.2.2, of an angle the standard's 3 S.
    """
    found = {
        name: (
            axis.RP if axis.dimension is Dimension.LENGTH else axis.three_sigma,
            axis.uncertainty,
            axis.dimension,
        )
        for name, axis in pose.axes.items()
    }
    if pose.XY is not None:
        RP = max(pose.XY.RP, pose.XY.RP_rss or 0.0)
        found["XY"] = (RP, pose.XY.uncertainty, Dimension.LENGTH)
    if pose.XYZ is not None:
        found["XYZ"] = (pose.XYZ.RP, pose.XYZ.uncertainty, Dimension.LENGTH)
    return found
