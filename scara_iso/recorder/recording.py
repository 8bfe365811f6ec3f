"""A recording from its first byte to its files: new, gone on with, or rebuilt."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from scara_iso.errors import (
    CannotCreateError,
    DataError,
    InstrumentError,
    ScaraIsoError,
    UsageError,
    WriteError,
)
from scara_iso.ports import Clock, Port, is_device, is_recorded, open_port, refuse_same_device
from scara_iso.ports.tape import SCHEMA
from scara_iso.recorder.disk import Disk, write_atomically
from scara_iso.recorder.events import Done, Operator, Said
from scara_iso.recorder.gauge import Gauge
from scara_iso.recorder.history import History, read_history
from scara_iso.recorder.journal import Journal
from scara_iso.recorder.manifest import check_manifest, manifest_path, raw_path, write_manifest
from scara_iso.recorder.plan import Listen, Plan
from scara_iso.recorder.session import Position, Session
from scara_iso.recorder.spec import GaugeSpec


@dataclass(frozen=True, slots=True)
class Job:
    """What to record into ``table``; ``resume`` goes on with what is there.

    ``excel_locale`` spells the table for a spreadsheet; None goes on as before.
    """

    table: Path
    gauges: tuple[GaugeSpec, ...]
    plan: Plan
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
) -> None:
    """Record a job and write its table, however the session ends.

    After a `WriteError` the table is not written: the raw file holds every announced reading.
    Raises what `Session.run` raises, and `CannotCreateError` where files are there already.
    Nothing is left behind where no reading was stored.
    """
    with ExitStack() as stack:
        raw = raw_path(job.table)
        if not job.resume:
            refuse_existing(job.table)
        ports = _open_ports(job, clock, stack)
        journal = Journal(raw, disk=disk, clock=clock, new=not job.resume)
        stack.callback(journal.close)
        earlier = _read_earlier(job, raw, disk) if job.resume else History(str(raw))
        try:
            gauges = _begin(job, ports, earlier, journal)
            Session(
                gauges, plan=job.plan, journal=journal, clock=clock, operator=operator, tell=tell,
                position=Position.after(earlier),
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
    _write_header(job, gauges, journal)
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
    if table is None:
        stem = raw.name.removesuffix(".raw.jsonl")
        if stem == raw.name:
            raise UsageError(f"{raw.name} is not called NAME.raw.jsonl", remedy="name OUT.csv too")
        table = raw.with_name(f"{stem}.csv")
    history = read_history(raw)
    text = _table_bytes(history, excel_locale)
    if table.exists() and table.read_bytes() != text:
        raise CannotCreateError(
            "is there and says something else", where=str(table), remedy="name another OUT.csv"
        )
    _write(disk, table, text)
    return table, history


def refuse_existing(table: Path) -> None:
    """Raise `CannotCreateError` where a table or its raw file is there already."""
    for path in (table, raw_path(table)):
        if path.exists():
            raise CannotCreateError(
                "exists already", where=str(path),
                remedy="use another name, or --resume to go on with it",
            )  # fmt: skip


def _open_ports(job: Job, clock: Clock, stack: ExitStack) -> list[Port]:
    refuse_same_device({g.axis: g.address for g in job.gauges if is_device(g.address)})
    ports = []
    for spec in job.gauges:
        if job.resume and is_recorded(spec.address):
            raise UsageError("a recorded stream begins anew: record it into a new file")
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


def _read_earlier(job: Job, raw: Path, disk: Disk) -> History:
    """Return what was recorded before; its manifest holds no longer."""
    if job.table.exists() and any(job.table.name in line for line in check_manifest(job.table)):
        raise CannotCreateError(
            "was changed after it was recorded", where=str(job.table),
            remedy="move it away: it would be written anew from the raw file",
        )  # fmt: skip
    history = read_history(raw)
    if history.header or history.faults:
        history.check()
        _compare(job, history)
    _remove(disk, manifest_path(job.table))
    cycle = history.cycle
    if any(history.present(later) for later in range(cycle + 1, len(history.times) + 1)):
        raise DataError(
            f"cycle {cycle} is missing and later ones are there",
            where=str(raw),
            remedy="--rebuild the table of what is there, and repeat the test",
        )
    return history


def _compare(job: Job, history: History) -> None:
    recorded = {axis: gauge["dialect"] for axis, gauge in history.header["gauges"].items()}
    given = {gauge.axis: gauge.dialect.key for gauge in job.gauges}
    if recorded != given:
        raise UsageError(
            f"recorded with {_listed(recorded)}, and now {_listed(given)}",
            where=history.source,
            remedy="give the same --gauge options, or none",
        )


def _listed(gauges: Mapping[str, str]) -> str:
    return ", ".join(f"{axis}={key}" for axis, key in gauges.items())


def _write_header(job: Job, gauges: Sequence[Gauge], journal: Journal) -> None:
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
            remedy="`scara-iso ports --probe PORT` shows what an indicator sends",
        )
    rows = int(history.complete_rows().sum())
    complete = rows == job.plan.cycles
    journal.append("end", complete=complete)
    journal.sync()
    if not rows:
        _remove(disk, job.table)
        return InstrumentError(
            f"no cycle is complete, so there is no table; {journal.path.name} holds the readings",
            where=str(job.table), remedy="go on with --resume",
        )  # fmt: skip
    _write(disk, job.table, _table_bytes(history))
    try:
        write_manifest(job.table, complete=complete, disk=disk)
    except OSError as error:
        raise _cannot_write(manifest_path(job.table), error) from error
    tell(Done(rows, job.plan.cycles, str(job.table), str(journal.path)))
    return None


def _table_bytes(history: History, excel_locale: str | None = None) -> bytes:
    from scara_iso.tables import find_locale, write_table  # noqa: PLC0415 - only once, at the end

    run = history.run()
    locale = find_locale(excel_locale or history.header.get("excel_locale"))
    # A file name or option need not be valid text; the readings must not be lost for that.
    return write_table(run, locale).encode("utf-8", "backslashreplace")


def _write(disk: Disk, path: Path, data: bytes) -> None:
    try:
        write_atomically(disk, path, data)
    except OSError as error:
        raise _cannot_write(path, error) from error


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
        remedy="the raw file holds every reading: `scara-iso record --rebuild` it elsewhere",
    )
