"""Drift of pose repeatability: how far RP has changed since the first block of a drift test.

dRP is the largest change of RP (7.2.2) from the first block to a later one, up or down, of each
axis that is a length, of XY and of XYZ. The blocks and their table are those of dAP. RP of ten
visits is uncertain by a fifth to a third, and the largest of many changes more so: a robot whose
scatter never changes easily shows a dRP of half its RP. The interval says so: its upper end is
that of the largest change by itself, its lower end allows for the choice of the largest among the
blocks.
"""

from dataclasses import replace

import numpy as np

from scara_iso.base.quantities import Dimension, Estimate
from scara_iso.iso9283.characteristics._shapes import each_in_blocks
from scara_iso.iso9283.core.results import Characteristic, Characteristics, Measured, limit_names
from scara_iso.iso9283.core.statistics import (
    FEWEST_FOR_INTERVAL,
    components,
    pooled_intervals,
    repeatability,
)
from scara_iso.run import Axis, FloatArray, step_of

CODE = "dRP"
CLAUSE = "7.6"
NEEDS = (
    "a drift test: blocks of visits over hours, numbered in a column 'block' and timed in a "
    "column time_s or timestamp"
)
_CONFIDENCE = 0.95


def compute(test: Measured) -> Characteristics:
    """Yield it for each axis that is a length, XY and XYZ of each pose of a drift test."""
    for pose, visits in each_in_blocks(test):
        for of, names in components(test.run):
            axes = [test.run.axes[name] for name in names]
            if axes[0].dimension is Dimension.LENGTH:
                blocks = [np.stack([block[name] for name in names]) for block in visits]
                estimate = change_of_repeatability(blocks, axes)
                named = limit_names(CODE, pose.label, of)
                found = Characteristic(CODE, pose.label, of, estimate, named, of_means=True)
                yield replace(found, counted="visits in a block")


def change_of_repeatability(blocks: list[FloatArray], axes: list[Axis]) -> Estimate:
    """Return the largest change of RP from the first of ``blocks``, of shape (axes, visits)."""
    RP = np.array([float(repeatability(block).RP) for block in blocks])
    change = np.abs(RP[1:] - RP[0])
    n, unit = min(block.shape[1] for block in blocks), axes[0].unit
    value, farthest = float(change.max()), int(np.argmax(change))
    if n < FEWEST_FOR_INTERVAL:
        return Estimate(value, unit, None, {}, None, n, CLAUSE)
    step = max(map(step_of, axes))  # rounding may move RP of a block by about a division
    below, _ = _reach(blocks, RP, step, 1 - (1 - _CONFIDENCE) / len(change))
    alone, above = _reach(blocks, RP, step, _CONFIDENCE)
    ends = (max(float((change - below).max()), 0.0), float((change + above).max()))
    u = float(alone[farthest] + above[farthest]) / 4
    return Estimate(value, unit, u, {"sampling": u}, ends, n, CLAUSE)


def _reach(
    blocks: list[FloatArray], RP: FloatArray, step: float, confidence: float
) -> tuple[FloatArray, FloatArray]:
    """Return how far each change may lie below and above it: Zou and Donner (2008)."""
    low, high = pooled_intervals(blocks, confidence=confidence)
    down, up, rises = RP - low, high - RP, RP[1:] >= RP[0]
    fallen, risen = np.hypot(down[1:], up[0]), np.hypot(up[1:], down[0])
    below, above = np.where(rises, fallen, risen), np.where(rises, risen, fallen)
    return np.hypot(below, step), np.hypot(above, step)
