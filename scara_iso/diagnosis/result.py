"""What a diagnosis says: frozen results, values in the units of the run's axes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

from scara_iso.base.display import Plotted
from scara_iso.base.published import Probability, Size
from scara_iso.diagnosis.verdict import Rival, Verdict
from scara_iso.run import AxisKey, FloatArray, IntArray, make_frame

if TYPE_CHECKING:
    import pandas as pd

    from scara_iso.diagnosis.reversals import RunReversals

ByAxis: TypeAlias = Mapping[str, float]
"""One value for each axis by name; repeatabilities also have ``XY`` and ``XYZ``, radial."""


ParameterValue: TypeAlias = "float | str | tuple[int, ...] | ByAxis"
"""A number, the name of a column, some cycles, or one number for each axis."""


@dataclass(frozen=True, eq=False, slots=True)
class AtJoint:
    """The size of an effect in a joint, in the links (growth, of 1), or in an axis everywhere."""

    value: float
    """Its size."""
    unit: str
    """``rad``, ``1``, ``mm`` or ``deg``."""
    standard_error: float
    """Of the size."""
    parameters: Mapping[str, float]
    """All that the effect has one of for each axis, such as the phase."""


@dataclass(frozen=True, eq=False, slots=True)
class Found:
    """An effect that was found and added to the model."""

    effect: str
    """Name of the effect; `explain` takes it."""
    axes: tuple[str, ...]
    """Axes that it moves."""
    joint: str | None
    """Name of the direction that its movement lies along, such as ``joint 1``."""
    angles: ByAxis
    """Angle in degrees between the movement and each direction of the geometry."""
    parameters: Mapping[str, ParameterValue]
    """Parameters by name; sizes are one for each axis that it moves, ``cycles`` a tuple."""
    standard_errors: Mapping[str, ByAxis]
    """Standard error of each size."""
    p_value: float
    """Chance of structure as strong in scatter alone."""
    p_value_at_floor: bool
    """None of the permutations or simulations was as far: the chance is at most the p-value."""
    probability: float
    """Posterior probability among the catalogue and the unknown."""
    rivals: tuple[Rival, ...]
    """Other effects that fit as well, likeliest first."""
    cause: str
    """What usually causes it."""
    confirm_by: str
    """The experiment that confirms it."""
    unidentified: tuple[str, ...] = ()
    """Parameters that the data do not determine, one line each."""
    share: ByAxis = field(default_factory=dict)
    """Share of each axis' variance that it takes; those of all effects add up to `Shares`."""
    left_open: Mapping[str, ByAxis] = field(default_factory=dict)
    """What a model must state beside ``parameters``: the scatter where a change of it begins."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Unit of each parameter; one that begins with ``reading`` is that of the axis."""
    poses: tuple[str, ...] = ()
    """The poses at which it acts, of a test of several: by axis is then by pose and axis."""
    place: str | None = None
    """Where it acts, where that is sure: a joint, ``along the arm``, ``Z everywhere``, a pose."""
    places: Mapping[str, float] = field(default_factory=dict)
    """How likely each place is."""
    joint_candidates: tuple[int, ...] = ()
    """The joints that these poses cannot tell apart."""
    at_joint: AtJoint | None = None
    """Its size in its place."""


@dataclass(frozen=True, slots=True)
class Flag:
    """A reading that stands apart: look at the sheet. No cause and no verdict by itself."""

    axis: AxisKey
    """Where the reading is."""
    cycle: int
    """Its cycle number."""
    p_value: Probability
    """Chance in Gaussian scatter; heavier tails make such readings common."""
    p_value_at_floor: bool
    """No simulation was as far: the chance is at most the p-value."""


@dataclass(frozen=True, eq=False, slots=True)
class Error:
    """Root mean square of measured minus predicted, by axis."""

    rms: Mapping[AxisKey, Size]
    """On the cycles that the fit saw [mm, deg]."""
    held_out_rms: Mapping[AxisKey, Size]
    """On cycles that the fit did not see."""


@dataclass(frozen=True, slots=True)
class Foretold:
    """RP that a new test of 30 cycles will have, 95 % between ``low`` and ``high``."""

    value: float
    """The median [mm, deg]."""
    low: float
    """Lower end of the prediction interval."""
    high: float
    """Upper end."""


SECOND = "the second table"


