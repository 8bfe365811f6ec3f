"""Which study the readings of a dial are, its figures, and what a tolerance makes of them.

What a guideline asks of a figure, and whether it is met.

The guidelines hold the figure itself against their limit, which has room for its chance in it:
that is the rule unless another is chosen. By the rule `interval` a criterion is met where the
whole 95 % interval is on its side, and neither proven nor refuted where the limit is within.

What is to be known of a study before its figures are signed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from scara_iso.base.display import Plotted
from scara_iso.base.published import INTERNAL, MERGED, Interval, fill, published, row_of
from scara_iso.gauge.budget import Budget
from scara_iso.gauge.crossed import Crossed, crossed
from scara_iso.gauge.reference_parts import (
    Linearity,
    Stability,
    TypeOne,
    linearity,
    stability,
    type_1,
)
from scara_iso.gauge.table import GaugeReadings, GaugeTables, Remark
from scara_iso.iso9283 import Conformity, DecisionRule
from scara_iso.run import frame_of

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, slots=True)
class Criterion:
    """One figure against the limit of a guideline."""

    name: str = field(metadata=published("criterion"))
    """``Cg``, ``Cgk``, ``resolution/T``, ``Q_MS``, ``R&R/T``, ``ndc`` and the like."""
    of: str
    """The guideline."""
    axis: str
    """Whose dial."""
    value: float | None
    """None where the readings give none."""
    interval: Interval | None
    """95 %; None where it has none."""
    limit: float
    """What the guideline asks for."""
    at_least: bool
    """Whether the figure must be at least the limit; else at most."""
    decision: DecisionRule = field(metadata=INTERNAL)
    """Whether the figure itself decides, or its interval."""
    conditional_above: float | None = field(default=None, metadata=INTERNAL)
    """From here to the limit the guideline leaves it to the use and its cost; None: nowhere."""
    verdict: Conformity = field(init=False)
    """What the rule makes of it; without a figure nothing is provable."""
    is_conditional: bool = field(init=False)
    """It passes in the band that the guideline leaves to the use and its cost (AIAG: R&R of 10 to
    30 %)."""

    def __post_init__(self) -> None:
        ends = self.interval if self.decision is DecisionRule.INTERVAL else None
        fill(self, verdict=self._verdict(ends))
        band, passes = self.conditional_above, self.verdict is Conformity.PASS
        conditional = band is not None and passes and max(ends or (self.value or 0.0,)) > band
        fill(self, is_conditional=conditional)

    def _verdict(self, ends: Interval | None) -> Conformity:
        if self.value is None:
            return Conformity.NOT_PROVABLE
        met = {self._met(end) for end in ends or (self.value,)}
        if len(met) > 1:
            return Conformity.NOT_PROVABLE
        return Conformity.PASS if met == {True} else Conformity.FAIL

    def _met(self, value: float) -> bool:
        return value >= self.limit if self.at_least else value <= self.limit


def worst(criteria: tuple[Criterion, ...]) -> Conformity | None:
    """Return the gravest verdict, None of none."""
    found = {one.verdict for one in criteria}
    for verdict in (Conformity.FAIL, Conformity.NOT_PROVABLE, Conformity.PASS):
        if verdict in found:
            return verdict
    return None


_LEVEL = 0.05
_WANTED = 25
"""Readings of a type 1 study: 50 are usual, 25 the fewest (Bosch booklet 10)."""
_GOOD, _BAD = 0.1, 0.3
"""AIAG's bands of R&R: good below, not acceptable above."""
_ORIGINS = {
    "CAL": "the dial's calibration (state '# indicator_uncertainty', from its certificate)",
    "RE": "the dial's division (state '# resolution')",
    "BI": "the bias (state the true value: '# reference')",
    "LIN": "linearity (a study of its own)",
}


def study_remarks(
    readings: GaugeReadings,
    figures: TypeOne | Crossed | Linearity | Stability,
    tolerance: float | None,
    statements: Mapping[str, str],
) -> Iterator[Remark]:
    """Yield what speaks against the figures, or limits what they say."""
    axis = readings.axis
    if statements.get("simulated"):
        yield Remark("warning", axis, "SIMULATED readings: no dial was read")
    if tolerance is None:
        yield Remark("info", axis, "no tolerance is stated: nothing is held against a limit")
    yield from _of_the_dial(readings)
    match figures:
        case TypeOne():
            yield from _of_type_1(axis, figures, readings.unit)
        case Crossed():
            yield from _of_crossed(axis, figures)
        case Linearity():
            yield from _of_linearity(axis, figures)
        case Stability():
            yield from _of_stability(axis, figures, readings.unit)
    if not isinstance(figures, Stability) and figures.budget.missing:
        said = "; ".join(_ORIGINS[name] for name in figures.budget.missing)
        yield Remark("info", axis, f"not counted in u: {said}")


def _of_the_dial(readings: GaugeReadings) -> Iterator[Remark]:
    levels = len(set(readings.values.tolist()))
    if levels == 1:
        yield Remark(
            "warning",
            readings.axis,
            "all readings are alike: the dial's division hides "
            "its scatter, and what it is cannot be told",
        )
    elif levels < 4 and len(readings.values) >= 10:
        yield Remark(
            "warning",
            readings.axis,
            f"the readings take {levels} values only: the dial's division decides their scatter",
        )


