"""How often the charts of `history` speak, and how often its intervals hold: simulated robots.

    python benchmarks/history.py [--histories 300] [--write]

A test is the RP of 30 Gaussian cycles of one axis. Histories go through the program's own charts
and trend. Prints the tables of benchmarks/results/other.md.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np
from page import RESULTS, run

from scara_iso.comparison.chance import spread
from scara_iso.comparison.charts import between_tests, crossing, cusum, ewma, standardised, trend_of

HISTORIES = int(sys.argv[sys.argv.index("--histories") + 1]) if "--histories" in sys.argv else 300
CYCLES, MONTHS, ONSET = 30, 24, 9
LONG = 1500
MONTH = 365.25 / 12


def simulated(
    rng: np.random.Generator, levels: np.ndarray, between: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return ln RP and its sampling error for tests of robots with these sigmas."""
    sigma = levels * np.exp(between * rng.standard_normal(len(levels)))
    readings = sigma[:, np.newaxis, np.newaxis] * rng.standard_normal((len(levels), 1, CYCLES))
    value, error = spread(readings, angle=False)
    pooled = np.sqrt(np.mean(error**2))
    return np.log(value), np.full(len(levels), pooled)


def alarms(logs: np.ndarray, sampling: np.ndarray) -> tuple[list[int], list[int]]:
    """Return the tests at which EWMA and CUSUM speak."""
    whole = [slice(0, len(logs))]
    z = standardised(logs, between_tests(logs, sampling, whole), whole)
    return list(ewma(z, whole).alarms), list(cusum(z, whole).alarms)


def run_lengths() -> Iterator[str]:
    """Yield how long a chart is silent where nothing changes, and in two years."""
    rng = np.random.default_rng(1)
    lengths: dict[str, list[int]] = {"EWMA": [], "CUSUM": []}
    for _ in range(HISTORIES // 3):
        logs, sampling = simulated(rng, np.ones(LONG))
        for name, at in zip(lengths, alarms(logs, sampling), strict=True):
            lengths[name].append(at[0] if at else LONG)
    mean = f"tests until a false alarm, mean of {HISTORIES // 3}"
    yield f"| robots that do not change | {mean} | in 24 tests |"
    yield "|---|---|---|"
    short = [alarms(*simulated(rng, np.ones(MONTHS))) for _ in range(10 * HISTORIES)]
    for k, name in enumerate(lengths):
        share = np.mean([bool(found[k]) for found in short])
        least = "at least " if LONG in lengths[name] else ""
        yield f"| {name} | {least}{np.mean(lengths[name]):.0f} | {share:.1%} |"
    either = np.mean([bool(found[0] or found[1]) for found in short])
    yield f"| either | | {either:.1%} |"


def detection() -> Iterator[str]:
    """Yield how soon a change in month 9 of 24 is seen."""
    rng = np.random.default_rng(2)
    month = np.arange(1, MONTHS + 1)
    later = month >= ONSET
    kinds = {
        "RP 20 % larger from month 9 on": np.where(later, 1.2, 1.0),
        "RP 50 % larger from month 9 on": np.where(later, 1.5, 1.0),
        "RP doubled from month 9 on": np.where(later, 2.0, 1.0),
        "grows by 3 % a month from month 9 on": 1 + 0.03 * np.maximum(month - ONSET, 0),
        "grows by 7 % a month from month 9 on": 1 + 0.07 * np.maximum(month - ONSET, 0),
    }
    yield "| change | seen by month 24 | tests until then, median |"
    yield "|---|---|---|"
    for name, levels in kinds.items():
        delays = []
        for _ in range(HISTORIES):
            found = alarms(*simulated(rng, levels))
            at = [k for one in found for k in one if k >= ONSET - 1]
            delays.append(min(at) - (ONSET - 2) if at else np.inf)
        seen = np.isfinite(delays).mean()
        median = np.median(delays)
        said = f"{median:.0f}" if np.isfinite(median) else "more than 16"
        yield f"| {name} | {seen:.0%} | {said} |"


def forecasts() -> Iterator[str]:
    """Yield how often the interval of the crossing holds."""
    rng = np.random.default_rng(3)
    month = np.arange(1, MONTHS + 1)
    days = (month - 1) * MONTH
    kinds = {
        "grows by 3 % a month from month 9 on": (ONSET, 0.03, 0.0),
        "grows by 7 % a month from month 9 on": (ONSET, 0.07, 0.0),
        "grows by 7 % a month from month 18 on": (18, 0.07, 0.0),
        "grows by 3 % a month from the first on": (1, 0.03, 0.0),
        "7 % a month from month 9, tests differ by 10 %": (ONSET, 0.07, 0.1),
        "no wear": (1, 0.0, 0.0),
        "no wear, tests differ by 10 %": (1, 0.0, 0.1),
    }
    yield "| robot | trend shown | crossing in its interval | behind its lower end | months wide |"
    yield "|---|---|---|---|---|"
    for name, (onset, growth, between) in kinds.items():
        levels = 1 + growth * np.maximum(month - onset, 0)
        inside, later, shown, widths = [], [], [], []
        for _ in range(HISTORIES):
            logs, sampling = simulated(rng, levels, between)
            trend = trend_of(days, logs, sampling)
            if trend is None:
                raise SystemExit("24 tests are enough for a trend")
            shown.append(trend.shown)
            true_month = rng.uniform(26, 40)  # where the limit is met, were it to go on
            limit = 2.606 * (1 + growth * (true_month - onset) if growth else 1.5)
            truth = (true_month - 1) * MONTH if growth else np.inf
            found = crossing(trend, limit)
            low = np.inf if found.earliest is None else found.earliest
            low = low if low > days[-1] else -np.inf
            low = min(low, found.horizon)
            high = np.inf if found.latest is None else found.latest
            inside.append(low <= truth <= high)
            later.append(low <= truth)
            widths.append((high - max(low, days[-1])) / MONTH)
        width = np.median(widths)
        said = f"{width:.0f}" if np.isfinite(width) else "open"
        cells = (np.mean(shown), np.mean(inside), np.mean(later))
        yield f"| {name} | {' | '.join(f'{cell:.0%}' for cell in cells)} | {said} |"


if __name__ == "__main__":
    sys.argv = [word for word in sys.argv if word != "--histories" and not word.isdecimal()]
    parts = {"run lengths": run_lengths, "detection": detection, "forecasts": forecasts}
    run(parts, RESULTS / "other.md", __doc__)
