"""Courses that the catalogue's grid lacks, weighed where they may be what the readings show.

Several levels of no name, wherever they change: the hypotheses hold courses of three and of four
levels on a grid of changes, which a run with such levels hardly ever meets, and four levels pass
for a bump or for a drift with a step. Two effects at once: effects are found one after another, and
two may look like neither of them; each pair is counted for the stronger of the two, and the next
round then finds the other. And periods, time constants and widths between those of the grid.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import comb

import numpy as np
import numpy.typing as npt

from scara_iso.diagnosis.likelihood.evidence import (
    LARGEST_LOG,
    Views,
    joint_evidence,
    log_bayes,
    log_bayes_amplified,
)
from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis, levels_of
from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet, build, extended
from scara_iso.diagnosis.likelihood.rounded import DialCourse, course_beside, course_of
from scara_iso.diagnosis.naming.choice import Weighed
from scara_iso.diagnosis.problem import Remainder, SearchProblem
from scara_iso.diagnosis.tuning import (
    AMPLITUDES,
    BEST_LEVELS_SHARE,
    FEWEST_ON_A_LEVEL,
    LEVELS_WEIGHT,
    PAIR_EFFECTS,
    PAIR_FORMS,
    PAIR_WEIGHT,
    UNKNOWN,
)
from scara_iso.effects import Form, Shape
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray

_DUST = 1e-12


def with_levels(hypotheses: HypothesisSet, left: Remainder, n: int) -> HypothesisSet:
    """Return the set with the best courses of several levels in what is left of a run as well."""
    own, more = hypotheses, build(several_levels(left, n), left.rows, left.basis)
    courses = len(own.first)
    return replace(
        own,
        members=(*own.members[:courses], *more.members, *own.members[courses:]),
        vectors=np.concatenate([own.vectors, more.vectors], axis=1),
        first=np.append(own.first, more.first + own.vectors.shape[1]),
        widths=np.append(own.widths, more.widths),
        shrink=np.append(own.shrink, more.shrink),
        penalty=np.append(own.penalty, more.penalty),
    )


def several_levels(left: Remainder, n: int) -> list[Hypothesis]:
    """Return the best courses of several levels in what is left of a run of n cycles.

    Each has the weight of one of all courses with so many levels.
    """
    found = []
    half = left.readings.half.max(axis=0)
    for changes in best_changes(left.values, half, max(LEVELS_WEIGHT)):
        k = len(changes)
        free = len(left.rows) - (k + 1) * (FEWEST_ON_A_LEVEL - 1)
        weight = BEST_LEVELS_SHARE * LEVELS_WEIGHT[k + 1] / comb(free - 1, k)
        found.append(Hypothesis(UNKNOWN, levels_of(n, left.rows[changes].tolist()), weight))
    return found


def best_changes(values: FloatArray, half: FloatArray, most: int) -> Iterator[IntArray]:
    """Yield the rows at which the best courses of 3 to ``most`` levels change.

    ``values`` (n, axes) change together, each axis by as much as it likes; ``half`` (axes,) is half
    a division of each. Least squares over all changes, no level of fewer readings than
    FEWEST_ON_A_LEVEL (segment neighbourhood, Auger and Lawrence 1989).
    """
    cost = _costs(values / _scatter(values, half))
    ending, begun = cost[0], []
    for levels in range(2, most + 1):
        every = ending[:-1, np.newaxis] + cost[1:]
        begun.append(every.argmin(axis=0) + 1)
        ending = every.min(axis=0)
        if levels > 2 and np.isfinite(ending[-1]):
            yield _traced(begun)


def _costs(scaled: FloatArray) -> FloatArray:
    """Return the sum of squares of readings i to j about their mean (n, n), infinite if few."""
    n = len(scaled)
    sums = np.vstack([np.zeros_like(scaled[:1]), scaled.cumsum(axis=0)])
    squares = np.append(0.0, (scaled**2).sum(axis=1).cumsum())
    count = np.arange(1, n + 1) - np.arange(n)[:, np.newaxis]
    between = ((sums[np.newaxis, 1:] - sums[:-1, np.newaxis]) ** 2).sum(axis=2)
    cost = squares[1:] - squares[:-1, np.newaxis] - between / np.maximum(count, 1)
    return np.asarray(np.where(count < FEWEST_ON_A_LEVEL, np.inf, cost))


def _traced(begun: list[IntArray]) -> IntArray:
    """Return the rows at which the best course over all readings changes."""
    changes = [len(begun[0])]
    for first in reversed(begun):
        changes.insert(0, int(first[changes[0] - 1]))
    return np.array(changes[:-1])


def _scatter(values: FloatArray, half: FloatArray) -> FloatArray:
    """Return that of each axis, by the differences of neighbours; not below the dial's."""
    robust = 1.4826 * median(np.abs(np.diff(values, axis=0)), axis=0) / np.sqrt(2)
    return np.asarray(np.maximum(np.maximum(robust, 2 * half / np.sqrt(12)), _DUST))


