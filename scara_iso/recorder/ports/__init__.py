"""The only place that opens ports: cables and URLs, Bluetooth, recorded streams, simulations."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeAlias

from scara_iso.recorder.indicators import Dialect
from scara_iso.recorder.ports.device import (
    DevicePort as DevicePort,
    SocketLine as SocketLine,
    open_line as open_line,
    refuse_absent as refuse_absent,
)
from scara_iso.recorder.ports.listening import (
    LISTEN as LISTEN,
    Connection as Connection,
    ListeningLine as ListeningLine,
    listen_address as listen_address,
)
from scara_iso.recorder.ports.port import (
    POLL_S as POLL_S,
    Clock as Clock,
    Device as Device,
    Port as Port,
    StreamClock as StreamClock,
    SystemClock as SystemClock,
    check_address as check_address,
    is_bluetooth,
    is_device as is_device,
    is_keyboard as is_keyboard,
    is_recorded as is_recorded,
    is_simulated as is_simulated,
    list_devices as list_devices,
    number_option as number_option,
    refuse_same_device as refuse_same_device,
    split_options as split_options,
)
from scara_iso.recorder.ports.replay import (
    PULSE as PULSE,
    ReplayPort as ReplayPort,
    replay_is_paced,
    replayed_poses as replayed_poses,
)
from scara_iso.recorder.ports.simulated import (
    KeyboardPort as KeyboardPort,
    SimulatedPort as SimulatedPort,
    simulation_is_paced,
)

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
    watched: bool = False,
    typed: Callable[[], bytes] | None = None,
) -> Port:
    """Open the port that ``address`` names, with the dialect's line settings.

    ``asked`` says that readings will be asked for; otherwise they come by themselves. The
    arm at a simulated indicator comes and goes by itself where it is ``watched``. ``typed`` gives
    the lines of the keyboard. Raises `UsageError`, `NoInputError`, `DataError` or
    `InstrumentError`.
    """
    if is_simulated(address):
        return SimulatedPort(address, dialect, axis=axis, clock=clock, asked=asked, watched=watched)
    if is_recorded(address):
        return ReplayPort(address, dialect, axis=axis, clock=clock, asked=asked)
    if is_keyboard(address):
        return KeyboardPort(typed)
    if is_bluetooth(address):
        from scara_iso.recorder.ports.bluetooth import BluetoothPort  # noqa: PLC0415 - asyncio

        return BluetoothPort(address)
    return DevicePort(address, dialect.line)
