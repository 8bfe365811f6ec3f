"""Repeatability of attained positions: the paper's eq. 2-6 and 23, ISO 9283 7.2.1 and 7.2.2.

One axis and a plane or space differ only in the number of components of a position, so one
function serves all: with one component the distance to the barycentre is eq. 3's |x_j - mean|.
Arrays end in the cycles of one pose; dimensions in front are poses and are kept.

Figures of scatter and of position, and the largest distance between barycentres (of directions, of
blocks in time, of robots), come with their uncertainty: chance, dial, calibration.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from statistics import NormalDist
from typing import NamedTuple, TypeAlias

import numpy as np

from scara_iso.base.quantities import Dimension, Estimate, rounding_uncertainty, within_half_a_turn
from scara_iso.run import Axis, FloatArray, Run, step_of

# Relative standard error of RP times sqrt(n) for Gaussian scatter, equal in 1, 2 or 3 directions:
# standard deviation of the influence function of E[l] + 3 sd[l] over its value, l half-normal,
# Rayleigh or Maxwell distributed.
GAUSSIAN_ERROR = {1: 0.74737, 2: 0.57371, 3: 0.49973}
# E[l] + 3 sd[l] for the same three and unit scatter.
GAUSSIAN_RP = {1: 2.60632, 2: 3.21872, 3: 3.61609}

_JACKKNIFE_GROUPS = 128
_AT_ONCE = 1 << 16
"""Readings, times groups left out, that are computed together: bounds the memory."""
_CONFIDENCE = 0.95
_Z = NormalDist().inv_cdf((1 + _CONFIDENCE) / 2)
_SHORTFALL = 3.0  # chosen by benchmarks/coverage.py: ends even for Gaussian and long-tailed scatter
_COARSE = 2.0  # divisions of scatter above which rounding moves RP by less than 3 %
_LARGEST = math.log(1e6)

WIDEST = 100.0
"""Upper limit over figure from which an interval says nothing: one reading carries the figure."""


def median(values: FloatArray, axis: int = 0) -> FloatArray:
    """Return the median of finite numbers along an axis.

    That of numpy takes ten times as long on thirty readings, and brings its masked arrays along.
    """
    ordered = np.moveaxis(np.sort(values, axis=axis), axis, 0)
    return np.asarray((ordered[(len(ordered) - 1) // 2] + ordered[len(ordered) // 2]) / 2)


Limits: TypeAlias = tuple[FloatArray, FloatArray]
"""Lower and upper limits of an interval; shapes as the poses in front."""
SamplingInterval: TypeAlias = Callable[[FloatArray, Sequence[float] | None], Limits]
"""`rp_interval`, `rss_interval` or `three_sigma_interval`."""


class Repeatability(NamedTuple):
    """RP and its intermediate values; each field has the shape of the poses in front.

    All in the unit of the readings; ``n`` is the number of cycles.
    """

    n: int
    mean: FloatArray
    """Barycentre, shape (..., components); eq. 2."""
    l_bar: FloatArray
    """Mean distance to the barycentre; eq. 4."""
    S_l: FloatArray
    """Standard deviation of that distance, with n - 1; eq. 5."""
    RP: FloatArray
    """l_bar + 3 S_l; eq. 6 for one axis, ISO 9283 7.2.2 for several."""


def repeatability(positions: FloatArray) -> Repeatability:
    """Return RP = l_bar + 3 S_l of positions of shape (..., components, n), n at least 2.

    Paper eq. 2-6 (one component) and ISO 9283 7.2.2 (several): l_j is the distance of attained
    position j to the barycentre, S_l has n - 1.
    """
    shifted = positions - positions[..., :1]  # keeps the digits of readings far from zero
    centre = shifted.mean(axis=-1, keepdims=True)
    if positions.shape[-2] == 1:
        distance = np.abs(shifted - centre)[..., 0, :]
    else:
        distance = np.sqrt(((shifted - centre) ** 2).sum(axis=-2))
    l_bar = distance.mean(axis=-1)
    S_l = distance.std(axis=-1, ddof=1)
    return Repeatability(
        n=positions.shape[-1],
        mean=(positions[..., :1] + centre)[..., 0],
        l_bar=l_bar,
        S_l=S_l,
        RP=l_bar + 3 * S_l,
    )


def standard_deviation(readings: FloatArray) -> FloatArray:
    """Return the sample standard deviation over the last axis, with n - 1; ISO 9283's S_a."""
    shifted = readings - readings[..., :1]
    return np.asarray(shifted.std(axis=-1, ddof=1))


def root_sum_of_squares(positions: FloatArray) -> FloatArray:
    """Return the paper's eq. 23 of positions of shape (..., components, n)."""
    return np.asarray(np.sqrt((repeatability(positions[..., np.newaxis, :]).RP ** 2).sum(axis=-1)))