def pairs(hypotheses: HypothesisSet, views: Views, rows: IntArray) -> list[Weighed]:
    """Return the evidence of pairs of shapes, each under the name and form of its stronger one.

    ``rows`` are those of the run's cycles that both arguments hold. As the stronger one the
    likeliest forms of the likeliest effects are tried, as the other any shape.
    """
    shaped = [m for m in hypotheses.members if isinstance(m.form, Shape) and m.effect != UNKNOWN]
    alone = hypotheses.of(shaped)
    joint = joint_evidence(log_bayes(alone, views.columns, views.known)[:, :, np.newaxis], views)
    strength = alone.weights * joint[:, 0]
    found = []
    for first in _likeliest(alone.members, strength):
        evidence, seen = _beside(alone, first, strength <= strength[first], views, rows)
        member = alone.members[first]
        weight = PAIR_WEIGHT * member.weight / alone.weights.sum()
        found.append(Weighed(member.effect, member.form, weight * evidence, on_dial=seen))
    return found


def _likeliest(members: Sequence[Hypothesis], strength: FloatArray) -> Iterator[int]:
    by_effect: dict[str, list[int]] = {}
    for i in np.argsort(-strength).tolist():
        by_effect.setdefault(members[i].effect, []).append(i)
    for forms in list(by_effect.values())[:PAIR_EFFECTS]:
        yield from forms[:PAIR_FORMS]


def _beside(
    alone: HypothesisSet,
    first: int,
    weaker: npt.NDArray[np.bool_],
    views: Views,
    rows: IntArray,
) -> tuple[float, DialCourse | None]:
    """Return the weighted Bayes factor of one member with each weaker one, and the best two."""
    q, form = views.axes, alone.members[first].form
    if not isinstance(form, Shape):
        return 0.0, None
    basis = extended(alone.basis, form.columns[rows])
    others = [m for m, use in zip(alone.members, weaker, strict=True) if use]
    beside = build(others, rows, basis)
    place = {id(member): i for i, member in enumerate(alone.members)}
    second = [place[id(member)] for member in beside.members]
    columns = views.columns[:, :q]
    known = None if views.known is None else views.known[:q]
    free = columns - basis @ (basis.T @ columns)
    total = np.zeros(len(second))
    singles = log_bayes_amplified(alone, columns, known)
    besides = log_bayes_amplified(beside, free, known)
    for (_, share), single, other in zip(AMPLITUDES, singles, besides, strict=True):
        mixed = _mixed(single[first], single[second], single[first] + other, q)
        total += share * beside.weights * mixed
    return float(total.sum()), _together(
        alone, first, second[int(total.argmax())]
    ) if second else None


def _together(alone: HypothesisSet, first: int, second: int) -> DialCourse:
    """Return two members as one course, which as many numbers choose as choose both."""
    one, other = course_of(alone, first), course_of(alone, second)
    columns = np.concatenate([one.columns, other.columns], axis=1)
    return course_beside(alone.basis, columns, one.parameters + other.parameters)


def _mixed(one: FloatArray, other: FloatArray, both: FloatArray, q: int) -> FloatArray:
    """Return Bayes factors over q axes, of which each takes either effect, both or none.

    With several axes that is one of the three parts of `joint_evidence`.
    """
    one, other, both = (np.exp(np.minimum(log, LARGEST_LOG / q)) for log in (one, other, both))
    if q == 1:
        return np.asarray(both[:, 0])
    return np.asarray(np.prod((1 + one + other + both) / 4, axis=1) / 3)


def refined(problem: SearchProblem, name: str, form: Form, left: Remainder) -> Form:
    """Return the likeliest of the forms near ``form``, where its effect knows nearer ones."""
    near = _near(problem, name, form)
    if not near:
        return form
    hypotheses = build([Hypothesis(name, one, 1.0) for one in near], left.rows, left.basis)
    if left.views.poses is not None:
        log_bf = log_bayes(hypotheses, left.views.columns)
        likely = joint_evidence(log_bf[:, :, np.newaxis], left.views)[:, 0]
    else:
        log_bf = log_bayes(hypotheses, left.views.columns[:, : left.views.axes])
        likely = log_bf.sum(axis=1)
    return hypotheses.members[int(np.argmax(likely))].form


def refined_courses(
    problem: SearchProblem, left: Remainder, forms: Mapping[str, Form]
) -> list[tuple[str, DialCourse]]:
    """Return the courses of those ``forms``, by effect, that have likelier ones near them.

    The name is of a refined form, so its rivals are too.
    """
    found = []
    for name, form in forms.items():
        finer = refined(problem, name, form, left)
        if finer is not form and isinstance(finer, Shape):
            searched = sum(not isinstance(value, str) for value in finer.parameters.values())
            found.append((name, course_beside(left.basis, finer.columns[left.rows], searched)))
    return found


def refined_members(
    problem: SearchProblem, forms: Mapping[str, Form], members: Sequence[Hypothesis]
) -> list[Hypothesis]:
    """Return the forms near the likeliest ones ``forms`` of the effects, which share their weight.

    Readings far beyond their scatter leave much of a course that lies between those of the grid.
    """
    weight = {id(member.form): member.weight for member in members}
    return [
        Hypothesis(name, one, weight.get(id(form), 0.0) / len(near))
        for name, form in forms.items()
        if (near := _near(problem, name, form))
        for one in near
    ]


def _near(problem: SearchProblem, name: str, form: Form) -> tuple[Form, ...]:
    if name not in problem.effects or not isinstance(form, Shape):
        return ()
    return problem.effects[name].near(problem.residual.conditions, form.parameters)
