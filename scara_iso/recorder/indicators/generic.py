"""Any other instrument that sends lines: the user's pattern says what a reading looks like."""

from __future__ import annotations

import re
from collections.abc import Callable

from scara_iso.base.errors import UsageError
from scara_iso.base.quantities import find_unit
from scara_iso.recorder.indicators._dialect import Dialect, Event, LineSettings, Reading
from scara_iso.recorder.indicators._grammar import decimal_text

PATTERN = r"(?P<value>[+-]\d{3}\.\d{3}) (?P<unit>mm|in)"
"""The pattern when the user gives none, and an example of a good one: sign, width and unit."""

_LONGEST = 64
_TERMINATOR = b"\r\n"
_VALUE = re.compile(rb"([+-]?) *(\d+\.?\d*|\.\d+)")
_ATOM = re.compile(r"\\.|\[\^?\]?[^\]]*\]")
_REPEATED_GROUP = re.compile(r"\)[*+{]")


def make_generic(pattern: str) -> Dialect:
    """Return the dialect of lines that ``pattern`` matches as a whole.

    ``pattern`` is a regular expression (ASCII) with the named group ``value`` and, if the lines
    state it, ``unit``. Anything else is garbage. Raises `UsageError` for a pattern that does not
    compile, has no ``value``, or repeats a group: a repeated group can take for ever on one line.
    """
    compiled = _compile(pattern)
    parse = _parser(compiled)
    return Dialect(
        key="generic",
        instruments="any instrument that sends lines, with a pattern given by the user",
        cable="any",
        line=LineSettings(),
        parse=parse,
        compose=_composer(parse),
        terminator=_TERMINATOR,
        longest_frame=_LONGEST,
        fixed_decimals=False,
        digits=6,
        decimals=(3,),
        units=("mm", "inch") if "unit" in compiled.groupindex else (None,),
        source=f"pattern {pattern}",
        confidence="low",
        unverified=("everything: the user states it",),
    )


def _compile(pattern: str) -> re.Pattern[bytes]:
    remedy = f"such as {PATTERN}"
    try:
        compiled = re.compile(pattern.encode("ascii"))
    except (re.error, UnicodeEncodeError, OverflowError, RecursionError) as error:
        raise UsageError(f"pattern {pattern!r}: {error}", remedy=remedy) from error
    if "value" not in compiled.groupindex:
        raise UsageError(f"pattern {pattern!r} has no group named 'value'", remedy=remedy)
    if _REPEATED_GROUP.search(_ATOM.sub("x", pattern)):
        raise UsageError(f"pattern {pattern!r} repeats a group", remedy=f"write it out, {remedy}")
    return compiled


def _parser(pattern: re.Pattern[bytes]) -> Callable[[bytes], tuple[Event, ...]]:
    has_unit = "unit" in pattern.groupindex

    def parse(line: bytes) -> tuple[Event, ...]:
        found = pattern.fullmatch(line)
        value = _VALUE.fullmatch((found["value"] or b"").strip(b" ")) if found else None
        if found is None or value is None:
            return ()
        spelt = found["unit"] if has_unit else None
        unit = find_unit(spelt.decode("ascii", "replace")) if spelt else None
        if spelt and unit is None:
            return ()
        name = unit.name if unit else None
        return (Reading(decimal_text(value[1], value[2]), name, None, None, line),)

    return parse


def _composer(
    parse: Callable[[bytes], tuple[Event, ...]],
) -> Callable[[str, str | None, str | None], bytes]:
    """Return a composer that tries the usual forms of a line until one is parsed back."""

    def compose(text: str, unit: str | None, _channel: str | None) -> bytes:
        sign, number = ("-", text[1:]) if text.startswith("-") else ("+", text)
        for shown in (f"{sign}{number.zfill(7)}", f"{sign}{number}", text, f"{text}000"):
            for name in (unit, "in") if unit == "inch" else (unit,):
                for line in (f"{shown} {name}", f"{shown}{name}") if name else (shown,):
                    match parse(line.encode("utf-8")):
                        case (Reading(text=read, unit=stated),) if (read, stated) == (text, unit):
                            return line.encode("ascii") + _TERMINATOR
        raise UsageError(f"no usual form of {text} {unit or ''} fits the pattern of this dialect")

    return compose


DIALECT = make_generic(PATTERN)
