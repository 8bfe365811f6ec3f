"""Units, resolutions, uncertainties and command poses of the axes, from all that states them.

What a table states of its dials' corrections: ``# correction_X: 0 0; 2 0.001``, and so on.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from scara_iso.base.errors import DataError
from scara_iso.base.quantities import Dimension, Unit, parse_number, parse_unit
from scara_iso.run import AXES, Axis, Commanded, Correction, Run, by_pose, coded
from scara_iso.tables.columns import Columns, Labels, decimal_of
from scara_iso.tables.grid import Faults, Row
from scara_iso.tables.statements import AN_AXIS, Statement, normal_key
from scara_iso.tables.vocabulary.names import (
    Column,
    Kind,
    length_in_mm,
    length_in_words,
    read_unit,
    unit_in_brackets,
)
from scara_iso.tables.vocabulary.sentences import in_parts_of_a_unit
from scara_iso.tables.vocabulary.words import (
    COMMAND,
    CORRECTION_KEYS,
    OF_A_CORRECTION,
    OF_A_POSE,
    Mark,
    is_of_another,
    is_of_axes,
    is_of_corrections,
    listed,
    parse_cell,
    quoted,
)

_OF_ONE = re.compile(rf".*_({'|'.join(AXES).lower()})(?:\[.*\])?")
_LETTERS = ("m", "in", "'", '"')
"""Units that mean something else as often."""
_UNITS = "write mm, um, inch, deg (a German Grad), rad, arcmin, or a scaled one as 0.01 mm"
_ANY = -math.inf


class Scales:
    """The unit of each axis, and the sizes that are stated of it, in its base unit.

    Every missing or conflicting statement is a fault. ``sized`` are the columns that have a unit;
    ``unit`` is the user's option, and stands for the statement of that name; a size that can be
    read two ways is read by the decimal mark of the readings, or of the rows ``below`` them.
    """

    def __init__(
        self,
        columns: Columns,
        sized: Sequence[Column],
        statements: Mapping[str, Statement],
        unit: str | None,
        below: Iterable[Row] = (),
    ) -> None:
        self.columns, self.faults = columns, columns.faults
        self.header_line, before = columns.layout.header_line, self.faults.total
        self.decimal = decimal_of(columns, sizes_in(statements, below))
        self.statements = statements
        self.general = self._general(unit)
        behind = {c.name: units for c, units in columns.units.items() if c.kind is Kind.AXIS}
        found = {c.name: self._of_axis(c, behind.get(c.name, {})) for c in sized}
        self.units = {axis: one for axis, one in found.items() if one is not None}
        if len(self.units) < len(found) and self.faults.total == before:
            self.faults.add(
                f"no unit stated for {listed(axis for axis in found if axis not in self.units)}",
                self.header_line,
                remedy="name what the dial shows, `unit=mm` or um or inch, or write it above the "
                "header: '# unit: mm'",
            )
        self._check_other_units()

    def _general(self, option: str | None) -> Unit | None:
        asked = parse_unit(option) if option is not None else None
        stated = self._stated("unit")
        if asked and stated and not _is_same(asked, stated):
            self.faults.add(
                f"`unit={option}` against the file's unit {stated.name}",
                self.statements["unit"].line,
                remedy=f"leave `unit=` out, or write '# unit: {asked.name}' in the file if it is "
                "wrong",
            )
        return asked or stated

    def _of_axis(self, column: Column, behind: Mapping[str, int]) -> Unit | None:
        """Return the unit of an axis; header, values and statements must agree.

        ``unit_Y`` is a statement about one axis and goes before ``unit``; a header does not.
        """
        axis, field = column.name, column.position + 1
        named, general = self._stated(f"unit_{axis.lower()}", axis), self.general
        if axis == "theta" and "unit" in self.statements:
            general = read_unit(_spelt(self.statements["unit"].value, axis)) or general
        places = [(column.unit, self.header_line), *behind.items()]
        known = {} if named is None else {named: self.header_line}
        for text, line in places:
            spelt = _spelt(text, axis)
            if text and (one := _known_unit(spelt, f"{axis}: ", line, field, self.faults)):
                known.setdefault(one, line)
        stated = named is not None or bool(column.unit)
        if general and not named and any(u.dimension is general.dimension for u in known):
            known.setdefault(general, self.header_line)
        elif "" in behind and len(behind) > 1 and not stated:
            remedy = "write the unit once, in the header, as 'X [mm]'"
            what = f"{axis}: a unit behind some values only"
            self.faults.add(what, behind[""], field, remedy=remedy)
        unit = next(iter(known), general)
        other = next((one for one in known if unit and not _is_same(one, unit)), None)
        if unit and other:
            of = self.statements.get(f"unit_{axis.lower()}") or self.statements.get("unit")
            where = f" (in {self.faults.place(0)})" if of and not of.line else ""
            a, b = (other.name, unit.name) if named else (unit.name, other.name)
            what = f"{axis}: unit {a} against {b}{where}"
            remedy = "let header, values and metadata state the same unit"
            self.faults.add(what, known[other], field, remedy=remedy)
        if unit and axis != "theta" and unit.dimension is Dimension.ANGLE:
            what = f"{axis} is a length and cannot be in {unit.name}"
            remedy = "write its unit of length, as mm; call a column of angles theta"
            self.faults.add(what, self.header_line, field, remedy=remedy)
        return unit

    def _stated(self, key: str, axis: str = "") -> Unit | None:
        if key not in self.statements:
            return None
        value, line = self.statements[key]
        return _known_unit(_spelt(value, axis), f"{key}: ", line, None, self.faults)

    def _check_other_units(self) -> None:
        """Add each free key whose value is a unit that readings are not in, or a part of theirs.

        ``display: um``, ``dial: hundredths``; of an axis one with digits too: ``Y: 1/100 mm``.
        """
        for key, (written, line) in self.statements.items():
            value = written or unit_in_brackets(key.replace("_", " "))
            of_axis = AN_AXIS.search(key) and parse_cell(value) is None
            word = value.lower() not in _LETTERS and not any(map(str.isdigit, value))
            unit = read_unit(value.strip("()")) if of_axis or word else None
            in_parts = self._in_whole_units() and in_parts_of_a_unit(value)
            if not (unit or in_parts) or is_of_axes(key) or is_of_another(key):
                continue
            dimension = unit.dimension if unit else Dimension.LENGTH
            like = [one for one in self.units.values() if one.dimension is dimension]
            if like and not (unit and any(_is_same(unit, one) for one in like)):
                what = f"{key}: {quoted(value)}, and readings are taken in {like[0].name}"
                remedy = f"write the unit of the readings as '# unit: {like[0].name}', and no other"
                self.faults.add(what, line, remedy=remedy)

    def _in_whole_units(self) -> bool:
        """Say whether a length is read in mm or a larger unit, of which people name parts."""
        return any(
            one.dimension is Dimension.LENGTH and one.to_base(1.0) >= 1
            for one in self.units.values()
        )

    def check_words(self, rows: Iterable[Row]) -> None:
        """Add each line of words that names another unit than that of the axes, or parts of one.

        ``Abweichungen in µm`` above ``X [mm]``, ``Werte in Hundertstel`` where they are read as mm.
        """
        lengths = [one for one in self.units.values() if one.dimension is Dimension.LENGTH]
        for row in rows if lengths else ():
            other = length_in_words(row.text)
            known = other is None or any(_is_same(other, one) for one in lengths)
            parts = self._in_whole_units() and in_parts_of_a_unit(row.text)
            if not known or parts:
                where = "" if row.line else f" in {self.faults.place(0)}"
                what = f"{quoted(row.text)}{where}, and readings are taken in {lengths[0].name}"
                remedy = (
                    "which of them is it? state it as '# unit: 0.01 mm' or the like, and only once"
                )
                self.faults.add(what, row.line, remedy=remedy)

    def of_no_axis(self) -> Iterator[str]:
        """Yield the statements about an axis that is not among those of the table."""
        for key in filter(is_of_axes, self.statements):
            found = _OF_ONE.fullmatch(key)
            axis = next((name for name in AXES if found and name.lower() == found[1]), None)
            if axis is not None and axis not in self.units:
                yield f"{key} not used: there is no axis {axis}"

    def sizes(
        self, key: str, option: float | None = None, *, above: float = 0.0
    ) -> dict[str, float]:
        """Return by axis what ``key``, or ``key_X`` and the like, state; ``option`` goes before."""
        return {**self._for_all(key, option, above), **self._of_one(key, above)}

    def _of_one(self, key: str, above: float) -> dict[str, float]:
        own = {axis: self.statements.get(f"{key}_{axis.lower()}") for axis in self.units}
        sizes = {a: self._size(one, f"{key}_{a}", a, above) for a, one in own.items() if one}
        return {axis: size for axis, size in sizes.items() if size is not None}

    def _size(self, own: Statement, key: str, axis: str, above: float) -> float | None:
        size, unit = self._read(own, key, above), self.units[axis]
        if size is None:
            return None
        value, stated = size
        if stated and stated.dimension is not unit.dimension:
            what = f"{key} in {stated.name}, {axis} in {unit.name}"
            self.faults.add(what, own.line, remedy=f"state {key} in {unit.name}")
        return (stated or unit).to_base(value)

    def _for_all(self, key: str, option: float | None, above: float) -> dict[str, float]:
        stated = self.statements.get(key)
        size, line = (self._read(stated, key, above), stated.line) if stated else (None, None)
        if not self.units or (size is None and option is None):
            return {}
        unit = (size[1] if size else None) or self._common_unit()
        if unit is None:
            remedy = f"write the unit behind it, as '# {key}: 0.001 mm'"
            self.faults.add(f"{key}: the axes have different units", line, remedy=remedy)
            return {}
        value = unit.to_base(size[0]) if size else None
        if option is not None:
            asked = (self.general or unit).to_base(option)
            if stated and value not in (None, asked):
                what = f"`resolution={option!r}` against the file's {stated.value}"
                remedy = "leave `resolution=` out; or, if the file is wrong, mend it there"
                self.faults.add(what, line, remedy=remedy)
            value = asked
        axes = [axis for axis, one in self.units.items() if one.dimension is unit.dimension]
        if not axes:
            other = next(iter(self.units.values())).dimension.value
            remedy = f"state {key} in the unit of the readings, as '# {key}: 0.001 {other}'"
            if option is not None:
                remedy = "leave `resolution=` out, or let `unit=` be a unit of the readings"
            what = f"{key} in {unit.name}, and no axis is in such a unit"
            self.faults.add(what, line, remedy=remedy)
        return {} if value is None else dict.fromkeys(axes, value)

    def _common_unit(self) -> Unit | None:
        """Return the unit that a bare size is in: the stated one, else the one of all lengths."""
        units = list(self.units.values())
        lengths = [unit for unit in units if unit.dimension is Dimension.LENGTH] or units
        same = all(_is_same(unit, lengths[0]) for unit in lengths)
        return self.general or (lengths[0] if lengths and same else None)

    def _read(
        self, statement: Statement, key: str, above: float
    ) -> tuple[float, Unit | None] | None:
        number = parse_cell(statement.value)
        if number and number.mark in (Mark.EITHER, Mark.BOTH):
            number = parse_cell(statement.value, self.decimal) if self.decimal else None
        if number is None or not above < number.value < math.inf:
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

    def commands(self, pose: Labels | None, own: str | None) -> dict[str, Commanded]:
        """Return the command coordinates by axis: of columns, and a number or numbers by pose.

        ``own`` is what the head calls the only pose.
        """
        given = coded(pose)[0] if pose is not None else [own] if own else []
        labels = {normal_key(label): label for label in given}
        found, columns = self._stated_commands(labels), self.columns
        for column in columns.layout.of(Kind.COMMAND):
            size, name = self.units.get(column.name), f"command_{column.name}"
            unit = read_unit(column.unit) if column.unit else size
            if size is None:
                continue
            if unit is None or unit.dimension is not size.dimension:
                what = f"{name}: {quoted(column.unit)} is not a unit of {column.name}"
                columns.fault(column, what, remedy=f"state it in a unit such as {size.name}")
                continue
            if column.name in found or set(columns.units.get(column, {})) - {""}:
                what = f"{name} is stated twice, or has units behind its values"
                columns.fault(column, what, remedy="state it in one place, its unit in the header")
            try:
                found[column.name] = by_pose(name, unit.to_base(columns.values(column)), pose)
            except DataError as error:
                self.faults.add(error.what, None, column.position + 1, remedy=error.remedy)
        return found

    def _stated_commands(self, labels: Mapping[str, str]) -> dict[str, Commanded]:
        """Return those of the head; ``labels`` are the poses, by their names as keys have them."""
        found: dict[str, Commanded] = dict(self._of_one(COMMAND, _ANY))
        by_axis: dict[str, dict[str, float]] = {}
        for key, own in self.statements.items():
            match = OF_A_POSE.fullmatch(key)
            axis = next((a for a in self.units if match and a.lower() == match[1]), None)
            if match is None or axis is None:
                continue
            if axis in found:
                what = f"{COMMAND}_{axis} and {key}: of which pose is the first?"
                remedy = f"write its pose behind it, as '# {COMMAND}_{axis}[P1]: 100.0'"
                self.faults.add(what, own.line, remedy=remedy)
            size = self._size(own, key, axis, _ANY)
            if size is not None:
                by_axis.setdefault(axis, {})[labels.get(match[2], match[2])] = size
        return {**found, **by_axis}


def _spelt(unit: str, axis: str) -> str:
    """Return a unit as it is meant: of an angle, ``"`` is seconds of arc and no inches."""
    return "arcsec" if axis == "theta" and unit.strip("[]() ") == '"' else unit


