"""What a strong smooth course leaves because no machine follows an equation to the last digit.

A machine that warms up has several time constants, and what one exponential leaves of it has an
order. That is no second effect: it lies among the effect's own courses, and is small beside the
first. It is taken off before more is sought, and is said as misfit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from scara_iso.diagnosis.fit import Term
from scara_iso.diagnosis.hypothesis_set import extended
from scara_iso.diagnosis.problem import Remainder, SearchProblem
from scara_iso.diagnosis.tuning import MISFIT_COURSES, MISFIT_LIKE, MOST_MISFIT
from scara_iso.effects import Shape
from scara_iso.run import FloatArray

_SEEN = 0.005
"""A course of its own has at least this share of the strongest one's singular value."""
_ERRORS = 3.0
"""So many variances of scatter an axis may show in each course without any misfit."""


def without_misfit(
    problem: SearchProblem, terms: Sequence[Term], left: Remainder
) -> tuple[Remainder, float]:
    """Return what is left beside the misfit of slow ``terms``, and its share of their size.

    The share is 0, and nothing is taken off, where no term is slow, where no more is left along
    courses like theirs than by chance, or more than a misfit may be.
    """
    courses = [
        _own_courses(term.effect, term.form, left)
        for term in terms
        if is_slow(problem, term) and isinstance(term.form, Shape)
    ]
    if not courses:
        return left, 0.0
    before = left.basis.shape[1]
    basis = extended(left.basis, np.concatenate(courses, axis=1))
    own = basis[:, before:]
    part = own @ (own.T @ left.values)
    beyond = left.values - part
    free = max(1, len(own) - basis.shape[1])
    chance = _ERRORS * own.shape[1] * (beyond**2).sum(axis=0) / free
    values = problem.residual.values[left.rows]
    whole = ((values - values.mean(axis=0) - left.values) ** 2).sum(axis=0)
    squares, most = (part**2).sum(axis=0), int(whole.argmax())
    too_large = np.any(squares > MOST_MISFIT**2 * whole + chance)
    if too_large or squares[most] <= chance[most]:
        return left, 0.0
    readings = replace(left.readings, values=beyond)
    views = problem.views_of(beyond, basis)
    rest = replace(left, basis=basis, values=beyond, readings=readings, views=views)
    return rest, float(np.sqrt(squares[most] / whole[most]))


def is_slow(problem: SearchProblem, term: Term) -> bool:
    """Return whether a term moves smoothly, by one course: a sine of another phase is no misfit."""
    effect, form = problem.effects.get(term.effect), term.form
    smooth = effect is not None and effect.smooth
    return smooth and isinstance(form, Shape) and form.columns.shape[1] == 1


def _own_courses(effect: str, form: Shape, left: Remainder) -> FloatArray:
    """Return the few courses (rows, k) that the effect's forms like this one are mixtures of."""
    found = _centred(form.columns[left.rows])
    alike = [
        columns
        for member in left.members
        if member.effect == effect and isinstance(member.form, Shape)
        for columns in [_centred(member.form.columns[left.rows])]
        if columns.shape == found.shape and np.linalg.norm(found.T @ columns, 2) > MISFIT_LIKE
    ]
    beside = left.basis @ left.basis.T
    free = np.concatenate([columns - beside @ columns for columns in alike] or [found[:, :0]], 1)
    vectors, sizes, _ = np.linalg.svd(free, full_matrices=False)
    seen = sizes > _SEEN * sizes.max(initial=0.0)
    return vectors[:, seen][:, :MISFIT_COURSES]


def _centred(columns: FloatArray) -> FloatArray:
    centred = columns - columns.mean(axis=0)
    return np.linalg.qr(centred)[0]
