"""The folder of a test: which recordings are there, how far each part is, and their runs.

A part's run has what test.toml states beside it; what its table says itself holds. The parts
recorded under one condition are one `Run`, a pose each.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from scara_iso import iso9283
from scara_iso.base.errors import DataError, Fault, ScaraIsoError
from scara_iso.iso9283 import Finding
from scara_iso.rawfile import LEFT_OUT, check_recording, raw_path, read_history
from scara_iso.run import SEPARATOR, Axis, Origin, Run, copies
from scara_iso.signals import read_loop
from scara_iso.tables import converted, corrected, is_of_corrections, read_table
from scara_iso.testfolder.all_conditions import refuse_other_axes, runs_below
from scara_iso.testfolder.statements import (
    NOT_STATED,
    command_of,
    metadata_of,
    other_instruments,
    read_test,
    why_not_of,
)
from scara_iso.testfolder.whole_test import Condition, Part, Struck, WholeTest


def completed(run: Run, part: Part, test: WholeTest) -> Run:
    """Return the run of a part, with the lines and sizes of the test that its table lacks."""
    of_test = metadata_of(part, test, run.axes)
    own = {key: text for key, text in run.metadata.items() if text.strip() != NOT_STATED}
    done = tuple(f"_{name}" for name, axis in run.axes.items() if axis.displayed is not None)
    lines = {
        key: text
        for key, text in of_test.items()
        if not key.startswith(("command_", "indicator_unc"))
        and not (is_of_corrections(key) and key.endswith(done))
    }
    said = {
        "characteristics": ", ".join(_planned(part, test)),
        "instrument_of_the_test": other_instruments(own, of_test),
    }
    known = replace(
        run,
        metadata={**lines, **own, **{key: text for key, text in said.items() if text}},
        axes={name: _completed_axis(axis, part, test) for name, axis in run.axes.items()},
        pose=np.full(len(run), part.pose) if part.other_tests else run.pose,
    )
    found, wrong = corrected(known)
    if wrong:
        raise DataError(
            f"cannot be corrected: {wrong[0]}",
            where=run.origin.source,
            faults=[Fault(one) for one in wrong],
            remedy="state `correction` and `correction_zero` in test.toml",
        )
    return found


def _planned(part: Part, test: WholeTest) -> list[str]:
    """Return the characteristics that a part has to give; a drift test gives its own alone."""
    planned = test.schedule.characteristics
    if test.drift is None:
        return list(planned)
    return [code for code in planned if (code in iso9283.DRIFT_CODES) == bool(part.other_tests)]


def _completed_axis(axis: Axis, part: Part, test: WholeTest) -> Axis:
    if axis.command is None:
        axis = replace(axis, command=command_of(part, test, axis.name))
    if axis.uncertainty is None and axis.name in test.instruments:
        axis = replace(axis, uncertainty=test.instruments[axis.name].uncertainty)
    return axis


DONE, MISSING, UNFINISHED = "done", "missing", "unfinished"
STRUCK, OUT, FAULTY = "struck", "out of its conditions", "faulty"
STATES = (DONE, MISSING, UNFINISHED, STRUCK, OUT, FAULTY)
PLANNED = ("other-load", "other-velocity", "not-measured")
"""Deviations that the name of a part says already, or that are of the whole test."""
_RAW = ".raw.jsonl"
_OF_A_RECORDING = (".csv", ".jsonl", ".json")
_REPEATED = r"(?:-r\d+)?"


@dataclass(frozen=True, eq=False)
class Recording:
    """What was recorded for a part, once: a table, a raw file, or both."""

    part: Part
    table: Path
    planned: int
    """Cycles, or visits of a drift test."""

    @property
    def name(self) -> str:
        """Its files' name without ending."""
        return self.table.name.removesuffix(".csv")

    @cached_property
    def cycles(self) -> tuple[int, int]:
        """How many cycles are complete, and how many were to be; raises as reading does.

        A drift test is planned by its test.toml, which may end it early; a push test is one.
        """
        if self.part.is_push:
            return 1, 1
        if not raw_path(self.table).exists():
            return len(self.run), len(self.run)
        history = read_history(raw_path(self.table))
        if not history.header and not history.faults:  # begun this moment, or cut short there
            return 0, iso9283.CYCLES_RUN
        history.check()
        wanted = int(history.header["cycles"])
        done = len(history.complete_visits())
        return done, min(wanted, self.planned) if self.part.other_tests else wanted

    @cached_property
    def run(self) -> Run:
        """The readings; raises as `read_table` does."""
        return check_recording(read_table(self.table), self.table)

    @property
    def is_whole(self) -> bool:
        """Whether every cycle is there, and the table is made of all that is stored."""
        done, wanted = self.cycles
        whole = done >= wanted and self.table.exists()
        return whole and (self.part.is_push or LEFT_OUT not in self.run.metadata)


