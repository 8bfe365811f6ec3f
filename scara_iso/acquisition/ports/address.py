"""What a port may be called: the one list of kinds, so that no address reaches a file or a program.

pyserial knows more kinds of URL than these, and among them some that write files.
"""

from __future__ import annotations

import os
import re
import stat
from contextlib import suppress
from pathlib import Path

from scara_iso.errors import InstrumentError, UsageError

KINDS = (
    "a device, socket://HOST:PORT, rfc2217://HOST:PORT, ble:ADDRESS, replay:FILE, sim: or keyboard:"
)
_URL = re.compile(
    r"(?:socket|rfc2217)://(?:[a-z0-9._-]{1,253}|\[[0-9a-f:.]{2,45}\]):([0-9]{1,5})", re.IGNORECASE
)
_BLUETOOTH = re.compile(
    r"ble:((?:[0-9a-f]{2}:){5}[0-9a-f]{2}|[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12})",
    re.IGNORECASE,
)
"""With the six bytes of an address, or the UUID that macOS has in its place."""
_SCHEME = re.compile(r"[a-z][a-z0-9+.-]*:", re.IGNORECASE)


def is_simulated(address: str) -> bool:
    """Say whether the address names a simulated indicator."""
    return address.startswith("sim:")


def is_recorded(address: str) -> bool:
    """Say whether the address names a recorded stream."""
    return address.startswith("replay:")


def is_keyboard(address: str) -> bool:
    """Say whether the address names the keyboard, or the lines of standard input."""
    return address == "keyboard:"


def is_bluetooth(address: str) -> bool:
    """Say whether the address names a Bluetooth instrument."""
    return _BLUETOOTH.fullmatch(address) is not None


def bluetooth_address(address: str) -> str:
    """Return the instrument's own address; `UsageError` for another kind of port."""
    found = _BLUETOOTH.fullmatch(address)
    if found is None:
        raise UsageError("no such kind of port", where=address, remedy=f"use {KINDS}")
    return found[1].upper()


def is_device(address: str) -> bool:
    """Say whether the address names a cable, a link or a URL: neither recorded nor simulated."""
    return not (is_simulated(address) or is_recorded(address))


def is_url(address: str) -> bool:
    """Say whether the address names a serial server."""
    found = _URL.fullmatch(address)
    return found is not None and int(found[1]) < 65536


def check_address(address: str) -> None:
    """Raise `UsageError` for what is no kind of port; nothing is looked for."""
    kinds = (is_simulated, is_recorded, is_keyboard, is_bluetooth, is_url)
    if any(is_kind(address) for is_kind in kinds):
        return
    if not (address.strip() and address.isprintable()) or _SCHEME.match(address):
        raise UsageError("no such kind of port", where=address, remedy=f"use {KINDS}")


def check_device(address: str) -> None:
    """Raise `UsageError` unless the address names a device or a serial server.

    Raises `InstrumentError` for a file that is there and is not a device.
    """
    check_address(address)
    if is_bluetooth(address):
        raise UsageError("is no serial device", where=address, remedy="name a device or a URL")
    with suppress(OSError):
        mode = Path(address).stat().st_mode
        if not is_url(address) and os.name == "posix" and not stat.S_ISCHR(mode):
            raise InstrumentError(
                "is no serial device", where=address, remedy="`scara-iso ports` lists them"
            )
