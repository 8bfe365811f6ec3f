"""Statements and columns to a `Run`, after the checks that need the whole table.

When each row was read: instants, or a clock's time of day, to seconds from the first row.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.run import (
    UNITS,
    Axis,
    Commanded,
    FloatArray,
    IntArray,
    Origin,
    Run,
    TableField,
    arrival_labels,
    beyond_dials,
    check_clusters,
    number_cycles,
    unit_of_condition,
)
from scara_iso.tables.body import Body, check_marks
from scara_iso.tables.columns import Columns
from scara_iso.tables.doubts import (
    check_columns,
    check_metres,
    check_readings,
)
from scara_iso.tables.faults import Faults, quoted
from scara_iso.tables.layout import Layout, called, check_header_names, said_sizes, said_units
from scara_iso.tables.names import CLOCKS, DATES, Column, Kind, plain_key
from scara_iso.tables.numbers import BLANKS
from scara_iso.tables.poses import find_commands, find_pose
from scara_iso.tables.preamble import Statement, read_preamble
from scara_iso.tables.statements import (
    Scale,
    corrected,
    is_of_axes,
    of_no_axis,
    read_scales,
    refuse_unused,
)
from scara_iso.tables.text import Row

_CLOCK = re.compile(
    r"([01]?[0-9]|2[0-3]):([0-5][0-9]):([0-5][0-9](?:[.,][0-9]{1,9})?)(?: ?([ap])\.?m\.?)?",
    re.IGNORECASE,
)
_DAY, _NOON = 86_400.0, 43_200.0
_STAMP = "write date and time as 2026-05-12T08:30:00 in a column timestamp"


def seconds_of_stamps(
    column: Column, columns: Columns, lines: IntArray, metadata: dict[str, str], faults: Faults
) -> FloatArray:
    """Return seconds from the first row's instant, which is kept as ``timestamp_start``."""
    stamps = [stamp for stamp in columns.stamps(column) if stamp is not None]
    start = stamps[0]
    for line, stamp in zip(lines.tolist(), stamps, strict=True):
        if (stamp.tzinfo is None) != (start.tzinfo is None):
            faults.add(
                "some times state their offset from UTC and some do not",
                line,
                column.position + 1,
                remedy="write all times with their offset, as +01:00, or all without",
            )
            return np.zeros(len(lines))
    metadata.setdefault("timestamp_start", start.isoformat())
    return np.array([(stamp - start).total_seconds() for stamp in stamps])


def with_clock(run: Run, columns: Columns) -> tuple[Run, dict[Column, str]]:
    """Return the run with the times of a clock's column as ``time_s``, where they are sure.

    They are where they go on from row to row, or within each pose, and pass midnight once at most.
    Beside the run is what to say of each clock, used or not.
    """
    layout = columns.layout
    clocks = [c for c in layout.of(Kind.COMMENT) if plain_key(c.name) in CLOCKS]
    said: dict[Column, str] = {}
    for column in clocks:
        found = (
            "there is another time" if "time_s" in run.covariates else _times(run, columns, column)
        )
        if isinstance(found, str):
            said[column] = f"{called(layout, column)} not used as the time: {found}"
            continue
        first = str(columns.labels(column)[0]).strip(BLANKS)
        said[column] = f"{called(layout, column)} is the time of each row, from {first} on"
        run = replace(run, covariates={**run.covariates, "time_s": found})
    return run, said


def _times(run: Run, columns: Columns, column: Column) -> FloatArray | str:
    """Return seconds from the first row, shape (rows,), or why the clock does not tell them."""
    read = [_seconds_of_day(str(cell)) for cell in columns.labels(column)]
    lines, row = columns.all_lines(), columns.faults.row
    wrong = next((k for k, seconds in enumerate(read) if seconds is None), None)
    if wrong is not None:
        return f"{row} {lines[wrong]} holds no time such as 14:03:22"
    day = np.array(read, dtype=np.float64)
    backward = np.flatnonzero(np.diff(day) < 0) + 1
    midnights = backward[np.diff(day)[backward - 1] < -_NOON]
    named = [c for c in columns.layout.of(Kind.COMMENT) if plain_key(c.name) in DATES]
    dates = [labels for labels in map(columns.labels, named) if all(labels)]
    changes = [np.flatnonzero(date[1:] != date[:-1]) + 1 for date in dates]
    if not all(np.array_equal(rows, midnights) for rows in changes):
        return f"the date changes at other rows than at midnight; {_STAMP}"
    if len(midnights) > 1:
        return f"it passes midnight {len(midnights)} times; {_STAMP}"
    in_turn = all(np.all(np.diff(day[rows]) >= 0) for _, rows in run.rows_by_pose())
    if len(backward) > len(midnights) and (len(midnights) or not in_turn):
        return f"it goes back in {row} {lines[backward[0]]}; {_STAMP}"
    if np.ptp(day) == 0:
        return "it stands still"
    passed = np.arange(len(day)) >= (midnights[0] if len(midnights) else len(day))
    return np.asarray(np.round(day + _DAY * passed - day[0], 9))


