"""Statements and columns to a `Run`, after the checks that need the whole table."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.condition_columns import UNITS, unit_of_condition
from scara_iso.origin import Origin, TableField
from scara_iso.pose_columns import Commanded, arrival_labels, check_clusters, number_cycles
from scara_iso.run import Axis, FloatArray, IntArray, Run, beyond_dials
from scara_iso.tables.body import Body
from scara_iso.tables.clocks import seconds_of_stamps, with_clock
from scara_iso.tables.columns import Columns
from scara_iso.tables.corrections import corrected
from scara_iso.tables.faults import Faults, quoted
from scara_iso.tables.header import called, check_header_names, said_sizes, said_units
from scara_iso.tables.layout import Layout
from scara_iso.tables.marks import check_marks
from scara_iso.tables.names import Column, Kind
from scara_iso.tables.poses import find_commands, find_pose
from scara_iso.tables.preamble import Statement, read_preamble
from scara_iso.tables.slips import check_counts, check_factors, check_metres, ends_in_mean
from scara_iso.tables.statements import Scale, is_of_axes, of_no_axis, read_scales
from scara_iso.tables.text import Row

_NOTES = 50
_MANY = 1_000_000
"""Rows of no test that is read off by hand."""
_DIRECTION = re.compile("direction|richtung")
_SIGNS = (-1, 0, 1)


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
    _check_directions(columns, faults)
    check_counts(columns, faults)
    check_factors(rows, statements, layout.header_line, faults)
    body.check_blocks()
    lines = columns.all_lines()
    if not len(lines) and not faults.total:
        faults.add("a header and no rows", layout.header_line, remedy="add the readings")
    scales = _scales(columns, statements, options, faults)
    faults.check()
    run, clocks = with_clock(_run(columns, lines, scales, statements, faults), columns)
    run = _corrected(run, faults)
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


def _check_directions(columns: Columns, faults: Faults) -> None:
    """Refuse an axis called a direction whose numbers are nothing but signs."""
    for column in columns.layout.of(Kind.AXIS):
        heading = columns.layout.header[column.position]
        if _DIRECTION.search(heading.lower()) and np.isin(columns.numbers(column), _SIGNS).all():
            faults.add(
                f"{quoted(heading)} holds +1, 0 and -1 only: directions, no readings",
                columns.layout.header_line,
                column.position + 1,
                remedy=f"call it approach where it says from which side; {column.name} "
                "where these are readings",
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
        if ends_in_mean(run):
            last = f"{columns.faults.row} {columns.all_lines()[-1]}"
            yield f"{last} is the mean of those above: a reading?"
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
    return Axis(column.name, readings, scale.unit.dimension, *stated)


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
