"""How often `compare` shows a difference that is there, and one that is not, by simulation.

    python benchmarks/compare.py [--seed 9283] [--runs 1000] [--shuffles 499]

Each row draws pairs of runs of 30 cycles from one law of scatter. The means of the two always
differ, since an indicator has no absolute zero; "level" counts pairs with equal scatter (and, for
the means, equal means) of which any figure is said to differ. "power" counts pairs whose scatter
differs 1.8 times in X alone, X shown; "ratio" and "difference" are how often the intervals of X
hold the truth there. Beside it stand the plain alternatives, for one axis: the F test of variances,
Levene's test about the median (Brown and Forsythe), and the permutation of |x - median|.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import stats

from scara_iso import analyze
from scara_iso.comparison import Comparison, Contrast, ContrastVerdict, compare
from scara_iso.iso9283.core.statistics import repeatability
from scara_iso.run import AXES, Axis, FloatArray, Run

CYCLES = 30
RATIO = 1.8
SHOWN = (ContrastVerdict.LESS, ContrastVerdict.MORE)
Draw = Callable[[np.random.Generator, tuple[int, ...]], FloatArray]


@dataclass(frozen=True)
class Law:
    """A law of scatter of deviation 1; ``division`` is that of the dial, 0 for none."""

    name: str
    draw: Draw
    division: float = 0.0


def _gaussian(rng: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
    return rng.standard_normal(shape)


LAWS = (
    Law("Gaussian", _gaussian),
    *(Law(f"rounded, sigma {s} div.", _gaussian, 1 / s) for s in (1.0, 0.7, 0.5, 0.4, 0.3, 0.2)),
    Law("uniform", lambda rng, shape: rng.uniform(-(3**0.5), 3**0.5, shape)),
    Law("Student t, 5", lambda rng, shape: rng.standard_t(5, shape) * 0.6**0.5),
    Law("gamma, shape 2", lambda rng, shape: (rng.gamma(2, 1, shape) - 2) / 2**0.5),
    Law("exponential", lambda rng, shape: rng.exponential(1, shape) - 1),
)


def draw_run(law: Law, rng: np.random.Generator, axes: int, scale: float, place: FloatArray) -> Run:
    """Return a run whose X scatters ``scale`` times as widely, at ``place``, shape (axes,)."""
    scales = np.array([scale, *[1.0] * (axes - 1)])
    readings = law.draw(rng, (axes, CYCLES)) * scales[:, np.newaxis] + place[:, np.newaxis]
    step = law.division
    if step:
        readings = np.rint(readings / step) * step
    return Run(
        cycle=np.arange(2, CYCLES + 2),
        axes={
            name: Axis(name, values, resolution=step or 1e-6)
            for name, values in zip(AXES, readings, strict=False)
        },
    )


def compared(
    law: Law, rng: np.random.Generator, axes: int, scale: float, *, apart: bool, shuffles: int
) -> tuple[Comparison, Run, Run]:
    """Return the comparison of two runs, ``apart`` in their places by a few deviations."""
    first = rng.uniform(-5, 5, axes)
    second = rng.uniform(-5, 5, axes) if apart else first
    runs = draw_run(law, rng, axes, 1.0, first), draw_run(law, rng, axes, scale, second)
    return compare([analyze(run) for run in runs], shuffles=shuffles), *runs


def rivals(before: FloatArray, after: FloatArray, rng: np.random.Generator) -> list[bool]:
    """Return whether F, Brown-Forsythe and its permutation call two samples' scatter unlike."""
    x, y = before - np.median(before), after - np.median(after)
    F = before.var(ddof=1) / max(after.var(ddof=1), 1e-12)
    tail = stats.f.cdf(F, len(x) - 1, len(y) - 1)
    equal = len(set(before)) == len(set(after)) == 1
    levene = 1.0 if equal else float(stats.levene(before, after, center="median").pvalue)
    pool = np.abs(np.concatenate([x, y]))
    orders = rng.permuted(np.tile(np.arange(len(pool)), (499, 1)), axis=1)
    dealt = pool[orders]
    chance = np.abs(dealt[:, : len(x)].mean(axis=1) - dealt[:, len(x) :].mean(axis=1))
    observed = abs(np.abs(x).mean() - np.abs(y).mean())
    p_value = (1 + np.sum(chance >= observed - 1e-12)) / 500
    return [2 * min(tail, 1 - tail) <= 0.05, levene <= 0.05, bool(p_value <= 0.05)]


