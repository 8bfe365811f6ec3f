"""Mitutoyo U-WAVE-R, the radio receiver: ``DT10005+00000020.06M`` when a DATA key is pressed.

``DT1``, group, channel, sign, eleven characters with the point, unit ``M``, ``I`` or ``0``; a
status is ``ST1``, group, channel (FF for none), device and code.
"""

from scara_iso.recorder.indicators._grammar import FaultLine, line_dialect

_CODES = {
    "01": "instrument does not answer",
    "02": "unregistered transmitter",
    "03": "measurement lost",
    "04": "transmitter disconnected",
    "05": "no data",
    "50": "request packet error",
    "99": "data cancelled",
    "": "unknown status",
}
_DEVICE = rb"[0-9A-F]{10}(?!00|51)(?P<kind>\d\d)"
_ANY = rb"(?:\d\d|FF)(?:\d\d|FF)"

DIALECT = line_dialect(
    key="mitutoyo-uwave",
    instruments="Mitutoyo U-WAVE-R receiver (virtual COM port), readings sent by the DATA key",
    cable="USB of the receiver; the transmitter's DATA key sends",
    line="57600 8N1",
    reading=rb"DT1(?P<channel>\d{4})"
    rb"(?P<sign>[+-])(?=[\d.]{11}[MI0]\Z)(?P<digits>\d+\.\d+)(?P<unit>[MI0])",
    form="DT1{channel}{sign}{digits}{unit}",
    units={"mm": "M", "inch": "I", None: "0"},
    faults=(
        FaultLine(rb"ST1(?P<channel>\d{4})" + _DEVICE, _CODES, code="ST1 {kind}"),
        FaultLine(rb"ST1" + _ANY + _DEVICE, _CODES, code="ST1 {kind}"),
    ),
    notices=(rb"ST1" + _ANY + rb"[0-9A-F]{10}(?:51|(?P<low>00))",),
    longest_frame=20,
    digits=10,
    decimals=(3, 1, 2, 4, 5, 6),
    channels=tuple(f"{number:04}" for number in range(10_000)),
    source="Mitutoyo U-WAVEPAK 99MAL216A 6.1 (by way of two independent programs)",
    confidence="high",
    unverified=("status codes: one program; the manual itself was not read",),
)
