"""Measured reversals, of a sweep with one row each or of a run, and what is found in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple, TypeAlias

import numpy as np

from scara_iso.base.published import (
    ALWAYS,
    INTERNAL,
    MERGED,
    Count,
    Probability,
    Size,
    fill,
    publish,
    published,
)
from scara_iso.base.quantities import rounding_uncertainty
from scara_iso.diagnosis.verdict import Rival, StructureTested, Verdict
from scara_iso.effects import Conditions, Sweep
from scara_iso.iso9283 import PoseResult
from scara_iso.robot import Backlash, Model, predict
from scara_iso.run import AxisKey, FloatArray, IntArray, Run, step_of
from scara_iso.tables import ColumnNames, Source, read_columns

Joint: TypeAlias = Annotated[int, ("enum", (1, 2))] | None
"""A joint's number; None for a sweep, which has one joint only."""

_NEEDED = ("Im", "IL", "arcmin", "deviation_rad")
_COLUMNS = ColumnNames(
    what="a sweep of reversals",
    needed=_NEEDED,
    optional=("ratio", "torque_Nm", "u_rad"),
    positive=frozenset({"Im", "IL", "arcmin", "ratio", "u_rad"}),
    remedy=f"give the columns {', '.join(_NEEDED)} in kg m2, arcmin and rad",
)
_COARSE = 0.5
"""Scatter under this share of a division leaves the rounding of a mean unaveraged."""


class MeasuredSweep(NamedTuple):
    """Reversals and the load deviations measured at them, in rad, shape (m,)."""

    sweep: Sweep
    deviation: FloatArray
    """With eq. 16's sign: not positive."""
    uncertainty: FloatArray | None
    """Standard uncertainties in rad, None where not given."""
    notes: tuple[str, ...] = ()


def read_sweep(source: Source, *, decimal: str | None = None) -> MeasuredSweep:
    """Return the sweep of a table with the columns Im, IL, arcmin and deviation_rad.

    Optional columns are ratio, torque_Nm and u_rad; others are left out. Text or .xlsx, in the
    spellings that `tables.read_table` takes, ``decimal`` as there; ``#`` begins a comment line.
    Raises `NoInputError` where it cannot be read, and `DataError` with every fault and its line.
    """
    columns = read_columns(source, _COLUMNS, decimal=decimal).values
    deviation = columns["deviation_rad"]
    sizes = bool(np.all(deviation >= 0))
    return MeasuredSweep(
        Sweep(
            I_m=columns["Im"],
            I_L=columns["IL"],
            gap=np.radians(columns["arcmin"] / 60),
            torque=columns.get("torque_Nm"),
            ratio=columns.get("ratio"),
        ),
        -deviation if sizes else deviation,
        columns.get("u_rad"),
        ("deviations are taken as sizes: eq. 16's sign is negative",) if sizes else (),
    )


@dataclass(frozen=True, eq=False, slots=True)
class GearFound:
    """An effect on the load deviation; intervals are 95 %, over all effects that were found."""

    effect: str
    """Name of the effect; `explain` takes it."""
    joint: Joint
    """Number of the joint; None for a sweep of one gear."""
    parameters: Mapping[str, float]
    """By name, in the units that the effect's page states."""
    intervals: Mapping[str, tuple[float, float]]
    """95 %, by the name of the parameter."""
    p_value: Probability
    """Chance of as much in scatter alone."""
    probability: Probability
    """Of the effects found, together."""
    rivals: tuple[Rival, ...]
    """Other effects that fit as well, likeliest first."""
    cause: str
    """What usually causes it."""
    confirm_by: str
    """The experiment that confirms it."""


@dataclass(frozen=True, slots=True)
class GearError:
    """Measured minus predicted of reversals, root mean square."""

    rms: Size
    """In the unit of the reversals."""
    held_out_rms: Size | None
    """Each payload, or reversal, left out in turn; null where there is one only."""


@dataclass(frozen=True, slots=True)
class GearErrors:
    """The errors of both models of the gear."""

    before: GearError
    """By eq. 16."""
    after: GearError
    """By eq. 16 with the effects found."""


@dataclass(frozen=True, eq=False, slots=True)
class SweepSeries:
    """Reversals in their order, shape (m,), in their unit."""

    measured: FloatArray
    """With eq. 16's sign."""
    predicted_before: FloatArray
    """By eq. 16."""
    predicted_after: FloatArray
    """With the effects found."""


@dataclass(frozen=True, eq=False, kw_only=True)
class GearVerdict(StructureTested):
    """What the two-inertia model leaves of measured reversals."""

    effects: tuple[GearFound, ...]
    """At most two; both act together and share `probability` and `rivals` (`a+b`)."""
    candidates: tuple[Rival, ...]
    """Where it is `unexplained`: the nearest effects."""
    error: GearErrors
    """Measured minus predicted, before and after."""


@dataclass(frozen=True, eq=False, kw_only=True)
class GearDiagnosis(GearVerdict):
    """The same, with the reversals."""

    series: SweepSeries
    """Measured and predicted."""
    notes: tuple[str, ...] = ()
    """What could not be tried, one line each."""


def _verdict_of(gear: GearDiagnosis | None) -> GearVerdict | None:
    return None if gear is None else publish(GearVerdict, gear)


