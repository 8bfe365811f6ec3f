"""A joint pushed to and fro at its arm: compliance, play and friction of the loop of its readings.

The model: reading = c G + b sign G + where its loop stands. G is the force that Coulomb friction
lets through (`transmitted`), c the compliance of the spring behind the play 2 b, and each loop has
its own zero, so that a slow drift counts for nothing. Given the friction the rest is linear; the
friction is searched. The model is a choice of this program: no clause states one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.quantities import Dimension, rounding_uncertainty
from scara_iso.run import FloatArray, IntArray, Run
from scara_iso.tables import ColumnNames, Source, read_columns

FEWEST_LOOPS = 2
_FEWEST_READINGS = 12
_FAR = 0.8
"""Share of the largest force from which a turn is an end of the loop."""


@dataclass(frozen=True, eq=False, slots=True)
class ForceLoop:
    """Forces [N] and the readings at them [mm], shape (n,), in the order in which they were."""

    force: FloatArray
    """Force of each step [N], shape (steps,)."""
    reading: FloatArray
    """Reading at each step [mm], shape (steps,)."""
    resolution: float | None = None
    """The dial's division [mm]; None where not stated."""
    uncertainty: float | None = None
    """Standard uncertainty of the indicator."""
    source: str = ""
    """File that it was read from."""
    notes: tuple[str, ...] = ()
    """How it was read, one line each."""


def turns(force: FloatArray) -> IntArray:
    """Return where the force turns at an end of the loop: alternately high and low."""
    far = np.flatnonzero(np.abs(force) >= _FAR * _reach(force)).tolist()
    sides = groupby(far, key=lambda k: np.sign(force[k]))
    ends = [max(side, key=lambda k: abs(force[k])) for _, side in sides]
    return np.array(ends, dtype=np.int64)


def _reach(force: FloatArray) -> float:
    return float(min(force.max(), -force.min()))


def is_loop(force: FloatArray) -> bool:
    """Return whether forces go to both sides in two loops or more."""
    if len(force) < _FEWEST_READINGS or _reach(force) <= 0:
        return False
    return len(turns(force)) >= 2 * FEWEST_LOOPS


