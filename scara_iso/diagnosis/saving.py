"""What was found beside what a model declares, and the model file that holds it."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scara_iso import robot
from scara_iso.diagnosis.poses_result import DiagnosisOfPoses
from scara_iso.diagnosis.result import Diagnosis, Found, FoundAtPoses
from scara_iso.effects import Effect, OwnEffect, ScatterChange, Values, find_effects
from scara_iso.robot import DeclaredCourse, DeclaredEffect, declare, is_random, read_model

if TYPE_CHECKING:
    from scara_iso.robot import Model


_ALIKE = 2.0
"""Sizes of random courses within this factor may be of one cause: 30 cycles show them no better."""


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


def declared_in_arm(found: FoundAtPoses) -> DeclaredEffect | None:
    """Return an effect of all poses as one that a model declares: in its joint, or in an axis.

    None where it is sure of neither: a model knows no effect of one pose alone.
    """
    at, place = found.at_joint, found.place or ""
    if at is None:
        return None
    axis = "theta" if place == "joint 4" else place.removesuffix(" everywhere")
    shape: dict[str, Any] = {
        k: v
        for k, v in found.parameters.items()
        if k not in at.parameters and not isinstance(v, tuple)
    }
    sizes = {name: {axis: value} for name, value in at.parameters.items()}
    return DeclaredEffect(found.effect, {**shape, **sizes})


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
