"""A `Run` to the canonical table, and to what the command ``tables`` shows.

How a table is spelt for the spreadsheet that will open it.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from typing import Annotated, Literal, TypeAlias

import numpy as np

from scara_iso.base.errors import DataError
from scara_iso.base.published import MERGED
from scara_iso.base.quantities import Dimension
from scara_iso.run import AXES, SEPARATOR, FloatArray, Run
from scara_iso.tables.statements import REMARKED, normal_key
from scara_iso.tables.summaries import figure_in_last_row
from scara_iso.tables.vocabulary.names import Column, Kind, read_name, with_likely
from scara_iso.tables.vocabulary.words import COMMAND, FORMULA, Mark, is_of_axes, parse_cell

_CONTROL = r"[\x00-\x1f\x7f-\x9f]+"


class Digits(str):
    """A number spelt with a decimal point, its digits chosen."""

    __slots__ = ()


OutputCell: TypeAlias = str | Digits | int | float | None
"""Text, a number, or nothing; only text is ever guarded against being taken for a formula."""


@dataclass(frozen=True, slots=True)
class SheetLocale:
    """What stands between cells, the decimal mark, and what the file begins with."""

    delimiter: str = ","
    decimal: str = "."
    bom: str = ""


PLAIN = SheetLocale()
"""The canonical table."""
# A German Excel splits at semicolons, an English one at commas; both take a file without a byte
# order mark for one of the old code pages.
EXCEL = {"de": SheetLocale(";", ",", "\ufeff"), "en": SheetLocale(",", ".", "\ufeff")}


def find_locale(name: object) -> SheetLocale:
    """Return the locale of an Excel by its language; `PLAIN` for anything else."""
    return EXCEL.get(name, PLAIN) if isinstance(name, str) else PLAIN


def write_rows(rows: Iterable[Sequence[OutputCell]], locale: SheetLocale = PLAIN) -> str:
    """Return rows as CSV with LF line ends, without the byte order mark.

    Numbers stay numbers, whatever their sign; what is not finite is an empty cell. Text is kept on
    one line and cannot become a formula.
    """
    spelt = [[_spell(cell, locale) for cell in row] for row in rows]
    if locale.decimal == ",":
        _settle_commas(spelt)
    file = io.StringIO()
    csv.writer(file, delimiter=locale.delimiter, lineterminator="\n").writerows(spelt)
    return file.getvalue()


def text_cell(text: str) -> str:
    """Return text that no spreadsheet takes for a formula; what spells a number is left alone.

    -2 mm spells none: a spreadsheet would work it out, and show an error.
    """
    text = one_line(text)
    start, number = text.lstrip()[:1], parse_cell(text)
    is_number = number is not None and not number.unit
    if start == "'" or (start and start in FORMULA and not is_number):
        return "'" + text
    return text


def one_line(text: str) -> str:
    """Return text with a blank for control characters."""
    return re.sub(_CONTROL, " ", text)


def _spell(cell: OutputCell, locale: SheetLocale) -> str:
    match cell:
        case None:
            return ""
        case Digits():
            return Digits(cell.replace(".", locale.decimal))
        case str():
            return text_cell(cell)
        case float() if not math.isfinite(cell):
            return ""
        case _:
            return Digits(str(cell).replace(".", locale.decimal))


def _settle_commas(rows: list[list[str]]) -> None:
    """Let 1,234 end in a zero where no other number says that the comma is a decimal one."""
    numbers = [parse_cell(cell) for row in rows for cell in row if isinstance(cell, Digits)]
    if any(number and number.mark is Mark.COMMA for number in numbers):
        return
    for row in rows:
        for k, cell in enumerate(row):
            number = parse_cell(cell) if isinstance(cell, Digits) else None
            if number and number.mark is Mark.EITHER:
                mantissa, e, exponent = cell.partition("e")
                row[k] = f"{mantissa}0{e}{exponent}"


_CUT = re.compile(rf"[,;]\s*[\"']?[{re.escape(FORMULA)}]|[,;\"]\s*$|^[^:]*\"|^[^:]*(:\s*)?[,;]")


def write_table(run: Run, locale: SheetLocale = PLAIN) -> str:
    """Return ``run`` as the canonical table, which `read_table` reads back to the same run.

    Metadata lines first; lengths in mm, angles in degrees; readings with the digits of their
    resolution unless that would change a value; LF line ends. No text in it becomes a formula in
    a spreadsheet. ``locale`` spells the cells as a spreadsheet takes them; metadata lines stay as
    they are. Raises `DataError` for columns whose name says something else in a table.
    """
    axes = [name for name in run.axes if name not in AXES]
    if wrong := [*axes, *refused_covariates(run.covariates)]:
        what = f"a table cannot hold columns named {', '.join(map(repr, wrong))}"
        raise DataError(what, remedy="rename them")
    columns: dict[str, list[str]] = {"cycle": [Digits(n) for n in run.cycle.tolist()]}
    if run.pose is not None:
        columns["pose"] = run.pose.tolist()
    if run.direction is not None:
        columns["approach"] = run.direction.tolist()
    columns |= {name: _digits(axis.readings, axis.resolution) for name, axis in run.axes.items()}
    columns |= _commands(run)
    columns |= {n: _plain(n, values) for n, values in run.covariates.items()}
    shown = {name: np.array(columns[name], dtype=float) for name in run.axes}
    if figure_in_last_row(run, shown):
        run = replace(run, metadata={**run.metadata, "last_row": "counts"})
    head = "".join(f"{line}\n" for line in _preamble(run))
    rows = zip(*columns.values(), strict=True)
    return locale.bom + head + write_rows([tuple(columns), *rows], locale)


def refused_covariates(names: Iterable[str]) -> list[str]:
    """Return the names of columns that a table would take for something else."""
    named = list(names)
    cells = [text_cell(name) for name in named]
    read = with_likely([read_name(cell) for cell in cells])
    return [name for name, found in zip(named, read, strict=True) if not _is_as_read(name, found)]


def _is_as_read(name: str, read: Column) -> bool:
    if read.kind in (Kind.OPEN, Kind.TIMESTAMP):  # of numbers, so it is read as numbers again
        return True
    converts = read.condition is not None and read.condition.converts
    return read.name == name and read.kind in (Kind.COVARIATE, Kind.APPROACH) and not converts


def _preamble(run: Run) -> Iterator[str]:
    lengths = {n: a for n, a in run.axes.items() if a.dimension is Dimension.LENGTH}
    angles = {n: a for n, a in run.axes.items() if a.dimension is Dimension.ANGLE}
    if lengths:
        yield "# unit: mm"
    for name in angles:
        yield f"# unit_{name}: deg"
    dials = {**lengths, **angles}
    sizes = {name: axis.resolution for name, axis in dials.items()}
    yield from _sizes("resolution", sizes, list(lengths))
    sizes = {name: axis.uncertainty for name, axis in dials.items()}
    yield from _sizes("indicator_uncertainty", sizes, list(lengths))
    for name, axis in run.axes.items():
        if isinstance(axis.command, float | int):
            yield f"# {COMMAND}_{name}: {axis.command!r}"
        elif axis.command is not None and f"{COMMAND}_{name}" not in _commands(run):
            yield from (f"# {COMMAND}_{name}[{p}]: {v!r}" for p, v in axis.command.items())
    for key, value in (_remarked(run) | dict(run.metadata)).items():
        name = one_line(normal_key(key).replace(":", "_").replace("=", "_"))
        if not is_of_axes(name):
            yield _metadata_line(name, value)


def _remarked(run: Run) -> dict[str, str]:
    """Return what was remarked, but for statements: whoever reads them again remarks on them."""
    again = {_letters(f"{key}{value}") for key, value in run.metadata.items()}
    remarks = [one for one in run.origin.remarks if _letters(_quoted_in(one)) not in again]
    return {REMARKED: SEPARATOR.join(remarks)} if remarks else {}


def _quoted_in(remark: str) -> str:
    return re.sub(r"^[^'\"]*", "", remark)


def _letters(text: str) -> str:
    return re.sub(r"[\W_]+", "", text).casefold()


def _commands(run: Run) -> dict[str, list[str]]:
    labels = [] if run.pose is None else run.pose.tolist()
    return {
        f"{COMMAND}_{name}": [Digits(axis.command[label]) for label in labels]
        for name, axis in run.axes.items()
        if labels and isinstance(axis.command, Mapping) and set(labels) == set(axis.command)
    }


def _sizes(key: str, sizes: dict[str, float | None], lengths: list[str]) -> Iterator[str]:
    shared = sizes[lengths[0]] if lengths else None
    if shared is not None and all(sizes[name] is not None for name in lengths):
        yield f"# {key}: {shared!r}"
        sizes = {n: size for n, size in sizes.items() if n not in lengths or size != shared}
    yield from (f"# {key}_{n}: {size!r}" for n, size in sizes.items() if size is not None)


def _metadata_line(key: str, value: str) -> str:
    """Return a metadata line; in quotes where a formula or another key could be cut out."""
    line = f"# {key}: {one_line(value).strip()}"
    if not _CUT.search(line):
        return line
    return '"' + line.replace('"', '""') + '"'


def _digits(values: FloatArray, resolution: float | None) -> list[str]:
    if resolution is None:
        return [Digits(v) for v in values.tolist()]
    places = max(0, -int(Decimal(repr(resolution)).normalize().as_tuple().exponent))
    rounded = [(f"{v:.{places}f}", v) for v in values.tolist()]
    return [Digits(text if float(text) == v else v) for text, v in rounded]


def _plain(name: str, values: FloatArray) -> list[str]:
    if name == "approach" and np.all(np.abs(values) == 1):
        return [Digits(f"{v:+.0f}") for v in values.tolist()]
    return [Digits(v) for v in values.tolist()]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PublishedTable:
    """``tables`` of a table, or of several: what was understood of it."""

    schema: Literal["scara-iso/tables/1"] = "scara-iso/tables/1"
    """Name and number of this schema."""
    rows: Annotated[int, ("minimum", 1)]
    """Number of rows."""
    run: Run = field(metadata=MERGED)


def published_table(run: Run) -> PublishedTable:
    """Return what was understood of a table."""
    return PublishedTable(rows=len(run), run=run)
