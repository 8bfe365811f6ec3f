"""Which visit is of which pose: in turn as the user says, or by the stream's own pose column."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from scara_iso.errors import DataError
from scara_iso.run import FloatArray, Run
from scara_iso.streams.arrival import middle
from scara_iso.streams.doubts import Samples, Stay

AWAY = "-"
"""Stands in the order of poses for a rest at which no pose is."""
_FARTHEST = 5.0
"""Times the spread of a level that an empty stretch between two is wide, as among readings."""
_FEWEST = 4
_SHOWN = 6


def label(
    run: Run, stream: Samples, rests: Sequence[Stay], order: Sequence[str], still: float
) -> tuple[list[Stay], list[str | None], list[str]]:
    """Return the rests that are visits, their poses, and what was noted.

    Raises `DataError` where levels clearly differ and nothing says which pose is which, or where
    the rests do not follow ``order``.
    """
    if run.pose is not None and not order:
        return list(rests), [_pose_at(run, stream, rest) for rest in rests], []
    levels = np.array([stream.levels(rest.rests[-1]) for rest in rests])
    if not order:
        _refuse_levels(run, stream, levels, still)
        return list(rests), [None] * len(rests), []
    notes = _check_turns(run, stream, rests, levels, order, still)
    turns = [order[k % len(order)] for k in range(len(rests))]
    kept = [rest for rest, name in zip(rests, turns, strict=True) if name != AWAY]
    labels = [name for name in turns if name != AWAY]
    if not kept:
        raise DataError(
            f"none of the {len(rests)} rests is a pose by {','.join(order)}",
            where=run.origin.source,
            remedy=f"name the poses in their order, {AWAY} for a rest that is none: `poses=P1,-`",
        )
    over = len(rests) % len(order)
    notes += [f"the last turn has {over} of {len(order)} rests"] if over else []
    away = len(rests) - len(kept)
    notes += [f"{away} rests are no pose, as stated"] if away else []
    return kept, list(labels), notes


def _pose_at(run: Run, stream: Samples, rest: Stay) -> str:
    assert run.pose is not None  # noqa: S101 - the caller looked
    begin, end = middle(rest.first, rest.last)
    labels = sorted(set(run.pose[begin : end + 1].tolist()))
    if len(labels) != 1:
        raise DataError(
            f"the pose changes in the rest at {stream.at(rest.first):.3f} s: {', '.join(labels)}",
            where=run.origin.source,
            remedy="say the order of the visits in place of the column: `poses=P1,P2`",
        )
    return str(labels[0])


def _refuse_levels(run: Run, stream: Samples, levels: FloatArray, still: float) -> None:
    """Refuse rests on levels that are far apart against ``still`` and against their own spread.

    Of four rests or more a level of a single one is a reading that is off, and no pose.
    """
    for values in levels.T:
        ordered = np.sort(values)
        cuts = np.flatnonzero(np.diff(ordered) > _FARTHEST * still) + 1
        parts = [p for p in np.split(ordered, cuts) if len(p) > 1 or len(ordered) < _FEWEST]
        if len(parts) < 2:
            continue
        between = min(b[0] - a[-1] for a, b in pairwise(parts))
        if between > _FARTHEST * float(np.median([np.ptp(part) for part in parts])):
            middles = [float(np.median(part)) for part in parts]
            raise _several_levels(run, stream, len(ordered), middles)


def _several_levels(run: Run, stream: Samples, rests: int, middles: Sequence[float]) -> DataError:
    named = ", ".join(f"{middle:.6g}" for middle in middles[:_SHOWN])
    return DataError(
        f"the {rests} rests are at {len(middles)} levels, about {named} {stream.unit}: "
        "poses, or rests away from the dial?",
        where=run.origin.source,
        remedy=f"say `poses=P1,P2` in the order of the visits, {AWAY} for a rest that is no pose "
        "(`poses=P1,-`), or `poses=P1` if it is one",
    )


def _check_turns(
    run: Run,
    stream: Samples,
    rests: Sequence[Stay],
    levels: FloatArray,
    order: Sequence[str],
    still: float,
) -> list[str]:
    """Refuse rests that are nearer to another place of the order than to their own.

    A place is where it was in the first turn, and where it is in most. Returns which places cannot
    be told apart by their levels.
    """
    first = levels[: len(order)]
    place = np.arange(len(levels)) % len(order)
    usual = np.array([np.median(levels[place == k], axis=0) for k in range(len(first))])
    for places in (first, usual):
        apart = np.abs(levels[:, None, :] - places[None, :, :]).max(axis=2)
        own = apart[np.arange(len(levels)), place]
        wrong = np.flatnonzero((own > _FARTHEST * still) & (2 * apart.min(axis=1) < own))
        if len(wrong):
            k = int(wrong[0])
            raise DataError(
                f"rest {k + 1} at {stream.at(rests[k].first):.3f} s should be {order[place[k]]} "
                f"and is at the level of {order[int(apart[k].argmin())]}: a rest is missing before "
                "it, or the order is another",
                where=run.origin.source,
                remedy="look at the stream there; correct `poses=`, or cut the stream in two",
            )
    return [
        f"{order[i]} and {order[j]} rest at one level: their order cannot be checked"
        for i in range(len(first))
        for j in range(i)
        if np.abs(first[i] - first[j]).max() <= _FARTHEST * still
    ]
