"""Which rests are visits, of which pose, and which are doubtful: none is dropped in silence."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError
from scara_iso.run import FloatArray
from scara_iso.signals.rests import Doubt, Motion, Rest, find_rests, middle

_LONG = 2.0
"""Times the usual duration of a visit from which on two may have become one."""


class Samples(NamedTuple):
    """Samples in time: axes of shape (n,), of which ``lengths`` tell rest from motion."""

    time: FloatArray
    axes: dict[str, FloatArray]
    lengths: list[FloatArray]
    unit: str
    """Of the lengths: mm, or deg where there are angles only."""
    pose: npt.NDArray[np.str_] | None = None
    source: str = ""

    def at(self, sample: int) -> float:
        """Return the time of a sample."""
        return float(self.time[sample])

    def lasts(self, rest: Rest | Stay) -> float:
        """Return the duration of a rest [s]."""
        return self.at(rest.last) - self.at(rest.first)

    def doubt(self, code: str, rest: Rest | Stay, message: str, *, counted: bool = False) -> Doubt:
        """Return a doubt about a rest."""
        return Doubt(code, self.at(rest.first), self.at(rest.last), message, counted)

    def levels(self, rest: Rest) -> FloatArray:
        """Return the mean of each length in the middle half of a rest, shape (lengths,)."""
        begin, end = middle(rest.first, rest.last)
        return np.array([values[begin : end + 1].mean() for values in self.lengths])


class Stay(NamedTuple):
    """A visit's rests, of which there are several where it was interrupted."""

    rests: tuple[Rest, ...]

    @property
    def first(self) -> int:
        """Return the first sample."""
        return self.rests[0].first

    @property
    def last(self) -> int:
        """Return the last sample."""
        return self.rests[-1].last


def join(stream: Samples, rests: Sequence[Rest], shortest: float, still: float) -> list[Stay]:
    """Return the rests, those joined that a short interruption parts at one level."""
    stays: list[Stay] = []
    for rest in rests:
        before = stays[-1].rests[-1] if stays else None
        if (
            before is not None
            and stream.at(rest.first) - stream.at(before.last) < shortest
            and np.abs(stream.levels(rest) - stream.levels(before)).max() <= still
        ):
            stays[-1] = Stay((*stays[-1].rests, rest))
        else:
            stays.append(Stay((rest,)))
    return stays


def sort(
    stream: Samples, stays: Sequence[Stay], dwell: float, still: float
) -> tuple[list[Stay], list[Doubt], int]:
    """Return the visits, the doubts about them and about the others, and how many pauses.

    A pause is a rest shorter than half of ``dwell``: that is only counted.
    """
    kept: list[Stay] = []
    doubts: list[Doubt] = []
    pauses = 0
    for stay in stays:
        if stream.lasts(stay) < dwell / 2:
            pauses += 1
        elif reason := _no_visit(stream, stay, dwell, still):
            code, why = reason
            doubts.append(stream.doubt(code, stay, f"{why}: not a visit"))
        else:
            kept.append(stay)
            gaps = (Rest(one.last, other.first) for one, other in pairwise(stay.rests))
            doubts += [stream.doubt("interrupted", gap, _GOES_ON, counted=True) for gap in gaps]
    return kept, doubts, pauses


_GOES_ON = "a rest is interrupted and continues at the same level: one visit, without this stretch"


def _no_visit(stream: Samples, stay: Stay, dwell: float, still: float) -> tuple[str, str] | None:
    lasts = stream.lasts(stay)
    if stay.first == 0:
        return "begins-at-rest", "the stream begins at rest, no arrival was seen"
    if lasts < dwell:
        return "short-rest", f"a rest of {lasts:.3g} s, shorter than the dwell"
    for rest in stay.rests:
        half = (rest.first + rest.last + 1) // 2
        for values in stream.lengths:
            moved = abs(values[half : rest.last + 1].mean() - values[rest.first : half].mean())
            if moved > still:
                return "creeps", f"creeps by {moved:.3g} {stream.unit} from half to half"
    return None


def long_rests(stream: Samples, kept: Sequence[Stay]) -> Iterator[Doubt]:
    """Yield a doubt for each visit that lasts so long that two may have become one."""
    usual = float(np.median([stream.lasts(stay) for stay in kept])) if kept else 0.0
    for stay in kept:
        if (long := stream.lasts(stay)) > _LONG * usual:
            message = (
                f"a rest of {long:.3g} s where others last {usual:.3g} s: is a visit missing in it?"
            )
            yield stream.doubt("long-rest", stay, message, counted=True)


def of_other_thresholds(
    stream: Samples, found: Motion, kept: Sequence[Stay], dwell: float, still: float
) -> Iterator[Doubt]:
    """Yield the visits that come or go where the threshold is halved or doubled."""
    for factor, said in ((0.5, "half"), (2.0, "double")):
        rests = join(stream, find_rests(found, factor * still), dwell / 2, factor * still)
        others = [r for r in rests if r.first > 0 and stream.lasts(r) >= dwell]
        for stay in _alone(kept, others):
            message = f"a visit only above {factor:g} times the threshold"
            yield stream.doubt("threshold", stay, message, counted=True)
        for stay in _alone(others, kept):
            yield stream.doubt("threshold", stay, f"would be a visit at {said} the threshold")


