"""The document of an analysis: the figures and what they are worth, then every table and finding.

A warning is never left out of the answer: each stands in the line of cautions, by what it is about.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import groupby

from scara_iso.diagnosis import FEWEST_CYCLES, MOST_CYCLES
from scara_iso.iso9283 import (
    CYCLES_USED,
    Analysis,
    AxisResult,
    Conformity,
    Finding,
    LimitCheck,
    PoseResult,
    arrivals_by_pose,
    in_brief,
    poses_in_cycles,
)
from scara_iso.reporting.shared.blocks import (
    Block,
    NextStep,
    Notice,
    Report,
    Section,
    Strip,
    Table,
    Text,
)
from scara_iso.reporting.shared.digits import Cell, Ends, result
from scara_iso.reporting.shared.figures import (
    characteristics,
    definitions_table,
    drift_details,
    drift_headlines,
    drift_strips,
    pose_figures,
)
from scara_iso.reporting.shared.limits import (
    STRICTEST,
    VERDICTS,
    conformity,
    estimate_result,
    limit_cell,
    table_of_limits,
)
from scara_iso.reporting.shared.stated import left_unused
from scara_iso.run import FloatArray

_LINE = 74
_MOST_NAMED = 4
_MOST_OF_NO_AXIS = 6
_MOST_POSES = 40
_ROOM_FOR_VERDICTS = 2
"""Figures of a pose beside which its verdict has room."""
FORCE_LOOP = "a force loop, no test of repeatability"
_OF_A_TABLE = re.compile(
    r"pose (.+?) from (the \w+'s name|'# pose:'|the column)(?: of)? .+?: (.+?)(?: \(lines [^)]*\))?"
)
_GRAVITY = ("error", "warning", "info")


def analysis_report(analysis: Analysis, following: NextStep | None = None) -> Report:
    """Return the document of an analysis; `after_analysis` says what may follow."""
    return (*_answer_sections(analysis, following), *Section.in_detail(_details(analysis)))


def _answer_sections(analysis: Analysis, following: NextStep | None) -> Iterator[Section]:
    verdicts, pose = list(conformity(analysis)), largest(analysis.poses)
    doubts = (Text(analysis.run.simulated, "bad"), cautions(analysis.findings))
    first = min(len(analysis.limits), 1)
    lines = [*verdicts[:first], *_answer(analysis), *verdicts[first:], *doubts]
    yield Section.of_answer(lines, following)
    if analysis.block is not None:
        for course in analysis.drift or ():
            yield Section("", tuple(drift_strips(course)), course.pose.label or "")
        yield Section("", characteristics(analysis, advice=False).blocks)
    else:
        many = len(analysis.poses) > 1
        yield Section("", (_table_of_poses(analysis) if many else _charted(analysis, pose),))
        yield Section("", (definitions_table(pose),), depth="brief")
    yield Section("", tuple(_behind(analysis)))
    yield Section("", (Text(_left_behind(analysis.findings), "quiet"),), depth="more")


def _details(analysis: Analysis) -> Iterator[Section]:
    yield from drift_details(analysis)
    poses = poses_in_cycles(analysis)
    for pose in poses:
        label = pose.label or ""
        strips = [readings_strip(pose, name, name) for name in pose.axes] if len(poses) > 1 else []
        name = f"{label and f'pose {label}: '}repeatability"
        yield Section(name, (*pose_figures(pose), *strips), label)
    if analysis.block is None:
        yield characteristics(analysis)
    yield from table_of_limits(analysis.limits)
    yield from findings(analysis)


def cautions(findings: Sequence[Finding]) -> Text:
    """Return every warning in one line, by what it is about; empty without any."""
    by_code: dict[str, list[Finding]] = {}
    for finding in findings:
        if finding.severity != "info":
            by_code.setdefault(finding.code, []).append(finding)
    names = {
        code: in_brief(code)
        + "".join(dict.fromkeys(f" ({one.in_short})" for one in like if one.in_short))
        for code, like in by_code.items()
    }
    parts = (": ".join(filter(None, (_subjects(by_code[code]), names[code]))) for code in by_code)
    text = "; ".join(parts)
    if len(text) > _LINE:
        text = "; ".join(names.values())
    return Text(text and f"! {text}", "warn")


def _subjects(found: Sequence[Finding]) -> str:
    named = [subject_of(one, " ") for one in found]
    if len(named) <= _MOST_NAMED:
        return ", ".join(filter(None, named))
    by_axis = groupby(sorted(found, key=lambda one: one.axis or ""), key=lambda one: one.axis)
    return ", ".join(f"{axis or 'poses'} ({len(list(like))})" for axis, like in by_axis)


def _left_behind(findings: Sequence[Finding]) -> str:
    deviations = sum(bool(one.rule) for one in findings)
    warnings = sum(one.severity != "info" and not one.rule for one in findings)
    counted = (
        (warnings, "warning", ""),
        (deviations, "deviation", " from ISO 9283"),
        (len(findings) - deviations - warnings, "note", ""),
    )
    parts = [f"{k} {name}{'s' if k > 1 else ''}{of}" for k, name, of in counted if k]
    return f"{', '.join(parts) or 'every figure'}: `full=`"


def _answer(analysis: Analysis) -> Iterator[Block]:
    if analysis.block is not None:
        yield from drift_headlines(analysis)
    elif is_force_loop(analysis):
        yield Text(FORCE_LOOP, "strong", (f"{analysis.cycles.used} readings",))
        first, *parts = [
            f"compliance {one.of} {estimate_result(one, one.estimate.unit)}"
            + (f" at {one.pose}" if one.pose else "")
            for one in analysis.characteristics
            if one.code == "compliance"
        ] or ["no spring is seen in it"]
        yield Text(first, parts=tuple(parts))
    else:
        pose = largest(analysis.poses)
        poses = len(arrivals_by_pose(analysis.run, analysis.poses))
        of = f"{poses} poses" if poses == len(analysis.poses) else f"{len(analysis.poses)} arrivals"
        at = f" at {pose.label}, the largest of {of}"
        named = _headline_figures(pose)
        limits = {one.figure: one.limit for one in analysis.limits}
        first, *figures = (
            f"{name} {result(value, ends, of, limit=limits.get(name))}"
            for name, value, ends, of in named
        )
        where = at if len(analysis.poses) > 1 else ""
        yield Text(f"RP  {first}{where}", "strong", (*figures, f"{len(pose.rows)} cycles"))


def axis_of_loop(analysis: Analysis) -> str | None:
    """Return the first axis at which the only pose was pushed to and fro; None without a loop."""
    if len(analysis.poses) > 1:
        return None
    return next((one.axis for one in analysis.findings if one.code == "force-loop"), None)


_Figure = tuple[str, float, Ends, str]
"""Name, value, 95 % interval, unit."""


def _headline_figures(pose: PoseResult) -> list[_Figure]:
    """Return what a robot is bought by: the plane where there is one, then the other axes."""
    plane = [] if pose.XY is None else [("XY", pose.XY.RP, pose.XY.RP_interval, "mm")]
    others = [axis for axis in pose.axes.values() if not (plane and axis.name in "XY")]
    return [*plane, *map(_of_axis, others)]


def _of_axis(axis: AxisResult) -> _Figure:
    if axis.unit == "deg":
        return axis.name, axis.three_sigma, axis.three_sigma_interval, axis.unit
    return axis.name, axis.RP, axis.RP_interval, axis.unit


def largest(poses: Sequence[PoseResult]) -> PoseResult:
    """Return the pose whose first figure is the largest, or may be where it is 0."""

    def size(pose: PoseResult) -> float:
        _, value, ends, _ = _headline_figures(pose)[0]
        return value or (ends and ends[1]) or 0.0

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
    passes = analysis.conformity is Conformity.PASS and not drifts
    if (passes or not _moves(analysis)) and any(
        one.code == "no-scatter" for one in analysis.findings
    ):
        return NextStep("scara-iso explain no-scatter", "a dial that stands still proves nothing")
    if passes:
        return NextStep(f"scara-iso report {command}", "the report to sign")
    if not can_be_diagnosed(analysis):
        return NextStep(f"scara-iso report {command}", "every figure, to sign")
    return NextStep(f"scara-iso diagnose {table}", "what is in it besides scatter")


def can_be_diagnosed(analysis: Analysis) -> bool:
    """Return whether ``diagnose`` takes such a test: its cycles, and a dial that moves."""
    as_many = FEWEST_CYCLES <= analysis.cycles.used <= MOST_CYCLES
    return as_many and analysis.block is None and _moves(analysis)


def _moves(analysis: Analysis) -> bool:
    return any(axis.l_bar for pose in analysis.poses for axis in pose.axes.values())


def _charted(analysis: Analysis, pose: PoseResult) -> Table:
    kept = {one.figure: one for one in analysis.limits if one.pose == pose.label}
    rows: list[tuple[_Figure, LimitCheck | None, FloatArray | None]] = [
        (_of_axis(axis), kept.pop(axis.name, None), axis.readings) for axis in pose.axes.values()
    ]
    others = sorted(kept.values(), key=lambda one: one.verdict is Conformity.PASS)
    if pose.XY is not None and {one.figure for one in others} == {"XY_eq23"}:
        rows.append((_headline_figures(pose)[0], None, None))  # before the one that decides
    rows += [
        ((one.figure, one.RP, one.interval, one.unit), one, None)
        for one in others[:_MOST_OF_NO_AXIS]
    ]
    checks = [check for _, check, _ in rows if check is not None]
    verdict = [_verdict_column(checks)] if checks else []
    units = {unit for (*_, unit), _, _ in rows}
    many = len(units) > 1
    cells = tuple(
        (*_cells(figure, check, with_unit=many), *(_verdict(check, v) for v in verdict))
        for figure, check, _ in rows
    )
    heading = "RP" if many else f"RP [{units.pop()}]"
    readings = tuple(readings for *_, readings in rows)
    return Table(("", heading, "95 % interval", *verdict), cells, readings=readings)


def _cells(figure: _Figure, check: LimitCheck | None, *, with_unit: bool) -> tuple[Cell, ...]:
    name, value, ends, unit = figure
    limit, half_width = None, unit == "deg"
    if check is not None:
        value, ends, limit, half_width = check.RP, check.interval, check.limit, check.code == "RP_a"
    mark = "± " if half_width else ""
    found = result(value, ends, unit * with_unit, limit=limit, mark=mark)
    return name, found.value, found.interval or ""


def _verdict_column(checks: Sequence[LimitCheck]) -> str:
    limits = {str(limit_cell(check)) for check in checks}
    return f"limit {limits.pop()}" if len(limits) == 1 else "limit"


def _verdict(check: LimitCheck | None, heading: str) -> str:
    if check is None:
        return ""
    limit = "" if heading != "limit" else f", {limit_cell(check)}"
    return f"{VERDICTS[check.verdict][0]}{limit}"


def _table_of_poses(analysis: Analysis) -> Table:
    figures = [(pose.label, _headline_figures(pose)) for pose in analysis.poses[:_MOST_POSES]]
    narrow = max(len(found) for _, found in figures) <= _ROOM_FOR_VERDICTS
    verdict = [_verdict_column(analysis.limits)] if analysis.limits and narrow else []
    rows: list[dict[str, Cell]] = []
    for label, found in figures:
        checks = [one for one in analysis.limits if one.pose == label]
        shown = [name for name, *_ in found]
        strictest = min(
            checks,
            key=lambda one: (STRICTEST.index(one.verdict), one.figure not in shown),
            default=None,
        )
        of = "" if strictest is None or [strictest.figure] == shown else _of_another(strictest)
        cells = {f"RP {name} [{unit}]": result(v, ends) for name, v, ends, unit in found}
        verdicts = {v: f"{of}{_verdict(strictest, v)}" for v in verdict}
        rows.append({"pose": label or "", **cells, **verdicts})
    return Table.by_name(rows)


def _of_another(check: LimitCheck) -> str:
    """Return the figure that decides at a pose, where it is not the one that stands beside it."""
    return f"{check.figure} {result(check.RP, check.interval, limit=check.limit).value}: "


def _behind(analysis: Analysis) -> Iterator[Text]:
    """Yield how the table was understood: a wrong unit must be seen, and a lost row."""
    origin = analysis.run.origin
    named = (analysis.run.metadata.get("robot"), origin.source, cycles_in_words(analysis))
    yield Text(" · ".join(filter(None, named)), "quiet")
    read = f"read as {origin.understood}" if origin.understood else ""
    limits = [one.limit for one in analysis.limits]
    for note in filter(None, (read, *by_table(left_unused(analysis.run, limits)))):
        yield Text(note, "quiet")


def by_table(notes: Sequence[str]) -> Iterator[str]:
    """Yield notes, those of tables that were read alike as one: they hid the others."""
    alike: dict[str, list[tuple[str, str]]] = {}
    for note in notes:
        found = _OF_A_TABLE.fullmatch(note)
        pose, read = (found[1], f"{found[2]}: {found[3]}") if found else ("", note)
        alike.setdefault(read, []).append((pose, note))
    for read, poses in alike.items():
        named = [pose for pose, _ in poses if pose]
        yield f"poses {', '.join(named)}, each from {read}" if len(named) > 1 else poses[0][1]


def is_force_loop(analysis: Analysis) -> bool:
    """Return whether a force was stepped to and fro at every pose: RP is no repeatability then."""
    loops = {one.pose for one in analysis.findings if one.code == "force-loop"}
    return analysis.block is None and loops >= {pose.label for pose in analysis.poses}


def cycles_in_words(analysis: Analysis) -> str:
    """Return how many cycles were read, which were discarded and how many count."""
    cycles = analysis.cycles
    if analysis.block is not None:
        return f"{cycles.read} visits in {analysis.block.max() + 1} blocks; every visit counts."
    each = " at each pose" if len(analysis.poses) > 1 else ""
    if any(pose.missing for pose in analysis.poses):
        each += " or more" if each else ""
    if cycles.all_count:
        own = ": the standard's own 30 cycles" if cycles.used == CYCLES_USED else ""
        return f"{cycles.read} cycles read{each}; all of them count, none was discarded{own}."
    left_out = (
        f"cycle {cycles.discarded[0]} is discarded"
        if cycles.discarded
        else "the first was discarded before, none is discarded here"
    )
    return f"{cycles.read} cycles read{each}; {left_out}; {cycles.used} count."


def readings_strip(pose: PoseResult, name: str, label: str) -> Strip:
    """Return the readings of an axis over the cycles, drawn small, with their range."""
    axis = pose.axes[name]
    caption = f"{axis.readings.min():.7g} .. {axis.readings.max():.7g} {axis.unit}"
    return Strip(label, axis.readings, caption)


def findings(analysis: Analysis, *, advice: bool = True) -> Iterator[Section]:
    """Yield the deviations from the standard, and what else was found.

    ``advice`` is for who runs the program, and not for a customer.
    """
    rows = {(one.rule, as_deviation(one, advice=advice)) for one in analysis.deviations}
    yield Section("deviations from ISO 9283", tuple(Text(text) for _, text in sorted(rows)))
    others = [finding for finding in analysis.findings if not finding.rule]
    others.sort(key=lambda finding: _GRAVITY.index(finding.severity))
    notices = tuple(notice(one, advice=advice) for one in others)
    how = Text("scara-iso explain CODE says more about each", "quiet")
    yield Section("findings", (*notices, how) if advice and notices else notices)


def notice(one: Finding, *, advice: bool = True) -> Notice:
    """Return a finding as a block of a document."""
    return Notice(one.severity, one.code, subject_of(one), one.in_full if advice else one.message)


def as_deviation(one: Finding, *, advice: bool = False) -> str:
    """Return what deviates from a rule, and the rule: ``Not stated: load [ISO 9283 6.2]``."""
    what = subject_of(one)
    what += (what and ": ") + (one.in_full if advice else one.message)
    return f"{what[:1].upper()}{what[1:]} [{one.rule}]"


def subject_of(finding: Finding, between: str = ", ") -> str:
    """Return what a finding is about: ``P1, X``, nothing where it is about all."""
    return between.join(filter(None, (finding.pose, finding.axis)))
