"""A recording from its first byte to its files: new, resumed, or rebuilt."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from scara_iso.acquisition.manifest import find_doubts, manifest_of, manifest_path, raw_path
from scara_iso.acquisition.ports import (
    Clock,
    Port,
    is_device,
    is_recorded,
    open_port,
    refuse_same_device,
)
from scara_iso.acquisition.ports.tape import SCHEMA
from scara_iso.acquisition.recorder.events import Done, Noticed, Operator, Said
from scara_iso.acquisition.recorder.gauge import Gauge
from scara_iso.acquisition.recorder.history import History, read_history
from scara_iso.acquisition.recorder.journal import Journal
from scara_iso.acquisition.recorder.plan import Listen, RecordingPlan
from scara_iso.acquisition.recorder.position import Position
from scara_iso.acquisition.recorder.session import Session
from scara_iso.acquisition.recorder.spec import GaugeSpec
from scara_iso.disk import Disk, write_atomically
from scara_iso.errors import (
    CannotCreateError,
    DataError,
    InstrumentError,
    ScaraIsoError,
    UsageError,
    WriteError,
)


@dataclass(frozen=True, slots=True)
class Job:
    """What to record into ``table``; ``resume`` goes on with what is there.

    ``excel_locale`` spells the table for a spreadsheet; None goes on as before.
    """

    table: Path
    gauges: tuple[GaugeSpec, ...]
    plan: RecordingPlan
    metadata: Mapping[str, str] = field(default_factory=dict)
    resume: bool = False
    excel_locale: str | None = None


def record(
    job: Job,
    *,
    disk: Disk,
    clock: Clock,
    operator: Operator,
    tell: Callable[[Said], None],
    attended: bool = False,
) -> None:
    """Record a job and write its table, however the session ends.

    After a `WriteError` the table is not written: the raw file holds every announced reading.
    ``attended`` says that the operator can answer a question. Raises what `Session.run` raises,
    and `CannotCreateError` where files are there already.
    Nothing is left behind where no reading was stored.
    """
    with ExitStack() as stack:
        raw = raw_path(job.table)
        if not job.resume:
            refuse_existing(job.table)
        ports = _open_ports(job, clock, stack)
        journal = Journal(raw, disk=disk, clock=clock, new=not job.resume)
        stack.callback(journal.close)
        earlier = _read_earlier(job, raw) if job.resume else History(str(raw))
        journal.previous = earlier.previous
        try:
            gauges = _begin(job, ports, earlier, journal)
            earlier.timeline.at({"event": "session", "t": clock.now(), "wall": clock.wall()})
            for jump in earlier.timeline.jumps:
                tell(Noticed("", jump))
            Session(
                gauges, plan=job.plan, journal=journal, clock=clock, operator=operator, tell=tell,
                position=Position.after(earlier), attended=attended,
            ).run()  # fmt: skip
        except WriteError:
            raise
        except BaseException:
            _finish(job, journal, disk, tell)
            raise
        if nothing := _finish(job, journal, disk, tell):
            raise nothing


def _begin(job: Job, ports: Sequence[Port], earlier: History, journal: Journal) -> list[Gauge]:
    """Write the header; strike out what a crash left of a cycle whose gauges are asked together."""
    specs = zip(job.gauges, ports, strict=True)
    gauges = [_gauge(spec, port, earlier) for spec, port in specs]
    _write_header(job, gauges, earlier, journal)
    cycle = earlier.cycle
    if cut := earlier.cut_short():
        journal.append("void", cycle=cycle, axes=cut, reason="the cycle was cut short")
        earlier.strike(cycle, cut)
    return gauges


def rebuild(
    raw: Path, table: Path | None, *, disk: Disk, excel_locale: str | None = None
) -> tuple[Path, History]:
    """Write the table that a raw file holds, by default beside it; return both.

    Raises `NoInputError`, `DataError`, or `CannotCreateError` where another table is there.
    """
    history = read_history(raw)
    if table is None:
        table = _table_of(raw)
        if raw_path(table) != raw:
            raise UsageError(f"{raw.name} is not called NAME.raw.jsonl", remedy="name OUT.csv too")
    found, plain = _doubts_beside(raw, history), _table_bytes(history, excel_locale)
    history.inherit(found)
    data = _table_bytes(history, excel_locale)
    if table.exists() and table.read_bytes() not in (plain, data):
        raise CannotCreateError(
            "is there and says something else", where=str(table), remedy="name another OUT.csv"
        )
    _write(disk, table, data, history, beside=raw_path(table).resolve() == raw.resolve())
    return table, history


def _table_of(raw: Path) -> Path:
    return raw.with_name(f"{raw.name.removesuffix('.raw.jsonl')}.csv")


def _doubts_beside(raw: Path, history: History) -> tuple[str, ...]:
    """Return what the manifest beside a raw file says against it, where there should be one."""
    table = _table_of(raw)
    if not history.has_table and not manifest_path(table).exists():
        return ()
    return find_doubts(table).recording


def refuse_existing(table: Path) -> None:
    """Raise `CannotCreateError` where a table, its raw file or its manifest is there already."""
    for path in (table, raw_path(table), manifest_path(table)):
        if path.exists():
            raise CannotCreateError(
                "exists already", where=str(path),
                remedy="use another name, or `resume=True` to go on with it",
            )  # fmt: skip


def _open_ports(job: Job, clock: Clock, stack: ExitStack) -> list[Port]:
    refuse_same_device({g.axis: g.address for g in job.gauges if is_device(g.address)})
    ports = []
    for spec in job.gauges:
        if job.resume and is_recorded(spec.address):
            raise UsageError("a recorded stream starts again: record it into a new file")
        if job.plan.stable > 1 and spec.address.startswith("replay:"):
            raise UsageError("a recorded stream is not asked twice", remedy="leave `stable=` out")
        asked = not isinstance(job.plan.trigger, Listen)
        port = open_port(spec.address, spec.dialect, axis=spec.axis, clock=clock, asked=asked)
        stack.callback(port.close)
        ports.append(port)
    return ports


def _gauge(spec: GaugeSpec, port: Port, earlier: History) -> Gauge:
    """Return the gauge; its unit is that of the readings there are, where there are some."""
    column = earlier.columns.get(spec.axis)
    recorded = column.unit if column else None
    if recorded and spec.unit and recorded != spec.unit:
        raise UsageError(
            f"recorded in {recorded}, and the option says {spec.unit}",
            where=f"gauge {spec.axis}",
            remedy="give the option as before, or none",
        )
    if spec.unit or not recorded:
        return Gauge(spec.axis, spec.dialect, port, unit=spec.unit)
    return Gauge(spec.axis, spec.dialect, port, unit=recorded, unit_from="the session before")


def _read_earlier(job: Job, raw: Path) -> History:
    """Return what was recorded before; a table that is not made of it is not written over."""
    history = read_history(raw)
    if history.header or history.faults:
        history.check()
        _compare(job, history)
    if job.table.exists() and find_doubts(job.table).table and not _is_made_of(history, job.table):
        raise CannotCreateError(
            "was changed after it was recorded", where=str(job.table),
            remedy="move it away: it would be written again from the raw file",
        )  # fmt: skip
    history.inherit(_doubts_beside(raw, history))
    cycle = history.cycle
    if any(history.present(later) for later in range(cycle + 1, len(history.times) + 1)):
        raise DataError(
            f"cycle {cycle} is missing and later ones are there",
            where=str(raw),
            remedy="make the table of what is there with `rebuild=True`, and repeat the test",
        )
    return history


def _is_made_of(history: History, table: Path) -> bool:
    try:
        return table.read_bytes() == _table_bytes(history)
    except DataError:  # no cycle is complete
        return False


def _compare(job: Job, history: History) -> None:
    recorded = {axis: gauge["dialect"] for axis, gauge in history.header["gauges"].items()}
    given = {gauge.axis: gauge.dialect.key for gauge in job.gauges}
    if recorded != given:
        raise UsageError(
            f"recorded with {_listed(recorded)}, and now {_listed(given)}",
            where=history.source,
            remedy="give the same `gauge=` as before, or none",
        )


def _listed(gauges: Mapping[str, str]) -> str:
    return ", ".join(f"{axis}={key}" for axis, key in gauges.items())


def _write_header(job: Job, gauges: Sequence[Gauge], earlier: History, journal: Journal) -> None:
    stated = {
        gauge.axis: {
            "spec": spec.text,
            "dialect": spec.dialect.key,
            "line": str(spec.dialect.line),
            "identity": gauge.port.identity,
            "unit": gauge.unit,
            "unit_from": gauge.unit_from,
            "simulated": gauge.port.simulated,
        }
        for spec, gauge in zip(job.gauges, gauges, strict=True)
    }
    journal.append(
        "session", schema=SCHEMA, cycles=job.plan.cycles, trigger=str(job.plan.trigger),
        gauges=stated, metadata=dict(job.metadata), excel_locale=job.excel_locale,
        doubts=list(earlier.doubts),
    )  # fmt: skip
    journal.sync()


def _finish(
    job: Job, journal: Journal, disk: Disk, tell: Callable[[Said], None]
) -> InstrumentError | None:
    """Write table and manifest from what the raw file holds; return why there is no table."""
    history = read_history(journal.path)
    if not history.latest and not history.troubles["voided"] and not history.damaged:
        _remove(disk, journal.path)
        return InstrumentError(
            "no reading was recorded, and nothing is left behind",
            remedy="scara-iso ports with `probe=PORT` shows what an indicator sends",
        )
    rows = int(history.complete_rows().sum())
    journal.append("end", complete=history.is_complete)
    journal.sync()
    if not rows:
        for path in (job.table, manifest_path(job.table)) if job.resume else ():
            _remove(disk, path)
        return InstrumentError(
            f"no cycle is complete, so there is no table; {journal.path.name} holds the readings",
            where=str(job.table), remedy="go on with `resume=True`",
        )  # fmt: skip
    if job.table.exists() and not job.resume:
        raise CannotCreateError(
            "was written by another program meanwhile", where=str(job.table),
            remedy=f"record with `rebuild=True`, {journal.path} and another name makes the table",
        )  # fmt: skip
    _write(disk, job.table, _table_bytes(history), history, beside=True)
    tell(Done(rows, job.plan.cycles, str(job.table), str(journal.path)))
    return None


def _table_bytes(history: History, excel_locale: str | None = None) -> bytes:
    from scara_iso.tables import find_locale, write_table  # noqa: PLC0415 - only once, at the end

    run = history.run()
    locale = find_locale(excel_locale or history.header.get("excel_locale"))
    # A file name or option need not be valid text; the readings must not be lost for that.
    return write_table(run, locale).encode("utf-8", "backslashreplace")


def _write(disk: Disk, table: Path, data: bytes, history: History, *, beside: bool) -> None:
    """Write a table and, where its raw file is ``beside`` it, their manifest.

    What a crash between the two leaves must not look as if someone had changed it: a new table
    comes after its manifest, one that is replaced before.
    """
    files, manifest = {table: data}, manifest_path(table)
    try:
        if beside:
            made = manifest_of(table, data, complete=history.is_complete, doubts=history.doubts)
            both = [(table, data), (manifest, made)]
            files = dict(both if manifest.exists() else reversed(both))
        write_atomically(disk, files)
    except OSError as error:
        raise _cannot_write(table, error) from error


def _remove(disk: Disk, path: Path) -> None:
    try:
        disk.remove(path)
        disk.sync_folder(path.parent)
    except OSError as error:
        raise _cannot_write(path, error) from error


def _cannot_write(path: Path, error: OSError) -> ScaraIsoError:
    return WriteError(
        f"cannot be written ({error.strerror or error})",
        where=str(path),
        remedy="the raw file holds every reading: `rebuild=True` makes a table elsewhere",
    )
