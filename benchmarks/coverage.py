"""How often the 95 % interval of RP holds the true RP, by simulation.

    python benchmarks/coverage.py [--seed 9283] [--runs 4000] [--resampled-runs 400]
        [--short-tailed]

Each cell draws many tests of n cycles from a known scatter and counts how often the interval lies
wholly above the true figure (too high), wholly below it (too low), or holds it; a test without an
interval (none) holds nothing. The true figure is that of the scatter itself, before the dial rounds
it. Beside `rp_interval` stand what else was tried: the pivot of Gaussian scatter, the bootstrap's
percentile and BCa intervals (scipy), and other uses of the jackknife (``tried``).
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy import stats

from scara_iso.iso9283.core import statistics as module
from scara_iso.iso9283.core.statistics import (
    GAUSSIAN_ERROR,
    WIDEST,
    SamplingInterval,
    repeatability,
    rp_interval,
    standard_deviation,
    three_sigma_interval,
)
from scara_iso.run import FloatArray, common_step

Limits = tuple[FloatArray, FloatArray]
Draw = Callable[[np.random.Generator, tuple[int, ...]], FloatArray]

POPULATION = 4_000_000  # readings that stand for all: the true RP to 0.1 %
PIVOT_RUNS = 100_000
RESAMPLES = 999
CHUNK = 100
CYCLES = (30, 10, 100)
ROUNDED_SIGMAS = (0.1, 0.2, 0.3, 0.5, 0.7, 1.0)  # of one division


@dataclass(frozen=True)
class Scatter:
    """A law of scatter; ``division`` is that of the dial, 0 for a dial without rounding.

    ``place`` is where the pose lies between two divisions, in divisions; chance where None.
    ``stated`` tells whether the test states the division.
    """

    name: str
    draw: Draw
    division: float = 0.0
    place: float | None = None
    stated: bool = True


def _gaussian(rng: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
    return rng.standard_normal(shape)


SCATTERS: tuple[Scatter, ...] = (
    Scatter("Gaussian", _gaussian),
    *(Scatter(f"rounded, sigma {s} div.", _gaussian, 1 / s) for s in ROUNDED_SIGMAS),
    Scatter("  0.1 div., on a border", _gaussian, 1 / 0.1, 0.5),
    Scatter("  0.4 div., on a division", _gaussian, 1 / 0.4, 0.0),  # hardest for the lower limit
    Scatter("  0.4 div., on a border", _gaussian, 1 / 0.4, 0.5),  # hardest for the upper limit
    Scatter("rounded 0.3, not stated", _gaussian, 1 / 0.3, stated=False),
    Scatter("rounded 1.0, not stated", _gaussian, 1.0, stated=False),
    Scatter("uniform", lambda rng, shape: rng.uniform(-1, 1, shape)),
    Scatter("Student t, 5", lambda rng, shape: rng.standard_t(5, shape)),
    Scatter("gamma, shape 2", lambda rng, shape: rng.gamma(2, 1, shape)),
    Scatter("exponential", lambda rng, shape: rng.exponential(1, shape)),
    Scatter("lognormal, s 0.5", lambda rng, shape: rng.lognormal(0, 0.5, shape)),
    Scatter("lognormal, s 1", lambda rng, shape: rng.lognormal(0, 1, shape)),
)


def _levels(apart: float, upper: float) -> Draw:
    """Return two levels, ``apart`` in standard deviations of the scatter about either."""

    def draw(rng: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
        return apart * (rng.random(shape) < upper) + rng.standard_normal(shape)

    return draw


SHORT_TAILED = (
    *(
        Scatter(f"levels {apart} apart, {share}", _levels(apart, upper))
        for apart in (4, 10, 20, 40)
        for upper, share in ((0.5, "50:50"), (0.8, "20:80"))
    ),
    Scatter("uniform, +/- 0.9 division", lambda rng, shape: rng.uniform(-0.9, 0.9, shape), 1.0),
    Scatter("uniform, +/- 1.5 division", lambda rng, shape: rng.uniform(-1.5, 1.5, shape), 1.0),
)
SCATTERS = (*SCATTERS, *SHORT_TAILED)


def true_rp(scatter: Scatter, components: int, seed: int) -> float:
    """Return RP of the unrounded scatter in ``components`` independent directions."""
    everything = scatter.draw(np.random.default_rng(seed), (components, POPULATION))
    return float(repeatability(everything).RP)


def true_three_sigma(scatter: Scatter, seed: int) -> float:
    """Return 3 S of the unrounded scatter."""
    everything = scatter.draw(np.random.default_rng(seed), (POPULATION,))
    return 3 * float(standard_deviation(everything))


def draw_tests(
    scatter: Scatter, rng: np.random.Generator, shape: tuple[int, int, int]
) -> FloatArray:
    """Return readings of shape (runs, components, n) as the dial shows them."""
    readings = scatter.draw(rng, shape)
    if not scatter.division:
        return readings
    place = rng.uniform(0, 1, (*shape[:2], 1)) if scatter.place is None else scatter.place
    return np.rint(readings / scatter.division + place) * scatter.division


def ours(tests: FloatArray, scatter: Scatter) -> Limits:
    """Return `rp_interval` as `analyze` prints it."""
    return printed(rp_interval, repeatability(tests).RP, tests, scatter)


def angle(tests: FloatArray, scatter: Scatter) -> Limits:
    """Return `three_sigma_interval` as `analyze` prints it."""
    figures = 3 * standard_deviation(tests[:, 0])
    return printed(three_sigma_interval, figures, tests, scatter)


def printed(
    interval: SamplingInterval, figures: FloatArray, tests: FloatArray, scatter: Scatter
) -> Limits:
    """Return an interval of each test, nan where `analyze` prints none."""
    steps = np.full(tests.shape[:2], scatter.division)
    if not scatter.stated:
        steps = np.array([[common_step(axis) for axis in test] for test in tests])
    lower, upper = np.empty((2, len(tests)))
    for known in np.unique(steps.round(9), axis=0):
        alike = np.all(steps.round(9) == known, axis=1)
        lower[alike], upper[alike] = interval(tests[alike], resolutions=known)
    none = (upper == 0) | ((figures > 0) & (upper >= WIDEST * figures))
    return np.where(none, np.nan, lower), np.where(none, np.nan, upper)


def tried(tests: FloatArray) -> Iterator[tuple[str, Limits]]:
    """Yield other intervals from the same jackknife, for a dial without rounding."""
    components, n = tests.shape[1:]
    RP = repeatability(tests).RP
    error, short = module._jackknife(lambda positions: repeatability(positions).RP, tests)
    least = GAUSSIAN_ERROR[components] / np.sqrt(n - 1)
    both, t = np.maximum(error, least), stats.t.ppf(0.975, n - 1)
    yield "log t", (RP * np.exp(-t * both), RP * np.exp(t * both))
    stretched = error * _accelerated(t, _skewness(tests))
    yield "accelerated", (RP * np.exp(-t * both), RP * np.exp(np.maximum(t * both, stretched)))
    lower, upper = RP * module._lower(both), module._upper(both)
    for share in (0.0, 2.0, 4.0):
        yield f"shortfall {share:g}", (lower, RP * np.exp(upper + share * np.maximum(short, 0)))
    beyond = np.maximum(short - 0.7 / n, 0)  # of Gaussian scatter it is 0.7 / n
    yield "beyond 5", (lower, RP * np.exp(upper + 5 * beyond))
    mixed = np.sqrt(0.75 * error**2 + 0.25 * least**2)
    yield "shrunk", (RP * module._lower(mixed), RP * np.exp(module._upper(mixed)))


def pivot(tests: FloatArray) -> Limits:
    """Return the interval that is exact for Gaussian scatter and a dial without rounding."""
    low, high = _pivot_quantiles(*tests.shape[1:])
    RP = repeatability(tests).RP
    return RP / high, RP / low


def _skewness(tests: FloatArray) -> FloatArray:
    """Return Efron's a of ln RP: the skewness of the jackknife's values."""
    n = tests.shape[-1]
    without = [repeatability(np.delete(tests, j, axis=-1)).RP for j in range(n)]
    logs = np.log(np.stack(without, axis=-1))
    deviation = logs.mean(axis=-1, keepdims=True) - logs
    return np.asarray((deviation**3).sum(axis=-1) / (6 * (deviation**2).sum(axis=-1) ** 1.5))


def _accelerated(t: float, skewness: FloatArray) -> FloatArray:
    """Return Efron's (1987) accelerated quantile, with at most a hundredfold stretch."""
    shifted = skewness + t
    return np.asarray(shifted / np.maximum(1 - skewness * shifted, 0.1) ** 2)


