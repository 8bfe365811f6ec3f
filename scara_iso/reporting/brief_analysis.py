"""An analysis in short: the figure, what it is worth, what next, one table with the readings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from scara_iso.diagnosis import FEWEST_CYCLES, MOST_CYCLES
from scara_iso.iso9283 import (
    Analysis,
    AxisResult,
    Conformity,
    LimitCheck,
    PoseResult,
    RadialResult,
)
from scara_iso.reporting.analysis import FORCE_LOOP, cycles_said, definitions_table, is_force_loop
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Charted,
    ChartedRow,
    Headline,
    NextStep,
    Report,
    Result,
    Section,
    Strip,
    Table,
    Text,
)
from scara_iso.reporting.brief import (
    Ends,
    cautions,
    figure_cells,
    figure_said,
    first_three,
    left_behind,
    simulated,
)
from scara_iso.reporting.characteristics import characteristics
from scara_iso.reporting.drift import drift_headlines, drift_sections
from scara_iso.reporting.limits import VERDICTS, conformity, figure_held

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
