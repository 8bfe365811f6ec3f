"""The step on which a dial's readings lie, where its resolution is not stated."""

from __future__ import annotations

import numpy as np

from scara_iso.run import Axis, FloatArray

_EXACT = 1e-6
_OFF_STEP = 0.02
"""Share of a step by which a reading may lie beside its multiple."""


def step_of(axis: Axis) -> float:
    """Return the axis' resolution, else the step on which all its readings lie, 0 without one."""
    return axis.resolution or common_step(axis.readings)


def common_step(readings: FloatArray) -> float:
    """Return the smallest distance of two readings if all others are multiples of it, else 0.

    A coarse dial of which nothing is stated would pass for two levels.
    """
    distances = np.diff(np.sort(readings))
    distances = distances[distances > 0]
    if not len(distances) or distances.min() < _EXACT * np.ptp(readings):
        return 0.0
    steps = (readings - readings.min()) / distances.min()
    return float(distances.min()) if np.all(np.abs(steps - np.rint(steps)) < _OFF_STEP) else 0.0
