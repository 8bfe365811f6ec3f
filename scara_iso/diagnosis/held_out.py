"""What the completed model says of cycles that the fit did not see: its error there, and their RP.

Cross-validation repeats the whole choice of effects inside each fold; with the effect fixed
beforehand it would flatter.

RP is that of tests drawn again and again: size and course within their uncertainty, scatter, by how
much a machine's scatter differs from run to run, where on the dial the pose comes to lie, and
rounding. Scatter is an effect of chance like others. Its size in each axis has the posterior of
rounded Gaussian readings about the fitted course, under the prior 1 / s; its correlation between
the axes is that of what is left. Accidents of one test are left out, and what chance drew is drawn
anew.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from scara_iso.base.errors import DataError
from scara_iso.base.quantities import Dimension, same_turn
from scara_iso.diagnosis.engine.evidence import constant, extended
from scara_iso.diagnosis.engine.fit import (
    Fit,
    HeldOut,
    SearchProblem,
    Term,
    fit,
    learn,
    log_bf_of_axes,
    row_scale,
)
from scara_iso.diagnosis.engine.hypotheses import ODD, of_visits
from scara_iso.diagnosis.engine.residual import Predicted, Residual, repeatabilities
from scara_iso.diagnosis.engine.rounded import scatters_on_dial
from scara_iso.diagnosis.engine.search import SHOWN, Stage, find_again
from scara_iso.diagnosis.result import SECOND, Foretold, UnseenRP
from scara_iso.diagnosis.verdict import FEWEST_CYCLES, UNKNOWN
from scara_iso.effects import Conditions, Effect, Process, Shape
from scara_iso.iso9283 import repeatability
from scara_iso.run import FloatArray, IntArray, Run

_CYCLES = 30
_DRAWS = 1000
_LIMITS = (0.025, 0.5, 0.975)

Groups = Mapping[str, tuple[str, ...]]
"""The axes of each RP."""
Standing = Mapping[str, FloatArray]
"""How the axes of each RP (k) move with those of the search, shape (k, axes)."""

FOLDS = 10

RUNS_DIFFER = 0.25
"""Standard deviation, in the logarithm, of the scatter between runs of one machine: RP of the next
run then lies in its interval as often as stated (benchmarks/study, null pairs)."""


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


def on_second_run(
    fitted: Fit, problem: SearchProblem, run: Run, expected: Predicted | None, now: Conditions
) -> HeldOut:
    """Return the error on another run of the same axes, with its prediction, its pose left free.

    Times that were found in the first run are the same in seconds where both have a clock.
    What chance drew in the first run, and its accidents, say nothing about another run. Raises
    `DataError` where that lacks an axis, or a column through which one of the effects acts.
    """
    first = problem.residual.conditions
    values = _left_by(run, expected or {}, problem.residual)
    predicted = np.zeros_like(values)
    for term, coefficients in zip(fitted.terms, fitted.coefficients, strict=True):
        if not isinstance(term.form, Shape):
            continue
        effect, found = problem.effects[term.effect], term.form.parameters
        known = {*now.covariates}.union(*now.visits.values())
        missing = {*effect.columns_needed(found)} - known
        if missing:
            raise DataError(
                f"the second table lacks {', '.join(sorted(missing))}, through which the "
                f"{term.effect} acts",
                remedy="hold out a run with the same columns",
            )
        form = _course_then(effect, term.form, first, now)
        if form is not None:
            predicted += replace(term, form=form).moved(coefficients)
    return HeldOut(values.std(axis=0), (values - predicted).std(axis=0))


def _course_then(effect: Effect, form: Shape, first: Conditions, now: Conditions) -> Shape | None:
    """Return the course that a form found under the ``first`` conditions has ``now``."""
    found = {**form.parameters, **effect.timed(first, form.parameters)}

    def course(conditions: Conditions) -> list[Shape]:
        known = effect.course(conditions, effect.at_pace(conditions, found))
        return [] if known is None else [known]

    again = course(now) if form.of is None else of_visits(course, now, form.of)
    return next(iter(again), None)


def _left_by(run: Run, expected: Predicted, first: Residual) -> FloatArray:
    missing = [name for name in first.axes if name not in run.axes]
    if missing:
        raise DataError(
            f"the second table lacks {', '.join(missing)}",
            where=run.origin.source,
            remedy="hold out a run of the same axes",
        )
    columns = []
    for name, seen in zip(first.axes, first.values.T, strict=True):
        axis = run.axes[name]
        column = axis.readings - np.asarray(expected.get(name, 0.0))
        columns.append(same_turn(column, seen) if axis.dimension is Dimension.ANGLE else column)
    return np.stack(columns, axis=1)


def foretold(
    problem: SearchProblem,
    fitted: Fit,
    standing: Standing,
    sigma: FloatArray,
    rng: np.random.Generator,
    *,
    cycles: int = _CYCLES,
    seen: IntArray | None = None,
    at: IntArray | None = None,
) -> dict[str, Foretold]:
    """Return RP that a new test of so many ``cycles`` would have, by figure.

    ``sigma`` (draws, axes) is the `scatter_draws`. ``seen`` are the rows that the fit knows, all
    unless given; ``at`` the ``cycles`` rows whose courses the new test takes.
    """
    residual = problem.residual
    n, axes = residual.values.shape
    rows = np.tile(np.arange(n) if at is None else at, (_DRAWS, 1))
    if rows.shape[1] != cycles:  # neighbours together: sides that alternate stay even
        first = rng.integers(n - 1, size=(_DRAWS, -(-cycles // 2)))
        rows = np.stack([first, first + 1], axis=2).reshape(_DRAWS, -1)[:, :cycles]
    known = problem.rows if seen is None else seen
    course = _course(problem, fitted, known, sigma, rng) + residual.moved
    width = row_scale(fitted.terms, n) * np.ones(axes)
    width /= np.sqrt((width**2).mean(axis=0))
    left = np.linalg.cholesky(_correlation((residual.values - fitted.predicted)[known]))
    noise = rng.normal(size=(_DRAWS, cycles, axes)) @ left.T * sigma[:, np.newaxis]
    if at is None:  # another run
        noise = noise * np.exp(RUNS_DIFFER * rng.normal(size=(_DRAWS, 1, 1)))
    each = np.arange(_DRAWS)[:, np.newaxis]
    shown = course[each, rows] + noise * width[rows]
    offset = rng.uniform(-0.5, 0.5, size=(_DRAWS, 1, axes))
    division = residual.division
    steps = np.rint(shown / np.where(division > 0, division, 1.0) + offset) * division
    read = np.where(division > 0, steps, shown)
    found = {}
    for name, weights in standing.items():
        positions = weights @ np.swapaxes(read, 1, 2)
        low, value, high = np.quantile(repeatability(positions).RP, _LIMITS)
        found[name] = Foretold(float(value), (float(low), float(high)))
    return found


def _course(
    problem: SearchProblem, fitted: Fit, seen: IntArray, sigma: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Return draws of the course (draws, n, axes): what repeats, and what chance draws anew."""
    n, axes = problem.residual.values.shape
    basis, error = constant(n), sigma[:, np.newaxis] * (n / len(seen)) ** 0.5
    course = np.zeros((_DRAWS, n, axes))
    for term, coefficients in zip(fitted.terms, fitted.coefficients, strict=True):
        if isinstance(term.form, Process):
            course += _drawn(term.form, sigma, rng) * term.moves
        elif isinstance(term.form, Shape):
            effect = problem.effects[term.effect]
            columns = effect.in_new_tests(term.form, seen, _DRAWS, rng)
            if not columns.any():
                continue
            free = extended(basis, term.columns)[:, basis.shape[1] :]
            of_free = np.linalg.lstsq(term.columns - term.columns.mean(axis=0), free, rcond=1e-9)[0]
            chance = rng.normal(size=(_DRAWS, free.shape[1], axes)) * error
            columns = columns - columns.mean(axis=1, keepdims=True)
            course += term.moved(coefficients, columns)
            course += columns @ (of_free @ chance) * term.moves
    return course


