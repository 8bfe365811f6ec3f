"""Which effect? The posterior over the catalogue once a test has found structure.

The evidence of `evidence` takes readings for exact and scatter for Gaussian. Of each effect the
likeliest forms are compared again by `rounded`, which knows the dial and heavy tails, and its
evidence changed in their ratio. Hidden states are sought in the readings themselves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import comb, log
from typing import NamedTuple

import numpy as np

from scara_iso.diagnosis.engine.evidence import (
    AMPLITUDES,
    LARGEST_LOG,
    SHARES,
    HypothesisSet,
    Remainder,
    Views,
    at_amplitudes,
    build,
    by_effect,
    extended,
    joint_evidence,
    log_bayes,
    log_bayes_of_course,
    wider,
)
from scara_iso.diagnosis.engine.hypotheses import FEWEST_MOVED, Hypothesis
from scara_iso.diagnosis.engine.rounded import (
    HEAVY_SHARE,
    MISFIT,
    log_likelihoods,
    mixed,
    scatter_alone,
)
from scara_iso.diagnosis.engine.two_levels import TwoLevels, two_levels
from scara_iso.diagnosis.verdict import UNKNOWN, Choice, posterior
from scara_iso.effects import Chain, Form, Shape
from scara_iso.run import FloatArray

_TINY = 1e-300
_DIGITS = 9

DIAL_FORMS = 3
"""So many of the likeliest forms of each effect are compared as read on the dial."""

SHARED = 0.5
"""Prior weight of a course without a fixed form that the axes of several poses share, over that
of one for each (ablation.py, five poses)."""

LEVELS_JUMPS, LEVELS_WEIGHT = 3, 0.4
"""A course that stays on one level after another has so many jumps (undeclared.py, three_loads)."""

PAIR_WEIGHT = 0.1
"""How much rarer two effects at once are than one: with 0.25 damped and trapezoid courses of no
name pass for two."""
PAIR_EFFECTS, PAIR_FORMS = 6, 2
"""Effects, and forms of each, that are tried as the stronger of two."""


class Weighed(NamedTuple):
    """A form of an effect and the log of its evidence, prior weight included.

    ``column`` is that of the views in which it was found; None for all.
    """

    effect: str
    form: Form
    log_evidence: float
    column: int | None = None


def choose(
    hypotheses: HypothesisSet,
    views: Views,
    beside: Sequence[Weighed] = (),
    readings: Remainder | None = None,
    log_change: Mapping[str, float] | None = None,
) -> Choice:
    """Return the probability of each effect for the views of one residual.

    ``beside`` is what `two_states` found in the same residual; without it effects with hidden
    states are judged by their shapes alone. ``readings`` are those that the views show; without
    them they are taken for exact and their scatter for Gaussian, but for the ``log_change`` of each
    effect that another choice has found.
    """
    log_bf = at_amplitudes(hypotheses, views.columns, views.known, MISFIT)
    bf = np.stack([joint_evidence(one, views) for one in log_bf])
    prior = np.outer(SHARES, hypotheses.weights)
    log_evidence = np.log(np.maximum(prior * bf, _TINY)).round(_DIGITS)
    of = by_effect(hypotheses)
    total = {n: float(np.logaddexp.reduce(log_evidence[:, own].ravel())) for n, own in of.items()}
    changed = log_change or {}
    if readings is not None:
        changed, beside = _on_dial(hypotheses, views, log_evidence, log_bf, readings, beside)
    total = {name: value + changed.get(name, 0.0) for name, value in total.items()}
    strongest = {name: _strongest(hypotheses, log_evidence, own) for name, own in of.items()}
    for one in beside:
        total[one.effect] = float(np.logaddexp(total.get(one.effect, -np.inf), one.log_evidence))
        if one.effect not in strongest or one.log_evidence > strongest[one.effect].log_evidence:
            strongest[one.effect] = one
    forms = {name: one.form for name, one in strongest.items()}
    probability = {name: p for name, p in posterior(total).items() if p}
    return Choice(probability, forms, changed)


def _strongest(hypotheses: HypothesisSet, log_evidence: FloatArray, own: Sequence[int]) -> Weighed:
    amplitude, i = divmod(int(np.argmax(log_evidence[:, own])), len(own))
    member = hypotheses.members[own[i]]
    form = member.of or wider(member.form, AMPLITUDES[amplitude])
    return Weighed(member.effect, form, float(log_evidence[amplitude, own[i]]))


def _on_dial(
    hypotheses: HypothesisSet,
    views: Views,
    log_evidence: FloatArray,
    log_bf: FloatArray,
    readings: Remainder,
    beside: Sequence[Weighed],
) -> tuple[dict[str, float], list[Weighed]]:
    """Return what dial and tails change in each effect's evidence, and in that ``beside``.

    ``log_evidence`` (amplitudes, members) comes from ``log_bf`` (amplitudes, members, views), and
    is changed itself where forms were compared. What was found beside takes Gaussian scatter for
    granted, which is a share of all.
    """
    axes = views.axes
    top = _likeliest(hypotheses, log_evidence)
    places = [place for own in top.values() for place in own]
    alone = scatter_alone(len(readings.values))
    by_axis = [
        log_likelihoods(
            readings.values[:, axis],
            readings.half[:, axis],
            hypotheses.basis,
            [*(hypotheses.course(i, AMPLITUDES[a], axis) for a, i in places), alone],
            float(readings.known[axis]),
        )
        for axis in range(axes)
    ]
    likely = np.stack([mixed(found) for found in by_axis], axis=1)
    plain = np.array([log_bf[a, i, :axes] for a, i in places])
    change = _together(likely[:-1] - likely[-1]) - _together(np.minimum(plain, LARGEST_LOG / axes))
    before = {name: [log_evidence[place] for place in own] for name, own in top.items()}
    for place, much in zip(places, change.tolist(), strict=True):
        log_evidence[place] = round(log_evidence[place] + much, _DIGITS)
    changed = {
        name: float(
            np.logaddexp.reduce([log_evidence[place] for place in own])
            - np.logaddexp.reduce(before[name])
        )
        for name, own in top.items()
    }
    gaussian = np.array([found[-1, 0] for found in by_axis]) + np.log(1 - HEAVY_SHARE) - likely[-1]
    return changed, [_in_gaussian(one, gaussian) for one in beside]


def _in_gaussian(one: Weighed, log_share: FloatArray) -> Weighed:
    """Return what takes Gaussian scatter for granted, where that is a share (axes,) of all."""
    alone = one.column is not None and one.column < len(log_share)
    share = log_share[one.column] if alone else log_share.sum()
    return one._replace(log_evidence=one.log_evidence + float(share))


def _likeliest(
    hypotheses: HypothesisSet, log_evidence: FloatArray
) -> dict[str, list[tuple[int, int]]]:
    """Return amplitude and member of each effect's likeliest forms, each member once."""
    best = log_evidence.argmax(axis=0)
    ranked = _ranked(hypotheses.members, log_evidence.max(axis=0))
    return {name: [(int(best[i]), i) for i in own[:DIAL_FORMS]] for name, own in ranked.items()}


