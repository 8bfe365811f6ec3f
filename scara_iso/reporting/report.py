"""The test report on paper: page 1 decides, figures and diagnosis follow, then all else.

The appendix is for who checks it: every value up to RP, and every reading as it was read.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from decimal import Decimal

import numpy as np

from scara_iso.diagnosis import Diagnosis
from scara_iso.iso9283 import (
    Analysis,
    AxisResult,
    Finding,
    PoseResult,
    RadialResult,
    not_measured,
    poses_in_cycles,
)
from scara_iso.reporting.analysis import (
    FORCE_LOOP,
    as_deviation,
    cycles_in_words,
    findings,
    is_force_loop,
    subject_of,
)
from scara_iso.reporting.backlash import backlash_report
from scara_iso.reporting.diagnosis import diagnosis_report
from scara_iso.reporting.dossier import Dossier, Provenance
from scara_iso.reporting.languages import in_parts, labels_of, translated
from scara_iso.reporting.named_effects import found_in_words, interpretation
from scara_iso.reporting.pictures import courses, drift_pictures, planes, predictions, push_picture
from scara_iso.reporting.shared.blocks import (
    Block,
    Document,
    Facts,
    Report,
    Section,
    Signature,
    Table,
    Text,
    ended,
    in_form,
    note,
)
from scara_iso.reporting.shared.digits import Cell, Number, decimals, few, numbers, words
from scara_iso.reporting.shared.figures import budget_blocks, characteristics, pose_figures
from scara_iso.reporting.shared.limits import conformity, result_tables, rule_of, table_of_limits
from scara_iso.reporting.shared.stated import conditions, not_stated, parties, remarks, stated_field
from scara_iso.reporting.signals import push_report
from scara_iso.run import Axis, FloatArray, IntArray, Origin, Run

SCOPE = (
    "The results relate only to the item tested (ISO/IEC 17025:2017, 7.8.2.1 l). The report is "
    "copied in full only, unless the laboratory agrees."
)
_MOST_LINES = 8
_MOST_NAMED = 4
_MORE_PLACES = 1
"""Than show three digits of the finest dial's step: sums then agree to the last one printed."""


def front_page(dossier: Dossier) -> Iterator[Block]:
    """Yield who tested what for whom, the result, the rule, what deviates, what was found."""
    analysis, amendment, run = dossier.analysis, dossier.amendment, dossier.analysis.run
    yield Text(_subject(analysis), "strong")
    yield Text(run.simulated, "bad")
    if amendment is not None:
        superseded = f"This report supersedes report {amendment.supersedes}."
        yield Text(f"{superseded} Reason: {amendment.reason}", "strong")
    yield from parties(run)
    loop = f"{FORCE_LOOP}: RP counts what the force moves"
    yield Text(loop if is_force_loop(analysis) else "", "bad")
    yield from conformity(analysis)
    yield from result_tables(dossier.parts)
    yield Text(rule_of(analysis.limits))
    yield Text(f"Method: {stated_field(run, 'method')}. {cycles_in_words(analysis)}")
    yield from _deviations(analysis)
    yield Text(_remarks(analysis), "warn")
    yield Text(found_in_words(dossier.diagnoses, dossier.together))
    missing = not_stated(run)
    lacking = few(missing, _MOST_NAMED)
    where = ", under Conditions and instruments" if len(missing) > _MOST_NAMED else ""
    yield Text(f"Not stated: {lacking}{where}." if lacking else "", "quiet")
    yield Text(SCOPE, "quiet")
    authorized = stated_field(run, "authorized by")
    name = f"name, signature: {authorized}" if authorized else "name, signature"
    yield Signature(("place, date", name))


def _subject(analysis: Analysis) -> str:
    serial = stated_field(analysis.run, "serial number")
    item, of = stated_field(analysis.run, "item"), f", serial {serial}" if serial else ""
    what = "Static compliance" if is_force_loop(analysis) else "Repeatability"
    if not item:
        return f"{what} by ISO 9283:1998. Robot: not stated{of}"
    return f"{what} of {item}{of}, by ISO 9283:1998"


