"""Pieces of parts, so that the tables of one are shared among many processes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

One = TypeVar("One")


@dataclass(frozen=True, slots=True)
class Share:
    """One of so many equal shares of what stands in an order, counted from 0."""

    number: int
    of: int

    def take(self, several: Sequence[One]) -> Sequence[One]:
        """Return this share of it, which may be nothing."""
        first, end = (k * len(several) // self.of for k in (self.number, self.number + 1))
        return several[first:end]


WHOLE = Share(0, 1)


@dataclass(frozen=True, slots=True)
class Piece:
    """A share of the tables of a part."""

    path: str
    share: Share = WHOLE
