"""What ``demo`` publishes of the paper's robot: schema ``scara-iso/demo/1``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from scara_iso.base.published import Size
from scara_iso.diagnosis import PublishedBacklash, published_backlash
from scara_iso.iso9283 import Analysis, Millimetres, PublishedAnalysis, published_analysis
from scara_iso.robot import (
    PRINTED_DEVIATION_MM,
    PRINTED_FREE_PLAY_MM,
    PRINTED_RP_MM,
    PRINTED_XY_MM,
    Backlash,
)
from scara_iso.run import AxisKey


@dataclass(frozen=True, slots=True, kw_only=True)
class PrintedFigures:
    """What the paper prints."""

    RP: Mapping[AxisKey, Size]
    """By axis, of Table I: lengths in mm, theta in degrees."""
    RP_rss: Millimetres
    """Eq. 23."""
    deviation_mm: Millimetres
    """Eq. 21."""
    free_play_mm: Millimetres
    """Eq. 22."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedDemo:
    """The paper's Table I and first joint."""

    schema: Literal["scara-iso/demo/1"]
    """Name and number of this schema."""
    analysis: PublishedAnalysis
    """Of Table I, as in `analyze`."""
    backlash: PublishedBacklash
    """Of the first joint, as in `backlash`."""
    printed: PrintedFigures
    """To be set beside those figures."""


def published_demo(table_1: Analysis, gear: Backlash) -> PublishedDemo:
    """Return what ``demo`` says of the paper's Table I and first joint."""
    return PublishedDemo(
        schema="scara-iso/demo/1",
        analysis=published_analysis(table_1),
        backlash=published_backlash(gear, table_1.poses[0]),
        printed=PrintedFigures(
            RP=PRINTED_RP_MM,
            RP_rss=PRINTED_XY_MM,
            deviation_mm=PRINTED_DEVIATION_MM,
            free_play_mm=PRINTED_FREE_PLAY_MM,
        ),
    )
