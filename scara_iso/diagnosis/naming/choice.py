"""Which effect? The posterior over the catalogue once a test has found structure.

What is stated of it is as often right as it says, and no name is sure beside a near rival.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Generic, TypeVar

import numpy as np

from scara_iso.diagnosis.likelihood.evidence import (
    LARGEST_LOG,
    Views,
    joint_evidence,
    log_bayes_amplified,
    log_bayes_of_course,
)
from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis
from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet
from scara_iso.diagnosis.likelihood.on_dial import DialReadings, OnDial, on_dial
from scara_iso.diagnosis.likelihood.rounded import DialCourse, course_beside
from scara_iso.diagnosis.likelihood.two_state import TwoLevels, between_levels, can_show_two
from scara_iso.diagnosis.tuning import (
    AMPLITUDES,
    RIGHT_OF_STATED,
    RIVAL,
    SHARPNESS,
    UNDECIDED,
    UNKNOWN,
    UNNAMED_AHEAD,
    UNSURE,
)
from scara_iso.diagnosis.verdict import Rival
from scara_iso.effects import Chain, Form, Process, Shape
from scara_iso.run import FloatArray, IntArray

_SAID = 1.001 * RIVAL
"""Share that no rounding of numbers takes below RIVAL."""


Near = Callable[[str], Mapping[str, float]]
"""Effects near the named one in BIC, and by how much they are behind."""


def as_stated(posterior: Mapping[str, float], near: Near) -> dict[str, float]:
    """Return what is stated of a posterior: the likeliest effect stays that."""
    probability = as_often_right(posterior)
    best = max(probability, key=probability.__getitem__)
    if probability[best] <= UNDECIDED:
        return probability
    return beside_near_rivals(probability, near(best))


def beside_near_rivals(
    probability: Mapping[str, float], near: Mapping[str, float]
) -> dict[str, float]:
    """Return probabilities of which none is above UNSURE while another effect is near in BIC.

    Nor above UNDECIDED while a course of no name is ahead. The nearest becomes a rival, at least
    RIVAL times as likely as the best; those farther, by the differences ``near``,
    exp(-difference / 2) times that; what is ahead and has no name, UNNAMED_AHEAD times.
    """
    best = max(probability, key=probability.__getitem__)
    ahead = near.get(UNKNOWN, 0.0) < 0
    most = UNDECIDED if ahead else UNSURE
    if probability[best] <= most or not near:
        return dict(probability)
    nearest = min(near.values())
    least = {name: _SAID * float(np.exp((nearest - d) / 2)) for name, d in near.items()}
    if ahead:
        least[UNKNOWN] = UNNAMED_AHEAD
    others = {
        name: max(probability.get(name, 0.0), least.get(name, 0.0) * probability[best])
        for name in {**probability, **least}
        if name != best
    }
    whole = sum(others.values())
    sure = min(most, probability[best] / (probability[best] + whole))
    return {best: sure, **{name: p * (1 - sure) / whole for name, p in others.items()}}


def unsure(probability: float, rivals: tuple[Rival, ...]) -> tuple[float, tuple[Rival, ...]]:
    """Return a probability of at most UNSURE, and rivals of which the unknown takes the rest."""
    if probability <= UNSURE:
        return probability, rivals
    known = tuple(rival for rival in rivals if rival.effect != UNKNOWN)
    rest = max(1 - UNSURE - sum(rival.probability for rival in known), probability - UNSURE)
    every = (*known, Rival(UNKNOWN, rest))
    return UNSURE, tuple(sorted(every, key=lambda rival: -rival.probability))


def as_often_right(probability: Mapping[str, float]) -> dict[str, float]:
    """Return probabilities of which the largest is as large as it has been right: RIGHT_OF_STATED.

    The others share what is left as before.
    """
    best = max(probability, key=probability.__getitem__)
    p = probability[best]
    right = float(np.interp(p, *np.transpose(RIGHT_OF_STATED)))
    left = (1 - right) / (1 - p) if p < 1 else 1.0
    return {name: right if name == best else left * q for name, q in probability.items()}


AnyForm = TypeVar("AnyForm")

Finer = Callable[[Mapping[str, Form]], Sequence[tuple[str, DialCourse]]]
_TINY = 1e-300
_DIGITS = 9


@dataclass(frozen=True, eq=False)
class Choice(Generic[AnyForm]):
    """Posterior probability of every effect, given that there is one; the unknown is one of them.

    ``forms`` holds the likeliest form of each: of readings over all cycles of the run, and hidden
    states as the course that they took.
    """

    posterior: Mapping[str, float]
    forms: Mapping[str, AnyForm]
    log_change: Mapping[str, float] = field(default_factory=dict)
    """What dial and tails changed in each effect's evidence."""
    near: Near | None = None
    """As in `as_stated`; None where the posterior is stated as it is."""

    @property
    def best(self) -> str:
        """Name of the likeliest effect, or UNKNOWN."""
        return max(self.posterior, key=self.posterior.__getitem__)

    @cached_property
    def probability(self) -> Mapping[str, float]:
        """What is stated of the posterior, sought when it is asked for: the name is the same."""
        return self.posterior if self.near is None else as_stated(self.posterior, self.near)

    @property
    def ranked(self) -> tuple[Rival, ...]:
        """All effects, likeliest first."""
        ranked = sorted(self.probability.items(), key=lambda item: -item[1])
        return tuple(Rival(name, p) for name, p in ranked)

    @property
    def rivals(self) -> tuple[Rival, ...]:
        """Other effects at least a tenth as likely as the best, stated or not, likeliest first."""
        best, *others = self.ranked
        least, stated = RIVAL * self.posterior[best.effect], RIVAL * best.probability
        return tuple(
            rival
            for rival in others
            if rival.probability >= stated or self.posterior.get(rival.effect, 0.0) >= least
        )


