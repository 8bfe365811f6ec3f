"""What each key of a test.toml has to be, and how it is read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import date, datetime
from typing import Any

from scara_iso.acceptance.whole_test import BOTH_SIDES, COUNTS, DISCARDED, ONE_SIDE
from scara_iso.iso9283 import Limit
from scara_iso.run import AXES
from scara_iso.toml_keys import is_number

_LONGEST = 1000
_LARGEST = 1e9
_MOST_CYCLES = 10_000


def _text(value: object) -> str:
    if not isinstance(value, str) or len(value) > _LONGEST or not value.isprintable():
        raise ValueError("not a line of text")
    return value.strip()


def _number(value: object) -> float:
    if not is_number(value):
        raise ValueError("no finite number")
    return float(value)  # type: ignore[arg-type]


def _positive(value: object) -> float:
    if not is_number(value) or not 0 < float(value) < _LARGEST:  # type: ignore[arg-type]
        raise ValueError("not a number above zero")
    return float(value)  # type: ignore[arg-type]


def _not_negative(value: object) -> float:
    if not is_number(value) or not 0 <= float(value) < _LARGEST:  # type: ignore[arg-type]
        raise ValueError("not a number of zero or more")
    return float(value)  # type: ignore[arg-type]


def _whole(value: object) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 2 <= value <= _MOST_CYCLES:
        raise ValueError(f"not a whole number from 2 to {_MOST_CYCLES}")
    return value


def _several(kind: Callable[[object], Any]) -> Callable[[object], tuple[Any, ...]]:
    def read(value: object) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise ValueError("no list")
        return tuple(kind(one) for one in value)

    return read


def _percent(value: object) -> float:
    if not is_number(value) or not 0 <= float(value) <= 100:  # type: ignore[arg-type]
        raise ValueError("not from 0 to 100")
    return float(value)  # type: ignore[arg-type]


def _limits_of_temperature(value: object) -> tuple[float, ...]:
    ends = _several(_number)(value)
    if len(ends) != 2 or ends[0] > ends[1]:
        raise ValueError("not a lowest and a highest temperature")
    return ends


def _one_of(*words: str) -> Callable[[object], str]:
    def read(value: object) -> str:
        if value not in words:
            raise ValueError(f"none of {', '.join(map(repr, words))}")
        return str(value)

    return read


def _day(value: object) -> date:
    if isinstance(value, str):
        try:
            value = date.fromisoformat(value)
        except ValueError:
            raise ValueError("not a date such as 2026-05-12") from None
    if isinstance(value, datetime):
        return value.date()
    if not isinstance(value, date):
        raise ValueError("not a date such as 2026-05-12")
    return value


def _points(value: object) -> tuple[tuple[float, ...], ...]:
    pairs = _several(_several(_number))(value)
    if any(len(pair) != 2 for pair in pairs):
        raise ValueError("not pairs of nominal and error, such as [[0, 0], [2, 0.001]]")
    return pairs


def _by_figure(value: object) -> dict[str, Limit]:
    if not isinstance(value, dict):
        raise ValueError("not by figure, such as { dAP = 0.02 }")
    return {str(figure): _limit(one) for figure, one in value.items()}


def _limit(value: object) -> Limit:
    if not isinstance(value, list):
        return _positive(value)
    ends = _several(_not_negative)(value)
    if len(ends) != 2 or ends[0] >= ends[1]:
        raise ValueError("not a smallest and a largest value, such as [0.20, 0.24]")
    return ends


def _by_axis(value: object) -> dict[str, float]:
    if not isinstance(value, dict) or set(value) - set(AXES):
        raise ValueError("not of axes, such as { X = 0.0 }")
    return {axis: _number(one) for axis, one in value.items()}


KINDS: Mapping[str, Callable[[Any], Any]] = {
    **dict.fromkeys(
        (
            "name",
            "serial_number",
            "model",
            "solid",
            "plane",
            "elbow",
            "certificate",
            "operator",
            "laboratory",
            "address",
            "location",
            "customer",
            "authorized_by",
            "report_number",
            "recording",
            "reason",
            "pose",
        ),
        _text,
    ),
    **dict.fromkeys(
        (
            "rated_payload_kg",
            "rated_velocity_mm_s",
            "uncertainty",
            "arm_m",
            "correction_uncertainty",
            "alignment_u_deg",
        ),
        _positive,
    ),
    **dict.fromkeys(
        ("dwell_s", "stabilisation_time_s", "warm_up_min", "alignment_deg"), _not_negative
    ),
    **dict.fromkeys(
        ("x_mm", "y_mm", "z_mm", "theta_deg", "temperature_C", "correction_zero"), _number
    ),
    **dict.fromkeys(("calibration_date", "calibration_due", "date"), _day),
    "size_mm": _several(_positive),
    "characteristics": _several(_text),
    "velocities": _several(_percent),
    "loads": _several(_percent),
    **dict.fromkeys(("humidity_percent", "velocity", "load"), _percent),
    **dict.fromkeys(("cycles", "blocks", "visits"), _whole),
    "limits": _by_figure,
    "correction": _points,
    "first_cycle": _one_of(DISCARDED, COUNTS),
    "approach": _one_of(ONE_SIDE, BOTH_SIDES),
    "dial_zero": _one_of("command"),
    "temperature_limits_C": _limits_of_temperature,
    "command": _by_axis,
}
"""What each key has to be, in whichever section."""
