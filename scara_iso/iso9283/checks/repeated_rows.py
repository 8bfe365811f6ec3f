"""Rows repeat others more often than chance can do.

A visit that is written several times counts several times: the interval of RP is too narrow. Keep
one row for each visit; equal neighbours of a coarse dial or a slow drift do not count. A block of
rows or a pose with the readings of another is most likely a copy.
"""

from scara_iso.iso9283.core.results import Finding, Findings, Measured
from scara_iso.iso9283.core.slips import REPEATED_BY_CHANCE, copied_in, repeats_in
from scara_iso.run import copies

CODE = "repeated-rows"
BRIEF = "rows repeat"


def check(measured: Measured) -> Findings:
    """Yield a warning for each pose whose rows repeat, or are those of another."""
    chance = f"by chance with p < {REPEATED_BY_CHANCE:g}"
    for pose in measured.poses:
        found = repeats_in(measured.run, pose.rows)
        if found.p_value < REPEATED_BY_CHANCE:
            what = f"{found.said} ({chance}): the interval is too narrow"
            advice = "take one row a visit"
            yield Finding(CODE, "warning", what, pose=pose.label, advice=advice)
        elif (copied := copied_in(measured.run, pose.rows)) is not None:
            what = f"{copied.in_words(measured.run.cycle[pose.rows])}, copied or stuck ({chance})"
            yield Finding(CODE, "warning", what, pose=pose.label, advice="measure those cycles")
    each = ((str(pose.label), measured.run.take(pose.rows)) for pose in measured.poses)
    for label, first in copies(each):
        what, brief = f"every reading is that of {first}: a copy?", f"those of {first}"
        advice = "measure the pose"
        yield Finding(CODE, "warning", what, pose=label, advice=advice, in_short=brief)
