"""Two effects at once: together they may be likelier than any one course, known or not.

Effects are found one after another, and two at once may look like neither of them: like a course of
no name, or a random one. Before that is said, pairs of known shapes are weighed too, each counted
for the stronger of the two; the next round then finds the other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from scara_iso.diagnosis.likelihood.evidence import (
    LARGEST_LOG,
    Views,
    joint_evidence,
    log_bayes,
    log_bayes_amplified,
)
from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis
from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet, build, extended
from scara_iso.diagnosis.likelihood.rounded import DialCourse, course_beside, course_of
from scara_iso.diagnosis.naming.choice import Weighed
from scara_iso.diagnosis.tuning import (
    AMPLITUDES,
    PAIR_EFFECTS,
    PAIR_FORMS,
    PAIR_WEIGHT,
    UNKNOWN,
)
from scara_iso.effects import Shape
from scara_iso.run import FloatArray, IntArray


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
