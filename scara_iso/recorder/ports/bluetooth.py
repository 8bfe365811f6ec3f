"""A Bluetooth Low Energy indicator as a port: text in notifications, requests as writes.

The one place that talks to bleak. The table of services is from public programs and, for Sylvac,
from the maker's protocol (github.com/SylvacDev/BluetoothDevTools); none was tried on an instrument.
A host that has connected again may hand on each transfer twice (bleak issue 2002): a copy would be
a reading that nobody took.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections import deque
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from threading import Thread
from typing import Any, TypeVar

from scara_iso.base.errors import InstrumentError, UsageError, with_extra
from scara_iso.recorder.indicators import LinePulse
from scara_iso.recorder.ports.port import Port

COPY_S = 0.05
"""A transfer that comes again within this time is a copy: no link repeats a text as fast [s]."""
SPOILT = b"\xff\x00"
"""Bytes that no frame holds: they make garbage of a line that can be read two ways."""
_ENDS = (b"\r", b"\n")


class Transfers:
    """Joins texts, each ended by CR or LF, from transfers of any length.

    A whole text, or the end of one, that comes again at once is dropped. Where all parts before the
    end came in equal pairs, they may be copies or may be meant: that line is made garbage, and so
    is one that a repeated transfer with an end inside would join.
    """

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._end = b""
        self._at = -math.inf

    def feed(self, data: bytes, now: float) -> bytes:
        """Return what a transfer that arrived at ``now`` [s] adds to the stream."""
        if not data.endswith(_ENDS):
            again = bool(self._parts) and self._parts[-1] == data
            self._parts.append(data)
            return SPOILT + data if again and any(end in data for end in _ENDS) else data
        if data == self._end and not self._parts and now - self._at < COPY_S:
            return b""
        parts, self._parts = self._parts, []
        self._end, self._at = data, now
        return SPOILT + data if parts and parts[0::2] == parts[1::2] else data


CONNECT_S = 30.0
_CLOSE_S = 5.0
_LONGEST = 20
"""Bytes of a transfer that every link takes."""
Answer = TypeVar("Answer")


@dataclass(frozen=True, slots=True)
class TextService:
    """The characteristics by which an instrument takes and sends text, as UUIDs in lower case."""

    name: str
    write: str
    notify: tuple[str, ...]


SERVICES = (
    TextService(
        "Sylvac",
        "c1b25012-caaf-6d0e-4c33-7dae30052840",
        ("c1b25010-caaf-6d0e-4c33-7dae30052840", "c1b25013-caaf-6d0e-4c33-7dae30052840"),
    ),
    TextService(
        "Nordic UART",
        "6e400002-b5a3-f393-e0a9-e50e24dcca9e",
        ("6e400003-b5a3-f393-e0a9-e50e24dcca9e",),
    ),
    TextService(
        "Microchip transparent UART",
        "49535343-8841-43f4-a8d4-ecbe34729bb3",
        ("49535343-1e4d-4bd9-ba61-23c647249616",),
    ),
)
"""The first one that an instrument has is used."""


def bleak_client(address: str, lost: Callable[[object], None]) -> Any:
    """Return bleak's client; ``lost`` is called when the link is. `UsageError` without bleak."""
    try:
        from bleak import BleakClient  # noqa: PLC0415 - an extra, and heavy
    except ImportError as error:
        raise UsageError(
            "Bluetooth needs the package bleak",
            where=f"ble:{address}",
            remedy=with_extra("ble"),
        ) from error
    return BleakClient(address, disconnected_callback=lost, timeout=CONNECT_S)


class BluetoothPort(Port):
    """A link to one instrument, held by a thread of its own; reading and writing never wait.

    Raises `UsageError` without bleak, and `InstrumentError` where the instrument cannot be reached
    or has no service of text. A lost link stays lost: the session ends and can be resumed.
    """

    settle_s = 0.15

    def __init__(self, address: str) -> None:
        self.address = address
        self._transfers = Transfers()
        self._arrived: deque[bytes] = deque()
        self._why_lost = ""
        self._loop = asyncio.new_event_loop()
        self._thread = Thread(target=self._loop.run_forever, name=address, daemon=True)
        self._thread.start()
        try:
            self._client = bleak_client(address.partition(":")[2].upper(), self._gone)
            self._service = self._wait(self._open(), CONNECT_S + _CLOSE_S)
        except BaseException as error:  # bleak raises its own, the system's and D-Bus's
            self.close()
            if isinstance(error, InstrumentError | UsageError) or not isinstance(error, Exception):
                raise
            raise InstrumentError(
                f"cannot be connected ({str(error) or type(error).__name__})",
                where=address,
                remedy="switch it and the computer's Bluetooth on, and end other programs that "
                "hold it",
            ) from error
        self.identity = f"{address} ({self._service.name})"

    def read(self) -> bytes:
        """Return what has arrived."""
        data = b"".join(self._arrived.popleft() for _ in range(len(self._arrived)))
        if self._why_lost and not data:
            raise self._lost()
        return data

    def write(self, data: bytes) -> None:
        """Send; where that fails the link is lost."""
        if self._why_lost:
            raise self._lost()
        asyncio.run_coroutine_threadsafe(self._send(data), self._loop)

    def pulse(self, pulse: LinePulse) -> None:
        """Refuse: a link has no modem lines."""
        raise UsageError(
            f"no line {pulse.line} on a Bluetooth link",
            where=self.address,
            remedy="use the driver of the duplex cable, such as opto-rs232",
        )

    def close(self) -> None:
        """Disconnect; a lost link may fail at that too."""
        if not self._thread.is_alive():
            return
        with contextlib.suppress(Exception):
            self._wait(self._client.disconnect(), _CLOSE_S)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(_CLOSE_S)
        self._loop.close()

    async def _open(self) -> TextService:
        await self._client.connect()
        there = {
            c.uuid.lower() for service in self._client.services for c in service.characteristics
        }
        found = next((one for one in SERVICES if {one.write, *one.notify} <= there), None)
        if found is None:
            raise InstrumentError(
                "has no service of text that is known",
                where=self.address,
                remedy=f"known are {', '.join(one.name for one in SERVICES)}; a Sylvac has it in "
                "the profile SIMPLE",
            )
        for uuid in found.notify:
            await self._client.start_notify(uuid, self._take)
        return found

    async def _send(self, data: bytes) -> None:
        try:
            for start in range(0, len(data), _LONGEST):
                part = data[start : start + _LONGEST]
                await self._client.write_gatt_char(self._service.write, part, response=False)
        except Exception as error:  # noqa: BLE001 - as on connecting; `read` says it
            self._why_lost = str(error) or type(error).__name__

    def _take(self, _: object, data: bytearray) -> None:
        self._arrived.append(self._transfers.feed(bytes(data), time.monotonic()))

    def _gone(self, _: object) -> None:
        self._why_lost = self._why_lost or "disconnected"

    def _wait(self, work: Coroutine[Any, Any, Answer], seconds: float) -> Answer:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(seconds)

    def _lost(self) -> InstrumentError:
        return InstrumentError(
            f"the link is lost ({self._why_lost})",
            where=self.address,
            remedy="switch the indicator on or come nearer, check zero and unit",
        )
