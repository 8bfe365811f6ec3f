"""What ``test status`` publishes of a test's folder: schema ``scara-iso/test-status/1``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from scara_iso.base.published import Count, publish
from scara_iso.testfolder.folder import STATES, Folder, PartState, lacking
from scara_iso.testfolder.next_part import seconds_a_cycle, seconds_left
from scara_iso.testfolder.whole_test import Struck


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
        seconds_a_cycle=seconds_a_cycle(folder),
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
