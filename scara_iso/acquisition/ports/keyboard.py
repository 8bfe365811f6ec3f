"""The keyboard as a port: each line that the operator types, or a cable types for it."""

from __future__ import annotations

from collections.abc import Callable

from scara_iso.acquisition.indicators import LinePulse
from scara_iso.errors import UsageError


class KeyboardPort:
    """Hands on the lines of ``typed``, one a call; the operator ends the session, not the port."""

    address = identity = "keyboard:"
    unit: str | None = None
    unit_confirmed = False
    simulated = ended = False
    settle_s = 0.0

    def __init__(self, typed: Callable[[], bytes] | None) -> None:
        if typed is None:
            raise UsageError(
                "nobody types here",
                where=self.address,
                remedy="scara-iso record takes what is typed, or the lines of standard input",
            )
        self._typed = typed

    def read(self) -> bytes:
        """Return the next line."""
        return self._typed()

    def write(self, data: bytes) -> None:
        """Ask nobody: a typed line comes by itself."""

    def pulse(self, pulse: LinePulse) -> None:
        """As `write`."""

    def close(self) -> None:
        """Nothing is held."""
