"""What ``fleet`` publishes: schemas ``scara-iso/fleet/1`` and ``scara-iso/fleet-figures/1``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from scara_iso.base.published import Count, publish
from scara_iso.fleets.drift import QUANTILES
from scara_iso.fleets.runs import FleetRun
from scara_iso.fleets.summary import (
    FleetFigures,
    FleetRemarks,
    FleetSummary,
    RobotFigures,
    RobotFinding,
)

Five: TypeAlias = Annotated[tuple[float, ...], ("minItems", 5), ("maxItems", 5)]


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedParts:
    """What became of the parts of the source."""

    count: Count
    """How many there are."""
    done_before: Count
    """By an earlier run."""
    failed: Mapping[str, str]
    """Those that could not be read or were given up, with why."""


@dataclass(frozen=True, kw_only=True)
class DiagnosedFleet:
    """Robots by how far they stand out, effects by how many robots show them."""

    schema: Literal["scara-iso/fleet/1"]
    """Name and number of this schema."""
    unit: Literal["mm"]
    """Of every length."""
    folder: str
    """Where the results stand."""
    parts: PublishedParts
    """What became of them."""
    tables: Count
    """How many were diagnosed."""
    false_discovery_rate: float
    """At which robots are named."""
    found_too_coarse: bool
    """Whether a robot may be ill and too little was drawn to name it."""
    effects: Mapping[str, Count]
    """Robots that are named, by effect, the most frequent first."""
    RP_quantiles: Mapping[str, Five]
    """By figure, of the tables [mm, deg]."""
    quantiles: tuple[float, ...]
    """Which these are."""
    robots: tuple[RobotFinding, ...]
    """The worst first."""


@dataclass(frozen=True, kw_only=True)
class MeasuredFleet:
    """The figures of a fleet, without a diagnosis."""

    schema: Literal["scara-iso/fleet-figures/1"]
    """Name and number of this schema."""
    unit: Literal["mm"]
    """Of every length."""
    folder: str
    """Where the results stand."""
    files: str
    """Folder of the figures of every pose, as Parquet."""
    parts: PublishedParts
    """What became of them."""
    tables: Count
    """How many have figures."""
    robots: Count
    """How many there are of these."""
    RP_quantiles: Mapping[str, Five]
    """By figure, of the poses [mm, deg]."""
    quantiles: tuple[float, ...]
    """Which these are."""
    worst: Annotated[tuple[RobotFigures, ...], ("maxItems", 100)]
    """By the largest RP of a pose."""


@dataclass(frozen=True, kw_only=True)
class PublishedFleet(FleetRemarks, DiagnosedFleet):
    """``fleet`` of the robots of a source."""


@dataclass(frozen=True, kw_only=True)
class PublishedFleetFigures(FleetRemarks, MeasuredFleet):
    """``fleet`` of the figures alone."""


def published_fleet(found: FleetSummary) -> PublishedFleet:
    """Return what ``fleet`` says: every robot is in it."""
    return publish(
        PublishedFleet,
        found,
        schema="scara-iso/fleet/1",
        unit="mm",
        folder=str(found.run.folder),
        parts=_parts(found.run),
        false_discovery_rate=found.level,
        found_too_coarse=found.too_coarse,
        quantiles=QUANTILES,
        robots=tuple(publish(RobotFinding, one) for one in found.robots),
    )


def published_fleet_figures(found: FleetFigures) -> PublishedFleetFigures:
    """Return what ``fleet`` says of figures alone."""
    return publish(
        PublishedFleetFigures,
        found,
        schema="scara-iso/fleet-figures/1",
        unit="mm",
        folder=str(found.run.folder),
        files=str(found.files),
        parts=_parts(found.run),
        quantiles=QUANTILES,
    )


def _parts(run: FleetRun) -> PublishedParts:
    return PublishedParts(count=run.parts, done_before=run.before, failed=run.failed)
