"""What the model expects the dials to read, and what they would have shown.

The expectation is pose, reversal of the gears and declared effects; a simulation adds scatter, and
effects that the model does not declare. Where friction stops the load inside the gap is here too.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import Enum

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.effects import Conditions, Effect, Sweep, find_effects, find_gear_effects
from scara_iso.robot.model import DeclaredEffect, Gearbox, Indicator, Model, on_dials
from scara_iso.run import Axis, FloatArray, IntArray, Origin, Run

_PLANE = ("X", "Y")
"""The indicators of the plane, in the base frame."""


def predict(model: Model, procedure: Conditions, *, reversal: bool = True) -> Run:
    """Return the readings that ``model`` expects over the cycles of ``procedure``.

    Each is pose + half the gears' reversal on the side of ``approach`` + every declared effect
    whose course is determined; an effect of chance (which flank, a random walk) moves the
    expectation by nothing, a learned course by what it was. Without an ``approach`` column every
    cycle arrives on the same flank and the reversal is a constant, which belongs to the pose;
    ``reversal`` False leaves it out. Raises `UsageError` for an effect that lacks a parameter or
    needs a column that the procedure does not have.
    """
    known = {effect.name: effect for effect in find_effects(model.own)}
    axes = {}
    for name, indicator in model.indicators.items():
        readings = np.full(len(procedure), indicator.level)
        if reversal:
            readings += _reversal(model, procedure, name)
        for learned in model.learned:
            if learned.axis == name:
                readings += learned.at(procedure.cycle)
        for declared in model.effects:
            effect = known.get(declared.name)
            if effect is None:
                continue
            acting = on_dials(declared, effect, model)
            if name in acting.axes and not is_random(effect, acting, name):
                readings += course(effect, acting, procedure, name)
        axes[name] = Axis(
            name, readings, indicator.dimension, indicator.resolution, indicator.uncertainty
        )
    return Run(
        cycle=procedure.cycle,
        axes=axes,
        covariates=procedure.covariates,
        metadata={"robot": model.robot},
        origin=Origin(source="model"),
    )


def is_random(effect: Effect, declared: DeclaredEffect, axis: str) -> bool:
    """Return whether chance draws the course of an effect anew in every test."""
    return effect.is_random(_given(effect, declared, axis))


def course(
    effect: Effect,
    declared: DeclaredEffect,
    procedure: Conditions,
    axis: str,
    rng: np.random.Generator | None = None,
) -> FloatArray:
    """Return what one effect adds to the readings of one axis, shape (n,), in the axis' unit."""
    values = effect.at_pace(procedure, _given(effect, declared, axis))
    lacking = [p for p in effect.parameters if p.name not in values]
    if lacking:
        raise UsageError(
            f"effect {declared.name} gives {lacking[0].in_seconds}, and the test has no time_s",
            remedy=f"record time_s, or give {lacking[0].name} in cycles too",
        )
    for column in effect.columns_needed(values):
        if column not in procedure.covariates or not effect.takes(column):
            raise UsageError(
                f"effect {declared.name} needs the column {column}, which the test does not have",
                remedy="record it, simulate it, or take the effect out of the model",
            )
    # A course that is not random draws nothing: any generator gives the same.
    found = effect.series(procedure, values, np.random.default_rng(0) if rng is None else rng)
    if not np.isfinite(found).all():
        cycle = int(procedure.cycle[np.flatnonzero(~np.isfinite(found))[0]])
        raise UsageError(
            f"effect {declared.name} has no finite value at cycle {cycle}",
            remedy="change its formula or its parameters",
        )
    return found


def _given(effect: Effect, declared: DeclaredEffect, axis: str) -> dict[str, float | str]:
    values = declared.on_axis(axis)
    missing = [p.name for p in effect.parameters if not {p.name, p.in_seconds} & set(values)]
    if missing:
        raise UsageError(
            f"effect {declared.name}: {', '.join(missing)} not given",
            remedy=f"it takes {', '.join(p.name for p in effect.parameters)}",
        )
    return values


def _reversal(model: Model, procedure: Conditions, axis: str) -> FloatArray:
    approach = procedure.covariates.get("approach")
    if approach is None or axis not in _PLANE:
        return np.zeros(len(procedure))
    payload = procedure.covariates.get("payload_kg")
    width = np.zeros(1)
    for joint in model.gearboxes:
        width = width + lever_mm(model, joint)[axis] * sweep_of(model, joint, payload).deviation
    return np.asarray(np.sign(approach) * width / 2)


