"""What the search says of every axis of its run, those that it left out among them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from scara_iso.diagnosis.fit import Fit
from scara_iso.diagnosis.residual import Predicted, Residual
from scara_iso.run import FloatArray, Run


def standing_of(
    run: Run, predicted: Predicted, residual: Residual, groups: Mapping[str, tuple[str, ...]]
) -> dict[str, tuple[tuple[int, float], ...]]:
    """Return, for each RP, the axes of the search that stand for its own, and their slopes."""
    model = {name: np.asarray(predicted.get(name, 0.0)) for name in run.axes}
    stand = {
        name: _searched(axis.readings - model[name], residual, name)
        for name, axis in run.axes.items()
    }
    return {name: tuple(stand[axis] for axis in axes) for name, axes in groups.items()}


def courses_of_axes(
    run: Run, predicted: Predicted, residual: Residual, fitted: Fit
) -> tuple[dict[str, FloatArray], ...]:
    """Return by axis: measured, predicted before and after, measured with effects removed."""
    measured = {name: np.asarray(axis.readings) for name, axis in run.axes.items()}
    before, after, removed = {}, {}, {}
    for name, readings in measured.items():
        model = np.asarray(predicted.get(name, np.zeros(len(run))), dtype=np.float64)
        before[name] = model + (readings - model).mean()
        after[name], removed[name] = before[name], readings
        a, slope = _searched(readings - model, residual, name)
        effect = slope * sum((part[:, a] for part in fitted.parts), np.zeros(len(run)))
        after[name] = before[name] + effect - effect.mean()
        if name in residual.axes:
            after[name] = model + fitted.predicted[:, a]
        left = residual.values[:, a] - fitted.predicted[:, a]
        removed[name] = readings - effect + slope * (fitted.cured[a] - 1) * left
    return measured, before, after, removed


def _searched(left: FloatArray, residual: Residual, name: str) -> tuple[int, float]:
    """Return which axis of the search stands for this one, and its slope on it.

    An axis that copies another has that one's effects; one that never moves has none (slope 0).
    """
    if name in residual.axes:
        return residual.axes.index(name), 1.0
    values = residual.values - residual.values.mean(axis=0)
    slopes = (left - left.mean()) @ values / (values**2).sum(axis=0)
    a = int(np.argmax(np.abs(slopes) * np.linalg.norm(values, axis=0)))
    return a, float(slopes[a])
