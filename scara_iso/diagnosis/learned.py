"""What no effect explains: its course learned with a band, and in words.

Readings of one axis beside the effects found are y = m + f + e, e scatter of variance s^2 and f a
Gaussian process of covariance s^2 K, K one of the covariances of unknown form. The K of the largest
marginal likelihood (m flat, s profiled) is taken; f is then the conditional mean K (K + I)^-1 y,
and its covariance s^2 (K - K (K + I)^-1 K) (Rasmussen and Williams 2006, eq. 2.23 and 2.24). It has
no name and no cause, and on cycles left out it is interpolated.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise

import numpy as np

from scara_iso.diagnosis.evidence import AMPLITUDES, build, log_bayes, wider
from scara_iso.diagnosis.fit import Fit, SearchProblem, Term, fit, remainder
from scara_iso.diagnosis.hypotheses import UNKNOWN
from scara_iso.diagnosis.residual import Residual
from scara_iso.diagnosis.result import Learned, LearnedCourse, UnexplainedCourse
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
_TURN = 0.2
"""A turn is worth a word from this share of the course's range."""
_LEVEL, _LONG = 0.1, 0.2
"""The first or last tenth of a rise that takes this share of the cycles is no rise yet."""
_MOST_PARTS = 5
_STAYS = "stays level"


def learn(problem: SearchProblem, terms: Sequence[Term], rows: IntArray) -> tuple[Term, ...]:
    """Return a term for each axis that shows a course beside ``terms`` on some rows of the run."""
    left = remainder(problem, terms, rows)
    unnamed = [m for m in left.members if m.effect == UNKNOWN]
    hypotheses = build(unnamed, rows, left.basis)
    axes = left.views.axes
    factors = [factor for factor, _ in AMPLITUDES]
    columns = left.views.columns[:, :axes]
    log_bf = np.stack([log_bayes(hypotheses, columns, factor=factor) for factor in factors])
    freedom = np.array([_freedom(m.form, rows, factors) for m in hypotheses.members]).T
    log_bf = np.where((freedom > _MOST_FREEDOM * len(rows))[..., np.newaxis], -np.inf, log_bf)
    best = log_bf.reshape(-1, axes).argmax(axis=0)
    strength = log_bf.max(axis=(0, 1))
    found = []
    for a in range(axes):
        amplitude, i = divmod(int(best[a]), len(hypotheses.members))
        if strength[a] >= min(_STRONG, strength.max()):
            form = wider(hypotheses.members[i].form, factors[amplitude])
            found.append(Term(UNKNOWN, form, np.arange(axes) == a))
    return tuple(found)


def _freedom(form: object, rows: IntArray, factors: Sequence[float]) -> FloatArray:
    """Return the effective degrees of freedom of a course, the trace of its smoother, by factor."""
    assert isinstance(form, Process)  # noqa: S101 - of courses of unknown form only
    K = form.covariance[np.ix_(rows, rows)]
    K = K - K.mean(axis=0) - K.mean(axis=1)[:, np.newaxis] + K.mean()
    own = np.multiply.outer(factors, np.linalg.eigvalsh(K).clip(0.0))
    return np.asarray((own / (1.0 + own)).sum(axis=1))


def learned_courses(
    residual: Residual, fitted: Fit
) -> tuple[Learned | None, tuple[UnexplainedCourse, ...]]:
    """Return the learned courses of a fit, each about its mean, and in words; None without any.

    The words are of the whole course, the effects found included: that is what the readings do.
    """
    courses, said, cycle = {}, [], residual.conditions.cycle
    for term, part in zip(fitted.terms, fitted.parts, strict=True):
        if term.effect == UNKNOWN and isinstance(term.form, Process):
            a = int(np.flatnonzero(term.moves)[0])
            left = residual.values[:, a] - fitted.predicted[:, a]
            u = _uncertainty(term.form.covariance, float(left.std(ddof=1) * fitted.wider[a]))
            value = part[:, a] - part[:, a].mean()
            low, high = (value - _TWO_SIDED * u).tolist(), (value + _TWO_SIDED * u).tolist()
            band = tuple(zip(low, high, strict=True))
            courses[residual.axes[a]] = LearnedCourse(cycle, value, band)
            words = in_words(fitted.predicted[:, a], cycle)
            said.append(UnexplainedCourse(residual.axes[a], words))
    return Learned(courses) if courses else None, tuple(said)


def _uncertainty(K: FloatArray, scatter: float) -> FloatArray:
    """Return the standard deviation (n,) of a course about its mean, given the readings."""
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


def in_words(smooth: FloatArray, cycle: IntArray) -> str:
    """Return what a smooth course (n,) does over the cycles (n,), empty where it does nothing."""
    if not np.ptp(smooth):
        return ""
    parts = [part for a, b in pairwise(_turns(smooth)) for part in _parts(smooth, a, b)]
    if len(parts) > _MOST_PARTS:
        swings = sum(verb != _STAYS for verb, _ in parts)
        return f"goes up and down, {swings} times in {len(smooth)} cycles"
    return _said([[*same][-1] for _, same in groupby(parts, lambda part: part[0])], cycle)


def _turns(smooth: FloatArray) -> list[int]:
    """Return both ends, and the rows between at which the course turns by a share of its range."""
    least = _TURN * np.ptp(smooth)
    turns, farthest, direction = [0], 0, 0.0
    for i in range(1, len(smooth)):
        beyond = smooth[i] - smooth[farthest]
        if direction * beyond > 0:
            farthest = i
        elif abs(beyond) >= least:
            turns += [farthest] if direction else []
            direction, farthest = np.sign(beyond), i
    return [*turns, len(smooth) - 1]


def _parts(smooth: FloatArray, first: int, last: int) -> list[tuple[str, int]]:
    """Return what the course does between two turns, and the row up to which."""
    change = smooth[last] - smooth[first]
    if abs(change) < _TURN * np.ptp(smooth):
        return [(_STAYS, last)]
    share = (smooth[first : last + 1] - smooth[first]) / change
    begins = first + int(np.flatnonzero(share >= _LEVEL)[0])
    ends = first + int(np.flatnonzero(share <= 1 - _LEVEL)[-1]) + 1
    long = _LONG * len(smooth)
    before = [(_STAYS, begins)] if begins - first >= long else []
    after = [(_STAYS, last)] if last - ends >= long else []
    return [*before, ("rises" if change > 0 else "falls", ends if after else last), *after]


def _said(parts: list[tuple[str, int]], cycle: IntArray) -> str:
    (verb, last), *others = parts
    if not others:
        return f"{verb} all the time"
    said = [f"{verb} in the first {last + 1} cycles"]
    said += [f"{verb} until cycle {cycle[row]}" for verb, row in others[:-1]]
    return f"{', '.join(said)}, then {others[-1][0]}"
