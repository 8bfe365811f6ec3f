"""Readings as a dial would have shown them: the model, effects it does not declare, scatter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from scara_iso.effects import Conditions, Effect, find_effects
from scara_iso.errors import UsageError
from scara_iso.robot.model.at_joint import on_dials
from scara_iso.robot.model.parts import DeclaredEffect, Indicator, Model
from scara_iso.robot.model.predict import course, is_random, predict
from scara_iso.run import FloatArray, Run


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
    for an effect that is not known or acts on an axis that the model does not have.
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
    for effect, declared in [
        *((known[d.name], d) for d in undeclared),
        *_random(model, known),
    ]:
        for name, moved in _courses(effect, declared, procedure, rng):
            readings[name] += moved
    axes = {
        name: replace(axis, readings=_shown(readings[name], model.indicators[name]))
        for name, axis in expected.axes.items()
    }
    return replace(expected, axes=axes)


def _random(model: Model, known: Mapping[str, Effect]) -> Iterator[tuple[Effect, DeclaredEffect]]:
    """Yield the declared effects that the prediction leaves out because chance draws them."""
    for declared in model.effects:
        effect = known.get(declared.name)
        if effect is not None and is_random(effect, declared, declared.axes[0]):
            yield effect, on_dials(declared, effect, model)


def _courses(
    effect: Effect, declared: DeclaredEffect, procedure: Conditions, rng: np.random.Generator
) -> Iterator[tuple[str, FloatArray]]:
    """Yield what the effect adds to each of its axes: one draw of chance for all if common."""
    seed = rng.integers(2**63)
    for name in declared.axes:
        chance = np.random.default_rng(seed) if effect.common else rng
        yield name, course(effect, declared, procedure, name, chance)


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
