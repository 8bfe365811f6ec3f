"""Which effect? The posterior over the catalogue once a test has found structure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from scara_iso.diagnosis.evidence import (
    LARGEST_LOG,
    Views,
    joint_evidence,
    log_bayes,
    log_bayes_of_course,
)
from scara_iso.diagnosis.hypotheses import Hypothesis, HypothesisSet
from scara_iso.diagnosis.tuning import AMPLITUDES, RIVAL, SHARPNESS
from scara_iso.diagnosis.two_state import TwoLevels, can_show_two, two_levels
from scara_iso.diagnosis.verdict import Rival
from scara_iso.effects import Chain, Form, Process, Shape
from scara_iso.run import FloatArray, IntArray

AnyForm = TypeVar("AnyForm")


@dataclass(frozen=True, eq=False, slots=True)
class Choice(Generic[AnyForm]):
    """Posterior probability of every effect, given that there is one; the unknown is one of them.

    ``forms`` holds the likeliest form of each: of readings over all cycles of the run, and hidden
    states as the course that they took.
    """

    probability: Mapping[str, float]
    forms: Mapping[str, AnyForm]

    @property
    def best(self) -> str:
        """Name of the likeliest effect, or UNKNOWN."""
        return max(self.probability, key=self.probability.__getitem__)

    @property
    def ranked(self) -> tuple[Rival, ...]:
        """All effects, likeliest first."""
        ranked = sorted(self.probability.items(), key=lambda item: -item[1])
        return tuple(Rival(name, p) for name, p in ranked)

    @property
    def rivals(self) -> tuple[Rival, ...]:
        """Other effects at least a tenth as likely as the best, likeliest first."""
        best, *others = self.ranked
        return tuple(rival for rival in others if rival.probability >= RIVAL * best.probability)


def posterior(evidence: Mapping[str, float], sharpness: float = 1.0) -> dict[str, float]:
    """Return probabilities from evidence raised to a power."""
    largest = max(evidence.values())
    sharp = {name: (value / largest) ** sharpness for name, value in evidence.items()}
    whole = sum(sharp.values())
    return {name: value / whole for name, value in sharp.items()}


def choose(hypotheses: HypothesisSet, views: Views, beside: Sequence[Weighed] = ()) -> Choice[Form]:
    """Return the posterior over effects for the views of one residual.

    ``beside`` is what `two_states` and `pairs` found in the same residual; without it effects with
    hidden states are judged by their shapes alone.
    """
    evidence = np.array([_evidence(hypotheses, views, *amplitude) for amplitude in AMPLITUDES])
    of: dict[str, list[int]] = {}
    for i, member in enumerate(hypotheses.members):
        of.setdefault(member.effect, []).append(i)
    total = {name: float(evidence[:, own].sum()) for name, own in of.items()}
    strongest = {name: _strongest(hypotheses, evidence, own) for name, own in of.items()}
    for weighed in beside:
        name = weighed.effect
        total[name] = total.get(name, 0.0) + weighed.evidence
        if name not in strongest or weighed.evidence > strongest[name].evidence:
            strongest[name] = weighed
    probability = {name: p for name, p in posterior(total, SHARPNESS).items() if p > 0}
    return Choice(probability, {name: weighed.form for name, weighed in strongest.items()})


def _evidence(hypotheses: HypothesisSet, views: Views, factor: float, share: float) -> FloatArray:
    """Return that of the members with variance ``factor`` times as large, prior ``share``."""
    log_bf = log_bayes(hypotheses.amplified(factor), views.columns, views.known)
    bf = joint_evidence(log_bf[:, :, np.newaxis], views)[:, 0]
    return np.asarray(share * hypotheses.weights * bf)


def _strongest(hypotheses: HypothesisSet, evidence: FloatArray, own: Sequence[int]) -> Weighed:
    """Return the member (one of ``own``) and amplitude of the largest ``evidence`` (both)."""
    amplitude, i = divmod(int(np.argmax(evidence[:, own])), len(own))
    member = hypotheses.members[own[i]]
    factor, form = AMPLITUDES[amplitude][0], member.form
    if isinstance(form, Process):
        form = replace(form, covariance=factor * form.covariance, amplitude=factor**0.5)
    return Weighed(member.effect, form, float(evidence[amplitude, own[i]]))


@dataclass(frozen=True, eq=False, slots=True)
class Weighed:
    """A form of an effect and its evidence, prior weight included."""

    effect: str
    form: Form
    evidence: float


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
    anything moves.
    """
    q = views.axes
    dials = [(int(a), float(division[a])) for a in np.flatnonzero(~np.isnan(division))]
    axes = [(a, least) for a, least in dials if can_show_two(views.columns[:, a], least)]
    moving = np.flatnonzero(views.columns[:, q : 2 * q].any(axis=0))
    return axes if len(axes) < 2 else axes + [(q + int(a), 0.0) for a in moving]


def _states(
    chained: Sequence[tuple[Chain, float]],
    views: Views,
    columns: Sequence[tuple[int, float]],
    rows: IntArray,
    n: int,
) -> tuple[int, float, TwoLevels]:
    """Return the column that shows the states best, their evidence there, and their course."""
    prior = np.array([weight for _, weight in chained])
    found = []
    for column, division in columns:
        whole = np.full(n, np.nan)
        whole[rows] = views.columns[:, column]
        known = 0.0 if views.known is None else float(views.known[column])
        levels = two_levels(whole, division, [chain for chain, _ in chained], known=known)
        evidence = float(prior @ np.exp(np.minimum(levels.log_bf, LARGEST_LOG)))
        found.append((column, evidence / len(columns), levels))
    return max(found, key=lambda item: item[1])


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
    return Weighed(effect, form, evidence * gained)
