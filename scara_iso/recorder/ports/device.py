"""A serial device or pyserial URL, held for real: the one place that talks to pyserial.

The line on which a robot speaks: a serial device, or a socket of which no byte is dropped.

pyserial empties its buffer when it opens a socket; a robot that speaks first would not be heard.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import socket
import time
from pathlib import Path
from typing import Any

import serial

from scara_iso.base.errors import InstrumentError
from scara_iso.recorder.indicators import LinePulse, LineSettings
from scara_iso.recorder.ports.listening import LISTEN, ListeningLine
from scara_iso.recorder.ports.port import check_device, describe, number_option, split_options

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
_CANNOT_DO = 22


class DevicePort:
    """An open port: exclusive, never waiting, its modem lines set before it was opened.

    Raises `UsageError` for what is not such an address, and `InstrumentError` where the port cannot
    be opened with these settings.
    """

    unit: str | None = None
    unit_confirmed = False
    settle_s = SETTLE_S
    ended = False
    simulated = False

    def __init__(self, address: str, line: LineSettings) -> None:
        check_device(address)
        self.address = address
        self.identity = describe(address)
        self._serial = _prepare(address, line)
        try:
            _open(self._serial, address)
            _exclude_others(self._serial)
            self.identity += _check_parity(self._serial, line)
        except _NOT_OPENED as error:
            self.close()
            raise _cannot_open(address, line, error) from error

    def read(self) -> bytes:
        """Return what has arrived."""
        try:
            return bytes(self._serial.read(_CHUNK))
        except _LOST as error:
            raise self._lost(error) from error

    def write(self, data: bytes) -> None:
        """Send."""
        try:
            self._serial.write(data)
        except _LOST as error:
            raise self._lost(error) from error

    def pulse(self, pulse: LinePulse) -> None:
        """Hold the modem line as the dialect says, then let it go back."""
        try:
            setattr(self._serial, pulse.line, pulse.level)
            time.sleep(pulse.seconds)
            setattr(self._serial, pulse.line, not pulse.level)
        except _LOST as error:
            raise self._lost(error) from error

    def close(self) -> None:
        """Close; a lost port may fail at that too."""
        with contextlib.suppress(*_LOST):
            self._serial.close()

    def _lost(self, error: Exception) -> InstrumentError:
        return InstrumentError(
            f"the port is lost ({error})",
            where=self.address,
            remedy="the cable or the indicator was unplugged or switched off, or another program "
            "reads this port; correct that, check zero and unit",
        )


def _prepare(address: str, line: LineSettings) -> Any:
    port = serial.serial_for_url(address, do_not_open=True)
    port.baudrate, port.bytesize = line.baud, line.data_bits
    port.parity, port.stopbits = line.parity, line.stop_bits
    port.timeout = 0
    if isinstance(port, serial.Serial):
        port.write_timeout = 2
        port.exclusive = True
    if line.dtr is not None:
        port.dtr = line.dtr
    if line.rts is not None:
        port.rts = line.rts
    return port


def _open(port: Any, address: str) -> None:
    """Open; a pseudo-terminal may refuse a parity, which has no meaning there."""
    try:
        port.open()
    except _NOT_OPENED as error:
        if _code(error) != _CANNOT_DO or not _PSEUDO.fullmatch(str(Path(address).resolve())):
            raise
        port.bytesize, port.parity, port.stopbits = 8, "N", 1
        port.open()


def _check_parity(port: Any, line: LineSettings) -> str:
    """Have the driver mark bytes of a wrong parity (0xFF 0x00 before them): no frame holds those.

    pyserial sets the parity and never checks it. A break is not a byte. Returns what is to be said
    where the device has no parity.
    """
    if termios is None or line.parity == "N" or not isinstance(port, serial.Serial):
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


def _exclude_others(port: Any) -> None:
    """Keep out programs that ask for no lock: the lock of pyserial is advisory."""
    if termios is not None and isinstance(port, serial.Serial):
        ioctl(port.fileno(), termios.TIOCEXCL)


def refuse_absent(address: str, line: LineSettings) -> None:
    """Raise `InstrumentError` where a port that is a file's name is not there."""
    if address.startswith("/") and not Path(address).exists():
        raise _cannot_open(address, line, OSError(errno.ENOENT, ""))


def _cannot_open(address: str, line: LineSettings, error: Exception) -> InstrumentError:
    match _code(error):
        case 2:
            remedy = "`scara-iso ports` lists the ports that are there"
        case 13:
            remedy = "no permission: join the group that owns the device (often dialout)"
        case 11 | 16:
            remedy = "another program holds this port: close it"
        case 22:
            remedy = f"this hardware cannot do {line}: use another adapter"
        case _:
            remedy = "check the address, the cable and that no other program holds the port"
    said = _errno_text(error)
    return InstrumentError(f"cannot be opened ({said})", where=address, remedy=remedy)


def _errno_text(error: Exception) -> str:
    """Return what the system says of an error, without the words of pyserial around it."""
    code = _code(error)
    return os.strerror(code) if isinstance(code, int) else str(error)


_SOCKET = re.compile(r"socket://\[?(.+?)\]?:([0-9]+)", re.IGNORECASE)
_CONNECT_S = 5.0


class SocketLine:
    """A connection to a server, never waiting; `InstrumentError` where it cannot be, or is lost."""

    def __init__(self, address: str, host: str, port: int) -> None:
        self.address = address
        try:
            self._socket = socket.create_connection((host, port), timeout=_CONNECT_S)
        except OSError as error:
            raise InstrumentError(
                f"cannot be opened ({error})", where=address, remedy="check that the robot listens"
            ) from error
        self._socket.setblocking(False)

    def read(self) -> bytes:
        """Return what has arrived, at once."""
        try:
            data = self._socket.recv(_CHUNK)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise self._lost(str(error)) from error
        if not data:
            raise self._lost("the other end has closed it")
        return data

    def write(self, data: bytes) -> None:
        """Send; what the robot's end has no room for is not waited for."""
        try:
            self._socket.send(data)
        except BlockingIOError:
            return
        except OSError as error:
            raise self._lost(str(error)) from error

    def close(self) -> None:
        """Close."""
        with contextlib.suppress(OSError):
            self._socket.close()

    def _lost(self, why: str) -> InstrumentError:
        return InstrumentError(
            f"the robot's line is lost ({why})",
            where=self.address,
            remedy="reconnect it",
        )


def open_line(text: str) -> SocketLine | DevicePort | ListeningLine:
    """Open ``socket://HOST:PORT``, ``listen://ADDRESS:PORT``, or a device at ``?baud=9600``.

    Raises `UsageError` for another address and `InstrumentError` where it cannot be opened.
    """
    if text.startswith(LISTEN):
        return ListeningLine(text)
    address, options = split_options(text, {"baud": "9600"})
    check_device(address)
    found = _SOCKET.fullmatch(address)
    if found is not None:
        return SocketLine(address, found[1], int(found[2]))
    return DevicePort(address, LineSettings(baud=int(number_option(options, "baud", 9600))))
