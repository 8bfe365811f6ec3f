"""Where the header is, and what the columns are: by it, by their cells, or as named in turn.

What to write where no header says so.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Container, Iterable, Sequence
from itertools import pairwise

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.base.moments import is_moment
from scara_iso.run import UNITS, declared_conditions, unit_of_condition
from scara_iso.tables.grid import ONE_COLUMN, Faults, Row, is_dash, is_filled, is_rule
from scara_iso.tables.statements import read_statements
from scara_iso.tables.vocabulary.names import (
    COLUMNS,
    COVARIATES,
    Column,
    Kind,
    Layout,
    axes_in,
    count_in_words,
    filled_width,
    header_cells,
    is_axis,
    names_an_axis,
    pose_alone,
    read_name,
    read_names,
    read_timestamp,
    read_unit,
    settle,
    unit_in_brackets,
    with_likely,
)
from scara_iso.tables.vocabulary.words import (
    LONGEST_NAME,
    Mark,
    Pattern,
    clean,
    is_of_another,
    names_a_footer,
    names_a_limit,
    names_an_instrument,
    numbers_a_thing,
    parse_cell,
    quoted,
    subject_of_heading,
)

_BETWEEN_CELLS = r"[;\t|]|,[^,]*,"
_FEWEST_COUNTED = 10
"""Rows from which 1, 2, 3 .. is a count and no chance."""
_BESIDE_AXES = {Kind.CYCLE, Kind.POSE, Kind.COMMENT, Kind.TIMESTAMP}


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


_WORDED = re.compile(
    r"(?:([^\W\d_](?:[^\W\d_]|[ -](?=[^\W\d_]))*)[ -])?(x|y|z|theta)(?:[ -]([^\W\d_]{1,40}))?"
    r"( ?[\[({</].*| in .*|_(?:mm|um|µm|in|inch|deg))?",
    re.IGNORECASE,
)
"""A word, an axis and its unit, or the word behind the axis: ``Uhr X (mm)``, ``X Sonde``."""


def find_worded(rows: Sequence[Row]) -> Layout | None:
    """Return the layout of a header whose axes stand with one word in no list: ``Uhr X``.

    Each axis is there once, in a length or angle where the word is not that of an instrument, and
    numbers follow. The word is none that changes readings, of a condition or of a figure. For rows
    in which no cell names an axis by itself.
    """
    for k, row in enumerate(rows):
        names = header_cells(row.cells[: COLUMNS + 1])
        found = {j: m for j, name in enumerate(names) if (m := _WORDED.fullmatch(name))}
        words = {clean(m[1] or m[3] or "").lower() for m in found.values()}
        axes = [m[2].lower() for m in found.values()]
        if len(words) != 1 or len(axes) != len(set(axes)) or not _is_free(*words):
            continue
        measured = all(read_unit(unit_in_brackets(names[j])) for j in found)
        if not measured and not names_an_instrument(*words):
            continue
        bare = [f"{found[j][2]}{found[j][4] or ''}" if j in found else name
                for j, name in enumerate(names)]  # fmt: skip
        layout = _layout([*rows[:k], row._replace(cells=bare), *rows[k + 1 :]], k)
        if layout.sure:
            return layout._replace(worded=words.pop())
    return None


def _is_free(word: str) -> bool:
    """Say whether a word in front of an axis is of its readings, as that of an instrument is."""
    if not word or is_of_another(word) or names_a_limit(word) or _FIGURE.fullmatch(word):
        return False
    return subject_of_heading(f"{word} x") is None and subject_of_heading(word) is None


_FIGURE = Pattern(
    r"(?:<footer.any>|<dial.resolution>|<dial.other_size>|<column.target>|command|set.*)\b.*"
)


def _is_one_field(rows: Sequence[Row], k: int) -> bool:
    """Say whether all rows below are one field that another delimiter parts."""
    below = [r for r in rows[k + 1 :] if r.text and not is_rule(r.text)]
    return bool(below) and all(
        len(r.cells) == 1 and re.search(_BETWEEN_CELLS, r.text) for r in below
    )


_RUN = r"(?:run|lauf|messung|cycle|zyklus|trial|j|n|#)? ?=? ?[0-9]{1,3}"
_TRIAL = r"(?:(x|y|z|theta)[ _]?[0-9]+|[0-9]+[ _]?(x|y|z|theta))(?: ?[\[(/].*)?"
_POSE_ALONE = r"(?:pose|point|punkt|p)[ _.-]?[0-9]{1,3}"
_OF_A_POSE = (
    r"(?:(?:pose|point|punkt)[ _.-]?[a-z0-9]{1,3}[ _:.-]+|p[ _.-]?[0-9]{1,3}[\W_]*)(x|y|z|theta)"
    r"(?: ?[\[(/].*)?"
)
SKIPPED = "-"


def column_names(columns: str | Sequence[str]) -> tuple[str, ...]:
    """Return the names of ``X,Y,-`` or of a sequence; `UsageError` where none is an axis."""
    names = columns.split(",") if isinstance(columns, str) else columns
    found = tuple(name.strip() for name in names)
    if not names_an_axis(found) or not all(found) or len(found) > COLUMNS:
        raise UsageError(
            f"columns {quoted(','.join(found))} name no axis X, Y, Z or theta",
            remedy="name each field in turn, - for one to leave out: `columns=cycle,X,Y,-`",
        )
    return found


def place_columns(rows: Sequence[Row], names: Sequence[str]) -> Layout | None:
    """Return the layout that ``names`` give the first row of as many fields, numbers for axes."""
    columns = [
        column._replace(heading=f"field {column.position + 1}") if name == SKIPPED else column
        for name, column in zip(
            names, read_names(["note" if n == SKIPPED else n for n in names]), strict=True
        )
    ]
    fitting = [row for row in rows if _fits(row, columns)]
    if _holds_other_delimiter([row.cells for row in fitting]):
        return None
    # LabVIEW's "Samples 5 5" above its columns is not like the rows
    row = next((row for row in fitting if _is_like(row, fitting[-1])), None)
    if row is None:
        return None
    above = [one for one in rows if one.line < row.line]
    found = (settle(c, row.cells[c.position]) for c in columns)
    settled = tuple(_with_unit(column, above) for column in found)
    return Layout(settled, row.line, row.line, sure=True, known=len(fitting))


def _fits(row: Row, columns: Sequence[Column]) -> bool:
    if len(row.cells) < len(columns) or any(map(is_filled, row.cells[len(columns) :])):
        return False
    sized = (c for c in columns if c.kind in (Kind.AXIS, Kind.CYCLE))
    return all(parse_cell(row.cells[c.position]) is not None for c in sized)


def _is_like(row: Row, other: Row) -> bool:
    """Say whether no field holds a number in one row and words in the other."""
    pairs = [p for p in zip(row.cells, other.cells, strict=False) if all(map(str.strip, p))]
    return all((parse_cell(a) is None) == (parse_cell(b) is None) for a, b in pairs)


def _unit_above(row: Row, column: Column) -> str:
    return unit_in_brackets(row.cells[column.position]) if column.position < len(row.cells) else ""


def _with_unit(column: Column, above: Sequence[Row]) -> Column:
    """Return an axis with the unit of the file's own heading, where `columns=` states none."""
    stated = [unit for row in above if (unit := _unit_above(row, column))]
    lacks = column.kind is Kind.AXIS and not column.unit and stated
    return column._replace(unit=stated[-1]) if lacks else column


