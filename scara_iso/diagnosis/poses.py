"""Close the loop on all poses of a test: which effect, where it acts, what is gained at each."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scara_iso.base.published import publish
from scara_iso.diagnosis.engine.fit import Fit, SearchProblem, problem_of_poses
from scara_iso.diagnosis.engine.residual import (
    AllPoses,
    CyclesWanted,
    Joints,
    Predicted,
    all_own,
    axis_at,
    doubts,
    not_looked_for,
    on_one_thread,
    predicted_by,
)
from scara_iso.diagnosis.poses_result import DiagnosisOfPoses, Separation, rms_by_axis
from scara_iso.diagnosis.readings import diagnose_problem
from scara_iso.diagnosis.result import AtJoint, ByAxis, Diagnosis, Error, Found, FoundAtPoses
from scara_iso.diagnosis.separating import poses_apart
from scara_iso.diagnosis.verdict import SEED, Verdict
from scara_iso.effects import Effect, OwnEffect, find_effects
from scara_iso.robot import Arm
from scara_iso.run import FloatArray, Run

if TYPE_CHECKING:
    from scara_iso.robot import Model


_DUST = 1e-12
"""What the sine of a whole turn leaves of a size, in mm or degrees."""


@on_one_thread
def close_the_loop_at_poses(
    run: Run,
    model: Model | None,
    wanted: CyclesWanted,
    *,
    hold_out: Run | None = None,
    seed: int,
    sigma: float | None = None,
    own: Sequence[OwnEffect] = (),
) -> DiagnosisOfPoses:
    """Return what ``model`` (None: a constant) leaves unexplained at all poses of a run together.

    Effects are traced to the joints where the model gives the arm and its joints at every pose.
    The other options are those of `close_the_loop`; ``hold_out`` holds the same poses.
    """
    known_own = all_own(own, model)
    test, expected, at = _test_of(run, model, wanted)
    second = None if hold_out is None else _test_of(hold_out, model, wanted)[:2]
    known = {} if model is None else model.poses
    joints = {
        label: known[pose] for label, pose in at.items() if pose is not None and pose in known
    }
    traced = model is not None and len(joints) == len(test.parts)
    found = diagnose_poses(
        test,
        expected,
        arm=model.arm if model is not None and traced else None,
        joints_deg=joints,
        seed=seed,
        effects=find_effects(known_own),
        sigma=sigma,
        held_out=second,
    )
    notes = (*filter(None, [run.simulated]), *not_looked_for(known_own, test.run), *found.notes)
    if model is not None:
        notes = (*notes, *_not_traced(model, at, joints), *doubts(model, run))
    return replace(found, notes=notes)


def _test_of(
    run: Run, model: Model | None, wanted: CyclesWanted
) -> tuple[AllPoses, dict[str, Predicted], dict[str, str | None]]:
    """Return all poses of a run, what a model predicts at each, and the pose of each label."""
    test = wanted.all_poses(run)
    at = {label: run.arrival_at(label)[0] for label in test.parts}
    if model is None or not model.poses:  # its effects are of one pose, and nobody says which
        return test, {}, at
    expected: dict[str, Predicted] = {
        label: predicted_by(model.at(at[label]), part) or {} for label, part in test.parts.items()
    }
    return test, expected, at


def _not_traced(
    model: Model, at: Mapping[str, str | None], known: Mapping[str, object]
) -> Iterator[str]:
    missing = list(dict.fromkeys(f"[pose.{at[label]}]" for label in at if label not in known))
    lacking = [*(["[robot] link_1_mm and link_2_mm"] if model.arm is None else []), *missing]
    if lacking:
        yield f"effects are not traced to the joints: the model lacks {', '.join(lacking)}"


def diagnose_poses(
    test: AllPoses,
    predicted: Mapping[str, Predicted] | None = None,
    *,
    arm: Arm | None = None,
    joints_deg: Mapping[str, Joints] | None = None,
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
    second = None
    if held_out is not None:
        visits = held_out[0].conditions(test.parts)
        second = held_out[0].run, _by_axis_at(held_out[1]), visits
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
        separation=_separation(test, arm, joints_deg),
        courses=tuple(term.columns for term in fitted.terms[: len(found)]),
        notes=(*test.notes, *whole.notes),
    )


def _by_axis_at(predicted: Mapping[str, Predicted]) -> dict[str, FloatArray]:
    return {
        axis_at(axis, pose): np.asarray(readings)
        for pose, own in predicted.items()
        for axis, readings in own.items()
    }


def _separation(
    test: AllPoses, arm: Arm | None, joints_deg: Mapping[str, Joints] | None
) -> Separation | None:
    planar = all({"X", "Y"} <= part.axes.keys() for part in test.parts.values())
    if arm is None or joints_deg is None or not planar:
        return None
    apart = poses_apart(arm, [joints_deg[pose] for pose in test.parts])
    return Separation(apart.angle_deg, apart.observability_index)


def _found(
    found: Found, fitted: Fit, i: int, test: AllPoses, problem: SearchProblem
) -> FoundAtPoses:
    """Return an effect of the axes at all poses by pose and axis, with its place."""
    of = [test.axes[name] for name in found.axes]
    result = publish(
        FoundAtPoses,
        found,
        axes=tuple(dict.fromkeys(one.axis for one in of)),
        poses=tuple(dict.fromkeys(one.pose for one in of)),
        **_each_value(found, lambda value: _by_pose(value, test)),
    )
    located = fitted.terms[i].located
    if located is None:
        return result
    result = replace(result, places=located.probability)
    if not located.is_sure:
        return replace(result, joint_candidates=located.joint_candidates)
    place = located.place
    at = _size(fitted, i, problem) if place.tied else None
    return replace(result, joint=place.joint, place=place.name, at_joint=at)


def _each_value(found: Found, of: Callable[[ByAxis], Any]) -> dict[str, Any]:
    by_name = {
        name: {k: of(v) if isinstance(v, Mapping) else v for k, v in getattr(found, name).items()}
        for name in ("parameters", "standard_errors", "left_open")
    }
    return {**by_name, "share": of(found.share)}


def _size(fitted: Fit, i: int, problem: SearchProblem) -> AtJoint:
    term = fitted.terms[i]
    located = term.located
    assert located is not None  # noqa: S101 - asked for located terms only
    effect = problem.effects[term.effect]
    sizes = (fitted.coefficients[i] @ located.weights)[:, 0]
    left = (problem.residual.values - fitted.predicted) @ located.weights
    free = term.columns - term.columns.mean(axis=0)
    error = float(
        np.sqrt((left**2).sum() / max(1, len(left) - 2)) / np.linalg.norm(free, axis=0).min()
    )
    sizes_by_name = effect.linear.sizes(sizes)
    return AtJoint(float(sizes_by_name[effect.size_name]), located.place.unit, error, sizes_by_name)


def _by_pose(by_axis: ByAxis, test: AllPoses) -> dict[str, dict[str, float]]:
    found: dict[str, dict[str, float]] = {}
    for name, part in by_axis.items():
        one = test.axes[name]
        found.setdefault(one.pose, {})[one.axis] = part if abs(part) > _DUST else 0.0
    return found


def _at(pose: str, test: AllPoses, whole: Diagnosis, found: Sequence[FoundAtPoses]) -> Diagnosis:
    own = {axis_at(axis, pose): axis for axis in (*test.parts[pose].axes, "XY", "XYZ")}
    effects = tuple(_effect_at(pose, one) for one in found if pose in one.poses)
    verdict = Verdict.EXPLAINED if effects else Verdict.NOTHING
    here: Diagnosis = _here(replace(whole, effects=(), notes=()), own)
    return replace(
        here,
        verdict=whole.verdict if whole.verdict is Verdict.UNEXPLAINED else verdict,
        effects=effects,
        series=replace(here.series, cycle=test.parts[pose].cycle),
        notes=tuple(note for note in whole.notes if _is_of(note, pose, test)),
    )


def _here(part: Any, own: Mapping[str, str]) -> Any:
    """Return the part of a result that is of some axes, which ``own`` names anew."""
    if isinstance(part, Mapping):
        return {own[name]: _here(one, own) for name, one in part.items() if name in own}
    if isinstance(part, tuple):
        about = ((one, getattr(one, "axis", None)) for one in part)
        return tuple(_here(one, own) for one, axis in about if axis is None or axis in own)
    if not is_dataclass(part) or isinstance(part, type):
        return part
    names = [one.name for one in fields(part) if one.init]
    changed = {name: _here(getattr(part, name), own) for name in names}
    if "axis" in names:
        changed["axis"] = own[changed["axis"]]
    return replace(part, **changed)


def _is_of(note: str, pose: str, test: AllPoses) -> bool:
    """Return whether a note is about this pose, or about none."""
    about = {
        one.pose for name, one in test.axes.items() if re.search(rf"{re.escape(name)}(?!\w)", note)
    }
    return not about or pose in about


def _effect_at(pose: str, found: FoundAtPoses) -> FoundAtPoses:
    here = _each_value(found, lambda by_pose: by_pose.get(pose, {}))
    sizes = [v for v in here["parameters"].values() if isinstance(v, Mapping)]
    return replace(found, axes=tuple(next(iter(sizes), found.axes)), poses=(pose,), **here)


def _over_poses(error: Error, test: AllPoses) -> Error:
    rms, unseen = (
        rms_by_axis((test.axes[name].axis, value) for name, value in one.items())
        for one in (error.rms, error.held_out_rms)
    )
    return Error(rms, unseen)
