"""What columns tell of poses: cycles by pose, one number for each, poses under another name."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, MutableMapping
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.quantities import Unit
from scara_iso.run.axis import Commanded, IntArray

if TYPE_CHECKING:
    import pandas as pd

Labels = npt.NDArray[np.str_]
POSE_NAMES = frozenset(
    """pose,pose label,pose name,pose no,point,point no,point name,punkt,punkt nr,target,
    target point,ziel,zielpunkt,position,station,messpunkt,messposition,messstelle,
    measuring point,measurement point,test point,location""".replace("\n    ", "").split(",")
)
"""What people call the column of poses, in lower case."""
_SAMPLE = 999
"""Labels that are looked at together."""
_NUMBERED = r"(?:p|pose|point|punkt)[ _.-]?[0-9]{1,3}"
_AXIS = r"(?:x|y|z|theta)"
_OF_A_POSE = re.compile(
    rf"(?:{_NUMBERED}[\W_]*{_AXIS}|{_AXIS}[\W_]*{_NUMBERED})(?: ?[\[(/,].*|[ _][^ _]+)?",
    re.IGNORECASE,
)
"""A column of one axis at one pose: ``P2 X``, ``X_P2 [mm]``."""


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
