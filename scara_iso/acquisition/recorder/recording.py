"""The one path of a recording: ports, raw file, what was before, header, session, table."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from datetime import date

from scara_iso.acquisition.manifest import manifest_path, raw_path
from scara_iso.acquisition.ports import (
    Clock,
    Port,
    is_device,
    is_keyboard,
    is_recorded,
    open_line,
    open_port,
    refuse_same_device,
    replayed_poses,
)
from scara_iso.acquisition.recorder.earlier import check_files, read_earlier, strike_cut_short
from scara_iso.acquisition.recorder.events import Done, Noticed, Operator, Said
from scara_iso.acquisition.recorder.header import make_gauges, write_header
from scara_iso.acquisition.recorder.history import History, read_history
from scara_iso.acquisition.recorder.journal import Journal
from scara_iso.acquisition.recorder.plan import Job, Listen, RobotLine, Settled
from scara_iso.acquisition.recorder.position import Position
from scara_iso.acquisition.recorder.robot_line import RobotSays
from scara_iso.acquisition.recorder.session import Session
from scara_iso.acquisition.recorder.spec import GaugeSpec
from scara_iso.acquisition.recorder.table import remove, table_of, write_table_of
from scara_iso.acquisition.recorder.tour import Tour
from scara_iso.disk import Disk
from scara_iso.errors import (
    CannotCreateError,
    InstrumentError,
    ScaraIsoError,
    UsageError,
    WriteError,
)
from scara_iso.iso9283 import past_due

_GO_ON = "then go on with `resume=True`"
_BEGIN = "and begin again: no reading was stored"


def record(
    job: Job,
    *,
    disk: Disk,
    clock: Clock,
    operator: Operator,
    tell: Callable[[Said], None],
    attended: bool = False,
    typed: Callable[[], bytes] | None = None,
) -> None:
    """Record a job and write its table, however the session ends.

    After a `WriteError` the table is not written: the raw file holds every announced reading.
    ``attended`` says that the operator can answer a question, ``typed`` gives
    the lines of the port ``keyboard:``. Raises what `Session.run` raises,
    and `CannotCreateError` where files are there already.
    Nothing is left behind where no reading was stored.
    """
    check_files(job.table, resume=job.resume)
    with ExitStack() as stack:
        ports = _open_ports(job, clock, stack, typed)
        journal = Journal(raw_path(job.table), disk=disk, clock=clock, new=not job.resume)
        stack.callback(journal.close)
        earlier = read_earlier(job)  # while the journal locks it
        journal.previous = earlier.previous
        with _table_at_the_end(job, journal, disk, tell):
            gauges = make_gauges(job, ports, earlier)
            write_header(job, gauges, earlier, journal)
            for struck in strike_cut_short(earlier, journal):
                tell(struck)
            earlier.timeline.at({"event": "session", "t": clock.now(), "wall": clock.wall()})
            for remark in (*earlier.timeline.jumps, *_past_due(job, earlier, clock)):
                tell(Noticed("", remark))
            if isinstance(job.plan.trigger, RobotLine):
                operator = robot = _robot(job, job.plan.trigger, operator, journal, tell, stack)
                tell = robot.told
            Session(
                gauges,
                plan=replace(job.plan, all_count=job.all_count),
                journal=journal,
                clock=clock,
                operator=operator,
                tell=tell,
                position=Position.after(earlier),
                attended=attended,
            ).run()


def _past_due(job: Job, earlier: History, clock: Clock) -> Iterator[str]:
    """Yield what is stated of a calibration that has run out; a simulation has no date."""
    wall = clock.wall()
    if wall is not None:
        head = {**earlier.header.get("metadata", {}), **job.metadata}
        for line in past_due(head, date.fromisoformat(wall[:10])):
            yield f"{line} is past: calibrate the indicator, or use another"


def _robot(
    job: Job,
    trigger: RobotLine,
    operator: Operator,
    journal: Journal,
    tell: Callable[[Said], None],
    stack: ExitStack,
) -> RobotSays:
    """Open the robot's line, as an operator that says when."""
    port = open_line(trigger.address)
    stack.callback(port.close)
    return RobotSays(
        port,
        operator,
        journal=journal,
        tell=tell,
        pose=job.metadata.get("pose"),
        in_order=not any(is_device(gauge.address) for gauge in job.gauges),
    )


