"""What the session asks of a port, what a port may be called, and the session's time.

The kinds of address are listed once, so that none reaches a file or a program: pyserial knows more
kinds of URL than these, and among them some that write files. A session whose ports are all
recorded or simulated takes its time from them, so that it gives the same table, times included, on
every run.
"""

from __future__ import annotations

import math
import os
import re
import stat
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal
from urllib.parse import unquote

from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.recorder.indicators import Dialect, LinePulse

_KINDS = {
    "sim": re.compile(r"sim:.*", re.DOTALL),
    "replay": re.compile(r"replay:.*", re.DOTALL),
    "keyboard": re.compile(r"keyboard:"),
    # the six bytes of an address, or the UUID that macOS has in its place
    "ble": re.compile(
        r"ble:(?:(?:[0-9a-f]{2}:){5}[0-9a-f]{2}|[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12})", re.I
    ),
    "url": re.compile(
        r"(?:socket|rfc2217)://(?:[a-z0-9._-]{1,253}|\[[0-9a-f:.]{2,45}\]):[0-9]{1,5}", re.I
    ),
}
_SCHEME = re.compile(r"[a-z][a-z0-9+.-]*:", re.IGNORECASE)


def port_kind(address: str) -> str:
    """Return ``sim``, ``replay``, ``keyboard``, ``ble``, ``url``, or ``device`` for all else."""
    return next((kind for kind, known in _KINDS.items() if known.fullmatch(address)), "device")


def is_device(address: str) -> bool:
    """Say whether the address names a cable, a link or a URL: neither recorded nor simulated."""
    return port_kind(address) not in ("sim", "replay")


def check_address(address: str) -> None:
    """Raise `UsageError` for what is not a kind of port; nothing is looked for."""
    good, kind = True, port_kind(address)
    if kind == "device":
        good = bool(address.strip()) and address.isprintable() and not _SCHEME.match(address)
    elif kind == "url":
        good = int(address.rpartition(":")[2]) < 65536
    if not good:
        raise UsageError(
            "no such kind of port",
            where=address,
            remedy="use a device, socket://HOST:PORT, rfc2217://HOST:PORT, ble:ADDRESS, "
            "replay:FILE, sim: or keyboard:",
        )


def check_device(address: str) -> None:
    """Raise `UsageError` unless the address names a device or a serial server.

    Raises `InstrumentError` for a file that is there and is not a device.
    """
    check_address(address)
    kind = port_kind(address)
    if kind == "ble":
        raise UsageError("is not a serial device", where=address, remedy="name a device or a URL")
    with suppress(OSError):
        mode = Path(address).stat().st_mode
        if kind == "device" and os.name == "posix" and not stat.S_ISCHR(mode):
            raise InstrumentError(
                "is not a serial device", where=address, remedy="`scara-iso ports` lists them"
            )


POLL_S = 0.002
"""Longest wait between two looks at the ports and the keyboard [s]."""


class Clock:
    """What a session needs of time: the machine's monotonic clock and its date."""

    def __init__(self) -> None:
        self._start = time.monotonic()
        self._sources: list[Callable[[], float]] = []

    def watch(self, due: Callable[[], float]) -> None:
        """Have a clock that jumps stop at the time that ``due`` gives, where that lies ahead."""
        self._sources.append(due)

    def now(self) -> float:
        """Return the seconds since the clock was made; never goes back."""
        return time.monotonic() - self._start

    def wall(self) -> str | None:
        """Return the date and time (ISO 8601, UTC), None where time is not the system's."""
        return datetime.now(UTC).isoformat(timespec="microseconds").replace("+00:00", "Z")

    def idle(self, until: float) -> None:
        """Wait a moment, not beyond ``until`` [s]; the ports are read again after it."""
        time.sleep(max(0.0, min(POLL_S, until - self.now())))


class StreamClock(Clock):
    """A clock that jumps to the next byte of its sources; ``paced`` lets it pass in real time."""

    def __init__(self, *, paced: bool) -> None:
        super().__init__()
        self._now = 0.0
        self._paced = paced

    def now(self) -> float:
        """Return the stream's time [s]."""
        return self._now

    def wall(self) -> str | None:
        """Return None: the date of a recorded or simulated stream is not today's."""
        return None

    def idle(self, until: float) -> None:
        """Go to ``until`` or to the next byte, whichever is earlier."""
        target = min([until, *(due() for due in self._sources)])
        if self._paced or math.isinf(target):
            target = min(target, self._now + POLL_S)
            time.sleep(max(0.0, target - self._now))
        self._now = max(self._now, target)


@dataclass(frozen=True, slots=True)
class Connection:
    """A robot came, went, or was refused."""

    state: Literal["connected", "lost", "refused"]
    peer: str
    why: str = ""


PULSE = b"(pulse)"
"""Stands for a request made by a modem line."""


class Port:
    """A stream of bytes both ways that never waits; of its own it is silent and takes anything."""

    address: str
    """The port as the user named it."""
    identity: str
    """One line for the record: which device this is."""
    unit: str | None = None
    """The unit that a recording or a simulation states for its indicator; None for a cable."""
    unit_confirmed: bool = False
    """Whether that unit is the indicator's own statement, not only what a user said of it."""
    simulated: bool = False
    """Whether the readings are made up, also where they were recorded so."""
    settle_s: float = 0.0
    """What arrives in this time after opening was under way before it [s]."""

    @property
    def ended(self) -> bool:
        """Whether nothing more can arrive: a recorded stream came to its end."""
        return False

    def changes(self) -> list[Connection]:
        """Return who came, went or was refused since the last call."""
        return []

    def read(self) -> bytes:
        """Return what has arrived, at once; `InstrumentError` where the port is lost."""
        return b""

    def write(self, data: bytes) -> None:
        """Send; `InstrumentError` where the port is lost."""

    def pulse(self, pulse: LinePulse) -> None:
        """Ask for a reading by a modem line; `InstrumentError` where the port is lost."""

    def ask(self, dialect: Dialect) -> None:
        """Send a dialect's request for a reading, or pulse its modem line, where it has one."""
        if dialect.request is not None:
            self.write(dialect.request)
        elif dialect.request_line is not None:
            self.pulse(dialect.request_line)

    def close(self) -> None:
        """Give the port back; never raises."""


def split_options(text: str, known: Mapping[str, str]) -> tuple[str, dict[str, str]]:
    """Return what stands before ``?`` and the ``key=value&...`` behind it.

    A value is written as in a URL (``%26`` for ``&``), but a ``+`` is a plus: patterns have them.
    Raises `UsageError` for a key that is not in ``known``, which says for each what it means.
    """
    head, mark, tail = text.partition("?")
    pairs = [pair.partition("=") for pair in tail.split("&")] if mark else []
    options = {unquote(key): unquote(value) for key, equals, value in pairs if equals}
    wrong = sorted(set(options) - set(known))
    if wrong or len(options) < len(pairs):
        raise UsageError(
            f"unknown option {wrong[0]!r}" if wrong else f"{tail!r} is not key=value&key=value",
            where=text,
            remedy="; ".join(f"{key}={meaning}" for key, meaning in known.items()),
        )
    return head, options


def number_option(options: Mapping[str, str], key: str, default: float) -> float:
    """Return an option that must be a number, zero or greater; `UsageError` otherwise."""
    text = options.get(key)
    if text is None:
        return default
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value <= 1e9:
        raise UsageError(
            f"{key}={text} is not a number of zero or more", remedy=f"write a number, as {key}=2"
        )
    return value
