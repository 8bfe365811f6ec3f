"""How a figure is held against its limit, and what comes of it."""

from __future__ import annotations

from enum import Enum
from typing import TypeAlias

EVERY_LENGTH = ""
"""Key of a limit that holds for every repeatability of a length without a limit of its own."""


Limit: TypeAlias = float | tuple[float, float]
"""The largest value that is allowed, or the smallest and the largest."""


class DecisionRule(Enum):
    """The rule by which a figure is held against its limit; the value is the word in outputs."""

    INTERVAL = "interval"
    """The figure's 95 % interval: proven inside, proven outside, or neither."""
    SIMPLE = "simple"
    """The figure alone, its uncertainty not counted: simple acceptance (JCGM 106, 8.2)."""


class Conformity(Enum):
    """Whether a limit is kept; the value is the word used in outputs."""

    PASS = "pass"  # noqa: S105 - no word to be kept
    FAIL = "fail"
    NOT_PROVABLE = "not-provable"
