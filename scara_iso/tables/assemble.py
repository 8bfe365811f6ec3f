"""Statements and columns to a `Run`, after the checks that need the whole table.

When each row was read: instants, or a clock's time of day, to seconds from the first row.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from scara_iso.base.moments import is_moment, seconds_of_day
from scara_iso.base.quantities import Dimension, Unit
from scara_iso.run import (
    SEPARATOR,
    UNITS,
    Axis,
    FloatArray,
    Origin,
    Run,
    TableField,
    arrival_labels,
    beyond_dials,
    check_clusters,
    copies,
    number_cycles,
    parted_by,
    unit_of_condition,
)
from scara_iso.tables.body import Body, check_remarks, rare_remarks, rows_in_words
from scara_iso.tables.columns import (
    Columns,
    Labels,
    check_end,
    check_marks,
    check_numbers,
    mark_in_words,
)
from scara_iso.tables.doubts import check_columns, check_header, check_readings, declared_in_words
from scara_iso.tables.grid import CellGrid, Faults, Row, stripped, text_row
from scara_iso.tables.scales import Scales, check_metres, check_turns, corrected, sizes_in
from scara_iso.tables.statements import (
    REMARKED,
    Statement,
    read_head,
    read_statements,
    refuse_unused,
)
from scara_iso.tables.summaries import check_last_row, check_summaries
from scara_iso.tables.vocabulary.names import (
    CLOCKS,
    DATES,
    Column,
    Kind,
    Layout,
    plain_key,
    pose_alone,
    read_name,
    read_unit,
    unit_in_brackets,
)
from scara_iso.tables.vocabulary.words import (
    RESOLUTION,
    UNCERTAINTY,
    is_of_axes,
    parse_cell,
    quoted,
    quoted_whole,
)

_NOTES = 50
_MOST = 5
"""So many rare remarks are named."""
_MANY = 1_000_000
"""Rows of no test that is read off by hand."""


class ReadOptions(NamedTuple):
    """What the user says about a file, None where nothing."""

    unit: str | None
    resolution: float | None
    decimal: str | None
    sheet: str | None
    columns: tuple[str, ...] | None = None
    sizes: tuple[str, ...] = ()  # what beside the grid shows which mark is the decimal one


def assemble(grid: CellGrid, layout: Layout, options: ReadOptions, faults: Faults) -> Run:
    """Return the run that a grid holds by its layout, or raise `DataError`."""
    columns = Columns(layout, options.decimal, faults)
    body = Body(columns)
    body.read(grid)
    words = _words_above(grid, body)
    statements, notes = _stated(words, body)
    _check(grid, body, statements, options)
    scales = Scales(columns, layout.of(Kind.AXIS), statements, options.unit, body.below)
    sizes = [scales.sizes(RESOLUTION, options.resolution), scales.sizes(UNCERTAINTY)]
    faults.check()
    declared, coded_words = declared_in_words(columns, _texts(statements))
    run, clocks = _with_clock(_run(columns, scales, sizes, coded_words), columns)
    run, wrong = corrected(run)
    for fault in wrong:
        faults.add(fault, remedy="correct the statements above the table, or leave them out")
    unread = [row for row in grid.cover if row not in words]
    scales.check_words([*unread, *words, *body.aside, *body.below])
    _check_run(run, body, scales)
    faults.check()
    of_comments, remarks = _remarks(body, clocks, declared, statements)
    shown = {name: axis.shown for name, axis in run.axes.items()}
    rows = [*unread, *words, *body.below]
    remarks += [*body.doubts, *rows_in_words(shown, scales.units.values(), faults, rows, run)]
    notes = [*_row_notes(columns, run), *_parted(columns, run, coded_words), *notes, *of_comments]
    notes += [*scales.of_no_axis(), *_layout_notes(layout), *body.notes]
    units = {name: scales.units[name].name for name in run.axes}
    how = f"{grid.how}, {mark_in_words(columns)}" if grid.text else grid.how
    parts = (how, _columns_in_words(run, units, faults.row), run.origin.understood)
    origin = Origin(
        source=faults.where,
        understood="; ".join(filter(None, parts)),
        notes=tuple(notes),
        remarks=tuple(remarks),
        units=units,
        header_line=None if options.columns else layout.header_line or None,
        fields=tuple(_fields(columns, units)),
        sheet=faults.sheet,
    )
    run = replace(run, origin=origin)
    check_numbers(run, columns, grid.delimiter)
    return run


def _parted(columns: Columns, run: Run, coded: Mapping[str, object]) -> list[str]:
    """Refuse columns that part the readings as poses do; name those that half a scatter is of."""
    layout, poses = columns.layout, list(run.rows_by_pose())
    words = {c.heading: columns.values(c) for c in layout.of(Kind.COMMENT)}
    adjacent = {**run.covariates, **words}
    check_clusters(run.axes, poses, adjacent, run.metadata, columns.faults.where)
    asked = {name: values for name, values in adjacent.items() if name not in coded}
    return list(parted_by(run.axes, poses, asked, run.metadata))


def _words_above(grid: CellGrid, body: Body) -> list[Row]:
    """Return the rows of words above the readings; what a cover says is of what no head says."""
    line = body.layout.header_line
    head = [text_row(line, [column.heading]) for column in _titles(body.columns)]
    head += [row for row in grid.head if row.line < line]
    known = {one.key for row in head for one in read_statements(row)} if grid.cover else set()
    rows = []
    for row in grid.cover:
        keys = {one.key for one in read_statements(row)}
        if not keys or any(map(is_of_axes, keys)) or not keys <= known:
            rows.append(row)
        known |= keys
    return rows + head


def _titles(columns: Columns) -> list[Column]:
    """Return the columns without a cell whose heading is more than a name."""
    empty = (c for c in columns.layout.of(Kind.COMMENT) if not any(columns.distinct(c)))
    return [c for c in empty if re.search(r"\d|\w\W+\w", c.heading) and not pose_alone(c.heading)]


def _stated(words: Sequence[Row], body: Body) -> tuple[dict[str, Statement], list[str]]:
    """Return what words and the cells beside a table state, and notes."""
    rows, faults, unused = [*words], body.faults, []
    for row in body.aside:
        if any(is_of_axes(one.key) for one in read_statements(row)):
            rows.append(row)
        else:
            refuse_unused(row, faults)
            unused.append(
                f"{faults.row} {row.line}: {quoted_whole(row.text)} beside the table not used"
            )
    statements, notes = read_head(rows, faults)
    return statements, notes + unused[:_NOTES]


def _check(
    grid: CellGrid, body: Body, statements: Mapping[str, Statement], options: ReadOptions
) -> None:
    columns, faults, layout = body.columns, body.faults, body.layout
    of_dials = (key for key in statements if is_of_axes(key) and key.startswith(RESOLUTION))
    steps = [statements[key].value for key in of_dials]
    steps += [] if options.resolution is None else [str(options.resolution)]
    if cut := check_end(grid, columns, steps):
        body.note(cut)
        body.doubts.append(cut)
    for note in columns.fill_poses(grid.merged):
        body.note(note)
    check_header(columns)
    check_marks(columns, [*sizes_in(statements, body.below), *options.sizes])
    for column in layout.of(Kind.COVARIATE):
        _check_units(column, columns)
    check_summaries(body.summaries, columns)
    body.doubts += check_columns(columns, _texts(statements), grid.colours)
    check_remarks(columns, body.aside)
    _check_shown(grid, columns)
    body.check_blocks()
    if columns.last_line is None and not faults.total:
        faults.add("a header and no rows", layout.header_line, remedy="add the readings")


def _check_run(run: Run, body: Body, scales: Scales) -> None:
    columns, faults = body.columns, body.faults
    poses = replace(run, direction=None).rows_by_pose()  # from whatever direction
    for label, other in copies((str(label), run.take(rows)) for label, rows in poses):
        faults.add(
            f"pose {label} holds the very readings of pose {other}: a copy?",
            columns.layout.header_line,
            remedy="remove the rows of the pose that was not measured",
        )
    body.doubts += [*check_readings(run, columns), *check_last_row(run, columns)]
    check_turns(run, scales.units, columns)
    _check_repeats(run, body.repeats, columns)


def _texts(statements: Mapping[str, Statement]) -> dict[str, str]:
    return {key: one.value for key, one in statements.items()}


def _check_units(column: Column, columns: Columns) -> None:
    """Add a covariate with another unit behind some value than its heading or its values state."""
    named, seen = unit_of_condition(column.unit), columns.units.get(column, {})
    other = [unit for unit in seen if unit and unit_of_condition(unit) != named]
    if named in UNITS and other:
        what, line = f"{quoted(other[0])} behind a value", seen[other[0]]
        remedy = "let the column's name and its values state the same unit"
    elif len(seen) > 1:
        *_, (unit, line) = seen.items()
        what = f"{quoted(unit)} behind a value, another unit above"
        remedy = "write the unit once, in the column's name, and plain numbers below it"
    else:
        return
    columns.fault(column, f"{column.name}: {what}", line, remedy=remedy)


def _check_shown(grid: CellGrid, columns: Columns) -> None:
    """Refuse readings that a sheet does not show: of a filter, or of nobody's choice."""
    for line in columns.all_lines().tolist() if grid.hidden_rows else ():
        if line in grid.hidden_rows:
            what = f"row {line} is hidden, by hand or by a filter, and holds readings"
            remedy = "show all rows, and delete those that do not count (`allow_gaps=`)"
            columns.faults.add(what, line, remedy=remedy)
    for column in columns.layout.of(Kind.AXIS):
        if column.position + 1 in grid.hidden_columns:
            remedy = "show the column if its readings count, else delete it"
            columns.fault(column, f"the column of {column.name} is hidden", remedy=remedy)


