"""From what is left at each pose, and where the arm stands there, to `JointScatter`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.diagnosis.joint_scatter.covariances import PoseCovariances
from scara_iso.diagnosis.joint_scatter.tracing import (
    CYCLES,
    FEWEST_POSES,
    SOURCES,
    UNITS,
    Traced,
    alike,
    correlation,
    neither,
    patterns_of,
    rounding_of,
    rp_at,
    source_intervals,
    trace,
)
from scara_iso.diagnosis.poses_result import (
    JointCorrelation,
    JointScatter,
    Misfit,
    PoseLeftOut,
    SourceOfScatter,
)
from scara_iso.diagnosis.result import Foretold
from scara_iso.iso9283 import repeatability
from scara_iso.robot import Arm
from scara_iso.run import FloatArray

PLANE = ("X", "Y")
Joints = tuple[float, float]
"""Joints 1 and 2 in degrees."""

_COARSE = 0.3
"""Share of the variance that is rounding from which a covariance is no longer the scatter's plus
rounding's: benchmarks/joint_scatter.py."""


@dataclass(frozen=True, eq=False, slots=True)
class ScatterAtPose:
    """What the effects found leave of X and Y at one pose.

    ``left`` (n, 2) is in mm, and so is ``read``, as the dials showed it; ``fitted`` is how many
    numbers were fitted to each axis beside its mean.
    """

    joints_deg: Joints
    left: FloatArray
    read: FloatArray
    fitted: float = 0.0

    @property
    def freedom(self) -> float:
        """Degrees of freedom of the covariance."""
        return max(len(self.left) - 1 - self.fitted, 1.0)

    @property
    def covariance(self) -> FloatArray:
        """Covariance of X and Y, shape (2, 2) [mm2]."""
        about = self.left - self.left.mean(axis=0)
        return np.asarray(about.T @ about / self.freedom)


def trace_to_joints(
    measured: Mapping[str, ScatterAtPose],
    arm: Arm,
    division: Sequence[float],
    *,
    elsewhere: Mapping[str, Joints],
    held_out: Mapping[str, ScatterAtPose],
) -> JointScatter:
    """Return the scatter of two poses or more traced to its sources, and RP at other poses.

    ``division`` (2,) are the dials' steps in X and Y in mm, 0 for none; ``elsewhere`` are the
    joints at poses that were not measured; ``held_out`` poses are measured, and take no part.
    Raises `UsageError` for fewer poses.
    """
    traced = trace_poses(measured, arm, division)
    unseen = {**elsewhere, **{pose: one.joints_deg for pose, one in held_out.items()}}
    others = _foretold(traced, arm, division, unseen, CYCLES)
    return JointScatter(
        sources=dict(_sources(traced)),
        predicted_RP=dict(zip(unseen, others, strict=True)),
        left_out=dict(_left_out(traced, measured, arm, division)),
        held_out={
            pose: _beside(traced, arm, division, pose, one) for pose, one in held_out.items()
        },
        together=_together(traced),
        misfit=Misfit(float(traced.ratio), float(traced.p_value)),
        notes=tuple(_notes(traced)),
    )


def trace_poses(
    measured: Mapping[str, ScatterAtPose], arm: Arm, division: Sequence[float]
) -> Traced:
    """Return the fit behind `trace_to_joints`; errors likewise."""
    if len(measured) < FEWEST_POSES:
        raise UsageError(
            f"scatter is traced to the joints from {FEWEST_POSES} poses or more, not "
            f"{len(measured)}",
            remedy="measure another pose, or hold none out",
        )
    poses = list(measured.values())
    known = np.broadcast_to(rounding_of(np.asarray(division)), (len(poses), 2, 2))
    return trace(
        PoseCovariances(
            observed=np.stack([one.covariance for one in poses]),
            freedom=np.array([one.freedom for one in poses]),
            patterns=patterns_of(arm, [one.joints_deg for one in poses]),
            known=known,
        )
    )


def _sources(traced: Traced) -> Iterator[tuple[str, SourceOfScatter]]:
    sizes = np.trace(traced.given.patterns, axis1=-2, axis2=-1).mean(axis=0)
    whole = np.trace(traced.given.expected(traced.variances), axis1=-2, axis2=-1).mean()
    shares = traced.variances * sizes / whole
    shares[:2] += shares[-1] / 2  # what the joints do together is both's
    low, high = source_intervals(traced)
    for k, (name, unit) in enumerate(zip(SOURCES, UNITS, strict=True)):
        found = (np.sqrt(traced.variances[k]), low[k], high[k], shares[k])
        value, least, most, share = map(float, found)
        yield name, SourceOfScatter(value, unit, (least, most), share)
    value, least, most = (float(part) for part in neither(traced))
    yield "neither", SourceOfScatter(value, "mm", (least, most))


def _together(traced: Traced) -> JointCorrelation | None:
    value, low, high = (float(part) for part in correlation(traced))
    return JointCorrelation(value, (low, high), float(traced.p_together)) if value else None


def _foretold(
    traced: Traced, arm: Arm, division: Sequence[float], at: Mapping[str, Joints], cycles: int
) -> list[Foretold]:
    if not at:
        return []
    patterns = patterns_of(arm, list(at.values()))
    found = rp_at(traced, patterns, rounding_of(np.asarray(division)), cycles)
    each = ([float(part) for part in one] for one in zip(*found, strict=True))
    return [Foretold(value, (low, high)) for value, low, high in each]


def _left_out(
    traced: Traced, measured: Mapping[str, ScatterAtPose], arm: Arm, division: Sequence[float]
) -> Iterator[tuple[str, PoseLeftOut]]:
    """Yield each pose beside what the others foretell of it, where enough others are there."""
    if len(measured) <= FEWEST_POSES:
        return
    for k, (pose, one) in enumerate(measured.items()):
        freedom = traced.given.freedom.copy()
        freedom[k] = 0.0
        others = trace(replace(traced.given, freedom=freedom))
        yield pose, _beside(others, arm, division, pose, one)


def _beside(
    traced: Traced, arm: Arm, division: Sequence[float], pose: str, one: ScatterAtPose
) -> PoseLeftOut:
    """Return a pose beside what is foretold of it."""
    predicted = _foretold(traced, arm, division, {pose: one.joints_deg}, len(one.left))[0]
    read, left = (float(repeatability(part.T).RP) for part in (one.read, one.left))
    before, after = (
        dict(zip(PLANE, part.std(axis=0).tolist(), strict=True)) for part in (one.read, one.left)
    )
    return PoseLeftOut(read, left, predicted, before, after)


def _notes(traced: Traced) -> Iterator[str]:
    known, seen = (
        np.trace(part, axis1=-2, axis2=-1).mean()
        for part in (traced.given.known, traced.given.observed)
    )
    share = float(known / max(seen, known, np.finfo(float).tiny))
    if share > _COARSE:
        yield (
            f"{share:.0%} of the variance is rounding to the dial's division: too much "
            "to trace the rest to the joints; measure with a finer indicator"
        )
    if alike(traced):
        yield (
            "these poses move alike with joint 1 and joint 2: they do not tell the scatter of one "
            "from that of the other; add poses at other angles of joint 2"
        )
    if traced.p_value < 0.05:
        yield (
            f"the poses scatter {float(traced.ratio):.1f} times as much about joints and dial as "
            f"sampling lets them (p = {float(traced.p_value):.2g}, as a variance): something else "
            "scatters, or not as a Gaussian does; the intervals are widened by the root of it"
        )
