"""Readings that lie apart as those of several poses do."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError
from scara_iso.run.axis import Axis, FloatArray, IntArray

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