def _any_shown(contrasts: tuple[Contrast, ...]) -> bool:
    return any(contrast.verdict in SHOWN for contrast in contrasts)


def _holds(ends: tuple[float | None, float | None] | None, true: float) -> bool:
    assert ends is not None  # noqa: S101
    lower, upper = ends
    return (lower is None or lower <= true) and (upper is None or true <= upper)


def level_row(law: Law, rng: np.random.Generator, axes: int, runs: int, shuffles: int) -> str:
    """Return the level of spreads with means apart, of means, and of one axis' rivals."""
    spreads, means, others = [], [], []
    for _ in range(runs):
        found, before, after = compared(law, rng, axes, 1.0, apart=True, shuffles=shuffles)
        spreads.append(_any_shown(found.pairs[0].spreads))
        if axes == 1:
            others.append(rivals(before.axes["X"].readings, after.axes["X"].readings, rng))
        same, _, _ = compared(law, rng, axes, 1.0, apart=False, shuffles=shuffles)
        means.append(_any_shown(same.pairs[0].means))
    beside = "".join(f"{share:>8.1%}" for share in np.mean(others, axis=0)) if others else ""
    return f"{np.mean(spreads):>8.1%}{np.mean(means):>8.1%}{beside}"


def power_row(law: Law, rng: np.random.Generator, axes: int, runs: int, shuffles: int) -> str:
    """Return the power for X, and how often X's two intervals hold the truth."""
    RP = float(repeatability(law.draw(rng, (1, 1_000_000))).RP)
    shown, ratio, difference, others = [], [], [], []
    for _ in range(runs):
        found, before, after = compared(law, rng, axes, RATIO, apart=True, shuffles=shuffles)
        X = found.pairs[0].spreads[0]
        shown.append(X.verdict is ContrastVerdict.MORE)
        ratio.append(_holds(X.ratio_interval, RATIO))
        difference.append(_holds(X.difference_interval, (RATIO - 1) * RP))
        if axes == 1:
            others.append(rivals(before.axes["X"].readings, after.axes["X"].readings, rng))
    beside = "".join(f"{share:>8.1%}" for share in np.mean(others, axis=0)) if others else ""
    columns = "".join(f"{np.mean(c):>8.1%}" for c in (shown, ratio, difference))
    return f"{columns}{beside}"


def cycles_row(rng: np.random.Generator, runs: int, shuffles: int) -> str:
    """Return how often the cycles that are asked for at the true ratio's distance show it."""
    asked = []
    for _ in range(runs):
        found, _, _ = compared(LAWS[0], rng, 1, 1.35, apart=True, shuffles=shuffles)
        X = found.pairs[0].spreads[0]
        if X.smallest_shown is not None:
            asked.append(X.smallest_shown)
    ratio = float(np.median(asked))
    shown = [
        compared(LAWS[0], rng, 1, ratio, apart=True, shuffles=shuffles)[0].pairs[0].spreads[0]
        for _ in range(runs)
    ]
    share = np.mean([one.verdict is ContrastVerdict.MORE for one in shown])
    return f"smallest ratio shown by 30 cycles in 80 %: {ratio:.2f}; shown in {share:.1%}"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=9283)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--shuffles", type=int, default=499)
    wanted = parser.parse_args()
    rest = wanted.runs, wanted.shuffles
    for axes in (1, 4):
        print(f"\n{axes} axes: level     means | F, Brown-Forsythe, permuted")
        print("    power, ratio holds, difference holds | the same three")
        for k, law in enumerate(LAWS):
            rng = np.random.default_rng([wanted.seed, axes, k])
            level = level_row(law, rng, axes, *rest)
            print(f"{law.name:<24}{level}  ||{power_row(law, rng, axes, *rest)}", flush=True)
    print(cycles_row(np.random.default_rng(wanted.seed), *rest))


if __name__ == "__main__":
    main()
