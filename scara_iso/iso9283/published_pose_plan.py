"""What ``plan`` publishes of a planned test: schema ``scara-iso/plan/1``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from scara_iso.base.published import Count, publish
from scara_iso.iso9283.poses import (
    Coordinate,
    DiagonalPlane,
    Kilograms,
    PlannedVisit,
    PosePlan,
    Solid,
)
from scara_iso.robot import Elbow

Length: TypeAlias = Annotated[float, ("unit", "mm"), ("minimum", 0)]
Corner: TypeAlias = tuple[Coordinate, Coordinate, Coordinate]


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedRated:
    """What the percentages are of; null where the model does not state it."""

    load_kg: Kilograms | None
    """Rated load."""
    velocity_mm_s: Annotated[float, ("unit", "mm/s")] | None
    """Of the tool along a line."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedCycles:
    """How many cycles are planned."""

    run: Count
    """All of them."""
    used: Count
    """Those of which the readings count."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearVisit(PlannedVisit):
    """One visit, on a line of the tool."""

    path: Literal["linear"]
    """A line of the tool."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedPlan:
    """``plan`` of the poses of ISO 9283."""

    schema: Literal["scara-iso/plan/1"]
    """Name and number of this schema."""
    unit: Literal["mm"]
    """Of every length."""
    solid: Solid
    """What is laid into the workspace."""
    size_mm: tuple[Length, Length, Length]
    """Edges along x, y and z."""
    corners: Annotated[tuple[Corner, ...], ("minItems", 8), ("maxItems", 8)]
    """C1 to C8."""
    plane: DiagonalPlane
    """The diagonal plane that holds the poses."""
    elbow: Elbow
    """Side of the elbow at every pose."""
    diagonal_mm: Length
    """L of eq. 1."""
    m_mm: Length
    """Distance of P2 to P5 from their corners, along the diagonal."""
    stroke_limits: bool
    """Whether a larger cube would fit if the stroke were longer."""
    rated: PublishedRated
    """Load and velocity."""
    cycles: PlannedCycles
    """Of each pose."""
    visits: tuple[LinearVisit, ...]
    """One cycle, in order."""


def published_plan(found: PosePlan) -> PublishedPlan:
    """Return what ``plan`` says."""
    return publish(
        PublishedPlan,
        found,
        schema="scara-iso/plan/1",
        unit="mm",
        corners=found.corners.tolist(),
        rated=publish(PublishedRated, found.rated),
        cycles=PlannedCycles(run=found.conditions.cycles, used=found.conditions.used),
        visits=tuple(publish(LinearVisit, one) for one in found.visits()),
    )
