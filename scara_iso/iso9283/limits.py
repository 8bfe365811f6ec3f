"""Figures against the limits that a user gives.

A limit is kept where the whole 95 % interval of the figure is at most the limit, and broken where
all of it is above; else these cycles prove neither. An interval that a finding voids (a drift)
keeps no limit: scatter that hangs together reads too small. What is above is above, drift and all.
Simple acceptance (RP at most the limit) is
there for who asks for it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from scara_iso.errors import UsageError
from scara_iso.iso9283.conformity import Conformity, DecisionRule
from scara_iso.iso9283.results import AxisResult, Finding, Interval, LimitCheck, PoseResult
from scara_iso.quantities import Dimension

EVERY_LENGTH = ""
"""Key of a limit that holds for every figure that is a length and has no limit of its own."""
MOST_CYCLES = 100_000
"""Stands for that many cycles and more."""
_AXES_OF = {"XY": ("X", "Y"), "XYZ": ("X", "Y", "Z")}
_POWER = 1.3  # benchmarks/conformity.py: 4 of 5 tests prove it (Gaussian scatter)


def check_limits(
    poses: Sequence[PoseResult],
    limits: Mapping[str, float],
    findings: Sequence[Finding] = (),
    *,
    decision: DecisionRule = DecisionRule.INTERVAL,
) -> Iterator[LimitCheck]:
    """Yield the comparison of each pose's figures with the limit that holds for them.

    ``limits`` by figure, in mm, or degrees for an angle; ``findings`` of the same poses say which
    intervals are void. Raises `UsageError` for a limit that is
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
        name for name, one in _figures(poses[0]).items() if one.dimension is Dimension.LENGTH
    ]
    if EVERY_LENGTH in limits and not lengths:
        raise UsageError(
            f"--limit {limits[EVERY_LENGTH]:g} is a length, and this table has none",
            remedy="name the figure, as in --limit theta=0.05 (degrees)",
        )
    void = {(one.pose, one.axis) for one in findings if one.voids_interval}
    for pose in poses:
        for name, measured in _figures(pose).items():
            is_void = any((pose.label, axis) in void for axis in _AXES_OF.get(name, (name,)))
            general = limits.get(EVERY_LENGTH) if measured.dimension is Dimension.LENGTH else None
            limit = limits.get(name, general)
            if limit is not None:
                yield _check(pose.label, name, measured, limit, decision, is_void=is_void)


@dataclass(frozen=True, slots=True)
class _Figure:
    """A figure that a limit can hold for, with what its decision rests on."""

    value: float
    interval: Interval | None
    uncertainty: float | None
    calibration: float | None
    n: int
    dimension: Dimension = Dimension.LENGTH


def _figures(pose: PoseResult) -> dict[str, _Figure]:
    """Return the figures by name: of an angle 3 S (7.2.2), of XY the larger of 7.2.2 and eq. 23."""
    n = len(pose.rows)
    found = {name: _of_axis(axis) for name, axis in pose.axes.items()}
    for name, plane in (("XY", pose.XY), ("XYZ", pose.XYZ)):
        if plane is not None:
            both = [(plane.RP, plane.RP_interval)]
            if plane.RP_rss is not None:
                both.append((plane.RP_rss, plane.RP_rss_interval))
            value, interval = max(both, key=lambda one: one[0])
            found[name] = _Figure(value, interval, plane.uncertainty, plane.calibration, n)
    return found


def _of_axis(axis: AxisResult) -> _Figure:
    value, interval = axis.RP, axis.RP_interval
    if axis.dimension is Dimension.ANGLE:
        value, interval = axis.three_sigma, axis.three_sigma_interval
    return _Figure(value, interval, axis.uncertainty, axis.calibration, axis.n, axis.dimension)


def _check(
    pose: str | None,
    name: str,
    measured: _Figure,
    limit: float,
    decision: DecisionRule,
    *,
    is_void: bool,
) -> LimitCheck:
    check = LimitCheck(
        figure=name,
        RP=measured.value,
        limit=limit,
        guard=None if measured.uncertainty is None else 2 * measured.uncertainty,
        pose=pose,
        interval=measured.interval,
        decision=decision,
        cycles_wanted=None,
        interval_void=is_void,
    )
    if is_void or check.verdict is not Conformity.NOT_PROVABLE:
        return check
    return replace(check, cycles_wanted=_cycles_wanted(measured, limit))


def _cycles_wanted(measured: _Figure, limit: float) -> int | None:
    """Return how many cycles bring the interval's end to the limit in most tests, if any do.

    Chance shrinks with the root of their number, the calibration does not, and where the lower
    limit is 0 the dial hides the scatter from however many.
    """
    RP, U = measured.value, 2 * (measured.calibration or 0.0)
    if measured.interval is None or measured.interval[0] == 0 or abs(limit - RP) <= U:
        return None
    end = measured.interval[1] if limit > RP else measured.interval[0]
    side = math.copysign(1.0, limit - RP)
    reach = abs(_log_ratio(RP, side * math.sqrt(max((end - RP) ** 2 - U**2, 0.0))))
    room = abs(_log_ratio(RP, side * math.sqrt((limit - RP) ** 2 - U**2)))
    return math.ceil(min(measured.n * (_POWER * reach / room) ** 2, MOST_CYCLES))


def _log_ratio(RP: float, change: float) -> float:
    return math.log1p(change / RP)
