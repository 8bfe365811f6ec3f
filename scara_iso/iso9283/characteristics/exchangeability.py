"""Exchangeability: how far apart several robots arrive with one and the same program.

The largest distance between the barycentres of the robots at a pose: along each axis, in XY and in
XYZ (of an angle, the largest difference of means). Run the same program, 30 cycles on each robot,
with the dials left where they are, or set to zero against the same reference, and compare a table
of each with `exchangeability=True`. Every table must say what its zero is referred to
(`# dial_zero: command`, or another word such as fixture), and all of them the same: two dials that
were set to zero at the robot's own place would show robots that are all alike. The interval is made
as that of vAP.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from scara_iso.iso9283.figures import PoseResult
from scara_iso.iso9283.results import Characteristic, Measured, limit_names
from scara_iso.iso9283.uncertainty import components, largest_distance

CODE = "exchangeability"
CLAUSE = "7.7"
NEEDS = (
    "a table of each of several robots, run with one program and dials of one zero, compared with "
    "`exchangeability=True`"
)


def compute(test: Measured) -> Iterator[Characteristic]:
    """Yield it for each axis, XY and XYZ of each pose that every robot of a test visited."""
    tests = (test, *test.robots)
    if len(tests) < 2:
        return
    pairs = list(combinations(range(len(tests)), 2))
    alone = all(len(one.poses) == 1 for one in tests)
    for pose in test.poses:
        others = [one.poses[0] if alone else _find(one, pose.label) for one in tests]
        at = [found for found in others if found is not None]
        if len(at) < len(tests):
            continue
        for of, names in components(test.run):
            if not all(set(names) <= set(one.axes) for one in at):
                continue
            groups = [np.stack([one.axes[n].readings for n in names]) for one in at]
            axes = [one.run.axes[name] for one in tests for name in names]
            estimate = largest_distance(groups, pairs, axes=axes, clause=CLAUSE)
            names_of_limit = limit_names(CODE, pose.label, of)
            yield Characteristic(CODE, pose.label, of, estimate, names_of_limit, of_means=True)


def _find(test: Measured, label: str | None) -> PoseResult | None:
    return next((pose for pose in test.poses if pose.label == label), None)