def check_names(rows: Iterable[Row], layout: Layout, faults: Faults) -> None:
    """Refuse names and units that the file's own header gives otherwise, and incomplete rows."""
    axes = layout.of(Kind.AXIS)
    for row in (row for row in rows if row.line < layout.header_line):
        filled = [cell for cell in row.cells if cell.strip()]
        if filled and all(map(parse_cell, filled)):
            what = f"{len(filled)} numbers above the first row of {layout.width} fields"
            faults.add(what, row.line, remedy="complete the line, or remove it")
        for column in axes:
            place, unit = (row.line, column.position + 1), _unit_above(row, column)
            if unit and read_unit(unit) != read_unit(column.unit):
                what = f"{quoted(unit)} heads {column.name}, and `columns=` states {column.unit}"
                faults.add(what, *place, remedy="name the unit that is true")
            wide = len(row.cells) >= layout.width and ":" not in row.cells[0]
            cell = row.cells[column.position] if wide and not names_an_axis(row.cells) else ""
            if (named := axes_in(cell)) and column.name not in named:
                what = f"{quoted(cell)} heads {column.name} of `columns=`"
                faults.add(what, *place, remedy="name each field by the axis that its heading says")
        own = header_cells(row.cells) if names_an_axis(row.cells) else []
        stated = {c.name: c.position for c in axes}
        for column in read_names(own):
            k = stated.get(column.name, column.position)
            if column.kind is Kind.AXIS and k != column.position:
                what = f"{column.name} by the header, and `columns=` says it is field {k + 1}"
                remedy = "leave `columns=` out, or remove the header"
                faults.add(what, row.line, column.position + 1, remedy=remedy)


