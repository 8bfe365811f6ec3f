"""The families of tables, and what a diagnosis made of one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from scara_iso.diagnosis import Diagnosis, Verdict
from scara_iso.run import Run
from undeclared import bench_work, chance, gearbox, thermal
from undeclared.dial import through_a_file

SURE = 0.9
OUTCOMES = ("right", "rival", "unexplained", "silent", "wrong", "surely wrong")


@dataclass(frozen=True, slots=True)
class Family:
    """A cause and the names in the catalogue that say it; none where no effect is right."""

    make: Callable[[np.random.Generator], Run]
    names: frozenset[str] = frozenset()
    silent: bool = False
    """Whether nothing to explain is the right answer."""

    @property
    def name(self) -> str:
        """Name of what makes it."""
        return self.make.__name__

    def table(self, seed: int) -> Run:
        """Return the table of a seed as it is read from its file."""
        return through_a_file(self.make(np.random.default_rng([seed, crc32(self.name.encode())])))


def _of(make: Callable[[np.random.Generator], Run], *names: str) -> Family:
    return Family(make, frozenset(names))


FAMILIES = (
    _of(gearbox.reversal, "lost_motion"),
    _of(gearbox.hidden_sides, "contact_side"),
    _of(gearbox.changing_flank, "contact_side", "step"),  # one change only is a step
    _of(gearbox.coasting, "coast_in_gap"),
    _of(gearbox.hanging, "compliance"),
    _of(thermal.warming_up, "warm_up", "linear_drift"),
    _of(
        thermal.warming_up_with_a_thermometer,
        "temperature",
        "temperature_lagged",
        "warm_up",
        "linear_drift",
    ),
    _of(thermal.thermostat, "periodic"),
    _of(bench_work.zeroed_again, "step"),
    _of(bench_work.zeroed_each_time, "overcorrection"),
    _of(bench_work.taught_again, "overcorrection"),
    _of(bench_work.digit_slip, "outlier"),
    _of(chance.scatter_doubles, "scatter_change"),
    _of(chance.comes_loose, "scatter_change"),
    _of(chance.lost_counts, "random_walk"),
    _of(chance.beating, "periodic"),
    _of(chance.passing, "transient"),
    _of(chance.knocked, "transient"),
    _of(chance.three_loads),
    Family(chance.pointed_scatter, silent=True),
    Family(chance.flat_scatter, silent=True),
    Family(gearbox.one_side, silent=True),
)


def outcome(family: Family, found: Diagnosis) -> str:
    """Return which of `OUTCOMES` the diagnosis of one of the family's tables is.

    A flagged reading is right where an outlier is.
    """
    if not found.effects:
        if found.verdict is Verdict.UNEXPLAINED:
            return "unexplained" if family.names or family.silent else "right"
        flagged = "outlier" in family.names and found.flags
        return "right" if family.silent or flagged else "silent"
    first = found.effects[0]
    if first.effect in family.names:
        return "right"
    if family.names & {rival.effect for rival in first.rivals}:
        return "rival"
    return "surely wrong" if first.probability >= SURE else "wrong"
