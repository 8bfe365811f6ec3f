"""All poses of a test in one search: which effect, where it acts, and what is gained at each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from scara_iso.base.published import publish
from scara_iso.diagnosis.all_poses import AllPoses, axis_at
from scara_iso.diagnosis.evidence import ManyPoses
from scara_iso.diagnosis.fit import Fit, Term
from scara_iso.diagnosis.places import BOTH, JOINTS, Place, places_of, separation
from scara_iso.diagnosis.poses_result import DiagnosisOfPoses, Separation
from scara_iso.diagnosis.readings import diagnose_problem
from scara_iso.diagnosis.residual import Predicted
from scara_iso.diagnosis.result import (
    AtJoint,
    ByAxis,
    Diagnosis,
    Error,
    Found,
    FoundAtPoses,
    Learned,
    Repeatabilities,
    Series,
)
from scara_iso.diagnosis.search import SearchProblem, problem_of
from scara_iso.diagnosis.tuning import (
    JOINTS_SHARE,
    SEED,
)
from scara_iso.diagnosis.verdict import Verdict
from scara_iso.effects import Effect, find_effects
from scara_iso.robot import Arm
from scara_iso.run import FloatArray

_Value = TypeVar("_Value")
_DUST = 1e-12
"""What the sine of a whole turn leaves of a size, in mm or degrees."""


def diagnose_poses(
    test: AllPoses,
    predicted: Mapping[str, Predicted] | None = None,
    *,
    arm: Arm | None = None,
    joints_deg: Mapping[str, tuple[float, float]] | None = None,
    seed: int = SEED,
    effects: Sequence[Effect] | None = None,
    sigma: float | None = None,
    held_out: tuple[AllPoses, Mapping[str, Predicted]] | None = None,
) -> DiagnosisOfPoses:
    """Return what all poses of a test show together that is more than scatter, and where it acts.

    ``predicted`` is that of a model by pose and axis; with an ``arm`` and its joints at every pose
    effects are traced to them. Whole cycles are shuffled by the test. ``sigma`` is the known
    scatter of every axis in mm, ``held_out`` a second test of the same poses with its prediction.
    Errors as in `diagnose_readings`.
    """
    expected = _by_axis_at(predicted or {})
    problem = problem_of_poses(test, expected, arm, joints_deg, effects, sigma)
    second = None if held_out is None else (held_out[0].run, _by_axis_at(held_out[1]))
    whole, fitted = diagnose_problem(
        problem, test.run, expected, test.planes(), seed=seed, second=second
    )
    found = tuple(_found(one, fitted, i, test, problem) for i, one in enumerate(whole.effects))
    return DiagnosisOfPoses(
        poses={pose: _at(pose, test, whole, found) for pose in test.parts},
        effects=found,
        verdict=whole.verdict,
        p_value=whole.p_value,
        p_value_at_floor=whole.p_value_at_floor,
        candidates=whole.candidates,
        error=whole.error.each(lambda one: _over_poses(one, test)),
        separation=_separation(problem),
        courses=tuple(_course(term, len(test.run)) for term in fitted.terms[: len(found)]),
        notes=(*test.notes, *whole.notes),
    )


def _by_axis_at(predicted: Mapping[str, Predicted]) -> dict[str, FloatArray]:
    return {
        axis_at(axis, pose): np.asarray(readings)
        for pose, own in predicted.items()
        for axis, readings in own.items()
    }


def problem_of_poses(
    test: AllPoses,
    predicted: Predicted | None = None,
    arm: Arm | None = None,
    joints_deg: Mapping[str, tuple[float, float]] | None = None,
    effects: Sequence[Effect] | None = None,
    sigma: float | None = None,
) -> SearchProblem:
    """Return the search that `diagnose_poses` makes; ``predicted`` is by the test's axes."""
    catalogue = tuple(find_effects() if effects is None else effects)
    known = {name: sigma for name, one in test.axes.items() if sigma and one.unit == "mm"}
    problem = problem_of(test.run, predicted, directions={}, effects=catalogue, sigma=known)
    columns = [test.axes[name] for name in problem.residual.axes]
    places = places_of(columns, arm, joints_deg)
    lines = [place for place in places if place.tied and place.name != BOTH]
    labels = list(dict.fromkeys(column.pose for column in columns))
    return replace(
        problem,
        places=places,
        directions={place.name: place.movement[:, 0] for place in lines},
        poses=ManyPoses(np.array([labels.index(c.pose) for c in columns]), _shares(lines)),
    )


def _shares(lines: Sequence[Place]) -> np.ndarray:
    """Return how much each direction counts in the test: the joints for most of it."""
    joints = np.array([place.name in JOINTS for place in lines])
    if not joints.any():
        return np.full(len(lines), 1 / max(1, len(lines)))
    others = max(1, int((~joints).sum()))
    return np.where(joints, JOINTS_SHARE / joints.sum(), (1 - JOINTS_SHARE) / others)


def _course(term: Term, n: int) -> FloatArray:
    return np.empty((n, 0)) if term.columns is None else term.columns


def _separation(problem: SearchProblem) -> Separation | None:
    if problem.poses is None or not any(place.name == BOTH for place in problem.places):
        return None
    return Separation(*separation(problem.places, problem.residual.values, problem.poses.of))