def _seconds_of_day(text: str) -> float | None:
    found = _CLOCK.fullmatch(text.strip(BLANKS))
    if found is None:
        return None
    hour, minute, second = int(found[1]), int(found[2]), float(found[3].replace(",", "."))
    if found[4]:
        hour = hour % 12 + 12 * (found[4].lower() == "p")
    return hour * 3600 + minute * 60 + second


_NOTES = 50
_MANY = 1_000_000
"""Rows of no test that is read off by hand."""


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """What the user says about a file, None where nothing."""

    unit: str | None
    resolution: float | None
    decimal: str | None
    sheet: str | None
    columns: tuple[str, ...] | None = None


def assemble(rows: list[Row], columns: Columns, body: Body, options: ReadOptions, how: str) -> Run:
    """Return the run that the head ``rows``, ``columns`` and ``body`` hold, or raise `DataError`.

    ``how`` says how the file was split into cells.
    """
    faults, layout = columns.faults, columns.layout
    statements, notes = read_preamble(rows, layout.header_line, faults)
    check_header_names(layout, faults)
    sizes = [stated.value for key, stated in statements.items() if is_of_axes(key)]
    check_marks(columns, options.decimal, faults, sizes)
    _check_covariates(columns, faults)
    check_columns(columns, statements, faults)
    refuse_unused([row for row in rows if row.line < layout.header_line], faults)
    body.check_blocks()
    lines = columns.all_lines()
    if not len(lines) and not faults.total:
        faults.add("a header and no rows", layout.header_line, remedy="add the readings")
    scales = _scales(columns, statements, options, faults)
    faults.check()
    run, clocks = with_clock(_run(columns, lines, scales, statements, faults), columns)
    run = _corrected(run, faults)
    check_readings(run, {name: scales[name].unit.to_base(1.0) for name in run.axes}, faults)
    _check_repeats(run, lines, body.repeats, faults)
    faults.check()
    comments = layout.of(Kind.COMMENT)
    texts = {layout.header[c.position]: columns.codes(c) for c in comments}
    beside = {**run.covariates, **texts}
    check_clusters(run.axes, run.rows_by_pose(), beside, run.metadata, where=faults.where)
    notes += [clocks.get(c, f"{called(layout, c)} not used") for c in comments]
    notes += [*of_no_axis(statements, run.axes), *said_units(layout), *said_sizes(layout)]
    notes += columns.beside[:_NOTES] + body.notes
    parts = (how, _said_columns(run, scales, lines, faults.row), run.origin.understood)
    understood = "; ".join(filter(None, parts))
    notes[:0] = _said_numbers(columns, run)
    units = {name: scales[name].unit.name for name in run.axes}
    origin = Origin(
        source=faults.where,
        understood=understood,
        notes=tuple(notes),
        units=units,
        header_line=None if options.columns else layout.header_line or None,
        fields=tuple(_field(column, layout, units) for column in layout.columns),
        sheet=faults.sheet,
    )
    return replace(run, origin=origin)


def _field(column: Column, layout: Layout, units: Mapping[str, str]) -> TableField:
    named = column.kind in (Kind.AXIS, Kind.COMMAND, Kind.COVARIATE)
    unit = units.get(column.name, "") if column.kind in (Kind.AXIS, Kind.COMMAND) else ""
    header, name = layout.header[column.position], column.name if named else ""
    return TableField(header, column.kind.value, name, unit)


def _check_covariates(columns: Columns, faults: Faults) -> None:
    for column, seen in columns.units.items():
        named = unit_of_condition(column.unit)
        other = [unit for unit in seen if unit and unit_of_condition(unit) != named]
        if column.kind is Kind.COVARIATE and named in UNITS and other:
            faults.add(
                f"{column.name}: {quoted(other[0])} behind a value",
                seen[other[0]],
                column.position + 1,
                remedy="let the column's name and its values state the same unit",
            )
            continue
        if column.kind is Kind.COVARIATE and len(seen) > 1:
            *_, (unit, line) = seen.items()
            faults.add(
                f"{column.name}: {quoted(unit)} behind a value, another unit above",
                line,
                column.position + 1,
                remedy="write the unit once, in the column's name, and plain numbers below it",
            )


def _scales(
    columns: Columns, statements: dict[str, Statement], options: ReadOptions, faults: Faults
) -> dict[str, Scale]:
    behind = {c.name: units for c, units in columns.units.items() if c.kind is Kind.AXIS}
    return read_scales(
        columns.layout.of(Kind.AXIS),
        columns.layout.header_line,
        statements,
        behind,
        unit=options.unit,
        resolution=options.resolution,
        faults=faults,
    )


