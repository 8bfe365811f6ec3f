"""The unit is the user's word.

The gauge states no unit in its frames and answered none when asked, so that the recorder took the
unit that was given. A display that showed inches then counts as millimetres, and near zero nothing
in the readings can tell. Look at the display, or move the plunger over a gauge block.
"""

from scara_iso.iso9283.checks._stated import noted_of_axes
from scara_iso.iso9283.results import Finding, Findings, Measured

CODE = "unit-not-confirmed"


def check(measured: Measured) -> Findings:
    """Yield a warning for each axis whose unit no gauge has confirmed."""
    for axis, said in noted_of_axes(measured.run, "record_unit"):
        yield Finding(CODE, "warning", said, axis)
