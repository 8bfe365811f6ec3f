"""What the delimiter and the end of a text may have done to its numbers, and is refused."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from scara_iso.run import FloatArray, Run
from scara_iso.tables.body import Body
from scara_iso.tables.columns import Cell, Columns
from scara_iso.tables.faults import Faults, quoted, refuse
from scara_iso.tables.marks import check_groups
from scara_iso.tables.names import Column, Kind
from scara_iso.tables.numbers import Mark, count_decimals
from scara_iso.tables.preamble import RESOLUTION, read_preamble
from scara_iso.tables.text import Delimiter, Row, split_lines

_ABOVE = 200
_TENTHS = 10
"""Two digits behind a comma."""


@dataclass(frozen=True, slots=True)
class Delimited:
    """How the rows of a text are parted, how many lines it has, the last ones, and the end."""

    lines: int
    size: int
    """Characters."""
    last: Sequence[str]
    """At most the two hundred last."""
    delimiter: Delimiter
    ended: bool
    """Whether the last line is ended."""

    def most_rows(self, width: int) -> int:
        """Return how many rows of ``width`` fields there can be: a field takes a character."""
        return min(self.lines, self.size // max(width, 1) + 1)

    def check_end(
        self, head: Sequence[Row], columns: Columns, body: Body, resolution: float | None
    ) -> None:
        """Find a file that was cut inside its last number: no line end, and too few decimals.

        A reading is refused that lacks decimals which a stated resolution and every one above have.
        Of other readings with fewer than most above, and numbers with fewer than each, a note is
        made.
        """
        line, last = self.lines, columns.layout.columns[-1]
        if self.ended or columns.last_line != line:
            return
        rows = [row for _, row in split_each(1, self.last, self.delimiter, Faults(""))]
        if last.position < len(rows[-1]) - 1:  # another pose's cells follow
            return
        *above, decimals = [_decimals(row, last.position) for row in rows]
        known = [count for count in above if count is not None]
        middle = (len(known) - 1) // 2 if last.kind is Kind.AXIS else 0
        usual = sorted(known)[middle] if known else 0
        if decimals is None or decimals >= usual:
            return
        what = f"no line end, and {decimals} decimals where others have {usual}: is the file cut?"
        stated, _ = read_preamble(head, columns.layout.header_line, Faults(""))
        steps = [one.value for key, one in stated.items() if key.startswith(RESOLUTION)]
        steps += [] if resolution is None else [str(resolution)]
        if last.kind is Kind.AXIS and set(known) <= set(map(count_decimals, steps)):
            remedy = "get the whole file; if it is whole, end its last line"
            columns.faults.add(what, line, last.position + 1, remedy=remedy)
        else:
            body.note(f"line {line}: {what}")

    def check_numbers(self, run: Run, columns: Columns) -> None:
        """Refuse numbers that are others where the delimiter, or a point, is the other locale's."""
        if self.delimiter is Delimiter.COMMA and not columns.marks:
            _check_split(run, columns)
        if self.delimiter in (Delimiter.SEMICOLON, Delimiter.TAB):
            check_groups(columns, run, columns.faults)

    def said(self, columns: Columns, decimal: str | None) -> str:
        """Return which mark of the numbers was taken for the decimal one."""
        if decimal is not None:
            return "decimal comma as asked" if decimal == "," else "decimal point as asked"
        commas = columns.marks.keys() & {Mark.COMMA, Mark.EITHER}
        return "decimal comma" if commas else "decimal point"


def delimited(pieces: Sequence[str], delimiter: Delimiter, ended: bool) -> Delimited:
    """Return what is to be known of a text once its ``pieces`` are gone."""
    last: list[str] = []
    for piece in reversed(pieces):
        last = [*piece.split("\n"), *last]
        if len(last) >= _ABOVE:
            break
    count = len(pieces) + sum(piece.count("\n") for piece in pieces)
    size = count + sum(map(len, pieces))
    return Delimited(count, size, last[-_ABOVE:], delimiter, ended)


def split_each(
    first: int, lines: Sequence[str], delimiter: Delimiter, faults: Faults
) -> Iterator[tuple[int, list[Cell]]]:
    """Yield number and cells of each line, from the ``first`` on; a broken quote is a fault."""
    for line, text in enumerate(lines, first):
        try:
            yield line, list(split_lines([text], delimiter)[0])
        except csv.Error as error:
            faults.add(f"{error}: {quoted(text)}", line, remedy="close or remove the quote")


def _decimals(row: Sequence[Cell], position: int) -> int | None:
    cell = row[position] if len(row) > position else ""
    return count_decimals(cell) if isinstance(cell, str) else None


def _check_split(run: Run, columns: Columns) -> None:
    """Refuse a whole number that never changes beside digits that do: 0,112 may have been one.

    A header with as many names as commas left fields lets split decimals pass for two columns.
    """
    by_position = {column.position: column for column in columns.layout.columns}
    for axis in columns.layout.of(Kind.AXIS):
        first, beside = run.axes[axis.name].readings, by_position.get(axis.position + 1)
        if beside is None or np.ptp(first) > 0 or not np.array_equal(first, np.round(first)):
            continue
        second = _whole_numbers(beside, columns)
        if second is not None and second.max() >= _TENTHS:
            message = f"{axis.name} never changes and {_called(beside, columns)} is whole: "
            remedy = "say `decimal=.` if the numbers are whole"
            raise refuse(columns.faults.where, f"{message}split decimal commas?", remedy=remedy)


def _called(column: Column, columns: Columns) -> str:
    return column.name if column.kind is Kind.AXIS else columns.layout.header[column.position]


def _whole_numbers(column: Column, columns: Columns) -> FloatArray | None:
    """Return the whole numbers that a column holds, in sizes; None for another or the time."""
    if column.kind is Kind.COMMENT:
        labels = columns.distinct(column)
        whole = all(map(str.isdecimal, labels))
        return np.array(labels, dtype=np.float64)[columns.codes(column)] if whole else None
    if column.kind not in (Kind.AXIS, Kind.COVARIATE) or column.name == "time_s":
        return None
    values = np.abs(columns.numbers(column))
    return values if np.array_equal(values, np.round(values)) else None