def _alone(stays: Sequence[Stay], others: Sequence[Stay]) -> list[Stay]:
    """Return the stays during which there is none of the others."""
    ends = np.array([other.last for other in others])
    begins = np.array([other.first for other in others])
    behind = np.searchsorted(ends, [stay.first for stay in stays])
    return [
        stay
        for stay, k in zip(stays, behind.tolist(), strict=True)
        if k == len(begins) or begins[k] > stay.last
    ]


AWAY = "-"
"""Stands in the order of poses for a rest at which no pose is."""
_FARTHEST = 5.0
"""Times the spread of a level that an empty stretch between two is wide, as among readings."""
_FEWEST = 4
_SHOWN = 6


def label(
    stream: Samples, rests: Sequence[Stay], order: Sequence[str], still: float, begun: Stay | None
) -> tuple[list[Stay], list[str | None], list[str]]:
    """Return the rests that are visits, their poses, and what was noted.

    ``begun`` is the rest with which the stream begins: no visit, it takes no name. Raises
    `DataError` where levels clearly differ and nothing says which pose is which, or where
    the rests do not follow ``order``.
    """
    if stream.pose is not None and not order:
        return list(rests), [_pose_at(stream.pose, stream, rest) for rest in rests], []
    levels = np.array([stream.levels(rest.rests[-1]) for rest in rests])
    if not order:
        _refuse_levels(stream, levels, still)
        return list(rests), [None] * len(rests), []
    notes = _check_turns(stream, rests, levels, order, still)
    if begun is not None and len(order) > 1:
        _refuse_begun(stream, begun, levels, order, still)
        first = f"{order[0]} is the rest at {stream.at(rests[0].first):.3f} s"
        notes.append(f"the stream begins at rest, which takes no name: {first}")
    turns = [order[k % len(order)] for k in range(len(rests))]
    kept = [rest for rest, name in zip(rests, turns, strict=True) if name != AWAY]
    labels = [name for name in turns if name != AWAY]
    if not kept:
        raise DataError(
            f"none of the {len(rests)} rests is a pose by {','.join(order)}",
            where=stream.source,
            remedy=f"name the poses in their order, {AWAY} for another rest: `poses=P1,-`",
        )
    over = len(rests) % len(order)
    notes += [f"the last turn has {over} of {len(order)} rests"] if over else []
    away = len(rests) - len(kept)
    notes += [f"{away} rests are not poses, as stated"] if away else []
    return kept, list(labels), notes


def _refuse_begun(
    stream: Samples, begun: Stay, levels: FloatArray, order: Sequence[str], still: float
) -> None:
    """Refuse a stream that begins at rest at a pose of a tour, which may be meant to count."""
    apart = np.abs(levels[: len(order)] - stream.levels(begun.rests[-1])).max(axis=1)
    near = int(apart.argmin())
    if AWAY not in order and apart[near] <= _FARTHEST * still:
        raise DataError(
            f"the stream begins at rest at the level of {order[near]}: no arrival was seen there, "
            "and whether it is the first of the poses is not known",
            where=stream.source,
            remedy="cut off this rest, and name the poses from the first one that is arrived at",
        )


def _pose_at(pose: npt.NDArray[np.str_], stream: Samples, rest: Stay) -> str:
    begin, end = middle(rest.first, rest.last)
    labels = sorted(set(pose[begin : end + 1].tolist()))
    if len(labels) != 1:
        raise DataError(
            f"the pose changes in the rest at {stream.at(rest.first):.3f} s: {', '.join(labels)}",
            where=stream.source,
            remedy="say the order of the visits in place of the column: `poses=P1,P2`",
        )
    return str(labels[0])


def _refuse_levels(stream: Samples, levels: FloatArray, still: float) -> None:
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
            named = ", ".join(f"{middle:.6g}" for middle in middles[:_SHOWN])
            raise DataError(
                f"the {len(ordered)} rests are at {len(middles)} levels, about {named} "
                f"{stream.unit}: poses, or rests away from the dial?",
                where=stream.source,
                remedy=f"say `poses=P1,P2` in the order of the visits, {AWAY} for a rest that is "
                "not a pose (`poses=P1,-`), or `poses=P1` if it is one",
            )


def _check_turns(
    stream: Samples, rests: Sequence[Stay], levels: FloatArray, order: Sequence[str], still: float
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
                where=stream.source,
                remedy="look at the stream there; correct `poses=`, or cut the stream in two",
            )
    return [
        f"{order[i]} and {order[j]} rest at one level: their order cannot be checked"
        for i in range(len(first))
        for j in range(i)
        if np.abs(first[i] - first[j]).max() <= _FARTHEST * still
    ]
