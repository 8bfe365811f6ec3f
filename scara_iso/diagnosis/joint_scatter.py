"""What several poses tell of the joints: their scatter, RP elsewhere, what follows a column."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.base.quantities import Dimension
from scara_iso.diagnosis.engine.places import ARM, MOVEMENTS, movements
from scara_iso.diagnosis.engine.residual import CyclesWanted, Joints, whole_cycles
from scara_iso.diagnosis.poses_result import (
    DiagnosisOfPoses,
    FollowedInJoints,
    JointCorrelation,
    JointScatter,
    Misfit,
    PoseLeftOut,
    ReachMap,
    SizeInJoint,
    SourceOfScatter,
    declared_in_arm,
)
from scara_iso.diagnosis.result import Foretold, FoundAtPoses
from scara_iso.diagnosis.sources import (
    CYCLES,
    SOURCES,
    UNITS,
    PoseCovariances,
    Traced,
    correlation,
    neither,
    patterns_of,
    rp_at,
    source_intervals,
    trace,
)
from scara_iso.effects import Conditions, find_effects
from scara_iso.iso9283 import repeatability
from scara_iso.robot import Arm, Elbow, Model, Workspace, predict
from scara_iso.run import FloatArray, Run, step_of

PLANE = ("X", "Y")
_FEWEST_POSES = 2
_CELLS = 81
_COARSE = 0.3
"""Share of the variance that is rounding from which a covariance is no longer the scatter's plus
rounding's: benchmarks/joint_scatter.py."""


_PER = {"lost_motion": "", "compliance": "/kg", "temperature": "/°C"}
"""Effects through a recorded column, in proportion to it, and the unit of the column."""
_TOLERANCE = 1e-6
"""Share of a column beside the others from which it is told from them."""
_FEWEST_FOLLOWED = 3
"""Of which X and Y are more numbers than there are sources."""
_APART = 1e-3
"""Smallest eigenvalue of the sources' cosines beside the scatter at which they are told apart."""
_WIDEN = 0.05
_LEVEL = 0.975
_Key = tuple[str, str]
"""Effect and column."""


class ScatterAtPose(NamedTuple):
    """What the effects found leave of X and Y at one pose.

    ``left`` (n, 2) is in mm, and so is ``read``, as the dials showed it; ``fitted`` is how many
    numbers were fitted to each axis beside its mean.
    """

    joints_deg: Joints
    left: FloatArray
    read: FloatArray
    fitted: float = 0.0


def trace_poses(
    measured: Mapping[str, ScatterAtPose], arm: Arm, division: Sequence[float]
) -> Traced:
    """Return the sources that fit the scatter of two poses or more, read on dials of ``division``.

    Steps of X and Y in mm, 0 for none.
    """
    poses = list(measured.values())
    left = np.stack([one.left - one.left.mean(axis=0) for one in poses])
    freedom = np.maximum([left.shape[1] - 1 - one.fitted for one in poses], 1.0)
    joints = [one.joints_deg for one in poses]
    return trace(PoseCovariances.of(left, freedom, arm, joints, division))


def joint_scatter(
    traced: Traced,
    measured: Mapping[str, ScatterAtPose],
    arm: Arm,
    *,
    elsewhere: Mapping[str, Joints],
    held_out: Mapping[str, ScatterAtPose],
) -> JointScatter:
    """Return what ``traced`` says of the ``measured`` poses that it is of, and RP at other poses.

    ``elsewhere`` are the joints at poses that were not measured; ``held_out`` poses are measured,
    and take no part.
    """
    unseen = {**elsewhere, **{pose: one.joints_deg for pose, one in held_out.items()}}
    together = correlation(traced)
    return JointScatter(
        sources=_sources(traced),
        predicted_RP={pose: _foretold(traced, arm, at) for pose, at in unseen.items()},
        left_out=dict(_left_out(traced, measured, arm)),
        held_out={pose: _compared(traced, arm, one) for pose, one in held_out.items()},
        together=together and JointCorrelation(together[0], together[1:], traced.p_together),
        misfit=Misfit(traced.ratio, traced.p_value),
        notes=tuple(_notes(traced)),
    )


def _sources(traced: Traced) -> dict[str, SourceOfScatter]:
    sizes = np.trace(traced.given.patterns, axis1=-2, axis2=-1).mean(axis=0)
    whole = np.trace(traced.given.expected(traced.variances), axis1=-2, axis2=-1).mean()
    shares = traced.variances * sizes / whole
    shares[:2] += shares[-1] / 2  # what the joints do together is both's
    values, ends = np.sqrt(traced.variances[: len(SOURCES)]).tolist(), source_intervals(traced)
    every = zip(values, UNITS, ends, shares[: len(SOURCES)].tolist(), strict=True)
    found = dict(zip(SOURCES, (SourceOfScatter(*one) for one in every), strict=True))
    value, low, high = neither(traced)
    return {**found, "neither": SourceOfScatter(value, "mm", (low, high))}


