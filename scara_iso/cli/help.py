"""The help of a command: its options in groups, in words that are no programmer's."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from typer.core import TyperCommand

_OWN = "Options"
_TABLE = "How a table is read"
_CYCLES = "Which cycles count"
_ANSWER = "What is shown and written"
_GROUPS = {
    _TABLE: ("unit", "resolution", "decimal", "sheet", "columns"),
    _CYCLES: ("first_cycle_discarded", "cycles", "all_count", "allow_gaps"),
    _ANSWER: ("output", "plot", "picture", "map_", "excel_locale", "full", "json", "help"),
}
_FEWEST = 8
"""Options of which fewer are one list."""
_KINDS = {"<str>": "TEXT", "<float>": "NUMBER", "<int range>": "N", "<int>": "N", "<path>": "FILE"}
_COMPLAINTS = {
    "is not a valid float.": "is not a number: digits and a decimal point, such as 0.5",
    "is not a valid int range.": "is not a whole number",
    "is not a valid int.": "is not a whole number",
}


class Command(TyperCommand):
    """A command whose help has the options by what they are for."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments and the groups of options that this command has."""
        shown: dict[str, list[tuple[str, str]]] = {"Arguments": [], _OWN: []}
        params = self.get_params(ctx)
        grouped = sum(param.param_type_name == "option" for param in params) >= _FEWEST
        for param in params:
            record = param.get_help_record(ctx)
            if record is not None:
                group = _group(param.name) if grouped else _OWN
                place = "Arguments" if param.param_type_name == "argument" else group
                shown.setdefault(place, []).append((_plain(record[0]), record[1]))
        for title in ("Arguments", _OWN, *_GROUPS):
            if shown.get(title):
                with formatter.section(title):
                    formatter.write_dl(shown[title])


def asks_for_help(arguments: Sequence[str]) -> list[str]:
    """Return the arguments, ``help COMMAND`` as ``COMMAND --help``."""
    words = list(arguments)
    at = next((k for k, word in enumerate(words) if not word.startswith("-")), None)
    if at is None or words[at] != "help":
        return words
    return [*words[:at], *words[at + 1 :], "--help"]


def in_plain_words(message: str) -> str:
    """Return what the parser complains of without its names of types."""
    for said, plain in _COMPLAINTS.items():
        message = message.replace(said, plain)
    return message


def _group(name: str | None) -> str:
    return next((title for title, names in _GROUPS.items() if name in names), _OWN)


def _plain(option: str) -> str:
    for kind, said in _KINDS.items():
        option = option.replace(kind, said)
    return option
