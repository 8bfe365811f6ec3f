"""What the names of a header leave open or contradict, and what to do about it."""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.quantities import Dimension
from scara_iso.tables.faults import Faults, quoted
from scara_iso.tables.layout import COLUMNS, Layout
from scara_iso.tables.names import CLOCKS, Column, Kind, read_name, unit_behind
from scara_iso.tables.pose_names import pose_and_name


def check_header_names(layout: Layout, faults: Faults) -> None:
    """Add what columns are too many, of one name, or formulas, and axes of a pose beside others."""
    if layout.width > COLUMNS:
        what = f"{layout.width} columns, more than {COLUMNS}"
        faults.add(what, layout.header_line, remedy="leave the columns of the readings only")
    _check_poses(layout, faults)
    _check_units(layout, faults)
    first: dict[tuple[Kind, str], Column] = {}
    for column in layout.columns:
        field = column.position + 1
        if column.kind in (Kind.NAMELESS, Kind.COMMENT):
            continue
        if layout.header[column.position].startswith(("=", "@")):
            what = "a formula for a column's name"
            faults.add(what, layout.header_line, field, remedy="write the name itself")
        covariate = column.kind in (Kind.TIMESTAMP, Kind.DIRECTION)
        kind = Kind.COVARIATE if covariate else column.kind
        name = "time_s" if column.kind is Kind.TIMESTAMP else column.name
        before = first.setdefault((kind, name.lower()), column)
        if before is not column:
            what = f"two columns for {name}: fields {before.position + 1} and {field}"
            faults.add(
                what,
                layout.header_line,
                field,
                remedy="leave one column for each axis and quantity; a block beside the first goes "
                "below it, and of several poses the columns are headed P1_X, P2_X",
            )


def _check_poses(layout: Layout, faults: Faults) -> None:
    """Add each covariate that names an axis of a pose: its readings would be lost."""
    for column in layout.of(Kind.COVARIATE):
        heading = layout.header[column.position]
        found = pose_and_name(heading)
        if found and read_name(found[1]).kind is Kind.AXIS:
            faults.add(
                f"{quoted(heading)} is of pose {found[0]}, other axes of none",
                layout.header_line,
                column.position + 1,
                remedy="head each axis with its pose, as P1_X and P2_X; "
                "call a column of no readings comment",
            )


def _check_units(layout: Layout, faults: Faults) -> None:
    """Add each covariate whose heading states another unit than the unit row."""
    for column in layout.of(Kind.COVARIATE):
        heading, _, below = column.unit.partition(" over ")
        if below:
            what = f"in {heading}, the unit row says {below}"
            faults.add(
                f"{quoted(layout.header[column.position])} is {what}",
                layout.header_line,
                column.position + 1,
                remedy="let the heading and the unit row state the same unit",
            )


def said_units(layout: Layout) -> Iterator[str]:
    """Name each column of another unit of time, temperature or load than that of a run, or none."""
    for column in layout.of(Kind.COVARIATE):
        if column.name.lower() in CLOCKS and not column.unit:
            yield f"{called(layout, column)} states no unit, not used as the time: call it time_s"
        if column.condition and column.condition.converts:
            yield f"{called(layout, column)} in {column.unit} is converted to {column.name}"


def said_sizes(layout: Layout) -> Iterator[str]:
    """Name each length or angle that is taken for a covariate, and may be an axis by its name."""
    for column in layout.of(Kind.COVARIATE):
        unit = unit_behind(layout.header[column.position])
        if unit is not None:
            axis = "theta" if unit.dimension is Dimension.ANGLE else "X, Y or Z"
            yield (
                f"{called(layout, column)} names no axis and is taken as a covariate; "
                f"if it holds readings, call it {axis}"
            )


def called(layout: Layout, column: Column) -> str:
    """Return what a message calls a column."""
    return f"column {column.position + 1} {quoted(layout.header[column.position])}"
