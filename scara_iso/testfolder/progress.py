"""How far a test is: which part is recorded next, what lacks and how long it takes.

A part is recorded into a file with its head; `test status` publishes all of them.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Annotated, Literal

from scara_iso.base.errors import UsageError
from scara_iso.base.published import Count, publish
from scara_iso.rawfile import manifest_path, raw_path
from scara_iso.testfolder.folder import FAULTY, STATES, Folder, PartState, lacking
from scara_iso.testfolder.statements import metadata_of
from scara_iso.testfolder.whole_test import Part, Struck

TIME = "time_s"
_MINUTE_S, _HOUR_S = 60.0, 3600.0


def _seconds_a_cycle(folder: Folder) -> float | None:
    """Return the pace: the median over the parts that have times, None where none has."""
    whole = [one.whole.run for one in folder.parts if one.whole and not one.part.other_tests]
    times = [run.covariates[TIME] for run in whole if TIME in run.covariates]
    paces = [float(one[-1] - one[0]) / (len(one) - 1) for one in times if len(one) > 1]
    return median(paces) if paces else None


def cycles_left(folder: Folder, but: Part | None = None) -> int:
    """Return how many cycles are still to be recorded at the poses, those of one part left out."""
    lacks = [one for one in folder.parts if one.is_open and not one.part.other_tests]
    left = [one for one in lacks if one.part != but]
    planned = (0, folder.test.schedule.cycles)
    begun = (one.begun.cycles if one.begun else planned for one in left)
    return sum(max(0, wanted - done) for done, wanted in begun)


def seconds_left(folder: Folder) -> float | None:
    """Return how long the poses that lack will take, None where no pace is known.

    A drift test has a pace of its own: None too where nothing but the tests beside them lack.
    """
    pace, left = _seconds_a_cycle(folder), cycles_left(folder)
    beside_alone = not left and folder.next is not None
    return None if pace is None or beside_alone else pace * left


def about(seconds: float) -> str:
    """Return a time as it is said: ``about 40 minutes``."""
    if seconds < _MINUTE_S:
        return "less than a minute"
    if seconds < 2 * _HOUR_S:
        minutes = math.ceil(seconds / _MINUTE_S)
        return f"about {minutes} minute{'s' if minutes > 1 else ''}"
    return f"about {seconds / _HOUR_S:.1f} hours"


@dataclass(frozen=True, slots=True)
class Assignment:
    """One part to record; ``struck`` are the recordings that it stands for, if it is repeated."""

    part: Part
    table: Path
    resume: bool
    metadata: Mapping[str, str]
    cycles: int
    folder: Folder
    """As it is before this part."""
    struck: tuple[Struck, ...] = ()

    def said(self, stored: int, pace_s: float | None = None) -> str:
        """Return where the test is: ``part 7 of 15, P2 at 50 %, about 40 minutes left``.

        ``pace_s`` is that of this recording, for a test of which no part is recorded yet.
        """
        every = [one.part for one in self.folder.parts]
        number = f"part {1 + every.index(self.part)} of {len(every)}"
        if self.part.other_tests:
            return f"{number}, the {self.part.name} test at {self.part.pose}"
        condition = self.part.condition
        load = "" if condition.load == 100 else f" and {condition.load:g} % load"
        where = f"{number}, {self.part.pose} at {condition.velocity:g} %"
        pace = _seconds_a_cycle(self.folder) or pace_s
        if pace is None:
            return f"{where}{load}"
        left = pace * (self.cycles - stored + cycles_left(self.folder, but=self.part))
        return f"{where}{load}, {about(left)} left"

    def begin(self, folder: Path, cycle: int) -> str:
        """Strike what is repeated, now that ``cycle`` is awaited; return which part it is.

        Done when the session has begun: a port that cannot be opened strikes nothing, and no
        reading is stored beside one that still counts.
        """
        if self.struck:
            from scara_iso.testfolder.writing import strike  # noqa: PLC0415 - brings tomlkit

            strike(folder, *self.struck)
        return f"{self.part.name}: {self.said(cycle - 1)}"


def next_of_load(folder: Folder, load: float | None = None) -> str | None:
    """Return the first part in the order of the test that lacks and needs no other load, if any.

    ``load`` is that of the first open part unless it is given. Tests beside the poses are none.
    """
    states = (one for one in folder.parts if one.is_open and not one.part.other_tests)
    return next((one.part.name for one in states if load in (None, one.part.condition.load)), None)


def assign(
    folder: Folder, axes: Collection[str], *, part: str | None = None, repeat: str | None = None
) -> Assignment | None:
    """Return the part ``part``, or the next one; None where nothing is missing.

    ``repeat`` is the reason for which what is there of the part is struck. Raises `UsageError` for
    no such part, one that is recorded already, and axes other than those of the other parts.
    """
    if repeat is not None and (part is None or not repeat.strip()):
        raise UsageError(
            "a part is repeated by its name and a reason",
            remedy="give `part=P3-v50-l100` and `repeat='the plunger stuck'`",
        )
    state = folder.next if part is None else _state(folder, part, repeat)
    if state is None:
        return None
    if state.part.is_push:
        raise UsageError(
            f"{state.part.name} is a table of forces, which is typed and not recorded",
            where=str(folder.path),
            remedy=f"write the columns force_N and reading into {_free(folder, state.part)}",
        )
    _refuse_other_axes(folder, axes, state)
    there = (*state.others, state.recording.name) if repeat and state.recording else ()
    struck = tuple(Struck(name, " ".join((repeat or "").split())) for name in there)
    begun = None if struck else state.begun
    return Assignment(
        part=state.part,
        table=begun.table if begun else _free(folder, state.part),
        resume=begun is not None,
        metadata=metadata_of(state.part, folder.test, axes),
        cycles=folder.test.visits_of(state.part),
        folder=folder,
        struck=struck,
    )


def _state(folder: Folder, name: str, repeat: str | None) -> PartState:
    found = {one.part.name: one for one in folder.parts}
    if name not in found:
        raise UsageError(
            f"no part {name!r} in {folder.path}", remedy=f"it has {', '.join(list(found)[:15])}"
        )
    state = found[name]
    if repeat is None and not state.is_open:
        why = f" and {state.why}" if state.state == FAULTY else ""
        raise UsageError(
            f"{name} is recorded already{why}", remedy="give `repeat='the reason'` to repeat it"
        )
    if repeat is not None and state.recording is None:
        raise UsageError(
            f"{name} is not recorded: nothing is repeated", remedy="leave `repeat=` out"
        )
    return state


def _refuse_other_axes(folder: Folder, axes: Collection[str], state: PartState) -> None:
    others = (one for one in folder.parts if one is not state and not one.part.other_tests)
    whole = next((one.whole for one in others if one.whole), None)
    if state.part.other_tests or whole is None or {*whole.run.axes} == {*axes}:
        return
    raise UsageError(
        f"{whole.part.name} was recorded on {', '.join(sorted(whole.run.axes))}, "
        f"and this would be {', '.join(sorted(axes))}",
        remedy="give a gauge for each of these axes, so that the poses can be compared",
    )


def _free(folder: Folder, part: Part) -> Path:
    """Return the first name of the part that no file has: ``P3-v50-l100``, ``P3-v50-l100-r2``."""
    number, table = 1, folder.path / f"{part.name}.csv"
    while any(path.exists() for path in (table, raw_path(table), manifest_path(table))):
        number += 1
        table = folder.path / f"{part.name}-r{number}.csv"
    return table


@dataclass(frozen=True, slots=True, kw_only=True)
class PartDeviation:
    """A finding of a part's recording that departs from the plan."""

    code: str
    """`scara-iso explain CODE` explains it."""
    message: str
    """What was found."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedPart:
    """How far a part is."""

    part: str
    """Pose, velocity, load: `P3-v50-l100`; or `drift`, `push`, `push-joint_1`."""
    pose: str | None
    """Null of a push test."""
    velocity: float | None
    """Per cent of the rated one; null of a push test."""
    load: float | None
    """Per cent of the rated one; null of a push test."""
    state: Annotated[str, ("enum", STATES)]
    """How far it is: docs/test-folder.md."""
    recording: str | None
    """The table that counts."""
    cycles: Count | None
    """That are recorded; null without a recording that can be read, and of a push test."""
    cycles_planned: Count | None
    """That are to be recorded; null as `cycles`."""
    deviations: tuple[PartDeviation, ...]
    """What departs from the plan."""
    struck: tuple[Struck, ...]
    """Recordings of it that do not count."""
    why: str
    """What is wrong with a faulty part; else empty."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedStatus:
    """``test status`` and ``test new``."""

    schema: Literal["scara-iso/test-status/1"] = "scara-iso/test-status/1"
    """Name and number of this schema."""
    folder: str
    """The folder of the test."""
    robot: str
    """Its name."""
    poses: tuple[str, ...]
    """That are planned."""
    velocities: tuple[float, ...]
    """That are planned, per cent of the rated one."""
    loads: tuple[float, ...]
    """That are planned, per cent of the rated one."""
    parts: Annotated[tuple[PublishedPart, ...], ("minItems", 1)]
    """In the order of recording."""
    missing: tuple[str, ...]
    """Parts that are still to be recorded."""
    not_measured: tuple[str, ...]
    """Characteristics that are planned and not given, with what they need."""
    unknown: tuple[str, ...]
    """Recordings that are of no part of the test."""
    complete: bool
    """Whether every part can be analysed."""
    next: str | None
    """The part that is recorded next; null where none is missing."""
    seconds_a_cycle: Annotated[float, ("unit", "s")] | None
    """The pace of the parts recorded; null where none has times."""
    seconds_left: Annotated[float, ("unit", "s")] | None
    """At this pace."""


