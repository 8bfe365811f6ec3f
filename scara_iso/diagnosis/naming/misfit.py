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
from scara_iso.diagnosis.likelihood.hypothesis_set import extended
from scara_iso.diagnosis.problem import Remainder, SearchProblem
from scara_iso.diagnosis.tuning import (
    LEAST_OF_COURSES,
    MISFIT_BY_CHANCE,
    MISFIT_COURSES,
    MISFIT_LIKE,
    MOST_MISFIT,
)
from scara_iso.effects import Shape
from scara_iso.run import FloatArray


def without_misfit(
    problem: SearchProblem, terms: Sequence[Term], left: Remainder
) -> tuple[Remainder, float]:
    """Return what is left beside the misfit of slow ``terms``, and its share of their size.

    The share is 0, and nothing is taken off, where no term is slow, where no more is left along
    courses like theirs than by chance, or more than a misfit may be.
    """
    slow = [
        (term.effect, term.form.columns[left.rows])
        for term in terms
        if isinstance(term.form, Shape) and is_slow(problem, term)
    ]
    if not slow:
        return left, 0.0
    courses = [_own_courses(effect, found, left) for effect, found in slow]
    basis = extended(left.basis, np.concatenate(courses, axis=1))
    own = basis[:, left.basis.shape[1] :]
    part = own @ (own.T @ left.values)
    beyond = left.values - part
    free = max(1, len(own) - basis.shape[1])
    by_chance = MISFIT_BY_CHANCE * own.shape[1] * (beyond**2).sum(axis=0) / free
    share = _share(problem.residual.values[left.rows], left.values, part, by_chance)
    if not share:
        return left, 0.0
    readings = replace(left.readings, values=beyond)
    views = problem.views_of(beyond, basis)
    return replace(left, basis=basis, values=beyond, readings=readings, views=views), share


def is_slow(problem: SearchProblem, term: Term) -> bool:
    """Return whether a term moves smoothly, by one course: a sine of another phase is no misfit."""
    effect, form = problem.effects.get(term.effect), term.form
    smooth = effect is not None and effect.smooth
    return smooth and isinstance(form, Shape) and form.columns.shape[1] == 1


def _own_courses(effect: str, found: FloatArray, left: Remainder) -> FloatArray:
    """Return the few courses (rows, k) of which the effect's forms like ``found`` are mixtures."""
    forms = [m.form for m in left.members if m.effect == effect and isinstance(m.form, Shape)]
    columns = [form.columns[left.rows] for form in forms if form.columns.shape[1] == 1]
    courses = np.concatenate([found, *columns], axis=1)
    courses -= courses.mean(axis=0)
    courses /= np.maximum(np.linalg.norm(courses, axis=0), 1e-300)
    alike = courses[:, np.abs(courses[:, 0] @ courses) > MISFIT_LIKE]
    free = alike - left.basis @ (left.basis.T @ alike)
    vectors, sizes, _ = np.linalg.svd(free, full_matrices=False)
    return vectors[:, sizes > LEAST_OF_COURSES * sizes.max(initial=0.0)][:, :MISFIT_COURSES]


def _share(values: FloatArray, left: FloatArray, part: FloatArray, by_chance: FloatArray) -> float:
    """Return the size of ``part`` over that of the terms on the axis (axes,) that they move most.

    0 where it is within ``by_chance``, or on any axis more than a misfit may be.
    """
    whole = ((values - values.mean(axis=0) - left) ** 2).sum(axis=0)
    squares, most = (part**2).sum(axis=0), int(whole.argmax())
    too_large = np.any(squares > MOST_MISFIT**2 * whole + by_chance)
    small = squares[most] <= by_chance[most]
    return 0.0 if too_large or small else float(np.sqrt(squares[most] / whole[most]))
