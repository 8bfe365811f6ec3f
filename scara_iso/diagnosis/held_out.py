"""Error on cycles that the fit did not see.

Cross-validation repeats the whole choice of effects inside each fold; with the effect fixed
beforehand it would flatter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scara_iso.diagnosis.bank import Member
from scara_iso.diagnosis.fit import Fit, Term, fit
from scara_iso.diagnosis.residual import Residual
from scara_iso.diagnosis.search import Problem, find_again
from scara_iso.effects import Shape
from scara_iso.run import FloatArray

FOLDS = 5
REPEATS = 4


@dataclass(frozen=True, eq=False, slots=True)
class HeldOut:
    """Root mean square error on unseen cycles, shape (axes,): constant pose, and with effects."""

    before: FloatArray
    after: FloatArray


def cross_validated(
    problem: Problem,
    critical: Sequence[float],
    rng: np.random.Generator,
    *,
    with_chains: bool,
    repeats: int = REPEATS,
) -> HeldOut:
    """Return the error by repeated 5-fold cross-validation of the whole search.

    ``critical`` are the statistics that each stage has to exceed, see `find_again`; none: the
    model after is the model before.
    """
    values, n = problem.residual.values, len(problem.residual)
    before, after = np.zeros(values.shape[1]), np.zeros(values.shape[1])
    folds = [fold for _ in range(repeats) for fold in np.array_split(rng.permutation(n), FOLDS)]
    for unseen in folds:
        rows = np.setdiff1d(np.arange(n), unseen)
        before += ((values[unseen] - values[rows].mean(axis=0)) ** 2).sum(axis=0)
        if critical:
            terms = find_again(problem, rows, critical, with_chains=with_chains)
            predicted = fit(terms, values[rows], rows, n).predicted
            after += ((values[unseen] - predicted[unseen]) ** 2).sum(axis=0)
    count = repeats * n
    after = after if critical else before
    return HeldOut(np.sqrt(before / count), np.sqrt(after / count))


def on_second_run(fitted: Fit, members: Sequence[Member], second: Residual) -> HeldOut:
    """Return the error on another run of the same axes, its pose left free.

    ``members`` are those of the second run's conditions. Courses that belong to the first run's
    readings (sides of contact, single readings, random walks) say nothing about another run.
    """
    predicted = sum(
        (
            _transferred(t, c, members)
            for t, c in zip(fitted.terms, fitted.coefficients, strict=True)
        ),
        np.zeros_like(second.values),
    )
    before = second.values - second.values.mean(axis=0)
    after = second.values - predicted
    after = after - after.mean(axis=0)
    return HeldOut(np.sqrt((before**2).mean(axis=0)), np.sqrt((after**2).mean(axis=0)))


def _transferred(term: Term, coefficients: FloatArray, members: Sequence[Member]) -> FloatArray:
    for member in members:
        match member.form, term.form:
            case Shape(columns, parameters), Shape(parameters=fitted) if (
                member.effect == term.effect and member.ordered and parameters == fitted
            ):
                return np.asarray(columns @ coefficients)
    return np.zeros(coefficients.shape[1])