def _of_type_1(axis: str, figures: TypeOne, unit: str) -> Iterator[Remark]:
    if figures.n < _WANTED:
        yield Remark("warning", axis, f"{figures.n} readings; 50 are usual, {_WANTED} the fewest")
    if figures.bias is not None and figures.p_value is not None and figures.p_value < _LEVEL:
        side = "too much" if figures.bias > 0 else "too little"
        yield Remark(
            "info",
            axis,
            f"the dial reads {side}, by {abs(figures.bias):.2g} {unit} (p = {figures.p_value:.2g})",
        )


def _of_crossed(axis: str, figures: Crossed) -> Iterator[Remark]:
    p, o, r = figures.cells.shape
    if p * max(o, 1) < 15 or r < 2:
        yield Remark("warning", axis, f"{p} parts x {o} operators: 15 or more are usual")
    if 1 < o < 3:
        yield Remark(
            "info", axis, f"{o} operators tell little of what operators make; three are usual"
        )
    whole = figures.components["GRR"]
    share, of = (whole.of_study, "TV") if whole.of_tolerance is None else (whole.of_tolerance, "T")
    if _GOOD < share <= _BAD:
        yield Remark(
            "info",
            axis,
            f"R&R is {share:.0%} of {of}: between 10 and 30 % AIAG leaves "
            "it to the use and its cost",
        )
    zero = [
        name
        for name in ("AV", "INT", "PV")
        if name in figures.components and figures.components[name].sigma == 0
    ]
    if zero:
        yield Remark("info", axis, f"{', '.join(zero)}: estimated below 0, taken as 0")


def _of_linearity(axis: str, figures: Linearity) -> Iterator[Remark]:
    if not figures.holds_zero:
        yield Remark(
            "warning",
            axis,
            "the line of the bias leaves 0 within the range (AIAG): the "
            "dial is not linear there, or reads beside",
        )
    if len(figures.references) < 5:
        yield Remark("info", axis, f"{len(figures.references)} references; five are usual")


def _of_stability(axis: str, figures: Stability, unit: str) -> Iterator[Remark]:
    if figures.outside:
        yield Remark("warning", axis, f"outside the limits: {', '.join(figures.outside)}")
    if figures.trend_p_value is not None and figures.trend_p_value < _LEVEL:
        yield Remark(
            "warning",
            axis,
            f"the mean moves by {figures.trend:.2g} {unit} a session "
            f"(p = {figures.trend_p_value:.2g})",
        )
    if len(figures.sessions) < 20:
        yield Remark("info", axis, f"{len(figures.sessions)} sessions; limits settle with 20")


Figures: TypeAlias = TypeOne | Crossed | Linearity | Stability
SEED = 1
_AIAG, _VDA, _BOSCH = "AIAG MSA 4", "VDA 5", "Bosch booklet 10"


class StudyKind(Enum):
    """The kind of a study; the value is the word used in outputs."""

    TYPE_1 = "type-1"
    """One part of known size, read again and again."""
    TYPE_2 = "type-2"
    """Parts read by several operators."""
    TYPE_3 = "type-3"
    """Parts read by one operator, or by a machine."""
    LINEARITY = "linearity"
    """Parts of several known sizes."""
    STABILITY = "stability"
    """One part in several sessions."""


@dataclass(frozen=True, eq=False, slots=True)
class AxisStudy:
    """The study of one dial."""

    kind: StudyKind
    """By the columns of its table."""
    readings: GaugeReadings = field(metadata=MERGED)
    """What it was made of."""
    tolerance: float | None
    """Width of the tolerance [mm, deg]; None where not stated."""
    figures: Figures = field(metadata=INTERNAL)
    """Those of its kind."""
    criteria: tuple[Criterion, ...] = field(metadata=INTERNAL)
    """What the guidelines ask; none without a tolerance."""
    type_1: TypeOne | None = field(default=None, init=False)
    """One part of known size, read again and again."""
    crossed: Crossed | None = field(default=None, init=False)
    """Types 2 and 3: parts, read several times by operators or a machine."""
    linearity: Linearity | None = field(default=None, init=False)
    """Parts of several known sizes."""
    stability: Stability | None = field(default=None, init=False)
    """One part in several sessions."""
    budget: Budget | None = field(init=False, metadata=published("uncertainty_budget"))
    """The uncertainties by VDA 5; None of a stability study."""

    def __post_init__(self) -> None:
        found = self.figures
        fill(self, **{_KEYS[type(found)]: found})
        fill(self, budget=None if isinstance(found, Stability) else found.budget)


_KEYS: Mapping[type, str] = {
    TypeOne: "type_1",
    Crossed: "crossed",
    Linearity: "linearity",
    Stability: "stability",
}