def _deviations(analysis: Analysis) -> Iterator[Text]:
    by_rule: dict[str, list[Finding]] = {}
    for finding in analysis.deviations:
        by_rule.setdefault(finding.rule, []).append(finding)
    yield Text("Deviations:" if by_rule else "", "strong")
    for _, found in sorted(by_rule.items())[:_MOST_LINES]:
        texts = list(dict.fromkeys(map(as_deviation, found)))
        more = f", and {len(texts) - 1} more in the appendix" if len(texts) > 1 else ""
        yield Text(f"{texts[0]}{more}")
    left = len(by_rule) - _MOST_LINES
    yield Text(f"and {left} more in the appendix" if left > 0 else "")


def _remarks(analysis: Analysis) -> str:
    by_code: dict[str, list[str]] = {}
    for one in analysis.findings:
        if one.severity != "info" and not one.rule:
            by_code.setdefault(one.code, []).extend(filter(None, [subject_of(one, " ")]))
    parts = [
        f"{words(code)} ({few(at, _MOST_NAMED)})" if at else words(code)
        for code, at in by_code.items()
    ]
    axes = [subject_of(one, " ") for one in analysis.findings if one.voids_interval]
    moved = few(list(dict.fromkeys(axes)), _MOST_NAMED)
    void = f" The intervals that include {moved} do not hold: the readings moved." if moved else ""
    named = f"Warnings, explained in the appendix: {'; '.join(parts)}." if parts else ""
    return named + void


def document(dossier: Dossier) -> Document:
    """Return the whole report of a test, its labels in the language of the dossier."""
    run, labels = dossier.analysis.run, labels_of(dossier.language)
    number = stated_field(run, "report number")
    of_readings = f"of the readings {dossier.provenance.files[0].sha256[:8]}"
    title = f"Test report {number or of_readings}"
    sections = ended(tuple(_sections(dossier)), title)
    return Document(
        in_parts(title, labels),
        tuple(translated(sections, labels)),
        dossier,
        simulated=bool(run.simulated) or dossier.other_tests.simulated,
        language=dossier.language,
    )


def _sections(dossier: Dossier) -> Iterator[Section]:
    analysis, found, others = dossier.analysis, dossier.diagnoses, dossier.other_tests
    yield Section("", tuple(front_page(dossier)))
    if analysis.block is None:
        yield Section("Figures", (*planes(analysis), *courses(analysis)), new_page=True)
    yield from drift_pictures(analysis)
    yield from () if others.drift is None else drift_pictures(others.drift)
    for name, pushed in others.pushes.items():
        shown = in_form(push_report(pushed), "page")
        pushes = [block for section in shown for block in section.blocks]
        yield Section(_of_part("Push test", name), (*pushes, push_picture(pushed)))
    if found:
        diagnosed = {pose: d for pose, d in found.items() if isinstance(d, Diagnosis)}
        blocks = (*interpretation(found), *predictions(diagnosed, analysis.poses))
        yield Section("Diagnosis: opinions and interpretations", blocks)
    lacking = ", ".join(not_stated(analysis.run))
    missing = Text(f"Not stated: {lacking}" if lacking else "", "quiet")
    stated = (*conditions(analysis.run, analysis.cycles), missing, *_struck(analysis))
    yield Section("Conditions and instruments", stated)
    yield Section("Uncertainty budget", tuple(budget_blocks(analysis)))
    first, *rest = _appendix(dossier)
    yield replace(first, heading=f"Appendix: {_begun(first.heading)}", new_page=True)
    yield from (replace(section, heading=_begun(section.heading)) for section in rest)


def _begun(heading: str) -> str:
    return heading[:1].upper() + heading[1:]


