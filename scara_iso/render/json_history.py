"""The JSON object of ``history``."""

from __future__ import annotations

import math
from collections.abc import Iterable

from scara_iso.comparison import published_comparison
from scara_iso.monitoring import (
    LimitCrossing,
    MeanHistory,
    RobotHistory,
    ServiceChange,
    SpreadHistory,
    TestFigure,
    Trend,
    date_on,
    moment_said,
)
from scara_iso.published import Json, to_json
from scara_iso.render.json import picked


def history_json(found: RobotHistory) -> Json:
    """Return the JSON object of ``history``, schema ``scara-iso/history/1``."""
    return {
        "schema": "scara-iso/history/1",
        "unit": "mm",
        **picked(found, "robot serial notes"),
        "tests": [
            {
                "date": moment_said(test.when),
                "source": test.source,
                "cycles": test.analysis.cycles.used,
            }
            for test in found.tests
        ],
        "unreadable": [{"source": name, "error": why} for name, why in found.unreadable],
        "events": [{"date": moment_said(event.when), "what": event.what} for event in found.events],
        "figures": [_spread(one) for one in found.spreads],
        "means": [_mean(one) for one in found.means],
        "changes": [_change(one) for one in found.changes],
        "crossed": [picked(one, "pose figure limit") for one in found.crossed],
    }


def _spread(one: SpreadHistory) -> Json:
    dates = [moment_said(test.when) for test in one.tests]
    return {
        **picked(one, "pose figure quantity unit sampling sigma"),
        "tests": [_test(test) for test in one.tests],
        "standardised": one.standardised.tolist(),
        "ewma": None
        if one.ewma is None
        else {**picked(one.ewma, "points limits"), "alarms": _at(dates, one.ewma.alarms)},
        "cusum": None
        if one.cusum is None
        else {**picked(one.cusum, "up down limit"), "alarms": _at(dates, one.cusum.alarms)},
        "since_service": dates[one.since_service],
        "trend": None if one.trend is None else _trend(one.trend),
        "limit": None
        if one.limit is None
        else {"limit": one.limit, "crossed": one.crossed, **_crossing(one.crossing)},
    }


def _trend(trend: Trend) -> Json:
    return {
        **picked(trend, "per_month interval shown=is_shown"),
        "onset": [date_on(day) for day in trend.onset],
        "level": trend.level(trend.days).tolist(),
    }


def _crossing(found: LimitCrossing | None) -> Json:
    names = ("earliest", "likely", "latest", "horizon")
    days = {name: None if found is None else getattr(found, name) for name in names}
    return {name: None if day is None else date_on(day) for name, day in days.items()}


def _mean(one: MeanHistory) -> Json:
    dates = [moment_said(test.when) for test in one.tests]
    chart = one.chart
    return {
        **picked(one, "pose figure unit"),
        "tests": [_test(test) for test in one.tests],
        "chart": None
        if chart is None
        else {
            **picked(chart, "centre low high range_limit sigma"),
            "moving_range": [None if math.isnan(m) else m for m in chart.moving_range.tolist()],
            "alarms": _at(dates, chart.alarms),
        },
    }


def _test(test: TestFigure) -> Json:
    return {"date": moment_said(test.when), **picked(test, "source n value interval error verdict")}


def _change(change: ServiceChange) -> Json:
    event = {"date": moment_said(change.event.when), "what": change.event.what}
    return {"event": event, "comparison": to_json(published_comparison(change.comparison))}


def _at(dates: list[str], alarms: Iterable[int]) -> list[str]:
    return [dates[k] for k in alarms]