def _run(
    columns: Columns,
    scales: Scales,
    sizes: Sequence[Mapping[str, float]],
    coded_words: Mapping[str, FloatArray],
) -> Run:
    layout, faults, lines = columns.layout, columns.faults, columns.all_lines()
    stated = scales.statements.items()
    metadata = {key: s.value for key, s in stated if not is_of_axes(key) and key != REMARKED}
    covariates = {
        c.name: c.condition.to_base(columns.values(c)) if c.condition else columns.values(c)
        for c in layout.of(Kind.COVARIATE)
    }
    covariates |= coded_words
    pose = _pose(columns, covariates)
    commands = scales.commands(pose, metadata.get("pose"))
    axes = {}
    for c in layout.of(Kind.AXIS):
        unit, readings = scales.units[c.name], _readings(c, columns, scales.units[c.name])
        axes[c.name] = Axis(
            c.name,
            readings,
            unit.dimension,
            resolution=sizes[0].get(c.name),
            uncertainty=sizes[1].get(c.name),
            command=commands.get(c.name),
            stated_unit=unit.other,
        )
    for column in layout.of(Kind.TIMESTAMP):
        covariates["time_s"] = _seconds_of_stamps(column, columns, metadata)
    faults.check()
    counted = next((columns.values(c) for c in layout.of(Kind.CYCLE)), None)
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


