"""Which dialect an indicator speaks, and whether a gauge reads: asked before anything is recorded.

Each dialect asks in its own way, and reads what comes back.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TypeVar

from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.recorder.indicators import (
    Decoder,
    DeviceNotice,
    Dialect,
    Garbage,
    LinePulse,
    Reading,
    diagnose_parity,
    find_dialects,
)
from scara_iso.recorder.plan import AUTO, GaugeSpec
from scara_iso.recorder.ports import choose_clock, open_port
from scara_iso.recorder.ports.device import list_devices
from scara_iso.recorder.ports.port import Clock, Port

LISTEN_S = 0.5
_LINGER_S = 0.05
_END = b"\r"
ECHO = "the port sends back what it is sent: a loopback plug, or RX joined to TX; no indicator"
_NO_ECHO = "take the plug off, or cross RX and TX, and connect the indicator"
DATA_S = 20.0
"""Time to press the DATA key of an indicator that is not asked [s]."""
_MAKERS = {"0fe7": "Mitutoyo"}
"""Makers whose USB identity tells that it is theirs; an adapter's says nothing of the gauge."""
_LINE_END = re.compile(rb"[\r\n]+")
_Event = TypeVar("_Event", Reading, DeviceNotice)
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
    echo: bool = False
    """Whether all that came was what was sent."""

    def __str__(self) -> str:
        if self.echo:
            return f"{self.address}: {ECHO}"
        among = f"{self.tried} drivers" + (f" of {self.maker}" if self.maker else "")
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
    came: dict[Dialect, bytes] = {}
    refused: list[InstrumentError] = []
    ordered = sorted(dialects, key=_line)
    lines = [tuple(group) for _, group in groupby(ordered, key=_line)]
    for group in lines:
        try:
            came |= _on_one_line(*opened(address, group[0]), group)
        except InstrumentError as error:
            refused.append(error)
    if len(refused) == len(lines):
        raise refused[0]
    fits = {d.key: came[d] for d in sorted(came, key=lambda d: d.key) if understands(d, came[d])}
    answers = [(data, dialect.request) for dialect, data in came.items() if data]
    echo = bool(answers) and all(is_echo(data, request) for data, request in answers)
    return Detected(address, len(dialects), fits, maker, echo)


def name_dialects(
    texts: Iterable[str], tell: Callable[[str], None], *, opened: Opened = _opened
) -> tuple[str, ...]:
    """Return gauges as written, `AUTO` replaced by the one dialect that its port speaks.

    ``tell`` hears which and why. Raises `InstrumentError` where none fits, or more than one.
    """
    return tuple(_named(text, tell, opened) for text in texts)


def _named(text: str, tell: Callable[[str], None], opened: Opened) -> str:
    axis, _, rest = text.partition("=")
    driver, at, address = rest.partition("@")
    key, mark, options = driver.partition("?")
    if key.strip() != AUTO or not at:
        return text
    if address.strip() == "keyboard:":
        raise UsageError("a keyboard has its own driver", remedy=f"write {axis}=keyboard@keyboard:")
    found = detect(address.strip(), opened=opened)
    if len(found.fits) != 1:
        what = str(found)
        remedy = (
            "switch the indicator on and its data output too, press DATA while it is tried, "
            f"or name its driver: {axis}=opto-rs232@{found.address}"
        )
        if found.echo:
            remedy = _NO_ECHO
        elif found.fits:
            what = f"more than one driver fits: {found}"
            remedy = "name the one of your indicator (scara-iso ports `dialects=`), such as "
            remedy += f"{axis}={next(iter(found.fits))}@{found.address}"
        raise InstrumentError(what, where=f"gauge {axis}", remedy=remedy)
    tell(f"{axis}: {found}")
    return f"{axis}={next(iter(found.fits))}{mark}{options}@{address}"


@dataclass(frozen=True, slots=True)
class FirstReading:
    """What a gauge showed when it was tried; ``unit`` as it or its port states it, else None."""

    text: str
    unit: str | None
    answered: bool
    """Whether it was asked for, and did not come by the DATA key."""


