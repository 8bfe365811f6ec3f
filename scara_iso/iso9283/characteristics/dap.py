"""Drift of pose accuracy: how far the pose has moved since the first block of a drift test.

dAP is the largest distance between the barycentre of the first block and that of a later one, of
each axis, XY and XYZ (of an angle, the largest change of the mean). The standard takes the change
of AP; the command pose falls out of it along an axis, and in XY and XYZ the distance of the
barycentres is never less, so that no command pose is needed and the dial must only keep its zero.
The standard's test: power off for 8 h, a cold start, then blocks of 10 visits to P1 from P2 with
warm-up motion between them for 8 h. In a table a column `block` numbers the blocks and time_s
or timestamp dates the rows; with `# test: drift` and no such column, gaps in time of
more than three usual steps part the blocks. Every visit counts. The interval allows for the choice
of the largest among the blocks, so that a pose that stands still has one down to 0.
"""

from dataclasses import replace

from scara_iso.iso9283.characteristics._shapes import each_in_blocks, farthest_apart
from scara_iso.iso9283.core.results import Characteristics, Measured

CODE = "dAP"
CLAUSE = "7.6"
NEEDS = (
    "a drift test: blocks of visits over hours, numbered in a column 'block' and timed in a "
    "column time_s or timestamp"
)


def compute(test: Measured) -> Characteristics:
    """Yield it for each axis, XY and XYZ of each pose of a drift test."""
    for pose, blocks in each_in_blocks(test):
        pairs = [(0, k) for k in range(1, len(blocks))]
        for found in farthest_apart(CODE, CLAUSE, pose.label, blocks, pairs, [test.run]):
            yield replace(found, counted="visits in a block")