def _foretold(traced: Traced, arm: Arm, at: Joints, cycles: int = CYCLES) -> Foretold:
    value, low, high = (float(one[0]) for one in rp_at(traced, patterns_of(arm, [at]), cycles))
    return Foretold(value, (low, high))


def _left_out(
    traced: Traced, measured: Mapping[str, ScatterAtPose], arm: Arm
) -> Iterator[tuple[str, PoseLeftOut]]:
    """Yield each pose beside what the others foretell of it, where enough others are there."""
    for k, (pose, one) in enumerate(measured.items() if len(measured) > _FEWEST_POSES else ()):
        freedom = np.where(np.arange(len(measured)) == k, 0.0, traced.given.freedom)
        yield pose, _compared(trace(replace(traced.given, freedom=freedom)), arm, one)


def _compared(traced: Traced, arm: Arm, one: ScatterAtPose) -> PoseLeftOut:
    predicted = _foretold(traced, arm, one.joints_deg, len(one.left))
    read, left = (float(repeatability(part.T).RP) for part in (one.read, one.left))
    before, after = (
        dict(zip(PLANE, part.std(axis=0).tolist(), strict=True)) for part in (one.read, one.left)
    )
    return PoseLeftOut(read, left, predicted, before, after)


def _notes(traced: Traced) -> Iterator[str]:
    seen = np.trace(traced.given.observed, axis1=-2, axis2=-1).mean()
    known = np.trace(traced.given.known)
    share = float(known / max(seen, known, np.finfo(float).tiny))
    if share > _COARSE:
        yield (
            f"{share:.0%} of the variance is rounding to the dial's division: too much "
            "to trace the rest to the joints; measure with a finer indicator"
        )
    if traced.alike:
        yield (
            "these poses move alike with joint 1 and joint 2: they do not tell the scatter of one "
            "from that of the other; add poses at other angles of joint 2"
        )
    if traced.p_value < 0.05:
        yield (
            f"the poses scatter {traced.ratio:.1f} times as much about joints and dial as "
            f"sampling lets them (p = {traced.p_value:.2g}, as a variance): something else "
            "scatters, or not as a Gaussian does; the intervals are widened by the root of it"
        )


def with_joint_scatter(
    found: DiagnosisOfPoses,
    run: Run,
    model: Model,
    wanted: CyclesWanted,
    *,
    held_out: str | None = None,
    reach: bool = False,
    limit: float | None = None,
) -> DiagnosisOfPoses:
    """Return a test's diagnosis with its scatter traced to the joints, or a note why it is not.

    ``run`` holds all poses, ``held_out`` names one that ``found`` has not seen, ``reach`` asks for
    the map, with the ``limit`` of RP in mm. Raises `UsageError` where pose or map were asked for
    and cannot be given: the model gives no arm, the run not X and Y as lengths, or the model not
    where the joints are at two poses and at the one that is held out.
    """
    try:
        return _traced_to_joints(
            found, run.unwrapped(), model, wanted, held_out=held_out, reach=reach, limit=limit
        )
    except UsageError as error:
        if held_out is not None or reach:
            raise
        note = f"scatter is not traced to the joints: {error.what}; {error.remedy}"
        return replace(found, notes=(*found.notes, note))


def _traced_to_joints(
    found: DiagnosisOfPoses,
    run: Run,
    model: Model,
    wanted: CyclesWanted,
    *,
    held_out: str | None,
    reach: bool,
    limit: float | None,
) -> DiagnosisOfPoses:
    used = run.take(np.concatenate(wanted.used(run).rows))
    rows = {str(label): own for label, own in used.rows_by_pose()}
    at = {label: used.arrival_at(label)[0] or label for label in rows}
    joints = {label: model.poses[pose] for label, pose in at.items() if pose in model.poses}
    arm = _arm(used, model)
    unknown = [label for label in rows if label not in joints]
    measured = dict(_measured(found, joints))
    if len(measured) < _FEWEST_POSES or held_out in unknown:
        raise UsageError(
            f"the model does not say where the joints are at {', '.join(unknown)}",
            remedy="give [pose.P1] joint_deg and so on, as the table names its poses",
        )
    steps = [step_of(used.axes[axis]) for axis in PLANE]
    traced = trace_poses(measured, arm, steps)
    unseen = {}
    if held_out is not None:
        known = model.at(at[held_out])
        unseen[held_out] = _unseen(found, used.take(rows[held_out]), known, joints[held_out])
    elsewhere = {pose: one for pose, one in model.poses.items() if pose not in at.values()}
    scatter = joint_scatter(traced, measured, arm, elsewhere=elsewhere, held_out=unseen)
    note = f"the model does not say where {', '.join(unknown)} is: left out of the joints"
    notes = (*found.notes, *scatter.notes, *([note] if unknown else []))
    poses = {label: joints[label] for label in measured}
    if reach:
        scatter = replace(scatter, reach=reach_map(traced, arm, poses, limit=limit))
    found = replace(found, joint_scatter=scatter, notes=notes)
    if len(poses) < len(found.poses):
        return found
    test = whole_cycles(used, {label: rows[label] for label in poses}).run
    conditions = Conditions(test.cycle, test.covariates)
    followed = _followed_at_poses(found, [*poses.values()], conditions, arm, steps)
    return replace(found, followed=followed)


