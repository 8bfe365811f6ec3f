"""Which pose a row belongs to, and the command coordinates of the poses."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from scara_iso.errors import DataError
from scara_iso.pose_columns import Commanded, by_pose, coded
from scara_iso.run import FloatArray
from scara_iso.tables.columns import Columns
from scara_iso.tables.faults import Faults, quoted
from scara_iso.tables.names import Kind, read_unit
from scara_iso.tables.numbers import parse_cell
from scara_iso.tables.preamble import normal_key
from scara_iso.tables.statements import Scale

Labels = npt.NDArray[np.str_]


def find_pose(columns: Columns, covariates: dict[str, FloatArray]) -> Labels | None:
    """Return the labels of the poses; numbers that hardly ever come again become a covariate."""
    for column in columns.layout.of(Kind.POSE):
        labels = columns.labels(column)
        name = columns.layout.header[column.position]
        often = 2 * len(columns.distinct(column)) <= len(labels)
        numbers = None if often or name.lower().startswith("pose") else _numbers(columns, labels)
        if numbers is None:
            return labels
        covariates[name] = numbers
    return None


def _numbers(columns: Columns, labels: Labels) -> FloatArray | None:
    found = [parse_cell(label, columns.decimal) for label in labels.tolist()]
    values = [number.value for number in found if number is not None and not number.unit]
    return np.array(values) if len(values) == len(labels) else None


def find_commands(
    columns: Columns,
    scales: dict[str, Scale],
    pose: Labels | None,
    metadata: dict[str, str],
    faults: Faults,
) -> dict[str, Commanded]:
    """Return the command coordinates by axis, from columns and from statements."""
    found: dict[str, Commanded] = {}
    for axis, scale in scales.items():
        stated = scale.command
        if isinstance(stated, Mapping):
            own = [metadata["pose"]] if "pose" in metadata else []
            names = own if pose is None else coded(pose)[0]
            labels = {normal_key(label): label for label in names}
            stated = {labels.get(key, key): value for key, value in stated.items()}
        found[axis] = stated
    for column in columns.layout.of(Kind.COMMAND):
        scaled = scales.get(column.name)
        if scaled is None:
            continue
        unit = read_unit(column.unit) if column.unit else scaled.unit
        if unit is None or unit.dimension is not scaled.unit.dimension:
            what = f"command_{column.name}: {quoted(column.unit)} is not a unit of {column.name}"
            remedy = f"state it in a unit such as {scaled.unit.name}"
            faults.add(what, columns.layout.header_line, column.position + 1, remedy=remedy)
            continue
        if scaled.command is not None or set(columns.units.get(column, {})) - {""}:
            what = f"command_{column.name} is stated twice, or has units behind its values"
            remedy = "state it in one place, its unit in the header"
            faults.add(what, columns.layout.header_line, column.position + 1, remedy=remedy)
        try:
            name = f"command_{column.name}"
            found[column.name] = by_pose(name, unit.to_base(columns.numbers(column)), pose)
        except DataError as error:
            faults.add(error.what, None, column.position + 1, remedy=error.remedy)
    return found
