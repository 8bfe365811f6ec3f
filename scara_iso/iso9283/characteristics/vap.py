"""Variation of pose accuracy by direction: how far the mean moves with the way of arriving.

vAP is the largest distance between the barycentres of one pose, each of the arrivals from one
direction: along each axis, in XY and in XYZ (of an angle, the largest difference of means). It
needs no command pose, and the dial must keep its zero throughout. The standard takes 30 cycles from
each of three perpendicular directions; a pose with fewer is measured all the same and said to
lack them, one with a single direction has no vAP. Every direction has its own RP: all of them
together would count the variation as scatter. The upper end of the interval is Student's for the
farthest pair; the lower one allows for the choice of that pair, so that two equal barycentres
have an interval down to 0.
"""

from dataclasses import replace
from itertools import combinations

from scara_iso.iso9283.characteristics._shapes import farthest_apart, readings_of
from scara_iso.iso9283.core.results import (
    Characteristics,
    Measured,
    arrivals_by_pose,
    poses_in_cycles,
)

CODE = "vAP"
CLAUSE = "7.2.3"
NEEDS = (
    "30 cycles at a pose from each of three perpendicular directions, which a column approach "
    "names: +x, +y, +z and the like"
)


def compute(test: Measured) -> Characteristics:
    """Yield it for each axis, XY and XYZ of each pose with two directions or more."""
    for pose, arrived in arrivals_by_pose(test.run, poses_in_cycles(test)).items():
        if len(arrived) > 1:
            groups, labels = map(readings_of, arrived), tuple(one.label for one in arrived)
            pairs = list(combinations(range(len(arrived)), 2))
            for found in farthest_apart(CODE, CLAUSE, pose, list(groups), pairs, [test.run]):
                yield replace(found, between=labels)