def lever_mm(model: Model, joint: int) -> dict[str, float]:
    """Return how far the dials X and Y move for each radian of a joint, in mm.

    0 where the model holds no arm or pose.
    """
    if model.arm is None or model.joints_deg is None:
        return dict.fromkeys(_PLANE, 0.0)
    column = model.arm.jacobian(model.joints_deg)[:, joint - 1]
    return dict(zip(_PLANE, column.tolist(), strict=True))


def sweep_of(model: Model, joint: int, payload: FloatArray | None = None) -> Sweep:
    """Return what eq. 16 takes of one joint, with the gear effects declared for it.

    One entry, or one for each ``payload`` [kg]: a point mass at the tool, where the gearbox says
    which payload its I_L includes, else without influence. Raises `UsageError` where that leaves no
    inertia. The torque at a reversal is taken to be the friction, which holds the wound-up gear.
    """
    gear = model.gearboxes[joint]
    I_L = np.full(1 if payload is None else len(payload), gear.IL)
    if payload is not None and gear.payload_kg is not None:
        distance = math.hypot(*lever_mm(model, joint).values()) / 1000
        I_L = gear.IL + (payload - gear.payload_kg) * distance**2
    if np.any(I_L <= 0):
        raise UsageError(
            f"gearbox.joint_{joint}: without its payload of {gear.payload_kg:g} kg no I_L is left",
            remedy="check IL and payload_kg",
        )
    one = np.ones_like(I_L)
    sweep = Sweep(
        I_m=gear.Im * one,
        I_L=I_L,
        gap=math.radians(gear.arcmin / 60) * one,
        torque=None if gear.friction is None else gear.friction * one,
        ratio=None if gear.ratio is None else gear.ratio * one,
    )
    known = {effect.name: effect for effect in find_gear_effects()}
    for declared in model.effects:
        if declared.name in known and declared.joint == joint:
            sweep = known[declared.name].changed(sweep, **declared.on_axis(""))
    return sweep


class Approach(Enum):
    """From which side the pose is approached."""

    ONE_SIDE = "one"
    """Always in the positive direction."""
    BOTH_SIDES = "both"
    """In the positive and the negative direction alternately."""
    RANDOM = "random"
    """In either direction with the same probability."""


def sides(approach: Approach, count: int, rng: np.random.Generator) -> IntArray:
    """Return the direction of each approach, +1 or -1, shape (count,)."""
    match approach:
        case Approach.ONE_SIDE:
            return np.ones(count, dtype=np.int64)
        case Approach.BOTH_SIDES:
            return 1 - 2 * (np.arange(count, dtype=np.int64) % 2)
        case Approach.RANDOM:
            return 1 - 2 * rng.integers(2, size=count)


# The paper states no move and no friction. These are assumed: a brisk move, arrivals that differ
# by a few per cent, and friction that lets the load stop inside the gap.
_SPEED, _SPEED_SCATTER = 1.0, 0.02  # rad/s
_DECELERATION = 10.0  # rad/s2
_FRICTION_SCATTER = 0.1


