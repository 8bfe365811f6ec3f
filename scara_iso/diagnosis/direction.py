"""Along which physical direction an effect moves the tool."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from scara_iso.diagnosis.tuning import FARTHEST_DEG
from scara_iso.run import FloatArray


@dataclass(frozen=True, slots=True)
class Match:
    """The direction that fits (None: none does), and the angle to every candidate in degrees."""

    name: str | None
    angles: Mapping[str, float]


def match(
    movement: FloatArray, uncertainty: FloatArray, directions: Mapping[str, FloatArray]
) -> Match:
    """Return how the ``movement`` of the axes (axes,) fits the candidate ``directions``.

    ``uncertainty`` (axes,) are standard errors. The nearest direction is named if the movement
    lies along it within its uncertainty and within 15 degrees, and along no other; with one axis
    nothing can be told.
    """
    if len(movement) < 2 or not directions or not np.any(movement):
        return Match(None, {})
    angles = {name: _angle(movement, along) for name, along in directions.items()}
    fitting = [
        name
        for name, along in directions.items()
        if angles[name] <= FARTHEST_DEG and _agrees(movement, uncertainty, along)
    ]
    return Match(fitting[0] if len(fitting) == 1 else None, angles)


def _angle(movement: FloatArray, along: FloatArray) -> float:
    lengths = float(np.linalg.norm(movement) * np.linalg.norm(along))
    cosine = abs(float(movement @ along)) / lengths if lengths else 0.0
    return float(np.degrees(np.arccos(min(1.0, cosine))))


def _agrees(movement: FloatArray, uncertainty: FloatArray, along: FloatArray) -> bool:
    """Whether what is left across ``along`` is within twice its expectation (chi-squared)."""
    sigma = np.maximum(uncertainty, 1e-12)
    size = float((movement * along / sigma**2).sum() / (along**2 / sigma**2).sum())
    misfit = float((((movement - size * along) / sigma) ** 2).sum())
    freedom = len(movement) - 1
    return bool(misfit <= freedom + 3 * np.sqrt(2 * freedom))
