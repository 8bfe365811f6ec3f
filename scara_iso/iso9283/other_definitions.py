"""The other words that makers use for repeatability, from the same readings.

A catalogue's figure is compared with the same word's figure, like with like.
"""

from __future__ import annotations

import numpy as np

from scara_iso.iso9283.figures import Definition
from scara_iso.iso9283.statistics import standard_deviation
from scara_iso.run import FloatArray

_VISITS = 7


def definitions(readings: FloatArray, approach: FloatArray | None) -> tuple[Definition, ...]:
    """Return half range, 2 s, 3 s and, where both approaches are there, ISO 230-2's R.

    ``readings`` of one axis, shape (n,); ``approach`` +1 or -1 for each, or None. All values are
    in the unit of the readings.
    """
    s = float(standard_deviation(readings))
    visits = readings[:_VISITS]
    found = [
        Definition("half range", float(np.ptp(readings)) / 2, f"± of all {len(readings)} readings"),
        Definition(
            f"half range of {_VISITS}", float(np.ptp(visits)) / 2, "± of the first seven visits"
        ),
        Definition("2 s", 2 * s, "± two sample standard deviations"),
        Definition("3 s", 3 * s, "± three sample standard deviations"),
    ]
    if approach is not None:
        found += _iso_230_2(readings, approach)
    return tuple(found)


def _iso_230_2(readings: FloatArray, approach: FloatArray) -> list[Definition]:
    """ISO 230-2: R = max(2 S_up + 2 S_down + |B|, 4 S_up, 4 S_down), B the reversal value."""
    up, down = readings[approach > 0], readings[approach < 0]
    if min(len(up), len(down)) < 2:
        return []
    S_up, S_down = float(standard_deviation(up)), float(standard_deviation(down))
    B = float(up.mean() - down.mean())
    R = max(2 * S_up + 2 * S_down + abs(B), 4 * S_up, 4 * S_down)
    return [
        Definition("R up", 4 * S_up, "ISO 230-2, unidirectional, approach +1"),
        Definition("R down", 4 * S_down, "ISO 230-2, unidirectional, approach -1"),
        Definition("B", B, "ISO 230-2, reversal: mean of +1 minus mean of -1"),
        Definition("R", R, "ISO 230-2, bidirectional"),
    ]