def _appendix(dossier: Dossier) -> Iterator[Section]:
    analysis, others, made = dossier.analysis, dossier.other_tests, dossier.provenance
    poses = poses_in_cycles(analysis)
    yield from filter(lambda one: one.blocks, findings(analysis, advice=False))
    for pose in poses:
        yield Section(_at_pose("Repeatability", pose), tuple(pose_figures(pose)))
    if analysis.block is None:
        yield characteristics(analysis, advice=False)
    yield from table_of_limits(analysis.limits)
    yield from _diagnoses(dossier)
    yield from _gears(dossier)
    for pose in poses:
        yield Section(_at_pose("Intermediate values", pose), tuple(_intermediates(pose)))
        yield Section(_at_pose("Deviations of each cycle", pose), (_by_cycle(pose),))
    for pose in analysis.poses:
        yield Section(_at_pose("Raw data", pose), (_raw_data(analysis, pose),), raw=True)
    if others.drift is not None:
        of_drift = conditions(others.drift.run, others.drift.cycles)
        yield Section("Conditions of the drift test", of_drift)
        for pose in others.drift.poses:
            raw_data = (_raw_data(others.drift, pose),)
            yield Section("Raw data of the drift test", raw_data, raw=True)
    for name, pushed in others.pushes.items():
        steps = {
            "step": numbers(range(1, len(pushed.loop.force) + 1)),
            "force [N]": numbers(pushed.loop.force, ".12g"),
            "reading [mm]": numbers(pushed.loop.reading, ".12g"),
        }
        heading = _of_part("Raw data of the push test", name)
        yield Section(heading, (Table.in_columns(steps),), raw=True)
    of_the_standard = [one for one in not_measured(analysis) if one.clause[0].isdigit()]
    of_the_standard.sort(key=lambda one: [*map(int, re.findall(r"\d+", one.clause))])
    missing = "; ".join(f"{one.clause} {one.name}" for one in of_the_standard)
    yield Section("Not measured, by clause of ISO 9283:1998", (Text(f"{missing}."),))
    yield Section("Provenance", tuple(_provenance(made, analysis.run.origin)))


def _diagnoses(dossier: Dossier) -> Iterator[Section]:
    for pose in poses_in_cycles(dossier.analysis):
        one = dossier.diagnoses.get(pose.label)
        for section in diagnosis_report(one) if isinstance(one, Diagnosis) else ():
            if section.depth == "detail":
                yield Section(_at_pose(f"Diagnosis: {section.heading}", pose), section.blocks)


def _gears(dossier: Dossier) -> Iterator[Section]:
    poses: Sequence[PoseResult] = poses_in_cycles(dossier.analysis)
    actual = poses[0] if len(poses) == 1 else None
    for joint, (gearbox, arm) in dossier.gearboxes.items():
        opening, *others = backlash_report(gearbox.backlash(arm), actual)
        reach = f"Joint to tool: {arm:g} m, the arm stretched, as in the paper." if arm else ""
        blocks = (*opening.blocks[1:], Text(reach, "quiet"))
        yield Section(f"Backlash of joint {joint}", blocks)
        for section in others:
            named = section.heading and f"Backlash of joint {joint}: {section.heading}"
            yield Section(named, section.blocks)


def _struck(analysis: Analysis) -> Iterator[Block]:
    line = remarks(analysis.run)
    headed = {
        "Readings that were struck and taken again:": [t for kind, t in line if kind == "struck"],
        "Remarks of the recording:": [f"{kind}: {t}" for kind, t in line if kind != "struck"],
    }
    for heading, lines in headed.items():
        yield Text(heading if lines else "", "strong")
        yield from map(Text, lines)


def _provenance(made: Provenance, origin: Origin) -> Iterator[Block]:
    rows = [
        row
        for file in made.files
        for row in ((file.role, file.name), (f"SHA-256 of the {file.role}", file.sha256))
    ]
    rows += [("program", f"scara-iso {made.version}"), ("command", made.command)]
    rows += [("stated for the report", str(one)) for one in made.restated]
    if origin.understood:
        rows.append(("the table was read as", origin.understood))
    yield Facts(tuple(rows))
    yield from (Text(note, "quiet") for note in origin.notes)


def _intermediates(pose: PoseResult) -> Iterator[Block]:
    places = _places(pose)
    rows = [
        {"figure": name, **_sums(one, places, len(pose.rows))} for name, one in pose.figures.items()
    ]
    yield Table.by_name(rows, note("sums"))
    for axis in pose.axes.values():
        if axis.unit == "deg":
            S, RP = numbers((axis.three_sigma / 3, axis.three_sigma), f".{places}f")
            angle: dict[str, Cell] = {"angle": axis.name, "S [deg]": S, "RP = ± 3 S [deg]": RP}
            yield Table.by_name([angle], "7.2.2, S with n - 1")


