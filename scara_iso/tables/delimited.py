"""What the delimiter and the end of a text may have done to its numbers, and is refused."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from scara_iso.frozen import dataclass
from scara_iso.run import Run
from scara_iso.tables.body import Body
from scara_iso.tables.columns import Cell, Columns
from scara_iso.tables.faults import Faults, quoted, refuse
from scara_iso.tables.marks import check_groups
from scara_iso.tables.names import Kind
from scara_iso.tables.numbers import Mark, count_decimals
from scara_iso.tables.preamble import RESOLUTION, read_preamble
from scara_iso.tables.text import Delimiter, Row, split_lines

_ABOVE = 200


@dataclass(frozen=True, slots=True)
class Delimited:
    """A text, how its rows are parted, and whether its last line is ended."""

    text: str
    delimiter: Delimiter
    ended: bool

    def check_end(
        self, head: Sequence[Row], columns: Columns, body: Body, resolution: float | None
    ) -> None:
        """Find a file that was cut inside its last number: no line end, and too few decimals.

        A reading is refused that lacks decimals which a stated resolution and every one above have.
        Of other readings with fewer than most above, and numbers with fewer than each, a note is
        made.
        """
        line, last = self.text.count("\n") + 1, columns.layout.columns[-1]
        if self.ended or not columns.lines or columns.lines[-1][-1] != line:
            return
        rows = [
            row for _, row in
            split_each(1, self.text.rsplit("\n", _ABOVE)[-_ABOVE:], self.delimiter, Faults(""))
        ]  # fmt: skip
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
        if self.delimiter is Delimiter.SEMICOLON:
            check_groups(columns, run, columns.faults)

    def said(self, columns: Columns, decimal: str | None) -> str:
        """Return which mark of the numbers was taken for the decimal one."""
        if decimal is not None:
            return "decimal comma as asked" if decimal == "," else "decimal point as asked"
        commas = columns.marks.keys() & {Mark.COMMA, Mark.EITHER}
        return "decimal comma" if commas else "decimal point"


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
    """Refuse whole millimetres beside a column that never changes: 0,112 may have been one number.

    A header with as many names as commas left fields lets split decimals pass for two axes.
    """
    axes = sorted(columns.layout.of(Kind.AXIS), key=lambda column: column.position)
    for left, right in pairwise(axes):
        first, second = (run.axes[column.name].readings for column in (left, right))
        whole = np.array_equal(first, np.round(first)) and np.array_equal(second, np.round(second))
        if whole and np.ptp(first) == 0 and np.abs(second).max() >= 10:
            message = f"{left.name} never changes and {right.name} is whole: split decimal commas?"
            remedy = "say `decimal=.` if the numbers are whole"
            raise refuse(columns.faults.where, message, remedy=remedy)
