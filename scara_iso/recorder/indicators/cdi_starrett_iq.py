"""Chicago Dial Indicator (Logic) and Starrett IQ: ``+  2.1380, MM``.

Polarity, eight characters with the point, comma, blank, IN or MM; both makers agree byte for byte.
"""

from scara_iso.recorder.indicators._grammar import FaultLine, line_dialect

DIALECT = line_dialect(
    key="cdi-starrett-iq",
    instruments="Chicago Dial Indicator Logic, Starrett IQ (USB, RS232 or UART)",
    cable=(
        "USB (appears as a COM port), RS232 or UART cable of the maker; the gauge needs "
        "outside power"
    ),
    line="9600 8N1",
    reading=rb"(?P<sign>[+-])(?=[ \d.]{8},)(?P<digits> *\d*\.\d+), (?P<unit>MM|IN)",
    form="{sign}{digits}, {unit}",
    fill=" ",
    units={"mm": "MM", "inch": "IN"},
    faults=(
        FaultLine(rb"NOT FOUND|NO ACCESS|OUT OF BOUNDS|NON NUMERIC", "the gauge refused a command"),
    ),
    notices=(rb"SUCCESS",),
    terminator=b"\r\n",
    longest_frame=13,
    digits=7,
    decimals=(4, 1, 2, 3, 5),
    request_template=b"R\r",
    source="CDI USB and RS232 communication protocol; Starrett IQ manual p. 17",
    confidence="high",
    unverified=(
        "blanks between digits, which CDI's note allows 'for readability', are refused",
        "whether a value held by H is marked (send no H)",
    ),
)