def posterior(evidence: Mapping[str, float], sharpness: float = 1.0) -> dict[str, float]:
    """Return probabilities from evidence raised to a power."""
    return _posterior({name: _log(value) for name, value in evidence.items()}, sharpness)


def _posterior(log_evidence: Mapping[str, float], sharpness: float) -> dict[str, float]:
    largest = max(log_evidence.values())
    sharp = {n: float(np.exp(sharpness * (e - largest))) for n, e in log_evidence.items()}
    whole = sum(sharp.values())
    return {name: value / whole for name, value in sharp.items()}


def choose(
    hypotheses: HypothesisSet,
    views: Views,
    beside: Sequence[Weighed] = (),
    readings: DialReadings | None = None,
    log_change: Mapping[str, float] | None = None,
    finer: Finer | None = None,
) -> Choice[Form]:
    """Return the posterior over effects for the views of one residual.

    ``beside`` is what `two_states` and `pairs` found in the same residual; without it effects with
    hidden states are judged by their shapes alone. ``readings`` are those that the views show;
    without them they are taken for exact and their scatter for Gaussian, but for the ``log_change``
    of each effect that another choice has found, and no rival is near. ``finer`` gives courses
    between those of the set, of the likeliest form of each effect: rivals may be near there.
    """
    log_bf = log_bayes_amplified(hypotheses, views.columns, views.known)
    log_evidence = _log_evidence(hypotheses, views, log_bf)
    others = [(one.effect, one.on_dial) for one in beside if one.on_dial is not None]
    seen = readings and on_dial(hypotheses, views, log_evidence, log_bf, readings, others)
    of: dict[str, list[int]] = {}
    for i, member in enumerate(hypotheses.members):
        of.setdefault(member.effect, []).append(i)
    total = {n: float(np.logaddexp.reduce(log_evidence[:, own].ravel())) for n, own in of.items()}
    changed = seen.log_change if seen else (log_change or {})
    total = {name: value + changed.get(name, 0.0) for name, value in total.items()}
    if seen:
        beside = [one.in_gaussian(seen.log_gaussian) for one in beside]
        for place, change in seen.compared.items():
            log_evidence[place] = round(log_evidence[place] + change, _DIGITS)
    strongest = {name: _strongest(hypotheses, log_evidence, own) for name, own in of.items()}
    for weighed in beside:
        name = weighed.effect
        total[name] = float(np.logaddexp(total.get(name, -np.inf), weighed.log_evidence))
        if name not in strongest or weighed.evidence > strongest[name].evidence:
            strongest[name] = weighed
    probability = {name: p for name, p in _posterior(total, SHARPNESS).items() if p > 0}
    forms = {name: weighed.form for name, weighed in strongest.items()}
    near = partial(_near, seen, forms, finer or (lambda _: ())) if seen else None
    return Choice(probability, forms, changed, near)


def _near(seen: OnDial, forms: Mapping[str, Form], finer: Finer, best: str) -> Mapping[str, float]:
    return seen.near(best, finer(forms))


def _log_evidence(hypotheses: HypothesisSet, views: Views, log_bf: FloatArray) -> FloatArray:
    """Return that of each member at each amplitude, prior weights included.

    Rounded, so that forms which fit equally well come in one order on every machine.
    """
    bf = np.stack([joint_evidence(one[:, :, np.newaxis], views)[:, 0] for one in log_bf])
    share = np.array([share for _, share in AMPLITUDES])[:, np.newaxis]
    return np.log(np.maximum(share * hypotheses.weights * bf, _TINY)).round(_DIGITS)


def _strongest(hypotheses: HypothesisSet, log_evidence: FloatArray, own: Sequence[int]) -> Weighed:
    """Return the member (one of ``own``) and amplitude of the largest evidence."""
    amplitude, i = divmod(int(np.argmax(log_evidence[:, own])), len(own))
    member = hypotheses.members[own[i]]
    factor, form = AMPLITUDES[amplitude][0], member.form
    if isinstance(form, Process):
        form = replace(form, variance=factor * form.variance, amplitude=factor**0.5)
    return Weighed(member.effect, form, float(np.exp(log_evidence[amplitude, own[i]])))


