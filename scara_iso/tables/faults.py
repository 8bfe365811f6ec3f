"""Faults of one file: counted up to a bound at which reading ends, the first thousand kept."""

from __future__ import annotations

from collections.abc import Iterable

from scara_iso.errors import DataError, Fault

KEPT = 1000
"""Faults that a `DataError` lists; more are counted."""
_MOST = 10_000
"""Faults after which a file is not read on."""
_SHOWN = 30


class Faults:
    """Collect what is wrong with the file ``where``, wanted as ``what``, in the order found."""

    def __init__(self, where: str, what: str = "a table of readings") -> None:
        self.where = where
        self.what = what
        self.total = 0
        self._kept: list[Fault] = []
        self._remedy = ""

    def add(
        self, message: str, line: int | None = None, column: int | None = None, *, remedy: str = ""
    ) -> None:
        """Note one fault; the remedy of the first fault that has one is the error's.

        Raises `DataError` where there are so many that reading on would tell nothing.
        """
        self.total += 1
        self._remedy = self._remedy or remedy
        if len(self._kept) < KEPT:
            self._kept.append(Fault(message, line, column))
        if self.total == _MOST:
            self.check()

    def check(self) -> None:
        """Raise `DataError` if a fault was noted."""
        if not self.total:
            return
        faults = sorted(self._kept, key=lambda fault: (fault.line or 0, fault.column or 0))
        count = "1 fault" if self.total == 1 else f"{self.total} faults"
        more = f", the first {KEPT} listed" if self.total > KEPT else ""
        more += "; not read to its end" if self.total == _MOST else ""
        raise DataError(
            f"cannot be read as {self.what}: {count}{more}",
            where=self.where,
            remedy=self._remedy or "correct the file, or export it again",
            faults=faults,
        )


def refuse(where: str, message: str, *, remedy: str) -> DataError:
    """Return the `DataError` of a file that is refused as a whole."""
    return DataError(message, where=where, remedy=remedy, faults=(Fault(message),))


def quoted(text: str) -> str:
    """Return ``text`` quoted, escaped and cut for a message."""
    return repr(text if len(text) <= _SHOWN else text[:_SHOWN] + "…")


def listed(items: Iterable[str]) -> str:
    """Return ``a, b and c``."""
    *head, last = items
    return f"{', '.join(head)} and {last}" if head else last
