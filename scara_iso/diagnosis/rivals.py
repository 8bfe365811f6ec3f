"""Which cycles would tell rivals apart next: what each rival foretells of them, judged again.

For each way to go on, readings are drawn as the rivals themselves foretell them from those that are
there, and the rivals' probabilities are brought up to date with them. Their largest, on average, is
how often the likeliest name will be right.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from scara_iso.diagnosis.evidence import evidence_of_runs
from scara_iso.diagnosis.hypotheses import Hypothesis, HypothesisSet, build, constant
from scara_iso.diagnosis.tuning import AMPLITUDES
from scara_iso.effects import Process, Shape, Spread
from scara_iso.run import FloatArray

_DRAWS, _FEWEST_DRAWS = 200, 50
"""Futures of one axis, and of many: they are judged while a recording waits."""


def right_after(
    values: FloatArray,
    probability: Mapping[str, float],
    members: Sequence[Hypothesis],
    rng: np.random.Generator,
) -> float:
    """Return how often the likeliest name will be right after some more readings.

    ``values`` (n, axes) are those that are there, ``probability`` that of each effect by them;
    ``members`` are over the n readings and those that follow.
    """
    n, rows = len(values), _rows(members[0])
    whole = build(members, np.arange(rows), constant(rows))
    seen = build(whole.members, np.arange(n), constant(n))
    place = {id(member): i for i, member in enumerate(whole.members)}
    before = np.zeros((len(AMPLITUDES), len(whole.members), 1))
    before[:, [place[id(member)] for member in seen.members]] = _evidence(seen, [values])
    runs = [*_drawn(values, probability, whole, before[:, :, 0], rng)]
    then, now = _by_effect(whole, _evidence(whole, runs)), _by_effect(whole, before)
    known = [name for name, share in probability.items() if share and name in now]
    updated = np.array([probability[name] * then[name] / now[name] for name in known])
    return float((updated.max(axis=0) / updated.sum(axis=0)).mean())


def _rows(member: Hypothesis) -> int:
    """Return how many readings a hypothesis is about."""
    form = member.form
    if isinstance(form, Shape):
        return len(form.columns)
    assert isinstance(form, Process | Spread)  # noqa: S101 - no chains are compared
    return len(form.covariance if isinstance(form, Process) else form.scale)


def _evidence(hypotheses: HypothesisSet, runs: Sequence[FloatArray]) -> FloatArray:
    """Return the evidence (amplitudes, members, runs), prior weights included."""
    weights = hypotheses.weights[:, np.newaxis]
    return np.stack(
        [
            share * weights * evidence_of_runs(hypotheses, runs, factor)
            for factor, share in AMPLITUDES
        ]
    )


def _by_effect(hypotheses: HypothesisSet, evidence: FloatArray) -> dict[str, FloatArray]:
    """Return the evidence (runs,) of each effect that has any."""
    total: dict[str, FloatArray] = {}
    for member, own in zip(hypotheses.members, evidence.sum(axis=0), strict=True):
        total[member.effect] = total.get(member.effect, np.zeros(1)) + own
    return {name: own for name, own in total.items() if own.all()}


def _drawn(
    values: FloatArray,
    probability: Mapping[str, float],
    hypotheses: HypothesisSet,
    evidence: FloatArray,
    rng: np.random.Generator,
) -> Iterator[FloatArray]:
    """Yield runs that have gone on, of effects as likely as they are.

    ``evidence`` (amplitudes, members) is that of the readings that are there.
    """
    draws = max(_FEWEST_DRAWS, _DRAWS // values.shape[1])
    effects = np.array([member.effect for member in hypotheses.members])
    for effect, share in probability.items():
        own = np.where(effects == effect, evidence, 0.0)
        if not own.any():
            continue
        places = rng.choice(own.size, round(draws * share), p=own.ravel() / own.sum())
        for place, count in zip(*np.unique(places, return_counts=True), strict=True):
            amplitude, member = divmod(int(place), len(effects))
            covariance = _covariance(hypotheses, member, AMPLITUDES[amplitude][0])
            for after in _foretold(values, covariance, int(count), rng):
                yield np.concatenate([values, after])


def _covariance(hypotheses: HypothesisSet, member: int, factor: float) -> FloatArray:
    """Return the covariance of readings (n, n) under a member, in the scatter's variance."""
    vectors, variances, scale = hypotheses.course(member)
    return np.asarray(np.diag(scale**2) + (vectors * (factor * variances)) @ vectors.T)


def _foretold(
    values: FloatArray, covariance: FloatArray, count: int, rng: np.random.Generator
) -> FloatArray:
    """Return draws of what follows ``values`` (n, axes), shape (count, m, axes).

    ``covariance`` (n + m, n + m) is in the scatter's variance. Mean and scatter are those that the
    values tell: the best linear unbiased prediction (Goldberger 1962), with Student's t.
    """
    n, axes = values.shape
    inverse, across = np.linalg.inv(covariance[:n, :n]), covariance[n:, :n]
    known = inverse.sum()
    mean = inverse.sum(axis=0) @ values / known
    left = values - mean
    beside = 1 - across @ inverse.sum(axis=1)
    spread = covariance[n:, n:] - across @ inverse @ across.T + np.outer(beside, beside) / known
    width = np.sqrt(1 / rng.chisquare(n - 1, (count, 1, 1)))
    normal = rng.normal(size=(count, len(spread), axes))
    drawn = width * (_root(spread) @ normal @ _root(left.T @ inverse @ left).T)
    return np.asarray(mean + across @ inverse @ left + drawn)


def _root(covariance: FloatArray) -> FloatArray:
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
