"""The only place that opens ports: cables and URLs, Bluetooth, recorded streams, simulations."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeAlias

from scara_iso.recorder.indicators import Dialect
from scara_iso.recorder.ports.device import (
    DevicePort,
    SocketLine,
    open_line,
    refuse_absent,
)
from scara_iso.recorder.ports.listening import (
    LISTEN,
    Connection,
    ListeningLine,
    listen_address,
)
from scara_iso.recorder.ports.port import (
    POLL_S,
    Clock,
    Device,
    Port,
    StreamClock,
    SystemClock,
    check_address,
    is_bluetooth,
    is_device,
    is_keyboard,
    is_recorded,
    is_simulated,
    list_devices,
    number_option,
    refuse_same_device,
    split_options,
)
from scara_iso.recorder.ports.replay import (
    PULSE,
    ReplayPort,
    replay_is_paced,
    replayed_poses,
)
from scara_iso.recorder.ports.simulated import (
    KeyboardPort,
    Signal,
    SimulatedPort,
    simulation_is_paced,
)

__all__ = [
    "LISTEN",
    "POLL_S",
    "PULSE",
    "Clock",
    "Connection",
    "Device",
    "DevicePort",
    "KeyboardPort",
    "ListeningLine",
    "OpenLine",
    "Port",
    "ReplayPort",
    "Signal",
    "SimulatedPort",
    "SocketLine",
    "StreamClock",
    "SystemClock",
    "check_address",
    "choose_clock",
    "is_device",
    "is_keyboard",
    "is_recorded",
    "is_simulated",
    "list_devices",
    "listen_address",
    "number_option",
    "open_line",
    "open_port",
    "refuse_absent",
    "refuse_same_device",
    "replayed_poses",
    "split_options",
]


OpenLine: TypeAlias = DevicePort | SocketLine | ListeningLine
"""A line on which a robot speaks."""


def choose_clock(addresses: Iterable[str]) -> Clock:
    """Return the system's clock, or a stream's where no port is a cable."""
    addresses = tuple(addresses)
    if any(map(is_device, addresses)):
        return SystemClock()
    paced = [simulation_is_paced(a) if is_simulated(a) else replay_is_paced(a) for a in addresses]
    return StreamClock(paced=any(paced))


def open_port(
    address: str,
    dialect: Dialect,
    *,
    axis: str,
    clock: Clock,
    asked: bool,
    source: Signal | None = None,
    watched: bool = False,
    typed: Callable[[], bytes] | None = None,
) -> Port:
    """Open the port that ``address`` names, with the dialect's line settings.

    ``asked`` says that readings will be asked for; otherwise they come by themselves. ``source``
    feeds a simulated indicator, whose arm comes and goes by itself where it is ``watched``.
    ``typed`` gives the lines of the keyboard. Raises `UsageError`, `NoInputError`, `DataError` or
    `InstrumentError`.
    """
    if is_simulated(address):
        return SimulatedPort(
            address, dialect, axis=axis, clock=clock, asked=asked, source=source, watched=watched
        )
    if is_recorded(address):
        return ReplayPort(address, dialect, axis=axis, clock=clock, asked=asked)
    if is_keyboard(address):
        return KeyboardPort(typed)
    if is_bluetooth(address):
        from scara_iso.recorder.ports.bluetooth import BluetoothPort  # noqa: PLC0415 - asyncio

        return BluetoothPort(address)
    return DevicePort(address, dialect.line)
