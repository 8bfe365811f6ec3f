"""Units, resolutions and uncertainties of the axes, from all places that state them.

What a table states of its dials' corrections: ``# correction_X: 0 0; 2 0.001``, and so on.
"""

from __future__ import annotations

import math
import re
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.base.quantities import Dimension, Unit, parse_number, parse_unit
from scara_iso.run import AXES, Axis, Commanded, Correction, Run
from scara_iso.tables.faults import Faults, listed, quoted
from scara_iso.tables.names import Column, read_unit
from scara_iso.tables.numbers import Mark, parse_cell
from scara_iso.tables.preamble import Statement, read_statements, whole_statement
from scara_iso.tables.subjects import LEAVE_SCALES, refusal, speaks_of_scale
from scara_iso.tables.text import Row

_KEYS = {
    "correction": "points",
    "correction_zero": "zero",
    "correction_uncertainty": "uncertainty",
    "alignment": "alignment_deg",
    "alignment_uncertainty": "alignment_u_deg",
}
_OF_AN_AXIS = re.compile(rf"({'|'.join(_KEYS)})_({'|'.join(AXES).lower()})")
_POSITIVE = ("uncertainty", "alignment_u_deg")
_MOST_NAMED = 5


def is_of_corrections(key: str) -> bool:
    """Return whether a statement corrects the readings of an axis."""
    return _OF_AN_AXIS.fullmatch(key.lower()) is not None


def stated_corrections(correction: Correction, axis: str) -> Iterator[tuple[str, str]]:
    """Yield the statements of a correction, which `corrected` reads back."""
    for key, name in _KEYS.items():
        value = getattr(correction, name)
        if name == "points" and value:
            yield f"{key}_{axis}", "; ".join(f"{x:.12g} {e:.12g}" for x, e in value)
        elif name != "points" and value is not None:
            yield f"{key}_{axis}", f"{value:.12g}"


def corrected(run: Run) -> tuple[Run, list[str]]:
    """Return the run with its readings corrected as its metadata states, and what is wrong.

    The statements go, and ``corrected_X`` says in their place what was done: they are never
    applied twice.
    """
    found, wrong = _read(run.metadata)
    unknown = [
        f"a correction of {axis}, which is no axis of this table"
        for axis in found
        if axis not in run.axes
    ]
    wrong += unknown
    axes, said = dict(run.axes), {}
    for name, correction in found.items():
        if name in axes:
            faults = [f"{name}: {text}" for text in _faults(correction, axes[name], run)]
            wrong += faults
            if not faults:
                axes[name] = correction.applied(axes[name], reach=_reach(axes[name], run))
                said[f"corrected_{name}"] = _said(correction, axes[name])
    if not found and not wrong:
        return run, []
    kept = {key: text for key, text in run.metadata.items() if not is_of_corrections(key)}
    return replace(run, axes=axes, metadata={**kept, **said}), wrong


def _read(metadata: Mapping[str, str]) -> tuple[dict[str, Correction], list[str]]:
    found: dict[str, dict[str, object]] = {}
    wrong = []
    names = {axis.lower(): axis for axis in AXES}
    for key, text in metadata.items():
        if (match := _OF_AN_AXIS.fullmatch(key.lower())) is None:
            continue
        name = _KEYS[match[1]]
        value = _points(text) if name == "points" else parse_number(text)
        if value is None or (name in _POSITIVE and not isinstance(value, tuple) and value <= 0):
            wanted = "'0 0; 2 0.001; 5 -0.002'" if name == "points" else "a number, such as 0.5"
            wrong.append(f"{key}: {text[:40]!r} is not {wanted} (in mm, or degrees)")
        else:
            found.setdefault(names[match[2]], {})[name] = value
    return {axis: Correction(**values) for axis, values in found.items()}, wrong  # type: ignore[arg-type]  # as _KEYS has them


def _points(text: str) -> tuple[tuple[float, float], ...] | None:
    pairs = [[parse_number(cell) for cell in pair.split()] for pair in text.split(";")]
    points = tuple((pair[0], pair[1]) for pair in pairs if len(pair) == 2)
    if len(points) < len(pairs) or any(x is None for pair in pairs for x in pair):
        return None
    return points  # type: ignore[return-value]  # no None among them


