"""Which device a port is: equal adapters must not change places unseen."""

from __future__ import annotations

import os
import stat
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from serial.tools.list_ports import comports

from scara_iso.acquisition.ports.address import is_bluetooth, is_url
from scara_iso.errors import UsageError


@dataclass(frozen=True, slots=True)
class Device:
    """A serial port of this machine; null is what the system does not know."""

    name: str
    """By which it is opened."""
    description: str
    """As the system says it."""
    usb: str | None
    """`VID:PID`."""
    serial_number: str | None
    """Of the USB device."""
    location: str | None
    """Of the socket."""

    def __str__(self) -> str:
        parts = [f"usb {self.usb}"] if self.usb else []
        parts += [f"serial {self.serial_number}"] if self.serial_number else []
        parts += [f"location {self.location}"] if self.location else []
        return " ".join(parts) or self.description


def list_devices() -> tuple[Device, ...]:
    """Return the serial ports of this machine, by name."""
    found = [
        Device(
            name=port.device,
            description=port.description or "",
            usb=None if port.vid is None else f"{port.vid:04x}:{port.pid:04x}",
            serial_number=port.serial_number or None,
            location=port.location or None,
        )
        for port in comports()
    ]
    return tuple(sorted(found, key=lambda device: device.name))


def describe(address: str) -> str:
    """Return one line that tells the device behind ``address`` from another."""
    device = _find(address)
    return f"{address} ({device})" if device else address


def refuse_same_device(addresses: Mapping[str, str]) -> None:
    """Raise `UsageError` where two axes (the keys) name one device, by whatever names."""
    seen: dict[object, str] = {}
    for axis, address in addresses.items():
        for key in _keys(address):
            other = seen.setdefault(key, axis)
            if other != axis:
                raise UsageError(
                    f"{other} and {axis} are the same device: {addresses[other]} and {address}",
                    remedy="give each axis its own indicator",
                )


def _keys(address: str) -> list[object]:
    """Return what two names of one device have in common."""
    if is_url(address) or is_bluetooth(address):
        return [address.lower()]
    device = _find(address)
    keys: list[object] = [os.path.normcase(_real(address))]
    keys += [("location", device.location)] if device and device.location else []
    try:
        status = Path(address).stat()
    except OSError:
        return keys
    return [*keys, ("device", status.st_rdev)] if stat.S_ISCHR(status.st_mode) else keys


def _find(address: str) -> Device | None:
    if is_url(address) or is_bluetooth(address):
        return None
    real = os.path.normcase(_real(address))
    return next((d for d in list_devices() if os.path.normcase(_real(d.name)) == real), None)


def _real(name: str) -> str:
    return os.path.realpath(name) if os.sep == "/" else name.removeprefix("\\\\.\\").upper()
