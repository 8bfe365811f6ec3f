"""A sweep of measured reversals: one row each, at several inertias, gaps or torques."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scara_iso.effects import Sweep
from scara_iso.errors import DataError, Fault, NoInputError
from scara_iso.quantities import parse_number
from scara_iso.run import FloatArray

_NEEDED = ("Im", "IL", "arcmin", "deviation_rad")
_OPTIONAL = ("ratio", "torque_Nm", "u_rad")
_POSITIVE = {"Im", "IL", "arcmin", "ratio", "u_rad"}
_MOST_ROWS = 100_000
_LARGEST = 10_000_000  # bytes


@dataclass(frozen=True, eq=False, slots=True)
class MeasuredSweep:
    """Reversals and the load deviations measured at them, in rad, shape (m,)."""

    sweep: Sweep
    deviation: FloatArray
    """With eq. 16's sign: not positive."""
    uncertainty: FloatArray | None
    """Standard uncertainties in rad, None where not given."""
    notes: tuple[str, ...] = ()


def read_sweep(path: str | Path) -> MeasuredSweep:
    """Return the sweep of a CSV file with the columns Im, IL, arcmin and deviation_rad.

    Optional columns are ratio, torque_Nm and u_rad; ``#`` begins a comment line; comma, semicolon
    or tab separate. Raises `NoInputError` where it cannot be read, and `DataError` with every
    fault and its line.
    """
    faults: list[Fault] = []
    columns = _columns(_lines(Path(path)), faults)
    if faults:
        what = f"no sweep can be read: {len(faults)} fault{'s' if len(faults) > 1 else ''}"
        remedy = f"give the columns {', '.join(_NEEDED)} in kg m2, arcmin and rad"
        raise DataError(what, where=str(path), remedy=remedy, faults=faults)
    deviation = columns["deviation_rad"]
    sizes = bool(np.all(deviation >= 0))
    return MeasuredSweep(
        Sweep(
            I_m=columns["Im"],
            I_L=columns["IL"],
            gap=np.radians(columns["arcmin"] / 60),
            torque=columns.get("torque_Nm"),
            ratio=columns.get("ratio"),
        ),
        -deviation if sizes else deviation,
        columns.get("u_rad"),
        ("deviations are taken as sizes: eq. 16's sign is negative",) if sizes else (),
    )


def _lines(path: Path) -> list[tuple[int, str]]:
    try:
        with path.open("rb") as file:
            data = file.read(_LARGEST + 1)
    except OSError as error:
        raise NoInputError(error.strerror or "cannot be read", where=str(path)) from error
    if len(data) > _LARGEST:
        raise DataError("larger than any sweep", where=str(path))
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataError("not UTF-8", where=str(path)) from error
    numbered = enumerate(text.splitlines(), 1)
    return [(k, line) for k, line in numbered if line.strip() and not line.lstrip().startswith("#")]


def _columns(lines: list[tuple[int, str]], faults: list[Fault]) -> Mapping[str, FloatArray]:
    if len(lines) < 2 or len(lines) > _MOST_ROWS:
        faults.append(Fault("a header and at least one row are wanted"))
        return {}
    separator = max(",;\t", key=lines[0][1].count)
    header, *cells = [[_unquoted(cell) for cell in line.split(separator)] for _, line in lines]
    known = {name.lower(): name for name in (*_NEEDED, *_OPTIONAL)}
    names = [known.get(name.lower()) for name in header]
    faults += [Fault(f"column {n} is missing", lines[0][0]) for n in _NEEDED if n not in names]
    faults += [
        Fault(f"column {name} is there twice", lines[0][0])
        for name in known.values()
        if names.count(name) > 1
    ]
    found: dict[str, list[float]] = {name: [] for name in names if name}
    for (line, _), row in zip(lines[1:], cells, strict=True):
        if len(row) != len(header):
            faults.append(Fault(f"{len(row)} fields, the header has {len(header)}", line))
            continue
        for column, (name, cell) in enumerate(zip(names, row, strict=True), 1):
            if name:
                found[name].append(_value(name, cell, line, column, faults))
    return {name: np.array(values) for name, values in found.items()}


def _unquoted(cell: str) -> str:
    cell = cell.strip()
    return cell[1:-1] if len(cell) > 1 and cell[0] == cell[-1] == '"' else cell


def _value(name: str, cell: str, line: int, column: int, faults: list[Fault]) -> float:
    value = parse_number(cell)
    if value is None:
        faults.append(Fault(f"{name}: {cell[:30]!r} is not a number", line, column))
    elif name in _POSITIVE and value <= 0:
        faults.append(Fault(f"{name}: {value:g} is not positive", line, column))
    return math.nan if value is None else value
