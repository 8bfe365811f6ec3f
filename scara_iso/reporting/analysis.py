"""The document of an analysis: the figures and what they are worth, then every table and finding.

A warning is never left out of the answer: each stands in the line of cautions, by what it is about.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
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
    RadialResult,
    in_brief,
    option_in_brief,
    poses_in_cycles,
)
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Charted,
    ChartedRow,
    Ends,
    Headline,
    NextStep,
    Notice,
    Report,
    Result,
    Section,
    Strip,
    Table,
    Text,
    answer_lines,
    at_depth,
    figure_cells,
    figure_in_words,
    table_by_name,
)
from scara_iso.reporting.figure_tables import characteristics, definitions_table, pose_figures
from scara_iso.reporting.limits import (
    STRICTEST,
    VERDICTS,
    conformity,
    limit_cell,
    limits,
)
from scara_iso.reporting.pictures import drift_details, drift_headlines, drift_sections
from scara_iso.reporting.stated import not_used
from scara_iso.run import SIMULATED, FloatArray, Run

_LINE = 74
_MOST_NAMED = 4
_MOST_OF_NO_AXIS = 6
_MOST_POSES = 40
_ROOM_FOR_VERDICTS = 2
"""Figures of a pose beside which its verdict has room."""


def analysis_report(analysis: Analysis, following: NextStep | None = None) -> Report:
    """Return the document of an analysis; `after_analysis` says what may follow."""
    return (*_answer_sections(analysis, following), *at_depth("detail", _details(analysis)))


def _answer_sections(analysis: Analysis, following: NextStep | None) -> Iterator[Section]:
    verdicts = list(conformity(analysis))
    doubts = [*simulated(analysis.run), *cautions(analysis.findings)]
    lines = [*verdicts[:1], *_answer(analysis), *verdicts[1:], *doubts]
    yield Section("", answer_lines(lines, following))
    if analysis.block is not None:
        yield from _courses(analysis)
    elif len(analysis.poses) > 1:
        yield Section("", (_table_of_poses(analysis),))
    else:
        yield Section("", (_charted(analysis, analysis.poses[0]),))
    defined = [axis for axis in _shown(analysis).axes.values() if axis.definitions]
    if defined and analysis.block is None:
        yield Section("", (definitions_table(defined),))
    yield Section("", (*_behind(analysis),))
    yield Section("", (Text(_left_behind(analysis.findings), "quiet"),), depth="more")


def _shown(analysis: Analysis) -> PoseResult:
    return largest(analysis.poses)


def _details(analysis: Analysis) -> Iterator[Section]:
    """Yield every figure of each pose, the limits, and what was found."""
    yield from drift_details(analysis)
    poses = poses_in_cycles(analysis)
    for pose in poses:
        label = pose.label or ""
        name = f"pose {label}: " if label else ""
        strips = tuple(_strips(pose)) if len(poses) > 1 else ()
        yield Section(f"{name}repeatability", (*pose_figures(pose), *strips), label)
    if analysis.block is None:
        yield from characteristics(analysis)
    yield from limits(analysis)
    yield from findings(analysis)


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
    text = "; ".join(_caution(code, found) for code, found in by_code.items())
    if len(text) > _LINE:
        names = ", ".join(map(_with_option, by_code))
        text = f"{len(by_code)} warnings: {names}" if len(by_code) > 1 else names
    yield Text(f"! {text}", "warn")


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


def _left_behind(findings: Sequence[Finding]) -> str:
    """Return how much more there is to be read."""
    deviations = sum(bool(one.rule) for one in findings)
    warnings = sum(one.severity != "info" and not one.rule for one in findings)
    others = len(findings) - deviations - warnings
    counted = (
        (warnings, "warning", ""),
        (deviations, "deviation", " from ISO 9283"),
        (others, "remark", ""),
    )
    parts = [f"{k} {name}{'s' if k > 1 else ''}{of}" for k, name, of in counted if k]
    return f"{', '.join(parts) or 'every figure'}: `full=`"


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
    figures = [figure_in_words(*one) for one in headline_figures(pose)]
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
            yield (
                figure_in_words(f"compliance {one.of}", found.value, found.interval, found.unit)
                + at
            )


NamedFigure = tuple[str, float, Ends, str]
"""Name, value, 95 % interval, unit."""


def headline_figures(pose: PoseResult) -> list[NamedFigure]:
    """Return what a robot is bought by: the plane where there is one, then the other axes."""
    plane = [_radial(pose.XY)] if pose.XY is not None else []
    others = [axis for axis in pose.axes.values() if not (plane and axis.name in "XY")]
    return [*plane, *map(_of_axis, others)]


def _radial(XY: RadialResult) -> NamedFigure:
    return "XY", XY.RP, XY.RP_interval, "mm"


def _of_axis(axis: AxisResult) -> NamedFigure:
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


def _courses(analysis: Analysis) -> Iterator[Section]:
    """Yield the strips of a drift test and its figures, without the tables of its blocks."""
    yield from (replace(one, heading="") for one in drift_sections(analysis))
    yield from (replace(one, heading="") for one in characteristics(analysis, advice=False))


def _charted(analysis: Analysis, pose: PoseResult) -> Charted:
    kept = {one.figure: one for one in analysis.limits if one.pose == pose.label}
    rows: list[tuple[tuple[Cell, ...], LimitCheck | None, FloatArray | None]] = []
    for axis in pose.axes.values():
        check = kept.pop(axis.name, None)
        cells = _cells(_of_axis(axis)) if check is None else _checked(check)
        rows.append((cells, check, axis.readings))
    others = sorted(kept.values(), key=lambda one: one.verdict is Conformity.PASS)
    if pose.XY is not None and {one.figure for one in others} == {"XY_eq23"}:
        rows.append((_cells(_radial(pose.XY)), None, None))  # beside the one that decides
    rows += [(_checked(one), one, None) for one in others[:_MOST_OF_NO_AXIS]]
    checks = [check for _, check, _ in rows if check is not None]
    verdict = [_verdict_column(checks)] if checks else []
    drawn = tuple(
        ChartedRow((*cells, *(_verdict(check, heading) for heading in verdict)), readings)
        for cells, check, readings in rows
    )
    units = {str(cells[-1]) for cells, _, _ in rows}
    if len(units) > 1:
        return Charted(("", "RP", "95 % interval", "", *verdict, "over the cycles"), drawn)
    narrow = tuple(ChartedRow((*r.cells[:3], *r.cells[4:]), r.readings) for r in drawn)
    unit = units.pop()
    return Charted(("", f"RP [{unit}]", "95 % interval", *verdict, "over the cycles"), narrow)


def _cells(figure: NamedFigure) -> tuple[Cell, ...]:
    name, value, ends, unit = figure
    return (name, *figure_cells(value, ends, mark="± " if unit == "deg" else ""), unit)


def _checked(check: LimitCheck) -> tuple[Cell, ...]:
    mark = "± " if check.code == "RP_a" else ""
    figures = figure_cells(check.RP, check.interval, limit=check.limit, mark=mark)
    return (check.figure, *figures, check.unit)


def _verdict_column(checks: Sequence[LimitCheck]) -> str:
    """Return the heading of verdicts, with the limit where all of them have the same."""
    limits = {str(limit_cell(check)) for check in checks}
    return f"limit {limits.pop()}" if len(limits) == 1 else "limit"


def _verdict(check: LimitCheck | None, heading: str) -> str:
    if check is None:
        return ""
    limit = "" if heading != "limit" else f", {limit_cell(check)}"
    return f"{VERDICTS[check.verdict]}{limit}"


def _table_of_poses(analysis: Analysis) -> Table:
    """Return a row for each pose, with the strictest of its verdicts where there is room."""
    poses = analysis.poses[:_MOST_POSES]
    figures = [{f"RP {one[0]} [{one[3]}]": one for one in headline_figures(p)} for p in poses]
    narrow = max(map(len, figures)) <= _ROOM_FOR_VERDICTS
    verdict = (_verdict_column(analysis.limits),) if analysis.limits and narrow else ()
    rows: list[dict[str, Cell]] = []
    for pose, found in zip(poses, figures, strict=True):
        checks = [one for one in analysis.limits if one.pose == pose.label]
        strictest = min(checks, key=lambda one: STRICTEST.index(one.verdict), default=None)
        results = {name: _result(one) for name, one in found.items()}
        rows.append(
            {"pose": pose.label or "", **results, **{v: _verdict(strictest, v) for v in verdict}}
        )
    return table_by_name(rows)


def _result(figure: NamedFigure) -> Result:
    _, value, ends, unit = figure
    return Result(*figure_cells(value, ends, mark="± " if unit == "deg" else ""))


def _behind(analysis: Analysis) -> Iterator[Text]:
    """Yield how the table was understood: a wrong unit must be seen, and a lost row."""
    origin = analysis.run.origin
    named = (analysis.run.metadata.get("robot"), origin.source, cycles_in_words(analysis))
    yield Text(" · ".join(filter(None, named)), "quiet")
    if origin.understood:
        yield Text(f"read as {origin.understood}", "quiet")
    notes = (*origin.notes, not_used(analysis.run))
    yield from (Text(note, "quiet") for note in notes if note)


FORCE_LOOP = "a force loop, no test of repeatability"
_GRAVITY = {"error": 0, "warning": 1, "info": 2}


def is_force_loop(analysis: Analysis) -> bool:
    """Return whether a force was stepped to and fro at every pose: RP is no repeatability then."""
    loops = {one.pose for one in analysis.findings if one.code == "force-loop"}
    return analysis.block is None and loops >= {pose.label for pose in analysis.poses}


def force_loop(analysis: Analysis) -> Iterator[Block]:
    """Yield that RP is no repeatability, where a force was stepped."""
    if is_force_loop(analysis):
        yield Text(f"{FORCE_LOOP}: RP counts what the force moves", "bad")


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
    if cycles.discarded:
        left_out = f"the extra cycle {cycles.discarded[0]} is discarded"
    else:
        left_out = "the first was discarded before, none is discarded here"
    return f"{cycles.read} cycles read{each}; {left_out}; {cycles.used} count."


def _strips(pose: PoseResult) -> Iterator[Block]:
    for axis in pose.axes.values():
        caption = f"{axis.readings.min():.7g} .. {axis.readings.max():.7g} {axis.unit}"
        yield Strip(axis.name, pose.cycle, axis.readings, caption)


def findings(analysis: Analysis, *, advice: bool = True) -> Iterator[Section]:
    """Yield the deviations from the standard, and what else was found.

    ``advice`` is for who runs the program, and not for a customer.
    """
    if analysis.deviations:
        rows = sorted({(one.rule, _in_words(one, advice=advice)) for one in analysis.deviations})
        text = tuple(Text(as_deviation(what, rule)) for rule, what in rows)
        yield Section("deviations from ISO 9283", text)
    others = [finding for finding in analysis.findings if not finding.rule]
    others.sort(key=lambda finding: _GRAVITY[finding.severity])
    if others:
        notices = tuple(
            Notice(f.severity, f.code, _subject(f), f.in_full if advice else f.message)
            for f in others
        )
        how = Text("scara-iso explain CODE says more about each", "quiet")
        yield Section("findings", (*notices, how) if advice else notices)


def as_deviation(what: str, rule: str) -> str:
    """Return what deviates from a rule, and the rule: ``Not stated: load [ISO 9283 6.2]``."""
    return f"{what[:1].upper()}{what[1:]} [{rule}]"


def _in_words(finding: Finding, *, advice: bool) -> str:
    subject, text = _subject(finding), finding.in_full if advice else finding.message
    return f"{subject}: {text}" if subject else text


def _subject(finding: Finding) -> str:
    return ", ".join(part for part in (finding.pose, finding.axis) if part)
