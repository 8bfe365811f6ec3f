"""Headings that name a pose and an axis in one cell: ``P1 X [mm]``, ``X P2``."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from scara_iso.tables.blocks import Block, Line
from scara_iso.tables.layout import HEAD
from scara_iso.tables.names import LONGEST_NAME, Kind, clean, read_name

_POSE = r"(?:p|pose|point|punkt)[ _.-]?0*([1-9][0-9]{0,2})"
_BEFORE = re.compile(rf"{_POSE}[ _:.-]+(\S.*)", re.IGNORECASE)
_BEHIND = re.compile(rf"(\S.*?)[ _:.-]+{_POSE}( ?[\[(/,].*)?", re.IGNORECASE)


def find_wide(rows: Sequence[Line]) -> list[Block]:
    """Return a block for each pose of the first row that heads the axes of two poses or more.

    Other poses' cells are empty there, so lines and columns of a fault are those of the file.
    """
    for k, (_, cells) in enumerate(rows[:HEAD]):
        named = {j: found for j, cell in enumerate(cells) if (found := _pose_and_name(cell))}
        axes = {pose for pose, name in named.values() if read_name(name).kind is Kind.AXIS}
        if len(axes) > 1:
            poses = dict.fromkeys(pose for pose, _ in named.values())
            return [
                Block(pose, [*rows[:k], *_of(pose, rows[k:], named)], "its columns' headings")
                for pose in poses
            ]
    return []


def _pose_and_name(cell: object) -> tuple[str, str] | None:
    """Return the pose that a heading names, and the heading without it."""
    text = clean(cell) if isinstance(cell, str) and len(cell) <= LONGEST_NAME else ""
    if found := _BEFORE.fullmatch(text):
        return f"P{found[1]}", found[2]
    found = _BEHIND.fullmatch(text)
    return (f"P{found[2]}", f"{found[1]}{found[3] or ''}") if found else None


def _of(pose: str, rows: Sequence[Line], named: Mapping[int, tuple[str, str]]) -> Iterator[Line]:
    """Yield the header and the rows below it with the columns of one pose."""
    others = {j for j, (of, _) in named.items() if of != pose}
    for k, (line, cells) in enumerate(rows):
        kept = ["" if j in others else cell for j, cell in enumerate(cells)]
        if k == 0:
            kept = [named[j][1] if j in named and cell else cell for j, cell in enumerate(kept)]
        yield line, kept
