"""Metro Mux4 and Mux8: ``V2: mm       -00001.250000``, and ``Nxy:Ex`` for an error."""

from scara_iso.recorder.indicators._grammar import FaultLine, line_dialect

DIALECT = line_dialect(
    key="metro-mux",
    instruments="Metro Mux4 and Mux8 multiplexers",
    cable="USB of the multiplexer (COM port)",
    line="9600 8N1",
    reading=rb"V(?P<channel>[1-8]): (?P<unit>mm  |in  |inch|um  )     "
    rb"(?P<sign>[+-])(?P<digits>\d{5}\.\d{6})",
    form="V{channel}: {unit:4}     {sign}{digits}",
    units={"mm": "mm", "inch": "in", "um": "um"},
    faults=(
        FaultLine(
            rb"N(?P<channel>[1-8])[ -~]?:(?P<kind>E\d)",
            {"E1": "communication error", "E3": "reading error", "": "unknown fault"},
            code="{kind}",
        ),
        # The source does not explain this field; its only example leaves it blank.
        FaultLine(
            rb"V(?P<channel>[1-8]): (?:mm  |in  |inch|um  ) (?!   )(?P<kind>[ -~]{3})"
            rb" [+-]\d{5}\.\d{6}",
            "a value of this type is not the reading",
            code="{kind}",
        ),
    ),
    terminator=b"\r\n",
    longest_frame=26,
    digits=11,
    decimals=(6,),
    request_template=b"{channel}",
    channels=tuple("12345678"),
    channel="1",
    source="Metro Datavac Mux4 manual (frame; errors p. 7)",
    confidence="high",
    unverified=(
        "line settings (the multiplexer is on USB)",
        "how inch and um are spelt, and the field between unit and value (blank is taken)",
    ),
)
