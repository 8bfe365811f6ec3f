"""Where the header is, and what the columns are.

What the names of a header leave open or contradict, and what to do about it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from scara_iso.base.quantities import Dimension
from scara_iso.run import UNITS, unit_of_condition
from scara_iso.tables.faults import Faults, quoted
from scara_iso.tables.names import (
    CLOCKS,
    COVARIATES,
    LONGEST_NAME,
    Column,
    Kind,
    clean,
    pose_and_name,
    read_name,
    read_names,
    read_unit,
    settle,
    unit_behind,
    with_likely,
)
from scara_iso.tables.numbers import parse_cell
from scara_iso.tables.text import Row

HEAD = 200
"""Lines in which the header must come."""
COLUMNS = 10_000
"""Columns that a table may have."""
_ERROR_CODE = re.compile(r"#(?:#|N/A|NV|[A-ZÄÖÜ/0]+[!?])")
_BETWEEN = str.maketrans(",|", "  ")
_BETWEEN_CELLS = re.compile(r"[;\t|]|,[^,]*,")
_STROKES = "-=_+*|:"


@dataclass(frozen=True, slots=True)
class Layout:
    """The columns of a table, its header as found, and the line that data begin on."""

    columns: tuple[Column, ...]
    header: tuple[str, ...]
    header_line: int
    data_line: int
    sure: bool
    """Whether a row of numbers follows the header."""
    words_below: bool = False
    """Whether a row of words follows it: a heading of two rows."""

    @property
    def width(self) -> int:
        """Number of fields of a row."""
        return len(self.columns)

    @property
    def known(self) -> int:
        """Number of columns that are more than a covariate."""
        return sum(c.kind not in (Kind.COVARIATE, Kind.NAMELESS) for c in self.columns)

    def of(self, *kinds: Kind) -> list[Column]:
        """Return the columns of the given kinds."""
        return [c for c in self.columns if c.kind in kinds]


def find_layout(rows: Sequence[Row]) -> Layout | None:
    """Return the layout of the first header that a row of numbers follows.

    Without one, that of the row that names most; None where no row names an axis.
    """
    best: Layout | None = None
    for k, row in enumerate(rows):
        if not names_an_axis(row.cells):
            continue
        layout = _layout(rows, k)
        if layout.width > 1 and _is_one_field(rows, k):
            continue
        if layout.sure or layout.width > COLUMNS:
            return layout
        if best is None or layout.known > best.known:
            best = layout
    return best


def _is_one_field(rows: Sequence[Row], k: int) -> bool:
    """Say whether all rows below are one field that another delimiter parts."""
    below = [r for r in rows[k + 1 :] if r.text and not is_rule(r.text)]
    return bool(below) and all(len(r.cells) == 1 and _BETWEEN_CELLS.search(r.text) for r in below)


def header_cells(cells: Sequence[str]) -> list[str]:
    """Return the cells of a row as header names, a leading ``#`` removed."""
    names = [clean(cell) for cell in cells[: _trimmed(cells)]]
    if names and re.match(r"# ?\w", names[0]):
        names[0] = names[0].lstrip("# ")
    return names


_RUN = re.compile(r"(?:run|lauf|messung|cycle|zyklus|trial|j|n|#)? ?=? ?[0-9]{1,3}")
_TRIAL = re.compile(r"(x|y|z|theta)[ _]?[0-9]{1,2}")
_OF_A_POSE = re.compile(
    r"(?:(?:pose|point|punkt)[ _.-]?[a-z0-9]{1,3}|p[ _.-]?[0-9]{1,3})[ _:.-]+(x|y|z|theta)"
    r"(?: ?[\[(/].*)?"
)


def runs_across(rows: Sequence[Row]) -> Row | None:
    """Return the first row of runs side by side: ``Run 1 Run 2``, ``X1 X2``, ``P0 X P1 X``."""
    for row in rows:
        short = [clean(cell).lower() for cell in row.cells if len(cell) <= LONGEST_NAME]
        found = [_TRIAL.fullmatch(text) or _OF_A_POSE.fullmatch(text) for text in short]
        axes = [trial[1] for trial in found if trial]
        if len(axes) > len(set(axes)):
            return row
        named = [text for text in short if _RUN.fullmatch(text)]
        if len(named) > 1 and not all(map(parse_cell, named)):
            return row
    return None


