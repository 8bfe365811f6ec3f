"""What ``tables`` publishes of a run that was read: schema ``scara-iso/tables/1``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from scara_iso.base.published import Count, Unit, publish
from scara_iso.run import AxisKey, FloatArray, IntArray, Run, TableField


@dataclass(frozen=True)
class FieldNumber:
    """Which field of a row it is."""

    field: Annotated[int, ("minimum", 1)]
    """From 1."""


@dataclass(frozen=True, slots=True)
class NumberedField(TableField, FieldNumber):
    """A column as the file has it, and what it was taken for."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class TableAxis:
    """The readings of one axis."""

    unit: Unit
    """Of readings and resolution."""
    resolution: Annotated[float, ("exclusiveMinimum", 0)] | None
    """The dial's division; null where not stated."""
    readings: FloatArray
    """By row."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PublishedTable:
    """``tables`` of a table, or of several."""

    schema: Literal["scara-iso/tables/1"]
    """Name and number of this schema."""
    source: str
    """The file."""
    read_as: str
    """How it was understood."""
    header_line: Count | None
    """Line of the header; null where several tables were read."""
    fields: tuple[NumberedField, ...]
    """The columns of the file; none of several tables."""
    rows: Annotated[int, ("minimum", 1)]
    """Number of rows."""
    lines: IntArray
    """Of the file, by row; empty where not known."""
    cycle: IntArray
    """By row."""
    pose: tuple[str, ...] | None
    """By row; null without poses."""
    axes: Annotated[Mapping[AxisKey, TableAxis], ("minProperties", 1)]
    """By name."""
    statements: Mapping[str, str]
    """What the file states."""
    notes: tuple[str, ...]
    """What was met and not used."""


def published_table(run: Run) -> PublishedTable:
    """Return what was understood of a table."""
    origin = run.origin
    numbered = enumerate(origin.fields, start=1)
    return PublishedTable(
        schema="scara-iso/tables/1",
        source=origin.source,
        read_as=origin.understood,
        header_line=origin.header_line,
        fields=tuple(publish(NumberedField, one, field=k) for k, one in numbered),
        rows=len(run),
        lines=np.empty(0, np.int64) if run.lines is None else run.lines,
        cycle=run.cycle,
        pose=None if run.pose is None else tuple(run.pose.tolist()),
        axes={name: publish(TableAxis, axis) for name, axis in run.axes.items()},
        statements=run.metadata,
        notes=origin.notes,
    )
