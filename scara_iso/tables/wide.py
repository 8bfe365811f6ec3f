"""Tables whose headings name a pose and an axis in one cell: ``P1 X [mm]``, ``X P2``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from scara_iso.tables.blocks import Block, Line, check_beside
from scara_iso.tables.layout import HEAD, names_an_axis
from scara_iso.tables.names import Kind, read_name
from scara_iso.tables.pose_names import pose_and_name


def find_wide(rows: Sequence[Line], where: str) -> list[Block]:
    """Return a block for each pose of the first row that heads the axes of two poses or more.

    Other poses' cells are empty there, so lines and columns of a fault are those of the file. There
    is none where a row names an axis of no pose: that is the header. Raises `DataError` for more
    than `BESIDE`.
    """
    head = [
        [cell if isinstance(cell, str) else repr(cell) for cell in cells]
        for _, cells in rows[:HEAD]
    ]
    if any(map(names_an_axis, head)):
        return []
    for k, texts in enumerate(head):
        named = {j: found for j, text in enumerate(texts) if (found := pose_and_name(text))}
        axes = {pose for pose, name in named.values() if read_name(name).kind is Kind.AXIS}
        if len(axes) > 1:
            poses = dict.fromkeys(pose for pose, _ in named.values())
            check_beside(len(poses), rows[k][0], where)
            return [
                Block(pose, [*rows[:k], *_of(pose, rows[k:], named)], "the heading of its columns")
                for pose in poses
            ]
    return []


def _of(pose: str, rows: Sequence[Line], named: Mapping[int, tuple[str, str]]) -> Iterator[Line]:
    """Yield the header and the rows below it with the columns of one pose."""
    others = {j for j, (of, _) in named.items() if of != pose}
    for k, (line, cells) in enumerate(rows):
        kept = ["" if j in others else cell for j, cell in enumerate(cells)]
        if k == 0:
            kept = [named[j][1] if j in named and cell else cell for j, cell in enumerate(kept)]
        yield line, kept
