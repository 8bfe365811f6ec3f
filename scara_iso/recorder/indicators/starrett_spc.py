"""Old Starrett SPC output (TTL level): 25 characters at 1200 baud, bit 8 undefined.

Source: Matronics converter, DiagramRev2.pdf: 13 blanks, sign (blank or ``-``), seven characters
with the point, blank, ``in`` or ``mm``, CR. One reverse-engineered source.
"""

from __future__ import annotations

from scara_iso.recorder.indicators._dialect import LineSettings
from scara_iso.recorder.indicators._grammar import line_dialect

DIALECT = line_dialect(
    key="starrett-spc",
    instruments="old Starrett gauges with SPC output (TTL level: needs a level converter)",
    cable="SPC connector through a level converter (TTL, not RS-232)",
    line=LineSettings(1200, 8, "N", 2),
    reading=rb" {13}(?P<sign>[ -])(?=[ \d.]{7} [im])(?P<digits> *\d*\.\d+) (?P<unit>in|mm)",
    form=" " * 13 + "{sign}{digits} {unit}",
    signs=(" ", "-"),
    fill=" ",
    units={"mm": "mm", "inch": "in"},
    longest_frame=24,
    digits=6,
    decimals=(3, 1, 2, 4, 5),
    bit_8_undefined=True,
    source="Matronics converter, DiagramRev2.pdf",
    confidence="medium",
    unverified=("everything: one reverse-engineered source", "what an error looks like"),
)