def _faults(correction: Correction, axis: Axis, run: Run) -> Iterator[str]:
    yield from correction.faults(axis.dimension)
    if correction.points and correction.zero is None and run.dial_zero_is_command:
        yield (
            "the display was zeroed at the command pose: state where on the certificate's scale "
            f"that was, as '# correction_zero_{axis.name}: 2.5'"
        )
    outside = correction.uncovered(axis)
    if len(outside):
        low, high = correction.points[0][0], correction.points[-1][0]
        zero = f", the display's zero at {correction.zero:g}" if correction.zero is not None else ""
        some = ", ".join(f"{axis.readings[k]:g}" for k in outside[:_MOST_NAMED])
        some += " .." if len(outside) > _MOST_NAMED else ""
        yield (
            f"{len(outside)} readings ({some}) are not "
            f"on the curve from {low:g} to {high:g} {axis.unit}{zero}: nothing is extrapolated"
        )


def _reach(axis: Axis, run: Run) -> float:
    """Return the longest distance that is measured: from the zero where it is the command pose."""
    far = np.abs(axis.readings).max() if run.dial_zero_is_command else np.ptp(axis.readings)
    return float(far)


def _said(correction: Correction, axis: Axis) -> str:
    parts = []
    if correction.points:
        zero = "" if correction.zero is None else f", zeroed at {correction.zero:g}"
        parts.append(f"certificate's curve of {len(correction.points)} points{zero}")
    if correction.alignment_deg is not None:
        parts.append(f"cosine of {correction.alignment_deg:g} deg")
    added = axis.readings - axis.shown
    return f"{' and '.join(parts)}: {added.min():+.3g} .. {added.max():+.3g} {axis.unit}"


OF_AXES = ("unit", "resolution", "indicator_uncertainty")
"""Keys that the axes of a `Run` hold, alone or with ``_X`` and the like behind."""
COMMAND = "command"
"""Key of the command pose, with ``_X`` and the like behind, and ``[P3]`` for one of several."""
_OF_A_POSE = re.compile(rf"{COMMAND}_({'|'.join(AXES).lower()})\[([^\[\]]+)\]")
_OF_ONE = re.compile(rf".*_({'|'.join(AXES).lower()})(?:\[.*\])?")


@dataclass(frozen=True, slots=True)
class Scale:
    """Unit of an axis, and what else is stated of it, in its base unit; None if unstated."""

    unit: Unit
    resolution: float | None
    uncertainty: float | None
    command: Commanded


def is_of_axes(key: str) -> bool:
    """Return whether a statement is about the axes and so is held by them."""
    return (
        key in OF_AXES
        or any(key in _keys(name) for name in (*OF_AXES, COMMAND))
        or _OF_A_POSE.fullmatch(key) is not None
    )


def refuse_unused(rows: Iterable[Row], faults: Faults) -> None:
    """Add what rows state that would change a figure and is not understood.

    Such a statement is never passed over; every other key is the report's.
    """
    for row in rows:
        _refuse_unused(row, faults)


def _refuse_unused(row: Row, faults: Faults) -> None:
    stated = [*read_statements(row), *whole_statement(row.text)]
    used = [one for one in stated if is_of_axes(one.key) or is_of_corrections(one.key)]
    before = faults.total
    for one in stated:
        if one not in used and (found := refusal(one.key, one.written, one.value)):
            faults.add(found[0], row.line, remedy=found[1])
    if not used and faults.total == before and speaks_of_scale(row.text):
        what = f"{quoted(row.text)}, and readings are multiplied by no factor"
        faults.add(what, row.line, remedy=LEAVE_SCALES)


def of_no_axis(statements: Iterable[str], axes: Container[str]) -> Iterator[str]:
    """Yield the statements about an axis that is not among those of a table."""
    for key in filter(is_of_axes, statements):
        found = _OF_ONE.fullmatch(key)
        axis = next((name for name in AXES if found and name.lower() == found[1]), None)
        if axis is not None and axis not in axes:
            yield f"{key} not used: there is no axis {axis}"


def _keys(name: str) -> list[str]:
    return [f"{name}_{axis.lower()}" for axis in AXES]


