"""The line on which a robot speaks: a serial device, or a socket of which no byte is dropped.

pyserial empties its buffer when it opens a socket; a robot that speaks first would not be heard.
"""

from __future__ import annotations

import contextlib
import re
import socket

from scara_iso.acquisition.indicators import LineSettings
from scara_iso.acquisition.ports.address import check_device
from scara_iso.acquisition.ports.device import DevicePort
from scara_iso.acquisition.ports.port import number_option, split_options
from scara_iso.errors import InstrumentError

_SOCKET = re.compile(r"socket://\[?(.+?)\]?:([0-9]+)", re.IGNORECASE)
_CONNECT_S = 5.0
_CHUNK = 4096


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


def open_line(text: str) -> SocketLine | DevicePort:
    """Open ``socket://HOST:PORT``, or a serial device, at ``?baud=9600`` where none is given.

    Raises `UsageError` for another address and `InstrumentError` where it cannot be opened.
    """
    address, options = split_options(text, {"baud": "9600"})
    check_device(address)
    found = _SOCKET.fullmatch(address)
    if found is not None:
        return SocketLine(address, found[1], int(found[2]))
    return DevicePort(address, LineSettings(baud=int(number_option(options, "baud", 9600))))
