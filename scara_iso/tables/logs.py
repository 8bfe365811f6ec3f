"""Logs whose lines name their numbers: ``probe at 97,2 is z=1.320``, ``x: 0.112 y: 0.811``.

A machine that tests its own probe names itself in its log.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

from scara_iso.tables.faults import Faults, quoted
from scara_iso.tables.grid import Line, Row, stripped, text_row
from scara_iso.tables.names import Kind, read_name
from scara_iso.tables.numbers import MINUS

_WHEN = (
    r"[0-9]{1,4}[-./][0-9]{1,2}[-./][0-9]{1,4}|[0-9]{1,2}:[0-9]{2}(?::[0-9]{2}(?:[.,][0-9]{1,9})?)?"
)
_NUMBER = r"[+-]?[0-9]{1,20}(?:[.,][0-9]{1,20})?"
_PAIR = (
    r"(?<!\w)([^\W\d_]{1,12}) ?[:=] {0,4}"
    r"([^\s;)\]:=]{1,40}(?: (?:mm|[uµμ]m|inch|deg)(?!\w))?)(?=[\s;)\],]|$)"
)
_COUNTED = r"(?<!\w)([^\W\d_]{1,12}) {1,4}([0-9]{1,9})(?![\w.,])"
_BEGINS = rf"\d|[-+.,{MINUS}]"
_WORD = r"[^\W\d_]+"
_LOOSE = " \t,;:=()[]/@#+-"
_COUNTS = (Kind.CYCLE, Kind.POSE)
_LONGEST = 1000
_EPOCH = 1e8
"""Seconds since 1970, and finer counts of them, are above this."""
_SHOWN = 20
_MM = "mm"
"""Unit of every length in the log of a machine."""
_REMEDY = "leave the lines of one test in the file, one line for each reading"


Log = tuple[list[Row], list[Line], str | None, list[str]]
"""The lines above the readings and a header of their names; the readings; unit; and notes.

The header stands at the line of the first reading, and ends in front of it; the notes say what is
below it and not used.
"""


class _Reading(NamedTuple):
    """A line: its text with # for numbers, the names and numbers of it, the numbers without one."""

    line: int
    shape: str
    names: tuple[str, ...]
    numbers: tuple[str, ...]
    others: tuple[str, ...]


def find_log(lines: Sequence[str], where: str) -> Log | None:
    """Return the readings of a log, None where fewer than two lines alike name an axis.

    Raises `DataError` for a log of two kinds of readings, of several places, or of two tests.
    """
    found = [one for k, text in enumerate(lines, 1) if (one := _read(k, text)) is not None]
    shapes: dict[str, list[_Reading]] = {}
    for one in found:
        shapes.setdefault(one.shape, []).append(one)
    several = [group for group in shapes.values() if len(group) > 1]
    if not several:
        return None
    rows, *more = several
    faults = Faults(where)
    for other in more:
        text = quoted(lines[other[0].line - 1])
        faults.add(f"{text} names an axis too", other[0].line, remedy=_REMEDY)
    words = {*re.findall(_WORD, rows[0].shape)}
    for one in found:
        if one.shape != rows[0].shape and words.issuperset(re.findall(_WORD, one.shape)):
            faults.add("names an axis, and is not as the other lines", one.line, remedy=_REMEDY)
    _check_between(rows, lines, faults)
    _check_others(rows, faults)
    faults.check()
    return _log(rows, lines)