def _open_ports(
    job: Job, clock: Clock, stack: ExitStack, typed: Callable[[], bytes] | None
) -> list[Port]:
    refuse_same_device({g.axis: g.address for g in job.gauges if is_device(g.address)})
    ports = []
    for spec in job.gauges:
        if job.resume and is_recorded(spec.address):
            raise UsageError(
                "a recorded stream cannot be resumed: record it into a new file",
                remedy="leave `resume=` out, and name another table",
            )
        _refuse_other_poses(spec, job.plan.tour)
        if job.plan.stable > 1 and spec.address.startswith("replay:"):
            raise UsageError(
                "a recorded stream cannot be asked again for a settled reading",
                remedy="leave `stable=` out",
            )
        asked = not isinstance(job.plan.trigger, Listen)
        if asked and is_keyboard(spec.address):
            raise UsageError(
                "a typed line is reading and trigger at once",
                where=f"gauge {spec.axis}",
                remedy="leave the trigger out, or give `trigger=data`",
            )
        port = open_port(
            spec.address,
            spec.dialect,
            axis=spec.axis,
            clock=clock,
            asked=asked,
            watched=isinstance(job.plan.trigger, Settled),
            typed=typed,
        )
        stack.callback(port.close)
        ports.append(port)
    return ports


def _refuse_other_poses(spec: GaugeSpec, tour: Tour) -> None:
    """Raise `UsageError` for a recorded stream of several poses that is taken for other ones."""
    poses = replayed_poses(spec.address)
    if poses and poses != tour.poses:
        stated = ",".join(poses)
        raise UsageError(f"{spec.address} was recorded at {stated}", remedy=f"give `pose={stated}`")


@contextmanager
def _table_at_the_end(
    job: Job, journal: Journal, disk: Disk, tell: Callable[[Said], None]
) -> Iterator[None]:
    """Make the table of the raw file however the session ends; only a `WriteError` goes past it."""
    try:
        yield
    except WriteError as error:
        if not _keeps_readings(journal):
            error.remedy = f"make room, or name another place, {_BEGIN}"
        raise
    except InstrumentError as error:
        _end(job, journal, disk, tell)
        error.remedy += f", {_GO_ON if _keeps_readings(journal) else _BEGIN}"
        raise
    except BaseException:
        _end(job, journal, disk, tell)
        raise
    if no_table := _end(job, journal, disk, tell):
        raise no_table


def _keeps_readings(journal: Journal) -> bool:
    try:
        return bool(read_history(journal.path).latest)
    except (OSError, ScaraIsoError):  # not there, or of a disk that failed
        return False


def _end(
    job: Job, journal: Journal, disk: Disk, tell: Callable[[Said], None]
) -> InstrumentError | None:
    """Write table and manifest from what the raw file holds; return why there is no table."""
    history = read_history(journal.path)
    if not history.latest and not history.troubles["voided"] and not history.damaged:
        remove(journal.path, disk)
        return InstrumentError(
            "no reading was recorded, and no file is kept",
            remedy="scara-iso ports with `probe=PORT` shows what an indicator sends",
        )
    rows = int(history.complete_rows().sum())
    journal.append("end", complete=history.is_complete)
    journal.sync()
    if not rows:
        for path in (job.table, manifest_path(job.table)) if job.resume else ():
            remove(path, disk)
        return InstrumentError(
            f"no cycle is complete, so there is no table; {journal.path.name} holds the readings",
            where=str(job.table),
            remedy="go on with `resume=True`",
        )
    if job.table.exists() and not job.resume:
        raise CannotCreateError(
            "was written by another program meanwhile",
            where=str(job.table),
            remedy=f"record with `rebuild=True`, {journal.path} and another name makes the table",
        )
    write_table_of(history, job.table, table_of(history), disk=disk)
    tell(Done(history.cycles, job.plan.cycles, str(job.table), str(journal.path)))
    return None
