"""What ``backlash`` publishes: schema ``scara-iso/backlash/1``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from scara_iso.base.published import Size, publish
from scara_iso.diagnosis.published import PublishedGear, of_gear
from scara_iso.diagnosis.sweeps import GearDiagnosis
from scara_iso.iso9283 import PoseResult
from scara_iso.robot import Backlash
from scara_iso.run import FloatArray

_CROSSING = ("load_deviation_rad", "inertia_ratio", "deviation_mm")


@dataclass(frozen=True, kw_only=True)
class Gap:
    """The gap of a gear."""

    schema: Literal["scara-iso/backlash/1"]
    """Name and number of this schema."""
    gap_rad: Size
    """The full gap 2D, eq. 18."""


@dataclass(frozen=True, kw_only=True)
class RotorThroughGear:
    """The rotor as the output shaft sees it."""

    ratio: float
    """Gear ratio N."""
    motor_inertia: Size
    """N² I_m, in kg m²."""


@dataclass(frozen=True, kw_only=True)
class LoadCrossing:
    """What the load does when the gear crosses the gap."""

    load_deviation_rad: float
    """Eq. 16."""
    inertia_ratio: Size
    """Gap over load deviation, eq. 20."""
    deviation_mm: Size | None
    """At the end of the arm, eq. 21; null without an arm."""


@dataclass(frozen=True, kw_only=True)
class ReflectedCrossing(LoadCrossing, RotorThroughGear):
    """The same with the rotor seen through the gear."""


@dataclass(frozen=True, kw_only=True)
class BacklashOfModel(LoadCrossing, Gap):
    """The paper's two-inertia model, the rotor as given."""

    arm_m: Size | None
    """From the joint to the tool; null where not given."""
    free_play_mm: Size | None
    """The whole gap at the end of the arm, eq. 22; null without an arm."""
    reflected: ReflectedCrossing | None
    """Null without a gear ratio."""


@dataclass(frozen=True, kw_only=True)
class PublishedBacklash(BacklashOfModel):
    """The paper's two-inertia model, and a pose that was measured."""

    actual: PoseResult | None = None
    """The measured pose beside the model, as in `analyze`."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SweepSeries:
    """Reversals in the order of the sweep."""

    measured: FloatArray
    """In rad."""
    predicted_before: FloatArray
    """By eq. 16."""
    predicted_after: FloatArray
    """With the effects found."""


@dataclass(frozen=True, kw_only=True)
class BacklashAndSweep(PublishedGear, PublishedBacklash):
    """The model, and what it leaves unexplained of a measured sweep, in rad."""

    series: SweepSeries
    """Measured and predicted."""
    notes: tuple[str, ...]
    """What could not be tried."""


def published_backlash(
    found: Backlash, actual: PoseResult | None = None, closed: GearDiagnosis | None = None
) -> PublishedBacklash:
    """Return what ``backlash`` says: of a measured pose too, and of a sweep what is unexplained."""
    reflected, ratio = found.reflected, found.ratio
    said: dict[str, Any] = {
        **{name: getattr(found, name) for name in ("gap_rad", "arm_m", "free_play_mm")},
        **{name: getattr(found.as_given, name) for name in _CROSSING},
        "schema": "scara-iso/backlash/1",
        "reflected": reflected and publish(ReflectedCrossing, reflected, ratio=ratio),
        "actual": actual,
    }
    if closed is None:
        return PublishedBacklash(**said)
    return of_gear(BacklashAndSweep, closed, series=publish(SweepSeries, closed), **said)


PUBLISHED = (PublishedBacklash, BacklashAndSweep)
"""The objects of ``backlash``."""
