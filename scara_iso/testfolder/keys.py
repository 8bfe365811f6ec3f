"""What a key of test.toml has to be, by the type of the field that it is named after."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from datetime import date, datetime
from typing import Annotated, Any, TypeAlias, get_args, get_origin

from scara_iso.base.files import is_number
from scara_iso.base.quantities import is_size
from scara_iso.iso9283 import Limit
from scara_iso.run import AXES

Reader: TypeAlias = Callable[[Any], Any]
"""Returns a value as the field holds it; raises `ValueError` that says what it is not."""

POSE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,20}")
_LONGEST = 1000
_LARGEST = 1e9
_MOST_CYCLES = 10_000


def _checked(
    what: str, is_right: Callable[[Any], bool], read: Reader = lambda value: value
) -> Reader:
    def reader(value: Any) -> Any:
        if not is_right(value):
            raise ValueError(what)
        return read(value)

    return reader


def _number(what: str, is_right: Callable[[float], bool] = lambda _: True) -> Reader:
    return _checked(what, lambda value: is_number(value) and is_right(float(value)), float)


def _several(kind: Reader) -> Reader:
    return _checked(
        "no list", lambda value: isinstance(value, list), lambda value: tuple(map(kind, value))
    )


def _two(kind: Reader, what: str, is_right: Callable[[float, float], bool]) -> Reader:
    read = _checked(what, lambda ends: len(ends) == 2 and is_right(*ends))
    return lambda value: read(_several(kind)(value))


def word_of(*words: str) -> Reader:
    """Return the reader of one of some words."""
    return _checked(f"none of {', '.join(map(repr, words))}", words.__contains__)


def _day(value: object) -> date:
    if isinstance(value, datetime):
        return value.date()
    if isinstance(value, date):
        return value
    with suppress(ValueError):
        if isinstance(value, str):
            return date.fromisoformat(value)
    raise ValueError("not a date such as 2026-05-12")


_finite = _number("no finite number")
_positive = _number("not a number above zero", lambda size: 0 < size < _LARGEST)
_not_negative = _number("not a number of zero or more", lambda size: 0 <= size < _LARGEST)
_least_and_most = _two(
    _not_negative,
    "not a smallest and a largest value, such as [0.20, 0.24]",
    lambda least, most: least < most,
)
_by_axis = _checked(
    "not of axes, such as { X = 0.0 }",
    lambda value: isinstance(value, dict) and not set(value) - set(AXES),
    lambda value: {axis: _finite(one) for axis, one in value.items()},
)
_by_figure = _checked(
    "not by figure, such as { dAP = 0.02 }",
    lambda value: isinstance(value, dict),
    lambda value: {str(figure): limit_of(one) for figure, one in value.items()},
)
_pair = _two(
    _finite, "not pairs of nominal and error, such as [[0, 0], [2, 0.001]]", lambda *_: True
)


def limit_of(value: object) -> Limit:
    """Return a limit: a number or a text with a unit, or the smallest and the largest value."""
    if isinstance(value, str) and is_size(value):
        return value
    limit: Limit = (_least_and_most if isinstance(value, list) else _positive)(value)
    return limit


Positive: TypeAlias = Annotated[float, _positive]
NotNegative: TypeAlias = Annotated[float, _not_negative]
Percent: TypeAlias = Annotated[float, _number("not from 0 to 100", lambda part: 0 <= part <= 100)]
Range: TypeAlias = Annotated[
    tuple[float, ...],
    _two(_finite, "not a lowest and a highest temperature", lambda low, high: low <= high),
]
Points: TypeAlias = Annotated[tuple[tuple[float, float], ...], _several(_pair)]
ByFigure: TypeAlias = Annotated[Mapping[str, Limit], _by_figure]
ByAxis: TypeAlias = Annotated[Mapping[str, float], _by_axis]

_OF_TYPE: Mapping[Any, Reader] = {
    str: _checked(
        "not a line of text",
        lambda text: isinstance(text, str) and len(text) <= _LONGEST and text.isprintable(),
        str.strip,
    ),
    int: _checked(
        f"not a whole number from 2 to {_MOST_CYCLES}",
        lambda count: isinstance(count, int) and 2 <= count <= _MOST_CYCLES,
    ),
    float: _finite,
    date: _day,
}


def reader_of(hint: Any) -> Reader:
    """Return what reads a field of a type: as it is annotated, else a text, a number, a day."""
    types = get_args(hint)
    if get_origin(hint) is Annotated:
        reader: Reader = types[1]
        return reader
    if get_origin(hint) is tuple:
        return _several(reader_of(types[0]))
    return reader_of(types[0]) if types else _OF_TYPE[hint]
