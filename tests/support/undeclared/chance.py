"""Scatter that changes, counts that are lost, passing disturbances, and scatter alone."""

from __future__ import annotations

import numpy as np

from undeclared.dial import CYCLES, SCATTER, on_dial

_ROW = np.arange(CYCLES)


def scatter_doubles(rng):
    """Half way something comes loose: twice the scatter from then on, on all three axes."""
    width = SCATTER * np.where(_ROW < 16, 1.0, 2.0)
    return on_dial(rng, dict.fromkeys("XYZ", np.zeros(CYCLES)), scatter=width)


def comes_loose(rng):
    """The same on one axis, and four times the scatter."""
    width = SCATTER * np.where(_ROW < rng.integers(12, 20), 1.0, 4.0)
    return on_dial(rng, {"X": np.zeros(CYCLES)}, scatter=width)


def lost_counts(rng):
    """A stepper without encoder loses or gains whole steps of 5 um and never finds them again."""
    lost = rng.choice([-1, 0, 0, 1], CYCLES)
    return on_dial(rng, {"X": 0.005 * np.cumsum(lost), "Y": np.zeros(CYCLES)})


def passing(rng):
    """A door is opened and closed: the reading goes off and comes back, as t exp(-t)."""
    t = np.maximum(_ROW - rng.integers(6, 15), 0) / rng.uniform(2.0, 4.0)
    moved = rng.choice([-1, 1]) * rng.uniform(0.020, 0.028) * t * np.exp(1 - t)
    return on_dial(rng, {"X": moved, "Y": 0.6 * moved})


def knocked(rng):
    """A knock at the stand, which then creeps back to where it was."""
    since = _ROW - rng.integers(6, 16)
    moved = np.where(since < 0, 0.0, np.exp(-np.maximum(since, 0) / rng.uniform(2.5, 5.0)))
    moved *= rng.choice([-1, 1]) * rng.uniform(0.022, 0.030)
    return on_dial(rng, {"X": moved, "Y": 0.6 * moved})


def three_loads(rng):
    """A neighbouring machine is loaded, loaded again and unloaded: four levels in all."""
    at = np.sort(rng.choice(np.arange(5, 27, 4), 3, replace=False))
    moved = rng.choice([-1, 1]) * 0.016 * np.array([0.0, 1.0, 2.2, 0.5])[np.searchsorted(at, _ROW)]
    return on_dial(rng, {"X": moved, "Y": 0.6 * moved})


def beating(rng):
    """Two pumps of nearly the same speed: a vibration that swells and dies away."""
    f = rng.uniform(0.15, 0.3)
    moved = 0.012 * np.sin(2 * np.pi * f * _ROW) * np.sin(np.pi * _ROW / CYCLES) ** 2
    return on_dial(rng, {"X": moved, "Y": np.roll(moved, 1)})


def pointed_scatter(rng):
    """Scatter alone: pointed on X, skewed on Y."""
    drawn = {"X": rng.laplace(0, np.sqrt(0.5), CYCLES), "Y": rng.gamma(4.0, 0.5, CYCLES) - 2.0}
    return on_dial(rng, {name: SCATTER * z for name, z in drawn.items()}, scatter=0.0005)


def flat_scatter(rng):
    """Scatter alone, equally likely within limits, as of a servo that stops in its dead band."""
    flat = rng.uniform(-1, 1, CYCLES) * np.sqrt(3)
    return on_dial(rng, {"X": SCATTER * flat}, scatter=0.0005)