def names_an_axis(cells: Sequence[str]) -> bool:
    """Return whether a row is a header: one of its cells names an axis, and none is a number."""
    if not cells or re.match(r"#?\s*[^\W\d_][^:=,;]*[:=]", cells[0]):
        return False
    names = header_cells(cells[: COLUMNS + 1])
    if any(len(name) > LONGEST_NAME or parse_cell(name) for name in names):
        return False
    return any(read_name(name).kind is Kind.AXIS for name in names)


_BESIDE_AXES = {Kind.CYCLE, Kind.POSE, Kind.COMMENT, Kind.TIMESTAMP}


def _named_above(names: list[str], above: Sequence[str]) -> list[str]:
    """Return names with what stands above an empty one, such as Lauf in a heading of two rows."""
    texts = _padded(list(map(clean, above)), len(names))
    return [
        text if not name and text and read_name(text).kind in _BESIDE_AXES else name
        for name, text in zip(names, texts, strict=True)
    ]


def _layout(rows: Sequence[Row], k: int) -> Layout:
    names = _named_above(header_cells(rows[k].cells), rows[k - 1].cells if k else [])
    below = _next_row(rows, k + 1)
    units: list[str] = []
    last = k
    if below is not None and _is_unit_row(names, rows[below].cells):
        units = [clean(cell).strip("[]() ") for cell in rows[below].cells]
        last, below = below, _next_row(rows, below + 1)
    cells = rows[below].cells if below is not None else []
    if names[0] == "#" and _trimmed(cells) == len(names) - 1:
        names = names[1:]  # "# X Y Z" over three columns of blanks, as numpy writes it
    first = _padded(cells, len(names))
    settled = [
        settle(column, names[column.position], first[column.position])
        for column in read_names(names, _padded(units, len(names)))
    ]
    columns = with_likely(settled, names)
    columns = tuple(_remarks(c, rows[below:] if below is not None else []) for c in columns)
    numeric = any(parse_cell(first[c.position]) for c in columns if c.kind is Kind.AXIS)
    words = any(map(clean, cells)) and not any(parse_cell(cell) for cell in cells)
    fits = _trimmed(cells) <= len(names) <= len(cells)
    return Layout(columns, tuple(names), rows[k].line, rows[last].end + 1, numeric and fits, words)


def _remarks(column: Column, rows: Sequence[Row]) -> Column:
    """Return a column of no known name as a comment where some cells are words and others empty.

    Words in every row may be a label that counts: a state, a pose.
    """
    if column.kind is not Kind.COVARIATE or column.name in COVARIATES:
        return column
    found = [r.cells[column.position].strip() for r in rows if len(r.cells) > column.position]
    words = all(text[0].isalpha() and not parse_cell(text) for text in found if text)
    return replace(column, kind=Kind.COMMENT) if words and not all(found) else column


def _padded(cells: Sequence[str], width: int) -> list[str]:
    return [*cells, *[""] * width][:width]


def _trimmed(cells: Sequence[str]) -> int:
    """Return the number of cells up to the last that is not blank."""
    return max((k + 1 for k, cell in enumerate(cells) if clean(cell)), default=0)


def _next_row(rows: Sequence[Row], k: int) -> int | None:
    """Return the first row from ``k`` on that is neither blank, a ruled line nor a comment."""
    for j in range(k, len(rows)):
        text = rows[j].text
        if text and not is_rule(text) and not text.startswith("#"):
            return j
    return None


def is_comment(text: str) -> bool:
    """Return whether a row begins with ``#``, and not with a spreadsheet's ``#DIV/0!``."""
    return text.startswith("#") and not _ERROR_CODE.match(text)


def is_rule(text: str) -> bool:
    """Return whether a row is a ruled line, of three strokes or more in every cell."""
    cells = text.translate(_BETWEEN).split()
    return bool(cells) and all(len(cell) > 2 and not cell.strip(_STROKES) for cell in cells)


