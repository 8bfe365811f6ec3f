"""Figures of scatter and of position with their uncertainty: chance, dial, calibration.

The largest distance between barycentres: of directions, of blocks in time, of robots.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from scara_iso.base.quantities import Dimension, Estimate, rounding_uncertainty, within_half_a_turn
from scara_iso.iso9283.statistics import WIDEST, SamplingInterval
from scara_iso.run import Axis, FloatArray, Run, step_of

FEWEST_FOR_INTERVAL = 5
_LEVEL = 0.05


def scatter_estimate(
    interval: SamplingInterval,
    figure: FloatArray,
    positions: FloatArray,
    axes: Sequence[Axis],
    *,
    steps: Sequence[float] | None = None,
    clause: str = "7.2.2",
) -> Estimate:
    """Return a figure of scatter of ``positions``, shape (components, n), as an estimate.

    ``steps`` are those of the ``axes`` unless given. Reaches of chance and calibration are combined
    as independent (Zou and Donner 2008). What a certificate's uncertainty makes of a scatter the
    sources leave open; here it is that of the figure itself. The standard uncertainty of sampling
    is a quarter of its 95 % interval, which is not symmetric.
    """
    value, n, calibration = float(figure), positions.shape[-1], largest_calibration(axes)
    known = {} if calibration is None else {"calibration": calibration}
    found = Estimate(value, axes[0].unit, None, known, None, n, clause)
    if n < FEWEST_FOR_INTERVAL:
        return found
    steps = [step_of(axis) for axis in axes] if steps is None else steps
    low, high = (float(end[0]) for end in interval(positions[np.newaxis], steps))
    U, sampling = 2 * (calibration or 0.0), (high - low) / 4
    ends = (
        max(value - float(np.hypot(value - low, U)), 0.0),
        value + float(np.hypot(high - value, U)),
    )
    if ends[1] <= 0 or 0 < WIDEST * value <= high:
        return found
    u = math.hypot(sampling, calibration or 0.0)
    return replace(found, u=u, parts={"sampling": sampling, **known}, interval=ends)


def position_estimate(
    value: float, *, S: float, n: int, reading_u: float | None, unit: str, clause: str
) -> Estimate:
    """Return a mean of n readings as an estimate.

    ``S`` is the readings' standard deviation, ``reading_u`` what the indicator adds to all of them
    alike. The interval is Student's, as `even_estimate` has it.
    """
    found = even_estimate(
        value,
        unit,
        sampling=S / math.sqrt(n),
        reading_u=reading_u,
        freedom=n - 1,
        n=n,
        clause=clause,
    )
    return found if n >= FEWEST_FOR_INTERVAL else replace(found, u=None, interval=None)


def even_estimate(
    value: float,
    unit: str,
    *,
    sampling: float,
    reading_u: float | None,
    freedom: int,
    n: int,
    clause: str,
    least: float = -math.inf,
) -> Estimate:
    """Return a figure whose interval reaches as far to both sides, down to ``least``.

    The reach is Student's t of ``freedom`` times its standard error by ``sampling``, combined with
    2 ``reading_u``.
    """
    from scipy.special import stdtrit  # noqa: PLC0415 - heavy

    parts = {"sampling": sampling} | ({} if reading_u is None else {"reading": reading_u})
    reach = math.hypot(float(stdtrit(freedom, 1 - _LEVEL / 2)) * sampling, 2 * (reading_u or 0.0))
    ends = (max(value - reach, least), value + reach)
    return Estimate(value, unit, math.hypot(*parts.values()), parts, ends, n, clause)


def distance_estimate(value: float, components: Sequence[Estimate]) -> Estimate:
    """Return the length of a vector of means; it is no less certain than its worst component.

    A length is wrong by no more than the vector is, so the interval holds at least 95 %.
    """
    worst = max(components, key=lambda one: one.u or 0.0)
    ends = [one.interval for one in components if one.interval is not None]
    if len(ends) < len(components):
        return replace(worst, value=value, u=None, interval=None)
    reach = math.hypot(*((high - low) / 2 for low, high in ends))
    return replace(worst, value=value, interval=(max(value - reach, 0.0), value + reach))


def reading_uncertainty(axis: Axis) -> float | None:
    """Return the standard uncertainty of one reading, in the axis' unit; None if nothing is stated.

    Resolution / sqrt(12) and the indicator's own uncertainty, combined as independent (GUM 5.1.2).
    """
    parts = [] if axis.resolution is None else [rounding_uncertainty(axis.resolution)]
    parts += [] if axis.uncertainty is None else [axis.uncertainty]
    return math.hypot(*parts) if parts else None


def largest_calibration(axes: Sequence[Axis]) -> float | None:
    """Return the largest standard uncertainty that a certificate states; None if none does."""
    return max((axis.uncertainty for axis in axes if axis.uncertainty is not None), default=None)


def lengths(run: Run, names: str) -> list[Axis]:
    """Return the axes of ``XY`` or ``XYZ``; none unless all are there and are lengths."""
    axes = [run.axes[name] for name in names if name in run.axes]
    are_lengths = all(axis.dimension is Dimension.LENGTH for axis in axes)
    return axes if are_lengths and len(axes) == len(names) else []


def components(run: Run) -> Iterator[tuple[str, list[str]]]:
    """Yield the figures of a run by name with their axes: each axis, then XY and XYZ."""
    yield from ((name, [name]) for name in run.axes)
    yield from ((names, list(names)) for names in ("XY", "XYZ") if lengths(run, names))


def largest_distance(
    groups: Sequence[FloatArray],
    pairs: Sequence[tuple[int, int]],
    *,
    axes: Sequence[Axis],
    clause: str,
) -> Estimate:
    """Return the largest distance between the barycentres of any of ``pairs`` of ``groups``.

    Each group has shape (components, n), a row for each of ``axes``. The sources give no interval.
    Here its upper end is the largest of the pairs' own (Student's t along the line between both
    barycentres, Welch 1947), which holds whatever pair truly lies farthest apart; its lower end
    allows for the choice of the largest among the pairs (Bonferroni) and for scatter alone being a
    distance (the error vector's length by Box 1954). Both readings carry what the dial adds.
    """
    found = [_pair(groups[a], groups[b], axes[0], len(pairs)) for a, b in pairs]
    largest, error, _, _ = max(found, key=lambda one: one[0])
    # What the dial leaves uncertain of every mean; its own step stands for none stated.
    dials = (math.hypot(rounding_uncertainty(step_of(a)), a.uncertainty or 0.0) for a in axes)
    reading = math.sqrt(2) * max(dials)
    parts = {"sampling": error} | ({"reading": reading} if reading else {})
    n, unit = min(group.shape[1] for group in groups), axes[0].unit
    if n < FEWEST_FOR_INTERVAL:
        return Estimate(largest, unit, None, parts, None, n, clause)
    lower = max(distance - math.hypot(below, 2 * reading) for distance, _, below, _ in found)
    upper = max(distance + math.hypot(above, 2 * reading) for distance, _, _, above in found)
    ends = (max(lower, 0.0), upper)
    return Estimate(largest, unit, math.hypot(*parts.values()), parts, ends, n, clause)


def _pair(
    one: FloatArray, other: FloatArray, axis: Axis, pairs: int
) -> tuple[float, float, float, float]:
    """Return a distance, its standard error, and how far the truth may lie below and above it."""
    from scipy.special import fdtri, stdtrit  # noqa: PLC0415 - heavy

    apart = other.mean(axis=1) - one.mean(axis=1)
    if axis.dimension is Dimension.ANGLE:
        apart = np.array([within_half_a_turn(float(apart[0]))])
    spreads = [_of_mean(one), _of_mean(other)]
    both = spreads[0] + spreads[1]
    distance, trace = float(np.linalg.norm(apart)), float(np.trace(both))
    if trace == 0:
        return distance, 0.0, 0.0, 0.0
    along = apart / distance if distance > 0 else np.linalg.eigh(both)[1][:, -1]
    error = math.sqrt(float(along @ both @ along))
    sizes = [float(np.trace(spread)) for spread in spreads]
    counts = [one.shape[1] - 1, other.shape[1] - 1]
    freedom = trace**2 / sum(size**2 / n for size, n in zip(sizes, counts, strict=True))
    directions = trace**2 / float(np.trace(both @ both))
    below = math.sqrt(trace * float(fdtri(directions, freedom, 1 - _LEVEL / pairs)))
    return distance, error, below, error * float(stdtrit(freedom, 1 - _LEVEL / 2))


def _of_mean(positions: FloatArray) -> FloatArray:
    """Return the covariance of the barycentre, shape (components, components)."""
    return np.asarray(np.atleast_2d(np.cov(positions, ddof=1)) / positions.shape[1])
