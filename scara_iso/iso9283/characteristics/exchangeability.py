"""Exchangeability: how far apart several robots arrive with one and the same program.

The largest distance between the barycentres of the robots at a pose: along each axis, in XY and in
XYZ (of an angle, the largest difference of means). Run the same program, 30 cycles on each robot,
with the dials left where they are, or set to zero against the same reference, and compare a table
of each with `exchangeability=True`. Every table must say what its zero is referred to
(`# dial_zero: command`, or another word such as fixture), and all of them the same: two dials that
were set to zero at the robot's own place would show robots that are all alike. The interval is made
as that of vAP.
"""

from itertools import combinations

from scara_iso.iso9283.characteristics._shapes import farthest_apart, readings_of
from scara_iso.iso9283.core.results import Characteristics, Measured

CODE = "exchangeability"
CLAUSE = "7.7"
NEEDS = (
    "a table of each of several robots, run with one program and dials of one zero, compared with "
    "`exchangeability=True`"
)


def compute(test: Measured) -> Characteristics:
    """Yield it for each axis, XY and XYZ of each pose that every robot of a test visited."""
    tests = (test, *test.robots)
    if len(tests) < 2:
        return
    pairs = list(combinations(range(len(tests)), 2))
    alone = all(len(one.poses) == 1 for one in tests)
    for pose in test.poses:
        at = [one for each in tests for one in each.poses if alone or one.label == pose.label]
        if len(at) == len(tests):
            groups, runs = [readings_of(one) for one in at], [one.run for one in tests]
            yield from farthest_apart(CODE, CLAUSE, pose.label, groups, pairs, runs)
