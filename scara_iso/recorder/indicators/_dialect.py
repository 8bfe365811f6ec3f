"""What a dialect is, and what its bytes become: readings, faults, notices and garbage.

A dialect is how one family of indicators speaks on a serial line: settings of the port, request,
and the grammar of one line. Every dialect met so far sends lines that end in CR, LF or both. Its
`Decoder` gives the same events however the stream is cut, in bounded memory.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from decimal import Decimal
from typing import Any, Literal, TypeAlias, cast

from scara_iso.base.errors import UsageError

Parity = Literal["N", "E", "O"]


@dataclass(frozen=True, slots=True)
class Reading:
    """A value that an indicator showed, exactly as it sent it.

    ``text`` is a decimal number: ``-`` or nothing, digits without leading zeros, and the decimals
    with their trailing zeros. ``unit`` is a name of `quantities`, None where the frame
    does not state it; ``channel`` and ``mode`` (such as a judgement) are as sent, or None.
    ``raw`` is the received line without its end.
    """

    text: str
    unit: str | None
    channel: str | None
    mode: str | None
    raw: bytes

    @property
    def value(self) -> Decimal:
        """The number, in ``unit``."""
        return Decimal(self.text)

    @property
    def decimals(self) -> int:
        """How many digits follow the point."""
        return len(self.text.partition(".")[2])

    @property
    def resolution(self) -> Decimal:
        """One count of the last place, in ``unit``."""
        return Decimal(1).scaleb(-self.decimals)


@dataclass(frozen=True, slots=True)
class InstrumentFault:
    """The instrument says that there is no valid reading: an error, a hold value, over-range."""

    code: str
    message: str
    raw: bytes
    channel: str | None = None


@dataclass(frozen=True, slots=True)
class DeviceNotice:
    """A line that is well formed and no reading: identification, echo, status, battery.

    ``unit`` is set where the line states the unit of the display (the answer to a unit request);
    ``switched_on`` where the instrument sends it only then: its zero is gone.
    """

    message: str
    raw: bytes
    unit: str | None = None
    switched_on: bool = False


@dataclass(frozen=True, slots=True)
class Garbage:
    """Bytes that are not a frame of the dialect; ``raw`` holds at most the longest frame."""

    reason: str
    raw: bytes


Event: TypeAlias = Reading | InstrumentFault | DeviceNotice | Garbage


@dataclass(frozen=True, slots=True)
class LineSettings:
    """Settings of a serial port; ``dtr`` and ``rts`` before it is opened, None for no matter."""

    baud: int = 9600
    data_bits: int = 8
    parity: Parity = "N"
    stop_bits: int = 1
    dtr: bool | None = None
    rts: bool | None = None

    def __post_init__(self) -> None:
        good = {
            "baud": 50 <= self.baud <= 4_000_000,
            "data bits": self.data_bits in (7, 8),
            "parity": self.parity in ("N", "E", "O"),
            "stop bits": self.stop_bits in (1, 2),
        }
        if wrong := [name for name, holds in good.items() if not holds]:
            raise UsageError(
                f"serial line: {', '.join(wrong)} out of range",
                remedy="baud 50 to 4000000; 7 or 8 data bits; parity N, E or O; 1 or 2 stop bits",
            )

    @classmethod
    def of(cls, text: str, *, dtr: bool | None = None, rts: bool | None = None) -> LineSettings:
        """Return the settings of a text such as ``4800 7E2``."""
        baud, frame = text.split()
        parity = cast("Parity", frame[1])
        return cls(int(baud), int(frame[0]), parity, int(frame[2]), dtr, rts)

    def __str__(self) -> str:
        return f"{self.baud} {self.data_bits}{self.parity}{self.stop_bits}"


@dataclass(frozen=True, slots=True)
class LinePulse:
    """A request made by a modem line: hold ``line`` at ``level`` for ``seconds``, then back."""

    line: Literal["dtr", "rts"]
    level: bool
    seconds: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """How one family of indicators speaks; a module of this folder holds one as ``DIALECT``.

    ``parse`` takes one received line (its end removed) and returns what it says, one event for
    each value in it, or nothing for a line that is not one of its frames. ``compose(text, unit,
    channel)`` returns the frame, its end included, that an instrument showing that value sends;
    it raises `UsageError` where the display cannot show it.
    """

    key: str
    instruments: str
    line: LineSettings
    parse: Callable[[bytes], tuple[Event, ...]] = field(repr=False)
    compose: Callable[[str, str | None, str | None], bytes] = field(repr=False)
    longest_frame: int
    """Bytes of the longest line, its end not counted."""
    digits: int
    """Digits of the display."""
    decimals: tuple[int, ...]
    """How many of them may follow the point, the usual one first."""
    units: tuple[str | None, ...]
    """Units that a frame may state, the usual one first; None for a frame without one."""
    source: str
    confidence: Literal["high", "medium", "low"]
    cable: str = ""
    """What connects it to the computer, and where its power comes from."""
    terminator: bytes = b"\r"
    """What the instrument sends after a line; the decoder takes CR, LF or both."""
    request_template: bytes | None = None
    request_line: LinePulse | None = None
    unit_request: bytes | None = None
    channels: tuple[str, ...] = ()
    channel: str | None = None
    """The channel asked for and listened to; None for an instrument without channels."""
    answer_time_s: float = 1.0
    """A request not answered in this time failed; a later answer belongs to it all the same."""
    bit_8_undefined: bool = False
    fixed_decimals: bool = True
    """Whether the decimals that are sent change only with unit or resolution of the display."""
    unverified: tuple[str, ...] = ()
    """What no source states: the user checks it, or sets it by option."""

    @property
    def request(self) -> bytes | None:
        """Bytes that ask for one reading; None where the instrument sends by itself."""
        if self.request_template is None:
            return None
        return self.request_template.replace(b"{channel}", (self.channel or "").encode("ascii"))

    @property
    def asks(self) -> bool:
        """Whether readings are asked for; otherwise the instrument only sends by itself."""
        return self.request_template is not None or self.request_line is not None

    @property
    def sends_unit(self) -> bool:
        """Whether every frame states its unit; otherwise the user must."""
        return None not in self.units

    def configure(self, *, channel: str | None = None, **line: Any) -> Dialect:
        """Return the dialect with the user's options in it; `UsageError` for an impossible one.

        ``line`` holds fields of `LineSettings`; what is None stays as it is.
        """
        if channel is not None and channel not in self.channels:
            known = ", ".join(self.channels[:9]) + (" ..." if len(self.channels) > 9 else "")
            raise UsageError(
                f"{self.key} has no channel {channel!r}", remedy=f"channels: {known or 'none'}"
            )
        stated = {name: value for name, value in line.items() if value is not None}
        line_settings = replace(self.line, **stated)
        return replace(self, line=line_settings, channel=channel or self.channel)


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
        return Garbage(diagnose_parity(line) or f"not read by {self._dialect.key}", line)

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
