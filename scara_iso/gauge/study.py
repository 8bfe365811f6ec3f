"""Which study the readings of a dial are, its figures, and what a tolerance makes of them.

The guidelines hold the figure itself against their limit, which has room for its chance in it:
that is the rule unless another is chosen. By the rule `interval` a criterion is met where the
whole 95 % interval is on its side, and neither proven nor refuted where the limit is within.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from scara_iso.base.displayed import Plotted
from scara_iso.base.published import INTERNAL, MERGED, Interval, fill, published, row_of
from scara_iso.gauge.budget import Budget
from scara_iso.gauge.crossed import ComponentName, Crossed, crossed
from scara_iso.gauge.reference_parts import (
    Linearity,
    Stability,
    TypeOne,
    linearity,
    stability,
    type_1,
)
from scara_iso.gauge.table import GaugeReadings, GaugeTables, Remark
from scara_iso.iso9283 import Conformity, DecisionRule, far_readings, gravest, mann_kendall, median
from scara_iso.run import frame_of
from scara_iso.tables import length_in_mm

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
    at_least: bool = field(default=False, kw_only=True)
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


Figures: TypeAlias = TypeOne | Crossed | Linearity | Stability

_LEVEL = 0.05
_WANTED = 25
"""Readings of a type 1 study: 50 are usual, 25 the fewest (Bosch booklet 10)."""
_FEW = 5
"""Readings of a part whose median one of them moves."""
_GOOD, _BAD = 0.1, 0.3
"""AIAG's bands of R&R: good below, not acceptable above."""
_USED = re.compile(r"(?:unit|resolution|indicator_uncertainty|reference|tolerance)(?:_|$)")
_ORIGINS = {
    "CAL": "the dial's calibration (state '# indicator_uncertainty', from its certificate)",
    "RE": "the dial's division (state '# resolution')",
    "BI": "the bias (state the true value: '# reference')",
    "LIN": "linearity (a study of its own)",
}


def study_remarks(
    readings: GaugeReadings,
    figures: Figures,
    tolerance: float | None,
    statements: Mapping[str, str],
) -> Iterator[Remark]:
    """Yield what speaks against the figures, or limits what they say."""
    yield from _of_the_head(readings, figures, statements)
    if tolerance is None:
        yield readings.note("no tolerance is stated: nothing is held against a limit")
    levels = len(set(readings.values.tolist()))
    if levels == 1:
        yield readings.warn(
            "all readings are alike: the dial's division hides its scatter, and what it is cannot "
            "be told"
        )
    elif levels < 4 and len(readings.values) >= 10:
        yield readings.warn(
            f"the readings take {levels} values only: the dial's division decides their scatter"
        )
    for k in _far_from_its_like(readings):
        at = [(name, getattr(readings, name)) for name in ("part", "operator", "session")]
        of = ", ".join(f"{name} {labels[k]}" for name, labels in at if labels)
        yield readings.warn(
            f"reading {k + 1} ({readings.values[k]:.7g} {readings.unit}{of and f', {of}'}) lies "
            "far from the others like it, and every figure rests on it: was it misread or mistyped?"
        )
    yield from _REMARKS[type(figures)](readings, figures)
    if not isinstance(figures, Stability) and figures.budget.missing:
        said = "; ".join(_ORIGINS[name] for name in figures.budget.missing)
        yield readings.note(f"not counted in u: {said}")


def _of_the_head(
    readings: GaugeReadings, figures: Figures, statements: Mapping[str, str]
) -> Iterator[Remark]:
    if statements.get("simulated"):
        yield readings.warn("SIMULATED readings: no dial was read")
    if "robot" in statements and isinstance(figures, TypeOne) and readings.reference is None:
        yield readings.warn("the head names a robot: `scara-iso analyze` is for its arrivals")
    for key, text in statements.items():
        if not _USED.match(key) and length_in_mm(text) is not None:
            what = f"{key.replace('_', ' ')}: {text} is not used"
            yield readings.warn(f"{what}; if it is the true value, write '# reference: {text}'")


def _far_from_its_like(readings: GaugeReadings) -> Iterator[int]:
    """Yield up to three readings that lie far from others of their part, operator and session.

    Each is held against the median of the others, so that the scatter of three is not taken for
    that of two; of each part the farthest is told.
    """
    factors = [readings.part, readings.operator, readings.session, readings.reference]
    labels = [one for one in factors if one is not None]
    alike: dict[tuple[object, ...], list[int]] = {}
    for k in range(len(readings.values)):
        alike.setdefault(tuple(one[k] for one in labels), []).append(k)
    cells = [cell for cell in alike.values() if len(cell) > 1]
    away = np.zeros(len(readings.values))
    for cell in cells:
        values = readings.values[cell]
        few = len(cell) <= _FEW
        away[cell] = values - (
            [median(np.delete(values, k)) for k in range(len(cell))] if few else median(values)
        )
    paired = [k for cell in cells for k in cell]
    far = {paired[k] for k in far_readings(away[paired], readings.resolution)} if paired else set()
    for cell in cells:
        if within := far.intersection(cell):
            yield max(within, key=lambda k: abs(away[k]))


