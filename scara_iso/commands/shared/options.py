"""Options: a command takes those of its public function, and how each is typed stands here once.

By `takes_options_of` name, type and default of an option are the function's.
"""

from __future__ import annotations

import inspect
import re
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, StrEnum
from functools import wraps
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Generic, TypeVar, Union, get_args, get_origin

import typer

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.files import read_toml
from scara_iso.base.quantities import is_size, parse_number
from scara_iso.commands.shared.inputs import Reading, ReadingOptions, keywords_in
from scara_iso.commands.shared.output import Answer
from scara_iso.iso9283 import Counting, CountingOptions, DecisionRule

Result = TypeVar("Result")
_FIGURES = {name.lower(): name for name in ("X", "Y", "Z", "theta", "XY", "XYZ", "XY_eq23")}
_SIZE = re.compile(r"([-+0-9.,]*(?:[eE][-+]?[0-9]+)?)\s*(.*)", re.DOTALL)
_DECIMAL_COMMA = re.compile(r"([+-]?[0-9]*),([0-9]+)")
_METAVARS: Mapping[Any, str] = {str: "TEXT", float: "NUMBER", int: "N", Path: "FILE"}
_PLAIN = (bool, int, float, str, Path, Enum)
_THOUSANDS = re.compile(r"[+-]?[1-9][0-9]{0,2},[0-9]{3}")


def parse_limits(texts: Sequence[str]) -> dict[str, float | str]:
    """Return limits by figure, as `parse_sizes`."""
    return parse_sizes(
        "--limit", texts, "write --limit 0.02 (mm) for every length, or --limit XY=20um"
    )


def parse_sizes(option: str, texts: Sequence[str], remedy: str) -> dict[str, float | str]:
    """Return sizes by figure or axis, in any case, as text where they have a unit.

    A decimal comma is read. `UsageError` for one that is no length, can be read two ways, or is
    given twice.
    """
    sizes: dict[str, float | str] = {}
    for text in texts:
        figure, equals, number = (part.strip() for part in text.rpartition("="))
        figure = _FIGURES.get(figure.lower(), figure)
        if equals and not figure:
            raise UsageError(f"{option} {text!r} names no figure", remedy=remedy)
        if figure in sizes:
            raise UsageError(
                f"{option} {text!r}: this figure has a size already", remedy="name each figure once"
            )
        sizes[figure] = _length(f"{option} {text!r}", number, remedy)
    return sizes


def _length(text: str, size: str, remedy: str) -> float | str:
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


def parse_pairs(texts: Sequence[str]) -> dict[str, str]:
    """Return what ``KEY=VALUE`` states; `UsageError` for another form."""
    if wrong := [text for text in texts if "=" not in text]:
        raise UsageError(f"--meta {wrong[0]!r} is not KEY=VALUE", remedy="--meta operator=A.Muster")
    pairs = (text.partition("=") for text in texts)
    return {key.strip(): value.strip() for key, _, value in pairs}


def pairs_in(file: Path | None) -> dict[str, str]:
    """Return what the lines ``key = value`` of a TOML file state; none of no file."""
    found = {} if file is None else read_toml(file)
    if nested := sorted(key for key, value in found.items() if isinstance(value, dict | list)):
        raise DataError(
            f"{', '.join(nested)}: not a single value",
            where=str(file),
            remedy='write lines such as operator = "A. Muster"',
        )
    return {k: str(v).lower() if isinstance(v, bool) else str(v) for k, v in found.items()}


def read_numbers(option: str, text: str, separator: str = ",") -> list[float]:
    """Return the numbers of an option; they may be in per cent."""
    parts = [parse_number(one.strip().removesuffix("%")) for one in text.split(separator)]
    numbers = [one for one in parts if one is not None]
    if len(numbers) < len(parts):
        raise UsageError(
            f"{option} {text!r} is not made of numbers",
            remedy=f"write numbers with {separator!r} between them",
        )
    return numbers


class ExcelName(StrEnum):
    """Language of the Excel that is to open a table."""

    DE = "de"
    EN = "en"