def _ranked(members: Sequence[Hypothesis], strength: FloatArray) -> dict[str, list[int]]:
    """Return the places of each effect's members, strongest first, and so the effects."""
    of: dict[str, list[int]] = {}
    for i in np.argsort(-strength, kind="stable").tolist():
        of.setdefault(members[i].effect, []).append(i)
    return of


def _together(log_bf: FloatArray) -> FloatArray:
    """Return log Bayes factors (c,) of single ones (c, axes), each axis taking part or not."""
    if log_bf.shape[1] == 1:
        return log_bf[:, 0]
    return np.asarray((np.logaddexp(0, log_bf) - np.log(2)).sum(axis=1))


def two_states(left: Remainder) -> list[Weighed]:
    """Return, for each effect with hidden chains, its evidence and the course of its states.

    They are sought on each axis, along the widest direction of several, and along those that have a
    name; all axes share those that one shows best.
    """
    chained: dict[str, list[tuple[Chain, float]]] = {}
    for member in left.members:
        if isinstance(member.form, Chain):
            chained.setdefault(member.effect, []).append((member.form, member.weight))
    columns = _columns(left.views, left.division)
    found = []
    for effect, own in chained.items():
        chains = [chain for chain, _ in own]
        prior = np.log(np.array([weight for _, weight in own]) / max(1, len(columns)))
        best: tuple[float, int, FloatArray, TwoLevels] | None = None
        for place, column, least, known in columns:
            whole = np.full(left.cycles, np.nan)
            whole[left.rows] = column
            levels = two_levels(whole, least, chains, known=known)
            if levels is None:
                continue
            log_evidence = float(np.logaddexp.reduce(prior + levels.log_bf))
            if best is None or log_evidence > best[0]:
                best = log_evidence, place, column, levels
        if best is not None:
            found.append(_over_axes(left, effect, *best))
    return found


