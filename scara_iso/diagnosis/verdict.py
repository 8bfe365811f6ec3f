"""What closing the loop can end with, on readings and on gears alike."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from scara_iso.base.published import Probability


class Verdict(Enum):
    """What the residual holds; the value is the word used in outputs."""

    NOTHING = "nothing-to-explain"
    EXPLAINED = "explained"
    UNEXPLAINED = "unexplained"


@dataclass(frozen=True, slots=True)
class Rival:
    """Another effect that the data do not exclude, and its probability."""

    effect: str
    """Its name."""
    probability: Probability
    """Posterior, 0 to 1."""


@dataclass(frozen=True, eq=False, kw_only=True)
class StructureTested:
    """Whether there is structure, and whether effects explain it."""

    verdict: Verdict
    """What the residual holds."""
    p_value: Probability
    """Chance of structure as strong in scatter alone."""
    p_value_at_floor: bool
    """No shuffle or simulation was as far: the chance is at most the p-value."""
