"""Mitutoyo MUX-10 text frames: ``01A+0000.123``: code 0, channel, item A, sign, number."""

from scara_iso.recorder.indicators._grammar import FaultLine, line_dialect

DIALECT = line_dialect(
    key="mitutoyo-mux",
    instruments="Mitutoyo MUX-10F, USB-ITN (virtual COM port), QM-Height USB, GageMux",
    cable=(
        "USB or RS-232 of the interface. USB-ITN: install the maker's virtual COM port "
        "(Windows); on Linux it is a keyboard and shows no port"
    ),
    line="9600 8N1",
    reading=rb"0(?P<channel>[1-9])A(?P<sign>[+-])(?=[\d.]{8}\Z)(?P<digits>\d+\.\d+)",
    form="0{channel}A{sign}{digits}",
    units={None: ""},
    faults=(  # "911" is "channel 1, no data", and never the number 911
        FaultLine(
            rb"9(?P<channel>[1-9])(?P<kind>\d)",
            {"1": "no data", "2": "format error", "9": "system error", "": "unknown fault"},
        ),
    ),
    longest_frame=12,
    digits=7,
    decimals=(3, 1, 2, 4, 5, 6),
    request_template=b"{channel}\r",
    channels=tuple("123456789"),
    channel="1",
    answer_time_s=2.5,
    source="Mitutoyo QM-Height 99MAF600B p. 67; ASD GageMux p. 6; faults: mitutoyo_reader",
    confidence="high",
    unverified=(
        "the request of the MUX-10F (channel digit and CR is what the USB-ITN takes)",
        "the meaning of the fault codes (read from a program, not from a manual)",
    ),
)
