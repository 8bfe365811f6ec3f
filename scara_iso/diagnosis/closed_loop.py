"""Close the loop on a run of one pose: predict the rows that count, subtract, name what is left.

What was found then stands beside what a model declares, and in the model file that holds it. One
table among many is only searched (`screen`): p-value, verdict and names are the same; errors,
shares and predictions are not computed. Where many tables are judged together (`fleets`), the
p-value that PERMUTATIONS orders can give may be too coarse: `finer` looks at more of the same
orders.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from scara_iso import robot
from scara_iso.diagnosis.engine.fit import SearchProblem, problem_of, problem_of_poses
from scara_iso.diagnosis.engine.residual import (
    CyclesWanted,
    all_own,
    doubts,
    groups_of,
    not_looked_for,
    on_one_thread,
    predicted_by,
    repeatabilities,
)
from scara_iso.diagnosis.engine.search import STEP, find, finer_p_value
from scara_iso.diagnosis.poses_result import DiagnosisOfPoses, declared_in_arm
from scara_iso.diagnosis.readings import diagnose_readings, verdict_of
from scara_iso.diagnosis.result import Diagnosis, Found, FoundAtPoses
from scara_iso.diagnosis.verdict import UNKNOWN, Verdict
from scara_iso.effects import Effect, OwnEffect, ScatterChange, Values, find_effects
from scara_iso.iso9283 import copied_in, exchanged_in, resumed_before
from scara_iso.robot import DeclaredCourse, DeclaredEffect, declare, is_random, read_model
from scara_iso.run import Run

if TYPE_CHECKING:
    from scara_iso.robot import Model


_PLANE = ("X", "Y")

_ALIKE = 2.0
"""Sizes of random courses within this factor may be of one cause: 30 cycles show them no better."""


@on_one_thread
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
    known_own = all_own(own, model)
    found = diagnose_readings(
        used,
        predicted_by(model, used),
        seed=seed,
        held_out=second,
        held_out_predicted=None if second is None else predicted_by(model, second),
        directions={} if model is None else directions_of(model),
        sigma={name: sigma for name, axis in used.axes.items() if sigma and axis.unit == "mm"},
        effects=find_effects(known_own),
    )
    notes = (*filter(None, [run.simulated]), *not_looked_for(known_own, used), *found.notes)
    found = replace(found, notes=notes, effects=tuple(_with_causes(found.effects, used)))
    if model is None:
        return found
    from scara_iso.diagnosis.gears import diagnose_run_reversals  # noqa: PLC0415 - with a model

    reversals = diagnose_run_reversals(used, model, seed=seed)
    notes = (*found.notes, *as_declared(found, model), *doubts(model, run))
    found = replace(found, notes=notes, reversals=reversals)
    return _with_gone(found, model, used, seed=seed)


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
    problem = problem_of(used, predicted_by(known, used), directions=along, effects=own)
    terms, stages = find(problem, np.random.default_rng(seed))
    still = {term.effect for term in terms}
    gone = [one.effect for one in found.effects if one.effect not in still]
    if found.learned is not None and stages[-1].choice is None and not stages[-1].misfit:
        gone.append(UNKNOWN)
    effects = {effect.name: effect for effect in find_effects()}
    others = [name for name in gone if name == UNKNOWN or not effects[name].by_flank]
    called = ["the course over the cycles" if name == UNKNOWN else name for name in others]
    said = (
        f"{', '.join(called)}: gone once the effects on the gear are in the model: that is their "
        "reversal, which differs with the payload"
    )
    notes = (said,) if others else ()
    reversals = replace(
        found.reversals, accounts_for=tuple(gone), notes=(*found.reversals.notes, *notes)
    )
    return replace(found, reversals=reversals)


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


def as_declared(found: Diagnosis, model: Model) -> Iterator[str]:
    """Yield which effects the model declares already: chance draws them anew in every test."""
    effects = {effect.name: effect for effect in find_effects(model.own)}
    for again in found.effects:
        declared = {
            axis: one.on_axis(axis)
            for one in model.effects
            if one.name == again.effect
            for axis in one.axes
            if robot.is_random(effects[one.name], one, axis)
        }
        if declared.keys().isdisjoint(again.axes):
            continue
        yield (
            f"{again.effect}: as declared; the model holds it, and chance draws it anew in every "
            f"test{_unlike(again, declared)}"
        )


def _unlike(again: Found, declared: Mapping[str, Values]) -> str:
    notes = [f"new on {axis}" for axis in again.axes if axis not in declared]
    sizes = again.parameters.get("size")
    for axis, values in declared.items():
        size = sizes.get(axis) if isinstance(sizes, Mapping) else None
        if size and not 1 / _ALIKE < abs(size / float(values.get("size", size))) < _ALIKE:
            notes.append(f"size {axis} {size:.2g}, declared {values['size']:.2g}")
    return "".join(f"; {one}" for one in notes)


def declarations(diagnosis: Diagnosis) -> tuple[DeclaredEffect, ...]:
    """Return what was found as effects that a model declares.

    Effects on the gear take the place of the reversal that they account for, unless the load
    rests where the model cannot put it.
    """
    reversals = diagnosis.reversals
    gear = reversals.gear if reversals is not None and not reversals.mirrored else None
    on_gear = (
        []
        if gear is None
        else [DeclaredEffect(one.effect, dict(one.parameters), one.joint) for one in gear.effects]
    )
    recorded = {effect.name for effect in find_effects() if effect.by_flank and effect.needs}
    gone = set() if reversals is None else recorded | {*reversals.accounts_for}
    kept = [f for f in diagnosis.effects if not (on_gear and f.effect in gone)]
    return (*(declared(found) for found in kept), *on_gear)


def declared(found: Found) -> DeclaredEffect:
    """Return a found effect as one that a model declares."""
    given = {k: v for k, v in found.parameters.items() if not isinstance(v, tuple)}
    return DeclaredEffect(found.effect, {**given, **found.left_open})


def _narrowest_scatter(
    effects: Sequence[DeclaredEffect], known: Mapping[str, Effect]
) -> dict[str, float]:
    """Return the scatter where it is narrowest, by axis: what a declared change of it adds to."""
    changes = (one for one in effects if isinstance(known.get(one.name), ScatterChange))
    return {
        axis: float(one.on_axis(axis)[known[one.name].size_name])
        for one in changes
        for axis in one.axes
    }


def save_model(
    diagnosis: Diagnosis | DiagnosisOfPoses, model: str, to: Path, own: Sequence[OwnEffect] = ()
) -> tuple[str, ...]:
    """Write ``model`` with what was found to ``to``; return what of it was declared.

    An effect that does not recur is left out, and one of single poses; ``own`` are the user's
    effects beside the model's. Raises as `declare`.
    """
    described = read_model(model, own)
    known = {effect.name: effect for effect in find_effects(described.own)}
    recurring = tuple(found for found in diagnosis.effects if known[found.effect].recurs)
    if isinstance(diagnosis, Diagnosis):
        effects = declarations(replace(diagnosis, effects=recurring))
    else:
        in_arm = map(declared_in_arm, diagnosis.effects)
        effects = tuple(one for one in in_arm if one is not None and known[one.name].recurs)
    dials = described.indicators
    seen = {**diagnosis.scatter, **_narrowest_scatter(effects, known)}
    scatter = {a: float(f"{s:.3g}") for a, s in seen.items() if a in dials}
    learned = _learned(diagnosis, dials)
    declare(model, effects, to, scatter, described.own, learned)
    notes = [f"{to} {line}" for line in _written(diagnosis, recurring, effects, known, learned)]
    sizes = ", ".join(f"{axis} {value:g}" for axis, value in scatter.items())
    notes = notes or [f"{to} holds the model's effects as they were: none was found to declare"]
    return (*notes, f"{to} states the scatter: {sizes}") if scatter else tuple(notes)


def _written(
    diagnosis: Diagnosis | DiagnosisOfPoses,
    recurring: Sequence[Found],
    effects: Sequence[DeclaredEffect],
    known: Mapping[str, Effect],
    learned: Sequence[DeclaredCourse],
) -> Iterator[str]:
    for found in recurring:
        if isinstance(found, FoundAtPoses) and declared_in_arm(found) is None:
            yield (
                f"does not hold the {found.effect} at {', '.join(found.poses)}: a model knows "
                "effects of a joint or of a dial, not of single poses"
            )
    for one in effects:
        yield f"declares {one.name}{_expectation(one, known.get(one.name))}"
    for found in diagnosis.effects:
        if found not in recurring:
            yield (
                f"does not hold the {found.effect}: an accident of this table says nothing of the "
                "next"
            )
    for course in learned:
        yield f"holds the learned course of {course.axis}: nameless, as it went in this table"


def _learned(
    diagnosis: Diagnosis | DiagnosisOfPoses, dials: Container[str]
) -> tuple[DeclaredCourse, ...]:
    """Return the learned courses of one pose as a model holds them; it has none of single poses."""
    if not isinstance(diagnosis, Diagnosis) or diagnosis.learned is None:
        return ()
    if diagnosis.reversals is not None and UNKNOWN in diagnosis.reversals.accounts_for:
        return ()
    return tuple(
        DeclaredCourse(axis, one.cycle.astype(float), one.value, np.ptp(one.band, axis=1) / 4)
        for axis, one in diagnosis.learned.axes.items()
        if axis in dials
    )


def _expectation(one: DeclaredEffect, effect: Effect | None) -> str:
    """Return what a model with the effect says of the next table; none is known on the gear."""
    if effect is not None and is_random(effect, one, one.axes[0]):
        return (
            " for simulate only: chance draws it anew in every test, so no prediction moves and "
            "the next table will show it again"
        )
    if "at_cycle" in one.parameters:
        return (
            f" at cycle {one.parameters['at_cycle']}, and expects it there in the next table: take "
            "it out once its cause is cured"
        )
    if "phase" in one.parameters:
        return " with the phase of this table: the next one must begin at the same phase"
    return ": the next table is expected to show it"
