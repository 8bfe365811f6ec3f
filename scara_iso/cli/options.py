"""Options that several commands share, and what their texts mean."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import Annotated

import typer

from scara_iso.errors import UsageError
from scara_iso.verdict import Decision

NOT_WITHIN_LIMITS = 1

Table = Annotated[
    str, typer.Argument(metavar="TABLE", help="CSV or .xlsx of readings; - is standard input.")
]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object on standard output.")]
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
FirstDiscarded = Annotated[
    bool, typer.Option("--first-cycle-discarded", help="The table lacks its first cycle already.")
]
CyclesRun = Annotated[
    int | None, typer.Option("--cycles", help="Cycles run, the first counted, if not 31.", min=2)
]
Limits = Annotated[
    list[str] | None,
    typer.Option(
        metavar="[FIGURE=]MM",
        help="Exit with 1 where RP is not proven to be at most this: 0.02 for every length, "
        "XY=0.02 for one figure. May be repeated.",
    ),
]
LimitRule = Annotated[
    Decision,
    typer.Option(
        "--decision",
        help="How --limit decides: interval (all of the 95 % interval inside, or outside), or "
        "simple (RP alone).",
    ),
]
ModelFile = Annotated[str, typer.Argument(metavar="MODEL", help="A model file, .toml.")]


class ExcelName(StrEnum):
    """Language of the Excel that is to open a table."""

    DE = "de"
    EN = "en"


ExcelLocale = Annotated[
    ExcelName | None,
    typer.Option(help="Spell the table for a German or an English Excel: de is ; and decimal ,"),
]


def parse_limits(texts: Sequence[str]) -> dict[str, float]:
    """Return limits by figure; `UsageError` for one that is no length or is given twice."""
    from scara_iso.quantities import parse_number

    limits: dict[str, float] = {}
    for text in texts:
        figure, _, number = text.rpartition("=")
        value = parse_number(number)
        if value is None:
            remedy = "write --limit 0.02 or --limit XY=0.02"
            raise UsageError(f"--limit {text!r} is not a length", remedy=remedy)
        if figure.strip() in limits:
            raise UsageError(f"--limit {text!r}: this figure has a limit already")
        limits[figure.strip()] = value
    return limits