def _found(
    found: Found, fitted: Fit, i: int, test: AllPoses, problem: SearchProblem
) -> FoundAtPoses:
    """Return an effect of the axes at all poses by pose and axis, with its place."""
    of = [test.axes[name] for name in found.axes]
    parameters = {k: _by_pose(v, test) for k, v in found.parameters.items()}
    told = publish(
        FoundAtPoses,
        found,
        axes=tuple(dict.fromkeys(one.axis for one in of)),
        poses=tuple(dict.fromkeys(one.pose for one in of)),
        parameters=parameters,
        standard_errors={k: _by_pose(v, test) for k, v in found.standard_errors.items()},
        share=_by_pose(found.share, test),
        left_open={k: _by_pose(v, test) for k, v in found.left_open.items()},
    )
    located = fitted.terms[i].located
    if located is None:
        return told
    told = replace(told, places=located.probability)
    if not located.is_sure:
        return replace(told, joint_candidates=located.joint_candidates)
    place = located.place
    at = None if not place.tied or place.name == BOTH else _size(fitted, i, problem)
    return replace(told, joint=place.joint, place=place.name, at_joint=at)


def _size(fitted: Fit, i: int, problem: SearchProblem) -> AtJoint:
    """Return the size of an effect in its place, with its standard error."""
    term = fitted.terms[i]
    located = term.located
    assert located is not None  # noqa: S101 - asked for located terms only
    effect = problem.effects[term.effect]
    sizes = (fitted.coefficients[i] @ located.weights)[:, 0]
    left = (problem.residual.values - fitted.predicted) @ located.weights
    course = term.columns
    assert course is not None  # noqa: S101
    free = course - course.mean(axis=0)
    error = float(
        np.sqrt((left**2).sum() / max(1, len(left) - 2)) / np.linalg.norm(free, axis=0).min()
    )
    said = effect.linear.sizes(sizes)
    return AtJoint(float(said[effect.size_name]), located.place.unit, error, said)


def _by_pose(value: Any, test: AllPoses) -> Any:
    """Return what is given by axis at a pose by pose and axis."""
    if not isinstance(value, Mapping):
        return value
    found: dict[str, dict[str, float]] = {}
    for name, part in value.items():
        one = test.axes[name]
        found.setdefault(one.pose, {})[one.axis] = part if abs(part) > _DUST else 0.0
    return found


def _verdict_at(whole: Diagnosis, effects: Sequence[Found]) -> Verdict:
    if whole.verdict is Verdict.UNEXPLAINED:
        return whole.verdict
    return Verdict.EXPLAINED if effects else Verdict.NOTHING


def _at(pose: str, test: AllPoses, whole: Diagnosis, found: Sequence[FoundAtPoses]) -> Diagnosis:
    """Return what was found at one pose."""
    own = {axis_at(axis, pose): axis for axis in (*test.parts[pose].axes, "XY", "XYZ")}

    def here(values: Mapping[str, _Value]) -> dict[str, _Value]:
        return {axis: values[name] for name, axis in own.items() if name in values}

    RP, series = whole.repeatability, whole.series
    unseen = RP.unseen and replace(
        RP.unseen,
        measured=here(RP.unseen.measured),
        model_before=here(RP.unseen.model_before),
        completed=here(RP.unseen.completed),
    )
    effects = tuple(_effect_at(pose, one) for one in found if pose in one.poses)
    return replace(
        whole,
        verdict=_verdict_at(whole, effects),
        effects=effects,
        error=whole.error.each(lambda one: Error(here(one.rms), here(one.held_out_rms))),
        repeatability=Repeatabilities(
            here(RP.measured),
            here(RP.model_before),
            here(RP.model_after),
            here(RP.with_effect_removed),
            here(RP.completed),
            unseen,
        ),
        shares=here(whole.shares),
        scatter=here(whole.scatter),
        series=Series(
            test.parts[pose].cycle,
            here(series.measured),
            here(series.predicted_before),
            here(series.predicted_after),
        ),
        courses=tuple(replace(c, axis=own[c.axis]) for c in whole.courses if c.axis in own),
        learned=Learned(here(whole.learned.axes)) if whole.learned else None,
        flags=tuple(replace(f, axis=own[f.axis]) for f in whole.flags if f.axis in own),
        notes=tuple(note for note in whole.notes if _is_of(note, pose, test)),
    )


def _is_of(note: str, pose: str, test: AllPoses) -> bool:
    """Return whether a note is about this pose, or about none."""
    about = {one.pose for name, one in test.axes.items() if name in note}
    return not about or pose in about


def _effect_at(pose: str, found: FoundAtPoses) -> FoundAtPoses:
    """Return an effect as it acts at one pose."""

    def here(value: Any) -> Any:
        return value.get(pose, {}) if isinstance(value, Mapping) else value

    parameters = {k: here(v) for k, v in found.parameters.items()}
    sizes = [v for v in parameters.values() if isinstance(v, Mapping)]
    return replace(
        found,
        axes=tuple(next(iter(sizes), found.axes)),
        poses=(pose,),
        parameters=parameters,
        standard_errors={k: here(v) for k, v in found.standard_errors.items()},
        share=here(found.share),
        left_open={k: here(v) for k, v in found.left_open.items()},
    )


def _over_poses(error: Error, test: AllPoses) -> Error:
    """Return the root mean square over all poses, by axis."""

    def over(by_axis: ByAxis) -> dict[str, float]:
        squares: dict[str, list[float]] = {}
        for name, value in by_axis.items():
            squares.setdefault(test.axes[name].axis, []).append(value**2)
        return {axis: float(np.sqrt(np.mean(own))) for axis, own in squares.items()}

    return Error(over(error.rms), over(error.held_out_rms))
