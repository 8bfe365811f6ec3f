"""Readings of one axis, as a raw file gives them line by line."""

from __future__ import annotations

import math
from array import array
from collections import deque
from collections.abc import Mapping
from decimal import Decimal
from typing import TypeAlias

import numpy as np

from scara_iso.acquisition.recorder.sizes import sizes_of_axis
from scara_iso.quantities import Dimension, find_unit, parse_number
from scara_iso.run import Axis, IntArray

ShownReading: TypeAlias = tuple[float, str, str]
"""A stored reading: in mm or degrees, and as the indicator showed it with its unit."""
VOIDABLE = 100
"""How many readings back an operator may void."""


class AxisReadings:
    """Readings of one axis by visit [mm or deg], in the memory of one number each."""

    def __init__(self) -> None:
        self.values = array("d")
        self.dimension: Dimension | None = None
        self.unit: str | None = None
        """What the indicator showed last."""
        self.shown: deque[tuple[int, str]] = deque(maxlen=VOIDABLE)
        self.resolution = 0.0
        """The coarsest that was sent: never states more than every reading holds."""

    def put(self, visit: int, text: str, unit: str) -> None:
        """Take a reading; `ValueError` says what is wrong with it."""
        size = find_unit(unit)
        if size is None:
            raise ValueError(f"unknown unit {unit!r}")
        if self.dimension not in (None, size.dimension):
            raise ValueError(f"{unit} after {self.dimension.value}")
        if parse_number(text) is None:
            raise ValueError(f"{text[:40]!r} is no reading")
        grow(self.values, visit)
        if not math.isnan(self.values[visit - 1]):
            raise ValueError("stored twice")
        self.values[visit - 1] = size.read(text)
        count = float(Decimal(1).scaleb(-len(text.partition(".")[2])))
        self.resolution = max(self.resolution, size.to_base(count))
        self.dimension, self.unit = size.dimension, unit
        self.shown.append((visit, text))

    def void(self, visit: int) -> None:
        """Strike out the reading of a visit."""
        if visit <= len(self.values):
            self.values[visit - 1] = math.nan
            self.shown = deque((one for one in self.shown if one[0] != visit), maxlen=VOIDABLE)

    def text(self, visit: int) -> str:
        """Return the latest readings' text, and nothing for one that is too old to be struck."""
        return dict(self.shown).get(visit, "")

    def axis(self, name: str, rows: IntArray, metadata: Mapping[str, str]) -> Axis:
        """Return the readings in ``rows``, with what ``metadata`` states of the axis."""
        dimension = self.dimension or Dimension.LENGTH
        sizes = sizes_of_axis(metadata, name, dimension)
        return Axis(name, np.array(self.values)[rows], dimension, self.resolution or None, *sizes)

    def by_visit(self) -> dict[int, ShownReading]:
        """Return the readings by visit, the latest as they were shown, others in mm or degrees."""
        texts, unit = dict(self.shown), self.unit or ""
        base = self.dimension.value if self.dimension else ""
        return {
            visit: (value, texts[visit], unit) if visit in texts else (value, f"{value:g}", base)
            for visit, value in enumerate(self.values, start=1)
            if not math.isnan(value)
        }

    def __contains__(self, visit: int) -> bool:
        return visit <= len(self.values) and not math.isnan(self.values[visit - 1])


def grow(values: array[float], size: int) -> None:
    """Make room for ``size`` numbers; what is not there yet is NaN."""
    values.extend([math.nan] * (size - len(values)))
