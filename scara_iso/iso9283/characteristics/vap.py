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

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from scara_iso.iso9283.figures import PoseResult
from scara_iso.iso9283.results import (
    Characteristic,
    Measured,
    limit_names,
    poses_in_cycles,
)
from scara_iso.iso9283.uncertainty import components, largest_distance

CODE = "vAP"
CLAUSE = "7.2.3"
NEEDS = (
    "30 cycles at a pose from each of three perpendicular directions, which a column approach "
    "names: +x, +y, +z and the like"
)


def compute(test: Measured) -> Iterator[Characteristic]:
    """Yield it for each axis, XY and XYZ of each pose with two directions or more."""
    arrived: dict[str | None, list[PoseResult]] = {}
    for one in poses_in_cycles(test):
        arrived.setdefault(test.run.arrival_at(one.label)[0], []).append(one)
    for pose, directions in arrived.items():
        if len(directions) > 1:
            yield from _at_pose(test, pose, directions)


def _at_pose(
    test: Measured, pose: str | None, directions: Sequence[PoseResult]
) -> Iterator[Characteristic]:
    pairs = list(combinations(range(len(directions)), 2))
    for of, names in components(test.run):
        groups = [np.stack([one.axes[n].readings for n in names]) for one in directions]
        axes = [test.run.axes[name] for name in names]
        yield Characteristic(
            CODE,
            pose,
            of,
            largest_distance(groups, pairs, axes=axes, clause=CLAUSE),
            limited_by=limit_names(CODE, pose, of),
            between=tuple(one.label for one in directions),
            of_means=True,
        )