def rp_interval(positions: FloatArray, resolutions: Sequence[float] | None) -> Limits:
    """Return lower and upper limits of a 95 % interval for RP; shapes as the poses in front.

    ``positions`` as in `repeatability`, n at least 5; ``resolutions`` one for each component, 0
    where the dial has no steps, None where none of them has. The sources give no interval; this
    one is that of the root of a chi-square of as many degrees of freedom as the jackknife's
    standard error allows, never more than Gaussian scatter has; the upper limit is raised by what
    RP of so few cycles falls short. A coarse dial moves both limits: `_beside_rounding`, `hidden`.
    Coverage is in docs/repeatability.md.
    """
    components = positions.shape[-2]
    known = (GAUSSIAN_RP[components], GAUSSIAN_ERROR[components])
    return _interval(_ScatterMeasure(_radial, *known), positions, resolutions)


def pooled_intervals(blocks: Sequence[FloatArray], *, confidence: float) -> Limits:
    """Return limits of RP of each block, shape (blocks,), as `rp_interval` for a perfect dial.

    Each block has shape (components, n). The relative error is that of all of them together: of
    ten readings by themselves the jackknife tells little.
    """
    z = NormalDist().inv_cdf((1 + confidence) / 2)
    RP = np.array([float(_radial(block)) for block in blocks])
    n = np.array([block.shape[-1] for block in blocks])
    of_one = np.array([float(_jackknife(_radial, block)[0]) for block in blocks])
    pooled = math.sqrt(float(np.mean(of_one**2 * (n - 1))))
    error = max(pooled, GAUSSIAN_ERROR[blocks[0].shape[0]]) / np.sqrt(n - 1)
    return RP * _lower(error, z), RP * np.exp(np.minimum(_upper(error, z), _LARGEST))


def rss_interval(positions: FloatArray, resolutions: Sequence[float] | None) -> Limits:
    """Return the 95 % interval of eq. 23, otherwise as `rp_interval`."""
    root = math.sqrt(positions.shape[-2])
    figure = _ScatterMeasure(root_sum_of_squares, root * GAUSSIAN_RP[1], GAUSSIAN_ERROR[1] / root)
    return _interval(figure, positions, resolutions)


def three_sigma_interval(positions: FloatArray, resolutions: Sequence[float] | None) -> Limits:
    """Return the 95 % interval of an angle's 3 S (7.2.2), otherwise as `rp_interval`.

    ``positions`` of one component; the chi-square has n - 1 degrees of freedom or fewer.
    """
    return _interval(_ScatterMeasure(_three_sigma, 3.0, math.sqrt(0.5)), positions, resolutions)


class _ScatterMeasure(NamedTuple):
    """A measure of scatter of positions; its value and error as `GAUSSIAN_RP` and `_ERROR`."""

    of: Callable[[FloatArray], FloatArray]
    gaussian: float
    gaussian_error: float


def _radial(positions: FloatArray) -> FloatArray:
    return repeatability(positions).RP


def _three_sigma(positions: FloatArray) -> FloatArray:
    return 3 * standard_deviation(positions[..., 0, :])


def _interval(
    figure: _ScatterMeasure, positions: FloatArray, resolutions: Sequence[float] | None
) -> Limits:
    components, n = positions.shape[-2:]
    steps = np.zeros(components) if resolutions is None else np.asarray(resolutions, np.float64)
    value = figure.of(positions)
    error, shortfall = _jackknife(figure.of, positions)
    least = figure.gaussian_error / math.sqrt(n - 1)
    width = two_divisions(positions, steps)
    error = np.where(width > 0, least, np.maximum(error, least))  # two levels tell no law
    raised = _upper(error) + np.where(width > 0, 0.0, _SHORTFALL * np.maximum(shortfall, 0))
    upper = value * np.exp(np.minimum(raised, _LARGEST))
    lower = _beside_rounding(figure, positions, value, steps) * _lower(error)
    return np.where(width > 0, 0.0, lower), np.maximum(upper, hidden(width, figure.gaussian, n))


