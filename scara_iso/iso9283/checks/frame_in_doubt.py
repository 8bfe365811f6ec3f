"""A reading may be the one before it, sent twice.

This gauge has sent a frame twice, and at these cycles its reading is exactly that of one or two
cycles before: perhaps the old frame in place of a lost one. Compare with the other axes, leave the
cycles out, or measure again with a shorter line.
"""

from scara_iso.iso9283.checks._stated import noted_of_axes
from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "frame-in-doubt"


def check(measured: Measured) -> Findings:
    """Yield a warning for each axis with cycles that repeat a frame on a line that doubles them."""
    for axis, cycles in noted_of_axes(measured.run, "record_doubted"):
        what = (
            f"{cycles}: equal to one of the two readings before, and this gauge has sent "
            "frames twice: perhaps a copy in place of a lost reading"
        )
        yield Finding(CODE, "warning", what, axis)
