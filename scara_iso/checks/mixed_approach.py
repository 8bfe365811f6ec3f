"""The pose was approached from both sides.

With arrivals from both sides the gap and the wind-up of the drive enter the figure; a
unidirectional figure of a catalogue is not comparable. ``analyze --definitions`` gives ISO 230-2's
figures for each direction and the reversal.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.results import Finding, Measured

CODE = "mixed-approach"


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a note where the column ``approach`` takes both signs."""
    approach = measured.run.covariates.get("approach")
    if approach is not None and approach.min() < 0 < approach.max():
        yield Finding(
            CODE,
            "info",
            "the pose is approached from both sides: RP includes the reversal; --definitions "
            "gives each direction",
        )
