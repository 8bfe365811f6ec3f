"""What closing the loop can end with, on readings and on gears alike, and while they come.

Commands that diagnose nothing take names and levels from here: it imports no effect.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import numpy as np

from scara_iso.base.published import Probability, Size

if TYPE_CHECKING:
    from scara_iso.effects import Form

Number: TypeAlias = Annotated[int, ("minimum", 1)]

SEED = 9283
"""Seed of every permutation and simulation unless another is given."""

RIVAL = 0.1
"""Share of the best one's probability from which another is its rival: an effect, or a way in
which unknown scatter may grow with a deviation."""

LEVEL = 0.05
"""Level at which a first effect is admitted."""

FURTHER_LEVEL = 0.01
"""Level at which a further one is."""

UNKNOWN = "unknown"
"""Name of the processes that stand for structure outside the catalogue."""

FEWEST_CYCLES, MOST_CYCLES = 8, 500


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


@dataclass(frozen=True, slots=True)
class Watched:
    """What all readings up to ``cycle`` say together."""

    event: Literal["watch"] = field(default_factory=lambda: "watch", init=False, repr=False)
    """What happens."""
    cycle: Number
    """Counted from 1, the first included."""
    evidence: Size
    """20 and more is an alarm: at most 5 % of recordings in which nothing acts come so far."""
    says: Literal["structure", "nothing yet"]
    """`structure` at an alarm."""
    effect: str | None = None
    """The likeliest effect so far, at an alarm."""
    since: Number | None = None
    """The cycle from which it acts."""
    share: Probability | None = None
    """Probability of that effect among those that the program knows and the unknown."""
    rivals: Mapping[str, Probability] | None = None
    """Others at least a tenth as likely, with theirs."""


@dataclass(frozen=True, eq=False, slots=True)
class Choice:
    """Probability of every effect, given that there is one; the unknown is one of them.

    ``forms`` holds the likeliest form of each: of readings over all cycles of the run, and hidden
    states as the course that they took. ``log_change`` is what dial and tails changed in each
    effect's evidence. Where each pose has a course of its own it is that of one ``pose``.
    """

    probability: Mapping[str, float]
    forms: Mapping[str, Form]
    log_change: Mapping[str, float] = field(default_factory=dict)
    pose: int | None = None

    @property
    def best(self) -> str:
        """Name of the likeliest effect, or UNKNOWN."""
        return max(self.probability, key=self.probability.__getitem__)

    @property
    def ranked(self) -> tuple[Rival, ...]:
        """All effects, likeliest first."""
        ranked = sorted(self.probability.items(), key=lambda item: -item[1])
        return tuple(Rival(name, p) for name, p in ranked)

    @property
    def rivals(self) -> tuple[Rival, ...]:
        """Other effects at least a tenth as likely as the best, likeliest first."""
        best, *others = self.ranked
        return tuple(one for one in others if one.probability >= RIVAL * best.probability)


def posterior(log_evidence: Mapping[str, float]) -> dict[str, float]:
    """Return probabilities from the logarithms of evidence."""
    largest = max(log_evidence.values(), default=0.0)
    likely = {name: float(np.exp(e - largest)) for name, e in log_evidence.items()}
    whole = sum(likely.values())
    return {name: value / whole for name, value in likely.items()}