def _columns(views: Views, division: FloatArray) -> list[tuple[int, FloatArray, float, float]]:
    """Return where states are sought: place, column (n,), its division, known squares."""
    q = views.axes
    known = views.known.tolist()
    shown = np.flatnonzero(~np.isnan(division)).tolist()
    found = [(a, views.columns[:, a], float(division[a]), known[a]) for a in shown]
    if len(found) < 2:
        return found
    named = range(q, len(known)) if views.poses is not None else ()
    along = [(a, views.columns[:, a], 0.0, 0.0) for a in named]
    return [*found, (-1, *widest(views, division), 0.0), *along]


def widest(views: Views, division: FloatArray) -> tuple[FloatArray, float]:
    """Return the axes along their widest direction (n,), of unit length, and its division.

    ``division`` (axes,) is in the units of the views; nan counts for nothing.
    """
    axes = views.columns[:, : views.axes]
    along = np.linalg.eigh(axes.T @ axes)[1][:, -1]
    length = max(float(np.linalg.norm(axes @ along)), _TINY)
    return axes @ along / length, float(np.sqrt(np.nansum((along * division) ** 2))) / length


def _over_axes(
    left: Remainder,
    effect: str,
    log_evidence: float,
    place: int,
    column: FloatArray,
    levels: TwoLevels,
) -> Weighed:
    """Return the evidence that all axes share the states found in one column.

    Once their course is known it is a shape like any other: what the other axes add to the
    evidence is that of the shape over all axes beside its own in the column where it was found.
    """
    course = np.where(levels.share_upper > 0.5, 1.0, 0.0)[:, np.newaxis]
    shown = course[left.rows]
    log_bf = log_bayes_of_course(shown, left.basis, left.views.columns)
    together = joint_evidence(log_bf[np.newaxis], left.views)[0]
    alone = log_bayes_of_course(shown, left.basis, column[:, np.newaxis])[0]
    form = Shape(course, {"switching": levels.switching})
    gained = float(np.log(together) - alone)
    return Weighed(effect, form, log_evidence + gained, place if place >= 0 else None)


def in_common(hypotheses: HypothesisSet, left: Remainder) -> list[Hypothesis]:
    """Return each effect of no fixed course as one course that the axes of several poses share.

    A random course, or a sine of any phase, of its own costs an axis more than a course that is
    known beforehand; one in common costs that once. The likeliest one along the widest direction
    is a shape. It is as much rarer than the effect as it is likelier, along that direction alone,
    than all that the effect could do.
    """
    if left.views.poses is None:
        return []
    groups = tuple(group for group in hypotheses.groups if group.variances.shape[1] > 1)
    hypotheses = replace(hypotheses, groups=groups, spreads=(), scales=hypotheses.scales[:0])
    column, _ = widest(left.views, np.zeros(left.views.axes))
    log_evidence = _log_evidence_along(column, hypotheses)
    found = []
    for effect, own in by_effect(hypotheses).items():
        amplitude, i = divmod(int(np.argmax(log_evidence[:, own])), len(own))
        prior = hypotheses.course(own[i], AMPLITUDES[amplitude])
        course = np.zeros((left.cycles, 1))
        kept = prior.variances / (1 + prior.variances)
        course[left.rows, 0] = prior.columns @ (kept * (prior.columns.T @ column))
        shared = Hypothesis(effect, Shape(course), 1.0)
        alone = build([shared], left.rows, left.basis)
        if alone.members:
            whole = np.logaddexp.reduce(log_evidence[:, own], axis=None)
            likelier = np.logaddexp.reduce(_log_evidence_along(column, alone), axis=None) - whole
            form = _strongest(hypotheses, log_evidence, own).form
            found.append(replace(shared, weight=SHARED * float(np.exp(-likelier)), of=form))
    return found


def _log_evidence_along(column: FloatArray, hypotheses: HypothesisSet) -> FloatArray:
    """Return the log evidence (amplitudes, members) of one column (n,), prior weights included."""
    log_bf = at_amplitudes(hypotheses, column[:, np.newaxis], misfit=MISFIT)[..., 0]
    share = np.log(SHARES)[:, np.newaxis]
    return np.asarray(share + log_bf + np.log(np.maximum(hypotheses.weights, _TINY)))


