"""Close the loop on a run: predict the rows that count, subtract, name what is left.

One table among many is only searched (`screen`): p-value, verdict and names are the same; errors,
shares and predictions are not computed. Where many tables are judged together (`fleets`), the
p-value that PERMUTATIONS orders can give may be too coarse: `finer` looks at more of the same
orders.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

from scara_iso import robot
from scara_iso.base.errors import DataError
from scara_iso.diagnosis.fit import SearchProblem, problem_of, problem_of_poses
from scara_iso.diagnosis.readings import diagnose_readings, verdict_of
from scara_iso.diagnosis.residual import (
    AllPoses,
    CyclesWanted,
    Predicted,
    groups_of,
    repeatabilities,
)
from scara_iso.diagnosis.result import Diagnosis, Found
from scara_iso.diagnosis.saving import as_declared, declarations
from scara_iso.diagnosis.search import STEP, find, finer_p_value
from scara_iso.diagnosis.verdict import Verdict
from scara_iso.effects import Conditions, OwnEffect, find_effects
from scara_iso.iso9283 import copied_in, exchanged_in, resumed_before
from scara_iso.run import Run

if TYPE_CHECKING:
    from scara_iso.diagnosis.poses_result import DiagnosisOfPoses
    from scara_iso.robot import Model


_PLANE = ("X", "Y")
_Work = TypeVar("_Work", bound=Callable[..., object])
_on_one_thread: Callable[[_Work], _Work] = threadpool_limits.wrap(limits=1, user_api="blas")
"""A second thread gains nothing on matrices of thirty readings, and waits in a loop."""


@_on_one_thread
def close_the_loop(
    run: Run,
    model: Model | None,
    wanted: CyclesWanted,
    *,
    hold_out: Run | None = None,
    seed: int,
    sigma: float | None = None,
    own: Sequence[OwnEffect] = (),
) -> Diagnosis:
    """Return what ``model`` (None: a constant pose) leaves unexplained in the rows that count.

    ``own`` are effects of the user's beside those of the model; ``sigma`` is the known scatter of
    the readings in mm, of every axis in mm. Errors as in `CyclesWanted.take` and
    `diagnosis.diagnose`, and `DataError` for a model that has none of the run's axes.
    """
    used = wanted.take(run)
    model = None if model is None else model.at(wanted.pose or used.metadata.get("pose"))
    second = None if hold_out is None else wanted.take(hold_out)
    known_own = _all_own(own, model)
    found = diagnose_readings(
        used,
        _predicted(model, used),
        seed=seed,
        held_out=second,
        held_out_predicted=None if second is None else _predicted(model, second),
        directions={} if model is None else directions_of(model),
        sigma={name: sigma for name, axis in used.axes.items() if sigma and axis.unit == "mm"},
        effects=find_effects(known_own),
    )
    notes = (*filter(None, [run.simulated]), *_not_looked_for(known_own, used), *found.notes)
    found = replace(found, notes=notes, effects=tuple(_with_causes(found.effects, used)))
    if model is None:
        return found
    from scara_iso.diagnosis.reversals import diagnose_run_reversals  # noqa: PLC0415 - with a model

    reversals = diagnose_run_reversals(used, model, seed=seed)
    notes = (*found.notes, *as_declared(found, model), *_doubts(model, run))
    found = replace(found, notes=notes, reversals=reversals)
    return _with_gone(found, model, used, seed=seed)


def _all_own(own: Sequence[OwnEffect], model: Model | None) -> tuple[OwnEffect, ...]:
    known = {one.name: one for one in (*own, *(() if model is None else model.own))}
    return tuple(known.values())


def _with_causes(effects: Iterable[Found], used: Run) -> Iterator[Found]:
    """Yield effects; what the table tells of a likelier cause is that of one.

    Axes that change places, of one that moves both; a recording that was resumed, of a step there;
    rows that are others again, of all.
    """
    copied = copied_in(used, np.arange(len(used)))
    again = f"rows were copied or the gauges stuck: {copied.in_words(used.cycle)}" if copied else ""
    resumed = resumed_before(used.metadata)
    rows = np.arange(len(used))
    pairs = list(combinations(used.axes.values(), 2))
    exchanged = {(a.name, b.name): exchanged_in(used.cycle, a, b, rows) for a, b in pairs}
    for one in effects:
        why = next((why for pair, why in exchanged.items() if why and {*pair} <= {*one.axes}), "")
        known = f"columns or cables exchanged, {why}" if why else again
        if one.effect == STEP and (at := one.parameters["at_cycle"]) in resumed:
            known = f"the recording was resumed before cycle {at:g}, and dial or fixture moved"
        yield replace(one, cause=f"{known}; else {one.cause}" if known else one.cause)


def _not_looked_for(own: Iterable[OwnEffect], run: Run) -> Iterator[str]:
    for one in own:
        missing = [name for name in one.needs if name not in run.covariates]
        forms = one.forms(Conditions(run.cycle, run.covariates))
        if missing:
            yield f"{one.name}: not looked for; the table has no column {', '.join(missing)}"
        elif not any(np.ptp(form.columns) > 0 for form in forms):
            yield f"{one.name}: not looked for; its formula moves nothing in these cycles"


def _with_gone(found: Diagnosis, model: Model, used: Run, *, seed: int) -> Diagnosis:
    """Return ``found`` with the effects named that those on the gear account for.

    A reversal that differs with the payload is more than one half width: beside approaches by turns
    it looks like a course over the cycles.
    """
    on_gear = tuple(e for e in declarations(found) if e.joint is not None)
    if found.reversals is None or not on_gear:
        return found
    known = replace(model, effects=(*model.effects, *on_gear))
    own, along = find_effects(model.own), directions_of(model)
    problem = problem_of(used, _predicted(known, used), directions=along, effects=own)
    still = {term.effect for term in find(problem, np.random.default_rng(seed))[0]}
    gone = tuple(one.effect for one in found.effects if one.effect not in still)
    effects = {effect.name: effect for effect in find_effects()}
    others = [name for name in gone if not effects[name].by_flank]
    said = (
        f"{', '.join(others)}: gone once the effects on the gear are in the model: that is their "
        "reversal, which differs with the payload"
    )
    notes = (said,) if others else ()
    reversals = replace(found.reversals, accounts_for=gone, notes=(*found.reversals.notes, *notes))
    return replace(found, reversals=reversals)


def _doubts(model: Model, run: Run) -> Iterator[str]:
    unknown = [axis for axis in run.axes if axis not in model.indicators]
    if unknown:
        yield f"the model has no indicator {', '.join(unknown)}: a constant pose is taken there"
    named = run.metadata.get("robot", "")
    if model.robot and named and model.robot.casefold() != named.casefold():
        yield f"the model is that of {model.robot}, the table is of {named}: is it the right one?"


@_on_one_thread
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
    from scara_iso.diagnosis.poses import diagnose_poses  # noqa: PLC0415 - of several poses

    known_own = _all_own(own, model)
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
    notes = (*filter(None, [run.simulated]), *_not_looked_for(known_own, test.run), *found.notes)
    if model is not None:
        notes = (*notes, *_not_traced(model, at, joints), *_doubts(model, run))
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
        label: _predicted(model.at(at[label]), part) or {} for label, part in test.parts.items()
    }
    return test, expected, at


def _not_traced(
    model: Model, at: Mapping[str, str | None], known: Mapping[str, object]
) -> Iterator[str]:
    missing = list(dict.fromkeys(f"[pose.{at[label]}]" for label in at if label not in known))
    lacking = [*(["[robot] link_1_mm and link_2_mm"] if model.arm is None else []), *missing]
    if lacking:
        yield f"effects are not traced to the joints: the model lacks {', '.join(lacking)}"


def _predicted(model: Model | None, run: Run) -> dict[str, np.ndarray] | None:
    if model is None:
        return None
    unknown = [name for name in run.axes if name not in model.indicators]
    if len(unknown) == len(run.axes):
        raise DataError(
            f"the model has no indicator {', '.join(unknown)}",
            where=run.origin.source,
            remedy="take the model of this robot, or leave `model=` out",
        )
    for name, axis in run.axes.items():
        if name in model.indicators and model.indicators[name].dimension is not axis.dimension:
            raise DataError(
                f"{name} is in {axis.unit}, and in {model.indicators[name].dimension.value} in the "
                "model",
                where=run.origin.source,
                remedy=f"state the unit of [indicator.{name}], or take the model of this robot",
            )
    expected = robot.predict(model, Conditions(run.cycle, run.covariates))
    return {name: a.readings for name, a in expected.axes.items() if name in run.axes}


def directions_of(model: Model) -> dict[str, Mapping[str, float]]:
    """Return how far X and Y move for each joint [mm/rad], and along the arm as it grows [mm]."""
    if model.arm is None or model.joints_deg is None:
        return {}
    moves = model.arm.movements(model.joints_deg).T
    names = ("joint 1", "joint 2", "along the arm")
    return {
        name: dict(zip(_PLANE, moved.tolist(), strict=True))
        for name, moved in zip(names, moves, strict=True)
    }


class Screened(NamedTuple):
    """What is found of one table, of all its poses together."""

    cycles: int
    """That count, at each pose."""
    poses: int
    """How many there are."""
    verdict: Verdict
    """As that of `close_the_loop`."""
    p_value: float
    """Smallest of the tests, each over its share of the level."""
    at_floor: bool
    """Nothing drawn came as far: the p-value is a bound."""
    effects: tuple[str, ...]
    """Names, each once."""
    RP: Mapping[str, float]
    """By figure, the largest of a pose [mm, deg]."""


def screen(run: Run, wanted: CyclesWanted, *, seed: int) -> Screened:
    """Return what is found in the rows of a table that count, all poses together.

    Raises `DataError` as `close_the_loop` and `close_the_loop_at_poses`.
    """
    problem, poses = _searched(run, wanted)
    terms, stages = find(problem, np.random.default_rng(seed))
    return Screened(
        cycles=len(poses[0]),
        poses=len(poses),
        verdict=verdict_of(terms, stages),
        p_value=stages[0].p_value,
        at_floor=stages[0].p_value_at_floor,
        effects=tuple(dict.fromkeys(term.effect for term in terms)),
        RP=_largest_RP(poses),
    )


def finer(run: Run, wanted: CyclesWanted, orders: int, *, seed: int) -> tuple[float, bool]:
    """Return the p-value of a table by more ``orders``, and whether none of them came as far."""
    return finer_p_value(_searched(run, wanted)[0], np.random.default_rng(seed), orders)


def _searched(run: Run, wanted: CyclesWanted) -> tuple[SearchProblem, tuple[Run, ...]]:
    """Return the search that a table is, and its poses."""
    if len(list(run.rows_by_pose())) == 1:
        used = wanted.take(run)
        return problem_of(used, directions={}, effects=find_effects()), (used,)
    test = wanted.all_poses(run)
    return problem_of_poses(test), tuple(test.parts.values())


def _largest_RP(poses: tuple[Run, ...]) -> dict[str, float]:  # noqa: N802 - the field's symbol
    found: dict[str, float] = {}
    for pose in poses:
        readings = {name: axis.readings for name, axis in pose.axes.items()}
        for name, value in repeatabilities(readings, groups_of(pose.axes)).items():
            found[name] = max(value, found.get(name, 0.0))
    return found