def _known_unit(
    text: str, what: str, line: int | None, column: int | None, faults: Faults
) -> Unit | None:
    """Return the unit that a text spells; one that is not known is a fault of ``what``."""
    unit = read_unit(text)
    if unit is None:
        faults.add(f"{what}unknown unit {quoted(text)}", line, column, remedy=_UNITS)
    return unit


def sizes_in(statements: Mapping[str, Statement], below: Iterable[Row] = ()) -> list[str]:
    """Return statements about axes, lengths of any other key, and the cells ``below`` readings."""
    sizes = (one.value for one in statements.values() if length_in_mm(one.value) is not None)
    stated = (one.value for key, one in statements.items() if is_of_axes(key))
    return [*stated, *sizes, *(cell for row in below for cell in row.cells)]


def _is_same(a: Unit, b: Unit) -> bool:
    return a.dimension is b.dimension and a.numerator * b.denominator == b.numerator * a.denominator


_WIDEST_M = 20.0  # [m]: no robot that is tested moves its dial by as much


def check_metres(axis: Column, columns: Columns) -> None:
    """Add an axis whose readings [m] are whole or far apart: an export lost the µ of µm."""
    readings = columns.values(axis)
    whole = bool(np.all(readings == np.round(readings)))
    if np.ptp(readings) > _WIDEST_M or (whole and np.ptp(readings) > 0):
        remedy = "write um where the µ was lost; if these are metres, state them in mm"
        what = f"{axis.name} moves by {np.ptp(readings):g} m: was its unit µm?"
        columns.fault(axis, what, remedy=remedy)


