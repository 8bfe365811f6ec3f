"""The tables of a gauge study: readings of a dial, with part, operator, session and true value.

A recording is such a table: its poses are the parts, and what its head states of all of it
(``# operator: Anna``) holds for every reading.

The readings of a study of one dial: each with the part, operator or session that it is of.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import PurePath
from typing import Any, Literal, TypeAlias, cast

import numpy as np

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.published import ALWAYS, INTERNAL, Unit as BaseUnit, published
from scara_iso.base.quantities import Unit, size_in, unwrap, which_unit
from scara_iso.run import AXES, FloatArray, IntArray
from scara_iso.tables import ColumnNames, NamedColumns, Source, read_columns


@dataclass(frozen=True, slots=True)
class Remark:
    """Something to know about the dial of an axis before its figures are signed."""

    severity: Literal["warning", "info"]
    """Whether it doubts the figures."""
    axis: str
    """Whose dial."""
    message: str
    """In words."""


@dataclass(frozen=True, eq=False, slots=True)
class GaugeReadings:
    """Readings of one dial in the order in which they were taken, shape (n,), in mm or degrees."""

    axis: str = field(metadata=INTERNAL)
    """``X``, ``Y``, ``Z``, ``theta`` or ``reading``."""
    values: FloatArray = field(metadata=published("readings"))
    """What the dial showed."""
    unit: BaseUnit
    """Of every size here."""
    resolution: float | None = field(default=None, metadata=ALWAYS)
    """The dial's division; None where not stated."""
    uncertainty: float | None = field(default=None, metadata=ALWAYS)
    """Standard uncertainty of the dial, from its certificate; None where not stated."""
    reference: FloatArray | None = field(default=None, metadata=INTERNAL)
    """True value of what each reading is of, shape (n,); None where not stated."""
    part: tuple[str, ...] | None = field(default=None, metadata=INTERNAL)
    """What each reading is of."""
    operator: tuple[str, ...] | None = field(default=None, metadata=INTERNAL)
    """Who took it."""
    session: tuple[str, ...] | None = field(default=None, metadata=INTERNAL)
    """When it was taken: readings of one session stand together."""
    time: tuple[str, ...] | None = field(default=None, metadata=INTERNAL)
    """Date and time as the table has them."""
    source: str = field(default="", metadata=INTERNAL)
    """File that it was read from."""

    def warn(self, message: str) -> Remark:
        """Return a doubt about the figures of these readings."""
        return Remark("warning", self.axis, message)

    def note(self, message: str) -> Remark:
        """Return what else is to be known of them."""
        return Remark("info", self.axis, message)

    def refuse(self, what: str, remedy: str) -> DataError:
        """Return the error that these readings make no such study."""
        return DataError(f"axis {self.axis}: {what}", where=self.source, remedy=remedy)


def numbered(labels: Sequence[str]) -> tuple[tuple[str, ...], IntArray]:
    """Return the labels in order of first appearance, and the number of each reading's."""
    names = tuple(dict.fromkeys(labels))
    at = {name: k for k, name in enumerate(names)}
    return names, np.array([at[label] for label in labels], dtype=np.int64)


READING = "reading"
_DIALS = (*AXES, READING)
_FACTORS = ("part", "operator", "session")
_REMEDY = (
    "give a column X (or Y, Z, theta, reading) with '# unit: mm' above, and part, operator, "
    "session or reference beside it as the study has them"
)
_COLUMNS = ColumnNames(
    what="a gauge study",
    needed=(),
    remedy=_REMEDY,
    optional=(*_DIALS, *_FACTORS, "reference", "timestamp", "trial", "cycle", "time_s"),
    with_unit=(*_DIALS, "reference"),
    same_unit="reference",
    labels=frozenset((*_FACTORS, "timestamp", "trial", "cycle")),
    aliases={
        alias: name
        for name, aliases in {
            "part": "pose sample teil werkstück prüfling muster pièce pezzo pieza",
            "operator": "appraiser inspector prüfer bediener werker opérateur operatore operador",
            "session": "day date subgroup datum tag sitzung séance sessione sesión shift schicht",
            "reference": "master normal referenz referenzwert sollwert soll nominal nennmaß "
            "nennmass endmaß endmass étalon",
            "trial": "wiederholung",
            READING: "value measurement messwert anzeige",
        }.items()
        for alias in aliases.split()
    },
)
_TURNED = "passes a full turn and is unwrapped"
_GROUPS = "call it part, operator, session, reference or trial, whatever it is, or remove it"


@dataclass(frozen=True, eq=False, slots=True)
class GaugeTables:
    """What the tables of a study hold."""

    dials: tuple[GaugeReadings, ...]
    """One for each axis, in the order of `AXES`."""
    tolerances: Mapping[str, float]
    """By axis, where the tables state one [mm, deg]."""
    statements: Mapping[str, str]
    """``# key: value`` lines, where all tables agree."""
    notes: tuple[str, ...]
    """What was not used, one line each."""
    remarks: tuple[Remark, ...]
    """What the tables say of some of their rows."""