def _of_type_1(readings: GaugeReadings, figures: TypeOne) -> Iterator[Remark]:
    if figures.n < _WANTED:
        yield readings.warn(f"{figures.n} readings; 50 are usual, {_WANTED} the fewest")
    if figures.bias is not None and figures.p_value is not None and figures.p_value < _LEVEL:
        side = "too much" if figures.bias > 0 else "too little"
        by = f"{abs(figures.bias):.2g} {readings.unit} (p = {figures.p_value:.2g})"
        yield readings.note(f"the dial reads {side}, by {by}")
    if (p := mann_kendall(readings.values)) < _LEVEL:
        yield readings.warn(
            f"the readings move in their order (Mann-Kendall p = {p:.1g}): s counts that as the "
            "dial's scatter, or part and dial were not at rest"
        )


def _of_crossed(readings: GaugeReadings, figures: Crossed) -> Iterator[Remark]:
    p, o, r = figures.cells.shape
    if p * o < 15 or r < 2:
        yield readings.warn(f"{p} parts x {o} operators: 15 or more are usual")
    if 1 < o < 3:
        yield readings.note(f"{o} operators tell little of what operators make; three are usual")
    whole = figures.components["GRR"]
    share, of = (whole.of_study, "TV") if whole.of_tolerance is None else (whole.of_tolerance, "T")
    if _GOOD < share <= _BAD:
        leaves = "between 10 and 30 % AIAG leaves it to the use and its cost"
        yield readings.note(f"R&R is {share:.0%} of {of}: {leaves}")
    named: tuple[ComponentName, ...] = ("AV", "INT", "PV")
    estimated = {name: figures.components[name] for name in named if name in figures.components}
    zero = [name for name, one in estimated.items() if one.sigma == 0]
    if zero:
        yield readings.note(f"{', '.join(zero)}: estimated below 0, taken as 0")


def _of_linearity(readings: GaugeReadings, figures: Linearity) -> Iterator[Remark]:
    if not figures.holds_zero:
        yield readings.warn(
            "the line of the bias leaves 0 within the range (AIAG): the dial is not linear there, "
            "or reads beside"
        )
    if len(figures.references) < 5:
        yield readings.note(f"{len(figures.references)} references; five are usual")


def _of_stability(readings: GaugeReadings, figures: Stability) -> Iterator[Remark]:
    if figures.outside:
        yield readings.warn(f"outside the limits: {', '.join(figures.outside)}")
    if figures.trend_p_value is not None and figures.trend_p_value < _LEVEL:
        by = f"{figures.trend:.2g} {readings.unit} a session (p = {figures.trend_p_value:.2g})"
        yield readings.warn(f"the mean moves by {by}")
    if len(figures.sessions) < 20:
        yield readings.note(f"{len(figures.sessions)} sessions; limits settle with 20")


_REMARKS: Mapping[type, Callable[[GaugeReadings, Any], Iterator[Remark]]] = {
    TypeOne: _of_type_1,
    Crossed: _of_crossed,
    Linearity: _of_linearity,
    Stability: _of_stability,
}
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
        fill(self, criteria=criteria, conformity=gravest(one.verdict for one in criteria))

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
        remarks=(*tables.remarks, *dict.fromkeys(found)),
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
    match kind:
        case StudyKind.TYPE_1:
            figures = type_1(readings, tolerance, rng)
        case StudyKind.LINEARITY:
            figures = linearity(readings, tolerance, rng)
        case StudyKind.STABILITY:
            figures = stability(readings)
        case _:
            figures = crossed(readings, tolerance, rng)
    criteria = tuple(_criteria(readings, figures, tolerance, decision)) if tolerance else ()
    return AxisStudy(kind, readings, tolerance, figures, criteria)


def _criteria(
    readings: GaugeReadings, figures: Figures, tolerance: float, decision: DecisionRule
) -> Iterator[Criterion]:
    criterion = partial(Criterion, axis=readings.axis, decision=decision)
    if readings.resolution is not None:
        share = readings.resolution / tolerance
        yield criterion("resolution/T", _VDA, value=share, interval=None, limit=0.05)
    match figures:
        case TypeOne(Cg_interval=Cg_ends, Cgk_interval=Cgk_ends):
            wanted = partial(criterion, of=_BOSCH, limit=1.33, at_least=True)
            yield wanted("Cg", value=figures.Cg, interval=Cg_ends)
            if figures.bias is not None:
                yield wanted("Cgk", value=figures.Cgk, interval=Cgk_ends)
        case Crossed(ndc_raw=ndc, ndc_interval=ends):
            whole = figures.components["GRR"]
            yield criterion(
                "R&R/T",
                _AIAG,
                value=whole.of_tolerance or None,  # of no scatter nothing is known
                interval=whole.of_tolerance_interval,
                limit=_BAD,
                conditional_above=_GOOD,
            )
            yield criterion("ndc", _AIAG, value=ndc, interval=ends, limit=5, at_least=True)
        case Stability():
            outside = float(len(figures.outside)) if figures.sigma > 0 else None
            yield criterion("sessions outside", _AIAG, value=outside, interval=None, limit=0)
    if not isinstance(figures, Stability):
        Q = figures.budget
        value = Q.Q if Q.holds_scatter else None
        yield criterion(f"Q_{Q.of}", _VDA, value=value, interval=Q.Q_interval, limit=Q.limit)
