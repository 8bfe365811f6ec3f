"""What ``gauge-study`` publishes of a study: schema ``scara-iso/gauge-study/1``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias, cast

from scara_iso.base.published import Interval, Unit, publish
from scara_iso.gauge.budget import Budget
from scara_iso.gauge.crossed import Crossed, CrossedFigures
from scara_iso.gauge.reference_parts import (
    Linearity,
    LinearityFigures,
    Stability,
    TypeOne,
    TypeOneFigures,
)
from scara_iso.gauge.study import AxisStudy, GaugeStudy, StudyKind
from scara_iso.gauge.table import Remark
from scara_iso.iso9283 import Conformity, DecisionRule
from scara_iso.run import FloatArray

Origin: TypeAlias = Literal["u_CAL", "u_RE", "u_EVR", "u_EVO", "u_BI", "u_LIN", "u_AV", "u_IA"]


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedBudget:
    """The standard uncertainties by VDA 5, in the readings' unit."""

    of: Literal["MS", "MP"]
    """The measuring system, or the process of measuring, operators included."""
    u: float
    """Of all parts together."""
    U: float
    """2 u."""
    interval: Interval
    """95 %, of U: by the chance of the readings."""
    Q: float | None
    """Capability ratio 2 U / T; null without a tolerance."""
    Q_interval: Interval | None
    """95 %."""
    Q_limit: float
    """Largest Q that VDA 5 recommends."""
    C: float | None
    """Capability index, 1.33 where Q is at its limit; null without a tolerance or scatter."""
    smallest_tolerance: float
    """Tolerance for which Q is just at its limit."""
    conformity_zone: float | None
    """T - 2 U: the width within which a reading proves conformity, 0 for none; null without a
    tolerance."""
    parts: Mapping[Origin, float]
    """Certificate, division, repeatability on the reference and on parts, bias, linearity,
    operators, part x operator."""
    missing: tuple[Origin, ...]
    """What this study cannot tell, and nothing states."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PublishedAxisStudy:
    """The study of one dial; of its figures those of its kind are there."""

    kind: StudyKind
    """By the columns of its table."""
    unit: Unit
    """Of every size here."""
    readings: FloatArray
    """What the dial showed."""
    resolution: float | None
    """The dial's division; null where not stated."""
    uncertainty: float | None
    """Standard uncertainty of the dial, from its certificate; null where not stated."""
    tolerance: float | None
    """Width of the tolerance; null where not stated."""
    type_1: TypeOneFigures | None = None
    """One part of known size, read again and again."""
    crossed: CrossedFigures | None = None
    """Types 2 and 3: parts, read several times by operators or a machine."""
    linearity: LinearityFigures | None = None
    """Parts of several known sizes."""
    stability: Stability | None = None
    """One part in several sessions."""
    uncertainty_budget: PublishedBudget | None
    """Null for a stability study."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedCriterion:
    """One figure against the limit of a guideline."""

    axis: str
    """Whose dial."""
    criterion: str
    """`Cg`, `Cgk`, `resolution/T`, `Q_MS`, `R&R/T`, `ndc` and the like."""
    of: str
    """The guideline."""
    value: float | None
    """Null where the readings give none."""
    interval: Interval | None
    """95 %; null where it has none."""
    limit: float
    """What the guideline asks for."""
    at_least: bool
    """Whether the figure must be at least the limit; else at most."""
    verdict: Conformity
    """What the rule makes of it."""
    is_conditional: bool
    """It passes in the band that the guideline leaves to the use and its cost (AIAG: R&R of 10 to
    30 %)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedGaugeStudy:
    """``gauge-study`` of one or several tables."""

    schema: Literal["scara-iso/gauge-study/1"]
    """Name and number of this schema."""
    source: str
    """Names of the tables."""
    notes: tuple[str, ...]
    """What of the tables was not used."""
    metadata: Mapping[str, str]
    """What the tables state."""
    decision: DecisionRule
    """Whether the figure itself decides, or its interval."""
    axes: Mapping[str, PublishedAxisStudy]
    """By name."""
    criteria: tuple[PublishedCriterion, ...]
    """What the guidelines ask; none without a tolerance."""
    conformity: Conformity | None
    """The gravest verdict; null where no tolerance is stated."""
    findings: tuple[Remark, ...]
    """What is to be known beside the figures."""


def published_gauge_study(found: GaugeStudy) -> PublishedGaugeStudy:
    """Return what ``gauge-study`` says."""
    return PublishedGaugeStudy(
        schema="scara-iso/gauge-study/1",
        source=found.source,
        notes=found.notes,
        metadata=found.statements,
        decision=found.decision,
        axes={name: _axis(one) for name, one in found.axes.items()},
        criteria=tuple(
            publish(PublishedCriterion, one, criterion=one.name) for one in found.criteria
        ),
        conformity=found.conformity,
        findings=found.remarks,
    )


def _axis(study: AxisStudy) -> PublishedAxisStudy:
    readings, figures = study.readings, study.figures
    return PublishedAxisStudy(
        kind=study.kind,
        unit=cast(Unit, readings.unit),
        readings=readings.values,
        resolution=readings.resolution,
        uncertainty=readings.uncertainty,
        tolerance=study.tolerance,
        type_1=publish(TypeOneFigures, figures) if isinstance(figures, TypeOne) else None,
        crossed=publish(CrossedFigures, figures) if isinstance(figures, Crossed) else None,
        linearity=publish(LinearityFigures, figures) if isinstance(figures, Linearity) else None,
        stability=figures if isinstance(figures, Stability) else None,
        uncertainty_budget=None if study.budget is None else _budget(study.budget),
    )


def _budget(found: Budget) -> PublishedBudget:
    return publish(
        PublishedBudget,
        found,
        Q_limit=found.limit,
        conformity_zone=found.zone,
        parts={f"u_{name}": part for name, part in found.parts.items()},
        missing=tuple(f"u_{name}" for name in found.missing),
    )
