"""What is known of each cycle of a test beside its reading."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from types import MappingProxyType

import numpy as np

from scara_iso.run import FloatArray, IntArray

CLOCK = "time_s"


@dataclass(frozen=True, eq=False, slots=True)
class Conditions:
    """Cycle numbers and recorded columns; every array has shape (n,).

    ``time`` is in cycles: the cycle number, or where ``time_s`` was recorded the same clock in
    units of its median interval.
    """

    cycle: IntArray
    covariates: Mapping[str, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "covariates", MappingProxyType(dict(self.covariates)))

    @property
    def elapsed(self) -> FloatArray:
        """Cycles since the first one, shape (n,)."""
        return np.asarray(self.cycle - self.cycle[0], dtype=np.float64)

    @property
    def time(self) -> FloatArray:
        """Time since the first cycle in cycles, from ``time_s`` where it is there and increases."""
        seconds, interval = self.seconds, self.interval
        if seconds is None or interval is None:
            return self.elapsed
        return seconds / interval

    @property
    def seconds(self) -> FloatArray | None:
        """Time since the first cycle [s], shape (n,); None where no clock was recorded.

        The first is the cycle of number 1, discarded or not, where the clock shows it to be zero;
        else the first one here.
        """
        if CLOCK not in self.covariates:
            return None
        clock, interval = np.asarray(self.covariates[CLOCK]), self.interval
        since_one = 0.0 if interval is None else float(self.cycle[0] - 1) * interval
        from_one = interval is not None and abs(clock[0] - since_one) < interval / 2
        return clock if from_one else clock - clock[0]

    @property
    def interval(self) -> float | None:
        """Median time from cycle to cycle [s]; None where no clock was recorded, or none goes."""
        apart = np.diff(self.covariates.get(CLOCK, np.empty(0)))
        return float(np.median(apart)) if len(apart) and np.all(apart > 0) else None

    def named(self, pattern: str) -> tuple[str, ...]:
        """Return the columns whose name fits a pattern such as ``temperature*``.

        The clock fits its own name only.
        """
        names = (
            name for name in self.covariates if CLOCK not in (name, pattern) or name == pattern
        )
        return tuple(name for name in names if fits(name, pattern))

    def without(self, names: set[str]) -> Conditions:
        """Return the conditions without some columns."""
        kept = {name: values for name, values in self.covariates.items() if name not in names}
        return Conditions(self.cycle, kept)

    def __len__(self) -> int:
        return len(self.cycle)


def fits(name: str, pattern: str) -> bool:
    """Return whether a column's name is ``pattern``, or fits it where it ends in ``*``."""
    return name == pattern or (is_open(pattern) and fnmatchcase(name.lower(), pattern))


def is_open(pattern: str) -> bool:
    """Return whether a pattern leaves open which column is meant."""
    return pattern.endswith("*")