def published_status(folder: Folder) -> PublishedStatus:
    """Return what ``test status`` says."""
    test, following = folder.test, folder.next
    return PublishedStatus(
        folder=str(folder.path),
        robot=test.robot.name,
        poses=tuple(test.poses),
        velocities=tuple(test.schedule.velocities),
        loads=tuple(test.schedule.loads),
        parts=tuple(map(_part, folder.parts)),
        missing=tuple(lacking(state) for state in folder.parts if state.is_open),
        not_measured=folder.unmeasured,
        unknown=folder.foreign,
        complete=all(state.is_whole for state in folder.parts),
        next=None if following is None else following.part.name,
        seconds_a_cycle=_seconds_a_cycle(folder),
        seconds_left=seconds_left(folder),
    )


def _part(state: PartState) -> PublishedPart:
    of_poses, recording = not state.part.is_push, state.recording
    readable = recording if of_poses and not state.why else None
    done, wanted = (None, None) if readable is None else readable.cycles
    condition = state.part.condition
    return publish(
        PublishedPart,
        state,
        part=state.part.name,
        pose=state.part.pose or None,
        velocity=condition.velocity if of_poses else None,
        load=condition.load if of_poses else None,
        recording=None if recording is None else recording.table.name,
        cycles=done,
        cycles_planned=wanted,
        deviations=tuple(publish(PartDeviation, one) for one in state.deviations),
    )
