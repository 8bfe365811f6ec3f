"""From the tests of one robot, in any order, to its history."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime, time
from itertools import pairwise
from typing import Literal, TypeAlias, TypeVar

import numpy as np

from scara_iso.base.errors import DataError, Fault, UsageError
from scara_iso.base.published import Unit
from scara_iso.base.quantities import TURN
from scara_iso.comparison.chance import spread, spread_of_axes
from scara_iso.comparison.charts import (
    FEWEST,
    Cusum,
    Ewma,
    Individuals,
    between_tests,
    crossing,
    cusum,
    ewma,
    individuals,
    standardised,
    trend_of,
)
from scara_iso.comparison.pairs import CONDITIONS, compare
from scara_iso.comparison.robot_history import (
    DatedAnalysis,
    MeanHistory,
    RobotHistory,
    ServiceChange,
    ServiceEvent,
    SpreadHistory,
    TestFigure,
    day_of,
    moment_said,
)
from scara_iso.iso9283 import (
    Characteristic,
    PoseResult,
    each_axis,
    poses_in_cycles,
    position_estimate,
)
from scara_iso.run import FloatArray, copies
from scara_iso.tables import differences

Chart = TypeVar("Chart", Ewma, Cusum, Individuals)
_OF_THE_PAPER = "RP_rss"
"""Followed where a limit names it."""
Followed: TypeAlias = Literal["RP", "three_sigma"]
_CODES: Mapping[str, Followed] = {
    "RP": "RP", "RP_a": "three_sigma", _OF_THE_PAPER: "RP",
}  # fmt: skip
_KEYS = {"robot": ("robot", "item"), "serial_number": ("serial_number", "robot_serial_number")}
_BREAK, _ERRORS = 4.0, 6.0
"""A figure so many times that of the test before, and so many errors of sampling off, is of another
unit, dial or machine: wear takes longer, and an inch is 25.4."""


def follow(
    tests: Sequence[DatedAnalysis],
    events: Sequence[ServiceEvent] = (),
    *,
    robot: str | None = None,
) -> RobotHistory:
    """Return every figure of one robot in time order, with its charts, trend and limit.

    Where the serial number of all is the ``robot`` asked for, its name may be spelt in several
    ways. The limits and the verdicts of single tests are those of the analyses. Raises `DataError`
    where the tests are of several robots, or one pose was tested twice on one day and no times say
    which was first; `UsageError` for a limit of what is not followed.
    """
    ordered = tuple(sorted(tests, key=lambda test: test.when))
    name, serial = _identity(ordered, robot)
    _refuse_twice(ordered)
    spreads = tuple(_spreads(ordered, events))
    _refuse_limits(ordered, spreads)
    return RobotHistory(
        robot=name,
        serial=serial,
        tests=ordered,
        events=tuple(events),
        spreads=spreads,
        means=tuple(_means(ordered, events)),
        changes=tuple(_changes(ordered, events)),
        notes=(*_notes(ordered), *_without_tests(events, ordered)),
    )


def _refuse_limits(tests: Sequence[DatedAnalysis], spreads: Sequence[SpreadHistory]) -> None:
    if not spreads:
        raise DataError(
            "no table gives RP: they are drift tests",
            remedy="name tables of repeatability tests; `scara-iso analyze` shows one drift test",
        )
    limited = (one for test in tests for one in test.analysis.characteristics if one.limit)
    other = next((one.code for one in limited if one.code not in _CODES), None)
    if other is not None:
        raise UsageError(
            f"{other}: a history follows RP (of an angle 3 S)",
            remedy=f"give a limit of {', '.join(dict.fromkeys(one.figure for one in spreads))}",
        )


def _identity(tests: Sequence[DatedAnalysis], asked: str | None) -> tuple[str, str]:
    """Return name and serial number of the one robot, capitals or not."""
    found = []
    numbers = {_stated(test, _KEYS["serial_number"]) for test in tests}
    by_number = asked is not None and {one.casefold() for one in numbers} == {asked.casefold()}
    for key, keys in _KEYS.items():
        stated = [_stated(test, keys) for test in tests]
        names = {text.casefold(): text for text in reversed(stated) if text}
        if len(names) > 1 and not (by_number and key == "robot"):
            counts = Counter(names[text.casefold()] for text in stated if text)
            said = ", ".join(f"{name} ({counts[name]})" for name in sorted(counts))
            numbered = key == "robot" and len(numbers) == 1 and all(numbers)
            one = f"; if all are one robot: `robot={min(numbers)!r}`" if numbered else ""
            raise DataError(
                f"the tables are of several robots by their {key}: {said}",
                remedy=f"name those of one, or say which, as `robot={min(counts)!r}`{one}",
            )
        found.append(next(iter(names.values()), ""))
    return found[0], found[1]


def _stated(test: DatedAnalysis, keys: Sequence[str]) -> str:
    metadata = {key.partition("[")[0]: x for key, x in test.analysis.run.metadata.items()}
    return next((metadata[key].strip() for key in keys if metadata.get(key, "").strip()), "")


def _label(test: DatedAnalysis, pose: str | None) -> str | None:
    """Return the name of a pose: of its column, else what the head of the table says."""
    return pose if pose is not None else _stated(test, ("pose",)) or None


def _labels(test: DatedAnalysis) -> list[str | None]:
    return [_label(test, pose.label) for pose in poses_in_cycles(test.analysis)]


def _refuse_twice(tests: Sequence[DatedAnalysis]) -> None:
    seen: dict[tuple[datetime, str | None], str] = {}
    faults = []
    for test in tests:
        for pose in test.analysis.poses:
            label = _label(test, pose.label)
            key = (test.when, label)
            if key in seen:
                at = "" if label is None else f" at {label}"
                day = test.when.date().isoformat()
                faults.append(Fault(f"{seen[key]} and {test.source}: both of {day}{at}"))
            seen[key] = test.source
    if faults:
        raise DataError(
            "several tests of one day, and no time says which was first",
            remedy="state the time too, '# date: 2026-05-12T14:30', or leave one of them out",
            faults=faults,
        )


def _spreads(
    tests: Sequence[DatedAnalysis], events: Sequence[ServiceEvent]
) -> Iterator[SpreadHistory]:
    found: dict[tuple[str | None, str, Followed], list[TestFigure]] = {}
    limits: dict[tuple[str | None, str, Followed], float] = {}
    for test in tests:
        poses = {pose.label: pose for pose in poses_in_cycles(test.analysis)}
        for one in test.analysis.characteristics:
            if one.code in _CODES and (one.limit or one.code != _OF_THE_PAPER):
                of = one.name if one.code == _OF_THE_PAPER else one.of
                key = (_label(test, one.pose), of, _CODES[one.code])
                found.setdefault(key, []).append(_spread_figure(test, poses[one.pose], one))
                if one.limit is not None:
                    limits[key] = one.limit.limit
    for key, figures in found.items():
        yield _spread_history(*key, figures, _stretches(figures, events), limits.get(key))


def _spread_figure(test: DatedAnalysis, pose: PoseResult, one: Characteristic) -> TestFigure:
    names = [one.of] if one.of in pose.axes else list(one.of)
    positions = np.stack([pose.axes[name].readings for name in names])
    if one.code == _OF_THE_PAPER:
        value, error = spread_of_axes(positions)
    else:
        value, error = spread(positions, angle=one.code == "RP_a")
    verdict = None if one.limit is None else one.limit.verdict
    n, ends = positions.shape[1], one.estimate.interval
    return TestFigure(test.when, test.source, float(value), ends, n, float(error), verdict)


def _spread_history(
    pose: str | None,
    of: str,
    quantity: Followed,
    tests: Sequence[TestFigure],
    stretches: Sequence[slice],
    limit: float | None,
) -> SpreadHistory:
    n = np.array([test.n for test in tests], dtype=np.float64)
    pooled = float(np.sqrt(np.mean([test.error**2 * test.n for test in tests])))
    sampling = pooled / np.sqrt(n)
    values = np.array([test.value for test in tests])
    breaks = _breaks(values, sampling, stretches)
    history = SpreadHistory(
        pose=pose,
        figure=of,
        quantity=quantity,
        unit="deg" if quantity == "three_sigma" else "mm",
        tests=tuple(tests),
        sampling=float(sampling.mean()),
        sigma=float(sampling.mean()),
        standardised=np.zeros(len(tests)),
        limit=limit,
        since_service=stretches[-1].start,
        breaks=breaks,
    )
    if len(tests) < FEWEST or not values.all():  # a dial that stood still has no logarithm
        return history
    logs, last = np.log(values), stretches[-1]
    sigma = between_tests(logs, sampling, stretches)
    z = standardised(logs, sigma, stretches)
    days = np.array([day_of(test.when) for test in tests])
    is_one_course = not breaks or breaks[-1] <= last.start
    trend = trend_of(days[last], logs[last], sampling[last]) if is_one_course else None
    return replace(
        history,
        sigma=float(sigma.mean()),
        standardised=z,
        ewma=_dated(ewma(z, stretches), tests),
        cusum=_dated(cusum(z, stretches), tests),
        trend=trend,
        crossing=None if trend is None or limit is None else crossing(trend, limit),
    )


def _breaks(
    values: FloatArray, sampling: FloatArray, stretches: Sequence[slice]
) -> tuple[int, ...]:
    """Return the tests, from 0, whose figure no wear brings from that of the test before.

    Of one stretch; from or to 0 every step is one.
    """
    with np.errstate(divide="ignore"):
        steps = np.abs(np.diff(np.log(values)))
    least = np.maximum(math.log(_BREAK), _ERRORS * np.hypot(sampling[1:], sampling[:-1]))
    begun = {one.start for one in stretches}
    return tuple(k for k in (np.flatnonzero(steps > least) + 1).tolist() if k not in begun)


def _means(tests: Sequence[DatedAnalysis], events: Sequence[ServiceEvent]) -> Iterator[MeanHistory]:
    found: dict[tuple[str | None, str, Unit], list[TestFigure]] = {}
    for test in tests:
        for pose, axis in each_axis(poses_in_cycles(test.analysis)):
            before = found.setdefault((_label(test, pose.label), axis.name, axis.unit), [])
            away = axis.mean - before[0].value if before and axis.unit == "deg" else 0.0
            mean, S = axis.mean - TURN * round(away / TURN), axis.three_sigma / 3
            one = position_estimate(mean, S=S, n=axis.n, reading_u=0.0, unit=axis.unit, clause="")
            error = one.parts["sampling"]
            before.append(TestFigure(test.when, test.source, mean, one.interval, axis.n, error))
    for key, figures in found.items():
        chart = None
        if len(figures) >= FEWEST:
            values = np.array([figure.value for figure in figures])
            errors = np.array([figure.error for figure in figures])
            chart = individuals(values, errors, _stretches(figures, events))
            chart = _dated(chart, figures)
        yield MeanHistory(*key, tuple(figures), chart)


def _dated(chart: Chart, tests: Sequence[TestFigure]) -> Chart:
    return replace(chart, dates=tuple(moment_said(tests[k].when) for k in chart.alarms))


def _stretches(tests: Sequence[TestFigure], events: Sequence[ServiceEvent]) -> list[slice]:
    """Return the tests between one service and the next."""
    starts = {0, *(sum(test.when < event.when for test in tests) for event in events)}
    bounds = [*sorted(start for start in starts if start < len(tests)), len(tests)]
    return [slice(a, b) for a, b in pairwise(bounds)]


def _changes(
    tests: Sequence[DatedAnalysis], events: Sequence[ServiceEvent]
) -> Iterator[ServiceChange]:
    """Yield for each service and pose the last test before it against the first behind it."""
    for event in events:
        pairs = {}
        for pose in dict.fromkeys(pose for test in tests for pose in _labels(test)):
            of_it = [test for test in tests if pose in _labels(test)]
            before = [test for test in of_it if test.when < event.when]
            behind = [test for test in of_it if test.when >= event.when]
            if before and behind:
                pairs[before[-1].source, behind[0].source] = (before[-1], behind[0])
        for one, other in pairs.values():
            yield ServiceChange(event, compare([one.analysis, other.analysis]))


def _without_tests(events: Sequence[ServiceEvent], tests: Sequence[DatedAnalysis]) -> Iterator[str]:
    """Yield the services with which no test can be compared."""
    first, last = tests[0].when, tests[-1].when
    for one in events:
        side = "before" if one.when <= first else "after" if one.when > last else ""
        if side:
            yield f"{one.what} ({moment_said(one.when)}): no test {side} it, so nothing is compared"
        elif one.when.time() == time() and any(t.when.date() == one.when.date() for t in tests):
            yield (
                f"{one.what} ({moment_said(one.when)}): taken as done before the test of that day; "
                "if it was after it, write its time too, as 2026-05-12T14:30"
            )


def _notes(tests: Sequence[DatedAnalysis]) -> Iterator[str]:
    """Yield what keeps the tests from being like each other, and what makes them too alike."""
    runs = [(test.source, test.analysis.run) for test in tests]
    for source, first in copies(runs):
        yield f"{source} holds the readings of {first}: is one the other's copy?"
    named = [bool(_stated(test, ("robot", "item", "serial_number"))) for test in tests]
    if any(named) and not all(named):
        missing = [test.source for test, is_named in zip(tests, named, strict=True) if not is_named]
        yield f"{len(missing)} of {len(tests)} tables name no robot: {', '.join(missing[:3])}"
    for one in differences([run for _, run in runs]):
        texts = [*dict.fromkeys(text for text in one.each if text)]
        words = f"not the same in all tests: {', '.join(texts[:5])}"
        if (
            one.of == "statement"
            and one.name.startswith(CONDITIONS)
            and len({*map(str.casefold, texts)}) > 1
        ):
            yield f"{one.name} is {words}"
        elif one.of == "resolution":
            yield f"the dial of {one.name} is {words}"
        elif one.of == "unit":
            yield f"{one.name} is a length in some tests and an angle in others"
