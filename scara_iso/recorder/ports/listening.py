"""A robot's line on a socket: one that it serves, or ``listen://ADDRESS:PORT``, served here.

No byte is dropped: pyserial empties its buffer when it opens a socket, and a robot that speaks
first would not be heard. A server binds to the address that is given and to no other. One robot is
connected at a time; a second is refused. A robot that was switched off is found to be gone by the
connection's own keep-alive.
"""

from __future__ import annotations

import contextlib
import ipaddress
import os
import re
import select
import socket

from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.recorder.ports.port import Connection, Port, split_options

LISTEN = "listen://"
_ADDRESS = re.compile(r"listen://(\[[0-9a-fA-F:.]{2,45}\]|[0-9.]{7,15}|localhost):([0-9]{1,5})")
_EXAMPLE = "listen://192.168.1.10:5000, with this machine's address on the robot's network"
_CHUNK = 4096
_QUEUE = 4
_MOST_REFUSED = 20
"""As many refused connections are reported: a stranger who tries on does not fill the disk."""
_KEEP_ALIVE = {"TCP_KEEPIDLE": 5, "TCP_KEEPINTVL": 2, "TCP_KEEPCNT": 3}
"""A robot without power is gone after eleven seconds [s, s, probes]."""


def listen_address(text: str) -> tuple[str, int, str | None]:
    """Return address, port and the one peer that may connect, None where any may.

    Raises `UsageError` for another spelling, and for all addresses of this machine without a peer.
    """
    address, options = split_options(text, {"from": "the robot's address"})
    found = _ADDRESS.fullmatch(address)
    if found is None or not 0 < int(found[2]) < 65536:
        raise UsageError("is not an address to listen on", where=text, remedy=f"write {_EXAMPLE}")
    host, peer = found[1].strip("[]"), options.get("from")
    try:
        own = ipaddress.ip_address("127.0.0.1" if host == "localhost" else host)
        known = None if peer is None else str(ipaddress.ip_address(peer))
    except ValueError as error:
        raise UsageError(str(error), where=text, remedy=f"write {_EXAMPLE}") from error
    if own.is_unspecified and known is None:
        raise UsageError(
            "every network of this machine could connect",
            where=text,
            remedy=f"write {_EXAMPLE}, or name the robot: {text}?from=192.168.1.20",
        )
    return str(own), int(found[2]), known


_SOCKET = re.compile(r"socket://\[?(.+?)\]?:([0-9]+)", re.IGNORECASE)
_CONNECT_S = 5.0


class SocketLine(Port):
    """A connection to a server, never waiting; `InstrumentError` where it cannot be, or is lost."""

    _peer: socket.socket | None
    _gone: InstrumentError | None = None

    def __init__(self, address: str) -> None:
        self.address = address
        found = _SOCKET.fullmatch(address)
        try:
            where = (found[1], int(found[2])) if found else ("", 0)
            self._peer = socket.create_connection(where, timeout=_CONNECT_S)
        except OSError as error:
            raise InstrumentError(
                f"cannot be opened ({error})", where=address, remedy="check that the robot listens"
            ) from error
        self._peer.setblocking(False)

    def read(self) -> bytes:
        """Return what has arrived, at once; nothing where no robot is connected."""
        if self._gone is not None:
            raise self._gone
        if self._peer is None:
            return b""
        data, why = b"", "the robot has closed it"
        try:
            data = self._peer.recv(_CHUNK)
        except BlockingIOError:
            return b""
        except OSError as error:
            why = error.strerror or str(error)
        if not data:
            self.drop(why)
        return data

    def write(self, data: bytes) -> None:
        """Send; `InstrumentError` where no robot is connected, or none that reads."""
        if self._peer is None:
            raise InstrumentError("no robot is connected", where=self.address, remedy="wait for it")
        try:
            self._peer.send(data)
        except BlockingIOError:
            self.drop("the robot does not read")
        except OSError as error:
            self.drop(error.strerror or str(error))

    def drop(self, why: str) -> None:
        """End the connection: a robot's server is not asked again."""
        self.close()
        self._gone = InstrumentError(
            f"the robot's line is lost ({why})", where=self.address, remedy="reconnect it"
        )
        raise self._gone

    def close(self) -> None:
        """Close."""
        with contextlib.suppress(OSError):
            if self._peer is not None:
                self._peer.close()
        self._peer = None


class ListeningLine(SocketLine):
    """A server for one robot, never waiting; it outlives the robot's connections.

    Raises `UsageError` as `listen_address`, and `InstrumentError` where it cannot be served.
    """

    def __init__(self, text: str) -> None:
        host, port, self._only = listen_address(text)
        self.address = text
        self._peer = None
        self._name = ""
        self._refused = 0
        self._changes: list[Connection] = []
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._server = socket.socket(family, socket.SOCK_STREAM)
        try:
            if os.name == "posix":  # elsewhere it would let two programs listen at once
                self._server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._server.bind((host, port))
            self._server.listen(_QUEUE)
            self._server.setblocking(False)
        except OSError as error:
            self._server.close()
            raise InstrumentError(
                f"cannot be listened on ({error.strerror or error})",
                where=text,
                remedy="give an address of this machine, and a port that no other program has",
            ) from error

    def changes(self) -> list[Connection]:
        """Return who came, went or was refused since the last call."""
        found, self._changes = self._changes, []
        return found

    def read(self) -> bytes:
        """Return what has arrived, at once; nothing where no robot is connected.

        What a robot said before it left is heard before another is let in. Who knocks is looked at
        first: a robot that leaves and comes back in between would be refused as a second one.
        """
        knocks = bool(select.select([self._server], (), (), 0)[0])
        data = super().read()
        if knocks and not data:
            self._accept()
        return data

    def drop(self, why: str) -> None:
        """End the robot's connection; it may come back."""
        if self._peer is not None:
            super().close()
            self._changes.append(Connection("lost", self._name, why))

    def close(self) -> None:
        """Close."""
        super().close()
        with contextlib.suppress(OSError):
            self._server.close()

    def _accept(self) -> None:
        try:
            peer, address = self._server.accept()
        except OSError:  # nobody there, or gone before it was accepted
            return
        peer.setblocking(False)
        name = f"{address[0]}:{address[1]}"
        if self._only not in (None, str(address[0])):
            self._refuse(peer, name, "not the robot that `from` names")
        elif self._peer is not None:
            self._refuse(peer, name, "another robot is connected")
        else:
            _keep_alive(peer)
            self._peer, self._name = peer, name
            self._changes.append(Connection("connected", name))

    def _refuse(self, peer: socket.socket, name: str, why: str) -> None:
        with contextlib.suppress(OSError):
            peer.send(f"NO {why}\r\n".encode("ascii"))
        with contextlib.suppress(OSError):  # what is left unread would take the answer away
            peer.recv(_CHUNK)
        peer.close()
        self._refused += 1
        if self._refused <= _MOST_REFUSED:
            self._changes.append(Connection("refused", name, why))


def _keep_alive(peer: socket.socket) -> None:
    with contextlib.suppress(OSError):
        peer.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for name, value in _KEEP_ALIVE.items():
            if hasattr(socket, name):
                peer.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
