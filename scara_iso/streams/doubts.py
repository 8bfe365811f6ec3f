"""Which rests are visits, and what is said of the doubtful ones: none is dropped in silence."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from scara_iso.run import FloatArray
from scara_iso.streams.arrival import middle
from scara_iso.streams.rests import Motion, Rest, find_rests
from scara_iso.streams.result import Doubt

_LONG = 2.0
"""Times the usual duration of a visit from which on two may have become one."""


@dataclass(frozen=True, eq=False, slots=True)
class Samples:
    """Samples in time: axes of shape (n,), of which ``lengths`` tell rest from motion."""

    time: FloatArray
    axes: dict[str, FloatArray]
    lengths: list[FloatArray]
    unit: str
    """Of the lengths: mm, or deg where there are angles only."""

    def at(self, sample: int) -> float:
        """Return the time of a sample."""
        return float(self.time[sample])

    def lasts(self, rest: Rest) -> float:
        """Return the duration of a rest [s]."""
        return self.at(rest.last) - self.at(rest.first)

    def levels(self, rest: Rest) -> FloatArray:
        """Return the mean of each length in the middle half of a rest, shape (lengths,)."""
        begin, end = middle(rest.first, rest.last)
        return np.array([values[begin : end + 1].mean() for values in self.lengths])


@dataclass(frozen=True, slots=True)
class Stay:
    """A visit's rests, of which there are several where it was interrupted."""

    rests: tuple[Rest, ...]

    @property
    def first(self) -> int:
        """First sample."""
        return self.rests[0].first

    @property
    def last(self) -> int:
        """Last sample."""
        return self.rests[-1].last


def join(stream: Samples, rests: Sequence[Rest], shortest: float, still: float) -> list[Stay]:
    """Return the rests, those joined that a short interruption parts at one level."""
    stays: list[Stay] = []
    for rest in rests:
        before = stays[-1].rests[-1] if stays else None
        if before is not None and stream.at(rest.first) - stream.at(before.last) < shortest:
            apart = np.abs(stream.levels(rest) - stream.levels(before)).max()
            if apart <= still:
                stays[-1] = Stay((*stays[-1].rests, rest))
                continue
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
        start, end = stream.at(stay.first), stream.at(stay.last)
        lasts = end - start
        reason = _no_visit(stream, stay, dwell, still)
        if lasts < dwell / 2:
            pauses += 1
        elif reason:
            doubts.append(Doubt(reason[0], start, end, reason[1], counted=False))
        else:
            kept.append(stay)
            doubts += _interruptions(stream, stay)
    return kept, doubts, pauses


def _no_visit(stream: Samples, stay: Stay, dwell: float, still: float) -> tuple[str, str] | None:
    lasts = stream.at(stay.last) - stream.at(stay.first)
    if stay.first == 0:
        return "begins-at-rest", "the stream begins at rest: no arrival was seen, no visit"
    if lasts < dwell:
        return "short-rest", f"a rest of {lasts:.3g} s, shorter than the dwell: no visit"
    for rest in stay.rests:
        half = (rest.first + rest.last + 1) // 2
        for values in stream.lengths:
            moved = abs(values[half : rest.last + 1].mean() - values[rest.first : half].mean())
            if moved > still:
                return "creeps", f"creeps by {moved:.3g} {stream.unit} from half to half: no visit"
    return None


def _interruptions(stream: Samples, stay: Stay) -> Iterator[Doubt]:
    for before, after in zip(stay.rests, stay.rests[1:], strict=False):
        yield Doubt(
            "interrupted",
            stream.at(before.last),
            stream.at(after.first),
            "a rest is interrupted and goes on at the same level: one visit, without this stretch",
            counted=True,
        )


def long_rests(stream: Samples, kept: Sequence[Stay]) -> list[Doubt]:
    """Return a doubt for each visit that lasts so long that two may have become one."""
    lasts = [stream.at(stay.last) - stream.at(stay.first) for stay in kept]
    usual = float(np.median(lasts)) if lasts else 0.0
    return [
        Doubt(
            "long-rest",
            stream.at(stay.first),
            stream.at(stay.last),
            f"a rest of {long:.3g} s where others last {usual:.3g} s: is a visit missing in it?",
            counted=True,
        )
        for stay, long in zip(kept, lasts, strict=True)
        if long > _LONG * usual
    ]


def of_other_thresholds(
    stream: Samples, found: Motion, kept: Sequence[Stay], dwell: float, still: float
) -> Iterator[Doubt]:
    """Yield the visits that come or go where the threshold is halved or doubled."""
    for factor, said in ((0.5, "half"), (2.0, "double")):
        rests = join(stream, find_rests(found, factor * still), dwell / 2, factor * still)
        others = [r for r in rests if r.first > 0 and _lasts(stream, r) >= dwell]
        for stay in _alone(kept, others):
            message = f"a visit only above {factor:g} times the threshold"
            yield _threshold_doubt(stream, stay, message, counted=True)
        for stay in _alone(others, kept):
            message = f"would be a visit at {said} the threshold"
            yield _threshold_doubt(stream, stay, message, counted=False)


def _threshold_doubt(stream: Samples, stay: Stay, message: str, *, counted: bool) -> Doubt:
    return Doubt("threshold", stream.at(stay.first), stream.at(stay.last), message, counted)


def _lasts(stream: Samples, stay: Stay) -> float:
    return stream.at(stay.last) - stream.at(stay.first)


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
