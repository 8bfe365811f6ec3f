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
from scara_iso.run import FloatArray, IntArray

FOLDS = 10
REPEATS = 2


@dataclass(frozen=True, eq=False, slots=True)
class HeldOut:
    """Root mean square error on unseen cycles, shape (axes,): constant pose, and with effects."""

    before: FloatArray
    after: FloatArray


def cross_validated(
    problem: Problem,
    fitted: Fit,
    rng: np.random.Generator,
    *,
    with_chains: bool,
    repeats: int = REPEATS,
) -> HeldOut:
    """Return the error by repeated 5-fold cross-validation of the search that gave ``fitted``.

    Each fold chooses anew as many effects as the whole run's tests admitted. That a fold's fit
    has fewer cycles than the whole run's is corrected for (Burman 1989, eq. 2.4): its excess over
    the whole fit, on all cycles, is taken off.
    """
    values, n = problem.residual.values, len(problem.residual)
    before, after = [], []
    for _ in range(repeats):
        for unseen in np.array_split(rng.permutation(n), FOLDS):
            rows = np.setdiff1d(np.arange(n), unseen)
            pose = np.broadcast_to(values[rows].mean(axis=0), values.shape)
            terms = find_again(problem, rows, len(fitted.terms), with_chains=with_chains)
            predicted = fit(terms, values[rows], rows, n).predicted
            before.append(_excess(values, pose, unseen))
            after.append(_excess(values, predicted, unseen))
    whole = np.broadcast_to(values.mean(axis=0), values.shape)
    return HeldOut(_error(values, whole, before), _error(values, fitted.predicted, after))


def _excess(values: FloatArray, predicted: FloatArray, unseen: IntArray) -> FloatArray:
    """Return mean squares on the unseen rows less those on all rows, shape (axes,)."""
    squares = (values - predicted) ** 2
    return np.asarray(squares[unseen].mean(axis=0) - squares.mean(axis=0))


def _error(values: FloatArray, predicted: FloatArray, excess: list[FloatArray]) -> FloatArray:
    """Return the error on unseen cycles; never below that on the fitted ones."""
    seen = ((values - predicted) ** 2).mean(axis=0)
    return np.asarray(np.sqrt(np.maximum(seen, seen + np.mean(excess, axis=0))))


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
