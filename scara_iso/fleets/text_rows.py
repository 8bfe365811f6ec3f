"""The rows of several robots as text: what is stated above their header, and what stands below."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from scara_iso.errors import DataError
from scara_iso.files import open_file
from scara_iso.tables import decode_text

DELIMITERS = (",", ";", "\t")
_STATEMENT = re.compile(r"#\s*([A-Za-z][\w ]*?)\s*:\s*(.*)")
_COMMENT = "#"


@dataclass(frozen=True, eq=False, slots=True)
class TextRows:
    """A text file with a header that names the robot of each row."""

    statements: Mapping[str, str]
    """What ``# key: value`` above the header says."""
    names: Sequence[str]
    delimiter: str
    columns: Sequence[Sequence[str | None]]
    """By name, the cells below the header; None for an empty one."""


def text_rows(path: Path) -> TextRows | None:
    """Return the rows of a text file, None where its header names no column ``robot``.

    A line of one cell below the header that begins with ``#`` is a comment. Raises `NoInputError`
    and `DataError`, of a row that is not as long as the header with its line.
    """
    with open_file(path) as file:
        data = file.read()
    lines = decode_text(data, str(path))[0].split("\n")
    statements, above = _above(lines)
    header = "".join(lines[above : above + 1])
    for delimiter in DELIMITERS:
        names = [name.strip() for name in next(csv.reader([header], delimiter=delimiter), [])]
        if "robot" in map(str.lower, names):
            rows = list(_rows(lines, above + 1, delimiter, len(names), str(path)))
            columns = list(zip(*rows, strict=True)) or [()] * len(names)
            return TextRows(statements, names, delimiter, columns)
    return None


def _above(lines: Sequence[str]) -> tuple[dict[str, str], int]:
    """Return what is stated above the header, and how many lines that are."""
    found: dict[str, str] = {}
    for number, line in enumerate(lines):
        stated = _STATEMENT.match(line)
        if stated:
            found[stated[1].lower().replace(" ", "_")] = stated[2].strip()
        elif line.strip() and not line.startswith(_COMMENT):
            return found, number
    return found, len(lines)


def _rows(
    lines: Sequence[str], above: int, delimiter: str, width: int, where: str
) -> Iterator[list[str | None]]:
    """Yield the rows below the header, each of its ``width``."""
    below = (f"{line}\n" for line in islice(lines, above, None))
    reader, line = csv.reader(below, delimiter=delimiter, strict=True), above + 1
    try:
        for row in reader:
            if len(row) == width:
                yield [cell.strip() or None for cell in row]
            elif row and not (len(row) == 1 and _is_no_row(row[0])):
                raise DataError(
                    f"line {line}: {len(row)} cells, and the header has {width}",
                    where=where,
                    remedy="mend that row; quotes around a cell keep it whole",
                )
            line = above + reader.line_num + 1
    except csv.Error as error:
        raise DataError(
            f"line {line}: a quotation mark opens or closes in the wrong place: {error}",
            where=where,
            remedy="mend that row",
        ) from error


def _is_no_row(text: str) -> bool:
    return not text.strip() or text.startswith(_COMMENT)
