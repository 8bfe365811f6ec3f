"""Which effect? The posterior over the catalogue once a test has found structure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.diagnosis.bank import Bank, Form, Member
from scara_iso.diagnosis.evidence import (
    LARGEST_LOG,
    Views,
    joint_evidence,
    log_bayes,
    log_bayes_of_course,
)
from scara_iso.diagnosis.levels import TwoLevels, can_show_two, two_levels
from scara_iso.effects import Chain, Process, Shape
from scara_iso.run import FloatArray, IntArray

_RIVAL = 0.1
"""Share of the best effect's probability from which another one is its rival."""

AMPLITUDES = ((1.0, 0.8), (13.0, 0.15), (200.0, 0.05))
"""Factors on the variances beside the scatter, and their prior: most effects are near it, some
dwarf it. One fixed variance alone could not tell such courses apart (Liang et al. 2008, 2.2)."""

_SHARPNESS = 1.4
"""Power of the evidence that makes stated probabilities come true (benchmarks/diagnosis.py)."""


@dataclass(frozen=True, eq=False, slots=True)
class Choice:
    """Probability of every effect, given that there is one; the unknown is one of them.

    ``forms`` holds the likeliest form of each over all cycles of the run; hidden sides as the
    course that they took.
    """

    probability: Mapping[str, float]
    forms: Mapping[str, Form]

    @property
    def best(self) -> str:
        """Name of the likeliest effect, or UNKNOWN."""
        return max(self.probability, key=self.probability.__getitem__)

    @property
    def rivals(self) -> dict[str, float]:
        """Other effects at least a tenth as likely as the best, likeliest first."""
        least = _RIVAL * self.probability[self.best]
        ranked = sorted(self.probability.items(), key=lambda item: -item[1])
        return {name: p for name, p in ranked[1:] if p >= least}


def choose(bank: Bank, views: Views, sides: Sequence[Hypothesis] = ()) -> Choice:
    """Return the posterior over effects for the views of one residual.

    ``sides`` are what `hidden_sides` found in the same residual; without them effects with hidden
    chains are judged by their shapes alone.
    """
    evidence = np.array([_evidence(bank, views, *amplitude) for amplitude in AMPLITUDES])
    of: dict[str, list[int]] = {}
    for i, member in enumerate(bank.members):
        of.setdefault(member.effect, []).append(i)
    total = {name: float(evidence[:, own].sum()) for name, own in of.items()}
    strongest = {name: _strongest(bank, evidence, own) for name, own in of.items()}
    for hypothesis in sides:
        name = hypothesis.effect
        total[name] = total.get(name, 0.0) + hypothesis.evidence
        if name not in strongest or hypothesis.evidence > strongest[name].evidence:
            strongest[name] = hypothesis
    largest = max(total.values())
    sharp = {name: (value / largest) ** _SHARPNESS for name, value in total.items()}
    whole = sum(sharp.values())
    return Choice(
        {name: value / whole for name, value in sharp.items() if value > 0},
        {name: hypothesis.form for name, hypothesis in strongest.items()},
    )


def _evidence(bank: Bank, views: Views, factor: float, share: float) -> FloatArray:
    """Return that of the members with variance ``factor`` times as large, prior ``share``."""
    log_bf = log_bayes(bank.amplified(factor), views.columns, views.known)
    bf = joint_evidence(log_bf[:, :, np.newaxis], views)[:, 0]
    return np.asarray(share * bank.weights * bf)


def _strongest(bank: Bank, evidence: FloatArray, own: Sequence[int]) -> Hypothesis:
    """Return the member (one of ``own``) and amplitude of the largest ``evidence`` (both)."""
    amplitude, i = divmod(int(np.argmax(evidence[:, own])), len(own))
    member = bank.members[own[i]]
    factor, form = AMPLITUDES[amplitude][0], member.form
    if isinstance(form, Process):
        form = replace(form, covariance=factor * form.covariance, amplitude=factor**0.5)
    return Hypothesis(member.effect, form, float(evidence[amplitude, own[i]]))


@dataclass(frozen=True, eq=False, slots=True)
class Hypothesis:
    """A hypothesis and its weighted evidence."""

    effect: str
    form: Form
    evidence: float


def hidden_sides(
    members: Sequence[Member],
    views: Views,
    basis: FloatArray,
    *,
    division: FloatArray,
    rows: IntArray,
    n: int,
) -> list[Hypothesis]:
    """Return, for each effect with hidden chains, its evidence and the course of its sides.

    ``division`` (axes,) is the dial's in the units of the views, nan for an axis that can show no
    sides; ``rows`` are those of the n cycles that the views hold, ``basis`` what is fitted there.
    """
    chained: dict[str, list[tuple[Chain, float]]] = {}
    for member in members:
        if member.chained and isinstance(member.form, Chain):
            chained.setdefault(member.effect, []).append((member.form, member.weight))
    columns = _columns(views, division)
    if not columns:
        return []
    found = [
        (effect, _sides(chains, views, columns, rows, n)) for effect, chains in chained.items()
    ]
    return [_over_axes(effect, sides, views, basis, rows) for effect, sides in found]


def _columns(views: Views, division: FloatArray) -> list[tuple[int, float]]:
    """Return the columns in which sides are sought, with the least scatter of their dial.

    Those are the axes that can show two and, with several, their principal directions in which
    anything moves.
    """
    q = views.axes
    dials = [(int(a), float(division[a])) for a in np.flatnonzero(~np.isnan(division))]
    axes = [(a, least) for a, least in dials if can_show_two(views.columns[:, a], least)]
    moving = np.flatnonzero(views.columns[:, q : 2 * q].any(axis=0))
    return axes if len(axes) < 2 else axes + [(q + int(a), 0.0) for a in moving]


def _sides(
    chained: Sequence[tuple[Chain, float]],
    views: Views,
    columns: Sequence[tuple[int, float]],
    rows: IntArray,
    n: int,
) -> tuple[int, float, TwoLevels]:
    """Return the column that shows the sides best, their evidence there, and their course."""
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
    sides: tuple[int, float, TwoLevels],
    views: Views,
    basis: FloatArray,
    rows: IntArray,
) -> Hypothesis:
    """Return the hypothesis that all axes share the sides found in one column.

    Once their course is known it is a shape like any other: what the other axes add to the
    evidence is that of the shape over all axes beside its own in the column where it was found.
    """
    column, evidence, levels = sides
    course = np.where(levels.share_upper > 0.5, 1.0, 0.0)[:, np.newaxis]
    log_bf = log_bayes_of_course(course[rows], basis, views.columns)
    together = float(joint_evidence(log_bf[np.newaxis, :, np.newaxis], views)[0, 0])
    gained = together / float(np.exp(log_bf[column]))
    return Hypothesis(effect, Shape(course, {"switching": levels.switching}), evidence * gained)