@cache
def _pivot_quantiles(components: int, n: int) -> tuple[float, float]:
    rng = np.random.default_rng(components * 1000 + n)
    found = [
        repeatability(rng.standard_normal((PIVOT_RUNS // 10, components, n))).RP for _ in range(10)
    ]
    low, high = np.quantile(np.concatenate(found), (0.025, 0.975))
    true = true_rp(SCATTERS[0], components, 0)
    return float(low / true), float(high / true)


def bootstrap(tests: FloatArray, rng: np.random.Generator) -> Iterator[tuple[str, Limits]]:
    """Yield the percentile and the BCa interval, from the same resamples."""
    if not len(tests):
        return
    chunks = np.split(tests, range(CHUNK, len(tests), CHUNK))
    seeds = rng.integers(2**32, size=len(chunks))
    for method in ("percentile", "BCa"):
        found = [
            _resample(chunk, method, np.random.default_rng(seed))
            for chunk, seed in zip(chunks, seeds, strict=True)
        ]
        lower, upper = zip(*found, strict=True)
        yield method, (np.concatenate(lower), np.concatenate(upper))


def _resample(tests: FloatArray, method: str, rng: np.random.Generator) -> Limits:
    def statistic(*components: FloatArray, axis: int) -> FloatArray:
        assert axis == -1  # noqa: S101 - of repeatability's own
        return repeatability(np.stack(components, axis=-2)).RP

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # equal readings have no BCa: nan, which counts as a miss
        found = stats.bootstrap(
            tuple(np.moveaxis(tests, 1, 0)),
            statistic,
            paired=True,
            vectorized=True,
            axis=-1,
            n_resamples=RESAMPLES,
            method=method,
            rng=rng,
        ).confidence_interval
    return found.low, found.high


def show(name: str, method: str, limits: Limits, true: float) -> None:
    """Print one line: both kinds of misses, coverage, and median width over the true RP."""
    lower, upper = limits
    high, low, none = np.mean(lower > true), np.mean(upper < true), np.mean(np.isnan(upper))
    held = np.mean((lower <= true) & (true <= upper))
    width = np.median((upper - lower)[np.isfinite(upper - lower)]) / true
    print(
        f"{name:<27}{method:<12}{high:>10.1%}{low:>9.1%}{held:>8.1%}{none:>8.1%}{width:>8.2f}",
        flush=True,
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=9283)
    parser.add_argument("--runs", type=int, default=4000)
    parser.add_argument("--resampled-runs", type=int, default=400)
    parser.add_argument("--short-tailed", action="store_true", help="levels and flat scatter alone")
    wanted = parser.parse_args()
    chosen = SHORT_TAILED if wanted.short_tailed else SCATTERS
    for n in CYCLES:
        for components in (1, 2):
            print(f"\nn = {n}, {'one axis' if components == 1 else 'radial in a plane'}")
            head = ("too high", "too low", "holds", "none", "width")
            print("{:<27}{:<12}{:>10}{:>9}{:>8}{:>8}{:>8}".format("scatter", "interval", *head))
            for k, scatter in enumerate(chosen, len(SCATTERS) - len(chosen)):
                rng = np.random.default_rng([wanted.seed, n, components, k])
                true = true_rp(scatter, components, wanted.seed)
                tests = draw_tests(scatter, rng, (wanted.runs, components, n))
                show(scatter.name, "ours", ours(tests, scatter), true)
                if components == 1:
                    show("", "3 S", angle(tests, scatter), true_three_sigma(scatter, wanted.seed))
                show("", "pivot", pivot(tests), true)
                if not scatter.division:
                    for method, limits in tried(tests):
                        show("", method, limits, true)
                for method, limits in bootstrap(tests[: wanted.resampled_runs], rng):
                    show("", method, limits, true)


if __name__ == "__main__":
    main()
