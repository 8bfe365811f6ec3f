"""The unit is the user's word.

The gauge does not send its unit, so the recorder took the one that you gave. If the display showed
inches, every figure is wrong, and the readings may not show it. Look at the display, or move the
plunger over a gauge block.
"""

from scara_iso.iso9283.checks._stated import noted_of_axes
from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "unit-not-confirmed"


def check(measured: Measured) -> Findings:
    """Yield a warning for each axis whose unit no gauge has confirmed."""
    for axis, said in noted_of_axes(measured.run, "record_unit"):
        yield Finding(CODE, "warning", said, axis)