def runs_across(rows: Sequence[Row]) -> Row | None:
    """Return the first row of runs side by side: ``Run 1 Run 2``, ``X1 X2``, ``P0 X P1 X``."""
    for row in rows:
        short = [clean(cell).lower() for cell in row.cells if len(cell) <= LONGEST_NAME]
        found = [re.fullmatch(_TRIAL, text) or re.fullmatch(_OF_A_POSE, text) for text in short]
        axes = [trial[trial.lastindex or 0] for trial in found if trial]
        if len(axes) > len(set(axes)):
            return row
        named = [
            text for text in short if re.fullmatch(_RUN, text) or re.fullmatch(_POSE_ALONE, text)
        ]
        if len(named) > 1 and not all(map(parse_cell, named)):
            return row
    return None


def _holds_other_delimiter(rows: Sequence[Sequence[str]]) -> bool:
    """Say whether another mark parts as many numbers in every row: ``a 0,820`` parts at a blank."""
    commas = not any("," in cell for cells in rows for cell in cells)
    between, marks = (",", " ;\t|") if commas else ("\n", ";\t|")
    texts = [between.join(cell.strip() for cell in cells) for cells in rows]
    ways = ([_count_sizes(text.split(mark)) for mark in marks if mark in text] for text in texts)
    both = zip(ways, map(_count_sizes, rows), strict=True)
    return bool(rows) and all(max(found, default=-1) >= own for found, own in both)


def _count_sizes(cells: Iterable[str]) -> int:
    return sum(_is_size(cell.strip()) for cell in cells)


def _is_size(cell: str) -> bool:
    one = parse_cell(cell)
    return bool(one and one.mark is not Mark.BOTH and (not one.unit or read_unit(one.unit)))


