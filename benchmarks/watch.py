"""The watch over a recording: false alarms where nothing acts, and how soon it sees what does.

``python -m benchmarks.watch`` prints the tables of benchmarks/results/watch.md, ``--write`` puts
them there. OPENBLAS_NUM_THREADS=1 in the environment saves most of its time.

One axis: 2,000 runs a cell; the p-value of a look is that of the same statistic among 20,000 orders
drawn once, since ranks without ties have one null whatever the readings. Several axes: 1,000 runs,
and the p-value among as many other runs in which nothing acts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from itertools import pairwise

import numpy as np
from scipy.stats import norm, t as student

from benchmarks import page
from scara_iso.diagnosis.evidence import joint_evidence, log_bayes, views_of
from scara_iso.diagnosis.live import (
    ALARM,
    WAYS_ON,
    EProcess,
    _hypotheses,
    drawn_in,
    evidence_of,
    explained,
    is_look,
    normal_scores,
    ways_on,
)
from scara_iso.diagnosis.naming import Choice
from scara_iso.diagnosis.tuning import PAUSE
from scara_iso.run import FloatArray, IntArray

RUNS, ORDERS, AXIS_RUNS, NAMED = 2000, 20_000, 1000, 100
PLANNED = 30
SIGMA = 0.7
"""Scatter in divisions of the dial, where readings are rounded."""
PAGE = page.RESULTS / "watch.md"
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
FOLLOWED: dict[str, Callable[[IntArray], FloatArray]] = {
    "step 2 after 15": lambda k: 2.0 * (k >= 15),
    "step 3 after 12": lambda k: 3.0 * (k >= 12),
    "drift 0.1 a cycle": lambda k: 0.1 * k,
    "drift 0.2 a cycle": lambda k: 0.2 * k,
    "warm-up 4, tau 5": lambda k: -4.0 * np.expm1(-k / 5),
    "warm-up 4, tau 10": lambda k: -4.0 * np.expm1(-k / 10),
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
    for name, told in _at_alarms().items():
        right = KINDS[name.split()[0]]
        named = [one.best == right for one in told]
        sure = [ok for ok, one in zip(named, told, strict=True) if _share(one) > SURE]
        among = [right in (one.best, *(rival.effect for rival in one.rivals)) for one in told]
        cells = (named, sure, among)
        shares = " | ".join(f"{sum(one)} of {len(one)}" for one in cells)
        yield f"| {name} | {len(told)} | {shares} |"


def shares() -> Iterator[str]:
    """Yield a row for each range of shares: how many of the names at the alarm are right."""
    yield "| share stated | names | mean of it | right |"
    yield "|---|---|---|---|"
    told = [
        (_share(one), one.best == KINDS[name.split()[0]])
        for name, own in _at_alarms().items()
        for one in own
    ]
    for low, high in pairwise((0.0, 0.5, 0.7, 0.8, 0.9, 1.01)):
        here = np.array([one for one in told if low <= one[0] < high]).reshape(-1, 2)
        stated, right = 100 * here.mean(axis=0)
        among = f"{100 * low:.0f} to {min(100, 100 * high):.0f} %"
        yield f"| {among} | {len(here)} | {stated:.0f} | {right:.0f} |"


def _share(choice: Choice) -> float:
    return choice.probability[choice.best]


@cache
def _at_alarms() -> dict[str, list[Choice]]:
    """Return what is known at the first alarm of the recordings of each course."""
    return {
        name: [_explained(values) for values, _ in _alarms(300 + k, name)]
        for k, name in enumerate(COURSES)
    }


def _explained(values: FloatArray, pauses: Sequence[int] = ()) -> Choice:
    return explained(drawn_in(values), _cycles(len(values)), PLANNED, pauses)


def _cycles(n: int) -> IntArray:
    return np.arange(2, n + 2)


def _alarms(seed: int, name: str) -> Iterator[tuple[FloatArray, float]]:
    """Yield each recording's readings (n, 1) up to its first alarm, and its place on the dial."""
    rng = np.random.default_rng(seed)
    place = rng.random((NAMED, 1))
    values = np.round(SIGMA * (rng.normal(size=(NAMED, PLANNED)) + COURSES[name]) + place)
    alarm = looks(values, rng) >= ALARM
    first = _first(alarm)
    for run in np.flatnonzero(alarm.any(axis=1)):
        yield values[run, : int(first[run]), np.newaxis], float(place[run, 0])


def followed() -> Iterator[str]:
    """Yield a row for each course: right names where rivals were left, and what more cycles bring.

    What had warmed begins anew, goes on or stands in a pause; what drifts goes on or stands.
    """
    ways = [_said(*way) for way in WAYS_ON]
    yield f"| effect [scatters] | with rivals | right at the alarm | {' | '.join(ways)} |"
    yield f"|---|---|---|{'---|' * len(ways)}"
    for k, name in enumerate(FOLLOWED):
        rng, found = np.random.default_rng(400 + k), []
        for values, zero in _alarms(500 + k, name):
            cycles = _cycles(len(values))
            choice = _explained(values)
            if choice.rivals:
                foretold = {
                    (one.pause, one.cycles): one.right
                    for one in ways_on(drawn_in(values), cycles, choice, PLANNED, [])
                }
                after = [_followed(values, zero, name, *way, rng) for way in WAYS_ON]
                right = [one == KINDS[name.split()[0]] for one in (choice.best, *after)]
                found.append([*right, *(foretold[way] for way in WAYS_ON)])
        now, *rest = 100 * np.mean(found, axis=0)
        cells = [f"{a:.0f} ({b:.0f})" for a, b in zip(rest[:3], rest[3:], strict=True)]
        yield f"| {name} | {len(found)} | {now:.0f} | {' | '.join(cells)} |"


def _said(pause: bool, cycles: int) -> str:
    return f"{'pause, ' if pause else ''}{cycles} cycles (promised)"


def _followed(
    values: FloatArray, zero: float, name: str, pause: bool, more: int, rng: np.random.Generator
) -> str:
    """Return the likeliest name after ``more`` cycles of a course."""
    n, kind = len(values), name.split(maxsplit=1)[0]
    clocks = {"step": [n], "drift": [n, n + PAUSE], "warm-up": [n, n + PAUSE, 0]}[kind]
    begin = int(rng.choice(clocks)) if pause else n
    course = _course(name, begin + more)[begin:]
    after = np.round(SIGMA * (rng.normal(size=more) + course) + zero)
    whole = np.concatenate([values, after[:, np.newaxis]])
    return _explained(whole, [n] if pause else []).best


def _course(name: str, n: int) -> FloatArray:
    """Return a course of `FOLLOWED` over ``n`` cycles."""
    return FOLLOWED[name](np.arange(n))


if __name__ == "__main__":
    tables = {"level": level, "found": found, "axes": axes, "names": names, "shares": shares}
    page.run({**tables, "followed": followed}, PAGE, __doc__)
