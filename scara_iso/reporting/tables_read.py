"""What is said of a table that was read: what each field was taken for, and what was left out."""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.origin import TableField
from scara_iso.reporting.blocks import Block, Cell, Facts, Number, Report, Section, Table, Text
from scara_iso.run import Run

_MOST = 100


def table_report(run: Run) -> Report:
    """Return what was understood of the table, or of the tables, that ``run`` was read from."""
    origin = run.origin
    sections = [Section("", (Text(f"read: {origin.source}", "strong"), Text(origin.understood)))]
    if stated := tuple(_stated(run)):
        sections.append(Section("stated in the file", (Facts(stated),)))
    if origin.fields:
        sections.append(
            Section(
                f"fields, by the header of {origin.row_name} {origin.header_line}"
                if origin.header_line
                else "fields",
                (_fields(run),),
            )
        )
    sections.append(Section("left out, and remarks", tuple(_notes(run))))
    return tuple(sections)


def _stated(run: Run) -> Iterator[tuple[str, str]]:
    for name, axis in run.axes.items():
        sizes = {"resolution": axis.resolution, "indicator_uncertainty": axis.uncertainty}
        yield from ((f"{key}_{name}", f"{x:g} {axis.unit}") for key, x in sizes.items() if x)
    yield from run.metadata.items()


def _fields(run: Run) -> Table:
    rows = [_row(k, one, run) for k, one in enumerate(run.origin.fields, start=1)]
    row = run.origin.row_name
    lines = "" if run.lines is None else f" ({row} {run.lines[0]}, {row} {run.lines[-1]})"
    note = f"first and last row{lines}: readings in mm, or degrees"
    return Table(("field", "header", "taken for", "in", "first", "last"), tuple(rows), note)


def _row(k: int, one: TableField, run: Run) -> tuple[Cell, ...]:
    taken = f"{one.kind} {one.name}" if one.name and one.kind != "covariate" else one.kind
    return (str(k), one.header or "(none)", taken, one.unit, *_ends(one, run))


def _ends(one: TableField, run: Run) -> tuple[Cell, Cell]:
    if one.kind == "axis":
        readings = run.axes[one.name].readings
        return Number(float(readings[0]), ".9g"), Number(float(readings[-1]), ".9g")
    labels = {"cycle": run.cycle, "pose": run.pose, "direction of approach": run.direction}
    found = labels.get(one.kind, run.covariates.get(one.name))
    return ("", "") if found is None else (str(found[0]), str(found[-1]))


def _notes(run: Run) -> Iterator[Block]:
    notes = run.origin.notes
    yield from (Text(note) for note in notes[:_MOST])
    if len(notes) > _MOST:
        yield Text(f"and {len(notes) - _MOST} more", "quiet")
    if not notes:
        yield Text("nothing: every row under the header is a reading")
