"""What a diagnosis says: frozen results, values in the units of the run's axes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

from scara_iso.diagnosis.verdict import Rival, Verdict
from scara_iso.frames import make_frame
from scara_iso.run import FloatArray, IntArray

if TYPE_CHECKING:
    import pandas as pd

    from scara_iso.diagnosis.reversals.from_run import RunReversals

ByAxis: TypeAlias = Mapping[str, float]
"""One value for each axis by name; repeatabilities also have ``XY`` and ``XYZ``, radial."""


@dataclass(frozen=True, eq=False, slots=True)
class Found:
    """An effect that was found and added to the model."""

    effect: str
    axes: tuple[str, ...]
    """Axes that it moves."""
    joint: str | None
    """Name of the direction that its movement lies along, such as ``joint 1``."""
    angles: ByAxis
    """Angle in degrees between the movement and each direction of the geometry."""
    parameters: Mapping[str, float | str | ByAxis]
    """Parameters by name; sizes are one for each axis that it moves."""
    standard_errors: Mapping[str, ByAxis]
    """Standard error of each size."""
    p_value: float
    """Chance of structure as strong in scatter alone."""
    p_value_at_floor: bool
    """None of the permutations or simulations was as far: the chance is at most the p-value."""
    probability: float
    """Posterior probability among the catalogue and the unknown."""
    rivals: tuple[Rival, ...]
    cause: str
    confirm_by: str
    unidentified: tuple[str, ...] = ()
    """Parameters that the data do not determine, one line each."""
    share: ByAxis = field(default_factory=dict)
    """Share of each axis' variance that it takes; those of all effects add up to `Shares`."""
    left_open: Mapping[str, ByAxis] = field(default_factory=dict)
    """What a model must state beside ``parameters``: the scatter where a change of it begins."""


@dataclass(frozen=True, slots=True)
class Flag:
    """A reading that stands apart: look at the sheet. No cause and no verdict by itself."""

    axis: str
    cycle: int
    p_value: float
    """Chance in Gaussian scatter; heavier tails make such readings common."""
    p_value_at_floor: bool


@dataclass(frozen=True, eq=False, slots=True)
class Error:
    """Root mean square of measured minus predicted, by axis."""

    rms: ByAxis
    held_out_rms: ByAxis
    """On cycles that the fit did not see."""


@dataclass(frozen=True, slots=True)
class Foretold:
    """RP that a new test of 30 cycles will have, 95 % between ``low`` and ``high``."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False, slots=True)
class Repeatabilities:
    """RP measured, of the model before and after, and of the readings with the effects removed.

    ``completed`` is what the model with effects, scatter and rounding foretells of the next test.
    """

    measured: ByAxis
    model_before: ByAxis
    model_after: ByAxis
    with_effect_removed: ByAxis
    completed: Mapping[str, Foretold] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, slots=True)
class Series:
    """Readings over the cycles, shape (n,) for each axis."""

    cycle: IntArray = field(repr=False)
    measured: Mapping[str, FloatArray] = field(repr=False)
    predicted_before: Mapping[str, FloatArray] = field(repr=False)
    predicted_after: Mapping[str, FloatArray] = field(repr=False)


@dataclass(frozen=True, slots=True)
class Shares:
    """Shares of one axis' variance; they sum to 1."""

    effects: float
    resolution: float
    unexplained: float


@dataclass(frozen=True, eq=False, slots=True)
class Diagnosis:
    """What was found in one pose's readings."""

    verdict: Verdict
    effects: tuple[Found, ...]
    candidates: tuple[Rival, ...]
    """Likeliest explanations of what the last stage still found; empty where it found nothing."""
    p_value: float
    """Smallest p-value of the first stage: is there structure at all?"""
    p_value_at_floor: bool
    error_before: Error
    error_after: Error
    repeatability: Repeatabilities
    shares: Mapping[str, Shares]
    series: Series
    scatter: ByAxis = field(default_factory=dict)
    """Standard deviation of each axis beside effects and rounding."""
    flags: tuple[Flag, ...] = ()
    notes: tuple[str, ...] = ()
    """What could not be searched or told, one line each."""
    reversals: RunReversals | None = None
    """The gears, by payload; None without a model or the columns approach and payload_kg."""

    def __repr__(self) -> str:
        named = f" {', '.join(one.effect for one in self.effects)}" if self.effects else ""
        axes, n = ", ".join(self.series.measured), len(self.series.cycle)
        return f"<Diagnosis of {axes} over {n} cycles: {self.verdict.value}{named}>"

    def to_frame(self) -> pd.DataFrame:
        """Return the series as a pandas table, a row for each cycle that counts [mm, deg].

        Columns: cycle, and ``X_measured``, ``X_predicted_before``, ``X_predicted_after`` for each
        axis; before and after the effects were added to the model.
        """
        series = self.series
        kinds = ("measured", "predicted_before", "predicted_after")
        columns = {f"{a}_{k}": getattr(series, k)[a] for a in series.measured for k in kinds}
        return make_frame({"cycle": series.cycle, **columns}, {"verdict": self.verdict.value})