def _pose(columns: Columns, covariates: dict[str, FloatArray]) -> Labels | None:
    """Return the labels of the poses; numbers that hardly ever come again become a covariate."""
    for column in columns.layout.of(Kind.POSE):
        labels, name = columns.labels(column), column.heading
        if 2 * len(columns.distinct(column)) <= len(labels) or name.lower().startswith("pose"):
            return labels
        found = [parse_cell(label, columns.decimal) for label in labels.tolist()]
        values = [number.value for number in found if number is not None and not number.unit]
        if len(values) < len(labels):
            return labels
        covariates[name] = np.array(values)
    return None


def _readings(column: Column, columns: Columns, unit: Unit) -> FloatArray:
    readings = columns.values(column)
    if unit.name == "m":
        check_metres(column, columns)
    if unit.numerator != unit.denominator:
        with np.errstate(over="ignore"):
            readings = unit.to_base(readings)
    for k in np.flatnonzero(beyond_dials(readings)).tolist():
        what = f"a reading beyond any dial, in {unit.name}"
        remedy = "look for a slip of the decimal mark there, and whether the unit is true"
        columns.fault(column, what, int(columns.all_lines()[k]), remedy=remedy)
    return readings


def _check_repeats(run: Run, repeats: Sequence[int], columns: Columns) -> None:
    """Find a second table under a repeated header: the cycles of a pose begin again."""
    for line in repeats:
        k = int(np.searchsorted(columns.all_lines(), line))
        again = 0 < k < len(run) and run.cycle[k] <= run.cycle[k - 1]
        if again and (run.pose is None or run.pose[k] == run.pose[k - 1]):
            cycles = f"cycle {run.cycle[k]} after {run.cycle[k - 1]}"
            what = f"a second table begins: the header again, then {cycles}"
            columns.faults.add(what, line, remedy="leave one table in the file")