def _jackknife(
    figure: Callable[[FloatArray], FloatArray], positions: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return standard error and shortfall (bias, sign turned) of the figure's logarithm."""
    groups = min(positions.shape[-1], _JACKKNIFE_GROUPS)
    found = np.concatenate([figure(part) for part in _without_each(groups, positions)])
    # in the order of memory, so that a pose's sums do not depend on the poses beside it
    without = np.ascontiguousarray(np.moveaxis(found, 0, -1))
    tiny = np.finfo(np.float64).tiny
    logs = np.log(np.maximum(without, tiny))  # a single reading may hold all of the figure
    mean = logs.mean(axis=-1)
    error = np.sqrt((groups - 1) / groups * ((logs - mean[..., np.newaxis]) ** 2).sum(axis=-1))
    whole = np.log(np.maximum(figure(positions), tiny))
    return np.asarray(error), np.asarray((groups - 1) * (whole - mean))


def _without_each(groups: int, positions: FloatArray) -> Iterator[FloatArray]:
    """Yield the positions without each group, some groups of one size at once along axis 0."""
    n = positions.shape[-1]
    group, at_once = np.arange(n) % groups, max(1, _AT_ONCE // positions.size)
    for same in (range(n % groups), range(n % groups, groups)):
        for begin in range(same.start, same.stop, at_once):
            batch = range(begin, min(begin + at_once, same.stop))
            kept = np.array([np.flatnonzero(group != one) for one in batch])
            yield np.ascontiguousarray(np.moveaxis(positions[..., kept], -2, 0))


def _lower(error: FloatArray, z: float = _Z) -> FloatArray:
    """Return sqrt(r / chi-square) at z, r = 1 / (2 error^2): Wilson and Hilferty (1931)."""
    error = np.minimum(error, 1.0)  # beyond one the formula turns back
    return np.asarray((1 - 4 / 9 * error**2 + 2 / 3 * z * error) ** -1.5)


def _upper(error: FloatArray, z: float = _Z) -> FloatArray:
    """Return ln sqrt(r / chi-square) at -z, as `_lower` but to second order of the error.

    The formula itself has no end from an error of 0.6.
    """
    return np.asarray(z * error + (z**2 + 2) / 3 * error**2)


def _beside_rounding(
    figure: _ScatterMeasure, positions: FloatArray, value: FloatArray, steps: FloatArray
) -> FloatArray:
    """Return the figure without what rounding may have added: Sheppard's (1898) correction."""
    variance = (standard_deviation(positions) ** 2).sum(axis=-1)
    rounding = float((rounding_uncertainty(1.0) ** 2 * steps**2).sum())
    share = 1 - rounding / np.maximum(variance, max(rounding, np.finfo(np.float64).tiny))
    # Gaussian scatter on three divisions looks long-tailed: its figure is read too large.
    gaussian = figure.gaussian * np.sqrt(variance / positions.shape[-2])
    coarse = variance < (_COARSE**2) * (steps**2).sum()
    return np.asarray(np.where(coarse, np.minimum(value, gaussian), value) * np.sqrt(share))


def two_divisions(positions: FloatArray, resolutions: Sequence[float] | FloatArray) -> FloatArray:
    """Return the width of the one or two divisions that hold all readings, 0 if there are more.

    A robot without scatter can read so: it stands still on the border of two divisions.
    """
    widths = np.ptp(positions, axis=-1) + np.asarray(resolutions)
    held = np.all(widths < 2.5 * np.asarray(resolutions), axis=-1)
    return np.where(held, widths.max(axis=-1), 0.0)


def hidden(width: FloatArray, gaussian: float, n: int) -> FloatArray:
    """Return the figure of the scatter that stays inside ``width`` n times one time in twenty.

    ``gaussian`` is the figure of unit Gaussian scatter, as in `GAUSSIAN_RP`.
    """
    all_inside = (1 - _CONFIDENCE) ** (1 / n)
    return gaussian * width / (2 * NormalDist().inv_cdf((1 + all_inside) / 2))


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
    value: float, *, S: float, n: int, reading_u: float, unit: str, clause: str
) -> Estimate:
    """Return a mean of n readings as an estimate.

    ``S`` is the readings' standard deviation, ``reading_u`` what the indicator adds to all of them
    alike. The interval is Student's, as `even_estimate` has it; readings that are all alike, on a
    dial whose step is not known, have none.
    """
    found = even_estimate(
        value,
        unit,
        sampling=S / math.sqrt(n),
        reading_u=reading_u or None,
        freedom=n - 1,
        n=n,
        clause=clause,
    )
    is_known = n >= FEWEST_FOR_INTERVAL and (S > 0 or reading_u > 0)
    return found if is_known else replace(found, u=None, interval=None)


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


def dial_uncertainty(axis: Axis) -> float:
    """Return what the dial leaves uncertain of every reading, and of a mean.

    As `reading_uncertainty`, but the step on which the readings lie stands for none stated.
    """
    return math.hypot(rounding_uncertainty(step_of(axis)), axis.uncertainty or 0.0)


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
    reading = math.sqrt(2) * max(map(dial_uncertainty, axes))
    parts = {"sampling": error} | ({"reading": reading} if reading else {})
    n, unit = min(group.shape[1] for group in groups), axes[0].unit
    if n < FEWEST_FOR_INTERVAL or not any(parts.values()):
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
