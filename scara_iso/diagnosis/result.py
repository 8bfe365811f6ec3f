"""What a diagnosis says: frozen results, values in the units of the run's axes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from scara_iso.base.displayed import Plotted
from scara_iso.base.published import INTERNAL, Interval, Probability, Size, fill, published
from scara_iso.diagnosis.sweeps import RunReversals
from scara_iso.diagnosis.verdict import Rival, StructureTested
from scara_iso.run import AXES, AxisKey, FloatArray, IntArray, make_frame

if TYPE_CHECKING:
    import pandas as pd

ByAxis: TypeAlias = Mapping[str, float]
"""One value for each axis by name; repeatabilities also have ``XY`` and ``XYZ``, radial."""
OfAxes: TypeAlias = Mapping[AxisKey, float]
Figure: TypeAlias = Annotated[str, ("enum", (*AXES, "XY", "XYZ"))]
"""An axis, or radial in the plane and in space."""
RPs: TypeAlias = Mapping[Figure, Size]
"""In mm; of an angle in degrees."""


ParameterValue: TypeAlias = "float | str | tuple[int, ...] | ByAxis"
"""A number, the name of a column, some cycles, or one number for each axis."""
ArmPlace: TypeAlias = Literal[1, 2, 4, "along the arm"]
_PLACES: Mapping[str, ArmPlace] = {
    "joint 1": 1,
    "joint 2": 2,
    "joint 4": 4,
    "along the arm": "along the arm",
}
_LEAST_PLACE = 0.001


@dataclass(frozen=True, eq=False, slots=True)
class AtJoint:
    """The size of an effect in its place."""

    value: float
    """In a joint, in the links (growth, of 1), or in an axis everywhere alike."""
    unit: Annotated[str, ("enum", ("rad", "1", "mm", "deg"))]
    """Of it."""
    standard_error: float = field(metadata=INTERNAL)
    """Of the size."""
    parameters: Mapping[str, float] = field(metadata=INTERNAL)
    """All that the effect has one of for each axis, such as the phase."""
    interval: Interval = field(init=False)
    """95 %."""

    def __post_init__(self) -> None:
        half = 2 * self.standard_error
        fill(self, interval=(self.value - half, self.value + half))


def _turning(joint: str | None) -> Annotated[int, ("enum", (1, 2))] | None:
    return {"joint 1": 1, "joint 2": 2}.get(joint or "")


def _in_arm(joint: str | None) -> ArmPlace | None:
    return _PLACES.get(joint or "")


def _likely(places: Mapping[str, float]) -> Mapping[str, Probability]:
    return {name: p for name, p in places.items() if p >= _LEAST_PLACE}


@dataclass(frozen=True, eq=False, kw_only=True)
class Found:
    """An effect that was found and added to the model."""

    effect: str
    """Its name; `scara-iso explain EFFECT` explains it."""
    axes: tuple[AxisKey, ...]
    """Axes that it moves."""
    joint: str | None = field(metadata=published(by=_turning))
    """Joint along whose movement it lies; null along none."""
    direction: str | None = field(init=False, metadata=published(always=True))
    """That its movement lies along; null where none is sure."""
    angles: Mapping[str, Annotated[float, ("unit", "deg")]]
    """Between its movement and each direction of the geometry."""
    parameters: Mapping[str, float | str | tuple[int, ...] | OfAxes]
    """By name; sizes by axis; `tau_s`, `period_s` where `time_s` was recorded."""
    standard_errors: Mapping[str, OfAxes]
    """Standard error of each size, by axis."""
    p_value: Probability
    """Chance of structure as strong in scatter alone."""
    p_value_at_floor: bool
    """No shuffle or simulation was as far: the chance is at most the p-value."""
    probability: Probability
    """Posterior, among the catalogue and the unknown."""
    rivals: tuple[Rival, ...]
    """Other effects that fit as well, likeliest first."""
    cause: str
    """What usually causes it."""
    confirm_by: str
    """The experiment that confirms it."""
    unidentified: tuple[str, ...] = ()
    """Parameters that the data do not determine, one line each."""
    share: OfAxes = field(default_factory=dict)
    """Of the variance of each axis; those of all effects add up to `shares`."""
    left_open: Mapping[str, Any] = field(default_factory=dict, metadata=INTERNAL)
    """What a model must state beside ``parameters``: the scatter where a change of it begins."""
    units: Mapping[str, str] = field(default_factory=dict, metadata=INTERNAL)
    """Unit of each parameter; one that begins with ``reading`` is that of the axis."""

    def __post_init__(self) -> None:
        fill(self, direction=self.joint)


@dataclass(frozen=True, eq=False, kw_only=True)
class FoundAtPoses(Found):
    """An effect that was found in a test of several poses."""

    joint: str | None = field(metadata=published(by=_in_arm))
    """Where in the arm; theta alike everywhere is joint 4 or its indicator."""
    parameters: Mapping[str, float | str | tuple[int, ...] | Mapping[str, OfAxes]]  # type: ignore[assignment]
    """By name; sizes by pose and axis."""
    standard_errors: Mapping[str, Mapping[str, OfAxes]]  # type: ignore[assignment]
    """Standard error of each size, by pose and axis."""
    share: Mapping[str, OfAxes] = field(default_factory=dict)  # type: ignore[assignment]
    """Of the variance of each axis at each pose."""
    poses: Annotated[tuple[str, ...], ("minItems", 1)]
    """At which it acts."""
    place: str | None = field(default=None, metadata=published("direction", always=True))
    """Its place: a joint, `along the arm`, `Z everywhere`, a pose; null where none is sure."""
    places: Mapping[str, float] = field(default_factory=dict, metadata=published(by=_likely))
    """How likely each is."""
    joint_candidates: tuple[Annotated[int, ("enum", (1, 2))], ...] = ()
    """Joints that these poses do not tell apart."""
    at_joint: AtJoint | None = field(default=None, metadata=published("size_at_joint", always=True))
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
class Errors:
    """Measured minus predicted, root mean square by axis."""

    before: Error
    """By the model as it was."""
    after: Error
    """By the model with the effects found."""

    def each(self, of: Callable[[Error], Error]) -> Errors:
        """Return what a function makes of both."""
        return Errors(of(self.before), of(self.after))


@dataclass(frozen=True, slots=True)
class Foretold:
    """RP that a test will measure."""

    value: Size
    """Expected."""
    interval: tuple[Size, Size]
    """95 %, of what the test measures."""


SECOND = "the second table"


@dataclass(frozen=True, eq=False, slots=True)
class UnseenRP:
    """RP of cycles that the fit did not see."""

    of: str
    """Which: those of the second table, or every other one, the model from the rest."""
    cycles: int
    """How many."""
    measured: RPs
    """Of their readings."""
    model_before: RPs
    """Of what the model as it was predicts there."""
    completed: Mapping[Figure, Foretold]
    """As the completed model foretells it for as many cycles."""


@dataclass(frozen=True, eq=False, slots=True)
class Repeatabilities:
    """RP measured, predicted, and without the effects: by axis, `XY` and `XYZ` (radial)."""

    measured: RPs
    """Of the readings."""
    model_before: RPs
    """Of what the model as it was predicts, which has no scatter."""
    model_after: RPs
    """Of what the model with the effects predicts."""
    with_effect_removed: RPs
    """Of the readings with the effects subtracted."""
    completed: Mapping[Figure, Foretold] = field(default_factory=dict)
    """Of a new test of 30 cycles, by the completed model: effects, scatter and rounding."""
    unseen: UnseenRP | None = field(default=None, metadata=published(always=True))
    """Null where there are too few cycles to leave half of them out."""


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
    units: Mapping[str, str] = field(default_factory=dict, metadata=INTERNAL)
    """By axis: mm, or deg of an angle."""


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


@dataclass(frozen=True, eq=False, kw_only=True)
class OfOnePose(StructureTested):
    """What is said of one pose beside its effects."""

    candidates: tuple[Rival, ...]
    """Where it is `unexplained`: the nearest effects."""
    courses: tuple[UnexplainedCourse, ...] = ()
    """Where it is `unexplained`: how it goes."""
    learned: Learned | None = field(default=None, metadata=published(always=True))
    """Where it is `unexplained`: the course that the completed model holds, about its mean."""
    error: Errors
    """Measured minus predicted, before and after."""
    repeatability: Repeatabilities
    """RP measured, predicted, and without the effects."""
    shares: Mapping[AxisKey, Shares]
    """Of each axis' variance."""
    series: Series
    """Readings and predictions over the cycles."""
    flags: tuple[Flag, ...] = ()
    """Readings that are apart from the others."""
    notes: tuple[str, ...] = ()
    """What could not be searched or told, and what was written to a model."""


@dataclass(frozen=True, eq=False, kw_only=True)
class DiagnoseSchema:
    """The head of the object."""

    schema: Literal["scara-iso/diagnose/2"] = "scara-iso/diagnose/2"
    """Name and number of this schema."""
    unit: Literal["mm"] = "mm"
    """Of every length."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Diagnosis(OfOnePose, DiagnoseSchema, Plotted):
    """``diagnose`` of one pose."""

    effects: tuple[Found, ...]
    """In the order in which they were found."""
    scatter: ByAxis = field(default_factory=dict, metadata=INTERNAL)
    """Standard deviation of each axis beside effects and rounding."""
    reversals: RunReversals | None = field(default=None, metadata=published("gear"))
    """With a model and the columns `approach` and `payload_kg`: the reversals."""

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
