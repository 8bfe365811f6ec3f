"""What columns tell of poses: cycles by pose, one number for each, poses under another name."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, MutableMapping, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.quantities import Unit, unwrap

if TYPE_CHECKING:
    import pandas as pd

Labels = npt.NDArray[np.str_]
IntArray = npt.NDArray[np.int64]

Commanded = float | Mapping[str, float] | None
"""A coordinate of the command pose: of the only pose, or by pose; None where not stated."""
CONDITIONS = frozenset({"approach", "block", "payload_kg", "speed", "temperature_C", "time_s"})
"""Covariates that are known to be no poses; ``# covariates: name, name`` states others."""
POSE_NAMES = frozenset(
    {
        "pose",
        "pose label",
        "pose name",
        "pose no",
        "point",
        "point no",
        "point name",
        "punkt",
        "punkt nr",
        "target",
        "target point",
        "ziel",
        "zielpunkt",
        "position",
        "station",
        "messpunkt",
        "messposition",
        "messstelle",
        "measuring point",
        "measurement point",
        "test point",
        "location",
    }
)
"""What people call the column of poses, in lower case."""

_NUMBERED = r"(?:p|pose|point|punkt)[ _.-]?[0-9]{1,3}"
_AXIS = r"(?:x|y|z|theta)"
_OF_A_POSE = re.compile(
    rf"(?:{_NUMBERED}[ _:.-]+{_AXIS}|{_AXIS}[ _:.-]+{_NUMBERED})(?: ?[\[(/,].*|[ _][^ _]+)?",
    re.IGNORECASE,
)
"""A column of one axis at one pose: ``P2 X``, ``X_P2 [mm]``."""
_FEWEST_ROWS = 3  # a level of fewer rows is a slip that somebody remarked on
_LONGEST = 500  # rows beyond which a table is a stream, which goes from pose to pose
_SAMPLE = 999  # rows that show whether a column has few values
_FARTHEST = 5  # times the spread of a level (some 20 sigma): no covariate of one pose does that


def pose_column(names: Iterable[str]) -> str | None:
    """Return which column holds the poses: ``pose``, or else the one with another name for it.

    Raises `DataError` for two of them, and where poses stand beside each other as columns.
    """
    names = list(names)
    wide = [name for name in names if _OF_A_POSE.fullmatch(name.strip())]
    if wide:
        raise DataError(
            f"columns {', '.join(map(repr, wide[:6]))} name a pose each",
            remedy="put the rows of the poses below each other, with a column 'pose'",
        )
    found = [name for name in names if name.strip().lower().replace("_", " ") in POSE_NAMES]
    if len(found) > 1 and "pose" not in found:
        raise DataError(
            f"columns {', '.join(map(repr, found))} all name the pose", remedy="keep one of them"
        )
    return "pose" if "pose" in found else next(iter(found), None)


def no_such_pose(pose: str, labels: Iterable[str | None], where: str) -> UsageError:
    """Return the error of a pose that was named and is not among those of a run."""
    there = [label for label in labels if label is not None][:20]
    said = f"it has {', '.join(there)}" if there else "it names no pose: leave `pose=` out"
    return UsageError(f"no pose {pose!r} in {where}", remedy=said)


def read_direction(text: str) -> str | None:
    """Return the direction of approach that a cell spells: ``+x`` to ``-z``; None for another."""
    match = _DIRECTION.fullmatch(text.strip().translate(_MINUS))
    return None if match is None else match[1].lower()


_DIRECTION = re.compile(r"'?([+-][xyz])", re.IGNORECASE)  # after ' in a guarded spreadsheet cell
_MINUS = str.maketrans("\u2212\u2013", "--")


def pop_direction(columns: MutableMapping[str, pd.Series]) -> Labels | None:
    """Take the column ``approach`` out where it holds directions; those of each row, or None."""
    found = columns.get("approach")
    read = [] if found is None else [read_direction(str(cell)) for cell in found.tolist()]
    if not read or None in read:
        return None
    del columns["approach"]
    return np.array(read)


def arrival_labels(pose: Labels | None, direction: Labels | None) -> Labels | None:
    """Return which readings belong together, a label for each row: pose, and direction if several.

    None where there is one pose and one direction without a name.
    """
    if direction is None or not np.any(direction != direction[:1]):
        return pose
    return direction if pose is None else np.char.add(np.char.add(pose, " from "), direction)


def arrival_at(
    label: str | None, pose: Labels | None, direction: Labels | None
) -> tuple[str | None, str | None]:
    """Return pose and direction of a label of `arrival_labels`, None for what it has none of."""
    arrived = arrival_labels(pose, direction)
    if arrived is None or direction is None or label not in arrived:
        return label, None
    row = int(np.argmax(arrived == label))
    return None if pose is None else str(pose[row]), str(direction[row])


