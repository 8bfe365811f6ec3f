"""What the columns of a table tell: conditions in their units, poses, and poses that none names.

The clock is ``time_s``, and effects of a temperature are per °C: a column of minutes or of °F would
else give a time constant, or a coefficient, that is silently another. Cycles are counted by pose,
and poses may stand under another name. Where no column names any, readings may still lie apart as
those of several poses do: they are refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, MutableMapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.quantities import Dimension, Number, Unit
from scara_iso.run.axis import Axis, Commanded, FloatArray, IntArray

if TYPE_CHECKING:
    import pandas as pd


class RecordedCondition(NamedTuple):
    """A recorded condition: its name in a run, which ends in its unit there, and its scale."""

    name: str
    numerator: float = 1.0
    denominator: float = 1.0
    zero: float = 0.0
    """What the column shows at zero s, °C or kg."""
    sure: bool = True
    """Whether the name says so whatever other columns there are."""

    @property
    def converts(self) -> bool:
        """Whether the column is in another unit than the run."""
        return (self.numerator, self.denominator, self.zero) != (1, 1, 0)

    def to_base(self, values: Number) -> Number:
        """Return numbers of the column, a value or an array of any shape, in the run's unit."""
        return (values - self.zero) * self.numerator / self.denominator


_TIME = {"s": (1, 1), "ms": (1, 1000), "min": (60, 1), "h": (3600, 1)}
_MASS = {"kg": (1, 1), "g": (1, 1000), "lb": (0.45359237, 1)}
_TEMPERATURE = {"c": (1, 1, 0), "f": (5, 9, 32), "k": (1, 1, 273.15)}
_SPELLED = {
    spelt: unit
    for unit, names in {
        "s": "sec,secs,second,seconds,sek,sekunde,sekunden",
        "ms": "millisecond,milliseconds,msec,millisekunden",
        "min": "mins,minute,minutes,minuten",
        "h": "hr,hrs,hour,hours,std,stunde,stunden",
        "c": "degc,deg c,grad c,celsius,deg celsius,grad celsius",
        "f": "degf,deg f,grad f,fahrenheit,deg fahrenheit",
        "k": "kelvin",
        "g": "gram,grams,gramm",
        "lb": "lbs,pounds",
    }.items()
    for spelt in names.split(",")
}
_CLOCK_NAMES = ("time", "t", "zeit")
_CLOCK_LIKE = ("elapsed", "elapsed time", "time elapsed", "time since start", "zeit seit start")
_LOAD_LIKE = ("load", "last", "nutzlast", "belastung", "zuladung", "carico", "carga")
_AIR = ("ambient temperature", "raumtemperatur", "lufttemperatur", "umgebungstemperatur")
_ROOM = ("t", "temp", *_AIR)
_WARM = re.compile(r"(?:temp|temperature?)(?: .+)?|.*temperature?", re.ASCII)


UNITS = frozenset([*_TIME, *_MASS, *_TEMPERATURE, "n", "kn", "nm", "mm", "um", "bar", "v", "a"])
"""Units of conditions, in the spelling that `unit_of_condition` returns."""
_PARTS = (
    re.compile(r"(.*?) ?[\[({<]([^\[\](){}<>]*)[\])}>]"),
    re.compile(r"(.+?) ?(?:/|,| in )(.+)"),
    re.compile(r"(.+)_(.+)"),
)


def unit_of_condition(text: str) -> str:
    """Return a unit in lower case, without its degree sign, and minutes as min."""
    unit = text.replace("°", "").strip(" -.").lower()
    return _SPELLED.get(unit, unit)


def unit_in_heading(heading: str) -> str:
    """Return the unit of a condition that a heading states, as it stands there; "" for none."""
    parted = (match for parts in _PARTS if (match := parts.fullmatch(heading)))
    return next((match[2] for match in parted if unit_of_condition(match[2]) in UNITS), "")


def find_condition(heading: str, unit_below: str = "") -> RecordedCondition | None:
    """Return the condition that a column records by its heading, or by that and a unit below it.

    ``Zeit [min]`` is ``time_s``, ``temperature_base_F`` is ``temperature_base_C``; None for another
    quantity or unit.
    """
    unit = unit_in_heading(heading)
    if unit:
        return _of_stem(heading.rpartition(unit)[0].rstrip(" _/,([{<").removesuffix(" in"), unit)
    stem, _, word = heading.rpartition(" ")
    return _of_stem(heading, unit_below) or _of_stem(stem, word)


