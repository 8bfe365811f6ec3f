"""Which part is recorded next, into which file, with what in its head; how long the test lasts."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from scara_iso.base.errors import UsageError
from scara_iso.rawfile import manifest_path, raw_path
from scara_iso.testfolder.folder import FAULTY, Folder, PartState
from scara_iso.testfolder.whole_test import Part, Struck, metadata_of

TIME = "time_s"
_MINUTE_S, _HOUR_S = 60.0, 3600.0


def seconds_a_cycle(folder: Folder) -> float | None:
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
    pace, left = seconds_a_cycle(folder), cycles_left(folder)
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
        pace = seconds_a_cycle(self.folder) or pace_s
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
