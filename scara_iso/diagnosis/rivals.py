"""Which cycles would tell rivals apart next: what each rival foretells of them, judged again.

For each way to go on, readings are drawn as the rivals themselves foretell them from those that are
there, and the rivals' probabilities are brought up to date with them. Their largest, on average, is
how often the likeliest name will be right. A way may be a recorded column taken at another value.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.diagnosis.likelihood.evidence import evidence_of_runs
from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis, hypotheses_of
from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet, build, constant
from scara_iso.diagnosis.naming.choice import Choice
from scara_iso.diagnosis.tuning import AMPLITUDES, SEED
from scara_iso.effects import CLOCK, Chain, Conditions, Effect, Form, Process, Shape, Spread
from scara_iso.run import FloatArray

_DRAWS, _FEWEST_DRAWS = 200, 50
"""Futures of one axis, and of many: they are judged while a recording waits."""


@dataclass(frozen=True, slots=True)
class NextCycles:
    """A way to go on: ``cycles`` more, behind a pause or not.

    ``right`` is how often the likeliest name will then be right, by the rivals' own account.
    """

    pause: bool
    cycles: int
    right: float


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
            share * weights * evidence_of_runs(hypotheses.amplified(factor), runs)
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
    wider = [hypotheses.amplified(factor) for factor, _ in AMPLITUDES]
    for effect, share in probability.items():
        own = np.where(effects == effect, evidence, 0.0)
        if not own.any():
            continue
        places = rng.choice(own.size, round(draws * share), p=own.ravel() / own.sum())
        for place, count in zip(*np.unique(places, return_counts=True), strict=True):
            amplitude, member = divmod(int(place), len(effects))
            covariance = _covariance(wider[amplitude], member)
            for after in _foretold(values, covariance, int(count), rng):
                yield np.concatenate([values, after])


def _covariance(hypotheses: HypothesisSet, member: int) -> FloatArray:
    """Return the covariance of readings (n, n) under a member, in the scatter's variance."""
    if member >= len(hypotheses.first):
        return np.diag(hypotheses.scales[member - len(hypotheses.first)] ** 2)
    shrink, vectors = hypotheses.of_member(member)
    return np.asarray(np.eye(len(vectors)) + (vectors * (shrink / (1 - shrink))) @ vectors.T)


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


_CHOSEN = ("approach", "payload_kg", "speed")
"""Columns of which an operator chooses the value."""
_CYCLES = 4
_WORTH = 0.05
"""Chance of a right name that is worth a line."""


def next_conditions(
    values: FloatArray, conditions: Conditions, choice: Choice[Form], effects: Sequence[Effect]
) -> str | None:
    """Return what to choose in the next cycles to tell rivals apart, None where nothing would.

    ``values`` (n, axes) are the residual readings taken under ``conditions``, ``choice`` what they
    say.
    """
    rivals = {choice.best, *(rival.effect for rival in choice.rivals)}
    ways = [*_ways(conditions)]
    if len(rivals) == 1 or not ways:
        return None
    found = []
    for way in [{}, *ways]:
        after = _longer(conditions, way)
        members = [_seen(m, after) for m in hypotheses_of(effects, after) if m.named]
        rng = np.random.default_rng(SEED)
        found.append(right_after(values, choice.probability, members, rng))
    before, *others = found
    best = int(np.argmax(others))
    if others[best] < before + _WORTH:
        return None
    ((name, value),) = ways[best].items()
    said = f"approach {value:+g}" if name == "approach" else f"{name} {value:g}"
    return (
        f"{said} in the next {_CYCLES} cycles would tell rivals apart: the likeliest name is then "
        f"right in {others[best]:.0%} ({before:.0%} with cycles as before)"
    )


def _seen(member: Hypothesis, conditions: Conditions) -> Hypothesis:
    """Return a hypothesis; hidden states as the process that keeps them as long (telegraph)."""
    if not isinstance(member.form, Chain):
        return member
    kept = 1 - member.form.leave_lower - member.form.leave_upper
    lag = np.abs(np.subtract.outer(conditions.elapsed, conditions.elapsed))
    return replace(member, form=Process(np.where(lag, kept**lag, 1.0)))


def _ways(conditions: Conditions) -> Iterator[Mapping[str, float]]:
    """Yield the columns that an operator can choose, at either end of what was recorded."""
    for name in _CHOSEN:
        column = conditions.covariates.get(name, np.zeros(1))
        if np.ptp(column):
            yield from ({name: float(value)} for value in (column.min(), column.max()))


def _longer(conditions: Conditions, chosen: Mapping[str, float]) -> Conditions:
    """Return conditions that go on for some cycles, with the columns that are ``chosen``.

    Others that are in the operator's hand go on as they went, the rest stay as they are.
    """
    more = np.arange(1, _CYCLES + 1)
    columns = {}
    for name, column in conditions.covariates.items():
        if name == CLOCK:
            after = column[-1] + more * (conditions.interval or 1.0)
        elif name in chosen:
            after = np.full(_CYCLES, chosen[name])
        else:
            after = column[-_CYCLES:] if name in _CHOSEN else np.full(_CYCLES, column[-1])
        columns[name] = np.append(column, after)
    return Conditions(np.append(conditions.cycle, conditions.cycle[-1] + more), columns)
