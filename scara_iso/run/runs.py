"""`Run`: readings by cycle and axis, and where they came from.

The dial, a table and the model all produce this type.
"""

from __future__ import annotations

import copyreg
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import numpy.typing as npt

from scara_iso.base.displayed import Displayed
from scara_iso.base.errors import DataError
from scara_iso.base.published import ALWAYS, INTERNAL, MERGED, Count, fill, published
from scara_iso.base.quantities import TURN, Dimension, Unit, parse_unit, unwrap
from scara_iso.run.axis import (
    AXES,
    Axis,
    AxisKey,
    Commanded,
    FloatArray,
    IntArray,
    beyond_dials,
    read_only,
)
from scara_iso.run.columns import (
    arrival_labels,
    by_pose,
    check_clusters,
    coded,
    in_base,
    number_cycles,
    of_base_units,
    pop_direction,
    pose_column,
)
from scara_iso.run.frames import FRAME, axis_attributes, check_axes, make_frame, numbers_of

if TYPE_CHECKING:
    import pandas as pd


def _read_only(values: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(values)


# So a run's mappings go to another process too.
copyreg.pickle(MappingProxyType, lambda one: (_read_only, (dict(one),)))

SEPARATOR = " | "
"""Between the statements in one line of a table's head."""
_FEWEST_COPIED = 10
"""Rows that are the same in two runs by no chance."""


@dataclass(frozen=True, slots=True)
class TableField:
    """A column as the file has it, and what it was taken for."""

    field: Annotated[int, ("minimum", 1)]
    """Which field of a row it is, from 1."""
    header: str
    """What the header says of it."""
    kind: str
    """``axis``, ``cycle``, ``pose``, ``covariate`` and the like."""
    name: str
    """Of the axis or the covariate in the run, else empty."""
    unit: str
    """Of an axis; else empty."""


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a run came from: shown to the user, never computed with."""

    source: str = ""
    """File name, ``-`` for standard input, or what made the run."""
    understood: str = field(default="", metadata=published("read_as"))
    """One line: how the reader understood the file."""
    notes: tuple[str, ...] = ()
    """What the reader met and did not use, such as footer rows, one line each."""
    remarks: tuple[str, ...] = field(default=(), metadata=INTERNAL)
    """What somebody wrote at a few of the rows that count, each with its place."""
    units: Mapping[str, str] = field(default_factory=dict, metadata=INTERNAL)
    """Unit that each axis was read in."""
    other_units: tuple[str, ...] = field(default=(), metadata=INTERNAL)
    """Of several tables, those in another unit than the first, one line for each axis."""
    files: Mapping[str, str] = field(default_factory=dict, metadata=INTERNAL)
    """The table of each pose, where the run was put together from several."""
    header_line: Count | None = field(default=None, metadata=ALWAYS)
    """Line of the header; null where there is none, or several tables were read."""
    fields: tuple[TableField, ...] = ()
    """The columns of the file; none of several tables."""
    sheet: str = field(default="", metadata=INTERNAL)
    """The one of a workbook that was read."""

    @property
    def row_name(self) -> str:
        """What a line of the file is called: ``row`` in a sheet, else ``line``."""
        return "row" if self.sheet else "line"


def _as_texts(labels: npt.NDArray[np.str_] | None) -> tuple[str, ...] | None:
    return None if labels is None else tuple(labels.tolist())


def _or_no_lines(lines: IntArray | None) -> IntArray:
    return np.empty(0, np.int64) if lines is None else lines


@dataclass(frozen=True, eq=False, slots=True)
class Run(Displayed):
    """One test: a row per cycle (and pose), a column per indicator axis; read-only.

    ``cycle`` has shape (rows,); every axis, ``pose`` (labels), ``direction`` (of approach, ``+x``
    to ``-z``; ISO 9283 7.2.3) and each covariate as well. ``lines`` are the rows' line numbers in
    their file, if any. ``metadata`` holds the table's ``key: value`` lines as text. Raises
    `DataError` where shapes differ, no axis is there, or a value is not finite.
    """

    cycle: IntArray
    """By row."""
    axes: Annotated[Mapping[AxisKey, Axis], ("minProperties", 1)]
    """By name, in the order of `AXES`."""
    pose: npt.NDArray[np.str_] | None = field(
        default=None, metadata=published(by=_as_texts, always=True)
    )
    """By row; null without poses."""
    covariates: Mapping[str, FloatArray] = field(default_factory=dict, metadata=INTERNAL)
    """Other columns by name, each of shape (rows,)."""
    metadata: Mapping[str, str] = field(default_factory=dict, metadata=published("statements"))
    """What the file states."""
    lines: IntArray | None = field(default=None, metadata=published(by=_or_no_lines, always=True))
    """Of the file, by row; empty where not known."""
    origin: Origin = field(default_factory=Origin, metadata=MERGED)
    """Where the run came from; never computed with."""
    direction: npt.NDArray[np.str_] | None = field(default=None, metadata=INTERNAL)
    """Labels of the directions of approach; None where none are named."""

    def __post_init__(self) -> None:
        covariates = {name: read_only(one, np.float64) for name, one in self.covariates.items()}
        fill(
            self,
            cycle=read_only(self.cycle, np.int64),
            axes=MappingProxyType({name: self.axes[name] for name in _ordered(self.axes)}),
            covariates=MappingProxyType(covariates),
            metadata=MappingProxyType(dict(self.metadata)),
        )
        for name, kind in (("pose", np.str_), ("direction", np.str_), ("lines", np.int32)):
            if getattr(self, name) is not None:
                fill(self, **{name: read_only(getattr(self, name), kind)})
        self._check_shapes()

    def _check_shapes(self) -> None:
        if not self.axes:
            raise DataError("a run needs at least one axis", remedy="name X, Y, Z or theta")
        if not len(self):
            raise DataError("a run needs at least one cycle")
        columns: dict[str, npt.NDArray[np.generic]] = {
            **{name: axis.readings for name, axis in self.axes.items()},
            **self.covariates,
        }
        others = {"pose": self.pose, "direction": self.direction, "lines": self.lines}
        columns |= {name: values for name, values in others.items() if values is not None}
        misnamed = [key for key, axis in self.axes.items() if key != axis.name]
        if misnamed:
            raise DataError(f"axis {misnamed[0]} holds the readings of another")
        wrong = [name for name, values in columns.items() if values.shape != self.cycle.shape]
        if wrong:
            raise DataError(f"{', '.join(wrong)}: not one value for each of {len(self)} rows")
        absurd = [n for n, a in self.axes.items() if beyond_dials(a.readings).any()]
        if absurd:
            raise DataError(f"{', '.join(absurd)}: a reading is not finite, or beyond any dial")
        gone = [name for name, values in self.covariates.items() if not np.isfinite(values).all()]
        if gone:
            raise DataError(f"{', '.join(gone)}: a value is missing or not finite")

    def __repr__(self) -> str:
        poses = len(list(self.rows_by_pose()))
        named = f" of {self.origin.source}" if self.origin.source else ""
        return f"<Run{named}: {', '.join(self.axes)}; {len(self)} rows, {poses} pose(s)>"

    def __len__(self) -> int:
        return len(self.cycle)

    def take(self, rows: IntArray) -> Run:
        """Return the run of some of its rows, given by number from 0; one pose has no label."""
        labels = None if self.pose is None else self.pose[rows]
        one_pose = labels is None or len(set(labels.tolist())) == 1
        label = str(labels[0]) if labels is not None and one_pose and len(labels) else None
        axes = {name: a.take(rows) for name, a in self.axes.items()}
        if one_pose:
            axes = {n: replace(a, command=self.command_of(n, label)) for n, a in axes.items()}
        return replace(
            self,
            cycle=self.cycle[rows],
            axes=axes,
            pose=None if one_pose else labels,
            covariates={name: values[rows] for name, values in self.covariates.items()},
            lines=None if self.lines is None else self.lines[rows],
            direction=None if self.direction is None else self.direction[rows],
        )

    def unwrapped(self) -> Run:
        """Return the run with the angles of each pose on one turn (`quantities.unwrap`).

        The run itself where they are; `DataError` where they scatter over more than half a turn.
        """
        moved = {}
        for name, axis in self.axes.items():
            if axis.dimension is Dimension.ANGLE and np.ptp(axis.readings) > TURN / 2:
                readings = _on_one_turn(self, axis)
                if not np.array_equal(readings, axis.readings):
                    moved[name] = replace(axis, readings=readings)
        if not moved:
            return self
        said = f"{', '.join(moved)} passes a full turn and is unwrapped about its mean"
        understood = "; ".join(part for part in (self.origin.understood, said) if part)
        origin = replace(self.origin, understood=understood)
        return replace(self, axes={**self.axes, **moved}, origin=origin)

    def command_of(self, axis: str, label: str | None) -> float | None:
        """Return the command coordinate of an axis at a pose, None where none is stated for it."""
        stated = self.axes[axis].command
        if isinstance(stated, Mapping):
            pose = self.arrival_at(label)[0]
            return stated.get(self.metadata.get("pose", "") if pose is None else pose)
        several = self.pose is not None and bool(np.any(self.pose != self.pose[0]))
        return None if several else stated

    @property
    def simulated(self) -> str:
        """What is said of readings that no dial showed, be it at one of several poses; or nothing.

        ``simulated: X`` in the head of a table, ``simulated[P2]`` where several are one run.
        """
        heads = ((key.partition("["), text) for key, text in self.metadata.items())
        found = [
            f"{text} at {pose[:-1]}" if pose else text
            for (key, _, pose), text in heads
            if key == "simulated" and text
        ]
        return f"SIMULATED readings ({', '.join(found)}): no robot was measured" if found else ""

    @property
    def dial_zero_is_command(self) -> bool:
        """Whether ``# dial_zero: command`` is stated: AP means something only then."""
        return self.metadata.get("dial_zero", "").strip().lower() == "command"

    @property
    def stated_units(self) -> dict[str, Unit]:
        """Units of the axes that were given in another than mm or degrees, by axis."""
        return {name: one.stated_unit for name, one in self.axes.items() if one.stated_unit}

    def rows_by_pose(self) -> Iterator[tuple[str | None, IntArray]]:
        """Yield each pose's label and row numbers, poses in order of first appearance.

        A run without a pose column is one pose, labelled None; a pose that is approached from
        several directions is one for each, as ``P1 from +x``.
        """
        labels = arrival_labels(self.pose, self.direction)
        if labels is None:
            yield None, np.arange(len(self))
            return
        names, codes = coded(labels)
        found = np.split(np.argsort(codes, kind="stable"), np.cumsum(np.bincount(codes))[:-1])
        yield from zip(names, found, strict=True)

    def arrival_at(self, label: str | None) -> tuple[str | None, str | None]:
        """Return pose and direction of approach of a label that `rows_by_pose` yields."""
        arrived = arrival_labels(self.pose, self.direction)
        if arrived is None or self.direction is None or label not in arrived:
            return label, None
        row = int(np.argmax(arrived == label))
        return None if self.pose is None else str(self.pose[row]), str(self.direction[row])

    def to_frame(self) -> pd.DataFrame:
        """Return the run as a pandas table; `from_frame` reads it back to the same run.

        Columns: ``cycle``, ``pose`` if there, axes [mm, deg], covariates; metadata in ``attrs``.
        """
        columns: dict[str, npt.NDArray[np.generic]] = {"cycle": self.cycle}
        columns |= {"pose": self.pose} if self.pose is not None else {}
        columns |= {"approach": self.direction} if self.direction is not None else {}
        columns |= {name: axis.readings for name, axis in self.axes.items()}
        attributes = {"metadata": dict(self.metadata), "axes": axis_attributes(self.axes)}
        return make_frame({**columns, **self.covariates}, attributes)

    @classmethod
    def from_frame(
        cls,
        frame: pd.DataFrame,
        *,
        unit: str | None = None,
        resolution: float | None = None,
        metadata: Mapping[str, str] | None = None,
    ) -> Run:
        """Return the run that a pandas table holds.

        Columns X, Y, Z and theta are axes, ``cycle`` (see `number_cycles`), ``pose`` (or another
        of `POSE_NAMES`, in any case), ``approach`` (+1/-1, or ``+x`` and the like) and
        ``command_X`` are what they say, any other numeric one is a covariate, in seconds or °C
        where its name ends in another unit of time or temperature. ``unit`` (``mm``,
        ``deg``, ``0.01 mm`` ...) and ``resolution`` (in that unit) hold for every axis, unless
        `to_frame` left others in ``attrs``. Raises `DataError` without an axis or its unit, for a
        value that is missing or not finite, naming column and row, and for a column that parts
        the readings as poses do.
        """
        kept = frame.attrs.get("axes", {})
        values = {str(name): frame[name] for name in frame.columns}
        named = pose_column(values)
        check_axes(frame, AXES, kept, unit)
        given = {"unit": unit, "resolution": resolution}
        pose = None if named is None else values.pop(named).to_numpy(dtype=str)
        direction = pop_direction(values)
        numbers = of_base_units({name: numbers_of(name, column) for name, column in values.items()})
        counted = numbers.pop("cycle", None)
        if counted is not None and np.any(counted != np.round(counted)):
            raise DataError("column 'cycle' holds a number that is not whole")
        axes = {
            name: _axis(
                name,
                numbers.pop(name),
                kept.get(name, given),
                by_pose(f"command_{name}", numbers.pop(f"command_{name}", None), pose),
            )
            for name in AXES
            if name in numbers
        }
        run = cls(
            cycle=number_cycles(counted, arrival_labels(pose, direction), len(frame)),
            axes=axes,
            pose=pose,
            covariates=numbers,
            metadata=frame.attrs.get("metadata", {}) if metadata is None else metadata,
            origin=Origin(source=FRAME),
            direction=direction,
        ).unwrapped()
        check_clusters(run.axes, run.rows_by_pose(), run.covariates, run.metadata, FRAME)
        return run


def _on_one_turn(run: Run, axis: Axis) -> FloatArray:
    found = axis.readings.copy()
    for label, rows in run.rows_by_pose():
        try:
            found[rows] = unwrap(axis.readings[rows])
        except DataError as error:
            what = f"{axis.name}{f' at pose {label}' if label else ''}: {error.what}"
            remedy = "check its unit and its far readings"
            raise DataError(what, where=run.origin.source, remedy=remedy) from error
    return found


def _axis(name: str, values: FloatArray, stated: Mapping[str, Any], command: Commanded) -> Axis:
    size = parse_unit(stated["unit"])
    known = {**stated, **({} if command is None else {"command": command})}
    sizes: dict[str, Any] = {k: in_base(known[k], size) for k in known if k != "unit"}
    return Axis(name, size.to_base(values), size.dimension, **sizes, stated_unit=size.other)


def copies(runs: Iterable[tuple[str, Run]]) -> Iterator[tuple[str, str]]:
    """Yield each run whose columns are those of an earlier one, and that: one was copied."""
    seen: dict[tuple[bytes, ...], str] = {}
    for name, run in runs:
        readings = [axis.readings for axis in run.axes.values()]
        if len(run) >= _FEWEST_COPIED and any(np.ptp(values) > 0 for values in readings):
            columns = tuple(one.tobytes() for one in (*readings, *run.covariates.values()))
            if columns in seen:
                yield name, seen[columns]
            seen.setdefault(columns, name)


def _ordered(axes: Mapping[str, Axis]) -> list[str]:
    return [name for name in AXES if name in axes] + [name for name in axes if name not in AXES]
