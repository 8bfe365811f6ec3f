"""The error tree. Each class carries the exit code of the command that meets it.

An error says what is wrong, where, and what to do about it. Domain errors derive from
``Exception`` only: the command line turns them into one to three lines and an exit code.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence
from typing import ClassVar, NamedTuple

_MANY = 5
"""Faults that are alike from which on they are said in one line."""
_RANGES = 20
"""Ranges of lines that are named in it."""
_VALUE = re.compile(r"'[^']*'|\"[^\"]*\"|[-+]?[0-9][0-9.,]*(?:e[-+]?[0-9]+)?")


class Fault(NamedTuple):
    """One thing wrong in a file: what, and the line and column (both from 1) where known.

    Of a workbook ``line`` is the row of a ``sheet``, and the place is a cell: ``Sheet1!B14``.
    """

    message: str
    line: int | None = None
    column: int | None = None
    sheet: str = ""

    def __str__(self) -> str:
        if self.sheet and self.line is not None:
            return f"{_cell(self.sheet, self.line, self.column)}: {self.message}"
        place = [f"line {self.line}"] if self.line is not None else []
        place += [f"column {self.column}"] if self.column is not None else []
        return f"{', '.join(place)}: {self.message}" if place else self.message


def _cell(sheet: str, row: int, column: int | None) -> str:
    return f"{sheet}, row {row}" if column is None else f"{sheet}!{_letters(column)}{row}"


def _letters(column: int) -> str:
    """Return the name of a column of a sheet, from 1: ``A`` to ``Z``, ``AA`` and so on."""
    more, letter = divmod(column - 1, 26)
    return (_letters(more) if more else "") + chr(ord("A") + letter)


def fault_lines(faults: Sequence[Fault]) -> list[str]:
    """Return a line for each fault, and one for all that are alike: five or more in one column.

    Faults are alike where they differ in the value only that they name.
    """
    groups: dict[tuple[object, ...], list[Fault]] = {}
    for k, fault in enumerate(faults):
        alike = (fault.sheet, fault.column, _VALUE.sub("", fault.message))
        groups.setdefault(alike if fault.line is not None else (k,), []).append(fault)
    return [
        line
        for group in groups.values()
        for line in ([_together(group)] if len(group) >= _MANY else map(str, group))
    ]


def _together(faults: Sequence[Fault]) -> str:
    first = faults[0]
    alike = "" if len({fault.message for fault in faults}) == 1 else " and the like"
    lines = _ranges(sorted({fault.line for fault in faults if fault.line is not None}))
    rows = "rows" if first.sheet else "lines"
    place = f"{rows} {lines}"
    if first.column is not None:
        place += f", column {_letters(first.column) if first.sheet else first.column}"
    place = f"{first.sheet}, {place}" if first.sheet else place
    return f"{place}: {first.message}{alike} ({len(faults)} times)"


def _ranges(numbers: Sequence[int]) -> str:
    """Return ascending numbers in words: ``3 to 7, 9, 11 and 4 more``."""
    starts = [k for k in range(len(numbers)) if k == 0 or numbers[k] != numbers[k - 1] + 1]
    runs = [numbers[a:b] for a, b in zip(starts, [*starts[1:], len(numbers)], strict=True)]
    said = [str(r[0]) if len(r) == 1 else f"{r[0]} to {r[-1]}" for r in runs[:_RANGES]]
    more = sum(map(len, runs[_RANGES:]))
    return ", ".join(said) + (f" and {more} more" if more else "")


_NAMED = re.compile(r"`([A-Za-z]\w*)=([^`]+)`")
_BY_NAME = ("limits", "metadata")


def as_keywords(text: str) -> str:
    """Return ``text`` with the parameters that it names (`` `unit=mm` ``) as Python takes them."""
    return _NAMED.sub(lambda named: f"`{named[1]}={_literal(named[1], named[2])}`", text)


def _literal(name: str, value: str) -> str:
    key, pair, of_key = value.partition("=")
    if pair and name in _BY_NAME:
        return f'{{"{key}": {_literal("", of_key)}}}'
    try:
        ast.literal_eval(value)
    except (ValueError, SyntaxError):
        return value if value == "N" else f'"{value}"'
    return value


class ScaraIsoError(Exception):
    """Root of the tree: ``what`` happened, ``where``, and what to do (``remedy``)."""

    exit_code: ClassVar[int] = 70

    def __init__(self, what: str, *, where: str = "", remedy: str = "") -> None:
        super().__init__(what)
        self.what = what
        self.where = where
        self.remedy = remedy
        if remedy:
            self.add_note(as_keywords(remedy))  # below a traceback, in a notebook too

    @property
    def headline(self) -> str:
        """Where and what, in one line."""
        return f"{self.where}: {self.what}" if self.where else self.what

    def __str__(self) -> str:
        return self.headline


def with_extra(name: str) -> str:
    """Return how the program is installed with one of its extras."""
    return (
        f"install it with its extra {name}, in its folder: uv tool install '.[{name}]', or "
        f"pip install '.[{name}]' (README, Install)"
    )


class UsageError(ScaraIsoError):
    """An option or argument that is not valid; exit code 2."""

    exit_code = 2


class DataError(ScaraIsoError):
    """Data that break the procedure or cannot be read, with every fault; exit code 65."""

    exit_code = 65
    MOST_SHOWN: ClassVar[int] = 50

    def __init__(
        self, what: str, *, where: str = "", remedy: str = "", faults: Sequence[Fault] = ()
    ) -> None:
        super().__init__(what, where=where, remedy=remedy)
        self.faults = tuple(faults)

    def __str__(self) -> str:
        return "\n".join((self.headline, *self.fault_lines()))

    def fault_lines(self) -> list[str]:
        """Return indented lines for the faults that the headline does not say; 50 at most."""
        lines = fault_lines([fault for fault in self.faults if fault.message != self.what])
        more = len(lines) - self.MOST_SHOWN
        lines = [*lines[: self.MOST_SHOWN], *([f"and {more} more"] if more > 0 else [])]
        return [f"  {line}" for line in lines]


class NoInputError(ScaraIsoError):
    """A file that is not there or may not be read; exit code 66."""

    exit_code = 66


class InstrumentError(ScaraIsoError):
    """A serial port or an instrument that fails; exit code 69."""

    exit_code = 69


class ServiceError(ScaraIsoError):
    """A service, such as a cluster, that does not answer; exit code 69."""

    exit_code = 69


class CannotCreateError(ScaraIsoError):
    """An output file that cannot be created; exit code 73."""

    exit_code = 73


class WriteError(ScaraIsoError):
    """An output that failed while being written; exit code 74."""

    exit_code = 74


class StoppedError(ScaraIsoError):
    """Stopped by the user, and some of the work is kept; exit code 130."""

    exit_code = 130