def _arm(run: Run, model: Model) -> Arm:
    if model.arm is None:
        raise UsageError(
            "the model gives no links", remedy="state link_1_mm and link_2_mm in [robot]"
        )
    if not all(a in run.axes and run.axes[a].dimension is Dimension.LENGTH for a in PLANE):
        raise UsageError(
            f"{', '.join(run.axes)} do not tell the joints apart",
            remedy="measure X and Y, as lengths",
        )
    return model.arm


def _measured(
    found: DiagnosisOfPoses, joints: Mapping[str, Joints]
) -> Iterator[tuple[str, ScatterAtPose]]:
    """Yield what is left at the poses whose joints are known.

    They share the sizes of effects in the joints.
    """
    for label, one in found.poses.items():
        if label not in joints:
            continue
        read, predicted = (
            np.stack([of[axis] for axis in PLANE], axis=1)
            for of in (one.series.measured, one.series.predicted_after)
        )
        numbers = sum(
            1 / len(found.poses)
            if isinstance(effect, FoundAtPoses) and effect.at_joint
            else len({*effect.axes} & {*PLANE})
            for effect in one.effects
        )
        yield label, ScatterAtPose(joints[label], read - predicted, read, numbers / len(PLANE))


def _unseen(found: DiagnosisOfPoses, run: Run, model: Model, joints: Joints) -> ScatterAtPose:
    """Return a pose that was held out, less what the model with the effects found says of it."""
    in_arm = [one for one in map(declared_in_arm, found.effects) if one is not None]
    known = replace(model, effects=(*model.effects, *in_arm))
    expected = predict(known, Conditions(run.cycle, run.covariates)).axes
    read = np.stack([run.axes[axis].readings for axis in PLANE], axis=1)
    still = np.zeros(len(run))
    moved = [expected[axis].readings if axis in expected else still for axis in PLANE]
    return ScatterAtPose(joints, read - np.stack(moved, axis=1), read)


def reach_map(
    traced: Traced,
    arm: Arm,
    poses: Mapping[str, Joints],
    cells: int = _CELLS,
    limit: float | None = None,
) -> ReachMap:
    """Return RP over the workspace, ``cells`` along its longer side, and where ``poses`` are.

    ``limit`` is the RP that is wanted, in mm. Where both elbows reach a place, the right one is
    taken: the left one's scatter is its mirror image, of the same RP.
    """
    low, high = Workspace.of(arm).extent()
    step = float((high - low).max()) / cells
    x, y = (np.arange(a + step / 2, b, step) for a, b in zip(low, high, strict=True))
    places = np.stack(np.meshgrid(x, y), axis=-1)
    joints = np.full(places.shape, np.nan)
    for elbow in (Elbow.LEFT, Elbow.RIGHT):
        solved = arm.solve(places, elbow)
        reached = np.all(arm.excess(solved) == 0, axis=-1)
        joints[reached] = solved[reached]
    inside = ~np.isnan(joints[..., 0])
    maps = np.full((3, *inside.shape), np.nan)
    maps[:, inside] = rp_at(traced, patterns_of(arm, joints[inside]))
    marked = {pose: tuple(arm.forward(at).tolist()) for pose, at in poses.items()}
    return ReachMap(x, y, maps[0], maps[1], maps[2], marked, limit)


def _followed_at_poses(
    found: DiagnosisOfPoses,
    joints: Sequence[Joints],
    test: Conditions,
    arm: Arm,
    division: Sequence[float],
) -> tuple[FollowedInJoints, ...]:
    """Return what follows the columns recorded in a test, beside the other effects found in it."""
    readings = [
        [one.series.measured[axis] - one.series.predicted_before[axis] for axis in PLANE]
        for one in found.poses.values()
    ]
    others_found = [
        course
        for one, course in zip(found.effects, found.courses, strict=True)
        if course.shape[1] > 1 or one.effect not in {*_PER, "temperature_lagged"}
    ]
    shown = np.moveaxis(np.array(readings), -1, 0)
    return followed_in_joints(shown, joints, division, arm, test, others_found)


