"""The watch over a recording: false alarms where nothing acts, and how soon it sees what does.

``python -m benchmarks.watch`` prints the tables of docs/watch-tables.md, ``--write`` puts them
there. OPENBLAS_NUM_THREADS=1 in the environment saves most of its time.

One axis: 2,000 runs a cell; the p-value of a look is that of the same statistic among 20,000 orders
drawn once, since ranks without ties have one null whatever the readings. Several axes: 1,000 runs,
and the p-value among as many other runs in which nothing acts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache

import numpy as np
from scipy.stats import norm, t as student

from benchmarks import page
from scara_iso.diagnosis import Monitor, Suspicion
from scara_iso.diagnosis.e_process import EProcess
from scara_iso.diagnosis.evidence import joint_evidence, log_bayes, views_of
from scara_iso.diagnosis.looks import ALARM, _hypotheses, evidence_of, is_look, normal_scores
from scara_iso.run import FloatArray

RUNS, ORDERS, AXIS_RUNS, NAMED = 2000, 20_000, 1000, 25
PLANNED = 30
SIGMA = 0.7
"""Scatter in divisions of the dial, where readings are rounded."""
PAGE = page.DOCS / "watch-tables.md"
K = np.arange(PLANNED)

SCATTER: dict[str, Callable[[np.random.Generator, tuple[int, int]], FloatArray]] = {
    "normal": lambda rng, size: rng.normal(size=size),
    "t3": lambda rng, size: rng.standard_t(3, size=size),
    "skewed (exponential)": lambda rng, size: rng.exponential(size=size),
    "flat": lambda rng, size: rng.random(size),
    "rounded, 0.7 division": lambda rng, size: rounded(rng.normal(size=size), rng),
}
COURSES = {
    "step 2 after 15": 2.0 * (K >= 15),
    "step 3 after 12": 3.0 * (K >= 12),
    "step 3 after 16": 3.0 * (K >= 16),
    "step 3 after 22": 3.0 * (K >= 22),
    "drift 0.1 a cycle": 0.1 * K,
    "drift 0.2 a cycle": 0.2 * K,
    "warm-up 4, tau 5": -4.0 * np.expm1(-K / 5),
    "warm-up 4, tau 10": -4.0 * np.expm1(-K / 10),
    "alternating 2": 2.0 * (K % 2),
    "alternating 2 from 15 on": 2.0 * (K % 2) * (K >= 15),
}
KINDS = {
    "step": "step", "drift": "linear_drift", "warm-up": "warm_up", "alternating": "contact_side",
}  # fmt: skip
SURE = 0.9
BEGINS = {name: next((int(k) for k in K if course[k]), 0) for name, course in COURSES.items()}


def rounded(values: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return values on a dial, each run's mean anywhere between two divisions."""
    return np.round(SIGMA * values + rng.random((len(values), 1)))


def statistic(scores: FloatArray) -> FloatArray:
    """Return the log of the mean Bayes factor of each run of scores (n, runs)."""
    hypotheses = _hypotheses(len(scores))
    centred = scores - scores.mean(axis=0)
    centred /= np.linalg.norm(centred, axis=0)
    blocks = [centred[:, k : k + 500] for k in range(0, centred.shape[1], 500)]
    found = [hypotheses.test_weights @ np.exp(log_bayes(hypotheses, block)) for block in blocks]
    return np.log(np.concatenate(found))


@cache
def null_of(n: int) -> FloatArray:
    """Return the sorted statistics of orders of n scores."""
    rng = np.random.default_rng(n)
    orders = rng.permuted(np.tile(np.arange(float(n)), (ORDERS, 1)), axis=1).T
    return np.sort(statistic(normal_scores(orders, np.zeros(orders.shape))))


