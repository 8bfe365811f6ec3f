"""What every short form is made of: a figure with its interval, cautions, what is left out.

A short form says the answer in three lines, then one table with the picture. A warning is never
left out of it: each stands in the line of cautions, by what it is about.

An analysis in short: the figure, what it is worth, what next, one table with the readings.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby

from scara_iso.diagnosis import FEWEST_CYCLES, MOST_CYCLES
from scara_iso.iso9283 import (
    Analysis,
    AxisResult,
    Conformity,
    Finding,
    LimitCheck,
    PoseResult,
    RadialResult,
    in_brief,
    option_in_brief,
)
from scara_iso.reporting.analysis import (
    FORCE_LOOP,
    characteristics,
    cycles_said,
    definitions_table,
    is_force_loop,
)
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Charted,
    ChartedRow,
    Headline,
    Interval,
    NextStep,
    Number,
    Report,
    Result,
    Section,
    Strip,
    Table,
    Text,
    places,
    places_that_decide,
)
from scara_iso.reporting.drift import drift_headlines, drift_sections
from scara_iso.reporting.limits import VERDICTS, conformity, figure_held
from scara_iso.run import SIMULATED, Run

_LINE = 74
_MOST_NAMED = 4

Ends = tuple[float, float] | None


def digits_of(value: float, ends: Ends, limit: float | None = None) -> int:
    """Return the decimal places that show two significant digits of the interval.

    Of a figure without one, three digits; more where a limit would seem to be on the other side.
    """
    width = ends[1] - ends[0] if ends else 0.1 * abs(value)
    found = places(width)
    if limit is None:
        return found
    return places_that_decide(limit, (value, *(ends or ())), found)


def figure_cells(
    value: float, ends: Ends, *, limit: float | None = None, mark: str = ""
) -> tuple[Number, Interval | str]:
    """Return a figure and its interval, to the same place."""
    spec = f".{digits_of(value, ends, limit)}f"
    between = Interval(*(Number(end, spec) for end in ends)) if ends else ""
    return Number(value, spec, mark=mark), between


def figure_said(
    name: str, value: float, ends: Ends, unit: str, *, limit: float | None = None, mark: str = ""
) -> str:
    """Return ``XY 0.014 mm [0.009, 0.022]``."""
    number, between = figure_cells(value, ends, limit=limit, mark=mark)
    said = f"{name} {number} {unit}"
    return f"{said} [{between.low}, {between.high}]" if isinstance(between, Interval) else said


def first_three(
    lines: Sequence[Block], following: NextStep, *, answer: int = 2
) -> tuple[Block, ...]:
    """Return the lines with what to do next behind the ``answer``: the third, or below its list."""
    behind = max(answer, 2)
    return (*lines[:behind], following, *lines[behind:])


def simulated(run: Run) -> Iterator[Text]:
    """Yield that no robot was measured, where the table says so."""
    if run.metadata.get("simulated"):
        yield Text(SIMULATED, "bad")


def cautions(findings: Sequence[Finding]) -> Iterator[Text]:
    """Yield every warning in one line, by what it is about."""
    grave = [finding for finding in findings if finding.severity != "info"]
    if not grave:
        return
    by_code: dict[str, list[Finding]] = {}
    for finding in grave:
        by_code.setdefault(finding.code, []).append(finding)
    said = "; ".join(_caution(code, found) for code, found in by_code.items())
    if len(said) > _LINE:
        names = ", ".join(map(_with_option, by_code))
        said = f"{len(by_code)} warnings: {names}" if len(by_code) > 1 else names
    yield Text(f"! {said}", "warn")


def _caution(code: str, found: Sequence[Finding]) -> str:
    subjects = _subjects(found)
    return f"{subjects}: {_with_option(code)}" if subjects else _with_option(code)


def _with_option(code: str) -> str:
    option = option_in_brief(code)
    return f"{in_brief(code)} (state it, as {option})" if option else in_brief(code)


def _subjects(found: Sequence[Finding]) -> str:
    named = [" ".join(part for part in (one.pose, one.axis) if part) for one in found]
    if len(named) <= _MOST_NAMED:
        return ", ".join(filter(None, named))
    by_axis = groupby(sorted(found, key=lambda one: one.axis or ""), key=lambda one: one.axis)
    return ", ".join(f"{axis or 'poses'} ({len(list(like))})" for axis, like in by_axis)


def left_behind(findings: Sequence[Finding]) -> str:
    """Return how much more there is to be read."""
    deviations = sum(bool(one.rule) for one in findings)
    warnings = sum(one.severity != "info" and not one.rule for one in findings)
    others = len(findings) - deviations - warnings
    counted = (
        (warnings, "warning", ""),
        (deviations, "deviation", " from ISO 9283"),
        (others, "remark", ""),
    )
    said = [f"{k} {name}{'s' if k > 1 else ''}{of}" for k, name, of in counted if k]
    return f"{', '.join(said) or 'every figure'}: `full=`"


_MOST_OF_NO_AXIS = 6
_MOST_POSES = 40


def analysis_brief(analysis: Analysis, following: NextStep) -> Report:
    """Return an analysis in ten to twenty lines; `after_analysis` says what may follow."""
    verdicts = list(conformity(analysis))
    doubts = [*simulated(analysis.run), *cautions(analysis.findings)]
    lines = [*verdicts[:1], *_answer(analysis), *verdicts[1:], *doubts]
    head = first_three(lines, following)
    return (
        Section("", head),
        *_figures(analysis),
        Section("", tuple(_behind(analysis))),
    )


def _answer(analysis: Analysis) -> Iterator[Block]:
    if analysis.block is not None:
        yield from drift_headlines(analysis)
        return
    if is_force_loop(analysis):
        counted = f"{analysis.cycles.used} readings"
        yield Headline((FORCE_LOOP, counted))
        yield Headline(tuple(_given_way(analysis)) or ("no spring is seen in it",), "plain")
        return
    pose = largest(analysis.poses)
    at = f"at {pose.label}, the largest of {len(analysis.poses)} poses"
    cycles = f"{analysis.cycles.used} cycles"
    figures = [figure_said(*one) for one in headline_figures(pose)]
    where = f" {at}" if len(analysis.poses) > 1 else ""
    yield Headline((f"RP  {figures[0]}{where}", *figures[1:], cycles))


def axis_of_loop(analysis: Analysis) -> str | None:
    """Return the first axis at which the only pose was pushed to and fro; None without a loop."""
    if len(analysis.poses) > 1:
        return None
    return next((one.axis for one in analysis.findings if one.code == "force-loop"), None)


def _given_way(analysis: Analysis) -> Iterator[str]:
    for one in analysis.characteristics:
        if one.code == "compliance":
            found, at = one.estimate, f" at {one.pose}" if one.pose else ""
            yield figure_said(f"compliance {one.of}", found.value, found.interval, found.unit) + at


Figure = tuple[str, float, Ends, str]
"""Name, value, 95 % interval, unit."""


def headline_figures(pose: PoseResult) -> list[Figure]:
    """Return what a robot is bought by: the plane where there is one, then the other axes."""
    plane = [_radial(pose.XY)] if pose.XY is not None else []
    others = [axis for axis in pose.axes.values() if not (plane and axis.name in "XY")]
    return [*plane, *map(_of_axis, others)]


def _radial(XY: RadialResult) -> Figure:
    return "XY", XY.RP, XY.RP_interval, "mm"


def _of_axis(axis: AxisResult) -> Figure:
    if axis.unit == "deg":
        return axis.name, axis.three_sigma, axis.three_sigma_interval, axis.unit
    return axis.name, axis.RP, axis.RP_interval, axis.unit


def largest(poses: Sequence[PoseResult]) -> PoseResult:
    """Return the pose whose first figure is the largest, or may be where it is 0."""

    def size(pose: PoseResult) -> float:
        _, value, ends, _ = headline_figures(pose)[0]
        return value or (ends[1] if ends else 0.0)

    return max(poses, key=size)


def after_analysis(
    analysis: Analysis, command: str, table: str, loop: str | None = None
) -> NextStep:
    """Return what to do next.

    ``table`` is how a command line names the readings, with the options that read them;
    ``command`` likewise with the limits; ``loop`` with `axis_of_loop`, where there is one.
    """
    if loop is not None:
        return NextStep(f"scara-iso push {loop}", "play, friction and spring")
    drifts = any(check.interval_void for check in analysis.limits)
    if analysis.conformity is Conformity.PASS and not drifts:
        return NextStep(f"scara-iso report {command}", "the report to sign")
    if analysis.block is not None or not _can_be_diagnosed(analysis):
        return NextStep(f"scara-iso report {command}", "every figure, to sign")
    return NextStep(f"scara-iso diagnose {table}", "what else than scatter is in it")


def _can_be_diagnosed(analysis: Analysis) -> bool:
    moving = any(axis.l_bar for pose in analysis.poses for axis in pose.axes.values())
    return moving and FEWEST_CYCLES <= analysis.cycles.used <= MOST_CYCLES


def _figures(analysis: Analysis) -> Iterator[Section]:
    if analysis.block is not None:
        yield from _courses(analysis)
        return
    pose = largest(analysis.poses)
    several = len(analysis.poses) > 1
    if several:
        yield Section("", (_table_of_poses(analysis.poses[:_MOST_POSES]),))
    yield Section("", (_charted(analysis, pose, at=pose.label if several else None),))
    defined = [axis for axis in pose.axes.values() if axis.definitions]
    if defined:
        yield Section("", (definitions_table(defined),))


def _courses(analysis: Analysis) -> Iterator[Section]:
    """Yield the strips of a drift test and its figures, without the tables of its blocks."""
    for section in drift_sections(analysis):
        blocks = tuple(block for block in section.blocks if isinstance(block, Strip))
        if blocks:
            yield Section("", blocks, section.one_of)
    yield from (replace(one, heading="") for one in characteristics(analysis, advice=False))


def _charted(analysis: Analysis, pose: PoseResult, *, at: str | None) -> Charted:
    held = {one.figure: one for one in analysis.limits if one.pose == pose.label}
    rows = [
        ChartedRow(_cells(_of_axis(axis), held.pop(axis.name, None)), axis.readings)
        for axis in pose.axes.values()
    ]
    others = sorted(held.values(), key=lambda one: one.verdict is Conformity.PASS)
    if pose.XY is not None and any(one.code == "RP_rss" for one in others):
        rows.append(ChartedRow(_cells(_radial(pose.XY), None)))  # beside the one that decides
    rows += [ChartedRow(_checked(one)) for one in others[:_MOST_OF_NO_AXIS]]
    header = ["", "RP", "95 % interval", "", f"over the cycles{'' if at is None else f' at {at}'}"]
    if analysis.limits:
        header.insert(-1, "limit")
        rows = [replace(row, cells=(*row.cells, "")[: len(header) - 1]) for row in rows]
    return Charted(tuple(header), tuple(rows))


def _cells(figure: Figure, check: LimitCheck | None) -> tuple[Cell, ...]:
    if check is not None:
        return _checked(check)
    name, value, ends, unit = figure
    return (name, *figure_cells(value, ends, mark="± " if unit == "deg" else ""), unit)


def _checked(check: LimitCheck) -> tuple[Cell, ...]:
    mark = "± " if check.code == "RP_a" else ""
    figures = figure_cells(check.RP, check.interval, limit=check.limit, mark=mark)
    return (figure_held(check), *figures, check.unit, VERDICTS[check.verdict])


def _table_of_poses(poses: Sequence[PoseResult]) -> Table:
    names = list(dict.fromkeys(name for pose in poses for name, *_ in headline_figures(pose)))
    units = {name: unit for pose in poses for name, _, _, unit in headline_figures(pose)}
    rows = []
    for pose in poses:
        found = {one[0]: one for one in headline_figures(pose)}
        cells = (_result(found.get(name)) for name in names)
        rows.append((pose.label or "", *cells))
    return Table(("pose", *(f"RP {name} [{units[name]}]" for name in names)), tuple(rows))


def _result(figure: Figure | None) -> Result | str:
    if figure is None:
        return ""
    _, value, ends, unit = figure
    return Result(*figure_cells(value, ends, mark="± " if unit == "deg" else ""))


def _behind(analysis: Analysis) -> Iterator[Text]:
    """Yield how the table was understood: a wrong unit must be seen, and a lost row."""
    origin = analysis.run.origin
    named = (analysis.run.metadata.get("robot"), origin.source, cycles_said(analysis))
    yield Text(" · ".join(filter(None, named)), "quiet")
    if origin.understood:
        yield Text(f"read as {origin.understood}", "quiet")
    yield from (Text(note, "quiet") for note in origin.notes)
    yield Text(left_behind(analysis.findings), "quiet")
