"""MUX 2 and MUX 4: ``1 MW+003.4665 inch``; ``3 TO 999999.99 mm`` is an error."""

from scara_iso.recorder.indicators._dialect import LineSettings
from scara_iso.recorder.indicators._grammar import FaultLine, line_dialect

DIALECT = line_dialect(
    key="mux24",
    instruments="MUX 2 and MUX 4 multiplexers (powered by the DTR line)",
    cable="RS-232, powered by the port's DTR line",
    line=LineSettings.of("9600 8N1", dtr=True),
    reading=rb"(?P<channel>[1-4]) MW(?P<sign>[+\- ])(?=[\d.]{8} )(?P<digits>\d+\.\d+)"
    rb" (?P<unit>mm|inch)",
    form="{channel} MW{sign}{digits} {unit}",
    units={"mm": "mm", "inch": "inch"},
    faults=(
        FaultLine(
            rb"(?P<channel>[1-4]) (?!MW)(?P<kind>[A-Z]{2})[+\- ][\d.]{8,9} (?:mm|inch)",
            {"TO": "error reading the gauge", "": "no measured value"},
            code="{kind}",
        ),
    ),
    terminator=b"\r\n",
    longest_frame=19,
    digits=7,
    decimals=(4, 1, 2, 3, 5, 6),
    request_template=b"{channel}",
    channels=("1", "2", "3", "4"),
    channel="1",
    source="Adept Science knowledge base, article 68CE",
    confidence="high",
    unverified=("types other than MW and TO (refused)", "the width of the number in mm"),
)
