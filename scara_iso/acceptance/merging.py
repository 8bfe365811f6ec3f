"""The parts recorded under one condition as one `Run`, a pose each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from scara_iso.acceptance.complete import completed
from scara_iso.acceptance.folder import FAULTY, UNFINISHED, Folder, PartState
from scara_iso.acceptance.whole_test import Condition
from scara_iso.dial import joined_axis
from scara_iso.errors import DataError, Fault
from scara_iso.iso9283 import SEPARATOR
from scara_iso.origin import Origin
from scara_iso.run import Axis, Run
from scara_iso.tables import converted

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
        state.part.pose: completed(state.recording.run, state.part, folder.test)
        for state in states
        if state.is_whole and state.recording is not None
    }
    if not runs:
        return None
    _refuse_other_axes(folder, runs)
    run = runs_as_poses(runs)
    said = f"{len(runs)} of {len(states)} parts of the test, {condition}"
    metadata = {**run.metadata, **dict(_of_the_test(states))}
    units = tuple(said for _, said in converted(runs))
    return replace(
        run,
        metadata=metadata,
        origin=Origin(str(folder.path), said, (*_notes(folder, runs), *units), other_units=units),
    )


def runs_as_poses(runs: Mapping[str, Run]) -> Run:
    """Return runs of one pose each as one run with a pose column.

    A line that all runs state stays; of others each is kept as ``key[P1]``. A size that one run
    does not state is not stated, else the largest counts. Columns that a run lacks are left out.
    """
    parts = list(runs.values())
    shared = [name for name in parts[0].covariates if all(name in p.covariates for p in parts)]
    return Run(
        cycle=np.concatenate([part.cycle for part in parts]),
        axes={name: _axis(name, runs) for name in parts[0].axes},
        pose=np.repeat(list(runs), [len(part) for part in parts]),
        covariates={n: np.concatenate([p.covariates[n] for p in parts]) for n in shared},
        metadata=_metadata(runs),
    )


def _axis(name: str, runs: Mapping[str, Run]) -> Axis:
    axes = [run.axes[name] for run in runs.values()]
    commands = {pose: run.command_of(name, None) for pose, run in runs.items()}
    return joined_axis(axes, {pose: one for pose, one in commands.items() if one is not None})


def _metadata(runs: Mapping[str, Run]) -> dict[str, str]:
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
    faults = [Fault(f"{one.part.name}: {one.why}") for one in states if one.state == FAULTY]
    if faults:
        first = next(one for one in states if one.state == FAULTY)
        raise DataError(
            f"{len(faults)} part{'s' if len(faults) > 1 else ''} cannot be taken",
            where=str(folder.path),
            faults=faults,
            remedy="move a file of another test away, correct or strike it, or repeat the part: "
            f"scara-iso record {folder.path} `part={first.part.name}` `repeat='the reason'`",
        )


def _refuse_other_axes(folder: Folder, runs: Mapping[str, Run]) -> None:
    found = {
        pose: ", ".join(f"{n} in {a.unit}" for n, a in run.axes.items())
        for pose, run in runs.items()
    }
    if len(set(found.values())) > 1:
        raise DataError(
            "the parts do not have the same axes",
            where=str(folder.path),
            faults=[Fault(f"{pose}: {said}") for pose, said in found.items()],
            remedy="repeat the part that differs, with the gauges of the others",
        )


def _of_the_test(states: Sequence[PartState]) -> Iterator[tuple[str, str]]:
    """Yield what is missing, struck and doubted, for the checks and for the head of the report."""
    if missing := [lacking(one) for one in states if one.is_open]:
        yield "parts_missing", ", ".join(missing)
    if struck := [f"{one.recording}: {one.reason}" for state in states for one in state.struck]:
        yield "parts_struck", SEPARATOR.join(struck)
    doubts = [
        f"{state.part.name}: {line}"
        for state in states
        if state.is_whole and state.recording is not None
        for line in state.recording.doubts
    ]
    if doubts:
        yield "doubts", SEPARATOR.join(doubts)


def lacking(state: PartState) -> str:
    """Return a part that is not whole by its name, and how far it is where it was begun."""
    if state.state != UNFINISHED or state.recording is None:
        return state.part.name
    done, wanted = state.recording.cycles
    return f"{state.part.name} ({done} of {wanted} cycles)"


def _notes(folder: Folder, runs: Mapping[str, Run]) -> Iterator[str]:
    for pose, run in runs.items():
        yield from (f"{pose}: {note}" for note in run.origin.notes)
    for name in folder.foreign:
        yield f"{name}: of no part of the test, not used"