def followed_in_joints(
    readings: FloatArray,
    joints_deg: Sequence[Joints],
    division: Sequence[float],
    arm: Arm,
    conditions: Conditions,
    courses: Sequence[FloatArray] = (),
) -> tuple[FollowedInJoints, ...]:
    """Return what follows each recorded column, traced to joints, links and dials.

    ``readings`` (n, P, 2) are X and Y of n cycles at P poses, on dials of divisions (2,), in mm;
    ``courses`` (n, k) are those of effects found that follow none of these columns. Nothing is
    returned of a column that does not vary or is the sum of others, and of fewer than three poses.

    What follows a column does so with ten sizes, those of X and Y at five poses. Joints, the growth
    of the links and the dials account for them by few numbers: least squares through the Jacobians,
    each pose weighed by the scatter of joints and dials there.
    """
    columns = dict(_columns(conditions))
    n, poses, _ = readings.shape
    others_found = np.concatenate([np.ones((n, 1)), *courses], axis=1)
    known = {key: one for key, one in columns.items() if _distinct(key, columns, others_found)}
    if not known or poses < _FEWEST_FOLLOWED or n <= len(known) + others_found.shape[1]:
        return ()
    design = np.column_stack([*known.values(), others_found])
    flat, inverse = readings.reshape(n, -1), np.linalg.pinv(design)
    freedom = max(1, n - int(np.linalg.matrix_rank(design)))
    sizes = (inverse @ flat).reshape(-1, poses, 2)
    left = (flat - design @ (inverse @ flat)).reshape(n, poses, 2)
    covariances = PoseCovariances.of(np.swapaxes(left, 0, 1), freedom, arm, joints_deg, division)
    scatter = covariances.expected(trace(covariances).variances)
    moves = movements(arm, joints_deg)
    of_size = (inverse**2).sum(axis=1).tolist()
    found = (
        _followed(key, sizes[k], of_size[k], left, freedom, scatter, moves)
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


def _followed(
    key: _Key,
    at_poses: FloatArray,
    of_size: float,
    left: FloatArray,
    freedom: int,
    scatter: FloatArray,
    moves: FloatArray,
) -> FollowedInJoints | None:
    """Return sizes (P, 2) of a column in its sources; None where the poses do not tell them apart.

    ``of_size`` is the variance of a size over that of a reading; what is ``left`` (n, P, 2) has
    covariances ``scatter`` (P, 2, 2) by joints and dials. Errors are those of the sources' own
    scatter from cycle to cycle. Where the poses disagree by more than sampling lets them at 5 %,
    they are widened by the root of that ratio (Birge 1932).
    """
    from scipy.special import chdtrc, stdtrit  # noqa: PLC0415 - heavy

    effect, column = key
    names = [one for one in MOVEMENTS if one != ARM or effect == "temperature"]  # links grow warm
    movement = moves[..., [MOVEMENTS.index(one) for one in names]]
    weighed = np.linalg.solve(scatter, movement)
    known = np.einsum("pik,pil->kl", movement, weighed)
    length = np.sqrt(np.diag(known))
    if np.linalg.eigvalsh(known / np.outer(length, length))[0] < _APART:
        return None
    estimate = np.einsum("kl,pil->kpi", np.linalg.inv(known), weighed)
    sizes = np.einsum("kpi,pi->k", estimate, at_poses)
    own = np.einsum("kpi,npi->nk", estimate, left)
    misfit = (at_poses - movement @ sizes)[..., np.newaxis]
    seen = np.linalg.solve(scatter, misfit)
    chi_square, over = float((misfit * seen).sum() / of_size), misfit.size - len(sizes)
    chance = float(chdtrc(over, chi_square))
    birge = max(1.0, chi_square / over) if chance < _WIDEN else 1.0
    error = np.sqrt((own**2).sum(axis=0) / freedom * of_size * birge)
    half = float(stdtrit(freedom, _LEVEL)) * error
    ends = zip(names, sizes.tolist(), half.tolist(), strict=True)
    by_source = {
        name: SizeInJoint(s, _unit(name) + _PER[effect], (s - h, s + h)) for name, s, h in ends
    }
    return FollowedInJoints(effect, column, by_source, chance)


def _unit(source: str) -> str:
    return "mm" if source.endswith("everywhere") else "1" if source == ARM else "rad"