@dataclass(frozen=True, slots=True)
class Typed:
    """How a parameter is typed as an option, or with a ``metavar`` as an argument."""

    text: str
    """Its help."""
    names: tuple[str, ...] = ()
    """Where they are others than the parameter's."""
    kind: Any = None
    """Its type on the command line, where `_kind` of the function's does not say it."""
    read: Callable[[Any], Any] | None = None
    """What makes of what is typed what the function takes, where that is another."""
    how: Mapping[str, Any] = field(default_factory=dict)
    """Bounds, completion and so on, as typer takes them."""
    is_argument: bool = False

    def parameter(self, name: str, kind: Any, default: Any) -> inspect.Parameter:
        """Return the parameter of this name as typer takes it; a flag has no --no."""
        kind = self.kind or _kind(kind, default)
        none_is_typed = default == () or self.read is not None
        if none_is_typed or (default is inspect.Parameter.empty and NoneType in get_args(kind)):
            default = None
        plain = next((one for one in get_args(kind) if one is not NoneType), kind)
        how = {"help": self.text, "metavar": _METAVARS.get(plain), **self.how}
        names = self.names or ((_dashed(name),) if kind is bool else ())
        info = typer.Argument(**how) if self.is_argument else typer.Option(*names, **how)
        return inspect.Parameter(
            name,
            inspect.Parameter.KEYWORD_ONLY,
            default=default,
            annotation=Annotated[kind, info, self],
        )


def option(text: str, *names: str, kind: Any = None, read: Any = None, **how: Any) -> Typed:
    """Return an option with its help."""
    return Typed(text, names, kind, read, how)


def output_file(text: str, kind: Any = Path | None, **how: Any) -> Typed:
    """Return the option of the file or folder to write."""
    return option(text, "-o", "--output", kind=kind, **how)


def argument(text: str, metavar: str, kind: Any = None, **how: Any) -> Typed:
    """Return an argument with its help."""
    return Typed(text, kind=kind, how={"metavar": metavar, **how}, is_argument=True)


SHARED: Mapping[str, Typed] = {
    "table": argument(
        "CSV or .xlsx of readings; - is standard input. Several, or a folder: poses of one test.",
        "TABLE...",
        list[str],
    ),
    "unit": option("Unit of the readings where the table states none."),
    "resolution": option("Resolution of the dial, in the table's unit."),
    "decimal": option("Decimal mark, ',' or '.', where both are possible."),
    "sheet": option("Name of the sheet of a workbook."),
    "columns": option(
        "Names of the columns in order, where no header gives them; - skips one.",
        metavar="X,Y,..",
    ),
    "first_cycle_discarded": option("Cycle 1 was already removed from the table."),
    "cycles": option("Number of cycles, the first included [31].", min=2),
    "all_count": option("All cycles count and none was discarded: the standard's 30."),
    "allow_gaps": option("Accept missing cycles, and use the others."),
    "limits": option(
        "Limit [mm, deg]: 0.02 or 20um for RP of every length, XY=0.02 for one figure "
        "(XY_eq23: the paper's), RD=0.02. Exit code 1 unless it is proven to be kept.",
        "--limit",
        read=parse_limits,
        metavar="[FIGURE=]SIZE",
    ),
    "decision": option(
        "Rule for --limit: interval (the whole 95 % interval decides) or simple (the figure "
        "alone).",
        kind=DecisionRule,
    ),
    "meta_file": option("File of --meta statements, lines key = value.", metavar="FILE.toml"),
    "condition": option("Only this velocity and load of a test folder: v50-l100.", metavar="V-L"),
    "own_effects": option(
        "TOML file of your own effects: name, formula, ranges.",
        "--effects",
        metavar="FILE",
    ),
    "excel_locale": option(
        "Spelling for a German (de: ; and decimal ,) or English (en) Excel.",
        kind=ExcelName | None,
    ),
    "full": option("All figures, findings and notes, not only the answer."),
    "json": option("One JSON object on standard output."),
}
MODEL_FILE = argument("Model file of the robot, .toml.", "MODEL")
READING, COUNTING = (tuple(o.__annotations__) for o in (ReadingOptions, CountingOptions))


