"""Two effects at once: together they may be likelier than any one course, known or not.

Effects are found one after another, and two at once look like neither to the first round. So the
first round also weighs every pair of known shapes, and counts it for the stronger of the two.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from scara_iso.diagnosis.bank import UNKNOWN, Bank, Member, build, extended
from scara_iso.diagnosis.choice import AMPLITUDES, Hypothesis
from scara_iso.diagnosis.evidence import Views, joint_evidence, log_bayes
from scara_iso.effects import Shape
from scara_iso.run import FloatArray, IntArray

_PAIR_WEIGHT = 0.1
"""How much rarer two effects are than one."""
_MOST_EFFECTS, _MOST_FORMS = 6, 2
_LARGEST_LOG = 600.0


def pairs(bank: Bank, views: Views, cycle: IntArray, rows: IntArray) -> list[Hypothesis]:
    """Return the evidence of pairs of shapes, each under the name and form of its stronger one.

    Of the stronger ones the likeliest forms of the likeliest effects are tried, with every other
    shape of the bank. Each axis takes each of the two or not, with probability 1/4 for all cases.
    """
    shaped = [m for m in bank.members if isinstance(m.form, Shape) and m.effect != UNKNOWN]
    axes = replace(
        views,
        columns=views.columns[:, : views.axes],
        known=None if views.known is None else views.known[: views.axes],
    )
    alone = {
        id(member): log_bf
        for member, log_bf in zip(bank.members, log_bayes(bank, views.columns, views.known))
    }
    strength = {id(m): _evidence(m, alone[id(m)], views) for m in shaped}
    total = sum(member.weight for member in shaped)
    found = []
    for first in _likeliest(shaped, strength):
        seconds = [m for m in shaped if strength[id(m)] <= strength[id(first)] and m is not first]
        weight = _PAIR_WEIGHT * first.weight / total
        evidence = weight * _pairs_of(first, seconds, bank, axes, cycle, rows)
        found.append(Hypothesis(first.effect, first.form, evidence))
    return found


def _evidence(member: Member, log_bf: FloatArray, views: Views) -> float:
    joint = joint_evidence(log_bf[np.newaxis, :, np.newaxis], views)
    return float(member.weight * joint[0, 0])


def _likeliest(shaped: Sequence[Member], strength: dict[int, float]) -> Iterator[Member]:
    by_effect: dict[str, list[Member]] = {}
    for member in sorted(shaped, key=lambda m: -strength[id(m)]):
        by_effect.setdefault(member.effect, []).append(member)
    for forms in list(by_effect.values())[:_MOST_EFFECTS]:
        yield from forms[:_MOST_FORMS]


def _pairs_of(
    first: Member,
    seconds: Sequence[Member],
    bank: Bank,
    axes: Views,
    cycle: IntArray,
    rows: IntArray,
) -> float:
    if not seconds or not isinstance(first.form, Shape):
        return 0.0
    basis = extended(bank.basis, first.form.columns[rows])
    beside = build(seconds, cycle, rows, basis)
    alone = build([first, *beside.members], cycle, rows, bank.basis)
    added = basis[:, bank.basis.shape[1] :]
    free = axes.columns - added @ (added.T @ axes.columns)
    order = {id(member): k for k, member in enumerate(alone.members)}
    second = [order[id(member)] for member in beside.members]
    found = 0.0
    for factor, share in AMPLITUDES:
        single = log_bayes(alone.amplified(factor), axes.columns, axes.known)
        one, other = single[order[id(first)]], single[second]
        both = one + log_bayes(beside.amplified(factor), free, axes.known)
        found += share * float(beside.weights @ _mixed(one, other, both, axes.axes))
    return found


def _mixed(one: FloatArray, other: FloatArray, both: FloatArray, q: int) -> FloatArray:
    one, other, both = (np.exp(np.minimum(log, _LARGEST_LOG / q)) for log in (one, other, both))
    if q == 1:
        return np.asarray(both[:, 0])
    return np.asarray(np.prod((1 + one + other + both) / 4, axis=1) / 3)
