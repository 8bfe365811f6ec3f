"""The readings of two axes are exchanged in some of the cycles.

One axis lies where the other lay, and the other where it lay: columns typed the other way round, or
cables that changed their plugs. It looks like a step of both, and RP is wrong. Put the readings
back, or repeat the test.
"""

from itertools import combinations

from scara_iso.iso9283.core.results import Finding, Findings, Measured
from scara_iso.iso9283.core.slips import exchanged_in

CODE = "axes-exchanged"
BRIEF = "axes exchanged?"


def check(measured: Measured) -> Findings:
    """Yield a warning for each pose and pair of axes whose readings change places."""
    for pose in measured.poses:
        for pair in combinations(measured.run.axes.values(), 2):
            if what := exchanged_in(measured.run.cycle[pose.rows], *pair, pose.rows):
                advice = "look at the sheet and at the cables"
                yield Finding(CODE, "warning", what, pair[0].name, pose.label, advice=advice)
