"""The head of a session: its gauges, and the record that states them before any reading."""

from __future__ import annotations

from collections.abc import Sequence

from scara_iso.acquisition.ports import Port
from scara_iso.acquisition.recorder.gauge import Gauge
from scara_iso.acquisition.recorder.history import History
from scara_iso.acquisition.recorder.journal import Journal
from scara_iso.acquisition.recorder.plan import Job
from scara_iso.acquisition.recorder.spec import GaugeSpec
from scara_iso.acquisition.tape import SCHEMA
from scara_iso.errors import UsageError


def make_gauges(job: Job, ports: Sequence[Port], earlier: History) -> list[Gauge]:
    """Return the gauges of a job; `UsageError` where one states another unit than before."""
    specs = zip(job.gauges, ports, strict=True)
    return [_gauge(spec, port, earlier, poses=len(job.plan.tour)) for spec, port in specs]


def _gauge(spec: GaugeSpec, port: Port, earlier: History, *, poses: int) -> Gauge:
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
        return Gauge(spec.axis, spec.dialect, port, unit=spec.unit, poses=poses)
    return Gauge(
        spec.axis, spec.dialect, port, unit=recorded, unit_from="the session before", poses=poses
    )


def write_header(job: Job, gauges: Sequence[Gauge], earlier: History, journal: Journal) -> None:
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
    journal.append(
        "session",
        schema=SCHEMA,
        cycles=job.plan.cycles,
        trigger=str(job.plan.trigger),
        gauges=stated,
        metadata=dict(job.metadata),
        excel_locale=job.excel_locale,
        doubts=list(earlier.doubts),
        **({"poses": list(job.plan.tour.poses)} if job.plan.tour.poses else {}),
    )
    journal.sync()
