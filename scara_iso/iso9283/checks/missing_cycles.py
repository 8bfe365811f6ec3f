"""Cycles are missing from the table.

With ``allow_gaps=True`` the cycles that are there count. A cycle that is missing may be missing
because of what was seen in it: say why, or repeat the test.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283.cycles import name_gap
from scara_iso.iso9283.results import Finding, Measured

CODE = "missing-cycles"
BRIEF = "cycles missing"
_MOST = 10


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for each pose that lacks cycles."""
    for pose in measured.poses:
        if pose.missing:
            named = [name_gap(first, last) for first, last in pose.missing]
            more = f" and {len(named) - _MOST} more gaps" if len(named) > _MOST else ""
            yield Finding(
                CODE,
                "warning",
                f"{', '.join(named[:_MOST])} missing{more}; the others are used",
                pose=pose.label,
                rule="ISO 9283 6.9: 30 cycles",
            )