@dataclass(frozen=True, eq=False, slots=True)
class PartState:
    """How far a part is; ``why`` says what is wrong with one that is faulty."""

    part: Part
    state: str
    recording: Recording | None = None
    struck: tuple[Struck, ...] = ()
    deviations: tuple[Finding, ...] = ()
    unmeasured: tuple[str, ...] = ()
    """Characteristics that are planned and that its readings do not give, with what they need."""
    why: str = ""
    remedy: str = ""
    """What its table, read alone, would have a user do."""
    others: tuple[str, ...] = ()
    """Further recordings that are not struck, where it was recorded more than once."""

    @property
    def is_whole(self) -> bool:
        """Whether its recording can be analysed."""
        return self.state in (DONE, OUT)

    @property
    def whole(self) -> Recording | None:
        """Its recording, where that can be analysed."""
        return self.recording if self.is_whole else None

    @property
    def begun(self) -> Recording | None:
        """Its recording, where that is to be gone on with."""
        return self.recording if self.state == UNFINISHED else None

    @property
    def is_open(self) -> bool:
        """Whether it is still to be recorded, or to be gone on with."""
        return self.state in (MISSING, STRUCK, UNFINISHED)


@dataclass(frozen=True, eq=False, slots=True)
class Folder:
    """A test and the states of its parts, in the order of recording."""

    path: Path
    test: WholeTest
    parts: tuple[PartState, ...]
    foreign: tuple[str, ...]
    """Recordings that are of no part of the test, and files called as a part, by their names."""

    @property
    def unmeasured(self) -> tuple[str, ...]:
        """What is planned and not given by the parts that are recorded, each line once."""
        return tuple(dict.fromkeys(line for state in self.parts for line in state.unmeasured))

    def under(self, condition: Condition) -> list[PartState]:
        """Return the poses of a condition."""
        of_poses = (one for one in self.parts if not one.part.other_tests)
        return [one for one in of_poses if one.part.condition == condition]

    @property
    def other_tests(self) -> list[PartState]:
        """The tests beside the poses: drift, pushes."""
        return [one for one in self.parts if one.part.other_tests]

    @property
    def next(self) -> PartState | None:
        """What comes next: a part that was begun, else the first that lacks."""
        begun = (part for part in self.parts if part.state == UNFINISHED)
        return next(begun, next((part for part in self.parts if part.is_open), None))


def read_folder(path: Path) -> Folder:
    """Return what a folder holds now; raises as `read_test`.

    A recording that cannot be read is a faulty part, never an error: status can always be asked.
    """
    test, names = read_test(path), _names(path)
    found = {part: _recordings(part, path, names, test) for part in test.parts()}
    parts = tuple(_state(part, recordings, test) for part, recordings in found.items())
    known = {recording.name for recordings in found.values() for recording in recordings}
    foreign = {*(names - known), *_in_other_files(path, found)}
    return Folder(path, test, _in_units(parts), tuple(sorted(foreign)))


def _in_other_files(path: Path, parts: Iterable[Part]) -> Iterator[str]:
    """Yield the files that are called as a part is and are no recording, such as a workbook."""
    names = "|".join(re.escape(part.name) for part in parts)
    called = re.compile(rf"(?:{names}){_REPEATED}", re.IGNORECASE)
    for file in path.iterdir():
        if file.is_file() and file.suffix not in _OF_A_RECORDING and called.fullmatch(file.stem):
            yield file.name