def read_scales(
    columns: Iterable[Column],
    header_line: int,
    statements: Mapping[str, Statement],
    behind: Mapping[str, Mapping[str, int]],
    *,
    unit: str | None,
    resolution: float | None,
    faults: Faults,
) -> dict[str, Scale]:
    """Return the scale of each axis column; every missing or conflicting statement is a fault.

    ``behind`` holds, per axis, the units found behind its values and the first line of each;
    ``unit`` and ``resolution`` are the user's options and stand for the statements of that name.
    """
    before = faults.total
    general = _general_unit(statements, unit, faults)
    units: dict[str, Unit] = {}
    for column in columns:
        seen = behind.get(column.name, {})
        found = _axis_unit(column, header_line, statements, seen, general, faults)
        if found is not None:
            units[column.name] = found
    missing = [c.name for c in columns if c.name not in units]
    if missing and faults.total == before:
        faults.add(
            f"no unit stated for {listed(missing)}",
            header_line,
            remedy="name it with `unit=mm`, or in a line '# unit: mm' above the header",
        )
    sizes = _Sizes(statements, units, general, faults)
    resolutions = sizes.of("resolution", resolution)
    uncertainties = sizes.of("indicator_uncertainty")
    commands = sizes.commands()
    return {
        axis: Scale(size, resolutions.get(axis), uncertainties.get(axis), commands.get(axis))
        for axis, size in units.items()
    }


def _general_unit(
    statements: Mapping[str, Statement], option: str | None, faults: Faults
) -> Unit | None:
    asked = parse_unit(option) if option is not None else None
    stated = _stated_unit(statements, "unit", faults)
    if asked and stated and not same_size(asked, stated):
        faults.add(
            f"`unit={option}` against the file's unit {stated.name}",
            statements["unit"].line,
            remedy=f"leave `unit=` out, or write '# unit: {asked.name}' in the file if it is wrong",
        )
    return asked or stated


def _stated_unit(
    statements: Mapping[str, Statement], key: str, faults: Faults, axis: str = ""
) -> Unit | None:
    if key not in statements:
        return None
    value, line = statements[key].value, statements[key].line
    return _known_unit(_spelt(value, axis), f"{key}: ", line, None, faults)


def _spelt(unit: str, axis: str) -> str:
    """Return a unit as it is meant: of an angle, ``"`` is seconds of arc and no inches."""
    return "arcsec" if axis == "theta" and unit.strip("[]() ") == '"' else unit


def _known_unit(text: str, what: str, line: int, column: int | None, faults: Faults) -> Unit | None:
    unit = read_unit(text)
    if unit is None:
        faults.add(
            f"{what}unknown unit {quoted(text)}",
            line,
            column,
            remedy="write mm, um, inch, deg (a German Grad), rad, arcmin, or a scaled one as "
            "0.01 mm",
        )
    return unit


def _axis_unit(
    column: Column,
    header_line: int,
    statements: Mapping[str, Statement],
    behind: Mapping[str, int],
    general: Unit | None,
    faults: Faults,
) -> Unit | None:
    axis, field = column.name, column.position + 1
    named = _stated_unit(statements, f"unit_{axis.lower()}", faults, axis)
    if axis == "theta" and "unit" in statements:
        general = read_unit(_spelt(statements["unit"].value, axis)) or general
    places = [(column.unit, header_line), *behind.items()]
    own = [
        named,
        *(_known_unit(_spelt(t, axis), f"{axis}: ", n, field, faults) for t, n in places if t),
    ]
    known = [unit for unit in own if unit is not None]
    stated = named is not None or bool(column.unit)
    # `unit_Y` is a statement about one axis and goes before `unit`; a header does not.
    if general and not named and any(u.dimension is general.dimension for u in known):
        known.append(general)
    elif "" in behind and len(behind) > 1 and not stated:
        remedy = "write the unit once, in the header, as 'X [mm]'"
        faults.add(f"{axis}: a unit behind some values only", behind[""], field, remedy=remedy)
    other = next((unit for unit in known if not same_size(unit, known[0])), None)
    if other:
        faults.add(
            f"{axis}: unit {known[0].name} against {other.name}",
            header_line,
            field,
            remedy="let header, values and metadata state the same unit",
        )
    unit = known[0] if known else general
    if unit and axis != "theta" and unit.dimension is Dimension.ANGLE:
        what = f"{axis} is a length and cannot be in {unit.name}"
        remedy = "write its unit of length, as mm; call a column of angles theta"
        faults.add(what, header_line, field, remedy=remedy)
    return unit


def same_size(a: Unit, b: Unit) -> bool:
    """Return whether two units are the same, however they are written."""
    return a.dimension is b.dimension and a.numerator * b.denominator == b.numerator * a.denominator


