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
