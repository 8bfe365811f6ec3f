"""Old Starrett SPC output (TTL level): 13 blanks, sign, seven characters, blank, unit."""

from scara_iso.recorder.indicators._grammar import line_dialect

DIALECT = line_dialect(
    key="starrett-spc",
    instruments="old Starrett gauges with SPC output (TTL level: needs a level converter)",
    cable="SPC connector through a level converter (TTL, not RS-232)",
    line="1200 8N2",
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