@dataclass(frozen=True, eq=False, kw_only=True)
class GaugeStudy(Plotted):
    """``gauge-study`` of one or several tables."""

    schema: Literal["scara-iso/gauge-study/1"] = "scara-iso/gauge-study/1"
    """Name and number of this schema."""
    source: str
    """Names of the tables."""
    notes: tuple[str, ...] = ()
    """What of the tables was not used."""
    statements: Mapping[str, str] = field(metadata=published("metadata"))
    """What the tables state."""
    decision: DecisionRule
    """Whether the figure itself decides, or its interval."""
    axes: Mapping[str, AxisStudy]
    """By name."""
    criteria: tuple[Criterion, ...] = field(init=False)
    """What the guidelines ask; none without a tolerance."""
    conformity: Conformity | None = field(init=False)
    """The gravest verdict; None where no tolerance is stated."""
    remarks: tuple[Remark, ...] = field(metadata=published("findings"))
    """What is to be known beside the figures."""

    def __post_init__(self) -> None:
        criteria = tuple(one for axis in self.axes.values() for one in axis.criteria)
        fill(self, criteria=criteria, conformity=worst(criteria))

    def __repr__(self) -> str:
        kinds = ", ".join(f"{name} {one.kind.value}" for name, one in self.axes.items())
        return f"<GaugeStudy of {self.source}: {kinds}>"

    def to_frame(self) -> pd.DataFrame:
        """Return the criteria as a pandas table, a row for each."""
        return frame_of([row_of(one) for one in self.criteria], {})


def study_gauge(
    tables: GaugeTables,
    *,
    decision: DecisionRule = DecisionRule.SIMPLE,
    seed: int = SEED,
) -> GaugeStudy:
    """Return the study that the readings make, by what they name: part, operator, session.

    ``seed`` is of the draws for the intervals of figures of several variances. Raises `DataError`
    for readings that make no study.
    """
    axes = {
        dial.axis: _study(dial, tables.tolerances.get(dial.axis), decision, seed)
        for dial in tables.dials
    }
    found = [
        said
        for one in axes.values()
        for said in study_remarks(one.readings, one.figures, one.tolerance, tables.statements)
    ]
    return GaugeStudy(
        axes=axes,
        remarks=tuple(dict.fromkeys(found)),
        decision=decision,
        statements=tables.statements,
        source=tables.dials[0].source,
        notes=tables.notes,
    )


def kind_of(readings: GaugeReadings) -> StudyKind:
    """Return the kind of study; `DataError` for one part read by several operators."""
    parts, operators, sessions = (
        len(set(labels or ("",))) for labels in (readings.part, readings.operator, readings.session)
    )
    references = 1 if readings.reference is None else len(np.unique(readings.reference))
    if parts > 1 and operators > 1:
        return StudyKind.TYPE_2
    if references > 1:
        return StudyKind.LINEARITY
    if parts > 1:
        return StudyKind.TYPE_3
    if sessions > 1:
        return StudyKind.STABILITY
    if operators > 1:
        raise readings.refuse(
            "several operators, and one part", "let each read several parts, named in column part"
        )
    return StudyKind.TYPE_1


def _study(
    readings: GaugeReadings, tolerance: float | None, decision: DecisionRule, seed: int
) -> AxisStudy:
    kind, rng = kind_of(readings), np.random.default_rng(seed)
    figures: Figures
    if kind is StudyKind.TYPE_1:
        figures = type_1(readings, tolerance, rng)
    elif kind is StudyKind.LINEARITY:
        figures = linearity(readings, tolerance, rng)
    elif kind is StudyKind.STABILITY:
        figures = stability(readings)
    else:
        figures = crossed(readings, tolerance, rng)
    criteria = tuple(_criteria(readings, figures, tolerance, decision)) if tolerance else ()
    return AxisStudy(kind, readings, tolerance, figures, criteria)


def _criteria(
    readings: GaugeReadings, figures: Figures, tolerance: float, decision: DecisionRule
) -> Iterator[Criterion]:
    def criterion(
        name: str,
        of: str,
        value: float | None,
        ends: Interval | None,
        limit: float,
        *,
        at_least: bool = False,
    ) -> Criterion:
        return Criterion(name, of, readings.axis, value, ends, limit, at_least, decision)

    if readings.resolution is not None:
        yield criterion("resolution/T", _VDA, readings.resolution / tolerance, None, 0.05)
    match figures:
        case TypeOne():
            yield criterion("Cg", _BOSCH, figures.Cg, figures.Cg_interval, 1.33, at_least=True)
            if figures.bias is not None:
                yield criterion(
                    "Cgk", _BOSCH, figures.Cgk, figures.Cgk_interval, 1.33, at_least=True
                )
        case Crossed():
            whole = figures.components["GRR"]
            share, ends = whole.of_tolerance, whole.of_tolerance_interval
            band = criterion("R&R/T", _AIAG, share, ends, _BAD)
            yield replace(band, conditional_above=_GOOD)
            yield criterion("ndc", _AIAG, figures.ndc_raw, figures.ndc_interval, 5, at_least=True)
        case Stability():
            yield criterion("sessions outside", _AIAG, float(len(figures.outside)), None, 0)
    if not isinstance(figures, Stability):
        Q = figures.budget
        yield criterion(f"Q_{Q.of}", _VDA, Q.Q, Q.Q_interval, Q.limit)
