"""Where a run came from: shown to the user, never computed with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

SEPARATOR = " | "
"""Between the statements in one line of a table's head."""
SIMULATED = "SIMULATED readings: no robot was measured"
"""What is said of a run whose head states `simulated`."""


@dataclass(frozen=True, slots=True)
class TableField:
    """A column as the file has it, and what it was taken for."""

    header: str
    """What the header says of it."""
    kind: str
    """``axis``, ``cycle``, ``pose``, ``covariate`` and the like."""
    name: str
    """Of the axis or the covariate in the run, else empty."""
    unit: str
    """Of an axis; else empty."""


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a run came from: shown to the user, never computed with."""

    source: str = ""
    """File name, ``-`` for standard input, or what made the run."""
    understood: str = ""
    """One line: how the reader understood the file."""
    notes: tuple[str, ...] = ()
    """What the reader met and did not use, such as footer rows, one line each."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Unit that each axis was read in."""
    other_units: tuple[str, ...] = ()
    """Of several tables, those in another unit than the first, one line for each axis."""
    files: Mapping[str, str] = field(default_factory=dict)
    """The table of each pose, where the run was put together from several."""
    header_line: int | None = None
    """Line of the header, where one table was read that has one."""
    fields: tuple[TableField, ...] = ()
    """What each field of that table was taken for."""
    sheet: str = ""
    """The one of a workbook that was read."""

    @property
    def row_name(self) -> str:
        """What a line of the file is called: ``row`` in a sheet, else ``line``."""
        return "row" if self.sheet else "line"
