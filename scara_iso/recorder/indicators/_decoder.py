"""Bytes in, events out: the same events however the stream is cut, in bounded memory."""

from __future__ import annotations

import re

from scara_iso.recorder.indicators._dialect import (
    DeviceNotice,
    Dialect,
    Event,
    Garbage,
    InstrumentFault,
    Reading,
)

_SEVEN_BITS = bytes(byte & 0x7F for byte in range(256))
_TEXT = re.compile(rb"[ -~\r\n]{3,}")


def diagnose_parity(raw: bytes) -> str | None:
    """Return what a line with bytes above 0x7F says about the port's settings, if anything.

    Read as 8N1, the parity of a seven-bit instrument sits in bit 8: every byte then has an even
    (or odd) number of ones, and without that bit the line is plain text.
    """
    if raw.isascii() or not _TEXT.fullmatch(raw.translate(_SEVEN_BITS)):
        return None
    parities = {byte.bit_count() % 2 for byte in raw}
    if parities == {0}:
        return "looks like 7E2 read as 8N1: open the port with 7 data bits and even parity"
    if parities == {1}:
        return "looks like 7O2 read as 8N1: open the port with 7 data bits and odd parity"
    return None


class Decoder:
    """Turns the bytes of one port into the events of one dialect.

    Holds one byte more than ``dialect.longest_frame`` at most. NULs and line ends before a frame
    are skipped: instruments and adapters really send them. Everything else between two line ends
    is one line, and a line is a frame as a whole or not at all.
    """

    def __init__(self, dialect: Dialect) -> None:
        self._dialect = dialect
        self._rest = b""
        self._beyond = 0  # bytes of the line in progress that are counted and not kept

    def feed(self, data: bytes) -> list[Event]:
        """Return the events of every line that ends within ``data``."""
        if self._dialect.bit_8_undefined:
            data = data.translate(_SEVEN_BITS)
        lines = _split(self._rest + data)
        rest = lines.pop()
        events: list[Event] = []
        if lines and self._beyond:
            events.append(self._too_long(lines.pop(0)))
            self._beyond = 0
        parse, longest = self._dialect.parse, self._dialect.longest_frame
        for line in lines:
            if len(line) > longest:
                events.append(self._too_long(line))
            elif line:
                events.extend(parse(line) or (self._garbage(line),))
        self._rest = rest[: longest + 1]
        self._beyond += len(rest) - len(self._rest)
        return events if self._dialect.channel is None else self._of_channel(events)

    def drop_partial(self) -> Garbage | None:
        """Forget a line that never ended, and return it: half a frame is never parsed."""
        count = len(self._rest) + self._beyond
        head = self._rest[: self._dialect.longest_frame]
        dropped = Garbage(f"{count} bytes of a line that never ended", head)
        self._rest, self._beyond = b"", 0
        return dropped if count else None

    def _too_long(self, line: bytes) -> Garbage:
        longest = self._dialect.longest_frame
        count = len(line) + self._beyond
        reason = f"line of {count} bytes, and no frame has more than {longest}"
        return Garbage(diagnose_parity(line[: longest + 1]) or reason, line[:longest])

    def _garbage(self, line: bytes) -> Garbage:
        return Garbage(diagnose_parity(line) or f"no frame of {self._dialect.key}", line)

    def _of_channel(self, events: list[Event]) -> list[Event]:
        asked = self._dialect.channel
        return [
            DeviceNotice(f"channel {event.channel} speaks, but was not asked", event.raw)
            if isinstance(event, Reading | InstrumentFault) and event.channel not in (None, asked)
            else event
            for event in events
        ]


def _split(data: bytes) -> list[bytes]:
    """Return the lines in ``data`` and, last, the start of the line in progress.

    CR and LF with bit 8 set, as a wrong parity leaves them, end a line too and stay in it: such
    a line is garbage, and is told at once instead of when the instrument falls silent.
    """
    if not data.isascii():
        data = data.replace(b"\x8d", b"\x8d\r").replace(b"\x8a", b"\x8a\r")
    lines = data.replace(b"\n", b"\r").split(b"\r")
    if b"\0" in data:
        lines = [line.lstrip(b"\0") for line in lines]
    return lines