def likeliest(shapes: Sequence[Form], left: Remainder) -> tuple[Form, float]:
    """Return the shape that fits what is left best, and its log evidence over all axes."""
    hypotheses = build([Hypothesis(UNKNOWN, one, 1.0) for one in shapes], left.rows, left.basis)
    log_bf = log_bayes(hypotheses, left.views.columns)
    evidence = joint_evidence(log_bf, left.views)
    best = int(np.argmax(evidence))
    return hypotheses.members[best].form, float(np.log(evidence[best]))


def on_levels(left: Remainder) -> list[Hypothesis]:
    """Return the unknown as a course that jumps from level to level, of all rows of a run.

    No level has fewer than FEWEST_MOVED cycles. All such courses are as likely; compared is the one
    whose jumps are found one after another, and then each once more beside the others. There is
    none where a course of one jump fewer is likelier: fewer are steps.
    """
    n = left.cycles
    if n < 2 * LEVELS_JUMPS * FEWEST_MOVED:  # no room for a jump more, wherever the others are
        return []
    jumps, likely = np.tri(n)[:, 1:].T[:, :, np.newaxis], {}
    for count in (LEVELS_JUMPS - 1, LEVELS_JUMPS):
        course: Form = Shape(np.empty((n, 0)))
        for _ in range(2 * count):
            kept = course.columns[:, max(0, course.columns.shape[1] - count + 1) :]
            tried = [np.hstack([kept, jump]) for jump in jumps]
            shapes = [Shape(one) for one in tried if _shortest_level(one) >= FEWEST_MOVED]
            course, likely[count] = likeliest(shapes, left)
        courses = comb(n - (count + 1) * (FEWEST_MOVED - 1) - 1, count)
        likely[count] -= log(courses)
    if likely[LEVELS_JUMPS] <= likely[LEVELS_JUMPS - 1]:
        return []
    return [Hypothesis(UNKNOWN, course, LEVELS_WEIGHT / courses)]


def _shortest_level(course: FloatArray) -> float:
    """Return the fewest cycles between two jumps of a course (n, jumps), or to its ends."""
    return float(np.diff(np.sort([0, *course.sum(axis=0), len(course)])).min())


def two_at_once(hypotheses: HypothesisSet, left: Remainder) -> list[Weighed]:
    """Return the evidence of pairs of shapes, each under the name and form of its stronger one.

    Effects are found one after another, and two at once may look like neither of them: the round
    after the stronger one then finds the other. As the stronger one the likeliest forms of the
    likeliest effects are tried, as the other any shape of another effect that is less likely: two
    of one effect follow any course of no name. Along each axis either acts, both or none, with even
    odds.
    """
    views, rows = left.views, left.rows
    named = (m for m in hypotheses.members if m.effect != UNKNOWN)
    shapes = [m for m in named if isinstance(m.form, Shape) and m.form.of is None]
    if len({m.effect for m in shapes}) < 2:
        return []
    alone, columns = build(shapes, rows, hypotheses.basis), views.columns[:, : views.axes]
    known = views.known[: views.axes]
    single = at_amplitudes(alone, columns, known, MISFIT)
    singles = Views(columns, views.axes, known)
    joint = [joint_evidence(one, singles) for one in single]
    strength = alone.weights * np.tensordot(SHARES, joint, 1)
    place = {id(member): i for i, member in enumerate(alone.members)}
    found = []
    strongest = list(_ranked(alone.members, strength).values())[:PAIR_EFFECTS]
    for first in (i for own in strongest for i in own[:PAIR_FORMS]):
        member = alone.members[first]
        basis = extended(alone.basis, member.form.columns[rows])
        weaker = [
            other
            for other, evidence in zip(alone.members, strength, strict=True)
            if other.effect != member.effect and evidence < strength[first]
        ]
        if not weaker:
            continue
        companions = build(weaker, rows, basis)
        others = [place[id(one)] for one in companions.members]
        free = columns - basis @ (basis.T @ columns)
        one = single[:, [first]]
        both = one + at_amplitudes(companions, free, known, MISFIT)
        limit = LARGEST_LOG / views.axes
        parts = [np.exp(np.minimum(part, limit)) for part in (one, single[:, others], both)]
        mixed = np.prod((1 + parts[0] + parts[1] + parts[2]) / 4, axis=2)
        total = float(SHARES @ mixed @ companions.weights)
        weight = PAIR_WEIGHT * member.weight / alone.weights.sum()
        found.append(Weighed(member.effect, member.form, float(np.log(weight * total + _TINY))))
    return found