def _layout(rows: Sequence[Row], k: int) -> Layout:
    names = header_cells(rows[k].cells)
    above = _padded(list(map(clean, rows[k - 1].cells)) if k else [], len(names))
    for j, text in enumerate(above):  # such as Lauf in a heading of two rows
        if not names[j] and text and read_name(text).kind in _BESIDE_AXES:
            names[j] = text
    below = _next_row(rows, k + 1)
    units: list[str] = []
    last = k
    if below is not None and _is_unit_row(names, rows[below].cells):
        units = [clean(cell).strip("[]() ") for cell in rows[below].cells]
        last, below = below, _next_row(rows, below + 1)
    data = rows[below:] if below is not None else []
    cells = data[0].cells if data else []
    widest = max((len(row.cells) for row in data), default=0)
    if names[0] == "#" and widest == len(names) - 1:
        names = names[1:]  # "# X Y Z" over three columns of blanks, as numpy writes it
    numbered = widest == len(names) + 1 and _counts([c for r in data for c in r.cells[:1]], start=0)
    counted = any(read_name(name).kind is Kind.CYCLE for name in names)
    if numbered and is_axis(names[0]) and not counted:
        names = ["", *names]  # over the numbers of rows, as R writes them
    first = _padded(cells, len(names))
    named = read_names(names, _padded(units, len(names)))
    settled = [settle(column, first[column.position]) for column in named]
    stated = {one.key: one.value for row in rows[:k] for one in read_statements(row)}
    declared = declared_conditions(stated)
    by_cells = _by_cells(settled, data, declared)
    columns = tuple(_remarks(c, data, declared) for c in with_likely(by_cells))
    numeric = any(parse_cell(first[c.position]) for c in columns if c.kind is Kind.AXIS)
    words = any(map(clean, cells)) and not any(map(parse_cell, cells))
    sure = numeric and filled_width(cells) <= len(names) <= len(cells)
    known = sum(c.kind not in (Kind.COVARIATE, Kind.NAMELESS) for c in columns)
    end = rows[last].end
    return Layout(columns, rows[k].line, end + 1, sure, known, words)


def _by_cells(
    columns: Sequence[Column], rows: Sequence[Row], declared: Container[str]
) -> list[Column]:
    """Return the columns with those that name the pose, and count, by their cells alone.

    A pose is named in each row, as P3 or Pose 3. A column counts where its whole numbers go on by
    one from row to row; they may begin at 1 again where poses are named. Of several that are called
    counters, those without a number are remarks. Stamps of no time are dates.
    """
    cells = {c: _cells(c, rows) for c in columns}
    counters = [c for c in columns if c.kind is Kind.CYCLE]
    numbered = [c for c in counters if any(map(parse_cell, cells[c]))]
    kinds = {c: Kind.COMMENT for c in counters if numbered and c not in numbered}
    free = (c for c in columns if c.kind is Kind.COVARIATE and not (c.condition or c.unit))
    unknown = [c for c in free if c.name.lower() not in declared and not numbers_a_thing(c.name)]
    unknown += [c for c in columns[:1] if c.kind is Kind.NAMELESS]
    parted = {c.kind for c in columns} & {Kind.POSE, Kind.DIRECTION}
    poses = [c for c in unknown if cells[c] and all(map(pose_alone, cells[c])) and not parted]
    again = bool(parted or poses)
    starts = {c: int(c.kind is not Kind.NAMELESS) for c in unknown if not counters}
    counts = [c for c, start in starts.items() if _counts(cells[c], again=again, start=start)]
    stamps = [c for c in columns if c.kind is Kind.TIMESTAMP]
    moments = [c for c in (*stamps, *unknown) if _are(is_moment, cells[c])]
    instants = [c for c in moments if _are(read_timestamp, cells[c])]
    kinds |= dict.fromkeys(moments, Kind.COMMENT)
    kinds |= dict.fromkeys(instants[: all(c.name != "time_s" for c in columns)], Kind.TIMESTAMP)
    kinds |= {c: Kind.COMMENT for c in stamps if all(x.endswith("T00:00:00") for x in cells[c])}
    kinds |= dict.fromkeys(poses[:1], Kind.POSE) | dict.fromkeys(counts[:1], Kind.CYCLE)
    return [c._replace(kind=kinds.get(c, c.kind)) for c in columns]


def _are(check: Callable[[str], object], cells: Sequence[str]) -> bool:
    """Say whether all cells are so, but for empty ones and labels of footers."""
    filled = [text for text in cells if text and not names_a_footer(text)]
    return bool(filled) and all(map(check, filled))


def _counts(cells: Sequence[str], *, again: bool = False, start: int = 1) -> bool:
    counts = [count_in_words(cell) for cell in cells]
    found = [int(number) for number, words in counts if number and words == counts[0][1]]
    if len(found) < _FEWEST_COUNTED or found[0] not in (1, start) or max(found) < _FEWEST_COUNTED:
        return False
    return all(n == before + 1 or (again and n == 1) for before, n in pairwise(found))