def _run(
    columns: Columns,
    lines: IntArray,
    scales: dict[str, Scale],
    statements: dict[str, Statement],
    faults: Faults,
) -> Run:
    layout = columns.layout
    metadata = {key: s.value for key, s in statements.items() if not is_of_axes(key)}
    covariates = {c.name: _recorded(c, columns) for c in layout.of(Kind.COVARIATE)}
    pose = find_pose(columns, covariates)
    commands = find_commands(columns, scales, pose, metadata, faults)
    axes = {
        c.name: _axis(c, columns, lines, scales[c.name], commands.get(c.name), faults)
        for c in layout.of(Kind.AXIS)
    }
    for column in layout.of(Kind.TIMESTAMP):
        covariates["time_s"] = seconds_of_stamps(column, columns, lines, metadata, faults)
    faults.check()
    counters = layout.of(Kind.CYCLE)
    counted = columns.counts(counters[0]) if counters else None
    direction = next((columns.labels(c) for c in layout.of(Kind.DIRECTION)), None)
    return Run(
        cycle=number_cycles(counted, arrival_labels(pose, direction), len(lines)),
        axes=axes,
        pose=pose,
        covariates=covariates,
        metadata=metadata,
        lines=lines,
        origin=Origin(faults.where),
        direction=direction,
    ).unwrapped()


def _recorded(column: Column, columns: Columns) -> FloatArray:
    values = columns.numbers(column)
    return values if column.condition is None else column.condition.to_base(values)


def _corrected(run: Run, faults: Faults) -> Run:
    found, wrong = corrected(run)
    for fault in wrong:
        faults.add(fault, remedy="correct the statements above the table, or leave them out")
    return found


def _said_numbers(columns: Columns, run: Run) -> Iterator[str]:
    counters = columns.layout.of(Kind.CYCLE)
    if len(run) > _MANY:
        yield (
            f"{len(run)} rows: for the figures of many robots use the command fleet, "
            "for samples in time the command visits"
        )
    if not counters and run.pose is None:
        yield f"no cycle column: rows numbered 1 to {len(run)} in their order"
    elif not counters:
        yield "no cycle column: the n-th row of a pose is its cycle n"
    elif not np.array_equal(columns.counts(counters[0]), run.cycle):
        yield "the cycle column counts all visits: the n-th of a pose is its cycle n"


def _axis(
    column: Column,
    columns: Columns,
    lines: IntArray,
    scale: Scale,
    command: Commanded,
    faults: Faults,
) -> Axis:
    if scale.unit.name == "m":
        place = columns.layout.header_line, column.position + 1
        check_metres(columns.numbers(column), column.name, place, faults)
    readings, unit = columns.numbers(column), scale.unit
    if unit.numerator != unit.denominator:
        with np.errstate(over="ignore"):
            readings = unit.to_base(readings)
    for k in np.flatnonzero(beyond_dials(readings)).tolist():
        faults.add(
            f"a reading beyond any dial, in {scale.unit.name}",
            int(lines[k]),
            column.position + 1,
            remedy="look for a slip of the decimal mark there, and whether the unit is true",
        )
    stated = scale.resolution, scale.uncertainty, command
    return Axis(column.name, readings, unit.dimension, *stated, stated_unit=unit.other)


def _check_repeats(run: Run, lines: IntArray, repeats: list[int], faults: Faults) -> None:
    """Find a second table under a repeated header: the cycles of a pose begin again."""
    for line in repeats:
        k = int(np.searchsorted(lines, line))
        if not 0 < k < len(run) or run.cycle[k] > run.cycle[k - 1]:
            continue
        if run.pose is None or run.pose[k] == run.pose[k - 1]:
            faults.add(
                "a second table begins: the header again, then cycle "
                f"{run.cycle[k]} after {run.cycle[k - 1]}",
                line,
                remedy="leave one table in the file",
            )


def _said_columns(run: Run, scales: dict[str, Scale], lines: IntArray, row: str) -> str:
    units = {name: scales[name].unit.name for name in run.axes}
    parts = [
        f"{' '.join(name for name in units if units[name] == unit)} in {unit}"
        for unit in dict.fromkeys(units.values())
    ]
    labelled = {"pose": run.pose, "approach": run.direction}
    also = [name for name, labels in labelled.items() if labels is not None] + list(run.covariates)
    text = ", ".join(parts) + (f"; also {', '.join(map(_short, also))}" if also else "")
    return f"{text}; {len(lines)} rows ({row}s {lines[0]}-{lines[-1]})"


def _short(name: str) -> str:
    return name if name.isprintable() and len(name) <= 30 else quoted(name)