_Given: TypeAlias = Mapping[str, Mapping[str, float | str]]
"""``reference`` and ``tolerance`` by axis, as the user gives them: `_base_size`."""


def _check_given(sizes: _Given, axes: Sequence[str], where: str) -> None:
    for key, given in sizes.items():
        for axis, size in given.items():
            if axis not in axes and (axis or len(axes) > 1):
                raise UsageError(
                    f"`{key}={axis + '=' if axis else ''}{size}`: "
                    + (f"there is no dial {axis}" if axis else "there are several dials"),
                    where=where,
                    remedy=f"name one of {', '.join(axes)}: `{key}={axes[0]}={size}`",
                )


def _base_size(key: str, given: float | str, unit: Unit) -> float:
    """Return a size in mm or degrees, of readings in ``unit``.

    Text has a unit of its own. Raises `UsageError` for a bare tolerance where the readings are in
    another unit than mm or degrees, and for a unit of another kind.
    """
    if isinstance(given, str):
        size = size_in(given, unit.base_name)
        if size is None:
            remedy = f"give it in {unit.base_name}"
            raise UsageError(f"`{key}={given}`: the readings are in {unit.name}", remedy=remedy)
        return size
    if key == "tolerance" and unit.other:
        raise which_unit(key, given, unit)
    return unit.to_base(given)


def read_gauge_tables(
    sources: Sequence[Source],
    *,
    unit: str | None = None,
    resolution: float | None = None,
    decimal: str | None = None,
    references: Mapping[str, float | str] | None = None,
    tolerances: Mapping[str, float | str] | None = None,
) -> GaugeTables:
    """Return the readings of one study, of one table or several.

    ``unit`` and ``resolution`` (in it) stand for the files' statements, ``decimal`` as in
    `read_columns`; ``references`` (in the unit of the readings) and ``tolerances`` (in mm or
    degrees, or with a unit: ``"30um"``) by axis, the empty name for the only one. Several tables
    that differ in nothing are sessions. Raises as `read_columns`, `DataError` with every
    fault of a table, `UsageError` for options that contradict it.
    """
    given: _Given = {"reference": references or {}, "tolerance": tolerances or {}}
    tables = [read_columns(source, _COLUMNS, unit=unit, decimal=decimal) for source in sources]
    read = [_dials(table, resolution, given) for table in tables]
    axes = list(read[0])
    stated: dict[str, float] = {}
    for table, dials in zip(tables, read, strict=True):
        if list(dials) != axes:
            raise DataError(
                f"has the dials {', '.join(dials)}, and another table {', '.join(axes)}",
                where=table.source,
                remedy="one study is of the same dials",
            )
    for axis in axes:
        sizes = [(t.source, dials[axis][1]) for t, dials in zip(tables, read, strict=True)]
        if (size := _one_of("tolerance", sizes)) is not None:
            stated[axis] = size
    merged = [_joined([dials[axis][0] for dials in read]) for axis in axes]
    found = tuple(_on_one_turn(dial) for dial in merged)
    return GaugeTables(
        dials=found,
        tolerances=stated,
        statements=_agreed(tables),
        notes=tuple(f"{table.source}: {note}" for table in tables for note in table.notes),
        remarks=(
            *(
                Remark("warning", "", f"{table.source}: rows with a remark count: {remark}")
                for table in tables
                for remark in table.remarks
            ),
            *(one.note(_TURNED) for one, raw in zip(found, merged, strict=True) if one is not raw),
        ),
    )


def _dials(
    table: NamedColumns, resolution: float | None, given: _Given
) -> dict[str, tuple[GaugeReadings, float | None]]:
    """Return the readings of each dial of one table, and the tolerance that holds for them."""
    axes = [name for name in _DIALS if name in table.values]
    faults, line, scales = table.faults, table.header_line, table.scales
    if not axes:
        faults.add("no column of readings: X, Y, Z, theta or reading", line, remedy=_REMEDY)
    several = [k for k in ("reference", "tolerance") if k in table.statements or k in table.values]
    if len(axes) > 1 and several:
        said = f"one {several[0]}, and the dials {', '.join(axes)}"
        faults.add(f"{said}: write # {several[0]}_{axes[0]}", line, remedy=_REMEDY)
    for heading, count in table.groups.items():
        what = f"column {heading!r} parts the readings into {count} groups, and is not used"
        faults.add(what, line, remedy=_GROUPS)
    _check_given(given, axes, table.source)
    stated = {
        "resolution": scales.sizes("resolution", resolution),
        "indicator_uncertainty": scales.sizes("indicator_uncertainty"),
        "reference": scales.sizes("reference", above=-math.inf),
        "tolerance": scales.sizes("tolerance"),
    }
    if "reference" in table.values and stated["reference"]:
        faults.add("the reference is stated twice, once in a column", line, remedy=_REMEDY)
    faults.check()
    return {
        axis: _dial(
            table,
            axis,
            # the empty name is that of the only dial
            {k: one.get(axis, one.get("") if len(axes) == 1 else None) for k, one in given.items()},
            {k: one.get(axis) for k, one in stated.items()},
        )
        for axis in axes
    }


