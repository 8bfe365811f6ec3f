"""What the session asks of a port, whether a cable, a recorded stream or a simulation is behind."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol
from urllib.parse import unquote

from scara_iso.acquisition.indicators import LinePulse
from scara_iso.errors import UsageError


class Port(Protocol):
    """A stream of bytes both ways that never waits."""

    address: str
    """The port as the user named it."""
    identity: str
    """One line for the record: which device this is."""
    unit: str | None
    """The unit that a recording or a simulation states for its indicator; None for a cable."""
    unit_confirmed: bool
    """Whether that unit is the indicator's own statement, not only what a user said of it."""
    simulated: bool
    """Whether the readings are made up, also where they were recorded so."""
    settle_s: float
    """What arrives in this time after opening was under way before it [s]."""

    @property
    def ended(self) -> bool:
        """Whether nothing more can arrive: a recorded stream came to its end."""

    def read(self) -> bytes:
        """Return what has arrived, at once; `InstrumentError` where the port is lost."""

    def write(self, data: bytes) -> None:
        """Send; `InstrumentError` where the port is lost."""

    def pulse(self, pulse: LinePulse) -> None:
        """Ask for a reading by a modem line; `InstrumentError` where the port is lost."""

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
