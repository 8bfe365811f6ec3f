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
    zero = np.zeros(len(days))
    if isinstance(one, MeanHistory):
        if one.chart is not None:
            chart, values = one.chart, np.array([test.value for test in one.tests])
            data = ControlPicture(
                days,
                {"mean": values},
                chart.centre,
                chart.low,
                chart.high,
                chart.alarms,
                f"[{one.unit}]",
                events,
            )
            yield Figure(data, "Individuals", "mean of each test, limits of three standard errors")
            moved = np.nan_to_num(chart.moving_range)
            limit = np.full(len(days), chart.range_limit)
            data = ControlPicture(
                days,
                {"moving range": moved},
                zero,
                zero,
                limit,
                chart.alarms,
                f"[{one.unit}]",
                events,
            )
            yield Figure(data, "Moving range", "distance from the test before, and its limit")
        return
    if one.ewma is not None:
        e = one.ewma
        data = ControlPicture(
            days,
            {"EWMA": e.points},
            zero,
            -e.limits,
            e.limits,
            e.alarms,
            "[standard errors]",
            events,
        )
        yield Figure(data, "EWMA", "of ln RP against the tests before; a ring is an alarm")
    if one.cusum is not None:
        c = one.cusum
        limit = np.full(len(days), c.limit)
        data = ControlPicture(
            days,
            {"up": c.up, "down": -c.down},
            zero,
            -limit,
            limit,
            c.alarms,
            "[standard errors]",
            events,
        )
        yield Figure(data, "CUSUM", "of ln RP against the tests before; a ring is an alarm")


def _days(tests: Sequence[TestFigure]) -> FloatArray:
    return np.array([day_of(test.when) for test in tests])


def _events(found: RobotHistory) -> tuple[float, ...]:
    return tuple(day_of(event.when) for event in found.events)