def _is_unit_row(names: list[str], cells: list[str]) -> bool:
    found = [clean(cell).strip("[]() ") for cell in cells]
    if any(parse_cell(cell) for cell in found):
        return False
    axes = [k for k, n in enumerate(names[: len(found)]) if read_name(n).kind is Kind.AXIS]
    if any(read_unit(found[k]) for k in axes if found[k]):
        return True
    stated = [cell for cell in found if cell]
    return bool(stated) and all(unit_of_condition(cell) in UNITS for cell in stated)


def check_header_names(layout: Layout, faults: Faults) -> None:
    """Add what columns are too many, of one name, or formulas, and axes of a pose beside others."""
    if layout.width > COLUMNS:
        what = f"{layout.width} columns, more than {COLUMNS}"
        faults.add(what, layout.header_line, remedy="leave the columns of the readings only")
    _check_poses(layout, faults)
    _check_units(layout, faults)
    first: dict[tuple[Kind, str], Column] = {}
    for column in layout.columns:
        field = column.position + 1
        if column.kind in (Kind.NAMELESS, Kind.COMMENT):
            continue
        if layout.header[column.position].startswith(("=", "@")):
            what = "a formula for a column's name"
            faults.add(what, layout.header_line, field, remedy="write the name itself")
        covariate = column.kind in (Kind.TIMESTAMP, Kind.DIRECTION)
        kind = Kind.COVARIATE if covariate else column.kind
        name = "time_s" if column.kind is Kind.TIMESTAMP else column.name
        before = first.setdefault((kind, name.lower()), column)
        if before is not column:
            what = f"two columns for {name}: fields {before.position + 1} and {field}"
            faults.add(
                what,
                layout.header_line,
                field,
                remedy="leave one column for each axis and quantity; a block beside the first goes "
                "below it, and of several poses the columns are headed P1_X, P2_X",
            )


def _check_poses(layout: Layout, faults: Faults) -> None:
    """Add each covariate that names an axis of a pose: its readings would be lost."""
    for column in layout.of(Kind.COVARIATE):
        heading = layout.header[column.position]
        found = pose_and_name(heading)
        if found and read_name(found[1]).kind is Kind.AXIS:
            faults.add(
                f"{quoted(heading)} is of pose {found[0]}, other axes of none",
                layout.header_line,
                column.position + 1,
                remedy="head each axis with its pose, as P1_X and P2_X; "
                "call a column of no readings comment",
            )


def _check_units(layout: Layout, faults: Faults) -> None:
    """Add each covariate whose heading states another unit than the unit row."""
    for column in layout.of(Kind.COVARIATE):
        heading, _, below = column.unit.partition(" over ")
        if below:
            what = f"in {heading}, the unit row says {below}"
            faults.add(
                f"{quoted(layout.header[column.position])} is {what}",
                layout.header_line,
                column.position + 1,
                remedy="let the heading and the unit row state the same unit",
            )


def said_units(layout: Layout) -> Iterator[str]:
    """Name each column of another unit of time, temperature or load than that of a run, or none."""
    for column in layout.of(Kind.COVARIATE):
        if column.name.lower() in CLOCKS and not column.unit:
            yield f"{called(layout, column)} states no unit, not used as the time: call it time_s"
        if column.condition and column.condition.converts:
            yield f"{called(layout, column)} in {column.unit} is converted to {column.name}"


def said_sizes(layout: Layout) -> Iterator[str]:
    """Name each length or angle that is taken for a covariate, and may be an axis by its name."""
    for column in layout.of(Kind.COVARIATE):
        unit = unit_behind(layout.header[column.position])
        if unit is not None:
            axis = "theta" if unit.dimension is Dimension.ANGLE else "X, Y or Z"
            yield (
                f"{called(layout, column)} names no axis and is taken as a covariate; "
                f"if it holds readings, call it {axis}"
            )


def called(layout: Layout, column: Column) -> str:
    """Return what a message calls a column."""
    return f"column {column.position + 1} {quoted(layout.header[column.position])}"
