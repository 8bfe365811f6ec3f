"""Mitutoyo Digimatic: 13 nibbles (52 bits) that a microcontroller passes on as hexadecimal text.

D1 type of data, D2-D4 F, D5 sign, D6-D11 digits, D12 decimals, D13 unit and GO/NG judgement. Of
"Digimatic 2" D1 is 8, D2 F, and D3 D4 are two more digits. Some bridges print the value after the
nibbles ("FFFF000566541 0.5665 in"), and call every GO/NG frame "in": the text is not read.
"""

from scara_iso.recorder.indicators._grammar import FaultLine, line_dialect

_PRINTED = rb"(?: +-?\d*\.?\d+ (?:in|mm))?"

DIALECT = line_dialect(
    key="digimatic-hex",
    instruments="Mitutoyo Digimatic gauges behind an Arduino or Pico bridge that sends the nibbles",
    cable=(
        "Arduino or Pico bridge on the Digimatic connector that prints the 13 nibbles as "
        "hexadecimal"
    ),
    line="9600 8N1",
    reading=rb"(?:FFFF|8F(?P<high>\d\d))(?P<sign>[08])(?P<digits>\d{6})(?P<places>[0-5])"
    rb"(?P<unit>(?P<mode>[0-7]))" + _PRINTED,
    form="FFFF{sign}{figures}{places}{unit}",
    signs=("0", "8"),
    units={"mm": "0", "inch": "1"},
    also={b"2": "mm", b"3": "mm", b"4": "mm", b"5": "inch", b"6": "inch", b"7": "inch"},
    modes={
        b"0": "",
        b"1": "",
        b"2": "+NG",
        b"3": "GO",
        b"4": "-NG",
        b"5": "+NG",
        b"6": "GO",
        b"7": "-NG",
    },
    faults=(
        FaultLine(
            rb"(?P<kind>[2-7])FFF[08]\d{6}[0-5][0-7]" + _PRINTED,
            {
                "2": "MAX of the statistics value",
                "3": "MIN of the statistics value",
                "4": "mean of the statistics value",
                "5": "sigma of the statistics value",
                "6": "MAX hold value",
                "7": "MIN hold value",
            },
            code="D1={kind}",
        ),
        # A dial always has a unit; nibble 8 is also what inch becomes with its bits reversed.
        FaultLine(rb"FFFF[08]\d{6}[0-5][89A-F]" + _PRINTED, "the frame states no unit", code="D13"),
    ),
    terminator=b"\r\n",
    longest_frame=32,
    digits=6,
    decimals=(3, 0, 1, 2, 4, 5),
    answer_time_s=2.5,
    source="Mitutoyo Manual No. 4330, 6.1-6.2; LSM-6200 99MBC095A p. 6-28; 99MAF600B p. 59",
    confidence="high",
    unverified=(
        "the bridge's line settings and request (this driver listens)",
        "Digimatic 2 frames (8 digits): one source, whose own example contradicts itself",
    ),
)