def _sums(found: AxisResult | RadialResult, places: int, n: int) -> dict[str, Cell]:
    spec, unit, mean = f".{places}f", "mm", None
    if isinstance(found, AxisResult):
        n, unit, mean = found.n, found.unit, found.mean
    return {
        "unit": unit,
        "n": Number(n),
        "sum": "" if mean is None else Number(n * mean, spec),
        "mean": "" if mean is None else Number(mean, spec),
        "sum of l_j": Number(n * found.l_bar, spec),
        "l_bar": Number(found.l_bar, spec),
        "sum of (l_j - l_bar)²": Number((n - 1) * found.S_l**2, ".6g"),
        "S_l": Number(found.S_l, spec),
        "RP = l_bar + 3 S_l": Number(found.RP, spec),
    }


def _by_cycle(pose: PoseResult) -> Table:
    places = _places(pose)
    off = {name: axis.readings - axis.mean for name, axis in pose.axes.items()}
    columns = {"cycle": numbers(pose.cycle)}
    for name, axis in pose.axes.items():
        columns[f"{name} - mean [{axis.unit}]"] = numbers(off[name], f"+.{places}f")
    for name in ("XY", "XYZ"):
        if name in pose.figures:
            distances = np.linalg.norm([off[axis] for axis in name], axis=0)
            columns[f"l_j {name} [mm]"] = numbers(distances, f".{places}f")
    return Table.in_columns(columns, "l_j of an axis is the deviation without its sign")


def _places(pose: PoseResult) -> int:
    steps = [axis.resolution or axis.three_sigma for axis in pose.axes.values()]
    return decimals([step for step in steps if step]) + _MORE_PLACES


_Cells = dict[str, list[Number] | list[str]]


def readings_report(run: Run) -> Report:
    """Return every row of a run; lengths in mm, angles in degrees."""
    poses: _Cells = {} if run.pose is None else {"pose": run.pose.tolist()}
    columns = {**poses, **_columns(run, np.arange(len(run)))}
    return (Section(run.origin.source, (Text(run.origin.understood), _table(run, columns))),)


def _raw_data(analysis: Analysis, pose: PoseResult) -> Table:
    """Return every row of a pose, the discarded ones marked; lengths in mm, angles in degrees."""
    run = analysis.run
    rows = dict(run.rows_by_pose())[pose.label]
    counted = set(pose.rows.tolist())
    counts = ["yes" if row in counted else "discarded" for row in rows.tolist()]
    return _table(run, {**_columns(run, rows), "counts": counts})


def _columns(run: Run, rows: IntArray) -> _Cells:
    columns: _Cells = {}
    for name, counted in (("line", run.lines), ("cycle", run.cycle)):
        if counted is not None:
            columns[name] = numbers(counted[rows])
    for axis in run.axes.values():
        columns[f"{axis.name} [{axis.unit}]"] = _digits(axis, axis.readings[rows])
    for axis in run.axes.values():
        if axis.displayed is not None:
            name = f"{axis.name} displayed [{axis.unit}]"
            columns[name] = _digits(axis, axis.displayed[rows])
    for name, values in run.covariates.items():
        columns[name] = numbers(values[rows], ".12g")
    return columns


def _table(run: Run, columns: _Cells) -> Table:
    note = "" if run.lines is None else f"line: where the row stands in {run.origin.source}"
    return Table.in_columns(columns, note)


def _digits(axis: Axis, values: FloatArray) -> list[Number]:
    """Return readings with the digits of the dial, or with all where those do not hold them."""
    if axis.resolution is None:
        return numbers(values, ".12g")
    places = max(0, -int(Decimal(repr(axis.resolution)).normalize().as_tuple().exponent))
    exact = f".{places}f"
    return [Number(v, exact if round(v, places) == v else ".12g") for v in values.tolist()]


def _at_pose(heading: str, pose: PoseResult) -> str:
    return heading if pose.label is None else f"{heading} at pose {pose.label}"


def _of_part(heading: str, name: str) -> str:
    joint = name.partition("-")[2]
    return f"{heading} of {joint}" if joint else heading
