"""A serial device or pyserial URL, held for real: the one place that talks to pyserial.

Which device a port is: equal adapters must not change places unseen.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import stat
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import serial
from serial.tools.list_ports import comports

from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.recorder.indicators import LinePulse, LineSettings
from scara_iso.recorder.ports.port import Port, check_device, port_kind

try:
    import termios
    from fcntl import ioctl
except ImportError:  # Windows: a port is always exclusive there
    termios = None  # type: ignore[assignment]

_LOST: tuple[type[Exception], ...] = (serial.SerialException, OSError, TypeError)
"""What pyserial 3.5 raises on a lost port; TypeError on a handle that was closed under it."""
if termios is not None:
    _LOST += (termios.error,)
_NOT_OPENED: tuple[type[Exception], ...] = (*_LOST, ValueError)

SETTLE_S = 0.15
"""Power of an opto cable comes up, and a frame under way at opening ends, in this time [s]."""
_CHUNK = 4096
_PSEUDO = re.compile(r"/dev/(?:pts/|ttys)\d+")
"""Pseudo-terminals of Linux and macOS: no line, so no parity and always eight bits."""


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
        stated = {"usb": self.usb, "serial": self.serial_number, "location": self.location}
        return " ".join(f"{what} {x}" for what, x in stated.items() if x) or self.description


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
                    remedy="give each axis an indicator on a port of its own",
                )


def _keys(address: str) -> list[object]:
    """Return what two names of one device have in common."""
    if port_kind(address) in ("url", "ble"):
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
    if port_kind(address) in ("url", "ble"):
        return None
    real = os.path.normcase(_real(address))
    return next((d for d in list_devices() if os.path.normcase(_real(d.name)) == real), None)


def _real(name: str) -> str:
    return os.path.realpath(name) if os.sep == "/" else name.removeprefix("\\\\.\\").upper()


class DevicePort(Port):
    """An open port: exclusive, never waiting, its modem lines set before it was opened.

    Raises `UsageError` for what is not such an address, and `InstrumentError` where the port cannot
    be opened with these settings.
    """

    settle_s = SETTLE_S

    def __init__(self, address: str, line: LineSettings) -> None:
        check_device(address)
        self.address = address
        self.identity = describe(address)
        self._serial = _prepare(address, line)
        try:
            _open(self._serial, address)
            self.identity += _guard(self._serial, line)
        except _NOT_OPENED as error:
            self.close()
            raise _cannot_open(address, line, error) from error

    def read(self) -> bytes:
        """Return what has arrived."""
        with self._losing():
            return bytes(self._serial.read(_CHUNK))

    def write(self, data: bytes) -> None:
        """Send."""
        with self._losing():
            self._serial.write(data)

    def pulse(self, pulse: LinePulse) -> None:
        """Hold the modem line as the dialect says, then let it go back."""
        with self._losing():
            setattr(self._serial, pulse.line, pulse.level)
            time.sleep(pulse.seconds)
            setattr(self._serial, pulse.line, not pulse.level)

    def close(self) -> None:
        """Close; a lost port may fail at that too."""
        with contextlib.suppress(*_LOST):
            self._serial.close()

    @contextlib.contextmanager
    def _losing(self) -> Iterator[None]:
        try:
            yield
        except _LOST as error:
            raise InstrumentError(
                f"the port is lost ({error})",
                where=self.address,
                remedy="the cable or the indicator was unplugged or switched off, or another "
                "program reads this port; correct that, check zero and unit",
            ) from error


def _prepare(address: str, line: LineSettings) -> Any:
    port = serial.serial_for_url(address, do_not_open=True)
    port.baudrate, port.bytesize = line.baud, line.data_bits
    port.parity, port.stopbits = line.parity, line.stop_bits
    port.timeout = 0
    if isinstance(port, serial.Serial):
        port.write_timeout = 2
        port.exclusive = True
    for name, level in (("dtr", line.dtr), ("rts", line.rts)):
        if level is not None:
            setattr(port, name, level)
    return port


def _open(port: Any, address: str) -> None:
    """Open; a pseudo-terminal may refuse a parity, which has no meaning there."""
    try:
        port.open()
    except _NOT_OPENED as error:
        if _code(error) != errno.EINVAL or not _PSEUDO.fullmatch(str(Path(address).resolve())):
            raise
        port.bytesize, port.parity, port.stopbits = 8, "N", 1
        port.open()


def _guard(port: Any, line: LineSettings) -> str:
    """Keep other programs out, and have the driver mark bytes of a wrong parity.

    The lock of pyserial is advisory; it sets the parity and never checks it. No frame holds the
    mark, 0xFF 0x00 before the byte. A break is not a byte. Returns what is to be said where the
    device has no parity.
    """
    if termios is None or not isinstance(port, serial.Serial):
        return ""
    ioctl(port.fileno(), termios.TIOCEXCL)
    if line.parity == "N":
        return ""
    settings = termios.tcgetattr(port.fileno())
    if not settings[2] & termios.PARENB:
        return f" (a pseudo-terminal: {line} is not set, no parity is checked)"
    settings[0] |= termios.INPCK | termios.PARMRK | termios.IGNBRK
    settings[0] &= ~(termios.IGNPAR | termios.ISTRIP)
    termios.tcsetattr(port.fileno(), termios.TCSANOW, settings)
    return ""


def _code(error: Exception) -> object:
    return getattr(error, "errno", None) or (error.args[0] if error.args else None)


def refuse_absent(address: str, line: LineSettings) -> None:
    """Raise `InstrumentError` where a port that is a file's name is not there."""
    if address.startswith("/") and not Path(address).exists():
        raise _cannot_open(address, line, OSError(errno.ENOENT, ""))


_REMEDIES = {
    errno.ENOENT: "`scara-iso ports` lists the ports that are there",
    errno.EACCES: "no permission: join the group that owns the device (often dialout)",
    errno.EAGAIN: "another program holds this port: close it",
    errno.EBUSY: "another program holds this port: close it",
    errno.EINVAL: "this hardware cannot do {line}: use another adapter",
    None: "check the address, the cable and that no other program holds the port",
}


def _cannot_open(address: str, line: LineSettings, error: Exception) -> InstrumentError:
    """Return the error with what the system says, without the words of pyserial around it."""
    code = _code(error)
    said = os.strerror(code) if isinstance(code, int) else str(error)
    remedy = _REMEDIES.get(code if isinstance(code, int) else None, _REMEDIES[None])
    return InstrumentError(
        f"cannot be opened ({said})", where=address, remedy=remedy.format(line=line)
    )