@dataclass(frozen=True, slots=True)
class Asked(Generic[Result]):
    """What was asked for on a command line, by the parameters of a public function."""

    function: Callable[..., Result]
    parameters: Mapping[str, inspect.Parameter]
    """As they are typed."""
    typed: Mapping[str, Any]
    """What was typed of each."""

    def __getitem__(self, name: str) -> Any:
        return self.typed[name]

    def options(self, *without: str) -> dict[str, Any]:
        """Return what the function takes of what was typed; what was not is left to it."""
        return {
            name: value if (read := _word(one).read) is None else read(value)
            for name, one in self.parameters.items()
            if (value := self.typed[name]) not in (None, []) and name not in without
        }

    def result(self, **more: Any) -> Result:
        """Return what the function makes of it."""
        return self.function(**self.options() | more)

    @property
    def reading(self) -> Reading:
        """How tables are read."""
        return {name: self.typed[name] for name in READING}

    @property
    def counting(self) -> Counting:
        """Which cycles count."""
        return Counting(**{name: self.typed[name] for name in COUNTING})

    def stated(self, *names: str) -> dict[str, Any]:
        """Return, by their names on the command line, the options that were not left as they are.

        Those of ``names``, else all.
        """
        return {
            _word(one).names[-1].removeprefix("--") if _word(one).names else name: self.typed[name]
            for name, one in self.parameters.items()
            if (not names or name in names) and self.typed[name] != one.default
            if not _word(one).is_argument
        }

    def line(self, *names: str, **more: object) -> str:
        """Return the arguments and the options that are `stated` as they are typed again."""
        given = [
            self.typed[name] for name, one in self.parameters.items() if _word(one).is_argument
        ]
        words = [word for one in given for word in (one if isinstance(one, list) else [one])]
        return command_line(words, self.stated(*names), **more)


def _word(parameter: inspect.Parameter) -> Typed:
    word: Typed = get_args(parameter.annotation)[-1]
    return word


def command_line(words: Sequence[str], options: Mapping[str, object], **more: object) -> str:
    """Return words and options that were given as they are typed; what is None or False was not."""
    given = [
        (name, one)
        for name, value in {**options, **more}.items()
        for one in (value if isinstance(value, list | tuple) else [value])
        if one is not None and one is not False
    ]
    files = (f"./{word}" if word.startswith("-") and word != "-" else word for word in words)
    return " ".join([*map(shlex.quote, files), *(_typed_again(name, one) for name, one in given)])


def _typed_again(name: str, value: object) -> str:
    text = f"{value:.15g}" if isinstance(value, float) else str(value)
    return _dashed(name) if value is True else f"{_dashed(name)} {shlex.quote(text)}"


def _dashed(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def takes_options_of(
    function: Callable[..., Result] | None, *answering: str, **words: Typed
) -> Callable[[Callable[..., Answer | None]], Callable[..., None]]:
    """Return what makes a command take the options of a function, and those of its own.

    A parameter is an option where ``words`` or `SHARED` say how it is typed; else it is for callers
    of the function alone. The command gets what was typed for the function as its first argument.
    With the options ``answering`` (``json``, ``full``) the answer that it returns is given.
    """
    asked = dict(_parameters(function, words)) if function is not None else {}
    shown = {name: SHARED[name].parameter(name, bool, False) for name in answering}

    def decorate(command: Callable[..., Answer | None]) -> Callable[..., None]:
        own = dict(_parameters(command, words))

        @wraps(command)
        def called(**given: Any) -> None:
            plain = {k: v.value if isinstance(v, Enum) else v for k, v in given.items()}
            first = [Asked(function, asked, {k: plain[k] for k in asked})] if function else []
            answer = command(*first, **{name: plain[name] for name in own})
            if answer is not None:
                answer.give(**{name: plain[name] for name in shown})

        given_by = {**asked, **own, **shown}.values()
        every = sorted(given_by, key=lambda one: one.default is not one.empty)
        vars(called)["__signature__"] = inspect.Signature(every)
        return called

    return decorate


def _parameters(
    function: Callable[..., Any], words: Mapping[str, Typed]
) -> Iterator[tuple[str, inspect.Parameter]]:
    typed = {**SHARED, **words}
    for name, one in inspect.signature(function, eval_str=True).parameters.items():
        if one.kind is one.VAR_KEYWORD:
            for key, kind in keywords_in(one).items():
                default = False if kind is bool else None
                yield key, typed[key].parameter(key, kind, default)
        elif name in typed:
            yield name, typed[name].parameter(name, one.annotation, one.default)


def _kind(kind: Any, default: Any) -> Any:
    """Return how a type is typed: once for each key, or as text where it is none of the plain ones.

    Without a default it must be typed.
    """
    kinds = {*(get_args(kind) if get_origin(kind) in (Union, UnionType) else [kind])} - {NoneType}
    if any(get_origin(one) is Mapping for one in kinds):
        return list[str] | None
    plain = all(isinstance(one, type) and issubclass(one, _PLAIN) for one in kinds)
    text = str if default is inspect.Parameter.empty else str | None
    return kind if plain and len(kinds) == 1 else text
