"""The report on an analysis: the verdict first, the findings last.

The report on the characteristics that no pose's own tables show.

The figures of several poses side by side: one row a pose.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scara_iso.iso9283 import (
    CYCLES_USED,
    Analysis,
    AxisResult,
    Characteristic,
    Finding,
    PoseResult,
    RadialResult,
    poses_in_cycles,
)
from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Notice,
    Number,
    Report,
    Section,
    Strip,
    Table,
    Text,
    U_of_scatter,
    interval,
    rounded,
    table_by_name,
)
from scara_iso.reporting.drift import drift_sections, drift_verdict
from scara_iso.reporting.limits import conformity, limits
from scara_iso.reporting.uncertainty import U_of_mean, U_of_RP

_OF_A_POSE = ("AP", "RP", "RP_a", "RP_rss")


def characteristics(analysis: Analysis, *, advice: bool = True) -> Iterator[Section]:
    """Yield one table of them, where there is one; ``advice`` names the command that explains."""
    found = [one for one in analysis.characteristics if one.code not in _OF_A_POSE]
    if found:
        yield Section("characteristics", (characteristics_table(found, advice=advice),))


def characteristics_table(found: Sequence[Characteristic], *, advice: bool = True) -> Table:
    """Return a table of characteristics."""
    header = ("characteristic", "pose", "of", "figure", "95 % interval", "n", "in")
    how = "scara-iso explain CODE says more about each" if advice else ""
    return Table(header, tuple(_row(one) for one in found), how)


def _row(found: Characteristic) -> tuple[Cell, ...]:
    estimate = found.estimate
    ends = estimate.interval
    U = U_of_scatter(estimate.value, estimate.n) if ends is None else (ends[1] - ends[0]) / 2
    return (
        f"{found.code} ({estimate.clause})",
        found.pose or "",
        found.of,
        rounded(estimate.value, U),
        interval(ends),
        Number(estimate.n),
        estimate.unit,
    )


def poses_table(poses: Sequence[PoseResult]) -> Table:
    """Return RP of every axis and plane of each pose, and AP where every pose has one."""
    columns = [_column(poses, name) for name in poses[0].axes]
    columns += [*_plane(poses), *_accuracy_columns(poses)]
    rows = zip(
        [pose.label or "" for pose in poses],
        [len(pose.rows) for pose in poses],
        *(cells for _, cells in columns),
        strict=True,
    )
    units = {axis.unit for axis in poses[0].axes.values()}
    note = f"RP in mm{', of an angle ± 3 s in deg' if 'deg' in units else ''}"
    return Table(("pose", "n", *(name for name, _ in columns)), tuple(rows), note)


_Column = tuple[str, list[Cell]]


def _column(poses: Sequence[PoseResult], name: str) -> _Column:
    return name, [_figure(pose.axes[name]) for pose in poses]


def _figure(axis: AxisResult) -> Cell:
    if axis.unit == "deg":
        return rounded(axis.three_sigma, U_of_scatter(axis.three_sigma, axis.n))
    return rounded(axis.RP, U_of_RP(axis, axis.n))


def _plane(poses: Sequence[PoseResult]) -> list[_Column]:
    """Return RP in XY with its interval; without a plane, the interval of the only axis."""
    planes = [(pose.XY, len(pose.rows)) for pose in poses if pose.XY is not None]
    if len(planes) == len(poses):
        ends: list[Cell] = [interval(XY.RP_interval) for XY, _ in planes]
        return [
            ("XY radial", [rounded(XY.RP, U_of_RP(XY, n)) for XY, n in planes]),
            ("95 % interval", ends),
        ]
    axes = [axis for pose in poses for axis in pose.axes.values()]
    if len(axes) > len(poses):
        return []
    found = [a.three_sigma_interval if a.unit == "deg" else a.RP_interval for a in axes]
    return [("95 % interval", [interval(one) for one in found])]


def _accuracy_columns(poses: Sequence[PoseResult]) -> list[_Column]:
    found = [
        rounded(pose.XY.accuracy, max(U_of_mean(pose.axes[axis]) for axis in "XY"))
        for pose in poses
        if pose.XY is not None and pose.XY.accuracy is not None
    ]
    return [("AP XY", [*found])] if len(found) == len(poses) else []


_NAMED_FIRST = 5
"""So many warnings are named at the top; of more, their number is said there."""
FORCE_LOOP = "a force loop, no test of repeatability"
_GRAVITY = {"error": 0, "warning": 1, "info": 2}


def analysis_report(analysis: Analysis) -> Report:
    """Return the report on an analysis."""
    sections = [Section("", (*_origin(analysis), *verdict(analysis)))]
    sections += drift_sections(analysis)
    for pose in poses_in_cycles(analysis):
        label = pose.label or ""
        name = f"pose {label}: " if label else ""
        sections.append(Section(f"{name}repeatability", tuple(pose_figures(pose)), label))
        sections.append(Section(f"{name}readings over the cycles", tuple(_strips(pose)), label))
    return (*sections, *characteristics(analysis), *limits(analysis), *findings(analysis))


def _origin(analysis: Analysis) -> Iterator[Block]:
    origin = analysis.run.origin
    title = " · ".join(part for part in (analysis.run.metadata.get("robot"), origin.source) if part)
    yield Text(f"ISO 9283 repeatability{f' of {title}' if title else ''}", "strong")
    if origin.understood:
        yield Text(f"read as {origin.understood}", "quiet")
    yield from (Text(note, "quiet") for note in origin.notes)


def verdict(analysis: Analysis) -> Iterator[Block]:
    """Yield the figure that the test is about, warnings, and whether limits are kept."""
    yield from force_loop(analysis)
    if analysis.block is not None:
        yield from drift_verdict(analysis)
    elif len(analysis.poses) == 1:
        yield Text(_headline(analysis.poses[0]), "strong")
    else:
        yield Text(_largest(analysis.poses), "strong")
        yield poses_table(analysis.poses)
    yield from _warnings(analysis)
    yield Text(cycles_said(analysis))
    yield from conformity(analysis)


def is_force_loop(analysis: Analysis) -> bool:
    """Return whether a force was stepped to and fro at every pose: RP is no repeatability then."""
    loops = {one.pose for one in analysis.findings if one.code == "force-loop"}
    return analysis.block is None and loops >= {pose.label for pose in analysis.poses}


def force_loop(analysis: Analysis) -> Iterator[Block]:
    """Yield that RP is no repeatability, where a force was stepped."""
    if is_force_loop(analysis):
        yield Text(f"{FORCE_LOOP}: RP counts what the force moves", "bad")


def _warnings(analysis: Analysis) -> Iterator[Block]:
    grave = [finding for finding in analysis.findings if finding.severity != "info"]
    by_subject: dict[str, list[str]] = {}
    for finding in grave:
        by_subject.setdefault(_subject(finding) or "test", []).append(finding.code)
    if grave:
        said = "; ".join(f"{name}: {', '.join(codes)}" for name, codes in by_subject.items())
        count = f"{len(grave)} warning{'s' if len(grave) > 1 else ''}"
        yield Text(f"{count} - {said}" if len(grave) <= _NAMED_FIRST else f"{count}, below", "warn")


def cycles_said(analysis: Analysis) -> str:
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


def _headline(pose: PoseResult) -> str:
    if pose.XY is None:
        return f"RP: {', '.join(_axis_verdict(axis) for axis in pose.axes.values())}"
    U = U_of_RP(pose.XY, len(pose.rows))
    radial = f"RP in XY: {rounded(pose.XY.RP, U)} mm radial (ISO 9283)"
    rss = pose.XY.RP_rss
    return radial if rss is None else f"{radial}, {rounded(rss, U)} mm by the paper's eq. 23"


def _axis_verdict(axis: AxisResult) -> str:
    if axis.unit == "deg":
        return f"{axis.name} ± {_of_scatter(axis.three_sigma, axis.n)} deg"
    return f"{axis.name} {rounded(axis.RP, U_of_RP(axis, axis.n))} mm"


def _largest(poses: Sequence[PoseResult]) -> str:
    def figure(pose: PoseResult) -> float:
        if pose.XY is not None:
            return pose.XY.RP
        return max(_lengths(pose) or [axis.three_sigma for axis in pose.axes.values()])

    worst = max(poses, key=figure)
    return f"{len(poses)} poses; the largest figure at {worst.label}: {_headline(worst)}"


def pose_figures(pose: PoseResult) -> Iterator[Block]:
    """Yield the tables of a pose: RP of axes, plane and space, accuracy, other words."""
    for unit in ("mm", "deg"):
        axes = [axis for axis in pose.axes.values() if axis.unit == unit]
        if axes:
            yield _axes_table(pose, axes, unit)
    yield from (Text(line) for line in _accuracy(pose))
    for axis in pose.axes.values():
        if axis.angle is not None:
            yield Text(
                f"theta at a radius of {axis.angle.radius_mm:g} mm: RP = ± "
                f"{_of_scatter(axis.angle.three_sigma_deg, axis.n)} deg (7.2.2, ± 3 S); "
                f"{_of_scatter(axis.angle.RP_deg, axis.n)} deg by eq. 2-6"
            )
    defined = [axis for axis in pose.axes.values() if axis.definitions]
    if defined:
        yield definitions_table(defined)


def _axes_table(pose: PoseResult, axes: Sequence[AxisResult], unit: str) -> Table:
    rows = [_axis_row(axis) for axis in axes]
    rows += [] if unit == "deg" else _radial_rows(pose)
    rule = "; an angle's RP is ± 3 s (7.2.2)" if unit == "deg" else ""
    note = f"in {unit}; n = {axes[0].n}; RP = l_bar + 3 S_l (eq. 2-6){rule}; U = 2 u"
    return table_by_name(rows, note)


def _axis_row(axis: AxisResult) -> dict[str, Cell]:
    """Return the row of an axis by column; of an angle, ± 3 s and its own interval."""
    angle = axis.unit == "deg"
    three_sigma: Cell = _of_scatter(axis.three_sigma, axis.n)
    return {
        "axis": axis.name,
        "mean": rounded(axis.mean, U_of_mean(axis)),
        **_parts(axis, axis.n),
        **({"± 3 s": three_sigma} if angle else {}),
        "95 % interval": interval(axis.three_sigma_interval if angle else axis.RP_interval),
        **({} if angle else {"3 s": three_sigma}),
        "U/3 s" if angle else "U/RP": _share(axis.expanded_ratio),
    }


def _radial_rows(pose: PoseResult) -> Iterator[dict[str, Cell]]:
    n = len(pose.rows)
    for name, found in (("XY", pose.XY), ("XYZ", pose.XYZ)):
        if found is None:
            continue
        yield {
            "axis": f"{name} radial",
            **_parts(found, n),
            "95 % interval": interval(found.RP_interval),
            "U/RP": _share(found.expanded_ratio),
        }
        if found.RP_rss is not None:
            yield {
                "axis": f"{name} eq. 23",
                "RP": rounded(found.RP_rss, U_of_RP(found, n)),
                "95 % interval": interval(found.RP_rss_interval),
            }


def _parts(found: AxisResult | RadialResult, n: int) -> dict[str, Cell]:
    """Return l_bar, S_l and RP to the same place; the appendix of a report has all digits."""
    U = U_of_RP(found, n)
    return {
        "l_bar": rounded(found.l_bar, U),
        "S_l": rounded(found.S_l, U),
        "RP": rounded(found.RP, U),
    }


def _of_scatter(figure: float, n: int) -> Number:
    return rounded(figure, U_of_scatter(figure, n))


def _accuracy(pose: PoseResult) -> Iterator[str]:
    said = [
        f"{axis.name} {rounded(axis.accuracy, U_of_mean(axis), sign='+')} {axis.unit}"
        for axis in pose.axes.values()
        if axis.accuracy is not None
    ]
    for name, found in (("XY", pose.XY), ("XYZ", pose.XYZ)):
        if found is not None and found.accuracy is not None:
            U = max(U_of_mean(pose.axes[axis]) for axis in name)
            said.append(f"{name} {rounded(found.accuracy, U)} mm")
    if said:
        yield f"accuracy AP (7.2.1, mean minus command): {', '.join(said)}"


def definitions_table(axes: Sequence[AxisResult]) -> Table:
    """Return other definitions of repeatability, a column for each axis."""
    scatter = [U_of_scatter(axis.three_sigma, axis.n) for axis in axes]
    rows = [
        (found[0].name, *(rounded(d.value, U) for d, U in zip(found, scatter, strict=True)))
        for found in zip(*(axis.definitions for axis in axes), strict=True)
    ]
    header = ("other words", *(f"{axis.name} [{axis.unit}]" for axis in axes))
    meanings = "; ".join(f"{d.name}: {d.meaning}" for d in axes[0].definitions)
    return Table(header, tuple(rows), meanings)


def _strips(pose: PoseResult) -> Iterator[Block]:
    for axis in pose.axes.values():
        caption = f"{axis.readings.min():.7g} .. {axis.readings.max():.7g} {axis.unit}"
        yield Strip(axis.name, pose.cycle, axis.readings, caption)


def findings(analysis: Analysis, *, advice: bool = True) -> Iterator[Section]:
    """Yield the deviations from the standard, and what else was found.

    ``advice`` is for who runs the program, and not for a customer.
    """
    if analysis.deviations:
        rows = sorted({(one.rule, _said(one, advice=advice)) for one in analysis.deviations})
        said = tuple(Text(f"{rule} - {what}") for rule, what in rows)
        yield Section("deviations from ISO 9283", said)
    others = [finding for finding in analysis.findings if not finding.rule]
    others.sort(key=lambda finding: _GRAVITY[finding.severity])
    if others:
        notices = tuple(
            Notice(f.severity, f.code, _subject(f), f.said if advice else f.message) for f in others
        )
        how = Text("scara-iso explain CODE says more about each", "quiet")
        yield Section("findings", (*notices, how) if advice else notices)


def _said(finding: Finding, *, advice: bool) -> str:
    subject, said = _subject(finding), finding.said if advice else finding.message
    return f"{subject}: {said}" if subject else said


def _subject(finding: Finding) -> str:
    return ", ".join(part for part in (finding.pose, finding.axis) if part)


def _share(ratio: float | None) -> Number | str:
    return "" if ratio is None else Number(ratio, ".0%")


def _lengths(pose: PoseResult) -> list[float]:
    """Return RP of the length axes, or what may hide behind an RP of 0."""
    axes = [axis for axis in pose.axes.values() if axis.unit == "mm"]
    return [a.RP or (a.RP_interval[1] if a.RP_interval else 0.0) for a in axes]