def _fields(columns: Columns, units: Mapping[str, str]) -> Iterator[TableField]:
    for column in columns.layout.columns:
        axis = column.kind in (Kind.AXIS, Kind.COMMAND)
        name = column.name if axis or column.kind is Kind.COVARIATE else ""
        unit = units.get(column.name, "") if axis else ""
        heading = column.heading
        yield TableField(column.position + 1, heading, column.kind.value, name, unit)


def _layout_notes(layout: Layout) -> Iterator[str]:
    """Name each column that counts or names poses by its cells, and not by its heading.

    Then each covariate in another unit of time, temperature or load than a run's, or none; and each
    length or angle that is taken for a covariate, and may be an axis by its name.
    """
    other = {c: read_name(c.heading).kind for c in layout.of(Kind.CYCLE, Kind.POSE)}
    by_cells = (c for c, kind in other.items() if kind in (Kind.COVARIATE, Kind.NAMELESS))
    yield from (f"{c.called} is taken for the {c.kind.value}, by its cells" for c in by_cells)
    if layout.worded:
        axes = ", ".join(column.name for column in layout.of(Kind.AXIS))
        yield f"{quoted(layout.worded)} before {axes} is taken for the instrument's name"
    covariates = layout.of(Kind.COVARIATE)
    for column in covariates:
        if column.name.lower() in CLOCKS and not column.unit:
            yield f"{column.called} states no unit, not used as the time: call it time_s"
        if column.condition and column.condition.converts:
            yield f"{column.called} in {column.unit} is converted to {column.name}"
    for column in covariates:
        if unit := read_unit(unit_in_brackets(column.heading)):
            axis = "theta" if unit.dimension is Dimension.ANGLE else "X, Y or Z"
            yield (
                f"{column.called} names no axis and is taken as a covariate; "
                f"if it holds readings, call it {axis}"
            )


def _row_notes(columns: Columns, run: Run) -> Iterator[str]:
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
    elif not np.array_equal(columns.values(counters[0]), run.cycle):
        yield "the cycle column counts all visits: the n-th of a pose is its cycle n"


def _remarks(
    body: Body,
    clocks: Mapping[Column, str],
    declared: Sequence[Column],
    statements: Mapping[str, Statement],
) -> tuple[list[str], list[str]]:
    """Return the notes of columns of comments, and the rare remarks: what happened at some rows.

    Those of the first row, which never counts, stand in the notes alone; ``clocks`` are the notes
    of columns of times. The statements hold the remarks of the table that this one was made of.
    """
    columns, called = body.columns, body.faults.row
    lines, quiet = columns.all_lines(), [*declared, *_titles(columns)]
    notes, rare = [], []
    for column in columns.layout.of(Kind.COMMENT):
        found = [] if column in clocks else rare_remarks(columns, column)
        shown = [f"{called} {line} {text}" for line, text in found[:_MOST]]
        shown += [".."] if len(found) > _MOST else []
        behind = f" ({', '.join(shown)})" if shown else ""
        if column not in quiet:
            notes.append(clocks.get(column, f"{column.called} not used{behind}"))
        rare += found
    for row in body.aside:
        if not any(is_of_axes(one.key) for one in read_statements(row)):
            rare.append((row.line, quoted_whole(row.text)))
    before = statements[REMARKED].value.split(SEPARATOR) if REMARKED in statements else []
    return notes, before + [f"{called} {line} {text}" for line, text in rare if line > lines[0]]


def _columns_in_words(run: Run, units: Mapping[str, str], row: str) -> str:
    parts = [
        f"{' '.join(name for name in units if units[name] == unit)} in {unit}"
        for unit in dict.fromkeys(units.values())
    ]
    labelled = {"pose": run.pose, "approach": run.direction}
    also = [name for name, labels in labelled.items() if labels is not None] + list(run.covariates)
    said = (x if x.isprintable() and len(x) <= 30 else quoted(x) for x in also)
    text = ", ".join(parts) + (f"; also {', '.join(said)}" if also else "")
    lines = [0] if run.lines is None else run.lines
    return f"{text}; {len(run)} rows ({row}s {lines[0]}-{lines[-1]})"


