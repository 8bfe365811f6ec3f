"""Rows repeat the row before them more often than chance can do.

A visit that is written several times counts several times, so the interval of RP is too narrow.
Keep one row for each visit. Equal neighbours of a coarse dial, of a slow drift or of a stuck
channel are not counted as repeats.
"""

from scara_iso.iso9283.cycles import REPEATED_BY_CHANCE, repeats_in
from scara_iso.iso9283.results import Finding, Findings, Measured

CODE = "repeated-rows"
BRIEF = "rows repeat"


def check(measured: Measured) -> Findings:
    """Yield a warning for each pose whose rows repeat."""
    chance = f"by chance with p < {REPEATED_BY_CHANCE:g}"
    for pose in measured.poses:
        found = repeats_in(measured.run, pose.rows)
        if found.p_value < REPEATED_BY_CHANCE:
            what = f"{found.said} ({chance}): the interval is too narrow"
            advice = "take one row a visit"
            yield Finding(CODE, "warning", what, pose=pose.label, advice=advice)
