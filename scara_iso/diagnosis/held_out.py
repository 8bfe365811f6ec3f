"""Error on cycles that the fit did not see.

Cross-validation repeats the whole choice of effects inside each fold; with the effect fixed
beforehand it would flatter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.base.errors import DataError
from scara_iso.diagnosis.fit import Fit, Term, fit, log_bf_of_axes
from scara_iso.diagnosis.learned import learn
from scara_iso.diagnosis.marginal import ODD
from scara_iso.diagnosis.residual import Residual
from scara_iso.diagnosis.search import SearchProblem, Stage, find_again
from scara_iso.diagnosis.tuning import FOLDS, SHOWN, UNKNOWN
from scara_iso.effects import Shape
from scara_iso.run import FloatArray, IntArray


@dataclass(frozen=True, eq=False, slots=True)
class HeldOut:
    """Root mean square error on unseen cycles, shape (axes,): constant pose, and with effects."""

    before: FloatArray
    after: FloatArray


def cross_validated(
    problem: SearchProblem, fitted: Fit, stages: Sequence[Stage], rng: np.random.Generator
) -> HeldOut:
    """Return the error by 10-fold cross-validation of the search that gave ``fitted``.

    Each fold chooses anew what the ``stages`` of the whole run's search chose (`found_again`). That
    a fold's fit has fewer cycles than the whole run's is corrected for (Burman 1989, eq. 2.4): its
    excess over the whole fit, on all cycles, is taken off.
    """
    values, n = problem.residual.values, len(problem.residual)
    before, after = [], []
    for unseen in np.array_split(rng.permutation(n), min(FOLDS, n)):
        rows = np.delete(np.arange(n), unseen)
        pose = np.broadcast_to(values[rows].mean(axis=0), values.shape)
        terms = found_again(problem, fitted, stages, rows)
        predicted = fit(terms, values[rows], rows, n).predicted if terms else pose
        before.append(_excess(values, pose, unseen))
        after.append(_excess(values, predicted, unseen))
    whole = np.broadcast_to(values.mean(axis=0), values.shape)
    return HeldOut(_error(values, whole, before), _error(values, fitted.predicted, after))


def without_gain(problem: SearchProblem, fitted: Fit, unseen: HeldOut) -> tuple[Term, ...]:
    """Return the terms without the axes that hardly show them, where no unseen error falls either.

    A course that moves one axis shows on another by chance in one table of twenty. One axis stays.
    Single readings say nothing of unseen ones; several poses have their axes from the place.
    """
    falls, kept = unseen.after < unseen.before, list(fitted.terms)
    for i, term in enumerate(fitted.terms):
        if not term.columns.size or term.effect == ODD or term.located is not None:
            continue
        others = [one for one in kept if one is not term and one.columns.size]
        log_bf = log_bf_of_axes(term, others, problem.residual.values, problem.rows)
        moves = term.moves & (falls | (log_bf > np.log(SHOWN)))
        if moves.any():
            kept[i] = replace(term, moves=moves)
    return tuple(kept)


def found_again(
    problem: SearchProblem, fitted: Fit, stages: Sequence[Stage], rows: IntArray
) -> tuple[Term, ...]:
    """Return the terms of ``fitted`` chosen, and its course learned, anew on some rows of a run."""
    count = sum(term.effect != UNKNOWN for term in fitted.terms)
    terms = find_again(problem, rows, stages[:count])
    return (*terms, *learn(problem, terms, rows)) if count < len(fitted.terms) else terms


def _excess(values: FloatArray, predicted: FloatArray, unseen: IntArray) -> FloatArray:
    """Return mean squares on the unseen rows less those on all rows, shape (axes,)."""
    squares = (values - predicted) ** 2
    return np.asarray(squares[unseen].mean(axis=0) - squares.mean(axis=0))


def _error(values: FloatArray, predicted: FloatArray, excess: list[FloatArray]) -> FloatArray:
    """Return the error on unseen cycles; never below that on the fitted ones."""
    seen = ((values - predicted) ** 2).mean(axis=0)
    return np.asarray(np.sqrt(np.maximum(seen, seen + np.mean(excess, axis=0))))


def on_second_run(fitted: Fit, problem: SearchProblem, second: Residual) -> HeldOut:
    """Return the error on another run of the same axes, its pose left free.

    Times that were found in the first run are the same in seconds where both have a clock.
    What chance drew in the first run, and its accidents, say nothing about another run. Raises
    `DataError` where ``second`` lacks a column through which one of the effects acts.
    """
    first, now = problem.residual.conditions, second.conditions
    predicted = np.zeros_like(second.values)
    for term, coefficients in zip(fitted.terms, fitted.coefficients, strict=True):
        if not isinstance(term.form, Shape):
            continue
        effect, found = problem.effects[term.effect], term.form.parameters
        missing = {*effect.columns_needed(found)} - now.covariates.keys()
        if missing:
            raise DataError(
                f"the second table lacks {', '.join(sorted(missing))}, through which the "
                f"{term.effect} acts",
                remedy="hold out a run with the same columns",
            )
        known = effect.course(now, effect.at_pace(now, {**found, **effect.timed(first, found)}))
        if known is not None:
            predicted += known.columns @ coefficients
    before = second.values - second.values.mean(axis=0)
    after = second.values - predicted
    after = after - after.mean(axis=0)
    return HeldOut(np.sqrt((before**2).mean(axis=0)), np.sqrt((after**2).mean(axis=0)))