_TURNS = tuple(10.0**k for k in range(-1, 6))  # what a dial may show before it is at zero again
_LEAST_TURN = 0.1  # mm: what is shorter is a step that robots make
_RANGES = ("range", "measuring_range", "messbereich")
_ROLLED = (
    "add its range to the readings behind it; where the dial shows more, say '# range: 25 mm' "
    "above the header"
)
_FEW, _MOST = 3, 500  # rows that each end has, and beyond which a table is a stream


def check_turns(run: Run, units: Mapping[str, Unit], columns: Columns) -> None:
    """Add each axis whose readings lie at both ends of a dial's range (a stated one) alone."""
    stated = next((run.metadata[key] for key in _RANGES if key in run.metadata), None)
    number = parse_cell(stated) if stated else None
    for _, rows in run.rows_by_pose() if len(run) <= _MOST else ():
        for name, axis in run.axes.items():
            turns = [number.value] if number else _TURNS
            at = _turn(axis.take(rows), [units[name].to_base(1.0) * turn for turn in turns])
            if at is not None:
                what = f"{name} lies at both ends of 0 .. {at:g} mm: did the dial roll over?"
                columns.faults.add(what, int(columns.all_lines()[rows[0]]), remedy=_ROLLED)


def _turn(axis: Axis, turns: Iterable[float]) -> float | None:
    """Return the range [mm] at whose ends the readings lie, or None."""
    values = np.sort(axis.shown)
    steps = np.diff(values)
    low = int(np.argmax(steps)) + 1 if len(steps) else 0
    both = _FEW <= low <= len(values) - _FEW and values[0] >= 0
    if axis.dimension is Dimension.ANGLE or not both:
        return None
    gap = float(steps[low - 1])
    fitting = (t for t in turns if t >= _LEAST_TURN and values[-1] <= t and t - gap < gap / 5)
    return next(fitting, None)


