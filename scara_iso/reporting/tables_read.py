"""What is said of a table that was read: what each field was taken for, and what was left out.

How far a test is: the matrix of its parts, what is wrong with them, what comes next.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import date

from scara_iso.reporting.blocks import (
    Block,
    Cell,
    Facts,
    Notice,
    Number,
    Report,
    Section,
    Table,
    Text,
)
from scara_iso.reporting.stated import not_used
from scara_iso.run import Run, TableField
from scara_iso.testfolder import Folder, PartState, about, lacking, seconds_left

_MOST = 100


def table_report(run: Run) -> Report:
    """Return what was understood of the table, or of the tables, that ``run`` was read from."""
    origin = run.origin
    sections = [Section("", (Text(f"read: {origin.source}", "strong"), Text(origin.understood)))]
    if stated := tuple(_stated(run)):
        sections.append(Section("stated in the file", (Facts(stated),)))
    if origin.fields:
        sections.append(
            Section(
                f"fields, by the header of {origin.row_name} {origin.header_line}"
                if origin.header_line
                else "fields",
                (_fields(run),),
            )
        )
    sections.append(Section("left out, and remarks", tuple(_notes(run))))
    return tuple(sections)


def _stated(run: Run) -> Iterator[tuple[str, str]]:
    for name, axis in run.axes.items():
        sizes = {"resolution": axis.resolution, "indicator_uncertainty": axis.uncertainty}
        yield from ((f"{key}_{name}", f"{x:g} {axis.unit}") for key, x in sizes.items() if x)
    yield from run.metadata.items()


def _fields(run: Run) -> Table:
    rows = [_row(k, one, run) for k, one in enumerate(run.origin.fields, start=1)]
    row = run.origin.row_name
    lines = "" if run.lines is None else f" ({row} {run.lines[0]}, {row} {run.lines[-1]})"
    note = f"first and last row{lines}: readings in mm, or degrees"
    return Table(("field", "header", "taken for", "in", "first", "last"), tuple(rows), note)


def _row(k: int, one: TableField, run: Run) -> tuple[Cell, ...]:
    taken = f"{one.kind} {one.name}" if one.name and one.kind != "covariate" else one.kind
    return (str(k), one.header or "(none)", taken, one.unit, *_ends(one, run))


def _ends(one: TableField, run: Run) -> tuple[Cell, Cell]:
    if one.kind == "axis":
        readings = run.axes[one.name].readings
        return Number(float(readings[0]), ".9g"), Number(float(readings[-1]), ".9g")
    labels = {"cycle": run.cycle, "pose": run.pose, "direction of approach": run.direction}
    found = labels.get(one.kind, run.covariates.get(one.name))
    return ("", "") if found is None else (str(found[0]), str(found[-1]))


def _notes(run: Run) -> Iterator[Block]:
    notes = tuple(filter(None, (not_used(run), *run.origin.notes)))
    yield from (Text(note) for note in notes[:_MOST])
    if len(notes) > _MOST:
        yield Text(f"and {len(notes) - _MOST} more", "quiet")
    if not notes:
        yield Text("nothing: every row under the header is a reading")


def status_report(folder: Folder, today: date) -> Report:
    """Return the states of a test's parts as a table of poses and conditions, and what is next.

    Calibrations are to hold on the day of the test, or ``today`` where none is stated.
    """
    title = f"Test of {folder.test.robot.name or folder.path.name}"
    head = (*_in_words(folder), *_past_due(folder, today))
    return (
        Section(title, (*head, _matrix(folder), *_other_tests(folder))),
        *_listed("Struck", _struck(folder)),
        *_listed("Out of its conditions", _deviations(folder)),
        *_listed("Faulty", [f"{one.part.name}: {one.why}" for one in folder.parts if one.why]),
        *_listed("Planned, and not measured", list(folder.unmeasured)),
        *_listed("Not part of the test", list(folder.foreign)),
    )


def missing_report(what: str, missing: tuple[str, ...]) -> Report:
    """Return the report on a condition of which no part is recorded."""
    return (Section(what, (Text(f"nothing to analyse yet; missing: {', '.join(missing)}"),)),)


def _past_due(folder: Folder, today: date) -> Iterator[Block]:
    day = folder.test.schedule.date or today
    for axis, one in folder.test.instruments.items():
        if one.calibration_due is not None and one.calibration_due < day:
            text = f"calibration_due {one.calibration_due} is past: calibrate it, or use another"
            yield Notice("warning", "calibration-date", axis, text)


def _matrix(folder: Folder) -> Table:
    conditions = folder.test.conditions()
    columns = [[_cell(state) for state in folder.under(condition)] for condition in conditions]
    rows = tuple(zip(folder.test.poses, *columns, strict=True))
    return Table(("pose", *(condition.name for condition in conditions)), rows)


def _other_tests(folder: Folder) -> Iterator[Block]:
    if folder.other_tests:
        rows = tuple((state.part.name, _cell(state)) for state in folder.other_tests)
        yield Table(("other tests", ""), rows)


def _cell(state: PartState) -> str:
    if state.recording is None or state.is_whole or state.why:
        return state.state
    done, wanted = state.recording.cycles
    return f"{done} of {wanted} cycles"


def _in_words(folder: Folder) -> Iterator[Block]:
    whole = sum(state.is_whole for state in folder.parts)
    yield Text(f"{whole} of {len(folder.parts)} parts are recorded")
    following = folder.next
    if following is None:
        faulty = [state for state in folder.parts if state.why]
        yield Text("Nothing is missing" + (", but parts are faulty" if faulty else ""), "strong")
        now = _mend(folder, faulty[0]) if faulty else f"scara-iso report {folder.path}"
        yield Text(f"Now: {now}")
        return
    left = seconds_left(folder)
    pace = f", {about(left)} left at the pace so far" if left is not None else ""
    yield Text(f"Next: {lacking(following)}{pace}", "strong")
    if following.part.is_push:
        yield Text(f"Now: write force_N and reading into {folder.path / following.part.name}.csv")
    else:
        yield Text(f"Now: scara-iso record {folder.path} `gauge=AXIS=DRIVER@PORT`")


def _mend(folder: Folder, state: PartState) -> str:
    if state.part.is_push:
        return f"correct {folder.path / state.part.name}.csv"
    again = f"scara-iso record {folder.path} `part={state.part.name}` `repeat='the reason'`"
    return f"correct what is named below, or {again} `gauge=AXIS=DRIVER@PORT`"


def _struck(folder: Folder) -> list[str]:
    return [f"{s.recording}: {s.reason}" for state in folder.parts for s in state.struck]


def _deviations(folder: Folder) -> list[str]:
    return [
        f"{state.part.name}: {finding.message} [{finding.code}]"
        for state in folder.parts
        for finding in state.deviations
    ]


def _listed(heading: str, lines: list[str]) -> Iterator[Section]:
    if lines:
        yield Section(heading, tuple(Text(line) for line in lines))
