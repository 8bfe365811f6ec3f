"""The table is read as a drift test.

It has a column `block` and times, or `# test: drift`: blocks of visits over hours (ISO 9283 7.6),
of which every visit counts. It gives dAP and dRP instead of RP, which would count the drift as
scatter. If the column is a condition of a test of 31 cycles, rename it.
"""

import numpy as np

from scara_iso.iso9283.core.drift import VISITS, blocks_from_gaps
from scara_iso.iso9283.core.results import Finding, Findings, Measured
from scara_iso.run import FloatArray, IntArray

CODE = "drift-test"
_VISITS = 10
_HOURS = 8.0


def check(measured: Measured) -> Findings:
    """Yield how a drift test was read, and where it departs from the standard's."""
    block, time = measured.block, measured.run.covariates.get("time_s")
    if block is None:
        return
    counts = np.unique(block, return_counts=True)[1] // len(measured.poses)
    least, most = int(counts.min()), int(counts.max())
    sizes = f"{least}" if least == most else f"{least} to {most}"
    stated = "block" in measured.run.covariates or VISITS in measured.run.metadata
    gaps = "" if stated else ", parted at gaps in time"
    hours = None if time is None else float(time[-1] - time[0]) / 3600
    over = "" if hours is None else f" over {hours:.3g} h"
    said = f"a drift test: {len(counts)} blocks of {sizes} visits{over}{gaps}; every visit counts"
    yield Finding(CODE, "info", said)
    if least != _VISITS or most != _VISITS:
        what = f"blocks of {sizes} visits"
        yield Finding(CODE, "warning", what, rule="ISO 9283 7.6: blocks of 10 visits")
    if time is not None and stated and _gaps_say_otherwise(time, block):
        what = "long pauses do not fall between the blocks: look for a visit lost or taken twice"
        yield Finding(CODE, "warning", what)
    if hours is not None and hours < _HOURS:
        what = f"it runs over {hours:.3g} h"
        yield Finding(CODE, "warning", what, rule=f"ISO 9283 7.6: {_HOURS:g} h, or until steady")


def _gaps_say_otherwise(time: FloatArray, block: IntArray) -> bool:
    """Whether there are long pauses, and any of them lies within a block."""
    paused = np.diff(blocks_from_gaps(time)) > 0
    return bool(np.any(paused & (np.diff(block) == 0)))
