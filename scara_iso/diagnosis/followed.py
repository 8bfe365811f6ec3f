"""Lost motion, compliance and thermal growth of each joint, from the poses of a test together.

What follows a recorded column does so with ten sizes, those of X and Y at five poses. Joints, the
growth of the links and the dials account for them by few numbers: least squares through the
Jacobians, each pose weighed by the scatter of joints and dials there. Courses of other effects that
were found are fitted beside the column.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from scara_iso.diagnosis.places import ARM, MOVEMENTS, Joints, movements
from scara_iso.diagnosis.poses_result import DiagnosisOfPoses, FollowedInJoints, SizeInJoint
from scara_iso.diagnosis.sources import PoseCovariances, trace
from scara_iso.effects import Conditions, find_effects
from scara_iso.robot import Arm
from scara_iso.run import FloatArray

_PER = {"lost_motion": "", "compliance": "/kg", "temperature": "/°C"}
"""Effects through a recorded column, in proportion to it, and the unit of the column."""
_TOLERANCE = 1e-6
"""Share of a column beside the others from which it is told from them."""
_FEWEST_POSES = 3
"""Of which X and Y are more numbers than there are sources."""
_APART = 1e-3
"""Smallest eigenvalue of the sources' cosines beside the scatter at which they are told apart."""
_WIDEN = 0.05
_LEVEL = 0.975
_Key = tuple[str, str]
"""Effect and column."""


def followed_at_poses(
    found: DiagnosisOfPoses,
    joints: Sequence[Joints],
    test: Conditions,
    arm: Arm,
    division: Sequence[float],
) -> tuple[FollowedInJoints, ...]:
    """Return what follows the columns recorded in a test, beside the other effects found in it.

    ``joints`` (P, 2) are those of its poses, ``division`` (2,) the steps of its dials [mm].
    """
    readings = [
        [one.series.measured[axis] - one.series.predicted_before[axis] for axis in "XY"]
        for one in found.poses.values()
    ]
    measured = MeasuredPoses(np.moveaxis(np.array(readings), -1, 0), joints, np.array(division))
    others_found = [
        course
        for one, course in zip(found.effects, found.courses, strict=True)
        if one.effect not in {*_PER, "temperature_lagged"}
    ]
    return followed_in_joints(measured, arm, test, others_found)


@dataclass(frozen=True, eq=False, slots=True)
class MeasuredPoses:
    """X and Y (n, P, 2) of n cycles at P poses [mm], where the joints are, divisions (2,) [mm]."""

    readings: FloatArray
    joints_deg: Sequence[Joints]
    division: FloatArray


def followed_in_joints(
    measured: MeasuredPoses, arm: Arm, conditions: Conditions, courses: Sequence[FloatArray] = ()
) -> tuple[FollowedInJoints, ...]:
    """Return what follows each recorded column, traced to joints, links and dials.

    ``courses`` (n, k) are those of effects found that follow none of these columns. Nothing is
    returned of a column that does not vary or is the sum of others, and of fewer than three poses.
    """
    columns = dict(_columns(conditions))
    n, poses, _ = measured.readings.shape
    others_found = np.concatenate([np.ones((n, 1)), *courses], axis=1)
    known = {key: one for key, one in columns.items() if _distinct(key, columns, others_found)}
    if not known or poses < _FEWEST_POSES or n <= len(known) + others_found.shape[1]:
        return ()
    design = np.column_stack([*known.values(), others_found])
    flat, inverse = measured.readings.reshape(n, -1), np.linalg.pinv(design)
    freedom = max(1, n - int(np.linalg.matrix_rank(design)))
    sizes = (inverse @ flat).reshape(-1, poses, 2)
    left = (flat - design @ (inverse @ flat)).reshape(n, poses, 2)
    covariances = PoseCovariances.of(
        np.swapaxes(left, 0, 1), freedom, arm, measured.joints_deg, measured.division
    )
    scatter = covariances.expected(trace(covariances).variances)
    moves = movements(arm, measured.joints_deg)
    of_size = (inverse**2).sum(axis=1).tolist()
    found = (
        _followed(key, sizes[k], _Scatter(left, freedom, scatter, of_size[k]), moves)
        for k, key in enumerate(known)
    )
    return tuple(one for one in found if one is not None)


def _columns(conditions: Conditions) -> Iterator[tuple[_Key, FloatArray]]:
    for effect in find_effects():
        if effect.name in _PER:
            names = conditions.named(effect.needs[0])
            for name, form in zip(names, effect.forms(conditions), strict=False):
                yield (effect.name, name), form.columns[:, 0]


def _distinct(key: _Key, columns: Mapping[_Key, FloatArray], others_found: FloatArray) -> bool:
    """Return whether a column varies otherwise than all that stands beside it."""
    others = np.column_stack([others_found, *(one for k, one in columns.items() if k != key)])
    own = columns[key]
    left = own - others @ np.linalg.lstsq(others, own, rcond=None)[0]
    return bool(left @ left > _TOLERANCE * max(float(own @ own), np.finfo(float).tiny))


@dataclass(frozen=True, eq=False, slots=True)
class _Scatter:
    """What is left (n, P, 2) of ``freedom``, its covariances (P, 2, 2) by joints and dials.

    ``of_size`` is the variance of a column's size over that of a reading.
    """

    left: FloatArray
    freedom: int
    covariances: FloatArray
    of_size: float


def _followed(
    key: _Key, at_poses: FloatArray, about: _Scatter, moves: FloatArray
) -> FollowedInJoints | None:
    """Return sizes (P, 2) of a column in its sources; None where the poses do not tell them apart.

    Errors are those of the sources' own scatter from cycle to cycle. Where the poses disagree by
    more than sampling lets them at 5 %, they are widened by the root of that ratio (Birge 1932).
    """
    from scipy.special import chdtrc, stdtrit  # noqa: PLC0415 - heavy

    effect, column = key
    names = [one for one in MOVEMENTS if one != ARM or effect == "temperature"]  # links grow warm
    movement = moves[..., [MOVEMENTS.index(one) for one in names]]
    weighed = np.linalg.solve(about.covariances, movement)
    known = np.einsum("pik,pil->kl", movement, weighed)
    length = np.sqrt(np.diag(known))
    if np.linalg.eigvalsh(known / np.outer(length, length))[0] < _APART:
        return None
    estimate = np.einsum("kl,pil->kpi", np.linalg.inv(known), weighed)
    sizes = np.einsum("kpi,pi->k", estimate, at_poses)
    own = np.einsum("kpi,npi->nk", estimate, about.left)
    misfit = (at_poses - movement @ sizes)[..., np.newaxis]
    seen = np.linalg.solve(about.covariances, misfit)
    chi_square, over = float((misfit * seen).sum() / about.of_size), misfit.size - len(sizes)
    chance = float(chdtrc(over, chi_square))
    birge = max(1.0, chi_square / over) if chance < _WIDEN else 1.0
    error = np.sqrt((own**2).sum(axis=0) / about.freedom * about.of_size * birge)
    half = float(stdtrit(about.freedom, _LEVEL)) * error
    ends = zip(names, sizes.tolist(), half.tolist(), strict=True)
    by_source = {
        name: SizeInJoint(s, _unit(name) + _PER[effect], (s - h, s + h)) for name, s, h in ends
    }
    return FollowedInJoints(effect, column, by_source, chance)


def _unit(source: str) -> str:
    return "mm" if source.endswith("everywhere") else "1" if source == ARM else "rad"
