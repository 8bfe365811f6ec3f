"""Options that several commands share, and what their texts mean."""

from __future__ import annotations

import re
from collections.abc import Sequence
from enum import StrEnum
from typing import Annotated

import typer

from scara_iso.errors import UsageError
from scara_iso.iso9283 import DecisionRule

NOT_WITHIN_LIMITS = 1
_LIMIT_REMEDY = "write it in mm: --limit 0.02 for every length, or --limit XY=0.02"

Table = Annotated[
    str,
    typer.Argument(
        metavar="TABLE",
        help="CSV or .xlsx of readings, - is standard input; or a test's folder.",
    ),
]
Tables = Annotated[
    list[str],
    typer.Argument(
        metavar="TABLE...",
        help="CSV or .xlsx of readings; - is standard input. Several, or a folder: a pose each.",
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object on standard output.")]
Full = Annotated[
    bool, typer.Option("--full", help="Every figure, finding and note, not only the answer.")
]
UnitOfTable = Annotated[
    str | None, typer.Option("--unit", help="Unit of the readings where the table states none.")
]
ResolutionOfTable = Annotated[
    float | None, typer.Option("--resolution", help="Resolution of the dial, in that unit.")
]
DecimalMark = Annotated[
    str | None, typer.Option("--decimal", help="',' or '.', where the table can be read two ways.")
]
Sheet = Annotated[str | None, typer.Option("--sheet", help="Sheet of an .xlsx file.")]
ColumnsByPosition = Annotated[
    str | None,
    typer.Option(
        "--columns",
        metavar="X,Y,..",
        help="What each field of a row is, where no header says it; - leaves one out.",
    ),
]
FirstDiscarded = Annotated[
    bool, typer.Option("--first-cycle-discarded", help="The table lacks its first cycle already.")
]
CyclesRun = Annotated[
    int | None, typer.Option("--cycles", help="Cycles run, the first counted, if not 31.", min=2)
]
AllCount = Annotated[
    bool,
    typer.Option("--all-count", help="Every cycle counts, none was discarded: the standard's 30."),
]
AllowGaps = Annotated[
    bool, typer.Option("--allow-gaps", help="Use the rest where cycles are missing.")
]
Limits = Annotated[
    list[str] | None,
    typer.Option(
        metavar="[FIGURE=]MM",
        help="Exit with 1 where RP is not proven to be at most this: 0.02 for every length, "
        "XY=0.02 for one figure, RD=0.02 for a characteristic. May be repeated.",
    ),
]
LimitRule = Annotated[
    DecisionRule,
    typer.Option(
        "--decision",
        help="How --limit decides: interval (all of the 95 % interval inside, or outside), or "
        "simple (RP alone).",
    ),
]
ConditionName = Annotated[
    str | None,
    typer.Option("--condition", metavar="V-L", help="Of a test's folder: v50-l100; else all."),
]
ModelFile = Annotated[str, typer.Argument(metavar="MODEL", help="A model file, .toml.")]


OwnEffectsFile = Annotated[
    str | None,
    typer.Option(
        "--effects", metavar="FILE", help="Effects of your own: name, formula, ranges; a TOML file."
    ),
]


class ExcelName(StrEnum):
    """Language of the Excel that is to open a table."""

    DE = "de"
    EN = "en"


ExcelLocale = Annotated[
    ExcelName | None,
    typer.Option(help="Spell the table for a German or an English Excel: de is ; and decimal ,"),
]


_FIGURES = {name.lower(): name for name in ("X", "Y", "Z", "theta", "XY", "XYZ")}
_DECIMAL_COMMA = re.compile(r"([+-]?[0-9]*),([0-9]+)")
_THOUSANDS = re.compile(r"[+-]?[1-9][0-9]{0,2},[0-9]{3}")


def parse_limits(texts: Sequence[str]) -> dict[str, float]:
    """Return limits by figure, as `parse_sizes`."""
    return parse_sizes("--limit", texts, _LIMIT_REMEDY)


def parse_sizes(option: str, texts: Sequence[str], remedy: str) -> dict[str, float]:
    """Return sizes by figure or axis, in any case; a decimal comma is read.

    `UsageError` for one that is no length, can be read two ways, or is given twice.
    """
    sizes: dict[str, float] = {}
    for text in texts:
        figure, equals, number = (part.strip() for part in text.rpartition("="))
        figure = _FIGURES.get(figure.lower(), figure)
        if equals and not figure:
            raise UsageError(f"{option} {text!r} names no figure", remedy=remedy)
        value = _length(f"{option} {text!r}", number, remedy)
        if figure in sizes:
            raise UsageError(
                f"{option} {text!r}: this figure has one already", remedy="name each figure once"
            )
        sizes[figure] = value
    return sizes


def _length(said: str, number: str, remedy: str) -> float:
    from scara_iso.quantities import parse_number

    if _THOUSANDS.fullmatch(number):
        point, whole = number.replace(",", "."), number.replace(",", "")
        raise UsageError(f"{said} can be read two ways", remedy=f"write {point} or {whole}")
    value = parse_number(_DECIMAL_COMMA.sub(r"\1.\2", number))
    if value is None:
        raise UsageError(f"{said} is not a length", remedy=remedy)
    return value
