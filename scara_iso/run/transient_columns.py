"""Columns of a table made of a stream that tell how an arrival ended, and cause nothing."""

from __future__ import annotations

import re

from scara_iso.base.quantities import Dimension

_KNOWN = re.compile(r"stabilisation_\w+_s|overshoot_\w+_(mm|deg)")


def stabilisation_column(axis: str) -> str:
    """Return the name of the column that holds the stabilisation times of an axis [s]."""
    return f"stabilisation_{axis}_s"


def overshoot_column(axis: str, dimension: Dimension) -> str:
    """Return the name of the column that holds the overshoots of an axis [mm or deg]."""
    return f"overshoot_{axis}_{dimension.value}"


def is_transient(name: str) -> bool:
    """Return whether a column is a figure of the arrivals: no condition, and so no cause."""
    return _KNOWN.fullmatch(name) is not None