def read_once(
    spec: GaugeSpec, press: Callable[[], None] | None = None, *, opened: Opened = _opened
) -> FirstReading:
    """Return one reading of a gauge and its unit.

    Where it does not answer, or is not asked, ``press`` tells somebody to press DATA within
    `DATA_S`. Raises `InstrumentError` where nothing comes that is a reading.
    """
    port, clock = opened(spec.address, spec.dialect)
    dialect, decoder, received = spec.dialect, Decoder(spec.dialect), bytearray()

    def first(kind: type[_Event], seconds: float) -> _Event | None:
        for data in _arrivals(port, clock, seconds):
            received.extend(data)
            if found := [one for one in decoder.feed(data) if isinstance(one, kind)]:
                return found[0]
        return None

    try:
        _receive(port, clock, port.settle_s)
        port.ask(dialect)
        reading = first(Reading, dialect.answer_time_s) if dialect.asks else None
        answered = reading is not None
        if reading is None and press is not None:
            press()
            reading = first(Reading, DATA_S)
        if reading is None:
            raise _no_reading(spec, bytes(received))
        unit = port.unit or reading.unit
        if unit is None and dialect.unit_request is not None:
            port.write(dialect.unit_request)
            notice = first(DeviceNotice, dialect.answer_time_s)
            unit = notice.unit if notice else None
    finally:
        port.close()
    if None not in (unit, spec.unit) and unit != spec.unit:
        raise InstrumentError(
            f"the indicator shows {unit}, and the option says {spec.unit}",
            where=spec.address,
            remedy="set one of them right",
        )
    return FirstReading(reading.text, unit, answered)


def _no_reading(spec: GaugeSpec, received: bytes) -> InstrumentError:
    if is_echo(received, spec.dialect.request):
        return InstrumentError(ECHO, where=spec.address, remedy=_NO_ECHO)
    came = f"only {_shown(received)}" if received else "nothing"
    return InstrumentError(
        f"{spec.dialect.key}: no reading came, {came}",
        where=spec.address,
        remedy=diagnose_parity(received)
        or "check that the indicator and its data output are on, and the cable",
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


def _on_one_line(port: Port, clock: Clock, dialects: Sequence[Dialect]) -> dict[Dialect, bytes]:
    """Return what came for each dialect; all share the port's settings."""
    try:
        _receive(port, clock, port.settle_s)
        heard: dict[_Request, bytes] = {(None, None): _receive(port, clock, LISTEN_S)}
        for dialect in sorted(dialects, key=_is_open):
            request = (dialect.request, dialect.request_line)
            if request not in heard:
                heard[request] = _answer(port, clock, dialect)
    finally:
        port.close()
    return {d: heard[d.request, d.request_line] for d in dialects}


def is_echo(received: bytes, request: bytes | None) -> bool:
    """Say whether all that came is what was sent, as a loopback plug sends it back."""
    return bool(request and received) and not received.replace(request or b"", b"")


def _answer(port: Port, clock: Clock, dialect: Dialect) -> bytes:
    """Return the answer to a request, which is ended where the dialect leaves it open.

    An instrument of another dialect waits for the end, and would take the next request with it.
    """
    port.read()
    port.ask(dialect)
    answer = b""
    for data in _arrivals(port, clock, dialect.answer_time_s):
        answer += data
        if _LINE_END.search(answer):
            answer += _receive(port, clock, _LINGER_S)
            break
    if _is_open(dialect):
        port.write(_END)
        _receive(port, clock, _LINGER_S)
    return answer


def _is_open(dialect: Dialect) -> bool:
    return dialect.request is not None and not dialect.request.endswith((b"\r", b"\n"))


def _arrivals(port: Port, clock: Clock, seconds: float) -> Iterator[bytes]:
    deadline = clock.now() + seconds
    while clock.now() < deadline:
        if data := port.read():
            yield data
        else:
            clock.idle(deadline)


def _receive(port: Port, clock: Clock, seconds: float) -> bytes:
    return b"".join(_arrivals(port, clock, seconds))


def understands(dialect: Dialect, received: bytes) -> bool:
    """Say whether every line is a frame of the dialect, and one a reading.

    Where nobody was asked, the first line may have begun before.
    """
    end = _LINE_END.search(received)
    if not dialect.asks and end and _LINE_END.search(received, end.end()):
        received = received[end.end() :]
    events = Decoder(dialect).feed(received)
    return (
        set(_LINE_END.findall(received)) <= {dialect.terminator}
        and any(isinstance(event, Reading) for event in events)
        and not any(isinstance(event, Garbage) for event in events)
    )


def _shown(data: bytes) -> str:
    return repr(data[:40])[2:-1]
