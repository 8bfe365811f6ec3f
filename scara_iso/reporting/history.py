"""The page of one robot over months: what changed first, then every figure with its charts.

The pictures of one robot over months, as data.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import PurePath

import numpy as np

from scara_iso.comparison import (
    ContrastVerdict,
    MeanHistory,
    RobotHistory,
    ServiceEvent,
    SpreadContrast,
    SpreadHistory,
    TestFigure,
    date_on,
    day_of,
    moment_said,
)
from scara_iso.reporting.blocks import (
    Block,
    Document,
    Figure,
    Headline,
    NextStep,
    Number,
    Report,
    Result,
    Section,
    Table,
    Text,
    Tone,
    answer_lines,
    at_depth,
    interval,
    rounded,
)
from scara_iso.reporting.comparison import CHANGED, headline, is_live, ratio_in_words
from scara_iso.reporting.picture_data import ControlPicture, MonthsPicture
from scara_iso.run import FloatArray

_AHEAD = 0.5  # spans of the tests that the picture goes on for


def month_picture(found: RobotHistory, one: SpreadHistory) -> Figure:
    """Return a figure by date, with the trend where there is one."""
    days = _days(one.tests)
    ends = np.array([test.interval or (math.nan, math.nan) for test in one.tests]).T
    fitted, ahead = None, None
    if one.trend is not None:
        fitted = one.trend.levels
        last, span = one.trend.days[-1], one.trend.days[-1] - one.trend.days[0]
        if one.trend.shown:
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
    text = "of ln RP against the tests before; a ring is an alarm"
    if (e := one.ewma) is not None:
        points = {"EWMA": e.points}
        data = ControlPicture(days, points, zero, -e.limits, e.limits, e.alarms, unit, events)
        yield Figure(data, "EWMA", text)
    if (c := one.cusum) is not None:
        limit, sums = np.full(len(days), c.limit), {"up": c.up, "down": -c.down}
        data = ControlPicture(days, sums, zero, -limit, limit, c.alarms, unit, events)
        yield Figure(data, "CUSUM", text)


def _days(tests: Sequence[TestFigure]) -> FloatArray:
    return np.array([day_of(test.when) for test in tests])


def _events(found: RobotHistory) -> tuple[float, ...]:
    return tuple(day_of(event.when) for event in found.events)


RUN_LENGTH = 350
"""Tests between two false alarms of one chart, on average: benchmarks/history.py."""
_METHOD = (
    "RP is compared as its logarithm, in standard errors: those of its own sampling, or of what "
    "neighbouring tests differ by where that is more. Each test stands against the mean of those "
    "before it since the last service. EWMA (weight 0.2, limit 2.86) and CUSUM (slack 0.5, "
    f"decision 4.77) give a false alarm in about {RUN_LENGTH} tests each. Trend and limit: growth "
    "at an even rate from an unknown day on; every interval holds 95 %."
)


def history_document(found: RobotHistory) -> Document:
    """Return the page of a robot."""
    title = f"Months of {found.robot}" if found.robot else "Months of a robot, its name not stated"
    end = Section("", (Text(f"End of {title}", "quiet"),))
    simulated = any(test.analysis.run.metadata.get("simulated") for test in found.tests)
    return Document(title, (*history_report(found), end), simulated=simulated)


def history_report(found: RobotHistory, following: NextStep | None = None) -> Report:
    """Return the document of a robot over months: what changed, then each figure and its charts."""
    answer: list[Block] = [Headline((_subject(found),)), *_verdicts(found)]
    lines = answer_lines([*answer, *_left_out(found)], following, answer=len(answer))
    return (
        Section("", lines),
        Section("", (_now(found),)),
        *at_depth("detail", _details(found)),
    )


def _details(found: RobotHistory) -> Iterator[Section]:
    if found.events:
        rows = tuple((moment_said(event.when), event.what) for event in found.events)
        yield Section("Service", (Table(("date", "what was done"), rows), *_services(found)))
    for spread in found.spreads:
        name = f"{_code(spread)} {_name(spread)}"
        yield Section(name, tuple(_spread(found, spread)), name)
    for mean in found.means:
        name = f"Mean {_name(mean)}"
        yield Section(name, tuple(_mean(found, mean)), name)
    yield Section("Method", (Text(_METHOD, "quiet"),))


def _subject(found: RobotHistory) -> str:
    first, last = found.tests[0].when, found.tests[-1].when
    name = found.robot or "robot not stated"
    serial = f", serial {found.serial}" if found.serial else ""
    if len(found.tests) == 1:
        return (
            f"{name}{serial}: one test, {moment_said(first)}; there is no other to compare it with"
        )
    return f"{name}{serial}: {len(found.tests)} tests, {moment_said(first)} to {moment_said(last)}"


def _verdicts(found: RobotHistory) -> Iterator[Text]:
    """Yield what limits, services, charts and trends amount to, the limits first.

    Alarms of the charts are left to the details where a trend says as much.
    """
    for one in found.spreads:
        yield from _against_limit(one)
    for event, moved in _served(found):
        worse = any(one.verdict is ContrastVerdict.MORE for one in moved)
        text = ", ".join(map(_moved, moved))
        yield Text(f"after the service of {_event(event)}: {text}", "bad" if worse else "good")
    changed = {id(one): next(_change_in_words(one), "") for one in found.spreads}
    for one in found.spreads:
        if text := changed[id(one)]:
            yield Text(f"{_code(one)} {_name(one)}: {text}", "warn")
    for mean in found.means:
        if mean.chart is not None and mean.chart.alarms:
            at = _alarms_at(mean.tests, mean.chart.alarms)
            yield Text(f"mean {_name(mean)} moved ({at}): robot, fixture or the dial's zero")
    yield from _silent([one for one in found.spreads if not changed[id(one)]], found)


def _silent(spreads: Sequence[SpreadHistory], found: RobotHistory) -> Iterator[Text]:
    """Yield what can be said of the figures of which neither chart, trend nor service speaks."""
    moved = {(one.pose, one.figure) for _, every in _served(found) for one in every}
    by_text: dict[str, list[str]] = {}
    for one in spreads if len(found.tests) > 1 else ():
        if not moved & {(one.pose, one.figure), (None, one.figure)}:
            by_text.setdefault(_unchanged(one), []).append(f"{_code(one)} {_name(one)}")
    for text, names in by_text.items():
        yield Text(f"{text}: {', '.join(names)}")


def _unchanged(one: SpreadHistory) -> str:
    """Return what holds where no chart speaks, which few tests do not have."""
    first, last = one.tests[0].interval, one.tests[-1].interval
    if first and last and (first[1] < last[0] or last[1] < first[0]):
        return "first and last test differ by more than their intervals"
    if one.ewma is None:
        return "no chart, for which five tests above 0 are needed"
    return "no change beyond sampling"


def _served(found: RobotHistory) -> Iterator[tuple[ServiceEvent, list[SpreadContrast]]]:
    """Yield each service behind which a figure of scatter is another, with these figures."""
    for event in found.events:
        pairs = [
            pair for one in found.changes if one.event is event for pair in one.comparison.pairs
        ]
        moved = [
            one for pair in pairs for one in pair.spreads if one.verdict in CHANGED and is_live(one)
        ]
        if moved:
            yield event, moved


def _moved(one: SpreadContrast) -> str:
    name = f"{_code(one)} {_name(one)}"
    ratio, ends = ratio_in_words(one)
    return f"{name} {'worse' if one.verdict is ContrastVerdict.MORE else 'better'} {ratio} [{ends}]"


def _event(event: ServiceEvent) -> str:
    return f"{moment_said(event.when)}, {event.what}"


def _change_in_words(one: SpreadHistory) -> Iterator[str]:
    yield from _trend_in_words(one)
    charts = (("EWMA", one.ewma), ("CUSUM", one.cusum))
    spoken = [f"{name} {len(c.alarms)}" for name, c in charts if c is not None and c.alarms]
    if spoken:
        yield f"alarms: {', '.join(spoken)}, {_alarms_at(one.tests, one.alarms)}"


def _limit_in_words(one: SpreadHistory) -> str:
    if one.limit is None:
        return ""
    limit = f"the limit of {one.limit:g} {one.unit}"
    if one.crossed:
        return f"exceeds {limit}, last {_last(one)}"
    if not one.is_proven:
        return f"may exceed {limit}, last {_last(one)}, which does not prove it kept{_until(one)}"
    return _expected(one, limit)


def _expected(one: SpreadHistory, limit: str) -> str:
    """Return until when a limit that the last test keeps is expected to be kept."""
    when = one.crossing
    if when is None or when.horizon is None:
        few = "too few tests since the service for a forecast"
        return f"is within {limit}, last {_last(one)}; {few}"
    if when.earliest is None:
        return f"is not expected to exceed {limit} before {date_on(when.horizon)}"
    if when.earliest <= day_of(one.tests[-1].when):
        return f"may already exceed {limit}, last {_last(one)}{_until(one)}"
    return f"is not expected to exceed {limit} before {date_on(when.earliest)}{_until(one)}"


def _may_exceed(one: SpreadHistory) -> bool:
    when = one.crossing
    soon = when is not None and (when.earliest or math.inf) <= day_of(one.tests[-1].when)
    return soon or not one.is_proven


def _against_limit(one: SpreadHistory) -> Iterator[Text]:
    if text := _limit_in_words(one):
        tone: Tone = "bad" if one.crossed else "warn" if _may_exceed(one) else "good"
        yield Text(f"{_code(one)} {_name(one)} {text}", tone)


def _until(one: SpreadHistory) -> str:
    when = one.crossing
    if when is None or when.likely is None:
        return ""
    latest = "" if when.latest is None else f", by {date_on(when.latest)}"
    return f", likely {date_on(when.likely)}{latest}"


def _trend_in_words(one: SpreadHistory) -> Iterator[str]:
    if one.trend is not None and one.trend.shown:
        trend = one.trend
        U = (trend.interval[1] - trend.interval[0]) / 2
        ends = interval(trend.interval)
        since = f"{date_on(trend.onset[0])} to {date_on(trend.onset[1])}"
        rate = rounded(trend.per_month, U, sign="+")
        yield f"{rate} {one.unit} a month [{ends}], begun {since}"


def _alarms_at(tests: tuple[TestFigure, ...], at: tuple[int, ...]) -> str:
    first = moment_said(tests[at[0]].when)
    return first if len(at) == 1 else f"from {first} on"


def _now(found: RobotHistory) -> Table:
    rows = tuple(
        (
            f"{_code(one)} {_name(one)} [{one.unit}]",
            Number(len(one.tests)),
            _result(one.tests[0]),
            _result(one.tests[-1]),
            Number(one.sigma, ".0%"),
        )
        for one in found.spreads
    )
    note = (
        "error: of one test, by its own sampling, or as neighbouring tests differ if that is more"
    )
    return Table(("figure", "tests", "first", "last", "error"), rows, note)


def _result(test: TestFigure, unit: str = "") -> Result:
    return Result(rounded(test.value, _U(test), unit=unit), interval(test.interval))


def _last(one: SpreadHistory) -> str:
    return str(_result(one.tests[-1], one.unit))


def _left_out(found: RobotHistory) -> Iterator[Text]:
    for one in found.unreadable:
        yield Text(f"left out: {one.source}: {one.error}", "warn")
    for note in found.notes:
        yield Text(note, "warn")


def _services(found: RobotHistory) -> Iterator[Block]:
    for change in found.changes:
        (pair,) = change.comparison.pairs
        names = [PurePath(one.run.origin.source).name for one in (pair.before, pair.after)]
        text = f"{_event(change.event)}: {headline(pair)}"
        yield Text(f"{text} ({names[0]} against {names[1]})")
    compared = {id(change.event) for change in found.changes}
    for event in found.events:
        if id(event) not in compared:
            yield Text(f"{_event(event)}: no test on both sides of it", "quiet")


def _spread(found: RobotHistory, one: SpreadHistory) -> Iterator[Block]:
    text = "; ".join(_change_in_words(one))
    yield Text(text or _unchanged(one), "strong" if text else "plain")
    yield from _against_limit(one)
    yield month_picture(found, one)
    yield from control_pictures(found, one)
    yield _every_test(one)


def _mean(found: RobotHistory, one: MeanHistory) -> Iterator[Block]:
    if one.chart is None:
        yield Text("fewer than five tests: no chart", "quiet")
    else:
        yield from control_pictures(found, one)
    yield _every_test(one)


def _every_test(one: SpreadHistory | MeanHistory) -> Table:
    alarms = one.alarms if isinstance(one, SpreadHistory) else one.chart.alarms if one.chart else ()
    rows = tuple(
        (
            moment_said(test.when),
            rounded(test.value, _U(test)),
            interval(test.interval),
            Number(test.n),
            test.verdict.value if test.verdict is not None else "",
            "alarm" if k in alarms else "",
            PurePath(test.source).name,
        )
        for k, test in enumerate(one.tests)
    )
    return Table(("date", f"[{one.unit}]", "95 % interval", "n", "limit", "charts", "table"), rows)


def _U(test: TestFigure) -> float:  # noqa: N802 - GUM's symbol
    return 0.0 if test.interval is None else (test.interval[1] - test.interval[0]) / 2


def _code(one: SpreadHistory | SpreadContrast) -> str:
    return "RP" if one.quantity == "RP" else "3 S"


def _name(one: SpreadHistory | MeanHistory | SpreadContrast) -> str:
    return one.figure if one.pose is None else f"{one.pose} {one.figure}"
