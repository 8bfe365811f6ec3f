"""Which study the readings of a dial are, its figures, and what a tolerance makes of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from scara_iso.display import Plotted
from scara_iso.frames import frame_of
from scara_iso.iso9283 import Conformity, DecisionRule
from scara_iso.measurement_system.budget import Budget
from scara_iso.measurement_system.criteria import Criterion, worst
from scara_iso.measurement_system.crossed import Crossed, crossed
from scara_iso.measurement_system.linearity import Linearity, linearity
from scara_iso.measurement_system.readings import GaugeReadings, Remark
from scara_iso.measurement_system.remarks import study_remarks
from scara_iso.measurement_system.stability import Stability, stability
from scara_iso.measurement_system.table import GaugeTables
from scara_iso.measurement_system.type_1 import TypeOne, type_1
from scara_iso.published import Interval

if TYPE_CHECKING:
    import pandas as pd

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
    readings: GaugeReadings
    """What it was made of."""
    tolerance: float | None
    """Width of the tolerance [mm, deg]; None where not stated."""
    figures: Figures
    """Those of its kind."""
    criteria: tuple[Criterion, ...]
    """What the guidelines ask; none without a tolerance."""

    @property
    def budget(self) -> Budget | None:
        """The uncertainties by VDA 5; None of a stability study."""
        return None if isinstance(self.figures, Stability) else self.figures.budget


@dataclass(frozen=True, eq=False, slots=True)
class GaugeStudy(Plotted):
    """The studies of the dials of one or several tables."""

    axes: Mapping[str, AxisStudy]
    """By axis."""
    remarks: tuple[Remark, ...]
    """What is to be known beside the figures."""
    decision: DecisionRule
    """Whether the figure itself decides, or its interval."""
    statements: Mapping[str, str]
    """``# key: value`` lines of the tables."""
    source: str
    """Names of the tables."""
    notes: tuple[str, ...] = ()
    """What of the tables was not used."""

    @property
    def criteria(self) -> tuple[Criterion, ...]:
        """Those of every axis."""
        return tuple(one for axis in self.axes.values() for one in axis.criteria)

    @property
    def conformity(self) -> Conformity | None:
        """The gravest verdict; None where no tolerance is stated."""
        return worst(self.criteria)

    def __repr__(self) -> str:
        kinds = ", ".join(f"{name} {one.kind.value}" for name, one in self.axes.items())
        return f"<GaugeStudy of {self.source}: {kinds}>"

    def to_frame(self) -> pd.DataFrame:
        """Return the criteria as a pandas table, a row for each."""
        rows = [
            {
                "axis": c.axis,
                "criterion": c.name,
                "of": c.of,
                "value": c.value,
                "limit": c.limit,
                "verdict": c.verdict.value,
            }
            for c in self.criteria
        ]
        return frame_of(rows, {})


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
            yield criterion("R&R/T", _AIAG, whole.of_tolerance, whole.of_tolerance_interval, 0.3)
            yield criterion("ndc", _AIAG, figures.ndc_raw, figures.ndc_interval, 5, at_least=True)
        case Stability():
            yield criterion("sessions outside", _AIAG, float(len(figures.outside)), None, 0)
    if not isinstance(figures, Stability):
        Q = figures.budget
        yield criterion(f"Q_{Q.of}", _VDA, Q.Q, Q.Q_interval, Q.limit)
