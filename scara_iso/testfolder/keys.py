"""What a key of test.toml has to be, by the type of the field that it is named after."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from datetime import date, datetime
from typing import Annotated, Any, TypeAlias, get_args, get_origin

from scara_iso.base.quantities import is_size
from scara_iso.base.toml_keys import is_number
from scara_iso.iso9283 import Limit
from scara_iso.run import AXES

Reader: TypeAlias = Callable[[Any], Any]
"""Returns a value as the field holds it; raises `ValueError` that says what it is not."""

POSE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,20}")
_LONGEST = 1000
_LARGEST = 1e9
_MOST_CYCLES = 10_000


def _text(value: object) -> str:
    if not isinstance(value, str) or len(value) > _LONGEST or not value.isprintable():
        raise ValueError("not a line of text")
    return value.strip()


def _whole(value: object) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 2 <= value <= _MOST_CYCLES:
        raise ValueError(f"not a whole number from 2 to {_MOST_CYCLES}")
    return value


def _day(value: object) -> date:
    if isinstance(value, str):
        try:
            return date.fromisoformat(value)
        except ValueError:
            raise ValueError("not a date such as 2026-05-12") from None
    if isinstance(value, datetime):
        return value.date()
    if not isinstance(value, date):
        raise ValueError("not a date such as 2026-05-12")
    return value


def _float(what: str, is_right: Callable[[float], bool] = lambda _: True) -> Reader:
    def read(value: Any) -> float:
        if not is_number(value) or not is_right(float(value)):
            raise ValueError(what)
        return float(value)

    return read


def _several(kind: Reader) -> Reader:
    def read(value: object) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise ValueError("no list")
        return tuple(kind(one) for one in value)

    return read


def _two(kind: Reader, what: str, is_right: Callable[[float, float], bool]) -> Reader:
    def read(value: object) -> tuple[float, ...]:
        ends: tuple[float, ...] = _several(kind)(value)
        if len(ends) != 2 or not is_right(*ends):
            raise ValueError(what)
        return ends

    return read


def word_of(*words: str) -> Reader:
    """Return the reader of one of some words."""

    def read(value: object) -> str:
        if value not in words:
            raise ValueError(f"none of {', '.join(map(repr, words))}")
        return str(value)

    return read


_number = _float("no finite number")
_positive = _float("not a number above zero", lambda size: 0 < size < _LARGEST)
_not_negative = _float("not a number of zero or more", lambda size: 0 <= size < _LARGEST)
_least_and_most = _two(
    _not_negative,
    "not a smallest and a largest value, such as [0.20, 0.24]",
    lambda least, most: least < most,
)


def limit_of(value: object) -> Limit:
    """Return a limit: a number or a text with a unit, or the smallest and the largest value."""
    if isinstance(value, list):
        ends: tuple[float, float] = _least_and_most(value)
        return ends
    size: Limit = value if isinstance(value, str) and is_size(value) else _positive(value)
    return size


def _by_figure(value: object) -> dict[str, Limit]:
    if not isinstance(value, dict):
        raise ValueError("not by figure, such as { dAP = 0.02 }")
    return {str(figure): limit_of(one) for figure, one in value.items()}


def _by_axis(value: object) -> dict[str, float]:
    if not isinstance(value, dict) or set(value) - set(AXES):
        raise ValueError("not of axes, such as { X = 0.0 }")
    return {axis: _number(one) for axis, one in value.items()}


def _points(value: object) -> tuple[tuple[float, ...], ...]:
    pairs: tuple[tuple[float, ...], ...] = _several(_several(_number))(value)
    if any(len(pair) != 2 for pair in pairs):
        raise ValueError("not pairs of nominal and error, such as [[0, 0], [2, 0.001]]")
    return pairs


Positive: TypeAlias = Annotated[float, _positive]
NotNegative: TypeAlias = Annotated[float, _not_negative]
Percent: TypeAlias = Annotated[float, _float("not from 0 to 100", lambda share: 0 <= share <= 100)]
Range: TypeAlias = Annotated[
    tuple[float, ...],
    _two(_number, "not a lowest and a highest temperature", lambda low, high: low <= high),
]
Points: TypeAlias = Annotated[tuple[tuple[float, float], ...], _points]
ByFigure: TypeAlias = Annotated[Mapping[str, Limit], _by_figure]
ByAxis: TypeAlias = Annotated[Mapping[str, float], _by_axis]

_OF_TYPE: Mapping[Any, Reader] = {str: _text, int: _whole, float: _number, date: _day}


def reader_of(hint: Any) -> Reader:
    """Return what reads a field of a type: as it is annotated, else a text, a number, a day."""
    types = get_args(hint)
    if get_origin(hint) is Annotated:
        reader: Reader = types[1]
        return reader
    if get_origin(hint) is tuple:
        return _several(reader_of(types[0]))
    return reader_of(types[0]) if types else _OF_TYPE[hint]