@dataclass(frozen=True, eq=False, slots=True)
class Weighed:
    """A form of an effect and its evidence, prior weight included."""

    effect: str
    form: Form
    evidence: float
    column: int | None = None
    """The column of the views in which it was found; None for all."""
    on_dial: DialCourse | None = None
    """The whole course that the evidence is of."""

    @property
    def log_evidence(self) -> float:
        """Logarithm of the evidence."""
        return _log(self.evidence)

    def in_gaussian(self, log_share: FloatArray) -> Weighed:
        """Return it where scatter need not be Gaussian, as it takes for granted.

        ``log_share`` (axes,) is that of the Gaussian family in scatter alone.
        """
        one = self.column is not None and self.column < len(log_share)
        share = log_share[self.column] if one else log_share.sum()
        return replace(self, evidence=self.evidence * float(np.exp(share)))


def two_states(
    members: Sequence[Hypothesis],
    views: Views,
    basis: FloatArray,
    *,
    division: FloatArray,
    rows: IntArray,
    n: int,
) -> list[Weighed]:
    """Return, for each effect with hidden chains, its evidence and the course of its states.

    ``division`` (axes,) is the dial's in the units of the views, nan for an axis that can show no
    two states; ``rows`` are those of the n cycles that the views hold, ``basis`` what is fitted
    there.
    """
    chained: dict[str, list[tuple[Chain, float]]] = {}
    for member in members:
        if isinstance(member.form, Chain):
            chained.setdefault(member.effect, []).append((member.form, member.weight))
    columns = _columns(views, division)
    if not columns:
        return []
    found = [
        (effect, _states(chains, views, columns, rows, n)) for effect, chains in chained.items()
    ]
    return [_over_axes(effect, states, views, basis, rows) for effect, states in found]


def _columns(views: Views, division: FloatArray) -> list[tuple[int, float]]:
    """Return the columns in which states are sought, with the least scatter of their dial.

    Those are the axes that can show two and, with several, their principal directions in which
    anything moves; of several poses the named ones.
    """
    q = views.axes
    dials = [(int(a), float(division[a])) for a in np.flatnonzero(~np.isnan(division))]
    axes = [(a, least) for a, least in dials if can_show_two(views.columns[:, a], least)]
    seen = views.columns[:, q : 2 * q] if views.poses is None else views.columns[:, q:]
    moving = np.flatnonzero(seen.any(axis=0))
    return axes if len(axes) < 2 else axes + [(q + int(a), 0.0) for a in moving]


def _states(
    chained: Sequence[tuple[Chain, float]],
    views: Views,
    columns: Sequence[tuple[int, float]],
    rows: IntArray,
    n: int,
) -> tuple[int, float, TwoLevels]:
    """Return the column that shows the states best, their evidence there, and their course."""
    chains = [chain for chain, _ in chained]
    prior = np.array([weight for _, weight in chained]) / len(columns)
    between = []
    for column, division in columns:
        whole = np.full(n, np.nan)
        whole[rows] = views.columns[:, column]
        known = 0.0 if views.known is None else float(views.known[column])
        between.append((column, between_levels(whole, division, known=known)))
    between.sort(key=lambda one: -one[1].log_most)
    found: list[tuple[int, float, TwoLevels]] = []
    for column, readings in between:  # until none can have more evidence
        if found and prior.sum() * _bayes_factor(readings.log_most) < max(e for _, e, _ in found):
            break
        levels = readings.under(chains)
        found.append((column, float(prior @ _bayes_factor(levels.log_bf)), levels))
    return max(found, key=lambda one: (one[1], -one[0]))


def _bayes_factor(log_bf: FloatArray | float) -> FloatArray:
    return np.asarray(np.exp(np.minimum(log_bf, LARGEST_LOG)))


def _over_axes(
    effect: str,
    states: tuple[int, float, TwoLevels],
    views: Views,
    basis: FloatArray,
    rows: IntArray,
) -> Weighed:
    """Return the evidence that all axes share the states found in one column.

    Once their course is known it is a shape like any other: what the other axes add to the
    evidence is that of the shape over all axes beside its own in the column where it was found.
    """
    column, evidence, levels = states
    course = np.where(levels.share_upper > 0.5, 1.0, 0.0)[:, np.newaxis]
    log_bf = log_bayes_of_course(course[rows], basis, views.columns)
    together = float(joint_evidence(log_bf[np.newaxis, :, np.newaxis], views)[0, 0])
    gained = together / float(np.exp(log_bf[column]))
    form = Shape(course, {"switching": levels.switching})
    seen = course_beside(basis, course[rows], 1 + _numbers_of(course[rows, 0]))
    seen = replace(seen, hidden=True)
    return Weighed(effect, form, evidence * gained, column, seen)


def _numbers_of(states: FloatArray) -> float:
    """Return how many numbers of BIC a course of states (n,) is worth: -2 log of its chance."""
    n = len(states)
    changes = (states[1:] != states[:-1]).mean()
    chance = np.array([changes, 1 - changes])
    bits = -(n - 1) * float(chance @ np.log(np.maximum(chance, _TINY)))
    return float(2 * (bits + np.log(2)) / np.log(n))


def _log(evidence: float) -> float:
    return float(np.log(evidence)) if evidence > 0 else -np.inf