def loop_numbers(force: FloatArray, first: int, ends: IntArray) -> IntArray:
    """Return the loop of each reading from ``first`` on, shape (n - first,), counted from 0.

    A loop begins at every second end; one that is left unfinished belongs to the one before.
    """
    begins = ends[::2]
    number = np.searchsorted(begins, np.arange(first, len(force)), side="right") - 1
    whole = max((len(ends) - 1) // 2, 1)
    return np.minimum(number, whole - 1)


def transmitted(force: FloatArray, friction: FloatArray) -> FloatArray:
    """Return what Coulomb friction lets through of a force, shape (frictions, n).

    The play operator: it follows the force at a distance of ``friction``, shape (frictions,), and
    stands still after a turn until the force has come back by twice that. ``force`` begins at an
    end of the loop, so that the state there is known.
    """
    through = np.empty((len(friction), len(force)))
    state = force[0] - np.sign(force[0]) * friction
    for k, value in enumerate(force.tolist()):
        through[:, k] = state = np.clip(state, value - friction, value + friction)
    return through


def flank(through: FloatArray) -> FloatArray:
    """Return the flank that is in contact, shape of ``through``: its sign, or the one before."""
    sign = np.sign(through)
    for k in range(1, sign.shape[-1]):
        sign[..., k] = np.where(sign[..., k] == 0, sign[..., k - 1], sign[..., k])
    return sign


_REMEDY = "give the columns force_N and reading, with '# unit: mm' above them"
_COLUMNS = ColumnNames(
    what="a force loop",
    needed=("force_N", "reading"),
    remedy=_REMEDY,
    with_unit=("reading",),
)


def read_loop(
    source: Source,
    *,
    unit: str | None = None,
    resolution: float | None = None,
    decimal: str | None = None,
) -> ForceLoop:
    """Return the loop of a table with the columns force_N [N] and reading, and its unit stated.

    ``unit`` and ``resolution`` (in it) stand for the file's statements, ``decimal`` as in
    `read_columns`. Raises as that, and `DataError` where the unit is missing, no length, or
    stated in two ways.
    """
    if resolution is not None and not 0 < resolution < math.inf:
        raise UsageError(f"resolution {resolution!r}: not above zero", remedy="correct it")
    table = read_columns(source, _COLUMNS, unit=unit, decimal=decimal)
    found = table.scales.units.get("reading")
    if found is not None and found.dimension is not Dimension.LENGTH:
        said = f"a dial reads lengths, not {found.name}; state `arm=`"
        table.faults.add(said, table.header_line, remedy=_REMEDY)
    steps = table.scales.sizes("resolution", resolution)
    uncertainties = table.scales.sizes("indicator_uncertainty")
    table.faults.check()
    return ForceLoop(
        force=table.values["force_N"],
        reading=table.values["reading"],
        resolution=steps.get("reading"),
        uncertainty=uncertainties.get("reading"),
        source=table.source,
        notes=table.notes,
    )


def loop_of(run: Run, axis: str) -> ForceLoop:
    """Return the loop of an axis and the column force_N of a table of readings, every row of it.

    Raises `DataError` where there is no such length, no force, or more than one pose.
    """
    force, found = run.covariates.get("force_N"), run.axes.get(axis)
    poses = [*run.rows_by_pose()]
    if force is None or found is None or found.dimension is not Dimension.LENGTH:
        lengths = [n for n, one in run.axes.items() if one.dimension is Dimension.LENGTH]
        has = ["force_N"] * (force is not None) + lengths
        raise DataError(
            f"no force_N, or no length {axis}, is in it",
            where=run.origin.source,
            remedy=f"it has {', '.join(has) or 'neither'}",
        )
    if len(poses) > 1:
        raise DataError(
            f"{len(poses)} poses are in it, and a loop is of one",
            where=run.origin.source,
            remedy="leave the rows of one pose",
        )
    return ForceLoop(
        force=force,
        reading=found.readings,
        resolution=found.resolution,
        uncertainty=found.uncertainty,
        source=run.origin.source,
    )


_GRID = 60
_ROUNDS = 4
_NOTHING = 1e-6
_IMPROBABLE = 0.001


@dataclass(frozen=True, eq=False, slots=True)
class LoopFit:
    """What a loop is made of: compliance [mm/N], half the play [mm], friction [N]."""

    compliance: float
    """Slope of the branches [mm/N]."""
    half_play: float
    """Half of the play [mm]."""
    friction: float
    """Coulomb's friction, one side [N]."""
    covariance: FloatArray
    """Of these three in this order, shape (3, 3): chance, and a shape that the model misses."""
    freedom: int
    """Degrees of freedom of the residual."""
    residual: float
    """Standard deviation of the residual [mm]."""
    readings: int
    """Number of readings used."""
    loops: int
    """Number of loops."""
    run_in: int
    """Readings before the first end of the loop, which do not count."""
    deflection: float
    """Reading between the two ends of the loop, mean [mm]."""
    ends: tuple[float, float]
    """Lowest and highest force [N]."""
    misfit: float | None
    """Rms of what all loops repeat and the model does not [mm]; None where that is chance."""


def fit_loop(loop: ForceLoop) -> LoopFit:
    """Return the fit; `DataError` where the forces make no two loops, or the readings no spring."""
    if not is_loop(loop.force):
        raise DataError(
            f"the forces do not go to both sides in {FEWEST_LOOPS} loops or more",
            where=loop.source,
            remedy="step the force from one side to the other and back, three times",
        )
    ends = turns(loop.force)
    first = int(ends[0])
    force = loop.force[first:]
    towards = math.copysign(1.0, float((force - force.mean()) @ loop.reading[first:]))
    reading = towards * loop.reading[first:]  # a dial on the far side reads the push as negative
    number = loop_numbers(loop.force, first, ends)
    friction = _search(force, reading, number)
    design, jacobian = _design(force, number, friction)
    solution, *_ = np.linalg.lstsq(design, reading, rcond=None)
    c, b = float(solution[0]), float(solution[1])
    jacobian[:, 2] *= c
    left = reading - design @ solution
    freedom = len(force) - design.shape[1] - 1
    step = 0.0 if loop.resolution is None else rounding_uncertainty(loop.resolution)
    variance = max(float(left @ left) / freedom, step**2)
    misfit, repeats = _misfit(force, left, number, scale=float(np.ptp(reading)))
    inverse = np.linalg.pinv(jacobian.T @ jacobian)
    covariance = inverse[:3, :3] * variance * (repeats if misfit is not None else 1.0)
    _check_spring(c, covariance, loop)
    return LoopFit(
        compliance=c,
        half_play=b,
        friction=friction,
        covariance=covariance,
        freedom=freedom,
        residual=math.sqrt(variance),
        readings=len(force),
        loops=int(number.max()) + 1,
        run_in=first,
        deflection=_deflection(loop, ends),
        ends=(float(loop.force.min()), float(loop.force.max())),
        misfit=misfit,
    )


def _search(force: FloatArray, reading: FloatArray, number: IntArray) -> float:
    """Return the friction that leaves the smallest squares, on a grid that closes in."""
    low, high = 0.0, float(np.ptp(force)) / 4
    best = 0.0
    reading = _within_loops(reading[np.newaxis], number)[0]
    for _ in range(_ROUNDS):
        tried = np.linspace(low, high, _GRID)
        through = transmitted(force, tried)
        moved, signs = (_within_loops(one, number) for one in (through, flank(through)))
        squares = []
        for G, sign in zip(moved, signs, strict=True):
            design = np.column_stack([G, sign])
            left = reading - design @ np.linalg.lstsq(design, reading, rcond=None)[0]
            squares.append(float(left @ left))
        k = int(np.argmin(squares))
        best = float(tried[k])
        low, high = float(tried[max(k - 1, 0)]), float(tried[min(k + 1, _GRID - 1)])
    return best


def _within_loops(rows: FloatArray, number: IntArray) -> FloatArray:
    """Return rows (k, n) without the mean of each loop, which the loop's zero takes (Lovell)."""
    loops = np.bincount(number)
    means = np.stack([np.bincount(number, row) for row in rows]) / loops
    return np.asarray(rows - means[:, number])


def _zeros(number: IntArray) -> FloatArray:
    return np.eye(int(number.max()) + 1)[number]


def _design(force: FloatArray, number: IntArray, friction: float) -> tuple[FloatArray, FloatArray]:
    """Return the columns of the linear part, and those of all with dG/dF_f as the third."""
    step = max(friction, float(np.ptp(force))) * 1e-6
    low, middle, high = transmitted(
        force, np.array([max(friction - step, 0.0), friction, friction + step])
    )
    slope = (high - low) / (friction + step - max(friction - step, 0.0))
    sign, zeros = flank(middle[np.newaxis])[0], _zeros(number)
    return np.column_stack([middle, sign, zeros]), np.column_stack([middle, sign, slope, zeros])


def _misfit(
    force: FloatArray, left: FloatArray, number: IntArray, *, scale: float
) -> tuple[float | None, float]:
    """Return the rms of what loops repeat beyond chance, and how many readings share a step.

    The test of lack of fit (Draper and Smith, 2.1), over equal steps of the force in one direction.
    What is nothing beside ``scale``, the readings' range, is how finely the friction is searched.
    """
    from scipy.special import fdtrc  # noqa: PLC0415 - only for loops

    rising = np.sign(np.diff(force, prepend=force[0]))
    keys = np.column_stack([np.round(force, 9), rising])
    _, group, counts = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    groups, free = len(counts), len(force) - len(counts)
    lack = groups - 3 - int(number.max()) - 1
    if free < groups / 2 or lack < 1:
        return None, 1.0
    means = np.bincount(group, left) / counts
    within = float(((left - means[group]) ** 2).sum()) / free
    between = float((counts * means**2).sum()) / lack
    if within > 0 and float(fdtrc(lack, free, between / within)) > _IMPROBABLE:
        return None, 1.0
    rms = math.sqrt(float((counts * means**2).sum()) / len(force))
    return (rms, len(force) / groups) if rms > _NOTHING * scale else (None, 1.0)


def _check_spring(c: float, covariance: FloatArray, loop: ForceLoop) -> None:
    if not c > 4 * math.sqrt(covariance[0, 0]):
        raise DataError(
            "the readings do not follow the force: no spring can be told from their scatter",
            where=loop.source,
            remedy="push harder, or read a dial with a finer division",
        )


def _deflection(loop: ForceLoop, ends: IntArray) -> float:
    at = loop.reading[ends]
    high = loop.force[ends] > 0
    return abs(float(at[high].mean() - at[~high].mean()))