def coded(labels: Labels) -> tuple[list[str], npt.NDArray[np.int32]]:
    """Return each label once, in order of first appearance, and the place among them of each row's.

    Without a list of all rows, and several times as fast as `np.unique`, which sorts texts.
    """
    known: dict[str, int] = {}
    codes = np.empty(len(labels), np.int32)
    for k in range(0, len(labels), _SAMPLE):
        some = labels[k : k + _SAMPLE].tolist()
        codes[k : k + len(some)] = [known.setdefault(label, len(known)) for label in some]
    return list(known), codes


def rows_by_label(labels: Labels | None, rows: int) -> Iterator[tuple[str | None, IntArray]]:
    """Yield each label and its row numbers, in order of first appearance; None has all rows."""
    if labels is None:
        yield None, np.arange(rows)
        return
    names, codes = coded(labels)
    found = np.split(np.argsort(codes, kind="stable"), np.cumsum(np.bincount(codes))[:-1])
    yield from zip(names, found, strict=True)


def unwrap_by_pose(
    name: str,
    readings: npt.NDArray[np.float64],
    poses: Iterable[tuple[str | None, IntArray]],
    *,
    where: str,
) -> npt.NDArray[np.float64]:
    """Return an axis' angles [deg], shape (rows,), those of each pose on one turn.

    Raises `DataError` where a pose's scatter over more than half a turn.
    """
    found = readings.copy()
    for label, rows in poses:
        try:
            found[rows] = unwrap(readings[rows])
        except DataError as error:
            what = f"{name}{f' at pose {label}' if label else ''}: {error.what}"
            remedy = "check its unit and its far readings"
            raise DataError(what, where=where, remedy=remedy) from error
    return found


def in_base(command: Commanded, unit: Unit) -> Commanded:
    """Return a coordinate, or those by pose, in mm or degrees."""
    if isinstance(command, Mapping):
        return {label: unit.to_base(number) for label, number in command.items()}
    return None if command is None else unit.to_base(command)


