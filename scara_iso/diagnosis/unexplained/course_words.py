"""A course of no name, in words: ``rises in the first 8 cycles, then falls``."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from scara_iso.run import FloatArray, IntArray

_TURN = 0.2
"""A turn is worth a word from this share of the course's range."""
_LEVEL, _LONG = 0.1, 0.2
"""The first or last tenth of a rise that takes this share of the cycles is no rise yet."""
_MOST_PARTS = 5
_STAYS = "stays level"
_DUST = 1e-300


def in_words(smooth: FloatArray, cycle: IntArray) -> str:
    """Return what a smooth course (n,) does over the cycles (n,), empty where it does nothing."""
    if not np.ptp(smooth):
        return ""
    parts = [part for a, b in pairwise(_turns(smooth)) for part in _parts(smooth, a, b)]
    if len(parts) > _MOST_PARTS:
        swings = sum(verb != _STAYS for verb, _ in parts)
        return f"goes up and down, {swings} times in {len(smooth)} cycles"
    return _said(_merged(parts), cycle)


def levels_in_words(y: FloatArray, behind: FloatArray, cycle: IntArray) -> str:
    """Return between which levels residuals y (n,) change, empty where they do not.

    ``behind`` (n, changes) are 1 from each change on. Every change is an estimated number and a
    chosen cycle, and is worth it by BIC.
    """
    n, changes = behind.shape
    columns = np.column_stack([np.ones(n), behind])
    steps = np.linalg.lstsq(columns, y, rcond=None)[0]
    left = float(((y - columns @ steps) ** 2).sum())
    if not changes or n * np.log(n * y.var() / max(left, _DUST)) <= 2 * changes * np.log(n):
        return ""
    first = cycle[behind.argmax(axis=0)]
    said = [f"{step:+.2g} from cycle {k} on" for step, k in zip(steps[1:], first, strict=True)]
    return f"has {changes + 1} levels: {', '.join(said)}"


def _turns(smooth: FloatArray) -> list[int]:
    """Return both ends, and the rows between at which the course turns by a share of its range."""
    least = _TURN * np.ptp(smooth)
    turns, farthest, direction = [0], 0, 0.0
    for i in range(1, len(smooth)):
        beyond = smooth[i] - smooth[farthest]
        if direction * beyond > 0:
            farthest = i
        elif abs(beyond) >= least:
            turns += [farthest] if direction else []
            direction, farthest = np.sign(beyond), i
    return [*turns, len(smooth) - 1]


def _parts(smooth: FloatArray, first: int, last: int) -> list[tuple[str, int]]:
    """Return what the course does between two turns, and the row up to which."""
    change = smooth[last] - smooth[first]
    if abs(change) < _TURN * np.ptp(smooth):
        return [(_STAYS, last)]
    share = (smooth[first : last + 1] - smooth[first]) / change
    begins = first + int(np.flatnonzero(share >= _LEVEL)[0])
    ends = first + int(np.flatnonzero(share <= 1 - _LEVEL)[-1]) + 1
    long = _LONG * len(smooth)
    before = [(_STAYS, begins)] if begins - first >= long else []
    after = [(_STAYS, last)] if last - ends >= long else []
    return [*before, ("rises" if change > 0 else "falls", ends if after else last), *after]


def _merged(parts: list[tuple[str, int]]) -> list[tuple[str, int]]:
    """Return the parts with neighbours that do the same as one."""
    return [
        part
        for part, following in zip(parts, [*parts[1:], ("", 0)], strict=True)
        if part[0] != following[0]
    ]


def _said(parts: list[tuple[str, int]], cycle: IntArray) -> str:
    (verb, last), *others = parts
    if not others:
        return f"{verb} all the time"
    said = [f"{verb} in the first {last + 1} cycles"]
    said += [f"{verb} until cycle {cycle[row]}" for verb, row in others[:-1]]
    return f"{', '.join(said)}, then {others[-1][0]}"
