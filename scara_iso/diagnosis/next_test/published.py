"""What ``plan`` publishes of separating poses: schema ``scara-iso/plan-separating/1``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from scara_iso.base.published import publish
from scara_iso.diagnosis.next_test.separating import PosesApart, SeparatingPlan
from scara_iso.iso9283 import PlannedCycles, PlannedVisit, PublishedRated
from scara_iso.robot import Elbow


@dataclass(frozen=True, slots=True, kw_only=True)
class SetsApart:
    """How well sets of poses tell the movements apart."""

    proposed: PosesApart
    """Those of this plan."""
    given: PosesApart | None = None
    """Those of the model, where there are any."""
    standard: PosesApart | None = None
    """Those of ISO 9283's cube, where there is one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class JointVisit(PlannedVisit):
    """One visit, the joints turn to it."""

    path: Literal["joint"]
    """The joints turn."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedSeparatingPlan:
    """``plan`` of poses that tell the joints apart."""

    schema: Literal["scara-iso/plan-separating/1"]
    """Name and number of this schema."""
    unit: Literal["mm"]
    """Of every length."""
    elbow: Elbow
    """Side of the elbow at every pose."""
    apart: SetsApart
    """These poses, and others beside them."""
    rated: PublishedRated
    """Load and velocity."""
    cycles: PlannedCycles
    """Of each pose."""
    visits: tuple[JointVisit, ...]
    """One cycle, in order."""


def published_separating_plan(found: SeparatingPlan) -> PublishedSeparatingPlan:
    """Return what ``plan`` says of separating poses."""
    return PublishedSeparatingPlan(
        schema="scara-iso/plan-separating/1",
        unit="mm",
        elbow=found.elbow,
        apart=SetsApart(**found.apart),
        rated=publish(PublishedRated, found.rated),
        cycles=PlannedCycles(run=found.conditions.cycles, used=found.conditions.used),
        visits=tuple(publish(JointVisit, one) for one in found.visits()),
    )
