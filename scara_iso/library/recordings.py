"""`record`: serial indicators to a table, without a terminal."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

from scara_iso import recorder
from scara_iso.base.errors import UsageError
from scara_iso.iso9283 import CYCLES_RUN, past_due
from scara_iso.library.watching import Watcher
from scara_iso.rawfile import Tour
from scara_iso.recorder import (
    Command,
    Job,
    Operator,
    RecordingPlan,
    Said,
    SystemDisk,
    check_metadata,
    choose_clock,
    earlier_of,
    is_recorded,
    name_dialects,
    parse_gauges,
    parse_poses,
    parse_trigger,
    when_started,
)
from scara_iso.run import Run
from scara_iso.tables import read_table
from scara_iso.testfolder import Assignment, assign, is_test_folder, read_folder

_REARM_S = 0.5


class Nobody:
    """An operator who never says anything."""

    def poll(self) -> Command | None:
        """Return None."""
        return None


def record(
    table: str | Path,
    gauges: Sequence[str],
    *,
    trigger: str,
    cycles: int | None = None,
    pose: str | Sequence[str] | None = None,
    stable: int = 1,
    rearm: float | None = None,
    unit: str | None = None,
    metadata: Mapping[str, str] | None = None,
    resume: bool = False,
    part: str | None = None,
    repeat: str | None = None,
    excel_locale: str | None = None,
    watch: bool = False,
    operator: Operator | None = None,
    tell: Callable[[Said], None] | None = None,
) -> Run:
    """Record indicators into ``table`` and return what is then in it.

    ``table`` may be the folder of a test: the next missing part is recorded, or gone on with, or
    ``part`` (``P3-v50-l100``); ``repeat`` is the reason for which what is there of it is struck.
    test.toml gives cycles, pose and head then, and `UsageError` says where nothing is missing.

    ``gauges`` are ``AXIS=DRIVER@PORT``, ``trigger`` is ``data``, ``timer:SECONDS``, or ``enter``
    with an ``operator`` whose ``poll()`` gives the commands. ``tell`` hears each event, a stored
    reading only once it is safe on the disk. ``stable`` readings in a row must agree; none counts
    within ``rearm`` seconds of the last (0.5, for recorded streams 0). ``cycles`` are 31 unless
    given. ``pose`` names the poses of every cycle, in their order: ``"P1,P2"`` or a sequence.
    ``metadata`` goes into the table's head. With ``watch`` ``tell`` hears after each cycle what the
    readings so far say together. Raises `UsageError` for invalid options,
    `InstrumentError` for a port, `CannotCreateError` and `WriteError` for the files.
    """
    specs = parse_gauges(name_dialects(gauges, lambda _: None), unit=unit)
    recorded = all(is_recorded(spec.address) for spec in specs)
    pause = rearm if rearm is not None else 0.0 if recorded else _REARM_S
    tour = Tour() if pose is None else Tour(parse_poses(pose))
    told = tell or (lambda _: None)
    path, head = Path(table), check_metadata(dict(metadata or {}))
    if (
        found := _part(path, [spec.axis for spec in specs], cycles, tour, part, repeat)
    ) is not None:
        told = when_started(partial(found.begin, path), told)
        path, cycles, resume = found.table, found.cycles, found.resume
        head = check_metadata(dict(found.metadata)) | head
    plan = RecordingPlan(parse_trigger(trigger), cycles or CYCLES_RUN, stable, pause, tour)
    job = Job(path, specs, plan, head, resume, excel_locale)
    if watch:
        earlier = earlier_of(path) if resume else None
        told = Watcher(job, earlier, told).told
    recorder.record(
        job,
        disk=SystemDisk(),
        clock=choose_clock(spec.address for spec in specs),
        operator=operator or Nobody(),
        tell=told,
        remarks=past_due,
    )
    return read_table(path)


def _part(
    path: Path,
    axes: Sequence[str],
    cycles: int | None,
    tour: Tour,
    part: str | None,
    repeat: str | None,
) -> Assignment | None:
    """Return the part to record where ``path`` is the folder of a test, else None."""
    if not is_test_folder(path):
        if part is not None or repeat is not None:
            raise UsageError(
                "`part=` and `repeat=` are for the folder of a test",
                where=str(path),
                remedy="leave them out, or name such a folder",
            )
        return None
    if cycles is not None or tour.poses:
        raise UsageError(
            "test.toml says poses and cycles", where=str(path), remedy="leave them out"
        )
    found = assign(read_folder(path), axes, part=part, repeat=repeat)
    if found is None:
        raise UsageError(
            "nothing is missing",
            where=str(path),
            remedy="to repeat a part give `part=P3-v50-l100` and `repeat='the plunger stuck'`",
        )
    return found