def _drawn(form: Process, sigma: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return random courses (draws, n, axes) of a process beside scatter sigma (draws, axes)."""
    covariance = form.covariance
    root = np.linalg.cholesky(covariance + 1e-9 * np.trace(covariance) * np.eye(len(covariance)))
    drawn = np.einsum("nm,dma->dna", root, rng.normal(size=(_DRAWS, len(root), sigma.shape[1])))
    return np.asarray(drawn * sigma[:, np.newaxis])


def _correlation(left: FloatArray) -> FloatArray:
    """Return that of what is left (n, axes), a little towards none so that it has a root."""
    free = left - left.mean(axis=0)
    scaled = free / np.maximum(np.linalg.norm(free, axis=0), 1e-300)
    return np.asarray(0.98 * scaled.T @ scaled + np.diag(1 - 0.98 * (scaled**2).sum(axis=0)))


def scatter_draws(
    residual: Residual, fitted: Fit, rng: np.random.Generator, seen: IntArray | None = None
) -> FloatArray:
    """Return draws (draws, axes) of each axis' standard deviation beside effects and rounding.

    ``seen`` are the rows that the fit knows, all unless given. Rounding is part of what a reading
    shows beside the known courses, of scatter and random course together.
    """
    shown = _beside_scatter(fitted)
    left = (residual.values - fitted.predicted) * fitted.wider * shown
    division = residual.division
    left = left if seen is None else left[seen]
    n, axes = left.shape
    numbers = sum(
        (part != 0).any(axis=0) * len(c)
        for part, c in zip(fitted.parts, fitted.coefficients, strict=True)
    ) + np.zeros(axes)
    found = []
    for a in range(axes):
        power = (n - numbers[a]) / n
        if division[a]:
            grid, weight = scatters_on_dial(left[:, a] / division[a], power)
            found.append(division[a] * rng.choice(grid, size=_DRAWS, p=weight))
        else:
            squares = float(((left[:, a] - left[:, a].mean()) ** 2).sum())
            freedom = max(n - 1 - numbers[a], 1)
            found.append(np.sqrt(squares / rng.chisquare(freedom, size=_DRAWS)))
    return np.stack(found, axis=1) / shown


def _beside_scatter(fitted: Fit) -> FloatArray:
    """Return how many times as wide as scatter (axes,) it is together with the random courses."""
    n, variance = len(fitted.predicted), np.ones(fitted.predicted.shape[1])
    for term in fitted.terms:
        if isinstance(term.form, Process):
            drawn = term.form.covariance
            variance += term.moves * (drawn.trace() - drawn.mean() * n) / max(1, n - 1)
    return np.sqrt(variance)


def unseen_rp(
    problem: SearchProblem,
    stages: Sequence[Stage],
    fitted: Fit,
    groups: Groups,
    standing: Standing,
    run: tuple[Run, Predicted | None],
    second: tuple[Run, Predicted | None] | None,
    rng: np.random.Generator,
) -> UnseenRP | None:
    """Return RP of a ``second`` run with its prediction, and as foretold of it.

    Without one it is that of every other cycle of the ``run``, foretold by what is found anew in
    the rest of them; None of too few. ``stages`` are those of the search that gave ``fitted``.
    """
    n, (shown, predicted) = len(problem.residual), second or run
    of, rows, seen, at = SECOND, np.arange(len(shown)), None, None
    if second is None:
        of, rows, seen = "every other cycle", np.arange(1, n, 2), np.arange(0, n, 2)
        if len(rows) < FEWEST_CYCLES:
            return None
        at, values = rows, problem.residual.values[seen]
        fitted = fit(found_again(problem, fitted, stages, seen), values, seen, n)
    drawn = scatter_draws(problem.residual, fitted, rng, seen)
    told = foretold(problem, fitted, standing, drawn, rng, cycles=len(rows), seen=seen, at=at)
    read = {name: np.asarray(axis.readings)[rows] for name, axis in shown.axes.items()}
    still = np.zeros(len(shown))
    model = {name: np.asarray((predicted or {}).get(name, still))[rows] for name in read}
    measured, before = (repeatabilities(one, groups) for one in (read, model))
    return UnseenRP(of, len(rows), measured, before, told)
