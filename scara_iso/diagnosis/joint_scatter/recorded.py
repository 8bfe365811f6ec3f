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

from scara_iso.diagnosis.joint_scatter.covariances import PoseCovariances
from scara_iso.diagnosis.joint_scatter.poses import Joints
from scara_iso.diagnosis.joint_scatter.tracing import patterns_of, rounding_of, trace
from scara_iso.diagnosis.places import ARM, MOVEMENTS, movements
from scara_iso.diagnosis.poses_result import FollowedInJoints, SizeInJoint
from scara_iso.effects import Conditions, Shape, find_effects
from scara_iso.robot import Arm
from scara_iso.run import FloatArray

FOLLOWED = ("lost_motion", "compliance", "temperature")
"""Effects through a recorded column, in proportion to it."""
_PER = {"lost_motion": "", "compliance": "/kg", "temperature": "/°C"}
_TOLERANCE = 1e-6
"""Share of a column beside the others from which it is told from them."""
_FEWEST_POSES = 3
"""Of which X and Y are more numbers than there are sources."""
_APART = 1e-3
"""Smallest eigenvalue of the sources' cosines beside the scatter at which they are told apart."""
_WIDEN = 0.05
_LEVEL = 0.975


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
    beside = np.concatenate([np.ones((n, 1)), *courses], axis=1)
    known = {key: one for key, one in columns.items() if _told(key, columns, beside)}
    if not known or poses < _FEWEST_POSES or n <= len(known) + beside.shape[1]:
        return ()
    fitted = _fit(measured, arm, np.column_stack([*known.values(), beside]))
    found = (_followed(key, k, fitted) for k, key in enumerate(known))
    return tuple(one for one in found if one is not None)


_Key = tuple[str, str]
"""Effect and column."""


def _columns(conditions: Conditions) -> Iterator[tuple[_Key, FloatArray]]:
    for effect in find_effects():
        if effect.name not in FOLLOWED:
            continue
        names = conditions.named(effect.needs[0])
        for name, form in zip(names, effect.forms(conditions), strict=False):
            if isinstance(form, Shape):
                yield (effect.name, name), form.columns[:, 0]


def _told(key: _Key, columns: Mapping[_Key, FloatArray], beside: FloatArray) -> bool:
    """Return whether a column varies otherwise than all that stands beside it."""
    others = np.column_stack([beside, *(one for k, one in columns.items() if k != key)])
    own = columns[key]
    left = own - others @ np.linalg.lstsq(others, own, rcond=None)[0]
    return bool(left @ left > _TOLERANCE * max(float(own @ own), np.finfo(float).tiny))


@dataclass(frozen=True, eq=False, slots=True)
class _Fitted:
    """Sizes (q, P, 2) of the columns at the poses, what is left, and how the sources move them."""

    sizes: FloatArray
    left: FloatArray
    spread: FloatArray
    """Variance (q,) of a size over that of a reading."""
    freedom: int
    scatter: FloatArray
    """Covariances (P, 2, 2) of joints and dials."""
    moves: Mapping[str, FloatArray]
    """By source, (P, 2)."""


def _fit(measured: MeasuredPoses, arm: Arm, design: FloatArray) -> _Fitted:
    n, poses, _ = measured.readings.shape
    flat, inverse = measured.readings.reshape(n, -1), np.linalg.pinv(design)
    freedom = max(1, n - int(np.linalg.matrix_rank(design)))
    left = (flat - design @ (inverse @ flat)).reshape(n, poses, 2)
    covariances = PoseCovariances(
        observed=np.einsum("npi,npj->pij", left, left) / freedom,
        freedom=np.full(poses, float(freedom)),
        patterns=patterns_of(arm, measured.joints_deg),
        known=np.broadcast_to(rounding_of(measured.division), (poses, 2, 2)),
    )
    every = movements(arm, measured.joints_deg)
    return _Fitted(
        (inverse @ flat).reshape(-1, poses, 2),
        left,
        np.diag(inverse @ inverse.T),
        freedom,
        covariances.expected(trace(covariances).variances),
        dict(zip(MOVEMENTS, np.moveaxis(every, -1, 0), strict=True)),
    )


def _sources(effect: str) -> tuple[str, ...]:
    """Return what may follow: the links grow with a temperature only."""
    return tuple(one for one in MOVEMENTS if one != ARM or effect == "temperature")


def _unit(source: str, effect: str) -> str:
    first = "mm" if source.endswith("everywhere") else "1" if source == ARM else "rad"
    return first + _PER[effect]


def _followed(key: _Key, k: int, fitted: _Fitted) -> FollowedInJoints | None:
    """Return the sizes of column ``k`` in its sources; None where the poses do not tell them apart.

    Errors are those of the sources' own scatter from cycle to cycle. Where the poses disagree by
    more than sampling lets them at 5 %, they are widened by the root of that ratio (Birge 1932).
    """
    from scipy.special import chdtrc, stdtrit  # noqa: PLC0415 - heavy

    effect, column = key
    sources = _sources(effect)
    movement = np.stack([fitted.moves[one] for one in sources], axis=-1)
    weighed = np.linalg.solve(fitted.scatter, movement)
    known = np.einsum("pik,pil->kl", movement, weighed)
    length = np.sqrt(np.diag(known))
    if np.linalg.eigvalsh(known / np.outer(length, length))[0] < _APART:
        return None
    estimate = np.einsum("kl,pil->kpi", np.linalg.inv(known), weighed)
    sizes = np.einsum("kpi,pi->k", estimate, fitted.sizes[k])
    own = np.einsum("kpi,npi->nk", estimate, fitted.left)
    misfit = fitted.sizes[k] - movement @ sizes
    seen = np.linalg.solve(fitted.scatter, misfit[..., np.newaxis])[..., 0]
    chi_square = float((misfit * seen).sum() / fitted.spread[k])
    over = misfit.size - len(sizes)
    chance = float(chdtrc(over, chi_square))
    birge = max(1.0, chi_square / over) if chance < _WIDEN else 1.0
    error = np.sqrt((own**2).sum(axis=0) / fitted.freedom * fitted.spread[k] * birge)
    half = float(stdtrit(fitted.freedom, _LEVEL)) * error
    return FollowedInJoints(
        effect,
        column,
        {
            source: SizeInJoint(size, _unit(source, effect), (size - h, size + h))
            for source, size, h in zip(sources, sizes.tolist(), half.tolist(), strict=True)
        },
        chance,
    )
