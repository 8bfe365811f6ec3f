"""An oracle: one table of known numbers, and the bytes of it in any spelling.

It shares no code with the reader. Readings are whole micrometres; the reader must give each back
as the double next to the exact number of millimetres.
"""

from __future__ import annotations

import codecs
import io
from dataclasses import dataclass, field
from decimal import Decimal

import openpyxl

SIZES = {
    "mm": Decimal(1),
    "um": Decimal("0.001"),
    "inch": Decimal("25.4"),
    "0.01 mm": Decimal("0.01"),
}
ENCODINGS = {
    "utf-8": lambda text: text.encode(),
    "utf-8-bom": lambda text: codecs.BOM_UTF8 + text.encode(),
    "utf-16": lambda text: codecs.BOM_UTF16_LE + text.encode("utf-16-le"),
    "utf-16-be": lambda text: codecs.BOM_UTF16_BE + text.encode("utf-16-be"),
    "cp1252": lambda text: text.encode("cp1252"),
}


@dataclass(frozen=True)
class Table:
    """Readings in whole steps of 0.000254 mm (which is 0.254 um and 0.00001 inch)."""

    axes: dict[str, list[int]]
    covariates: dict[str, list[str]] = field(default_factory=dict)
    pose: list[str] | None = None

    @property
    def rows(self) -> int:
        return len(next(iter(self.axes.values())))

    def readings(self, axis: str, unit: str) -> list[float]:
        """Return what must be read, in mm, to the last digit or the one before it."""
        return [float(Decimal(n) * STEP) for n in self.axes[axis]]


STEP = Decimal("0.000254")


@dataclass(frozen=True)
class Spelling:
    """How a table is written."""

    delimiter: str = ","
    mark: str = "."
    encoding: str = "utf-8"
    end: str = "\n"
    unit: str = "mm"
    unit_place: str = "metadata"  # bracket, parenthesis, suffix, slash, row, behind, option
    preamble: str = "#"  # bare, cells
    cycle: str = "cycle"
    quoted: bool = False
    sep_line: bool = False
    trailing: int = 0
    plus: bool = False
    minus: str = "-"
    blank: str = ""  # around every number
    blank_lines: bool = False
    repeated_header: bool = False
    footer: tuple[str, ...] = ()
    order: int = 1  # -1: columns the other way round
    exponent: bool = False
    rule: bool = False
    last_end: bool = True


def number(value: Decimal, spelling: Spelling) -> str:
    text = f"{value:E}" if spelling.exponent else f"{value:f}"
    text = text.replace("E+", "E") if spelling.exponent and not spelling.plus else text
    if spelling.plus and value >= 0:
        text = "+" + text
    text = text.replace(".", spelling.mark).replace("-", spelling.minus)
    return f"{spelling.blank}{text}{spelling.blank}"


def header(axis: str, spelling: Spelling) -> str:
    unit = spelling.unit
    return {
        "bracket": f"{axis} [{unit}]", "parenthesis": f"{axis.lower()} ({unit})",
        "suffix": f"{axis}_{unit}", "slash": f"{axis} / {unit}",
    }.get(spelling.unit_place, axis)  # fmt: skip


def columns(table: Table, spelling: Spelling) -> list[tuple[str, str, list[str]]]:
    """Return header, unit below and cells of each column."""
    behind = f" {spelling.unit}" if spelling.unit_place == "behind" else ""
    found = [(spelling.cycle, "", [str(n + 1) for n in range(table.rows)])]
    if table.pose is not None:
        found.append(("pose", "", table.pose))
    for axis, steps in table.axes.items():
        values = [Decimal(n) * STEP / SIZES[spelling.unit] for n in steps]
        cells = [number(v.normalize(), spelling) + behind for v in values]
        found.append((header(axis, spelling), spelling.unit, cells))
    for name, cells in table.covariates.items():
        found.append((name, "", [cell.replace(".", spelling.mark) for cell in cells]))
    return found[:: spelling.order]


def lines(table: Table, spelling: Spelling) -> list[str]:
    found = columns(table, spelling)
    names = [name for name, _, _ in found]
    rows = [list(cells) for cells in zip(*(cells for _, _, cells in found), strict=True)]
    body = [[f"{n}" for n in names]]
    if spelling.unit_place == "row":
        body.append([unit or "-" for _, unit, _ in found])
    if spelling.rule:
        body.append(["----" for _ in found])
    for k, row in enumerate(rows):
        if spelling.repeated_header and k and k % 10 == 0:
            body.append(names)
        body.append(row)
        if spelling.blank_lines and k % 5 == 4:
            body.append([])
    nine = f"9{spelling.mark}9"
    body += [[label if n == spelling.cycle else nine for n in names] for label in spelling.footer]
    text = [join(row, found, spelling) + spelling.delimiter * spelling.trailing for row in body]
    if spelling.delimiter == " ":
        text = [line.rstrip() for line in text]
    return [*preamble(spelling), *text]


def join(row: list[str], found: list[tuple[str, str, list[str]]], spelling: Spelling) -> str:
    if spelling.quoted:
        row = [f'"{cell}"' for cell in row]
    if spelling.delimiter == " ":
        widths = [3 + max(map(len, (name, *cells))) for name, _, cells in found]
        return "".join(cell.rjust(width + 20) for cell, width in zip(row, widths, strict=False))
    return spelling.delimiter.join(row)


def preamble(spelling: Spelling) -> list[str]:
    pairs = [("robot", "FUM SCARA"), ("resolution", f"0{spelling.mark}001 mm")]
    if spelling.unit_place == "metadata":
        pairs.append(("unit", spelling.unit.replace(".", spelling.mark)))
    filler = spelling.delimiter * spelling.trailing
    shape = {"#": "# {}: {}", "bare": "{}: {}", "cells": f"{{}}{spelling.delimiter}{{}}"}
    found = [shape[spelling.preamble].format(*pair) + filler for pair in pairs]
    if spelling.preamble != "#":
        found.insert(0, "Repeatability test")
    return [f"sep={spelling.delimiter}", *found] if spelling.sep_line else found


def spell(table: Table, spelling: Spelling) -> bytes:
    text = spelling.end.join(lines(table, spelling))
    text += spelling.end if spelling.last_end else ""
    return ENCODINGS[spelling.encoding](text)


def workbook(table: Table, spelling: Spelling, *, first_row: int = 1) -> bytes:
    """Return an .xlsx file with numbers as numbers."""
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    found = columns(table, spelling)
    rows: list[list[object]] = [[f"unit: {spelling.unit}"], ["robot", "FUM SCARA"], []]
    rows.append([name for name, _, _ in found])
    for k in range(table.rows):
        cells = [cells[k] for _, _, cells in found]
        rows.append(
            [c if name == "pose" else float(c) for (name, *_), c in zip(found, cells, strict=True)]
        )
    rows += [[label, 9.9, 9.9] for label in spelling.footer]
    for k, row in enumerate(rows, first_row):
        for j, value in enumerate(row, 1):
            sheet.cell(k, j, value)
    file = io.BytesIO()
    book.save(file)
    return file.getvalue()