def _in_units(parts: tuple[PartState, ...]) -> tuple[PartState, ...]:
    """Return the states with those out that were read in another unit than the first."""
    runs, states = _whole_runs(parts), {one.part.name: one for one in parts}
    for name, line in dict(converted(runs) if runs else ()).items():
        found = Finding("other-unit", "warning", line)
        deviations = (*states[name].deviations, found)
        states[name] = replace(states[name], state=OUT, deviations=deviations)
    return tuple(states.values())


def _whole_runs(parts: Iterable[PartState]) -> dict[str, Run]:
    return {one.part.name: one.whole.run for one in parts if one.whole and not one.part.is_push}


def _names(path: Path) -> set[str]:
    files = [one.name for one in path.iterdir() if one.is_file()]
    return {n.removesuffix(end) for n in files for end in (".csv", _RAW) if n.endswith(end)}


def _recordings(part: Part, path: Path, names: set[str], test: WholeTest) -> list[Recording]:
    """Return what was recorded of a part: ``P3-v50-l100``, and ``-r2`` of it where repeated."""
    repeats = re.compile(re.escape(part.name) + _REPEATED)
    mine = sorted(filter(repeats.fullmatch, names), key=lambda name: (len(name), name))
    return [Recording(part, path / f"{name}.csv", test.visits_of(part)) for name in mine]


def _state(part: Part, recordings: list[Recording], test: WholeTest) -> PartState:
    reasons: Mapping[str, Struck] = {one.recording: one for one in test.struck}
    struck = tuple(reasons[one.name] for one in recordings if one.name in reasons)
    counting = [one for one in recordings if one.name not in reasons]
    if not counting:
        return PartState(part, STRUCK if struck else MISSING, struck=struck)
    *others, last = counting
    known = PartState(part, FAULTY, last, struck, others=tuple(one.name for one in others))
    if others:
        why = (
            f"recorded twice: {', '.join(one.name for one in counting)}; strike one of them in "
            f'test.toml: [[struck]] with recording = "{last.name}" and its reason'
        )
        return replace(known, why=why)
    try:
        return _judged(known, last, test)
    except ScaraIsoError as error:
        return replace(known, why=_why(error), remedy=error.remedy)


def _judged(known: PartState, recording: Recording, test: WholeTest) -> PartState:
    """Return how far a part is with its only recording; raises as reading it does."""
    part = recording.part
    if not recording.is_whole:
        return replace(known, state=UNFINISHED)
    if part.is_push:
        push_of(recording, test)
        return replace(known, state=DONE)
    if faults := why_not_of(recording.run, part, test):
        return replace(known, why="; ".join(faults))
    run = completed(recording.run, part, test)
    cycles = None if part.other_tests else test.schedule.cycles_run
    findings = iso9283.analyze(run, iso9283.Counting(cycles=cycles)).findings
    off = tuple(
        f
        for f in findings
        if f.severity != "info" and f.code not in PLANNED and (f.rule or f.code == "edited")
    )
    lacking = tuple(finding.message for finding in findings if finding.code == "not-measured")
    return replace(known, state=OUT if off else DONE, deviations=off, unmeasured=lacking)


def _why(error: ScaraIsoError) -> str:
    """Return what is wrong with a recording in one line, the first of its faults with it."""
    faults = error.faults if isinstance(error, DataError) else ()
    said = [str(one) for one in faults[:1] if one.message != error.what]
    more = [f"and {len(faults) - 1} more"] if len(faults) > 1 else []
    return "; ".join([error.headline, *said, *more])


def push_of(recording: Recording, test: WholeTest) -> iso9283.PushResult:
    """Return what the table of a push test says, held against its limits; raises as `push_test`."""
    stated = test.pushes[recording.part.name]
    return iso9283.push_test(
        read_loop(str(recording.table)),
        arm_m=stated.arm_m,
        limits=stated.limits,
        decision=iso9283.DecisionRule(test.decision),
    )


_OF_A_PART = {"part", "pose", "doubts"}
"""Lines that the merged run says in another way."""