def p_values(values: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the p-value of the order of each run, values (runs, n)."""
    null = null_of(values.shape[1])
    found = statistic(normal_scores(values.T, noise.T))
    return np.asarray((len(null) - np.searchsorted(null, found - 1e-9) + 1) / (len(null) + 1))


def looks(values: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return the evidence after each reading, shape (runs, n): 1 where there is no look."""
    noise, n = rng.random(values.shape), values.shape[1]
    evidence = np.ones(values.shape)
    for taken in filter(lambda k: is_look(k, n), range(1, n + 1)):
        p = p_values(values[:, :taken], noise[:, :taken])
        evidence[:, taken - 1] = [evidence_of(float(one), taken / n) for one in p]
    return evidence


def e_process(values: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return the evidence of the e-process after each reading, shape (runs, n)."""
    noise, process, found = rng.random(values.shape), EProcess(len(values)), []
    for k in range(values.shape[1]):
        before, last = values[:, :k], values[:, k : k + 1]
        tied = (before == last) & (noise[:, :k] < noise[:, k : k + 1])
        rank = (before < last).sum(axis=1) + tied.sum(axis=1)
        found.append(process.take((rank + rng.random(len(values))) / (k + 1)))
    return np.stack(found, axis=1)


def cusum(values: FloatArray) -> FloatArray:
    """Return Hawkins' self-starting CUSUM, k = 0.5, either direction, after each reading."""
    runs, n = values.shape
    up, down, found = np.zeros(runs), np.zeros(runs), np.zeros(values.shape)
    for k in range(2, n):
        mean, sd = values[:, :k].mean(axis=1), np.maximum(values[:, :k].std(axis=1, ddof=1), 1e-9)
        T = (values[:, k] - mean) / sd * (k / (k + 1)) ** 0.5
        z = np.clip(norm.ppf(student.cdf(T, k - 1)), -8, 8)
        up, down = np.maximum(0, up + z - 0.5), np.maximum(0, down - z - 0.5)
        found[:, k] = np.maximum(up, down)
    return found


@cache
def cusum_limit(scatter: str) -> float:
    """Return the limit that 5 % of runs of the planned length reach in such scatter."""
    values = SCATTER[scatter](np.random.default_rng(0), (ORDERS, PLANNED))
    return float(np.quantile(cusum(values).max(axis=1), 0.95))


def level() -> Iterator[str]:
    """Yield a row for each scatter: how many runs in which nothing acts have an alarm."""
    yield "| scatter | looks, 30 | looks, 60 | e-process, 30 | e-process, 100 | CUSUM | fixed, 30 |"
    yield "|---|---|---|---|---|---|---|"
    for k, (name, draw) in enumerate(SCATTER.items()):
        rng = np.random.default_rng(k)
        values = draw(rng, (RUNS, 100))
        found = [
            looks(values[:, :30], rng).max(axis=1) >= ALARM,
            looks(values[:, :60], rng).max(axis=1) >= ALARM,
            e_process(values[:, :30], rng).max(axis=1) >= ALARM,
            e_process(values, rng).max(axis=1) >= ALARM,
            cusum(values[:, :30]).max(axis=1) >= cusum_limit("normal"),
            p_values(values[:, :30], rng.random((RUNS, 30))) <= 1 / ALARM,
        ]
        yield f"| {name} | {' | '.join(f'{100 * one.mean():.1f}' for one in found)} |"


def found() -> Iterator[str]:
    """Yield a row for each course: how many are found, and how many cycles after it began."""
    yield "| effect [scatters] | looks | e-process | CUSUM | fixed, 30 | cycles used |"
    yield "|---|---|---|---|---|---|"
    for k, (name, course) in enumerate(COURSES.items()):
        rng = np.random.default_rng(100 + k)
        values = rounded(rng.normal(size=(RUNS, PLANNED)) + course, rng)
        by_looks = looks(values, rng)
        fixed = p_values(values, rng.random(values.shape)) <= 1 / ALARM
        cells = [
            _cell(by_looks >= ALARM, BEGINS[name]),
            _cell(e_process(values, rng) >= ALARM, BEGINS[name]),
            _cell(cusum(values) >= cusum_limit("rounded, 0.7 division"), BEGINS[name]),
        ]
        used = _first(by_looks >= ALARM).mean()
        yield f"| {name} | {' | '.join(cells)} | {100 * fixed.mean():.0f} | {used:.1f} |"


def _first(alarm: np.ndarray) -> FloatArray:
    """Return the reading of the first alarm, the last one where there is none."""
    return np.where(alarm.any(axis=1), alarm.argmax(axis=1) + 1, alarm.shape[1])


def _cell(alarm: np.ndarray, begin: int) -> str:
    seen = alarm.any(axis=1)
    later = np.median(_first(alarm)[seen] - begin) if seen.any() else np.nan
    return f"{100 * seen.mean():.0f}, {later:.0f}"


def axes() -> Iterator[str]:
    """Yield a row for each case of several axes."""
    yield "| axes | looks | e-process |"
    yield "|---|---|---|"
    cases = {
        "three, scatter only, independent": (3, 0.0, 0.0, 0, 0),
        "three, scatter only, correlated 0.9": (3, 0.9, 0.0, 0, 0),
        "ten, scatter only, correlated 0.5": (10, 0.5, 0.0, 0, 0),
        "step 3 on all three after 12": (3, 0.0, 3.0, 3, 12),
        "step 3 on all three after 22": (3, 0.0, 3.0, 3, 22),
        "step 3 on one of three after 12": (3, 0.0, 3.0, 1, 12),
        "step 3 on one of three after 22": (3, 0.0, 3.0, 1, 22),
    }
    for k, (name, (count, together, size, moved, at)) in enumerate(cases.items()):
        rng = np.random.default_rng(200 + k)
        alone, values = (_correlated(rng, count, together) for _ in range(2))
        values[:, at:, :moved] += size
        each = e_process(np.concatenate(np.moveaxis(values, 2, 0)), rng)
        mean = each.reshape(count, AXIS_RUNS, PLANNED).mean(axis=0)
        cells = [_cell(one >= ALARM, at) for one in (joint_looks(values, alone), mean)]
        yield f"| {name} | {' | '.join(cells)} |"


def _correlated(rng: np.random.Generator, count: int, together: float) -> FloatArray:
    common = rng.normal(size=(AXIS_RUNS, PLANNED, 1)) * together**0.5
    own = rng.normal(size=(AXIS_RUNS, PLANNED, count))
    return np.asarray(common + own * (1 - together) ** 0.5)


def joint_looks(values: FloatArray, alone: FloatArray) -> FloatArray:
    """Return the evidence after each reading of runs (runs, n, axes).

    The p-value is that of the statistic among those of runs ``alone`` in which nothing acts.
    """
    n = values.shape[1]
    evidence = np.ones(values.shape[:2])
    for taken in filter(lambda k: is_look(k, n), range(1, n + 1)):
        null = np.sort(joint_statistic(alone[:, :taken]))
        found = joint_statistic(values[:, :taken])
        p = (len(null) - np.searchsorted(null, found - 1e-9) + 1) / (len(null) + 1)
        evidence[:, taken - 1] = [evidence_of(float(one), taken / n) for one in p]
    return evidence


def joint_statistic(values: FloatArray) -> FloatArray:
    """Return the log of the mean Bayes factor of each run (runs, n, axes) without ties."""
    hypotheses, found = _hypotheses(values.shape[1]), []
    for k in range(0, len(values), 50):
        views = [
            views_of(normal_scores(run, np.zeros(run.shape)), hypotheses.basis)
            for run in values[k : k + 50]
        ]
        bf = log_bayes(hypotheses, np.concatenate([one.columns for one in views], axis=1))
        bf = bf.reshape(len(bf), len(views), -1).transpose(0, 2, 1)
        found.append(np.log(hypotheses.test_weights @ joint_evidence(bf, views[0])))
    return np.concatenate(found)


def names() -> Iterator[str]:
    """Yield a row for each course: what is said at the alarm, and how often it is right."""
    yield "| effect [scatters] | alarms | named right | of shares above 90 % | or a rival |"
    yield "|---|---|---|---|---|"
    for k, name in enumerate(COURSES):
        told = [one for one in _at_alarm(300 + k, name) if one is not None]
        right = {KINDS[name.split()[0]]}
        named = [one.effect in right for one in told]
        sure = [ok for ok, one in zip(named, told, strict=True) if (one.share or 0.0) > SURE]
        among = [bool(right & {str(one.effect), *(one.rivals or {})}) for one in told]
        cells = (named, sure, among)
        shares = " | ".join(f"{sum(one)} of {len(one)}" for one in cells)
        yield f"| {name} | {len(told)} | {shares} |"


def _at_alarm(seed: int, name: str) -> Iterator[Suspicion | None]:
    """Yield what is known at the first alarm of each recording, None where there is none."""
    rng = np.random.default_rng(seed)
    values = rounded(rng.normal(size=(NAMED, PLANNED)) + COURSES[name], rng)
    for run, row in enumerate(values):
        monitor, told = Monitor(planned=PLANNED + 1, seed=run), None
        for value in (row[0], *row):
            monitor.take([float(value)])
            if told is None and monitor.evidence >= ALARM:
                told = monitor.suspicion
        yield told


if __name__ == "__main__":
    page.run({"level": level, "found": found, "axes": axes, "names": names}, PAGE, __doc__)
