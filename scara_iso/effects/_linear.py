"""The parameters in which a course is linear, and how its coefficients are read as them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from scara_iso.effects._parameter import Sizes
from scara_iso.run import FloatArray


@dataclass(frozen=True, slots=True)
class Linear:
    """The parameters in which a course is linear, and its coefficients (k,)."""

    names: tuple[str, ...]
    sizes: Callable[[FloatArray], dict[str, float]]
    coefficients: Callable[[Sizes], FloatArray]


def _polar(coefficients: FloatArray) -> dict[str, float]:
    sine, cosine = float(coefficients[0]), float(coefficients[1])
    return {"size": math.hypot(sine, cosine), "phase": math.atan2(cosine, sine)}


SIZE = Linear(("size",), lambda c: {"size": float(c[0])}, lambda v: np.array([v["size"]]))
"""One column, times ``size``."""

AMPLITUDE_AND_PHASE = Linear(
    ("size", "phase"),
    _polar,
    lambda v: v["size"] * np.array([math.cos(v["phase"]), math.sin(v["phase"])]),
)
"""A sine and a cosine: size sin(angle + phase)."""