def _cells(column: Column, rows: Sequence[Row]) -> list[str]:
    return [r.cells[column.position].strip() for r in rows if len(r.cells) > column.position]


def _remarks(column: Column, rows: Sequence[Row], declared: Container[str]) -> Column:
    """Return a column of no known name as a comment where its cells are words, but not in each row.

    Words in every row may be a label, a state or a pose, unless declared or all the same; marks
    such as ``i.O.`` are remarks.
    """
    if column.kind is not Kind.COVARIATE or column.name in COVARIATES:
        return column
    found = _cells(column, rows)
    filled = [text for text in found if text and not is_dash(text)]
    words = all(text[0].isalpha() and not parse_cell(text) for text in filled)
    same = len(set(filled)) == 1 and read_unit(filled[0]) is None
    same = same or column.name.lower() in declared
    same = same or (bool(filled) and all(_A_MARK.fullmatch(text.lower()) for text in filled))
    is_remark = words and (len(filled) < len(found) or same)
    return column._replace(kind=Kind.COMMENT) if is_remark else column


_A_MARK = Pattern("<heading.marked>|<heading.valid>")


def _padded(cells: Sequence[str], width: int) -> list[str]:
    return [*cells, *[""] * width][:width]


def _next_row(rows: Sequence[Row], k: int) -> int | None:
    """Return the first row from ``k`` on that is neither blank, a ruled line nor a comment."""
    texts = enumerate((row.text for row in rows[k:]), k)
    return next((j for j, x in texts if x and not is_rule(x) and not x.startswith("#")), None)


def _is_unit_row(names: list[str], cells: list[str]) -> bool:
    found = [clean(cell).strip("[]() ") for cell in cells]
    if any(map(parse_cell, found)):
        return False
    axes = [k for k, n in enumerate(names[: len(found)]) if is_axis(n)]
    if any(read_unit(found[k]) for k in axes if found[k]):
        return True
    stated = [cell for cell in found if cell]
    return bool(stated) and all(unit_of_condition(cell) in UNITS for cell in stated)


ONE_A_ROW = (
    "write a row for each reading: pose,approach,cycle,X with the target as its pose; where the "
    "columns are of several poses, head them P1_X, P1_Y, P2_X"
)
_TARGET = Pattern(r"<column.target>\b.*")
_REPETITIONS = r"\b(x|y|z|theta)[ _]?1\b.*\b\1[ _]?2\b"
_FORCE = Pattern(r"(?:force|kraft)\b|force_n")
_MOST_NAMED = 40
"""Fields that a suggestion names."""
_OFTEN = 3  # times that each pose comes again
_FEWEST_ACROSS = 12  # a row of a measuring report has nominal, tolerances, measured, deviation
_TURN = (
    "the axes stand in rows: turn the table, so that each has a column "
    "(in a spreadsheet: copy, then paste special, transpose)"
)


def suggest_columns(tables: Sequence[Sequence[Row]]) -> str:
    """Return what to do with rows that no header names, parted in each way that there is.

    Most rows of the same number of fields, most of them numbers, are taken for the table.
    """
    if any(map(runs_across, tables)):
        return ONE_A_ROW
    every = [row.cells for rows in tables for row in rows]
    names = [clean(c).lower() for cells in every for c in cells if len(c) <= LONGEST_NAME]
    if advice := _other_test(names):
        return advice
    if any(
        len(cells) > _FEWEST_ACROSS and all(map(_is_size, cells[1:])) and is_axis(cells[0])
        for cells in every
    ):
        return _TURN
    alike = [r for table in tables if (r := _alike(table)) and not _holds_other_delimiter(r)]
    if advice := next(filter(None, map(_of_headings, tables)), ""):
        return advice
    rows = max(alike, key=lambda rows: (len(rows), len(rows[0])), default=[])
    named = _likely_names(rows) if len(rows) > 1 and len(rows[0]) <= _MOST_NAMED else []
    or_else = ""
    numbers = {
        "".join(map("".join, r)): r for r in alike if all(_count_sizes(c) == len(c) for c in r)
    }
    whole = next((r for text, r in numbers.items() if "," in text and "." not in text), [])
    if "cycle" not in named and len(whole) > 1:
        or_else = "" if rows is whole or "-" in named else f" or `columns={','.join(named)}`"
        rows, named = whole, _likely_names(whole)
    headings = (c for cells in every if len(cells) == len(named) for c in cells)
    headed = set().union(*map(axes_in, headings))
    if len(headed) > 1:
        named = [name if name not in "XYZ" or name in headed else "-" for name in named]
    if "X" not in named:
        return ""
    said = quoted(", ".join(map(clean, rows[-1])))
    return (
        f"no header says what {said} is: name them in order (- skips one), for example "
        f"`columns={','.join(named)}`{or_else}"
    )


