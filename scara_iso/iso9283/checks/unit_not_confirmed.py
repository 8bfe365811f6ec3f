"""The unit is the user's word.

The gauge states no unit in its frames and answered none when asked, so that the recorder took the
unit that was given. A display that showed inches then counts as millimetres, and near zero nothing
in the readings can tell. Look at the display, or move the plunger over a gauge block.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283.results import Finding, Measured
from scara_iso.run import SEPARATOR

CODE = "unit-not-confirmed"


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for each axis whose unit no gauge has confirmed."""
    for line in measured.run.metadata.get("record_unit", "").split(SEPARATOR):
        axis, colon, said = line.partition(": ")
        if colon:
            yield Finding(CODE, "warning", said.strip(), axis.strip())
