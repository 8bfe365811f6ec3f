"""Magnescale LT10A/LT11A/LT20A counters and MG80 modules: ``A+12.345``, ``00NMG-09.9999``.

Sources: LT10A/LT11A manual pp. 16 and 37, LT20A/LT30 pp. 40-41 (channel A or B; mode N current,
P peak-to-peak, I minimum, A maximum; unit; judgement; sign + or blank; alarms ``E`` and ``F``);
MG80-SC1 manual pp. 39-40 (module and counter, 0 to F; "Error" and a leading ``F`` on alarm).
"""

from __future__ import annotations

import re
from dataclasses import replace

from scara_iso.recorder.indicators._dialect import (
    Dialect,
    Event,
    InstrumentFault,
    LineSettings,
    Reading,
)
from scara_iso.recorder.indicators._grammar import Compose, Parse, decimal_text, show_digits, spell

_UNITS = {b"M": "mm", b"I": "inch", b"": None}
_HELD = {b"P": "peak-to-peak", b"I": "minimum", b"A": "maximum"}


def _parser(header: bytes, *, width: int, values: int) -> Parse:
    """Return the parser of lines of ``values`` numbers at most, separated by a blank."""
    one = (
        rb"(%b)(?:([NPIA])([MI])([UGLE])?)?"
        rb"(?:([+\- ])(?=[\d.]{%d}(?![\d.]))(\d+\.\d+)|([+\- ]F[\d.]+|E[FO]?|  Error ))"
    ) % (header, width)
    item = re.compile(one)
    whole = re.compile(rb"%b(?: %b){0,%d}" % (one, one, values - 1))

    def parse(line: bytes) -> tuple[Event, ...]:
        if alone := item.fullmatch(line):
            return (_event(alone.groups(b""), line),)
        if whole.fullmatch(line) is None:
            return ()
        return tuple(_event(fields, line) for fields in item.findall(line))

    return parse


def _event(fields: tuple[bytes, ...], line: bytes) -> Event:
    header, mode, unit, judgement, sign, digits, alarm = fields
    channel = header.decode("ascii")
    if alarm or judgement == b"E":
        what = "overflow" if b"F" in alarm else "alarm"
        return InstrumentFault((judgement + alarm).strip().decode(), what, line, channel)
    if mode in _HELD:
        message = f"{_HELD[mode]} value, not the reading"
        return InstrumentFault(mode.decode(), message, line, channel)
    text = decimal_text(sign, digits)
    return Reading(text, _UNITS[unit], channel, judgement.decode() or None, line)


def _composer(*, digits: int, header: str) -> Compose:
    def compose(text: str, unit: str | None, channel: str | None) -> bytes:
        sign, shown = show_digits(text, digits=digits, decimals=range(1, digits))
        mode = spell(unit, {None: "", "mm": "NM", "inch": "NI"}, key="magnescale")
        return f"{channel or header}{mode}{sign}{shown}\r\n".encode("ascii")

    return compose


_LT10A = Dialect(
    key="magnescale",
    instruments="Magnescale LT10A and LT11A counters with RS-232C (-C models)",
    cable="RS-232C socket of the counter",
    line=LineSettings(9600, 8, "N", 1),
    parse=_parser(rb"[AB]", width=6, values=2),
    compose=_composer(digits=5, header="A"),
    terminator=b"\r\n",
    longest_frame=2 * 12 + 1,
    digits=5,
    decimals=(3, 1, 2, 4),
    units=(None, "mm", "inch"),
    request_template=b"R\r\n",
    channels=("A", "B"),
    channel="A",
    source="Magnescale LT10A/LT11A manual pp. 16, 37",
    confidence="medium",
    unverified=("baud, data bits, parity and stop bits",),
)

_LT20A = replace(
    _LT10A,
    key="magnescale-lt20a",
    instruments="Magnescale LT20A and LT30 counters with RS-232C",
    cable="RS-232C socket of the counter",
    parse=_parser(rb"[AB]", width=7, values=2),
    compose=_composer(digits=6, header="A"),
    longest_frame=2 * 13 + 1,
    digits=6,
    decimals=(4, 1, 2, 3, 5),
    source="Magnescale LT20A/LT30 manual pp. 40-41",
    unverified=("baud, data bits, parity and stop bits", "the request (that of the LT10A)"),
)

_MG80 = replace(
    _LT10A,
    key="magnescale-mg80",
    instruments="Magnescale MG80-SC1 modules",
    cable="RS-232C of the main module; CR or CR LF by switch 2",
    parse=_parser(rb"[0-9A-F]{2}", width=7, values=16),
    compose=_composer(digits=6, header="00"),
    longest_frame=16 * 14 + 15,
    digits=6,
    decimals=(4, 1, 2, 3, 5),
    units=(None, "mm"),
    request_template=None,
    channels=tuple(f"{module:X}{counter:X}" for module in range(16) for counter in range(16)),
    channel="00",
    source="Magnescale MG80-SC1 manual pp. 39-40",
    unverified=("baud, data bits, parity and stop bits", "the request (this dialect listens)"),
)

DIALECTS = (_LT10A, _LT20A, _MG80)
