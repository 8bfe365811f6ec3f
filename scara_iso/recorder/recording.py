"""The one path of a recording: ports, raw file, what was before, header, session, table.

What was recorded before is refused where going on would lose or mix something. Table and manifest
are made of what the raw file holds and of nothing else.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from datetime import date
from pathlib import Path

from scara_iso.base.errors import (
    CannotCreateError,
    DataError,
    InstrumentError,
    NoInputError,
    ScaraIsoError,
    UsageError,
    WriteError,
)
from scara_iso.base.files import (
    Disk,
    check_output,
    check_table_name,
    is_folder,
    target_of,
    write_atomically,
)
from scara_iso.base.process import Later
from scara_iso.rawfile import (
    SCHEMA,
    History,
    find_doubts,
    manifest_of,
    manifest_path,
    raw_path,
    read_history,
)
from scara_iso.recorder.bench import refuse_other_gauges
from scara_iso.recorder.events import Done, Noticed, Operator, Said
from scara_iso.recorder.gauge import Gauge
from scara_iso.recorder.journal import Journal
from scara_iso.recorder.plan import GaugeSpec, Job, RobotLine, Settled, refuse_unreadable
from scara_iso.recorder.ports import open_line, open_port
from scara_iso.recorder.ports.device import refuse_same_device
from scara_iso.recorder.ports.port import Clock, Port, is_device, port_kind
from scara_iso.recorder.ports.replay import replayed_poses
from scara_iso.recorder.robot_line import RobotOperator
from scara_iso.recorder.session import Session

_RAW = ".raw.jsonl"


def table_of(history: History, excel_locale: str | None = None) -> bytes:
    """Return the table, spelled as the recording says where ``excel_locale`` is None.

    Raises `DataError` where no cycle is complete.
    """
    from scara_iso.tables import find_locale, write_table  # noqa: PLC0415 - only once, at the end

    run = history.run()
    locale = find_locale(excel_locale or history.header.get("excel_locale"))
    # A file name or option need not be valid text; the readings must not be lost for that.
    return write_table(run, locale).encode("utf-8", "backslashreplace")


def write_table_of(
    history: History, table: Path, data: bytes, *, disk: Disk, beside: bool = True
) -> None:
    """Write a table and, where its raw file is ``beside`` it, their manifest.

    What a crash between the two leaves of a new table must not look as if someone had changed it:
    it comes after its manifest. One that is replaced comes before; until a `rebuild` it does.
    """
    files, manifest = {table: data}, manifest_path(table)
    with _writing(table):
        if beside:
            made = manifest_of(table, data, complete=history.is_complete, doubts=history.doubts)
            both = [(table, data), (manifest, made)]
            files = dict(both if manifest.exists() else reversed(both))
        write_atomically(disk, files)


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise WriteError(
            f"cannot be written ({error.strerror or error})",
            where=str(path),
            remedy="the raw file holds every reading: record it elsewhere with `rebuild=True`",
        ) from error


def rebuild(
    raw: Path, table: Path | None, *, disk: Disk, excel_locale: str | None = None
) -> tuple[Path, History]:
    """Write the table that a raw file holds, by default beside it; return both.

    Raises `NoInputError`, `DataError`, `CannotCreateError` where another table is there, and
    `UsageError` for what is no file of a table.
    """
    if table is None and not raw.name.endswith(_RAW):
        raise UsageError(f"{raw.name} is not called NAME{_RAW}", remedy="name OUT.csv too")
    own = _table_beside(raw)
    if table is None:
        table = own
    else:
        check_table_name(table)
    if target_of(table) is None:
        raise UsageError(
            "is a stream or a device, and not a file", where=str(table), remedy="name OUT.csv"
        )
    check_output(table)
    history = read_history(raw)
    found, plain = doubts_beside(raw, history), table_of(history, excel_locale)
    history.inherit(found)
    data = table_of(history, excel_locale)
    beside = table.resolve() == own.resolve()
    is_ours = beside and not find_doubts(table)[0]  # made of less of the same raw file
    if table.exists() and not is_ours and table.read_bytes() not in (plain, data):
        raise CannotCreateError(
            "exists already, with other contents", where=str(table), remedy="name another OUT.csv"
        )
    write_table_of(history, table, data, disk=disk, beside=beside)
    return table, history


def doubts_beside(raw: Path, history: History) -> tuple[str, ...]:
    """Return what the manifest beside a raw file says against it, where there should be one."""
    table = _table_beside(raw)
    if not (history.has_table or manifest_path(table).exists() or table.exists()):
        return ()
    return find_doubts(table)[1]


def _table_beside(raw: Path) -> Path:
    """Return the table of a raw file: as its manifest names it, else as one there, else .csv."""
    usual = raw.with_name(f"{raw.name.removesuffix(_RAW)}.csv")
    names = [usual.name] if usual.exists() else []
    with suppress(OSError):
        names += sorted(path.name for path in raw.parent.iterdir() if path.is_file())
    with suppress(OSError, ValueError, KeyError, TypeError):
        names = [*json.loads(manifest_path(usual).read_text("utf-8"))["sha256"], *names]
    own = (raw.with_name(name) for name in names if name and Path(name).name == name)
    return next((table for table in own if raw_path(table) == raw), usual)


def check_files(table: Path, *, resume: bool) -> None:
    """Raise, before any port is opened, where a recording cannot be kept beside its table.

    As `check_output` and `check_table_name`, `CannotCreateError` where one of its files is there
    already, and `NoInputError` where there is nothing to ``resume``.
    """
    files = (table, raw_path(table), manifest_path(table))
    if not resume:
        check_table_name(table)
    if resume:
        _refuse_missing(table)
    elif is_folder(table):
        raise CannotCreateError(
            "is a folder, and not that of a test",
            where=str(table),
            remedy=f"name a table in it, or make it one: scara-iso test new {table} "
            "`model=MODEL.toml`",
        )
    elif there := next(filter(os.path.lexists, files), None):
        begun = raw_path(table).is_file()
        raise CannotCreateError(
            "exists already",
            where=str(there),
            remedy="use another name" + ", or `resume=True` to continue it" * begun,
        )
    check_output(*files)


def _refuse_missing(table: Path) -> None:
    raw = raw_path(table)
    if not raw.exists():
        raise NoInputError(
            f"is not there: nothing was recorded for {table.name}",
            where=str(raw),
            remedy="check the name, or leave `resume=True` out and begin",
        )


def earlier_of(table: Path) -> History:
    """Return what was recorded for a table; `NoInputError` where nothing was."""
    _refuse_missing(table)
    return read_history(raw_path(table))


def read_earlier(job: Job, ports: Sequence[Port]) -> History:
    """Return what the raw file of a job holds, nothing where it does not go on with one.

    Raises `UsageError` for other gauges than before, `CannotCreateError` for a table that is not
    made of the raw file, and `DataError` for a raw file that cannot be resumed.
    """
    raw = raw_path(job.table)
    if not job.resume:
        return History(str(raw))
    history = read_history(raw)
    if history.header or history.faults:
        history.check()
        refuse_other_gauges(job, history, ports)
    if job.table.exists() and find_doubts(job.table)[0] and not _is_made_of(history, job.table):
        raise CannotCreateError(
            "was changed after it was recorded",
            where=str(job.table),
            remedy="move it away: it would be written anew from the raw file",
        )
    history.inherit(doubts_beside(raw, history))
    visit = history.visit
    if any(later > visit and history.present(later) for later in history.times):
        raise DataError(
            f"{history.tour.name(visit)} is missing and later ones are there",
            where=history.source,
            remedy="make the table of what is there with `rebuild=True`, and repeat the test",
        )
    return history


def _is_made_of(history: History, table: Path) -> bool:
    try:
        return table.read_bytes() == table_of(history)
    except DataError:  # no cycle is complete
        return False


def _strike_cut_short(earlier: History, journal: Journal, tell: Callable[[Said], None]) -> None:
    """Strike out half a visit, and say so: what comes now is of another."""
    visit, reason = earlier.visit, "the cycle was cut short"
    if cut := sorted(earlier.present(visit)):
        journal.append("void", **earlier.tour.state(visit), axes=cut, reason=reason)
        earlier.strike(visit, cut)
        half = f"{', '.join(cut)} of {earlier.tour.name(visit)}"
        tell(Noticed("", f"{half} struck out: {reason}"))


def _write_header(job: Job, gauges: Sequence[Gauge], earlier: History, journal: Journal) -> None:
    """Put the record ``session`` on the disk: all that the table needs and no reading says."""
    stated = {
        gauge.axis: {
            "spec": spec.text,
            "dialect": spec.dialect.key,
            "line": str(spec.dialect.line),
            "identity": gauge.port.identity,
            "unit": gauge.unit,
            "unit_from": gauge.unit_from,
            "unit_confirmed": gauge.port.unit_confirmed,
            "simulated": gauge.port.simulated,
        }
        for spec, gauge in zip(job.gauges, gauges, strict=True)
    }
    poses = job.plan.tour.poses
    journal.append(
        "session",
        schema=SCHEMA,
        cycles=job.plan.cycles,
        trigger=str(job.plan.trigger),
        gauges=stated,
        metadata=dict(job.metadata),
        excel_locale=job.excel_locale,
        doubts=list(earlier.doubts),
        **({"poses": list(poses)} if poses else {}),
    )
    journal.sync()


_GO_ON = "then continue with `resume=True`"
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
    remarks: Callable[[Mapping[str, str], date], Iterable[str]] = lambda _head, _day: (),
) -> None:
    """Record a job and write its table, however the session ends.

    After a `WriteError` the table is not written: the raw file holds every announced reading.
    ``attended`` says that the operator can answer a question, ``typed`` gives
    the lines of the port ``keyboard:``, ``remarks`` what is to be noticed of the table's head on
    the day of the session. Raises what `Session.run` raises,
    and `CannotCreateError` where files are there already.
    Nothing is left behind where no reading was stored.
    """
    check_files(job.table, resume=job.resume)
    refuse_unreadable(job)
    with ExitStack() as stack:
        ports = _open_ports(job, clock, stack, typed)
        with _recorded(job, ports, stack, disk, clock, tell) as (journal, earlier):
            units = {axis: column.unit for axis, column in earlier.columns.items()}
            gauges = [
                Gauge(spec, port, before=units.get(spec.axis), poses=len(job.plan.tour))
                for spec, port in zip(job.gauges, ports, strict=True)
            ]
            _write_header(job, gauges, earlier, journal)
            _strike_cut_short(earlier, journal, tell)
            wall = clock.wall()  # None of a simulation, which has no date
            earlier.timeline.at({"event": "session", "t": clock.now(), "wall": wall})
            head = {**earlier.header.get("metadata", {}), **job.metadata}
            of_head = remarks(head, date.fromisoformat(wall[:10])) if wall else ()
            for remark in (*earlier.timeline.jumps, *of_head):
                tell(Noticed("", remark))
            robot = _robot(job, earlier, journal, operator, tell, clock, stack)
            Session(
                gauges,
                job=job,
                journal=journal,
                clock=clock,
                operator=robot or operator,
                tell=robot.told if robot else tell,
                earlier=earlier,
                attended=attended,
            ).run()
            if robot is not None:
                robot.finish(clock)


def _robot(
    job: Job,
    earlier: History,
    journal: Journal,
    operator: Operator,
    tell: Callable[[Said], None],
    clock: Clock,
    stack: ExitStack,
) -> RobotOperator | None:
    """Return the robot that paces the session beside its operator, where one does.

    A line that is open already stays so.
    """
    trigger = job.plan.trigger
    if not isinstance(trigger, RobotLine):
        return None
    line = trigger.line or stack.enter_context(closing(open_line(trigger.address, clock)))
    names = earlier.covariates
    robot = RobotOperator(line, operator, job=job, journal=journal, tell=tell, names=names)
    stack.callback(robot.leave)
    return robot


def _open_ports(
    job: Job, clock: Clock, stack: ExitStack, typed: Callable[[], bytes] | None
) -> list[Port]:
    refuse_same_device({g.axis: g.address for g in job.gauges if is_device(g.address)})
    ports = []
    for spec in job.gauges:
        _refuse_unfit(spec, job)
        port = open_port(
            spec.address,
            spec.dialect,
            axis=spec.axis,
            clock=clock,
            asked=job.plan.trigger != "data",
            watched=isinstance(job.plan.trigger, Settled),
            typed=typed,
        )
        stack.callback(port.close)
        ports.append(port)
    return ports


def _refuse_unfit(spec: GaugeSpec, job: Job) -> None:
    """Raise `UsageError` for a recorded stream or a keyboard that the job asks too much of."""
    kind, what, remedy = port_kind(spec.address), "", ""
    if kind == "replay" and job.resume:
        what = "a recorded stream cannot be resumed: record it into a new file"
        remedy = "leave `resume=` out, and name another table"
    elif kind == "replay" and job.plan.stable > 1:
        what = "a recorded stream cannot be asked again for a settled reading"
        remedy = "leave `stable=` out"
    elif (poses := replayed_poses(spec.address)) and poses != job.plan.tour.poses:
        what = f"{spec.address} was recorded at {','.join(poses)}"
        remedy = f"give `pose={','.join(poses)}`"
    elif is_device(spec.address) and str(job.plan.trigger).startswith("replay:"):
        what = "a recorded robot brings no arm to this indicator"
        remedy = f"replay the gauges of that file too: {spec.axis}=DRIVER@{job.plan.trigger}"
    elif kind == "keyboard" and job.plan.trigger != "data":
        what = "a typed line is reading and trigger at once"
        remedy = "leave the trigger out, or give `trigger=data`"
    if what:
        raise UsageError(what, where=f"gauge {spec.axis}", remedy=remedy)


@contextmanager
def _recorded(
    job: Job,
    ports: Sequence[Port],
    stack: ExitStack,
    disk: Disk,
    clock: Clock,
    tell: Callable[[Said], None],
) -> Iterator[tuple[Journal, History]]:
    """Open the raw file, and make its table however the session ends.

    Only a `WriteError` goes past the table. An interrupt waits until what is begun is whole.
    """
    with Later():
        journal = Journal(raw_path(job.table), disk=disk, clock=clock, new=not job.resume)
        stack.callback(journal.close)
        earlier = read_earlier(job, ports)  # while the journal locks it
        journal.previous = earlier.previous
    try:
        yield journal, earlier
    except WriteError as error:
        if not _keeps_readings(journal):
            error.remedy = f"make room, {_GO_ON}; or name another place"
            if not (job.resume or journal.failed):  # a disk that failed is left as it is
                error.remedy = f"make room, or name another place, {_BEGIN}"
                with suppress(WriteError):
                    _remove([journal.path], disk)
        raise
    except InstrumentError as error:
        with Later():
            _end(job, journal, disk, tell)
        error.remedy += f", {_GO_ON if _keeps_readings(journal) else _BEGIN}"
        raise
    except BaseException:
        with Later():
            _end(job, journal, disk, tell)
        raise
    with Later():
        no_table = _end(job, journal, disk, tell)
    if no_table:
        raise no_table


def _keeps_readings(journal: Journal) -> bool:
    try:
        history = read_history(journal.path)
    except (OSError, ScaraIsoError):
        return journal.path.exists()  # and may hold some
    return bool(history.latest or history.troubles["voided"])


def _end(
    job: Job, journal: Journal, disk: Disk, tell: Callable[[Said], None]
) -> InstrumentError | None:
    """Write table and manifest from what the raw file holds; return why there is no table."""
    history = read_history(journal.path)
    if not history.latest and not history.troubles["voided"] and not history.damaged:
        _remove([journal.path], disk)
        return InstrumentError(
            "no reading was recorded, and no file is kept",
            remedy="scara-iso ports with `probe=PORT` shows what an indicator sends",
        )
    journal.append("end", complete=history.is_complete)
    journal.sync()
    if not history.complete_visits():
        _remove([job.table, manifest_path(job.table)] if job.resume else [], disk)
        return InstrumentError(
            f"no cycle is complete, so there is no table; {journal.path.name} holds the readings",
            where=str(job.table),
            remedy="continue with `resume=True`",
        )
    if job.table.exists() and not job.resume and find_doubts(job.table)[0]:
        raise CannotCreateError(
            "was written by another program meanwhile",
            where=str(job.table),
            remedy=f"record with `rebuild=True`, {journal.path} and another name makes the table",
        )
    write_table_of(history, job.table, table_of(history), disk=disk)
    tell(Done(history.cycles, job.plan.cycles, str(job.table), str(journal.path)))
    return None


def _remove(paths: Iterable[Path], disk: Disk) -> None:
    for path in paths:
        with _writing(path):
            disk.remove(path)
            disk.sync_folder(path.parent)
