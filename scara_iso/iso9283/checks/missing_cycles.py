"""Cycles are missing from the table.

With ``allow_gaps=True`` the cycles that are there count. A cycle may be missing because
its reading was not wanted: state why, or repeat the test.
"""

from scara_iso.iso9283.core.cycles import name_gap
from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "missing-cycles"
BRIEF = "cycles missing"
_MOST = 10


def check(measured: Measured) -> Findings:
    """Yield a warning for each pose that lacks cycles."""
    for pose in measured.poses:
        named = [name_gap(first, last) for first, last in pose.missing]
        if named:
            more = f" and {len(named) - _MOST} more gaps" if len(named) > _MOST else ""
            what = f"{', '.join(named[:_MOST])} missing{more}; the others are used"
            yield Finding(CODE, "warning", what, pose=pose.label, rule="ISO 9283 6.9: 30 cycles")
