"""What the user states of an indicator in numbers: its uncertainty and the command pose.

The recorder's table is in mm and degrees, and so are these; each becomes part of its axis.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from scara_iso.errors import DataError
from scara_iso.quantities import Dimension

_KEY = re.compile(r"indicator_uncertainty(_(x|y|z|theta))?|command_(x|y|z|theta)")
_NUMBER = re.compile(r"[+-]?[0-9]{1,6}(\.[0-9]{1,12})?")


def wrong_sizes(metadata: Mapping[str, str]) -> list[str]:
    """Return the keys whose size is not a plain number, or whose uncertainty is not positive."""
    stated = {key: str(text) for key, text in metadata.items() if _KEY.fullmatch(_normal(key))}
    return [
        key
        for key, text in stated.items()
        if not _NUMBER.fullmatch(text)
        or (_normal(key).startswith("indicator") and not float(text) > 0)
    ]


def sizes_of_axis(
    metadata: Mapping[str, str], axis: str, dimension: Dimension
) -> tuple[float | None, float | None]:
    """Return standard uncertainty and command pose of an axis [mm or deg], None where not stated.

    ``indicator_uncertainty`` without an axis is a length: that of every axis read in mm.
    """
    if wrong := wrong_sizes(metadata):
        raise DataError(f"{wrong[0]}: not a plain number")
    stated = {
        _normal(key): float(text) for key, text in metadata.items() if _KEY.fullmatch(_normal(key))
    }
    general = stated.get("indicator_uncertainty") if dimension is Dimension.LENGTH else None
    name = axis.lower()
    return stated.get(f"indicator_uncertainty_{name}", general), stated.get(f"command_{name}")


def _normal(key: str) -> str:
    return key.lower().replace(" ", "_").replace("-", "_")