@dataclass(frozen=True, slots=True)
class Reversal:
    """Half the distance between the two approaches, of one axis at one payload."""

    axis: AxisKey
    """``X`` or ``Y``."""
    payload_kg: float
    """Payload [kg]."""
    cycles: tuple[Count, Count]
    """How many arrived with approach +1, and -1."""
    half_width_mm: float
    """Mean of approach +1 less mean of approach -1, over 2; known effects subtracted."""
    uncertainty_mm: Size
    """Standard uncertainty; the scatter is pooled over payloads and approaches."""
    predicted_before_mm: float | None = field(default=None, metadata=ALWAYS)
    """By eq. 16 and the gear effects that the model declares; None where it cannot say."""
    predicted_after_mm: float | None = field(default=None, metadata=ALWAYS)
    """With the effects that were found; None likewise."""


@dataclass(frozen=True, eq=False, slots=True)
class RunReversals:
    """The reversals of a run, and what the model's gears leave of them."""

    reversals: tuple[Reversal, ...]
    """One for each axis and payload."""
    gear: GearDiagnosis | None = field(metadata=published(by=_verdict_of, merged=True))
    """In mm; None where the model lacks what the comparison needs."""
    missing: tuple[str, ...] = ()
    """Fields that the model lacks."""
    mirrored: bool = False
    """The load rests on the other side than in the model, so that sizes were compared."""
    notes: tuple[str, ...] = ()
    """What was left out or not tried."""
    accounts_for: tuple[str, ...] = field(default=(), metadata=INTERNAL)
    """Effects of the readings that are gone once those on the gear are in the model."""
    verdict: Verdict | None = field(init=False)
    """Of the gear; null where the fields `missing` are needed."""

    def __post_init__(self) -> None:
        fill(self, verdict=self.gear and self.gear.verdict)


@dataclass(frozen=True, eq=False, slots=True)
class BacklashResult:
    """``backlash``: the paper's two-inertia model, beside it what was measured."""

    model: Backlash = field(metadata=MERGED)
    actual: PoseResult | None = None
    """The measured pose beside the model, as in `analyze`."""
    sweep: GearDiagnosis | None = field(default=None, metadata=MERGED)
    """With a measured sweep: what the model leaves of it, in rad."""


def rms_of(values: FloatArray) -> float:
    """Return the root mean square."""
    return float(np.sqrt((values**2).mean()))


class Halves(NamedTuple):
    """Halves of the distance between the approaches, ``half`` (axes, payloads) [mm].

    ``counts`` (payloads, 2) are the cycles of each side. The readings scatter about the mean of
    their payload and approach by ``covariance`` (axes, axes), not below the rounding, with
    ``degrees`` of freedom; ``rounding`` (axes,) is the variance of a mean that averaging does not
    lower: of rounding without enough scatter.
    """

    names: Sequence[str]
    payload: FloatArray
    counts: IntArray
    half: FloatArray
    covariance: FloatArray
    rounding: FloatArray
    degrees: int

    def uncertainty(self, directions: FloatArray) -> FloatArray:
        """Return the standard uncertainty (d, payloads) along unit vectors (d, axes)."""
        each = np.einsum("da,ab,db->d", directions, self.covariance, directions)
        rounding = directions**2 @ self.rounding
        of_means = np.outer(each, (1 / self.counts).sum(axis=1)) + 2 * rounding[:, np.newaxis]
        return np.asarray(np.sqrt(of_means) / 2)

    def reversals(self, *predicted: FloatArray) -> tuple[Reversal, ...]:
        """Return them by axis and then payload; ``predicted`` (axes, payloads) before and after."""
        values = np.stack([self.half, self.uncertainty(np.eye(len(self.names))), *predicted])
        return tuple(
            Reversal(name, payload, tuple(self.counts[k].tolist()), *values[:, a, k].tolist())
            for a, name in enumerate(self.names)
            for k, payload in enumerate(self.payload.tolist())
        )


def halves_of(run: Run, model: Model, names: Sequence[str]) -> Halves:
    """Return the reversals of a run's axes by payload, what the model knows subtracted."""
    expected = predict(model, Conditions(run.cycle, run.covariates), reversal=False).axes
    known = [expected[name].readings if name in expected else 0.0 for name in names]
    left = np.stack([run.axes[n].readings - k for n, k in zip(names, known, strict=True)])
    payload, side = run.covariates["payload_kg"], np.sign(run.covariates["approach"])
    parts = {
        p: [left[:, (payload == p) & (side == s)] for s in (1, -1)] for p in np.unique(payload)
    }
    parts = {p: both for p, both in parts.items() if all(part.size for part in both)}
    within = [part - part.mean(axis=1, keepdims=True) for both in parts.values() for part in both]
    degrees = sum(part.shape[1] - 1 for part in within)
    squares = sum((part @ part.T for part in within), np.zeros((len(names), len(names))))
    covariance = squares / max(degrees, 1)
    variance = covariance.diagonal()
    steps = np.array([step_of(run.axes[name]) for name in names])
    rounding = np.array([rounding_uncertainty(step) ** 2 for step in steps])
    halves = [(plus.mean(axis=1) - minus.mean(axis=1)) / 2 for plus, minus in parts.values()]
    return Halves(
        names=names,
        payload=np.array([*parts], dtype=np.float64),
        counts=np.reshape([part.shape[1] for both in parts.values() for part in both], (-1, 2)),
        half=np.stack(halves, axis=1) if halves else np.empty((len(names), 0)),
        covariance=covariance + np.diag(np.maximum(rounding - variance, 0.0)),
        rounding=np.where(np.sqrt(variance) < _COARSE * steps, rounding, 0.0),
        degrees=degrees,
    )