def run_under(folder: Folder, condition: Condition) -> Run | None:
    """Return the run of the whole parts of a condition, None where there is none.

    What is missing or struck is in its metadata. Raises `DataError` for parts that are faulty, or
    not of the same axes.
    """
    states = folder.under(condition)
    refuse_faulty(folder, states)
    runs = {
        state.part.pose: completed(state.whole.run, state.part, folder.test)
        for state in states
        if state.whole
    }
    if not runs:
        return None
    remedy = "repeat the part that differs, with the gauges of the others"
    refuse_other_axes(runs, "the parts do not have the same axes", str(folder.path), remedy)
    whole = runs_below(runs, lambda pose, _: pose, _metadata(runs))
    said = f"{len(runs)} of {len(states)} parts of the test, {condition}"
    metadata = {**whole.metadata, **dict(_of_the_test(states, folder))}
    units = tuple(said for _, said in converted(runs))
    origin = Origin(
        str(folder.path),
        said,
        (*_notes(folder, runs), *units),
        tuple(f"{pose}: {one}" for pose, run in runs.items() for one in run.origin.remarks),
        other_units=units,
    )
    return replace(whole, metadata=metadata, origin=origin)


def _metadata(runs: Mapping[str, Run]) -> dict[str, str]:
    """Return the lines that all runs state alike; of others each is kept as ``key[P1]``."""
    found: dict[str, str] = {}
    keys = dict.fromkeys(key for run in runs.values() for key in run.metadata)
    for key in (one for one in keys if one not in _OF_A_PART):
        texts = {pose: run.metadata.get(key) for pose, run in runs.items()}
        first = next(iter(texts.values()))
        if first is not None and len(set(texts.values())) == 1:
            found[key] = first
        else:
            found |= {f"{key}[{pose}]": text for pose, text in texts.items() if text is not None}
    return found


def refuse_faulty(folder: Folder, states: Sequence[PartState]) -> None:
    """Raise `DataError` with what is wrong with each part that is faulty."""
    faulty = [one for one in states if one.state == FAULTY]
    faults = [Fault(f"{one.part.name}: {one.why}") for one in faulty]
    if faults:
        advice = "; ".join(dict.fromkeys(one.remedy for one in faulty if one.remedy))
        alone = f"{advice} (here as a line of the file, cycles in test.toml); or " if advice else ""
        raise DataError(
            f"{len(faults)} part{'s' if len(faults) > 1 else ''} cannot be taken",
            where=str(folder.path),
            faults=faults,
            remedy=f"{alone}move a file of another test away, correct or strike it, or repeat the "
            f"part: scara-iso record {folder.path} `part={faulty[0].part.name}` "
            "`repeat='the reason'`",
        )


def _of_the_test(states: Sequence[PartState], folder: Folder) -> Iterator[tuple[str, str]]:
    """Yield what is missing, struck and doubted, for the checks and for the head of the report."""
    for key, parts in (("parts_missing", states), ("other_tests_missing", folder.other_tests)):
        if missing := [lacking(one) for one in parts if one.is_open]:
            yield key, ", ".join(missing)
    if struck := [f"{one.recording}: {one.reason}" for state in states for one in state.struck]:
        yield "parts_struck", SEPARATOR.join(struck)
    doubts = [
        f"{state.part.name}: {line}"
        for state in states
        if state.whole
        for line in state.whole.run.metadata.get("doubts", "").split(SEPARATOR)
        if line
    ]
    if doubts:
        yield "doubts", SEPARATOR.join(doubts)


def lacking(state: PartState) -> str:
    """Return a part that is not whole by its name, and how far it is where it was begun."""
    if state.begun is None:
        return state.part.name
    done, wanted = state.begun.cycles
    return f"{state.part.name} ({done} of {wanted} cycles)"


def _notes(folder: Folder, runs: Mapping[str, Run]) -> Iterator[str]:
    for pose, run in runs.items():
        yield from (f"{pose}: {note}" for note in run.origin.notes)
    for name, first in copies(_whole_runs(folder.parts).items()):
        yield f"{name} holds the very readings of {first}: a copy?"
    for name in folder.foreign:
        yield f"{name}: of no part of the test, or no .csv: not used"