def number_cycles(
    counted: npt.NDArray[np.float64] | IntArray | None, pose: npt.NDArray[np.str_] | None, rows: int
) -> npt.NDArray[np.int64]:
    """Return the cycle of each row, shape (rows,), of which ``counted`` are the numbers if any.

    Where rows of several poses have none, or numbers that count all visits, the n-th row of a pose
    is its cycle n; numbers of visits in turn also tell which of them is missing.
    """
    numbers = np.arange(1, rows + 1) if counted is None else counted.astype(np.int64, copy=False)
    if pose is None or np.any(numbers[1:] <= numbers[:-1]):
        return numbers
    _, place = coded(pose)
    visits = np.bincount(place)
    poses = len(visits)
    if poses < 2 or visits.max() < 2:
        return numbers
    if counted is not None:
        turn = numbers - min(int(numbers[0]), 1)
        if len(set(zip((turn % poses).tolist(), place.tolist(), strict=True))) == poses:
            return np.asarray(turn // poses + 1)
        if np.any(np.diff(numbers) > 1) or numbers[0] > 1:
            return numbers
    order = np.argsort(place, kind="stable")
    first = np.cumsum(visits) - visits
    cycle = np.empty(rows, dtype=np.int64)
    cycle[order] = np.arange(rows) - np.repeat(first, visits) + 1
    return cycle


def by_pose(
    name: str, values: npt.NDArray[np.float64] | None, pose: npt.NDArray[np.str_] | None
) -> Commanded:
    """Return what a column that holds one number for each pose says, or raise `DataError`."""
    if values is None:
        return None
    labels = ["" for _ in values] if pose is None else pose.tolist()
    found = dict(zip(labels, values.tolist(), strict=True))
    if any(found[label] != value for label, value in zip(labels, values.tolist(), strict=True)):
        raise DataError(
            f"column {name!r} changes within a pose", remedy="a pose has one command coordinate"
        )
    return found if pose is not None else found[""]


class Readings(Protocol):
    """What is asked of an axis."""

    @property
    def readings(self) -> npt.NDArray[np.float64]:
        """Shape (rows,)."""

    @property
    def resolution(self) -> float | None:
        """In the unit of the readings."""

    @property
    def unit(self) -> str:
        """Of the readings."""


def check_clusters(
    axes: Mapping[str, Readings],
    poses: Iterable[tuple[str | None, npt.NDArray[np.int64]]],
    columns: Mapping[str, npt.NDArray[np.generic]],
    metadata: Mapping[str, str],
    *,
    where: str,
) -> None:
    """Refuse readings that a column parts at a pose as poses are parted; ``where`` are they from.

    ``poses`` are labels with their rows; ``columns`` of shape (rows,). Known conditions, and those
    that ``metadata`` states as ``covariates``, are passed over. So are readings at several levels
    refused where no pose is named.
    """
    stated = {name.strip().lower() for name in metadata.get("covariates", "").split(",")}
    few = {name: values for name, values in columns.items() if _is_few(values[:_SAMPLE])}
    known = {name for name in few if name in CONDITIONS or name.lower() in stated}
    asked = {name: values for name, values in few.items() if name not in known}
    labelled = list(poses)
    at_poses = [rows for _, rows in labelled] if asked else []
    for name, values in asked.items():
        for rows in at_poses:
            for axis, of_it in axes.items():
                found = _apart(of_it.readings[rows], values[rows], of_it.resolution)
                if found is not None:
                    raise DataError(
                        f"column {name!r} parts the readings of {axis} as poses would: "
                        f"about {found[0]:.6g} and about {found[1]:.6g} {of_it.unit}",
                        where=where,
                        remedy=f"name the column 'pose', or say '# covariates: {name}' above the "
                        "header if it is a condition of one pose",
                    )
    if [label for label, _ in labelled] == [None] and "pose" not in metadata:
        _check_levels(axes, [few[name] for name in known], where)


def _check_levels(
    axes: Mapping[str, Readings], conditions: Sequence[npt.NDArray[np.generic]], where: str
) -> None:
    """Refuse readings of no named pose at three levels or more, far apart under each condition."""
    for name, axis in axes.items():
        together = np.stack([*conditions, np.zeros(len(axis.readings))], axis=-1)
        _, condition = np.unique(together, axis=0, return_inverse=True)
        for k in range(int(condition.max()) + 1):
            levels = _levels(axis.readings[condition.ravel() == k], axis.resolution)
            if levels:
                said = ", ".join(f"{level:.6g}" for level in levels[:6])
                raise DataError(
                    f"{name} lies at {len(levels)} levels far apart, as the readings of several "
                    f"poses do: about {said} {axis.unit}",
                    where=where,
                    remedy="name the poses in a column 'pose'; if this is one pose, say "
                    "'# pose: P1' above the header",
                )


def _levels(readings: npt.NDArray[np.float64], division: float | None) -> list[float]:
    """Return the middles of three levels or more, far apart as `_apart` has it; else none."""
    values = np.sort(readings)
    steps = np.diff(values)
    if not 3 * _FEWEST_ROWS <= len(values) <= _LONGEST or not steps.any():
        return []
    # a dial may step by more than its last decimal: readings one step apart are no levels
    step = max(steps[steps > 0].min(), division or 0.0)
    widest = np.argsort(-steps, kind="stable")
    for count in range(2, len(values) // _FEWEST_ROWS):
        parts = np.split(values, np.sort(widest[:count]) + 1)
        spread = max(step, *(part[-1] - part[0] for part in parts))
        if steps[widest[count - 1]] <= _FARTHEST * spread:
            continue
        if min(map(len, parts)) >= _FEWEST_ROWS:
            return [float(part[len(part) // 2]) for part in parts]
    return []


def _is_few(levels: npt.NDArray[np.generic]) -> bool:
    return _FEWEST_ROWS * len(set(levels.tolist())) <= len(levels)


def _apart(
    readings: npt.NDArray[np.float64], levels: npt.NDArray[np.generic], division: float | None
) -> tuple[float, float] | None:
    """Return the middles of two neighbouring clusters that a column's levels make, or None.

    ``readings`` and ``levels`` of shape (n,). Clusters are the readings at each level that three
    rows or more have; they are far apart where an empty stretch between them is five times as wide
    as the spread at a usual level, or as ``division`` of the dial.
    """
    _, inverse, counts = np.unique(levels, return_inverse=True, return_counts=True)
    if len(counts) < 2 or not _is_few(levels) or np.ptp(readings) == 0:
        return None
    parts = [readings[inverse == k] for k in np.flatnonzero(counts >= _FEWEST_ROWS)]
    if len(parts) < 2:
        return None
    low, high = np.array(sorted((part.min(), part.max()) for part in parts)).T
    empty = low[1:] - np.maximum.accumulate(high)[:-1]
    widest = int(np.argmax(empty))
    steps = np.diff(np.sort(readings))
    # a dial may step by more than its last decimal: readings one step apart are no levels
    step = max(steps[steps > 0].min(), division or 0.0)
    spread = max(float(np.median(high - low)), step)
    if empty[widest] <= _FARTHEST * spread:
        return None
    below, above = readings[readings < low[widest + 1]], readings[readings >= low[widest + 1]]
    return float(np.median(below)), float(np.median(above))