@dataclass(frozen=True, slots=True)
class _Sizes:
    """Statements of a size, such as the resolution, for all axes and for one."""

    statements: Mapping[str, Statement]
    units: Mapping[str, Unit]
    general: Unit | None
    faults: Faults

    def of(self, key: str, option: float | None = None) -> dict[str, float]:
        """Return the size per axis, in its base unit, that statements of ``key`` give."""
        return {**self._for_all(key, option), **self.of_one(key)}

    def of_one(self, key: str, *, above: float = 0.0) -> dict[str, float]:
        """Return what the statements of ``key_X`` and the like give, per axis."""
        sizes: dict[str, float] = {}
        for axis in self.units:
            own = self.statements.get(f"{key}_{axis.lower()}")
            size = self._size(own, f"{key}_{axis}", axis, above) if own else None
            if size is not None:
                sizes[axis] = size
        return sizes

    def commands(self) -> dict[str, Commanded]:
        """Return the command coordinates: a number per axis, or numbers by pose as it is keyed."""
        found: dict[str, Commanded] = dict(self.of_one(COMMAND, above=-math.inf))
        axes = {axis.lower(): axis for axis in self.units}
        by_axis: dict[str, dict[str, float]] = {}
        for key, own in self.statements.items():
            match = _OF_A_POSE.fullmatch(key)
            axis = axes.get(match[1]) if match else None
            if match is None or axis is None:
                continue
            if axis in found:
                self.faults.add(
                    f"{COMMAND}_{axis} and {key}: of which pose is the first?",
                    own.line,
                    remedy=f"write its pose behind it, as '# {COMMAND}_{axis}[P1]: 100.0'",
                )
            size = self._size(own, key, axis, -math.inf)
            if size is not None:
                by_axis.setdefault(axis, {})[match[2]] = size
        return {**found, **by_axis}

    def _size(self, own: Statement, key: str, axis: str, above: float) -> float | None:
        """Return the size that a statement about one axis gives, in the axis' base unit."""
        size, unit = self._read(own, key, above), self.units[axis]
        if size is None:
            return None
        value, stated = size
        if stated and stated.dimension is not unit.dimension:
            what = f"{key} in {stated.name}, {axis} in {unit.name}"
            self.faults.add(what, own.line, remedy=f"state {key} in {unit.name}")
        return (stated or unit).to_base(value)

    def _for_all(self, key: str, option: float | None) -> dict[str, float]:
        stated = self.statements.get(key)
        size = self._read(stated, key) if stated else None
        unit = (size[1] if size else None) or self._common_unit()
        if unit is None:
            if self.units and (size or option is not None):
                self.faults.add(
                    f"{key}: the axes have different units",
                    stated.line if stated else None,
                    remedy=f"write the unit behind it, as '# {key}: 0.001 mm'",
                )
            return {}
        value = unit.to_base(size[0]) if size else None
        if option is not None:
            asked = (self.general or unit).to_base(option)
            if value is not None and stated and asked != value:
                self.faults.add(
                    f"`resolution={option!r}` against the file's {stated.value}",
                    stated.line,
                    remedy="leave `resolution=` out; or, if the file is wrong, mend it there",
                )
            value = asked
        if value is None:
            return {}
        found = {axis: value for axis, u in self.units.items() if u.dimension is unit.dimension}
        if self.units and not found:
            other = next(iter(self.units.values())).dimension.value
            remedy = f"state {key} in the unit of the readings, as '# {key}: 0.001 {other}'"
            if option is not None:
                remedy = "leave `resolution=` out, or let `unit=` be a unit of the readings"
            what = f"{key} in {unit.name}, and no axis is in such a unit"
            self.faults.add(what, stated.line if stated else None, remedy=remedy)
        return found

    def _common_unit(self) -> Unit | None:
        """Return the unit that a bare size is in: the stated one, else the one of all lengths."""
        if self.general:
            return self.general
        units = list(self.units.values())
        lengths = [unit for unit in units if unit.dimension is Dimension.LENGTH] or units
        same = all(same_size(unit, lengths[0]) for unit in lengths)
        return lengths[0] if lengths and same else None

    def _read(
        self, statement: Statement, key: str, above: float = 0.0
    ) -> tuple[float, Unit | None] | None:
        number = parse_cell(statement.value)
        if (
            number is None
            or number.mark in (Mark.EITHER, Mark.BOTH)
            or not above < number.value < math.inf
        ):
            kind = "a number" if above < 0 else "a number above zero"
            self.faults.add(
                f"{key}: {quoted(statement.value)} is not {kind}",
                statement.line,
                remedy=f"write one number, and its unit where it has another: '# {key}: 0.001'",
            )
            return None
        if not number.unit:
            return number.value, None
        unit = _known_unit(number.unit, f"{key}: ", statement.line, None, self.faults)
        return (number.value, unit) if unit else None