def _dial(
    table: NamedColumns,
    axis: str,
    given: Mapping[str, float | str | None],
    stated: Mapping[str, float | None],
) -> tuple[GaugeReadings, float | None]:
    unit = table.scales.units[axis]
    sizes = {}
    for key, value in given.items():
        size = None if value is None else _base_size(key, value, unit)
        sizes[key] = _one_of(key, [(table.source, stated[key]), (f"`{key}=`", size)])
    values, reference = table.values[axis], sizes["reference"]
    of_all = None if reference is None else np.full(len(values), reference)
    readings = GaugeReadings(
        axis=axis,
        values=values,
        unit=cast(BaseUnit, unit.base_name),
        resolution=stated["resolution"],
        uncertainty=stated["indicator_uncertainty"],
        reference=table.values.get("reference", of_all),
        time=table.labels.get("timestamp"),
        source=table.source,
        **{factor: _labels(table, factor) for factor in _FACTORS},
    )
    return readings, sizes["tolerance"]


def _labels(table: NamedColumns, name: str) -> tuple[str, ...] | None:
    stated = table.statements.get(name)
    rows = len(next(iter(table.values.values())))
    return table.labels.get(name) or (None if stated is None else (stated,) * rows)


def _one_of(key: str, stated: Sequence[tuple[str, float | None]]) -> float | None:
    """Return the one size that is stated; `UsageError` where two places state two."""
    found = {value: place for place, value in stated if value is not None}
    if len(found) > 1:
        said = ", ".join(f"{value:g} by {place}" for value, place in found.items())
        raise UsageError(f"the {key} is stated in two ways: {said}", remedy="leave one")
    return next(iter(found), None)


def _joined(dials: Sequence[GaugeReadings]) -> GaugeReadings:
    """Return the readings of several tables as one; they are sessions if they differ in nothing."""
    first = dials[0]
    for name in ("unit", "resolution", "uncertainty"):
        values = {getattr(one, name) for one in dials}
        if len(values) > 1:
            raise DataError(
                f"axis {first.axis}: the tables have not the same {name}: "
                + ", ".join(map(str, values)),
                where=dials[-1].source,
                remedy="one study is of the same dial",
            )
    factors: dict[str, Any] = {name: _all(dials, name) for name in (*_FACTORS, "time")}
    stated = _all(dials, "reference")
    reference = None if stated is None else np.array(stated)
    alike = all(len(set(factors[name] or ("",))) == 1 for name in _FACTORS)
    if len(dials) > 1 and alike and (reference is None or np.ptp(reference) == 0):
        stems = [(PurePath(one.source).stem, len(one.values)) for one in dials]
        factors["session"] = tuple(stem for stem, rows in stems for _ in range(rows))
    return replace(
        first,
        values=np.concatenate([one.values for one in dials]),
        reference=reference,
        source=", ".join(one.source for one in dials),
        **factors,
    )


def _on_one_turn(dial: GaugeReadings) -> GaugeReadings:
    """Return angles about their true value, else all together, else each part's together.

    The readings themselves where they are; refused where one part scatters over half a turn.
    """
    if dial.unit != "deg":
        return dial
    found = dial.values.copy()
    for labels in (alike := ("",) * len(found), dial.part or alike):
        names, at = numbered(labels)
        try:
            for rows in (at == k for k in range(len(names))):
                about = None if dial.reference is None else dial.reference[rows]
                found[rows] = unwrap(dial.values[rows], about)
            break
        except DataError as error:
            far = error
    else:
        raise dial.refuse(far.what, "check its unit and its far readings")
    return dial if np.array_equal(found, dial.values) else replace(dial, values=found)


def _all(dials: Sequence[GaugeReadings], name: str) -> tuple[Any, ...] | None:
    """Return what all tables have of one name, for each reading; None where none has it."""
    found = [getattr(one, name) for one in dials]
    lacking = [one for one, values in zip(dials, found, strict=True) if values is None]
    if not lacking:
        return tuple(value for values in found for value in values)
    if name != "time" and len(lacking) < len(dials):
        what = f"states no {name}, and another table does"
        raise lacking[0].refuse(what, f"write '# {name}: ...' in its head")
    return None


def _agreed(tables: Sequence[NamedColumns]) -> dict[str, str]:
    first, *others = (table.statements for table in tables)
    return {
        key: text for key, text in first.items() if all(other.get(key) == text for other in others)
    }
