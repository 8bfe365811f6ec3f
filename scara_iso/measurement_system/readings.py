"""The readings of a study of one dial: each with the part, operator or session that it is of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from scara_iso.errors import DataError
from scara_iso.run import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class Remark:
    """Something to know about the dial of an axis before its figures are signed."""

    severity: Literal["warning", "info"]
    """Whether it doubts the figures."""
    axis: str
    """Whose dial."""
    message: str
    """In words."""


@dataclass(frozen=True, eq=False, slots=True)
class GaugeReadings:
    """Readings of one dial in the order in which they were taken, shape (n,), in mm or degrees."""

    axis: str
    """``X``, ``Y``, ``Z``, ``theta`` or ``reading``."""
    values: FloatArray
    """What the dial showed."""
    unit: str
    """``mm`` or ``deg``, of every size here."""
    resolution: float | None = None
    """The dial's division; None where not stated."""
    uncertainty: float | None = None
    """Standard uncertainty of the dial, from its certificate; None where not stated."""
    reference: FloatArray | None = None
    """True value of what each reading is of, shape (n,); None where not stated."""
    part: tuple[str, ...] | None = None
    """What each reading is of."""
    operator: tuple[str, ...] | None = None
    """Who took it."""
    session: tuple[str, ...] | None = None
    """When it was taken: readings of one session stand together."""
    time: tuple[str, ...] | None = None
    """Date and time as the table has them."""
    source: str = ""
    """File that it was read from."""

    def refuse(self, what: str, remedy: str) -> DataError:
        """Return the error that these readings make no such study."""
        return DataError(f"axis {self.axis}: {what}", where=self.source, remedy=remedy)


def numbered(labels: Sequence[str]) -> tuple[tuple[str, ...], IntArray]:
    """Return the labels in order of first appearance, and the number of each reading's."""
    names = tuple(dict.fromkeys(labels))
    at = {name: k for k, name in enumerate(names)}
    return names, np.array([at[label] for label in labels], dtype=np.int64)