def rest_positions(
    model: Model, approach: Approach, *, count: int, rng: np.random.Generator
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Return the approach (+1/-1) of each arrival and what X and Y read of it, in mm, shape (n,).

    Each gearbox is followed by itself and moves the tool along its joint's column of the Jacobian;
    all joints turn in the direction of the approach. Raises `UsageError` where the model holds no
    arm, pose or gearbox, and for a gearbox with a stiffness.
    """
    if model.arm is None or model.joints_deg is None or not model.gearboxes:
        raise UsageError(
            "the drive train needs the arm, the pose and a gearbox",
            remedy="give [robot], [pose] and [gearbox.joint_1] in the model",
        )
    jacobian = model.arm.jacobian(model.joints_deg)
    moved = np.zeros((2, count))
    approaches = sides(approach, count, rng)
    for joint, gear in model.gearboxes.items():
        rest = rest_in_gap(gear, approaches, rng)
        moved += jacobian[:, joint - 1, np.newaxis] * rest
    return approaches.astype(np.float64), {"X": moved[0], "Y": moved[1]}


def rest_in_gap(gear: Gearbox, approaches: IntArray, rng: np.random.Generator) -> FloatArray:
    """Return where the load rests, in rad from where it would without a gap, shape (n,).

    The servo holds the motor to its command whatever the load does: it drives the load at speed v,
    brakes at d and stands. Friction stops the load at f, so it runs ahead of the motor by
    v^2 / 2 (1 / f - 1 / d), from the driving flank to the other one at most.
    """
    if gear.stiffness is not None:
        raise UsageError(
            "arrivals are followed in closed form, without viscous friction or compliance",
            remedy="leave them out",
        )
    speed = _SPEED * _scattered(_SPEED_SCATTER, len(approaches), rng)
    friction = (gear.friction or 0.0) * _scattered(_FRICTION_SCATTER, len(approaches), rng)
    with np.errstate(divide="ignore"):
        ahead = speed**2 / 2 * (gear.IL / friction - 1 / _DECELERATION)
    gap = math.radians(gear.arcmin / 60)
    return np.asarray(approaches * (np.clip(ahead, 0.0, gap) - gap / 2))


def _scattered(scatter: float, count: int, rng: np.random.Generator) -> FloatArray:
    """Return factors about 1; a factor that chance makes tiny or negative is held at a tenth."""
    return np.maximum(1.0 + scatter * rng.standard_normal(count), 0.1)


def simulate(
    model: Model,
    procedure: Conditions,
    *,
    rng: np.random.Generator,
    undeclared: Sequence[DeclaredEffect] = (),
    displacement: Mapping[str, FloatArray] | None = None,
) -> Run:
    """Return readings of ``model`` with scatter, rounded to each indicator's resolution.

    ``undeclared`` effects act on the readings and are written nowhere; ``displacement`` is what
    another simulator gives in place of the gears' reversal, by axis, shape (n,). What chance draws
    of an effect is one course for all its axes where the effect is `common`. Raises `UsageError`
    for an effect that is not known, acts on an axis that the model does not have, or begins behind
    the last cycle.
    """
    expected = predict(model, procedure, reversal=displacement is None)
    known = {effect.name: effect for effect in find_effects(model.own)}
    _check(undeclared, model, set(known))
    readings = {
        name: axis.readings + rng.normal(0, model.indicators[name].scatter, len(procedure))
        for name, axis in expected.axes.items()
    }
    for name, moved in (displacement or {}).items():
        if name in readings:
            readings[name] += moved
    drawn = (
        on_dials(one, known[one.name], model)
        for one in model.effects
        if one.name in known and is_random(known[one.name], one, one.axes[0])
    )
    for declared in (*undeclared, *drawn):
        effect, seed = known[declared.name], rng.integers(2**63)
        for name in declared.axes:
            chance = np.random.default_rng(seed) if effect.common else rng
            moved = course(effect, declared, procedure, name, chance)
            if declared in undeclared and not moved.any():
                _check_begun(declared, name, int(procedure.cycle[-1]))
            readings[name] += moved
    axes = {
        name: replace(axis, readings=_shown(readings[name], model.indicators[name]))
        for name, axis in expected.axes.items()
    }
    return replace(expected, axes=axes)


def _check_begun(declared: DeclaredEffect, axis: str, last: int) -> None:
    """Raise `UsageError` where an effect that moves nothing begins behind the last cycle."""
    begins = declared.on_axis(axis).get("at_cycle", 0.0)
    if isinstance(begins, float) and begins > last:
        raise UsageError(
            f"effect {declared.name} begins at cycle {begins:g}, and the last is {last}",
            remedy="simulate more cycles, or let it begin within them",
        )


def _shown(readings: FloatArray, indicator: Indicator) -> FloatArray:
    if indicator.resolution is None:
        return readings
    decimals = max(0, round(-np.log10(indicator.resolution)) + 2)
    return np.round(np.round(readings / indicator.resolution) * indicator.resolution, decimals)


def _check(undeclared: Sequence[DeclaredEffect], model: Model, known: set[str]) -> None:
    for declared in undeclared:
        if declared.name not in known:
            raise UsageError(
                f"unknown effect {declared.name!r}", remedy=f"use one of {', '.join(sorted(known))}"
            )
        foreign = [axis for axis in declared.axes if axis not in model.indicators]
        if foreign:
            raise UsageError(
                f"effect {declared.name}: the model has no indicator {', '.join(foreign)}",
                remedy=f"it has {', '.join(model.indicators)}",
            )
