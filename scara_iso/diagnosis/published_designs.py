"""What ``diagnose`` publishes of a plan: ``scara-iso/design/1``, ``scara-iso/design-poses/1``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from scara_iso.base.published import Count, Size, publish
from scara_iso.diagnosis.planning import (
    Alike,
    ChangeOfPoses,
    Design,
    DesignOfPoses,
    PlannedPosesTest,
    PlannedRun,
    Smallest,
)
from scara_iso.diagnosis.separating import PosesApart

Travels: TypeAlias = Mapping[str, Size | None]
"""By effect; None where not even a large one is found."""


@dataclass(frozen=True, kw_only=True)
class AlikeEffects:
    """Two effects that can have one course."""

    effects: tuple[str, str]
    """Which."""
    cosine: float
    """Of their courses: 1 where they are one."""


@dataclass(frozen=True, kw_only=True)
class ChangedPlan:
    """Another plan."""

    change: str
    """What is changed."""
    smallest: Travels
    """Travel that it finds in 80 % of tests, by effect, in mm."""


@dataclass(frozen=True, kw_only=True)
class PublishedDesign:
    """What a planned test of one pose will be able to tell."""

    schema: Literal["scara-iso/design/1"]
    """Name and number of this schema."""
    unit: Literal["mm"]
    """Of every length."""
    cycles: Count
    """That count."""
    sigma: Size
    """Standard deviation of the readings."""
    resolution: Size
    """Of the dial; 0 for none."""
    columns: tuple[str, ...]
    """That are recorded."""
    smallest: Travels
    """Travel, lowest to highest reading, found in 80 % of tests, by effect; null: none is."""
    alike: tuple[AlikeEffects, ...]
    """What it cannot tell apart."""
    changes: tuple[ChangedPlan, ...]
    """What would find more."""


@dataclass(frozen=True, kw_only=True)
class PlannedScatter:
    """A standard deviation."""

    value: Size
    """In `unit`."""
    unit: Literal["rad", "mm"]
    """`rad` of a joint."""


@dataclass(frozen=True, kw_only=True)
class ChangedPosesPlan:
    """Another plan, and the gain."""

    change: str
    """What is changed."""
    smallest: Mapping[str, Travels]
    """As of the plan."""
    joints_apart: PosesApart
    """How well its poses tell the joints apart."""
    size_needed: Mapping[str, Size]
    """Size found and told from the other joint, over that of the plan, by joint."""
    adds: tuple[str, ...]
    """Effects that only it tells."""


@dataclass(frozen=True, kw_only=True)
class PublishedPosesDesign:
    """What a planned test of several poses will be able to tell of the joints."""

    schema: Literal["scara-iso/design-poses/1"]
    """Name and number of this schema."""
    unit: Literal["rad"]
    """Of every size in a joint."""
    cycles: Count
    """That count."""
    poses: tuple[str, ...]
    """Their names."""
    resolution_mm: tuple[Size, Size]
    """Of X and Y."""
    columns: tuple[str, ...]
    """That are recorded."""
    scatter: Mapping[str, PlannedScatter]
    """Of `joint 1`, `joint 2`, and the `dial` itself."""
    seen_in_a_cycle: Mapping[str, Annotated[float, ("unit", "rad"), ("minimum", 0)]]
    """Scatter of a joint's angle as all poses of one cycle show it."""
    smallest: Mapping[str, Travels]
    """Travel found in 80 % of tests, in rad, by joint and effect; null: none is."""
    joints_apart: PosesApart
    """How well the poses tell the joints apart."""
    alike: tuple[AlikeEffects, ...]
    """What it cannot tell apart."""
    changes: tuple[ChangedPosesPlan, ...]
    """What would help, the largest gain first."""


def published_design(plan: PlannedRun, found: Design) -> PublishedDesign:
    """Return what a planned test will tell."""
    return PublishedDesign(
        schema="scara-iso/design/1",
        unit="mm",
        cycles=len(plan.conditions),
        sigma=plan.sigma,
        resolution=plan.division,
        columns=tuple(plan.conditions.covariates),
        smallest=_travels(found.smallest),
        alike=_alike(found.alike),
        changes=tuple(
            ChangedPlan(change=one.change, smallest=_travels(one.smallest)) for one in found.changes
        ),
    )


def published_poses_design(plan: PlannedPosesTest, found: DesignOfPoses) -> PublishedPosesDesign:
    """Return what a planned test of poses will tell."""
    return PublishedPosesDesign(
        schema="scara-iso/design-poses/1",
        unit="rad",
        cycles=len(plan.conditions),
        poses=tuple(plan.joints_deg),
        resolution_mm=plan.division,
        columns=tuple(plan.conditions.covariates),
        scatter={
            name: PlannedScatter(value=value, unit="mm" if name == "dial" else "rad")
            for name, value in plan.sources.items()
        },
        seen_in_a_cycle=plan.sigma,
        smallest=_by_joint(found.smallest),
        joints_apart=found.apart,
        alike=_alike(found.alike),
        changes=tuple(map(_changed, found.changes)),
    )


def _changed(found: ChangeOfPoses) -> ChangedPosesPlan:
    smallest = _by_joint(found.smallest)
    return publish(ChangedPosesPlan, found, smallest=smallest, joints_apart=found.apart)


def _by_joint(found: Mapping[str, Iterable[Smallest]]) -> dict[str, Travels]:
    return {joint: _travels(own) for joint, own in found.items()}


def _travels(found: Iterable[Smallest]) -> Travels:
    return {one.effect: one.travel for one in found}


def _alike(found: Iterable[Alike]) -> tuple[AlikeEffects, ...]:
    return tuple(AlikeEffects(effects=(a.first, a.second), cosine=a.cosine) for a in found)