_DAY, _NOON, _HOUR = 86_400.0, 43_200.0, 3600.0
_STAMP = "write date and time as 2026-05-12T08:30:00 in a column timestamp"


def _seconds_of_stamps(column: Column, columns: Columns, metadata: dict[str, str]) -> FloatArray:
    """Return seconds from the first row's instant, which is kept as ``timestamp_start``."""
    stamps = [stamp for stamp in columns.values(column).tolist() if stamp is not None]
    start, lines = stamps[0], columns.all_lines()
    for line, stamp in zip(lines.tolist(), stamps, strict=True):
        if (stamp.tzinfo is None) != (start.tzinfo is None):
            what = "some times state their offset from UTC and some do not"
            remedy = "write all times with their offset, as +01:00, or all without"
            columns.fault(column, what, line, remedy=remedy)
            return np.zeros(len(lines))
    metadata.setdefault("timestamp_start", start.isoformat())
    return np.array([(stamp - start).total_seconds() for stamp in stamps])


def _with_clock(run: Run, columns: Columns) -> tuple[Run, dict[Column, str]]:
    """Return the run with the times of a clock's column as ``time_s``, where they are sure.

    They are where they go on from row to row, or within each pose, and pass midnight once at most.
    Beside the run is what to say of each clock, used or not.
    """
    said: dict[Column, str] = {}
    for column in columns.layout.of(Kind.COMMENT):
        clock = all(seconds_of_day(stripped(text)) is not None for text in columns.distinct(column))
        if plain_key(column.name) not in CLOCKS and not clock:
            continue
        called = column.called
        other = "there is another time" if "time_s" in run.covariates else ""
        found = other or _times(run, columns, column)
        if isinstance(found, str):
            said[column] = f"{called} not used as the time: {found}"
            continue
        first = stripped(str(columns.labels(column)[0]))
        said[column] = f"{called} is the time of each row, from {first} on"
        run = replace(run, covariates={**run.covariates, "time_s": found})
    return run, said


def _times(run: Run, columns: Columns, column: Column) -> FloatArray | str:
    """Return seconds from the first row, shape (rows,), or why the clock does not tell them."""
    read = [seconds_of_day(stripped(str(cell))) for cell in columns.labels(column)]
    lines, row = columns.all_lines(), columns.faults.row
    if None in read:
        return f"{row} {lines[read.index(None)]} holds no time such as 14:03:22"
    day = np.array(read, dtype=np.float64)
    backward = np.flatnonzero(np.diff(day) < 0) + 1
    midnights = backward[np.diff(day)[backward - 1] < -_NOON]
    dated = (
        c
        for c in columns.layout.of(Kind.COMMENT)
        if plain_key(c.name) in DATES or all(map(is_moment, columns.distinct(c)))
    )
    every = (labels for c in dated if all(labels := columns.labels(c)))
    dates = [one for one in every if ":" not in str(one[0]).removesuffix("T00:00:00")]
    changes = [np.flatnonzero(date[1:] != date[:-1]) + 1 for date in dates]
    if not all(np.array_equal(rows, midnights) for rows in changes):
        return f"the date changes at other rows than at midnight; {_STAMP}"
    if len(midnights) > 1:
        return f"it passes midnight {len(midnights)} times; {_STAMP}"
    in_turn = all(np.all(np.diff(day[rows]) >= 0) for _, rows in run.rows_by_pose())
    if len(backward) > len(midnights) and (len(midnights) or not in_turn):
        return f"it goes back in {row} {lines[backward[0]]}; {_STAMP}"
    if 0 < day[0] < _HOUR and plain_key(column.name) not in CLOCKS:
        return "are these durations? call it Time if it is a clock"
    passed = np.arange(len(day)) >= (midnights[0] if len(midnights) else len(day))
    times = np.asarray(np.round(day + _DAY * passed - day[0], 9))
    return times if np.ptp(day) else "it stands still"
