"""Readings as a dial would have shown them: the model, effects it does not declare, scatter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from scara_iso.effects import Conditions, find_effects
from scara_iso.errors import UsageError
from scara_iso.model.parts import DeclaredEffect, Indicator, Model
from scara_iso.model.predict import course, is_chance, predict
from scara_iso.run import FloatArray, Run


def simulate(
    model: Model,
    procedure: Conditions,
    *,
    rng: np.random.Generator,
    undeclared: Sequence[DeclaredEffect] = (),
    displacement: dict[str, FloatArray] | None = None,
) -> Run:
    """Return readings of ``model`` with scatter, rounded to each indicator's resolution.

    ``undeclared`` effects act on the readings and are written nowhere; ``displacement`` adds what
    another simulator gives, by axis, shape (n,). Raises `UsageError` for an effect that is not
    known or acts on an axis that the model does not have.
    """
    expected = predict(model, procedure)
    known = {effect.name: effect for effect in find_effects()}
    _check(undeclared, model, set(known))
    axes = {}
    for name, axis in expected.axes.items():
        readings = axis.readings + rng.normal(0, model.indicators[name].scatter, len(procedure))
        for declared in (*undeclared, *model.effects):
            effect = known.get(declared.name)
            if effect is None or name not in declared.axes:
                continue
            if declared in undeclared or is_chance(effect, declared, procedure, name):
                readings += course(effect, declared, procedure, name, rng)
        if displacement is not None and name in displacement:
            readings += displacement[name]
        axes[name] = replace(axis, readings=_shown(readings, model.indicators[name]))
    return replace(expected, axes=axes)


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
