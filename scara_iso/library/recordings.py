"""`record`: serial indicators to a table, without a terminal."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from scara_iso import acquisition
from scara_iso.acquisition import (
    Command,
    Job,
    Operator,
    RecordingPlan,
    Said,
    SystemDisk,
    Tour,
    check_metadata,
    choose_clock,
    is_recorded,
    name_dialects,
    parse_gauges,
    parse_poses,
    parse_trigger,
)
from scara_iso.iso9283 import CYCLES_RUN
from scara_iso.run import Run
from scara_iso.tables import read_table

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
    cycles: int = CYCLES_RUN,
    pose: str | Sequence[str] | None = None,
    stable: int = 1,
    rearm: float | None = None,
    unit: str | None = None,
    metadata: Mapping[str, str] | None = None,
    resume: bool = False,
    excel_locale: str | None = None,
    operator: Operator | None = None,
    tell: Callable[[Said], None] | None = None,
) -> Run:
    """Record indicators into ``table`` and return what is then in it.

    ``gauges`` are ``AXIS=DRIVER@PORT``, ``trigger`` is ``data``, ``timer:SECONDS``, or ``enter``
    with an ``operator`` whose ``poll()`` gives the commands. ``tell`` hears each event, a stored
    reading only once it is safe on the disk. ``stable`` readings in a row must agree; none counts
    within ``rearm`` seconds of the last (0.5, for recorded streams 0). ``pose`` names the poses
    of every cycle, in their order: ``"P1,P2"`` or a sequence. ``metadata`` goes into the
    table's head. Raises `UsageError` for invalid options, `InstrumentError` for a
    port, `CannotCreateError` and `WriteError` for the files.
    """
    specs = parse_gauges(name_dialects(gauges, lambda _: None), unit=unit)
    recorded = all(is_recorded(spec.address) for spec in specs)
    pause = rearm if rearm is not None else 0.0 if recorded else _REARM_S
    tour = Tour() if pose is None else Tour(parse_poses(pose))
    job = Job(
        Path(table),
        specs,
        RecordingPlan(parse_trigger(trigger), cycles, stable, pause, tour),
        check_metadata(dict(metadata or {})),
        resume,
        excel_locale,
    )
    acquisition.record(
        job,
        disk=SystemDisk(),
        clock=choose_clock(spec.address for spec in specs),
        operator=operator or Nobody(),
        tell=tell or (lambda _: None),
    )
    return read_table(table)
