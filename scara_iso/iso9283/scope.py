"""What of ISO 9283 a test does not give: what no dial measures, and what this one lacks."""

from __future__ import annotations

from dataclasses import dataclass

from scara_iso.iso9283.characteristics import find_clauses, needs
from scara_iso.iso9283.results import Analysis


@dataclass(frozen=True, slots=True)
class NotMeasured:
    """A characteristic that a test does not give, with its clause, and why."""

    name: str
    clause: str
    why: str


# Clauses as the contents of ISO 9283:1998 name them.
BEYOND_DIALS = (
    NotMeasured(
        "distance accuracy AD beyond a dial's range",
        "7.3",
        "a dial measures no length beyond its own travel: use a laser tracker or a scale",
    ),
    NotMeasured("path accuracy AT", "8.2", "a dial rests at one place and follows no path"),
    NotMeasured(
        "path repeatability RT", "8.3", "a dial follows no path: use a tracking instrument"
    ),
    NotMeasured("path accuracy on reorientation", "8.4", "likewise"),
    NotMeasured("cornering deviations", "8.5", "a dial follows no path, nor a corner between two"),
    NotMeasured(
        "path velocity characteristics", "8.6", "a dial does not measure speed along a path"
    ),
    NotMeasured(
        "minimum posing time",
        "9",
        "it begins when the robot leaves one pose; the dial is at the other",
    ),
    NotMeasured("weaving deviations", "11", "a dial follows no path"),
)
"""What dials at a pose cannot measure, by clause."""


def not_measured(analysis: Analysis) -> tuple[NotMeasured, ...]:
    """Return each characteristic that these readings do not give, with what it would need.

    Those that dials can measure by name of their file, then `BEYOND_DIALS`.
    """
    there = {one.code for one in analysis.characteristics}
    lacking = (
        NotMeasured(code, find_clauses()[code], f"needs {needed}")
        for code, needed in needs().items()
        if code not in there
    )
    return (*lacking, *BEYOND_DIALS)
