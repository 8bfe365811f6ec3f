"""The pictures of one robot over months, as data."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from scara_iso.monitoring import MeanHistory, RobotHistory, SpreadHistory, TestFigure, day_of
from scara_iso.reporting.blocks import Figure
from scara_iso.reporting.plotted import ControlPicture, MonthsPicture
from scara_iso.run import FloatArray

_AHEAD = 0.5  # spans of the tests that the picture goes on for


def month_picture(found: RobotHistory, one: SpreadHistory) -> Figure:
    """Return a figure by date, with the trend where there is one."""
    days = _days(one.tests)
    ends = np.array([test.interval or (math.nan, math.nan) for test in one.tests]).T
    fitted, ahead = None, None
    if one.trend is not None:
        fitted = one.trend.level(one.trend.days)
        last, span = one.trend.days[-1], one.trend.days[-1] - one.trend.days[0]
        if one.trend.is_shown:
            later = np.linspace(last, last + _AHEAD * span, 12)
            ahead = (later, one.trend.level(later))
    data = MonthsPicture(
        days,
        np.array([test.value for test in one.tests]),
        ends,
        f"[{one.unit}]",
        fitted,
        ahead,
        one.limit,
        _events(found),
    )
    caption = (
        "each test with its 95 % interval; orange what the trend expects, dotted if it goes on"
    )
    return Figure(data, f"{'RP' if one.quantity == 'RP' else '3 S'} {one.figure}", caption)


def control_pictures(found: RobotHistory, one: SpreadHistory | MeanHistory) -> Iterator[Figure]:
    """Yield the control charts of a figure."""
    days, events = _days(one.tests), _events(found)
    if isinstance(one, MeanHistory):
        yield from _charts_of_mean(one, days, events)
    else:
        yield from _charts_of_spread(one, days, events)


def _charts_of_mean(
    one: MeanHistory, days: FloatArray, events: tuple[float, ...]
) -> Iterator[Figure]:
    if one.chart is None:
        return
    chart, unit, zero = one.chart, f"[{one.unit}]", np.zeros(len(days))
    means = {"mean": np.array([test.value for test in one.tests])}
    data = ControlPicture(
        days, means, chart.centre, chart.low, chart.high, chart.alarms, unit, events
    )
    yield Figure(data, "Individuals", "mean of each test, limits of three standard errors")
    moved = {"moving range": np.nan_to_num(chart.moving_range)}
    limit = np.full(len(days), chart.range_limit)
    data = ControlPicture(days, moved, zero, zero, limit, chart.alarms, unit, events)
    yield Figure(data, "Moving range", "distance from the test before, and its limit")


def _charts_of_spread(
    one: SpreadHistory, days: FloatArray, events: tuple[float, ...]
) -> Iterator[Figure]:
    unit, zero = "[standard errors]", np.zeros(len(days))
    said = "of ln RP against the tests before; a ring is an alarm"
    if (e := one.ewma) is not None:
        points = {"EWMA": e.points}
        data = ControlPicture(days, points, zero, -e.limits, e.limits, e.alarms, unit, events)
        yield Figure(data, "EWMA", said)
    if (c := one.cusum) is not None:
        limit, sums = np.full(len(days), c.limit), {"up": c.up, "down": -c.down}
        data = ControlPicture(days, sums, zero, -limit, limit, c.alarms, unit, events)
        yield Figure(data, "CUSUM", said)


def _days(tests: Sequence[TestFigure]) -> FloatArray:
    return np.array([day_of(test.when) for test in tests])


def _events(found: RobotHistory) -> tuple[float, ...]:
    return tuple(day_of(event.when) for event in found.events)