_POSITIVE = ("uncertainty", "alignment_u_deg")
_MOST_NAMED = 5


def stated_corrections(correction: Correction, axis: str) -> Iterator[tuple[str, str]]:
    """Yield the statements of a correction, which `corrected` reads back."""
    for key, name in CORRECTION_KEYS.items():
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
    from_zero = run.dial_zero_is_command
    unknown = [
        f"a correction of {axis}, which is not an axis of this table"
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
                shown = axes[name].readings  # the longest distance measured is its reach
                reach = np.abs(shown).max() if from_zero else np.ptp(shown)
                axes[name] = correction.applied(axes[name], reach=float(reach))
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
        if (match := OF_A_CORRECTION.fullmatch(key)) is None:
            continue
        name = CORRECTION_KEYS[match[1].lower()]
        value = _points(text) if name == "points" else parse_number(text)
        if value is None or (name in _POSITIVE and not isinstance(value, tuple) and value <= 0):
            wanted = "'0 0; 2 0.001; 5 -0.002'" if name == "points" else "a number, such as 0.5"
            wrong.append(f"{key}: {text[:40]!r} is not {wanted} (in mm, or degrees)")
        else:
            found.setdefault(names[match[2].lower()], {})[name] = value
    return {axis: Correction(**values) for axis, values in found.items()}, wrong  # type: ignore[arg-type]  # as CORRECTION_KEYS has them


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


def _said(correction: Correction, axis: Axis) -> str:
    parts = []
    if correction.points:
        zero = "" if correction.zero is None else f", zeroed at {correction.zero:g}"
        parts.append(f"certificate's curve of {len(correction.points)} points{zero}")
    if correction.alignment_deg is not None:
        parts.append(f"cosine of {correction.alignment_deg:g} deg")
    added = axis.readings - axis.shown
    return f"{' and '.join(parts)}: {added.min():+.3g} .. {added.max():+.3g} {axis.unit}"
