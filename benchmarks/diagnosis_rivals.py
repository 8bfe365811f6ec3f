"""What else names an effect: information criteria, change points, textbook tests, SINDy.

Each rival returns the name of an effect of the catalogue, or None for "nothing". They stand beside
the package's procedure in benchmarks/diagnosis.py; two need packages of the ``benchmark`` extra.
"""

from __future__ import annotations

import numpy as np

from scara_iso.diagnosis import UNKNOWN
from scara_iso.diagnosis.engine.hypotheses import hypotheses_of
from scara_iso.effects import Conditions, Shape, find_effects

# Parameters of each effect beside its coefficients: position, time constant, period.
_NONLINEAR = {"step": 1, "warm_up": 1, "periodic": 1, "outlier": 1}


def _least_squares(y):
    """Return (name, residual sum of squares, parameters) for the best shape of each effect."""
    conditions = Conditions(np.arange(2, len(y) + 2))
    best = {}
    for member in hypotheses_of(find_effects(), conditions):
        if isinstance(member.form, Shape) and member.effect != UNKNOWN:
            design = np.column_stack([np.ones(len(y)), member.form.columns])
            left = y - design @ np.linalg.lstsq(design, y, rcond=None)[0]
            count = design.shape[1] + _NONLINEAR.get(member.effect, 0)
            found = (float(left @ left), count)
            best[member.effect] = min(found, best.get(member.effect, found))
    return [(None, float(((y - y.mean()) ** 2).sum()), 1)] + [(k, *v) for k, v in best.items()]


def by_criterion(y, criterion):
    """Return the effect with the least AICc or BIC, None where it is the constant."""
    n, least, chosen = len(y), np.inf, None
    for name, rss, count in _least_squares(y):
        k = count + 1
        penalty = k * np.log(n) if criterion == "BIC" else 2 * k + 2 * k * (k + 1) / (n - k - 1)
        value = n * np.log(max(rss, 1e-9) / n) + penalty
        if value < least:
            least, chosen = value, name
    return chosen


def by_pelt(y):
    """Return ``step`` where PELT (penalty 2 sigma^2 ln n, sigma by differences) finds a change."""
    import ruptures  # noqa: PLC0415

    sigma = np.median(np.abs(np.diff(y))) / 0.6745 / np.sqrt(2) or np.std(np.diff(y)) / np.sqrt(2)
    model = ruptures.Pelt(model="l2", min_size=3, jump=1).fit(y[:, np.newaxis])
    changes = model.predict(pen=2 * max(sigma, 1e-6) ** 2 * np.log(len(y)))
    return "step" if len(changes) > 1 else None


def by_battery(y):
    """Return the effect of the smallest p-value of textbook tests at 5 % each."""
    from scipy import stats  # noqa: PLC0415

    j, n = np.arange(len(y)), len(y)
    e = y - y.mean()
    above = e > np.median(e)
    runs = 1 + np.count_nonzero(np.diff(above))
    one, two = np.count_nonzero(above), np.count_nonzero(~above)
    expected = 1 + 2 * one * two / n
    variance = max((expected - 1) * (expected - 2) / (n - 1), 1e-9)
    power = np.abs(np.fft.rfft(e)[1:]) ** 2
    g, bins = power.max() / power.sum(), len(power)
    p = {
        "linear_drift": stats.kendalltau(j, y).pvalue,
        "contact_side": 2 * stats.norm.sf(abs(runs - expected) / np.sqrt(variance)),
        "periodic": min(1.0, bins * (1 - g) ** (bins - 1)),
        "step": _pettitt(y),
        "outlier": min(1.0, 2 * n * stats.t.sf(_grubbs(e), n - 2)),
        "warm_up": stats.ttest_ind(y[:5], y[-5:]).pvalue,
        "random_walk": 2 * stats.norm.sf(abs(np.sqrt(n) * (e[1:] @ e[:-1]) / (e @ e))),
        "scatter_change": stats.levene(y[: n // 2], y[n // 2 :]).pvalue,
        "two levels": stats.shapiro(y).pvalue,
    }
    name = min(p, key=lambda k: p[k] if np.isfinite(p[k]) else 1.0)
    return name if p[name] < 0.05 else None


def _pettitt(y):
    ranks = np.argsort(np.argsort(y)) + 1.0
    n = len(y)
    k = np.abs(2 * np.cumsum(ranks)[:-1] - np.arange(1, n) * (n + 1)).max()
    return min(1.0, 2 * np.exp(-6 * k**2 / (n**3 + n**2)))


def _grubbs(e):
    n, z = len(e), np.abs(e).max() / e.std(ddof=1)
    return np.sqrt(z**2 * n * (n - 2) / max((n - 1) ** 2 - n * z**2, 1e-9))


def by_sindy(y):
    """Return the kind of term that sparse regression (STLSQ of PySINDy) keeps on its own.

    The library holds the shapes of the catalogue at three or four parameters each.
    """
    from pysindy import STLSQ  # noqa: PLC0415

    j, n = np.arange(len(y)), len(y)
    columns = {("linear_drift", 0): j * 1.0, ("contact_side", 0): j % 2 * 1.0}
    columns |= {("step", k): (j >= k) * 1.0 for k in (6, 11, 16, 21, 26)}
    columns |= {("warm_up", tau): np.exp(-j / tau) for tau in (2, 4, 8)}
    for period in (3, 4, 6, 9, 14):
        columns[("periodic", period)] = np.sin(2 * np.pi * j / period)
        columns[("periodic", -period)] = np.cos(2 * np.pi * j / period)
    design = np.column_stack([(c - c.mean()) / c.std() for c in columns.values()])
    e = (y - y.mean()) / (y.std() or 1.0)
    fitted = STLSQ(threshold=0.35, alpha=0.05).fit(design, e[:, np.newaxis])
    weight = np.abs(np.ravel(fitted.coef_))[:n]
    if not weight.any():
        return None
    return list(columns)[int(weight.argmax())][0]


RIVALS = {
    "AICc": lambda y: by_criterion(y, "AICc"),
    "BIC": lambda y: by_criterion(y, "BIC"),
    "PELT": by_pelt,
    "battery": by_battery,
    "SINDy": by_sindy,
}