@dataclass(frozen=True, eq=False, slots=True)
class UnseenRP:
    """RP of cycles that the fit did not see, and what the models foretold of it."""

    of: str
    """Which cycles: those of the second table, or every other one, the model from the rest."""
    cycles: int
    """How many."""
    measured: ByAxis
    """Of their readings [mm, deg]."""
    model_before: ByAxis
    """Of what the model as it was predicts there."""
    completed: Mapping[str, Foretold]
    """As the completed model foretells it for as many cycles."""


@dataclass(frozen=True, eq=False, slots=True)
class Repeatabilities:
    """RP measured, of the model before and after, and of the readings with the effects removed.

    ``completed`` is what the model with effects, scatter and rounding foretells of the next test.
    """

    measured: ByAxis
    """Of the readings [mm, deg]."""
    model_before: ByAxis
    """Of what the model as it was predicts, which has no scatter."""
    model_after: ByAxis
    """Of what the model with the effects predicts."""
    with_effect_removed: ByAxis
    """Of the readings with the effects subtracted."""
    completed: Mapping[str, Foretold] = field(default_factory=dict)
    """Of the next test, by axis and in XY, as the completed model foretells it."""
    unseen: UnseenRP | None = None
    """Of unseen cycles; None where there are too few to leave half of them out."""


@dataclass(frozen=True, eq=False, slots=True)
class Series:
    """Readings over the cycles, shape (n,) for each axis."""

    cycle: IntArray = field(repr=False)
    """Cycle numbers, shape (n,)."""
    measured: Mapping[AxisKey, FloatArray] = field(repr=False)
    """By axis [mm, deg]."""
    predicted_before: Mapping[AxisKey, FloatArray] = field(repr=False)
    """By the model as it was."""
    predicted_after: Mapping[AxisKey, FloatArray] = field(repr=False)
    """By the model with the effects found."""


@dataclass(frozen=True, slots=True)
class Shares:
    """Shares of one axis' variance; they sum to 1."""

    effects: float
    """What the effects found explain."""
    resolution: float
    """Rounding to the dial's division."""
    unexplained: float
    """The rest."""


@dataclass(frozen=True, slots=True)
class UnexplainedCourse:
    """What is left unexplained in one axis."""

    axis: AxisKey
    """Where it is."""
    words: str
    """What it does over the cycles; empty where no smooth course is there."""


@dataclass(frozen=True, eq=False, slots=True)
class LearnedCourse:
    """The course of one axis that no effect explains, about its mean [mm, deg]."""

    cycle: IntArray = field(repr=False)
    """Cycle numbers, shape (n,)."""
    value: FloatArray = field(repr=False)
    """Expected, shape (n,)."""
    band: tuple[tuple[float, float], ...] = field(repr=False)
    """95 % of the course, without scatter: lower and upper end for each cycle."""


@dataclass(frozen=True, eq=False, slots=True)
class Learned:
    """What the completed model holds where no known effect fits: no name, no cause."""

    axes: Mapping[AxisKey, LearnedCourse]
    """By axis; an axis that shows no course is not among them."""


@dataclass(frozen=True, eq=False, slots=True)
class Diagnosis(Plotted):
    """What was found in one pose's readings."""

    verdict: Verdict
    """Whether there is structure, and whether effects explain it."""
    effects: tuple[Found, ...]
    """In the order in which they were found."""
    candidates: tuple[Rival, ...]
    """Likeliest explanations of what the last stage still found; empty where it found nothing."""
    p_value: float
    """Smallest p-value of the first stage: is there structure at all?"""
    p_value_at_floor: bool
    """No permutation was as far: the chance is at most the p-value."""
    error_before: Error
    """Of the model as it was."""
    error_after: Error
    """Of the model with the effects found."""
    repeatability: Repeatabilities
    """RP as measured, as predicted, and without the effects."""
    shares: Mapping[str, Shares]
    """Of the variance, by axis."""
    series: Series
    """Readings and predictions over the cycles."""
    courses: tuple[UnexplainedCourse, ...] = ()
    """What the unexplained looks like, where the verdict is that."""
    learned: Learned | None = None
    """The course that is added to the model where the verdict is ``unexplained``."""
    scatter: ByAxis = field(default_factory=dict)
    """Standard deviation of each axis beside effects and rounding."""
    flags: tuple[Flag, ...] = ()
    """Single readings to look at."""
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
