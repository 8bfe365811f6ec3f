"""What is said of a table that was read: what each field was taken for, and what was left out.

How far a test is: the matrix of its parts, what is wrong with them, what comes next.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import date

from scara_iso.reporting.blocks import (
    Block,
    Columns,
    Facts,
    NextStep,
    Notice,
    Report,
    Section,
    Table,
    Text,
)
from scara_iso.reporting.digits import Cell, Number
from scara_iso.reporting.stated import left_unused
from scara_iso.run import Run, TableField
from scara_iso.testfolder import Folder, PartState, about, lacking, seconds_left


def table_report(run: Run) -> Report:
    """Return what was understood of the table, or of the tables, that ``run`` was read from."""
    origin = run.origin
    stated = [
        (f"{key}_{name}", f"{size:g} {axis.unit}")
        for name, axis in run.axes.items()
        for key, size in (
            ("resolution", axis.resolution),
            ("indicator_uncertainty", axis.uncertainty),
        )
        if size
    ]
    header = f", by the header of {origin.row_name} {origin.header_line}"
    left_out = left_unused(run) or ("nothing: every row under the header is a reading",)
    return (
        Section("", (Text(f"read: {origin.source}", "strong"), Text(origin.understood))),
        Section("stated in the file", (Facts((*stated, *run.metadata.items())),)),
        Section(f"fields{header if origin.header_line else ''}", (_fields(run),)),
        Section("left out, and remarks", tuple(map(Text, left_out))),
    )


def _fields(run: Run) -> Table:
    row = run.origin.row_name
    lines = "" if run.lines is None else f" ({row} {run.lines[0]}, {row} {run.lines[-1]})"
    columns: Columns[tuple[int, TableField]] = {
        "field": lambda one: str(one[0]),
        "header": lambda one: one[1].header or "(none)",
        "taken for": lambda one: (
            f"{one[1].kind} {one[1].name}"
            if one[1].name and one[1].kind != "covariate"
            else one[1].kind
        ),
        "in": lambda one: one[1].unit,
        "first": lambda one: _reading(one[1], run, 0),
        "last": lambda one: _reading(one[1], run, -1),
    }
    note = f"first and last row{lines}: readings in mm, or degrees"
    return Table.of(enumerate(run.origin.fields, start=1), columns, note)


def _reading(one: TableField, run: Run, k: int) -> Cell:
    if one.kind == "axis":
        return Number(float(run.axes[one.name].readings[k]), ".9g")
    labels = {"cycle": run.cycle, "pose": run.pose, "direction of approach": run.direction}
    found = labels.get(one.kind, run.covariates.get(one.name))
    return "" if found is None else str(found[k])


def status_report(folder: Folder, today: date) -> Report:
    """Return the states of a test's parts as a table of poses and conditions, and what is next.

    Calibrations are to hold on the day of the test, or ``today`` where none is stated.
    """
    test, conditions = folder.test, folder.test.conditions()
    columns: dict[str, list[Cell]] = {"pose": [*test.poses]}
    for condition in conditions:
        columns[condition.name] = [_cell(state) for state in folder.under(condition)]
    others: Columns[PartState] = {"other tests": lambda state: state.part.name, "": _cell}
    head = (*_in_words(folder), *_past_due(folder, today))
    parts = {
        "Struck": [f"{s.recording}: {s.reason}" for state in folder.parts for s in state.struck],
        "Out of its conditions": [
            f"{state.part.name}: {finding.message} [{finding.code}]"
            for state in folder.parts
            for finding in state.deviations
        ],
        "Faulty": [f"{one.part.name}: {one.why}" for one in folder.parts if one.why],
        "Planned, and not measured": list(folder.unmeasured),
        "Not part of the test": list(folder.foreign),
    }
    title = f"Test of {test.robot.name or folder.path.name}"
    return (
        Section(title, (*head, Table.in_columns(columns), Table.of(folder.other_tests, others))),
        *(Section(heading, tuple(map(Text, lines))) for heading, lines in parts.items()),
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
        yield _mend(folder, faulty[0]) if faulty else NextStep(f"scara-iso report {folder.path}")
        return
    left = seconds_left(folder)
    pace = f", {about(left)} left at the pace so far" if left is not None else ""
    yield Text(f"Next part: {lacking(following)}{pace}", "strong")
    if following.part.is_push:
        yield Text(f"Now: write force_N and reading into {folder.path / following.part.name}.csv")
    else:
        yield NextStep(f"scara-iso record {folder.path} `gauge=AXIS=DRIVER@PORT`")


def _mend(folder: Folder, state: PartState) -> Block:
    if state.part.is_push:
        return Text(f"Now: correct {folder.path / state.part.name}.csv")
    again = f"`part={state.part.name}` `repeat='the reason'` `gauge=AXIS=DRIVER@PORT`"
    return NextStep(f"scara-iso record {folder.path} {again}", "or correct what is named below")
