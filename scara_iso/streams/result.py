"""What is found in a stream: visits, what is doubtful, and the parameters of the rule."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, TypeAlias

from scara_iso.display import Displayed
from scara_iso.iso9283 import Characteristic
from scara_iso.published import Count, Size
from scara_iso.run import AxisKey, Run

if TYPE_CHECKING:
    import pandas as pd

DOUBTS = (
    "begins-at-rest",
    "short-rest",
    "creeps",
    "interrupted",
    "long-rest",
    "threshold",
    "missing-samples",
    "does-not-settle",
)
Seconds: TypeAlias = Annotated[float, ("unit", "s")]
Duration: TypeAlias = Annotated[float, ("unit", "s"), ("minimum", 0)]
SizeByAxis: TypeAlias = Mapping[AxisKey, Size]


@dataclass(frozen=True, slots=True)
class Visit:
    """One stay at a pose; times in s of the stream, lengths in mm, angles in degrees."""

    start: Seconds
    """First sample at rest."""
    settled: Seconds
    """From here on every axis keeps the limit band."""
    end: Seconds
    """Last sample at rest."""
    averaged: tuple[Seconds, Seconds]
    """First and last sample of the reading."""
    samples: Count
    """Of the mean."""
    mean: Mapping[AxisKey, float]
    """By axis, over `averaged`: the reading."""
    scatter: SizeByAxis
    """Their standard deviation, by axis."""
    approach: Mapping[AxisKey, Annotated[int, ("enum", (-1, 0, 1))]]
    """By axis: +1 where the reading rose to the pose, -1 where it fell, 0 where it hardly moved."""
    stabilisation_s: Mapping[AxisKey, Duration | None]
    """By axis; null where it cannot be told."""
    overshoot: Mapping[AxisKey, Size | None]
    """By axis; null, as `stabilisation_s`, where it hardly moved or the stream is too slow."""
    pose: str | None
    """Label; null where the stream has one pose."""


@dataclass(frozen=True, slots=True)
class Doubt:
    """A stretch of the stream that is not plainly a visit, or a visit that is not plainly one."""

    code: Annotated[str, ("enum", DOUBTS)]
    """Kind of doubt, a word."""
    start: Seconds
    """Begin of the stretch."""
    end: Seconds
    """End of the stretch."""
    message: str
    """What is doubtful, in a sentence."""
    counted: bool
    """Whether it is among the visits nevertheless."""


@dataclass(frozen=True, slots=True)
class Rule:
    """The parameters by which rest is distinguished from motion, as used; lengths in mm."""

    dwell_s: Duration
    """Shortest rest that is a visit."""
    window_s: Duration
    """Length of the sliding window."""
    samples_in_window: Count
    """How many samples the window holds."""
    still: Size
    """Largest range of the readings within a window at rest."""
    still_stated: bool
    """Whether the user stated it; else the one on which the number of rests depends least."""
    band: SizeByAxis
    """Half width of the limit band, by axis."""
    band_stated: bool
    """Whether the user stated it; else it is made of the scatter at rest."""


@dataclass(frozen=True, eq=False, slots=True)
class StreamVisits(Displayed):
    """The visits of a stream, and the table that they are."""

    run: Run
    """A row for each visit, with time_s, approach and what the stream's head stated."""
    visits: tuple[Visit, ...]
    """In the order of time, one for each row of `run`."""
    doubts: tuple[Doubt, ...]
    """Stretches that are not plainly one or the other."""
    rule: Rule
    """The parameters that distinguished rest from motion."""
    samples: int
    """Of the whole stream."""
    rate_hz: float
    """Samples a second, the median."""
    notes: tuple[str, ...]
    """What else is to be known of the reading, in words."""
    characteristics: tuple[Characteristic, ...]
    """Stabilisation time and overshoot (7.4, 7.5) of each pose with three arrivals or more."""

    def to_frame(self) -> pd.DataFrame:
        """Return the visits as a pandas table, a row for each."""
        return self.run.to_frame()

    def __repr__(self) -> str:
        of_it = self.run.origin.source or "a stream"
        return f"<StreamVisits of {of_it}: {len(self.visits)} visits, {len(self.doubts)} doubts>"
