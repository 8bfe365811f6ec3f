"""Sizes that a public function takes for all figures at once, or by figure."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Real
from typing import TypeVar

from scara_iso.base.errors import UsageError
from scara_iso.iso9283 import EVERY_LENGTH, Limit

Size = TypeVar("Size", bound=Limit)


def sizes_of(
    name: str, given: float | Mapping[str, Size] | None, *, pairs: bool = False
) -> dict[str, Size | float]:
    """Return the sizes by figure or axis; a single number stands under the empty name, for all.

    ``name`` is the keyword's; with ``pairs`` a size may be the smallest and the largest. Raises
    `UsageError` for what is neither number nor mapping.
    """
    found: dict[str, Size | float] = {}
    if given is not None:
        found.update(given if isinstance(given, Mapping) else {EVERY_LENGTH: given})
    for figure, size in found.items():
        ends = size if pairs and isinstance(size, tuple) and len(size) == 2 else (size,)
        if not isinstance(figure, str) or not all(map(_is_number, ends)):
            raise UsageError(
                f"{name}={given!r} is no size",
                remedy=f'write {name}=0.02, or {name}={{"X": 0.02}} for one of them',
            )
    return found


def _is_number(size: object) -> bool:
    return isinstance(size, Real) and not isinstance(size, bool)
