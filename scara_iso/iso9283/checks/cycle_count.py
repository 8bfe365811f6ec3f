"""The number of cycles is not the standard's, or the first cycle is not in the table.

ISO 9283 6.9 asks for 30 cycles. The paper runs 31 and drops the first, because that arrival may
rest on the other side of the gap. ``all_count=True`` states that none was discarded.
"""

from scara_iso.iso9283.core.cycles import CYCLES_USED
from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "cycle-count"
BRIEF = "not the standard's 30 cycles"


def check(measured: Measured) -> Findings:
    """Yield a warning for other than 30 cycles, and a note where none is discarded here."""
    cycles = measured.cycles
    if measured.block is not None:
        return
    if cycles.used != CYCLES_USED:
        what = f"{cycles.used} cycles count; the standard asks for {CYCLES_USED}"
        axes = [axis for pose in measured.poses for axis in pose.axes.values()]
        if any(axis.RP > 0 and axis.RP_interval is None for axis in axes):
            what += "; they are too few for an interval of RP"
        yield Finding(CODE, "warning", what, rule="ISO 9283 6.9: 30 cycles")
    if cycles.all_count:
        yield Finding(CODE, "info", f"all {cycles.used} cycles count, and none was discarded")
    elif not cycles.discarded:
        what = f"the first cycle is not in the table; all {cycles.used} rows count"
        yield Finding(CODE, "info", what)
