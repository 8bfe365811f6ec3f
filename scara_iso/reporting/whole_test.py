"""How far a test is: the matrix of its parts, what is wrong with them, what comes next."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import date

from scara_iso.acceptance import Folder, PartState, about, lacking, seconds_left
from scara_iso.reporting.blocks import Block, Notice, Report, Section, Table, Text


def status_report(folder: Folder, today: date) -> Report:
    """Return the states of a test's parts as a table of poses and conditions, and what is next.

    Calibrations are to hold on the day of the test, or ``today`` where none is stated.
    """
    title = f"Test of {folder.test.robot.name or folder.path.name}"
    head = (*_said(folder), *_past_due(folder, today))
    return (
        Section(title, (*head, _matrix(folder), *_beside(folder))),
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


def _beside(folder: Folder) -> Iterator[Block]:
    if folder.beside:
        rows = tuple((state.part.name, _cell(state)) for state in folder.beside)
        yield Table(("beside", ""), rows)


def _cell(state: PartState) -> str:
    if state.recording is None or state.is_whole or state.why:
        return state.state
    done, wanted = state.recording.cycles
    return f"{done} of {wanted} cycles"


def _said(folder: Folder) -> Iterator[Block]:
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