def _of_stem(stem: str, unit: str) -> RecordedCondition | None:
    unit = unit_of_condition(unit)
    name = " ".join(stem.replace("_", " ").lower().rstrip(". :").split())
    if unit in _TIME and name in (*_CLOCK_NAMES, *_CLOCK_LIKE):
        return RecordedCondition("time_s", *_TIME[unit], sure=unit == "s" and name in _CLOCK_NAMES)
    if unit in _MASS and name in ("payload", *_LOAD_LIKE):
        return RecordedCondition(
            "payload_kg", *_MASS[unit], sure=unit == "kg" and name == "payload"
        )
    if unit in _TEMPERATURE and name in ("temperature", "temperatur", *_ROOM):
        sure = name not in _ROOM
        return RecordedCondition("temperature_C", *_TEMPERATURE[unit], sure=sure)
    if unit in ("f", "k") and _WARM.fullmatch(name):
        return RecordedCondition(f"{stem.strip()}_C", *_TEMPERATURE[unit])
    return None


def of_base_units(
    columns: Mapping[str, FloatArray],
) -> dict[str, FloatArray]:
    """Return columns by name, each of shape (rows,), those in another unit than a run's converted.

    Raises `DataError` where two would be the same column then.
    """
    found: dict[str, FloatArray] = {}
    for name, values in columns.items():
        condition = find_condition(name)
        if condition is None or not condition.converts:
            condition = RecordedCondition(name)
        elif condition.name in columns or condition.name in found:
            what = f"column {name!r} is {condition.name} too"
            raise DataError(what, where="data frame", remedy="keep one of them")
        found[condition.name] = condition.to_base(values)
    return found


_TRANSIENT = re.compile(r"stabilisation_\w+_s|overshoot_\w+_(mm|deg)")


def stabilisation_column(axis: str) -> str:
    """Return the name of the column that holds the stabilisation times of an axis [s]."""
    return f"stabilisation_{axis}_s"


def overshoot_column(axis: str, dimension: Dimension) -> str:
    """Return the name of the column that holds the overshoots of an axis [mm or deg]."""
    return f"overshoot_{axis}_{dimension.value}"


def is_transient(name: str) -> bool:
    """Return whether a column is a figure of the arrivals: no condition, and so no cause."""
    return _TRANSIENT.fullmatch(name) is not None


Labels = npt.NDArray[np.str_]
POSE_NAMES = frozenset(
    """pose,pose label,pose name,pose no,point,point no,point name,punkt,punkt nr,target,
    target point,ziel,zielpunkt,position,station,messpunkt,messposition,messstelle,
    measuring point,measurement point,test point,location""".replace("\n    ", "").split(",")
)
"""What people call the column of poses, in lower case."""
_TOGETHER = 999
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
    for k in range(0, len(labels), _TOGETHER):
        some = labels[k : k + _TOGETHER].tolist()
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


Columns = Mapping[str, npt.NDArray[np.generic]]
Poses = Iterable[tuple[str | None, IntArray]]

CONDITIONS = frozenset({"approach", "block", "payload_kg", "speed", "temperature_C", "time_s"})
"""Covariates that are known to be no poses; ``# covariates: name, name`` states others."""
_FEWEST_ROWS = 3  # a level of fewer rows is a slip that somebody remarked on
FEW_LEVELS = 4
_LONGEST = 500  # rows beyond which a table is a stream, which goes from pose to pose
_SAMPLE = 999  # rows that show whether a column has few values
_FARTHEST = 5  # times the spread of a level (some 20 sigma): no covariate of one pose does that


def declared_conditions(stated: Mapping[str, str]) -> set[str]:
    """Return the columns that a head declares to be conditions of the test, in small letters."""
    return {name.strip().lower() for name in stated.get("covariates", "").split(",")}


