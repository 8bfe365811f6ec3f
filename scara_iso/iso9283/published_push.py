"""What ``push`` publishes of a push test: schema ``scara-iso/push/1``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias, TypeVar

from scara_iso.base.published import Count, Interval, Size, publish
from scara_iso.iso9283.figures import Conformity, Millimetres
from scara_iso.iso9283.pushed_joint import PushResult
from scara_iso.iso9283.results import Characteristic, LimitCheck

PushUnit: TypeAlias = Literal["mm", "mm/100 N", "N", "arcmin", "N m", "N m/arcmin"]
ForceEnds: TypeAlias = Annotated[Interval, ("unit", "N")]


@dataclass(frozen=True, slots=True, kw_only=True)
class PushFigure:
    """A figure of the loop."""

    value: Size
    """In `unit`."""
    unit: PushUnit
    """Of value, u and interval."""
    u: Size
    """Standard uncertainty."""
    interval: Interval | None
    """95 %; null for a stiffness whose compliance may be none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopFigures:
    """What joint and reading both have; `scara-iso explain` explains each."""

    lost_motion: PushFigure
    """Play, without friction."""
    friction_width: PushFigure
    """Width of the loop by friction."""
    hysteresis: PushFigure
    """Width of the loop in all."""
    deflection: PushFigure
    """Between the two ends of the loop."""


@dataclass(frozen=True, slots=True, kw_only=True)
class JointFigures(LoopFigures):
    """The joint, by the arm."""

    friction_torque: PushFigure
    """Coulomb's friction, one side."""
    stiffness: PushFigure
    """Torque per angle, along a branch."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadingFigures(LoopFigures):
    """The reading."""

    compliance: PushFigure
    """Displacement per force, along a branch."""
    friction_force: PushFigure
    """Coulomb's friction, one side."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PushReadings:
    """How many readings the loop has."""

    read: Count
    """Readings in the table."""
    run_in: Count
    """Before the first end of the loop, not counted."""
    used: Count
    """Readings that count."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedPush:
    """``push`` of a force loop."""

    schema: Literal["scara-iso/push/1"]
    """Name and number of this schema."""
    unit: Literal["mm"]
    """Of every length."""
    source: str
    """The file."""
    notes: tuple[str, ...]
    """How it was read."""
    arm_m: Annotated[float, ("unit", "m"), ("exclusiveMinimum", 0)] | None
    """From the joint to the dial and to the force; null where not stated."""
    loops: Count
    """Number of loops."""
    readings: PushReadings
    """For all loops."""
    force_N: ForceEnds  # noqa: N815 - newton
    """Lowest and highest."""
    residual_mm: Millimetres
    """Standard deviation of what is left beside the model."""
    misfit_mm: Millimetres | None
    """What all loops repeat and the model does not, rms; null where that is chance."""
    joint: JointFigures | None
    """Null without an arm."""
    reading: ReadingFigures
    """Of the dial, by the same codes."""
    characteristics: tuple[Characteristic, ...]
    """Every figure of the test."""
    limits: tuple[LimitCheck, ...]
    """One for each figure that was held against a limit."""
    conformity: Conformity | None
    """Of all limits together, the gravest; null where none was given."""


Figures = TypeVar("Figures", bound=LoopFigures)


def published_push_test(found: PushResult) -> PublishedPush:
    """Return what ``push`` says."""
    fit = found.fit
    read = len(found.loop.force)
    return PublishedPush(
        schema="scara-iso/push/1",
        unit="mm",
        source=found.loop.source,
        notes=found.loop.notes,
        arm_m=found.arm_m,
        loops=fit.loops,
        readings=PushReadings(read=read, run_in=fit.run_in, used=fit.readings),
        force_N=fit.ends,
        residual_mm=fit.residual,
        misfit_mm=fit.misfit,
        joint=None if found.arm_m is None else _figures(JointFigures, found, "joint"),
        reading=_figures(ReadingFigures, found, "reading"),
        characteristics=found.characteristics,
        limits=found.limits,
        conformity=found.conformity,
    )


def _figures(kind: type[Figures], found: PushResult, of: str) -> Figures:
    of_it = [one for one in found.characteristics if one.of == of]
    return kind(**{one.code: publish(PushFigure, one.estimate) for one in of_it})
