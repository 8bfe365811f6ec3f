"""`gauge_study`: is the dial good enough for the tolerance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from scara_iso.base.disk import check_output, write_file
from scara_iso.base.errors import UsageError
from scara_iso.gauge import GaugeStudy, Remark, read_gauge_tables, study_gauge
from scara_iso.iso9283 import DecisionRule
from scara_iso.library.inputs import Tables, paths_of, tables_of
from scara_iso.library.sizes import sizes_of
from scara_iso.render import find_format
from scara_iso.reporting import Document, gauge_study_report

SEED = 1


def gauge_study(
    table: Tables,
    *,
    tolerance: float | Mapping[str, float] | None = None,
    reference: float | Mapping[str, float] | None = None,
    unit: str | None = None,
    resolution: float | None = None,
    decimal: str | None = None,
    decision: str = DecisionRule.SIMPLE.value,
    to: str | Path | None = None,
    seed: int = SEED,
) -> GaugeStudy:
    """Return whether a dial is good enough: type 1, R&R, linearity or stability.

    ``table`` is a path, ``-``, bytes or an open file, or several of one study; which study it is
    is told by what the readings name: ``part`` (a recording's ``pose``), ``operator``, ``session``,
    ``reference``. ``tolerance`` (its width) and ``reference`` (the true value) are in the unit of
    the readings, one for all or by axis. ``unit``, ``resolution`` (in it) and ``decimal`` as in
    `read_table`. ``decision`` is ``simple`` (the figure against the guideline's limit, as
    the guidelines do) or ``interval`` (all of its 95 % interval). ``to`` also writes it: .dfq
    (AQDEF) or a form of the report. ``seed`` is of the draws for intervals of several variances.
    Raises `DataError` for a table that cannot be read or makes no study, `UsageError` for options
    that make no sense.
    """
    words = [rule.value for rule in DecisionRule]
    if decision not in words:
        raise UsageError(f"decision {decision!r}", remedy=f"use {' or '.join(words)}")
    _refuse_twice(table)
    write = None if to is None else find_format(Path(to).name, Path(to).suffix)
    if to is not None:
        check_output(Path(to))
    read = read_gauge_tables(
        tables_of(table),  # type: ignore[arg-type]  # a Run or a frame is refused when read
        unit=unit,
        resolution=resolution,
        decimal=decimal,
        references=sizes_of("reference", reference),
        tolerances=_positive(sizes_of("tolerance", tolerance)),
    )
    found = study_gauge(read, decision=DecisionRule(decision), seed=seed)
    found = replace(found, remarks=(*_changed(table), *found.remarks))
    if to is not None and write is not None:
        write_file(Path(to), write(Document("Gauge study", gauge_study_report(found), found)))
    return found


def _refuse_twice(table: Tables) -> None:
    paths = [Path(path).resolve() for path in paths_of(table)]
    twice = [path for k, path in enumerate(paths) if path in paths[:k]]
    if twice:
        raise UsageError(
            f"{twice[0].name} is named twice", remedy="name it once: its readings would count twice"
        )


def _positive(sizes: Mapping[str, float]) -> Mapping[str, float]:
    wrong = [size for size in sizes.values() if not 0 < size < 1e9]
    if wrong:
        raise UsageError(f"`tolerance={wrong[0]:g}`", remedy="give its width, above zero")
    return sizes


def _changed(table: Tables) -> tuple[Remark, ...]:
    """Return a remark for each file that changed since it was recorded."""
    from scara_iso.rawfile import check_manifest

    found = dict.fromkeys(line for path in paths_of(table) for line in check_manifest(path))
    return tuple(Remark("warning", "", line) for line in found)
