"""The only place that opens ports: cables and URLs, Bluetooth, recorded streams, simulations."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from scara_iso.recorder.indicators import Dialect, LineSettings
from scara_iso.recorder.ports import replay, simulated
from scara_iso.recorder.ports.device import DevicePort
from scara_iso.recorder.ports.listening import LISTEN, ListeningLine, SocketLine
from scara_iso.recorder.ports.port import (
    Clock,
    Port,
    StreamClock,
    check_device,
    is_device,
    number_option,
    port_kind,
    split_options,
)
from scara_iso.recorder.ports.replay import ReplayLine, ReplayPort
from scara_iso.recorder.ports.simulated import KeyboardPort, SimulatedPort


def choose_clock(addresses: Iterable[str]) -> Clock:
    """Return the system's clock, or a stream's where no port is a cable."""
    addresses = tuple(addresses)
    if any(map(is_device, addresses)):
        return Clock()
    return StreamClock(paced=True in [_is_paced(one) for one in addresses])  # each is checked


def _is_paced(address: str) -> bool:
    """Say whether a simulation keeps to real time, or a recording to its own."""
    kind, _, rest = address.partition(":")
    known, usual = {"sim": (simulated.OPTIONS, "1"), "replay": (replay.OPTIONS, "0")}[kind]
    return split_options(rest, known)[1].get("pace", usual) != "0"


def open_port(
    address: str,
    dialect: Dialect,
    *,
    axis: str,
    clock: Clock,
    asked: bool,
    watched: bool = False,
    typed: Callable[[], bytes] | None = None,
) -> Port:
    """Open the port that ``address`` names, with the dialect's line settings.

    ``asked`` says that readings will be asked for; otherwise they come by themselves. The
    arm at a simulated indicator comes and goes by itself where it is ``watched``. ``typed`` gives
    the lines of the keyboard. Raises `UsageError`, `NoInputError`, `DataError` or
    `InstrumentError`.
    """
    match port_kind(address):
        case "sim":
            return SimulatedPort(
                address, dialect, axis=axis, clock=clock, asked=asked, watched=watched
            )
        case "replay":
            return ReplayPort(address, dialect, axis=axis, clock=clock, asked=asked)
        case "keyboard":
            return KeyboardPort(typed)
        case "ble":
            from scara_iso.recorder.ports.bluetooth import (  # noqa: PLC0415 - asyncio
                BluetoothPort,
            )

            return BluetoothPort(address)
    return DevicePort(address, dialect.line)


def open_line(text: str, clock: Clock) -> Port:
    """Open ``socket://HOST:PORT``, ``listen://ADDRESS:PORT``, or a device at ``?baud=9600``.

    ``replay:FILE`` has the robot of a raw file say its visits again, by the ``clock``. Raises
    `UsageError` for another address and `InstrumentError` where it cannot be opened.
    """
    if port_kind(text) == "replay":
        return ReplayLine(text, clock)
    if text.startswith(LISTEN):
        return ListeningLine(text)
    address, options = split_options(text, {"baud": "9600"})
    check_device(address)
    if address.lower().startswith("socket:"):
        return SocketLine(address)
    return DevicePort(address, LineSettings(baud=int(number_option(options, "baud", 9600))))