_TWO_AXES = r"(?i)(?:x|y|z) ?[/,;&+|] ?(?:x|y|z)\b.*"


def _of_headings(rows: Sequence[Row]) -> str:
    """Return what to do with a column that names the axis of each row, or a cell that names two."""
    data = [row.cells for row in rows if len(row.cells) > 1 and any(map(parse_cell, row.cells))]
    if len(data) < _FEWEST_COUNTED or _holds_other_delimiter(data):
        return ""
    if any(2 * sum(map(is_axis, cells)) > len(data) for cells in zip(*data, strict=False)):
        return f"a column names the axis of each row: {ONE_COLUMN}"
    both = (c for row in rows for c in map(clean, row.cells) if re.fullmatch(_TWO_AXES, c))
    return next((f"{quoted(text)} heads two axes: give each its own column" for text in both), "")


def _other_test(names: Sequence[str]) -> str:
    """Return what to do with columns of a push test, of targets, or of repetitions of one axis."""
    if any(map(_FORCE.match, names)):
        return "readings over a force are a push test: the command push reads this table"
    if any(map(_TARGET.fullmatch, names)):
        return f"the targets of ISO 230-2: {ONE_A_ROW}"
    return ONE_A_ROW if re.search(_REPETITIONS, " ".join(names)) else ""


def _alike(rows: Sequence[Row]) -> list[list[str]]:
    """Return the rows with numbers in the usual cells, among those of a third of them or more."""
    found = [row.cells for row in rows if 3 * sum(map(_is_size, row.cells)) >= len(row.cells)]
    found = [c for c in found if not any(is_axis(x) for x in c if len(x) <= LONGEST_NAME)]
    forms = [tuple(map(_is_size, cells)) for cells in found]
    return [c for c, form in zip(found, forms, strict=True) if form == max(forms, key=forms.count)]


def _likely_names(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return what each field may be called: a count, a pose, a clock or words (-), or an axis."""
    numbers = [[parse_cell(cell) if _is_size(cell) else None for cell in cells] for cells in rows]
    columns = np.array([[one.value if one else math.nan for one in row] for row in numbers]).T
    are_whole = [bool(np.all(column == np.round(column))) for column in columns]
    axes, names = iter(("X", "Y", "Z")), list[str]()
    for cells, column, whole in zip(zip(*rows, strict=True), columns, are_whole, strict=True):
        known, digits = column[np.isfinite(column)], all(cell.strip().isdigit() for cell in cells)
        steps, levels = np.diff(known), len(set(known.tolist()))
        counts = digits and bool(np.all(steps == 1)) and not all(are_whole)
        often = whole and 1 < levels <= len(rows) // _OFTEN and not all(are_whole)
        goes_on = len(known) > 2 and bool(np.all(steps > 0) or levels == 1)
        if counts and "cycle" not in names:
            names.append("cycle")
        elif often and "pose" not in names:
            names.append("pose")
        else:
            names.append("-" if math.isnan(column[-1]) or goes_on else next(axes, "-"))
    return names
