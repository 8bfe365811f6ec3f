"""What a test can end with: its figures against limits, its readings or gears against a model."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Verdict(Enum):
    """What the residual holds; the value is the word used in outputs."""

    NOTHING = "nothing-to-explain"
    EXPLAINED = "explained"
    UNEXPLAINED = "unexplained"


class Decision(Enum):
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


@dataclass(frozen=True, slots=True)
class Rival:
    """Another effect that the data do not exclude, and its probability."""

    effect: str
    probability: float
