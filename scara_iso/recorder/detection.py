"""Which dialect an indicator speaks: each asks in its own way, and reads what comes back."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.recorder.indicators import (
    Decoder,
    Dialect,
    Garbage,
    LinePulse,
    Reading,
    find_dialects,
)
from scara_iso.recorder.ports import Clock, Port, choose_clock, list_devices, open_port

AUTO = "auto"
"""The driver of a gauge whose dialect is to be found."""
LISTEN_S = 0.5
_LINGER_S = 0.05
_MAKERS = {"0fe7": "Mitutoyo"}
"""Makers whose USB identity tells that it is theirs; an adapter's says nothing of the gauge."""
_LINE_END = re.compile(rb"[\r\n]+")
_Request = tuple[bytes | None, LinePulse | None]
Opened = Callable[[str, Dialect], tuple[Port, Clock]]


@dataclass(frozen=True, slots=True)
class Detected:
    """What a port was found to speak: the dialects that understood all of an answer to them."""

    address: str
    tried: int
    fits: Mapping[str, bytes]
    """What came, by the key of each dialect that understands it."""
    maker: str | None
    """Whose dialects were tried alone, because the port's USB identity says so."""

    def __str__(self) -> str:
        among = f"{self.tried} dialects" + (f" of {self.maker}" if self.maker else "")
        found = ", ".join(f"{key} ({_shown(data)})" for key, data in self.fits.items())
        return f"{self.address} speaks {found or 'none'} of {among} tried"


def _opened(address: str, dialect: Dialect) -> tuple[Port, Clock]:
    """Return a port and the time that passes on it: a simulated port sets a clock of its own."""
    clock = choose_clock([address])
    return open_port(address, dialect, axis="X", clock=clock, asked=True), clock


def detect(address: str, *, opened: Opened = _opened) -> Detected:
    """Ask a port for a reading in every dialect that fits its identity.

    A dialect fits where every line that came in answer to its own request is one of its frames,
    ended as it ends them, and one is a reading; a dialect that is not asked, where such lines came
    by themselves. ``opened`` gives the port with a dialect's line settings, anew for each, and its
    clock. Raises `InstrumentError` where the port cannot be opened at all.
    """
    maker, dialects = _candidates(address)
    fits: dict[str, bytes] = {}
    refused: list[InstrumentError] = []
    ordered = sorted(dialects, key=_line)
    lines = [tuple(group) for _, group in groupby(ordered, key=_line)]
    for group in lines:
        try:
            fits |= _on_one_line(*opened(address, group[0]), group)
        except InstrumentError as error:
            refused.append(error)
    if len(refused) == len(lines):
        raise refused[0]
    return Detected(address, len(dialects), dict(sorted(fits.items())), maker)


def name_dialects(
    texts: Iterable[str],
    tell: Callable[[str], None],
    *,
    find: Callable[[str], Detected] = detect,
) -> tuple[str, ...]:
    """Return gauges as written, `AUTO` replaced by the one dialect that its port speaks.

    ``tell`` hears which and why. Raises `InstrumentError` where none fits, or more than one.
    """
    return tuple(_named(text, tell, find) for text in texts)


def _named(text: str, tell: Callable[[str], None], find: Callable[[str], Detected]) -> str:
    name, _, rest = text.partition("=")
    driver, at, address = rest.partition("@")
    key, mark, options = driver.partition("?")
    if key.strip() != AUTO or not at:
        return text
    if address.strip() == "keyboard:":
        raise UsageError("a keyboard speaks no dialect", remedy=f"write {name}=keyboard@keyboard:")
    found = find(address.strip())
    if len(found.fits) != 1:
        raise _undecided(name, found)
    tell(f"{name}: {found}")
    return f"{name}={next(iter(found.fits))}{mark}{options}@{address}"


def _undecided(name: str, found: Detected) -> InstrumentError:
    if found.fits:
        return InstrumentError(
            f"more than one dialect fits: {found}",
            where=f"gauge {name}",
            remedy="`scara-iso ports` lists the drivers and their instruments: "
            f"{name}={next(iter(found.fits))}@{found.address}",
        )
    return InstrumentError(
        str(found),
        where=f"gauge {name}",
        remedy="switch the indicator on and its data output too, press DATA while it is tried, "
        f"or name its driver: {name}=opto-rs232@{found.address}",
    )


def _candidates(address: str) -> tuple[str | None, tuple[Dialect, ...]]:
    dialects = tuple(d for key, d in find_dialects().items() if key not in ("generic", "keyboard"))
    usb = next((device.usb for device in list_devices() if device.name == address), None)
    maker = _MAKERS.get((usb or "").partition(":")[0])
    chosen = tuple(d for d in dialects if maker is None or maker in d.instruments)
    return maker, chosen


def _line(dialect: Dialect) -> tuple[str, str]:
    """Return what tells two lines apart, their power by the modem lines included."""
    return str(dialect.line), f"{dialect.line.dtr} {dialect.line.rts}"


def _on_one_line(port: Port, clock: Clock, dialects: Sequence[Dialect]) -> dict[str, bytes]:
    """Return what came for each dialect that understands it; all share the port's settings."""
    try:
        _receive(port, clock, port.settle_s)
        heard: dict[_Request, bytes] = {(None, None): _receive(port, clock, LISTEN_S)}
        for dialect in dialects:
            request = (dialect.request, dialect.request_line)
            if request not in heard:
                heard[request] = _answer(port, clock, dialect)
    finally:
        port.close()
    came = {d.key: heard[d.request, d.request_line] for d in dialects}
    return {d.key: came[d.key] for d in dialects if understands(d, came[d.key])}


def _answer(port: Port, clock: Clock, dialect: Dialect) -> bytes:
    port.read()
    if dialect.request is not None:
        port.write(dialect.request)
    elif dialect.request_line is not None:
        port.pulse(dialect.request_line)
    return _receive(port, clock, dialect.answer_time_s, until_line=True)


def _receive(port: Port, clock: Clock, seconds: float, *, until_line: bool = False) -> bytes:
    """Return what comes within ``seconds``, or until a line has ended and no more follows."""
    received, deadline = b"", clock.now() + seconds
    while clock.now() < deadline:
        more = port.read()
        received += more
        if until_line and more and _LINE_END.search(received):
            deadline = min(deadline, clock.now() + _LINGER_S)
        if not more:
            clock.idle(deadline)
    return received


def understands(dialect: Dialect, received: bytes) -> bool:
    """Say whether every line is a frame of the dialect, and one a reading.

    Where nobody was asked, the first line may have begun before.
    """
    whole = received
    if dialect.request is None and dialect.request_line is None:
        first, end, rest = _parted(received)
        whole = rest if _LINE_END.search(rest) else first + end
    ends = set(_LINE_END.findall(whole))
    events = list(Decoder(dialect).feed(whole))
    return (
        ends <= {dialect.terminator}
        and any(isinstance(event, Reading) for event in events)
        and not any(isinstance(event, Garbage) for event in events)
    )


def _parted(received: bytes) -> tuple[bytes, bytes, bytes]:
    end = _LINE_END.search(received)
    if end is None:
        return received, b"", b""
    return received[: end.start()], end.group(), received[end.end() :]


def _shown(data: bytes) -> str:
    return repr(data[:40])[2:-1]
