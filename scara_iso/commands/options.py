"""Options that several commands share, and what their texts mean."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Sequence
from enum import StrEnum
from functools import wraps
from typing import Annotated, Any

import typer

from scara_iso.base.errors import UsageError
from scara_iso.commands.inputs import TableOptions
from scara_iso.iso9283 import Counting, DecisionRule

_LIMIT_REMEDY = "write --limit 0.02 (mm) for every length, or --limit XY=20um"
Table = Annotated[
    str,
    typer.Argument(
        metavar="TABLE",
        help="CSV or .xlsx of readings, - is standard input; or a test's folder.",
    ),
]
TableNames = Annotated[
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
Limits = Annotated[
    list[str] | None,
    typer.Option(
        metavar="[FIGURE=]SIZE",
        help="Exit with 1 where RP is not proven to be at most this [mm, deg]: 20um for every "
        "length, XY=0.02 for one figure (XY_eq23: the paper's), RD=0.02.",
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


def _reading(
    *,
    unit: UnitOfTable = None,
    resolution: ResolutionOfTable = None,
    decimal: DecimalMark = None,
    sheet: Annotated[str | None, typer.Option(help="Sheet of an .xlsx file.")] = None,
    columns: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,..",
            help="What each field of a row is, where no header says it; - leaves one out.",
        ),
    ] = None,
) -> TableOptions:
    return TableOptions(unit, resolution, decimal, sheet, columns)


def _counting(
    *,
    first_cycle_discarded: Annotated[
        bool,
        typer.Option("--first-cycle-discarded", help="The table lacks its first cycle already."),
    ] = False,
    cycles: Annotated[
        int | None, typer.Option(help="Cycles run, the first counted, if not 31.", min=2)
    ] = None,
    all_count: Annotated[
        bool,
        typer.Option(
            "--all-count", help="Every cycle counts, none was discarded: the standard's 30."
        ),
    ] = False,
    allow_gaps: Annotated[
        bool, typer.Option("--allow-gaps", help="Use the rest where cycles are missing.")
    ] = False,
) -> Counting:
    return Counting(first_cycle_discarded, cycles, all_count, allow_gaps)


_SHARED: dict[str, Callable[..., Any]] = {"reading": _reading, "counting": _counting}


def takes_tables(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command whose parameters ``reading`` and ``counting`` are options of their own."""
    own = inspect.signature(command, eval_str=True).parameters
    shared = {
        name: inspect.signature(_SHARED[name], eval_str=True).parameters
        for name in own
        if name in _SHARED
    }

    @wraps(command)
    def called(**given: Any) -> None:
        for name, options in shared.items():
            given[name] = _SHARED[name](**{option: given.pop(option) for option in options})
        command(**given)

    spread = [
        option for name, one in own.items() for option in shared.get(name, {name: one}).values()
    ]
    vars(called)["__signature__"] = inspect.Signature(spread)
    return called


class ExcelName(StrEnum):
    """Language of the Excel that is to open a table."""

    DE = "de"
    EN = "en"


ExcelLocale = Annotated[
    ExcelName | None,
    typer.Option(help="Spell the table for a German or an English Excel: de is ; and decimal ,"),
]
_FIGURES = {name.lower(): name for name in ("X", "Y", "Z", "theta", "XY", "XYZ", "XY_eq23")}
_SIZE = re.compile(r"([-+0-9.,]*(?:[eE][-+]?[0-9]+)?)\s*(.*)", re.DOTALL)
_DECIMAL_COMMA = re.compile(r"([+-]?[0-9]*),([0-9]+)")
_THOUSANDS = re.compile(r"[+-]?[1-9][0-9]{0,2},[0-9]{3}")


def parse_limits(texts: Sequence[str]) -> dict[str, float | str]:
    """Return limits by figure, as `parse_sizes`."""
    return parse_sizes("--limit", texts, _LIMIT_REMEDY)


def parse_sizes(option: str, texts: Sequence[str], remedy: str) -> dict[str, float | str]:
    """Return sizes by figure or axis, in any case, as text where they have a unit.

    A decimal comma is read.

    `UsageError` for one that is no length, can be read two ways, or is given twice.
    """
    sizes: dict[str, float | str] = {}
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


def _length(text: str, size: str, remedy: str) -> float | str:
    from scara_iso.base.quantities import is_size, parse_number

    number, unit = _SIZE.fullmatch(size).groups()  # type: ignore[union-attr]  # it takes any text
    if _THOUSANDS.fullmatch(number):
        point, whole = number.replace(",", "."), number.replace(",", "")
        raise UsageError(
            f"{text} can be read two ways", remedy=f"write {point}{unit} or {whole}{unit}"
        )
    plain = _DECIMAL_COMMA.sub(r"\1.\2", number)
    value = parse_number(plain)
    if value is None or (unit and not is_size(plain + unit)):
        raise UsageError(f"{text} is not a length", remedy=remedy)
    return plain + unit if unit else value