def _log(rows: Sequence[_Reading], lines: Sequence[str]) -> Log:
    first, notes, own = rows[0].line, list[str](), 0
    head = [text_row(k, [text]) for k, text in enumerate(lines[: first - 1], 1)]
    named = [k for k, (itself, _) in _MACHINES.items() if any(re.search(itself, x) for x in lines)]
    machine = named[0] if len(named) == 1 else None
    if machine:
        itself, deviation = _MACHINES[machine]
        head = [one for one in head if not re.search(itself, lines[one.line - 1])]
        notes.append(f"a log of {machine}: lengths in {_MM}")
        found = ((re.search(deviation, line), k) for k, line in enumerate(lines, 1))
        stated, own = next((one for one in found if one[0]), (None, 0))
        if stated:
            notes.append(
                f"line {own}: its standard deviation {stated[1]} {_MM} divides by n, not by "
                "n - 1, and is not taken"
            )
    used = {own, *(one.line for one in rows)}
    left = (k for k in range(first, len(lines) + 1) if k not in used and lines[k - 1].strip())
    notes += [f"line {k}: {quoted(lines[k - 1])} not used" for k in left][:_SHOWN]
    head.append(replace(text_row(first, rows[0].names), end=first - 1))
    readings: list[Line] = [(one.line, list(one.numbers)) for one in rows]
    return head, readings, _MM if machine else None, notes


def _read(line: int, text: str) -> _Reading | None:
    if len(text) > _LONGEST or not ("=" in text or ":" in text):
        return None
    text = re.sub(_WHEN, "@", stripped(text))
    if not any(_kind(pair[1]) is Kind.AXIS for pair in re.finditer(_PAIR, text)):
        return None
    pairs: list[tuple[str, str]] = []

    def take(match: re.Match[str]) -> str:
        kind = _kind(match[1])
        counted = match.re.pattern == _COUNTED
        if (
            kind not in _COUNTS
            if counted
            else kind is not Kind.AXIS and not re.match(_BEGINS, match[2])
        ):
            return match[0]
        pairs.append((match[1], match[2].rstrip(",")))
        return f"{match[1]}= "

    rest = re.sub(_COUNTED, take, re.sub(_PAIR, take, text))
    names, numbers = zip(*pairs, strict=True)
    others = tuple(
        rest[max(0, m.start() - 1) : m.start()].strip(_LOOSE) + m[0]
        for m in re.finditer(_NUMBER, rest)
    )
    shape = "".join(re.sub(_NUMBER, "0", rest).split())
    return _Reading(line, shape, names, numbers, others)


@lru_cache(maxsize=1024)
def _kind(name: str) -> Kind:
    return read_name(name).kind


def _check_between(rows: Sequence[_Reading], lines: Sequence[str], faults: Faults) -> None:
    """Refuse numbers between the readings: another test may begin there."""
    for one, following in pairwise(rows):
        between = range(one.line, following.line - 1)
        for k in [k for k in between if re.search(_NUMBER, re.sub(_WHEN, "@", lines[k]))][:1]:
            what = f"{quoted(lines[k])} between readings: does another test begin?"
            faults.add(what, k + 1, remedy=_REMEDY)


def _check_others(rows: Sequence[_Reading], faults: Faults) -> None:
    """Refuse numbers without a name that change as no count and no clock does: places, poses."""
    for texts in zip(*(one.others for one in rows), strict=True):
        whole = all(text.isdecimal() for text in texts)
        counts = whole and all(int(b) == int(a) + 1 for a, b in pairwise(texts))
        clock = all(x[0].isdecimal() and float(x.replace(",", ".")) > _EPOCH for x in texts)
        if len(set(texts)) == 1 or counts or clock:
            continue
        k = next(k for k, text in enumerate(texts) if text != texts[0])
        what = f"{texts[k]} where line {rows[0].line} has {texts[0]}: another place or pose?"
        faults.add(what, rows[k].line, remedy="leave the lines of one place in the file")


# Klipper's docs/G-Codes.md, [probe]; Marlin's gcode/calibrate/M48. Both divide by n.
_MACHINES = {
    "Klipper PROBE_ACCURACY": (
        r"PROBE_ACCURACY at X:[-0-9.]+ Y:[-0-9.]+ Z:[-0-9.]+",
        r"probe accuracy results:.*standard deviation ([0-9.]{1,20})\s*$",
    ),
    "Marlin M48": (
        r"M48 Z-Probe Repeatability Test",
        r"Standard Deviation: ([0-9.]{1,20})\s*$",
    ),
}
"""How a machine names itself, and how it states its standard deviation."""
