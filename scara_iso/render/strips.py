"""Readings drawn in one line of text."""

from __future__ import annotations

import numpy as np

from scara_iso.run import FloatArray

LEVELS = "▁▂▃▄▅▆▇█"


def sparkline(readings: FloatArray, levels: str = LEVELS, width: int = 60) -> str:
    """Return readings drawn one character each, lowest to highest level.

    ``readings`` of shape (n,); more than ``width`` of them are averaged in equal groups.
    """
    if len(readings) > width:
        edges = np.linspace(0, len(readings), width + 1).astype(int)
        readings = np.add.reduceat(readings, edges[:-1]) / np.diff(edges)
    low, high = float(readings.min()), float(readings.max())
    if high == low:
        return levels[len(levels) // 2] * len(readings)
    place = (readings - low) / (high - low) * (len(levels) - 1)
    return "".join(levels[k] for k in np.rint(place).astype(int))