def check_clusters(
    axes: Mapping[str, Axis],
    poses: Poses,
    columns: Columns,
    metadata: Mapping[str, str],
    where: str,
) -> None:
    """Raise `DataError` at ``where`` for readings that a column parts as poses are parted.

    ``poses`` are the rows by label, ``columns`` have shape (rows,). Known conditions, and those
    that the metadata state as ``covariates``, are passed over. So are readings at several levels
    refused where no pose is named.
    """
    stated = declared_conditions(metadata)
    few = {name: values for name, values in columns.items() if _is_few(values[:_SAMPLE])}
    known = {name for name in few if name in CONDITIONS or name.lower() in stated}
    by_pose = list(poses)
    for name, values in few.items():
        for _, rows in () if name in known else by_pose:
            for axis, of_it in axes.items():
                found = _apart(of_it.readings[rows], values[rows], of_it.resolution)
                if found is not None:
                    raise DataError(
                        f"column {name!r} parts the readings of {axis} as poses would: "
                        f"about {found[0]:.6g} and about {found[1]:.6g} {of_it.unit}",
                        where=where,
                        remedy=f"name the column 'pose', or say '# covariates: {name}' above the "
                        "header if it is a condition of one pose; a velocity is a table of its own",
                    )
    if [label for label, _ in by_pose] == [None] and "pose" not in metadata:
        _check_levels(axes, [few[name] for name in known], where)


def parted_by(
    axes: Mapping[str, Axis], poses: Poses, columns: Columns, metadata: Mapping[str, str]
) -> Iterator[str]:
    """Say of each column, but for known and stated conditions, that half of a scatter is its own.

    Arguments as of `check_clusters`, a column of two to four levels. Of two equal ones it is so
    where the readings of one lie two standard deviations above those of the other. By chance it
    is said of one column in thousands.
    """
    known, by_pose = CONDITIONS | declared_conditions(metadata), list(poses)
    for name, values in columns.items():
        levels, inverse = np.unique(values, return_inverse=True)
        few = 1 < len(levels) <= FEW_LEVELS and _is_few(inverse)
        if {name, name.lower()} & known or not few:
            continue
        apart = [
            axis.name
            for axis in axes.values()
            if any(_is_parted(axis.readings[rows], inverse[rows]) for _, rows in by_pose)
        ]
        if apart:
            yield (
                f"column {name!r} parts the readings of {', '.join(apart)}, which are taken "
                f"together: is it a condition ('# covariates: {name}'), a side (approach), a pose?"
            )


def _is_parted(readings: FloatArray, levels: npt.NDArray[np.intp]) -> bool:
    counts = np.bincount(levels)
    if len(readings) < 2 * _FEWEST_ROWS or np.sum(counts >= _FEWEST_ROWS) < 2:
        return False
    means = np.bincount(levels, readings) / np.maximum(counts, 1)
    left = min(0.5, 1e-4 ** (2 / (len(readings) - len(counts))))
    return bool(np.var(readings - means[levels]) < left * np.var(readings))


def _check_levels(
    axes: Mapping[str, Axis], conditions: Sequence[npt.NDArray[np.generic]], where: str
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


def _levels(readings: FloatArray, division: float | None) -> list[float]:
    """Return the middles of three levels or more, far apart as `_apart` has it; else none."""
    values = np.sort(readings)
    steps = np.diff(values)
    if not 3 * _FEWEST_ROWS <= len(values) <= _LONGEST or not steps.any():
        return []
    widest = np.argsort(-steps, kind="stable")
    for count in range(2, len(values) // _FEWEST_ROWS):
        parts = np.split(values, np.sort(widest[:count]) + 1)
        spread = max(_step(steps, division), *(part[-1] - part[0] for part in parts))
        if steps[widest[count - 1]] <= _FARTHEST * spread:
            continue
        if min(map(len, parts)) >= _FEWEST_ROWS:
            return [float(part[len(part) // 2]) for part in parts]
    return []


def _step(steps: FloatArray, division: float | None) -> float:
    """Return the smallest of a dial: it may step by more than its last decimal.

    Readings one step apart are no levels.
    """
    return max(float(steps[steps > 0].min()), division or 0.0)


def _is_few(levels: npt.NDArray[np.generic]) -> bool:
    return _FEWEST_ROWS * len(set(levels.tolist())) <= len(levels)


def _apart(
    readings: FloatArray, levels: npt.NDArray[np.generic], division: float | None
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
    spread = max(float(np.median(high - low)), _step(np.diff(np.sort(readings)), division))
    if empty[widest] <= _FARTHEST * spread:
        return None
    above = readings >= low[widest + 1]
    return float(np.median(readings[~above])), float(np.median(readings[above]))
