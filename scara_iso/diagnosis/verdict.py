"""What closing the loop can end with, on readings and on gears alike, and while they come."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Annotated, Literal, TypeAlias

from scara_iso.base.published import Probability, Size

Number: TypeAlias = Annotated[int, ("minimum", 1)]


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
