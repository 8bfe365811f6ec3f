"""The learned course: what structure that no effect explains looks like, with its band.

Readings of one axis beside the effects found are y = m + f + e, e scatter of variance s^2 and f a
Gaussian process of covariance s^2 K, K one of the covariances of unknown form. The K of the largest
marginal likelihood (m flat, s profiled) is taken; f is then the conditional mean K (K + I)^-1 y,
and its covariance s^2 (K - K (K + I)^-1 K) (Rasmussen and Williams 2006, eq. 2.23 and 2.24). It has
no name and no cause, and on cycles left out it is interpolated.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from scara_iso.diagnosis.fit import Fit, Term, fit
from scara_iso.diagnosis.likelihood.evidence import log_bayes_amplified
from scara_iso.diagnosis.likelihood.hypothesis_set import build
from scara_iso.diagnosis.problem import SearchProblem, remainder
from scara_iso.diagnosis.result import Learned, LearnedCourse
from scara_iso.diagnosis.tuning import AMPLITUDES, UNKNOWN
from scara_iso.effects import Process
from scara_iso.run import FloatArray, IntArray

_TWO_SIDED = 2.0
"""Standard deviations of a band of 95 %, to the digits that a band has."""
_STRONG = 3.0
"""Log Bayes factor from which an axis shows a course; the one with the largest always does."""
_MOST_FREEDOM = 0.5
"""Effective degrees of freedom of a course, of each reading: more would learn the scatter too."""
_LAST = 5
"""The last fifth of the cycles is predicted from those before it."""


def learn(problem: SearchProblem, terms: Sequence[Term], rows: IntArray) -> tuple[Term, ...]:
    """Return a term for each axis that shows a course beside ``terms`` on some rows of the run."""
    left = remainder(problem, terms, rows)
    unnamed = [m for m in left.members if m.effect == UNKNOWN and isinstance(m.form, Process)]
    hypotheses = build(unnamed, rows, left.basis)
    axes = left.views.axes
    log_bf = log_bayes_amplified(hypotheses, left.views.columns[:, :axes])
    factors = [factor for factor, _ in AMPLITUDES]
    freedom = np.array([_freedom(m.form, rows, factors) for m in hypotheses.members]).T
    log_bf = np.where((freedom > _MOST_FREEDOM * len(rows))[..., np.newaxis], -np.inf, log_bf)
    best = log_bf.reshape(-1, axes).argmax(axis=0)
    found = []
    for a in range(axes):
        amplitude, i = divmod(int(best[a]), len(hypotheses.members))
        form = hypotheses.members[i].form
        strength = log_bf.max(axis=(0, 1))
        if strength[a] >= min(_STRONG, strength.max()) and isinstance(form, Process):
            factor = AMPLITUDES[amplitude][0]
            form = replace(form, variance=factor * form.variance, amplitude=factor**0.5)
            found.append(Term(UNKNOWN, form, np.arange(axes) == a))
    return tuple(found)


def _freedom(form: object, rows: IntArray, factors: Sequence[float]) -> FloatArray:
    """Return the effective degrees of freedom of a course, the trace of its smoother, by factor."""
    assert isinstance(form, Process)  # noqa: S101 - of courses of unknown form only
    K = form.covariance[np.ix_(rows, rows)]
    K = K - K.mean(axis=0) - K.mean(axis=1)[:, np.newaxis] + K.mean()
    own = np.multiply.outer(factors, np.linalg.eigvalsh(K).clip(0.0))
    return np.asarray((own / (1.0 + own)).sum(axis=1))


def learned_course(problem: SearchProblem, fitted: Fit) -> Learned | None:
    """Return the learned courses of a fit, each about its mean; None where it has none."""
    residual = problem.residual
    courses = {}
    for term, part in zip(fitted.terms, fitted.parts, strict=True):
        if term.effect == UNKNOWN:
            a = int(np.flatnonzero(term.moves)[0])
            left = residual.values[:, a] - fitted.predicted[:, a]
            u = _uncertainty(term, float(left.std(ddof=1) * fitted.wider[a]))
            value = part[:, a] - part[:, a].mean()
            low, high = (value - _TWO_SIDED * u).tolist(), (value + _TWO_SIDED * u).tolist()
            band = tuple(zip(low, high, strict=True))
            courses[residual.axes[a]] = LearnedCourse(residual.conditions.cycle, value, band)
    return Learned(courses) if courses else None


def _uncertainty(term: Term, scatter: float) -> FloatArray:
    """Return the standard deviation (n,) of a course about its mean, given the readings."""
    assert isinstance(term.form, Process)  # noqa: S101 - of learned terms only
    K = term.form.covariance
    given = K - K @ np.linalg.solve(K + np.eye(len(K)), K)
    about_mean = given - given.mean(axis=0) - given.mean(axis=1)[:, np.newaxis] + given.mean()
    return np.asarray(scatter * np.sqrt(np.maximum(np.diag(about_mean), 0.0)))


def last_cycles(problem: SearchProblem, terms: Sequence[Term]) -> Iterator[str]:
    """Yield how well the last cycles follow from a course learned of those before them."""
    residual = problem.residual
    n, last = len(residual), len(residual) // _LAST
    rows = np.arange(n - last)
    learned = learn(problem, terms, rows)
    if not learned:
        return
    values = residual.values
    with_it, without = (
        np.sqrt(((values - fit(own, values[rows], rows, n).predicted)[-last:] ** 2).mean(axis=0))
        for own in ((*terms, *learned), terms)
    )
    said = "; ".join(
        f"{residual.axes[a]} {with_it[a]:.2g}, without it {without[a]:.2g}"
        for term in learned
        for a in np.flatnonzero(term.moves)
    )
    yield (
        f"cycles to come: error on the last {last} by a course learned of those before them {said}"
    )
