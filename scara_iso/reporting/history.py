"""The page of one robot over months: what changed first, then every figure with its charts."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from pathlib import PurePath

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
from scara_iso.reporting.comparison import CHANGED, figure_name, headline, is_live, ratio
from scara_iso.reporting.pictures import control_charts, month_picture
from scara_iso.reporting.shared.blocks import (
    Block,
    Columns,
    Document,
    NextStep,
    Report,
    Section,
    Table,
    Text,
    ended,
    note,
)
from scara_iso.reporting.shared.digits import FIGURE, Result, Tone, result, share
from scara_iso.tables import listed


def history_document(found: RobotHistory) -> Document:
    """Return the page of a robot."""
    title = f"Months of {found.robot}" if found.robot else "Months of a robot, its name not stated"
    simulated = any(test.analysis.run.simulated for test in found.tests)
    return Document(title, ended(history_report(found), title), simulated=simulated)


def history_report(found: RobotHistory, following: NextStep | None = None) -> Report:
    """Return the document of a robot over months: what changed, then each figure and its charts."""
    first, last = (moment_said(found.tests[k].when) for k in (0, -1))
    named = (found.robot or "robot not stated", found.serial and f"serial {found.serial}")
    many = f"{len(found.tests)} tests, {first} to {last}"
    one = f"one test, {first}; a second one is needed for a comparison"
    subject = f"{', '.join(filter(None, named))}: {many if len(found.tests) > 1 else one}"
    notes = map(str, found.unreadable)
    answer: list[Block] = [Text(subject, "strong"), *_verdicts(found)]
    doubts = [Text(note, "warn") for note in (*notes, *found.notes)]
    columns: Columns[SpreadHistory] = {
        "figure": lambda one: f"{_name(one)} [{one.unit}]",
        "tests": lambda one: len(one.tests),
        "first": lambda one: _result(one.tests[0], limit=one.limit),
        "last": lambda one: _result(one.tests[-1], limit=one.limit),
        "error": lambda one: share(one.sigma),
    }
    return (
        Section.of_answer([*answer, *doubts], following, answer=len(answer)),
        Section("", (Table.of(found.spreads, columns, note("error_of_a_test")),)),
        *Section.in_detail(_details(found)),
    )


def _details(found: RobotHistory) -> Iterator[Section]:
    events: Columns[ServiceEvent] = {
        "date": lambda event: moment_said(event.when),
        "what was done": lambda event: event.what,
    }
    yield Section("Service", (Table.of(found.events, events), *_services(found)))
    for spread in found.spreads:
        text = "; ".join(_change_in_words(spread))
        blocks: tuple[Block, ...] = (
            Text(text or _unchanged(spread), "strong" if text else "plain"),
            *_against_limit(spread),
            month_picture(found, spread),
            *control_charts(found, spread),
            _every_test(spread, spread.alarms),
        )
        yield Section(_name(spread), blocks, _name(spread))
    for mean in found.means:
        name, chart = f"Mean {figure_name(mean)}", mean.chart
        few = Text("fewer than five tests: no chart" if chart is None else "", "quiet")
        tests = _every_test(mean, () if chart is None else chart.alarms)
        yield Section(name, (few, *control_charts(found, mean), tests), name)
    yield Section("Method", (Text(note("months"), "quiet"),))


def _verdicts(found: RobotHistory) -> Iterator[Text]:
    """Yield what limits, services, charts and trends amount to, the limits first.

    Alarms of the charts are left to the details where a trend says as much.
    """
    yield from _breaks(found.spreads)
    for one in found.spreads:
        yield from _against_limit(one)
    served = list(_served(found))
    for event, moved in served:
        worse = any(one.verdict is ContrastVerdict.MORE for one in moved)
        text = ", ".join(f"{_name(one)} {CHANGED[one.verdict]} {ratio(one)}" for one in moved)
        yield Text(f"after the service of {_event(event)}: {text}", "bad" if worse else "good")
    changed = {id(one): next(_change_in_words(one), "") for one in found.spreads}
    for one in found.spreads:
        if text := changed[id(one)]:
            yield Text(f"{_name(one)}: {text}", "warn")
    for mean in found.means:
        if mean.chart is not None and mean.chart.alarms:
            at = _alarms_at(mean.tests, mean.chart.alarms)
            yield Text(f"mean {figure_name(mean)} moved ({at}): robot, fixture or the dial's zero")
    spoken = {(one.pose, one.figure) for _, moved in served for one in moved}
    quiet = [one for one in found.spreads if not (changed[id(one)] or one.crossed)]
    yield from _silent(quiet, spoken, found)


def _breaks(spreads: Sequence[SpreadHistory]) -> Iterator[Text]:
    found: dict[str, list[str]] = {}
    for one in spreads:
        for k in one.breaks:
            before, here = one.tests[k - 1].value, one.tests[k].value
            least, most = min(before, here), max(before, here)
            times = (
                f"{most / least:.2g} times {'more' if here > before else 'less'}" if least else ""
            )
            way = times or ("0" if here == 0 else "no longer 0")
            found.setdefault(moment_said(one.tests[k].when), []).append(f"{_name(one)} is {way}")
    for when, figures in found.items():
        text = f"{when} does not go on from the test before: {', '.join(figures)}. {note('break')}"
        yield Text(text, "warn")


def _silent(
    spreads: Sequence[SpreadHistory],
    spoken: Collection[tuple[str | None, str]],
    found: RobotHistory,
) -> Iterator[Text]:
    silent: dict[str, list[str]] = {}
    for one in spreads if len(found.tests) > 1 else ():
        if (one.pose, one.figure) not in spoken and (None, one.figure) not in spoken:
            silent.setdefault(_unchanged(one), []).append(_name(one))
    yield from (Text(f"{text}: {', '.join(names)}") for text, names in silent.items())


def _unchanged(one: SpreadHistory) -> str:
    first, last = one.tests[0].interval, one.tests[-1].interval
    if first and last and (first[1] < last[0] or last[1] < first[0]):
        return "first and last test differ by more than their intervals"
    if one.ewma is None:
        return "no chart, which wants five tests and none of them 0"
    return "no change beyond sampling"


def _served(found: RobotHistory) -> Iterator[tuple[ServiceEvent, list[SpreadContrast]]]:
    for event in found.events:
        changes = (one for one in found.changes if one.event is event)
        pairs = (pair for one in changes for pair in one.comparison.pairs)
        spreads = (one for pair in pairs for one in pair.spreads)
        moved = [one for one in spreads if one.verdict in CHANGED and is_live(one)]
        if moved:
            yield event, moved


def _event(event: ServiceEvent) -> str:
    return f"{moment_said(event.when)}, {event.what}"


def _change_in_words(one: SpreadHistory) -> Iterator[str]:
    if one.trend is not None and one.trend.shown:
        trend = one.trend
        rate = result(trend.per_month, trend.interval, f"{one.unit} a month", sign="+")
        since = f"{date_on(trend.onset[0])[:7]} to {date_on(trend.onset[1])[:7]}"
        yield f"{rate}, begun {since}"
    charts = (("EWMA", one.ewma), ("CUSUM", one.cusum))
    later = ((name, sum(k >= one.since_service for k in c.alarms)) for name, c in charts if c)
    spoken = [f"{name} {n} test{'s' * (n > 1)}" for name, n in later if n]
    if spoken:
        at = [k for k in one.alarms if k >= one.since_service]
        yield f"alarms: {', '.join(spoken)}, {_alarms_at(one.tests, at)}"


def _alarms_at(tests: Sequence[TestFigure], at: Sequence[int]) -> str:
    first = moment_said(tests[at[0]].when)
    last = "on" if at[-1] == len(tests) - 1 else f"to {moment_said(tests[at[-1]].when)}"
    return first if len(at) == 1 else f"from {first} {last}"


def _until(one: SpreadHistory, likely: float, latest_day: float | None) -> str:
    latest = "" if latest_day is None else f", 97.5 % sure by {date_on(latest_day)}"
    day = date_on(likely)
    if not next(_change_in_words(one), ""):
        return f"; by a trend that is within sampling it would cross it on {day}{latest}"
    if likely <= day_of(one.tests[-1].when):
        return f"; more likely than not it does already{latest}"
    return f"; expected to cross it on {day}{latest}"


def _against_limit(one: SpreadHistory) -> Iterator[Text]:
    if one.limit is None:
        return
    limit = f"the limit of {one.limit:g} {one.unit}"
    last = f"last {_result(one.tests[-1], one.unit, one.limit)}"
    when, until = one.crossing, ""
    tone: Tone = "warn"
    if when is not None and when.likely is not None:
        until = _until(one, when.likely, when.latest)
    ends = one.tests[-1].interval
    if one.limit < (one.tests[-1].value if ends is None else ends[0]):
        text, tone = f"exceeds {limit}, {last}", "bad"
    elif one.broken:
        broke = listed([moment_said(test.when) for test in one.broken])
        text, tone = f"exceeded {limit} on {broke}, {last}", "bad"
    elif not one.is_proven:
        text = f"may exceed {limit}, {last}{until}"
    elif when is None or when.horizon is None:
        few = (
            "no forecast over such a break"
            if one.breaks and one.breaks[-1] > one.since_service
            else f"too few tests{' since the service' * bool(one.since_service)} for a forecast"
        )
        text, tone = f"is within {limit}, {last}; {few}", "good"
    elif (when.earliest or math.inf) <= day_of(one.tests[-1].when):
        text = f"may already exceed {limit}, {last}{until}"
    else:
        until = "" if when.earliest is None else until
        first = date_on(when.horizon if when.earliest is None else when.earliest)
        text, tone = f"is not expected to exceed {limit} before {first}{until}", "good"
    yield Text(f"{_name(one)} {text}", tone)


def _result(test: TestFigure, unit: str = "", limit: float | None = None) -> Result:
    return result(test.value, test.interval, unit, limit=limit)


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


def _every_test(one: SpreadHistory | MeanHistory, alarms: Sequence[int]) -> Table:
    columns: Columns[tuple[int, TestFigure]] = {
        "date": lambda row: moment_said(row[1].when),
        FIGURE: lambda row: _result(row[1], one.unit),
        "n": lambda row: row[1].n,
        "limit": lambda row: None if row[1].verdict is None else row[1].verdict.value,
        "charts": lambda row: "alarm" if row[0] in alarms else "",
        "table": lambda row: PurePath(row[1].source).name,
    }
    return Table.of(enumerate(one.tests), columns)


def _name(one: SpreadHistory | SpreadContrast) -> str:
    return f"{'RP' if one.quantity == 'RP' else '3 S'} {figure_name(one)}"
