"""From a run and a prediction to a verdict, the error before and after, and what stays unexplained.

Readings of one axis beside the effects found are y = m + f + e, e scatter of variance s^2 and f a
Gaussian process of covariance s^2 K, K one of the covariances of unknown form. The K of the largest
marginal likelihood (m flat, s profiled) is taken (`fit.learn`); f is then the conditional mean
K (K + I)^-1 y, and its covariance s^2 (K - K (K + I)^-1 K) (Rasmussen and Williams 2006, eq. 2.23
and 2.24). It has no name and no cause, is told in words, and on cycles left out it is interpolated.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby, pairwise

import numpy as np

from scara_iso.diagnosis.engine.fit import Fit, HeldOut, SearchProblem, Term, fit, learn, problem_of
from scara_iso.diagnosis.engine.hypotheses import ODD
from scara_iso.diagnosis.engine.residual import Predicted, Residual, groups_of, repeatabilities
from scara_iso.diagnosis.engine.search import Stage, find, is_slow
from scara_iso.diagnosis.findings import UNSURE, courses_of_axes, found_effects, shares_of, shown_by
from scara_iso.diagnosis.held_out import (
    cross_validated,
    foretold,
    on_second_run,
    scatter_draws,
    unseen_rp,
    without_gain,
)
from scara_iso.diagnosis.result import (
    Diagnosis,
    Error,
    Errors,
    Flag,
    Found,
    Learned,
    LearnedCourse,
    Repeatabilities,
    Series,
    Shares,
    UnexplainedCourse,
)
from scara_iso.diagnosis.verdict import SEED, UNKNOWN, Rival, Verdict
from scara_iso.effects import Conditions, Effect, Process, find_effects
from scara_iso.iso9283 import TREND_LEVEL, far_readings, holm, mann_kendall, median
from scara_iso.run import FloatArray, IntArray, Run

FLAG_LEVEL = 0.01
"""Level at which a reading is flagged, in Gaussian scatter."""

MUCH_ROUNDING = 0.2
"""Share of the variance from which rounding is worth a line."""

SAME_SCATTER = 1.6
"""Factor between a stated scatter and the remaining one that thirty readings can account for."""

_TWO_SIDED = 2.0
"""Standard deviations of a band of 95 %, to the digits that a band has."""
_LAST = 5
"""The last fifth of the cycles is predicted from those before it."""
_TURN = 0.2
"""A turn is worth a word from this share of the course's range."""
_LEVEL, _LONG = 0.1, 0.2
"""The first or last tenth of a rise that takes this share of the cycles is no rise yet."""
_MOST_PARTS = 5
_STAYS = "stays level"


def diagnose_readings(
    run: Run,
    predicted: Predicted | None = None,
    *,
    seed: int = SEED,
    held_out: Run | None = None,
    held_out_predicted: Predicted | None = None,
    directions: Mapping[str, Mapping[str, float]] | None = None,
    effects: Sequence[Effect] | None = None,
    sigma: Mapping[str, float] | None = None,
) -> Diagnosis:
    """Return what a model leaves unexplained in a run, which effect it is, and what is gained.

    ``run`` holds one pose without the discarded cycle (`scara_iso.diagnose` applies the cycle rule
    to a table); ``predicted`` is the model's readings by
    axis, None for a constant pose (a constant is always free: an indicator has no absolute zero).
    ``directions`` names how far each axis moves, such as ``{"joint 1": {"X": .., "Y": ..}}``.
    ``held_out`` is a second run for the error on unseen cycles; without it that is
    cross-validated. ``effects`` is the catalogue unless given. ``sigma`` is the standard deviation
    of the readings of some axes where nothing acts, known from elsewhere (as from 30 readings): it
    sharpens the naming, not the tests. Same arguments, same result.

    Raises `DataError` for fewer than 8 cycles or more than 500, several poses, no axis that
    moves, a prediction that does not belong to the run, or a sigma that is not positive.
    """
    run = run.unwrapped()
    catalogue = {e.name: e for e in (find_effects() if effects is None else effects)}
    known = tuple(catalogue.values())
    problem = problem_of(run, predicted, directions=directions or {}, effects=known, sigma=sigma)
    second = None
    if held_out is not None:
        other = held_out.unwrapped()
        second = other, held_out_predicted, Conditions(other.cycle, other.covariates)
    groups = groups_of(run.axes)
    return diagnose_problem(problem, run, predicted, groups, seed=seed, second=second)[0]


def diagnose_problem(
    problem: SearchProblem,
    run: Run,
    predicted: Predicted | None,
    groups: Mapping[str, tuple[str, ...]],
    *,
    seed: int,
    second: tuple[Run, Predicted | None, Conditions] | None = None,
) -> tuple[Diagnosis, Fit]:
    """Return what was found in the problem that a run is, and its fit; see `diagnose_readings`.

    ``groups`` are the axes of each RP by name; ``second`` is a run held out, its prediction and
    conditions.
    """
    rng, residual = np.random.default_rng(seed), problem.residual
    terms, stages = find(problem, rng)
    unexplained = (verdict := verdict_of(terms, stages)) is Verdict.UNEXPLAINED
    course = unexplained and stages[-1].on_levels < 0
    learned = learn(problem, terms, problem.rows) if course else ()
    fitted = fit((*terms, *learned), residual.values, problem.rows, len(run))
    if second is None:
        unseen = cross_validated(problem, fitted, stages, rng)
    else:
        unseen = on_second_run(fitted, problem, *second)
    fitted = fit(without_gain(problem, fitted, unseen), residual.values, problem.rows, len(run))
    shown = shown_by(run, predicted or {}, residual)
    courses = courses_of_axes(run, predicted or {}, residual, fitted, shown)
    drawn = scatter_draws(residual, fitted, rng)
    standing = {name: np.stack([shown[a] for a in axes]) for name, axes in groups.items()}
    next_test = foretold(problem, fitted, standing, drawn, rng)
    own = (run, predicted)
    other = unseen_rp(problem, stages, fitted, groups, standing, own, second and second[:2], rng)
    measured, before, after, removed = (repeatabilities(c, groups) for c in courses)
    effects = found_effects(problem, fitted, stages, unseen)
    nameless, said = learned_courses(residual, fitted)
    diagnosis = Diagnosis(
        verdict=verdict,
        effects=effects,
        candidates=_candidates(stages) if unexplained else (),
        p_value=stages[0].p_value,
        p_value_at_floor=stages[0].p_value_at_floor,
        error=_errors(residual, fitted, unseen),
        shares=shares_of(residual, fitted),
        notes=tuple(_notes(problem, terms, stages, fitted, seed)),
        flags=tuple(_flags(run, residual, stages, fitted, effects)),
        repeatability=Repeatabilities(measured, before, after, removed, next_test, other),
        scatter=_named(residual, median(drawn)),
        courses=said,
        learned=nameless,
        series=_series(run, residual, courses),
    )
    return diagnosis, fitted


def _series(run: Run, residual: Residual, courses: Sequence[Mapping[str, FloatArray]]) -> Series:
    units = {name: axis.unit for name, axis in run.axes.items()}
    return Series(residual.conditions.cycle, courses[0], courses[1], courses[2], units)


def _candidates(stages: Sequence[Stage]) -> tuple[Rival, ...]:
    choice = stages[-1].choice
    return (choice.ranked[0], *choice.rivals) if choice else ()


def _notes(
    problem: SearchProblem, terms: Sequence[Term], stages: Sequence[Stage], fitted: Fit, seed: int
) -> Iterator[str]:
    """Yield what could not be searched or told, and by how much courses miss their equations."""
    yield from problem.residual.notes
    if verdict_of(terms, stages) is Verdict.NOTHING:
        yield from _moved(problem.residual)
    if (a := stages[-1].on_levels) >= 0:
        where = [*problem.residual.axes, "a direction between the axes"][a]
        many = {3: "three", 4: "four", 5: "five"}[stages[-1].marginal.levels]
        yield (
            f"{where} lies on {many} levels in no order: are poses mixed, or are there {many} "
            "places where a joint comes to rest?"
        )
    yield from _coarse(shares_of(problem.residual, fitted))
    if stages[-1].misfit:
        courses = " and ".join(t.effect.replace("_", " ") for t in terms if is_slow(problem, t))
        share = f"{stages[-1].misfit:.0%} of its size; that much does not count as a second effect"
        yield f"misfit: the course of {courses} differs from its equation by {share}"
    yield from _stated_otherwise(problem, seed)
    if len(fitted.terms) > len(terms):
        yield from last_cycles(problem, terms)


def _moved(residual: Residual) -> Iterator[str]:
    """Yield the axes that `analyze` calls moved where all hypotheses together find no order."""
    tested = list(map(mann_kendall, residual.values.T))
    found = holm(tested, TREND_LEVEL, len(tested))
    for name, p, moves in zip(residual.axes, tested, found, strict=True):
        if moves:
            yield f"{name} alone moves with the cycles (Mann-Kendall p = {p:.1g}): repeat the test"


def verdict_of(terms: Sequence[Term], stages: Sequence[Stage]) -> Verdict:
    """Return what a search ends with: it may leave structure that no effect accounts for."""
    if stages[0].choice is None:
        return Verdict.NOTHING
    is_course = bool(terms) and isinstance(terms[-1].form, Process)
    explained = is_course or stages[-1].choice is None
    return Verdict.EXPLAINED if explained else Verdict.UNEXPLAINED


def _errors(residual: Residual, fitted: Fit, unseen: HeldOut) -> Errors:
    def error(predicted: FloatArray, held_out: FloatArray) -> Error:
        rms = np.sqrt(((residual.values - predicted) ** 2).mean(axis=0))
        return Error(_named(residual, rms), _named(residual, held_out))

    mean = residual.values.mean(axis=0)
    return Errors(error(mean, unseen.before), error(fitted.predicted, unseen.after))


def _named(residual: Residual, values: FloatArray) -> dict[str, float]:
    return dict(zip(residual.axes, map(float, values), strict=True))


def _flags(
    run: Run, residual: Residual, stages: Sequence[Stage], fitted: Fit, effects: Sequence[Found]
) -> Iterator[Flag]:
    """Yield the readings to look at: rare in Gaussian scatter, or far off to the analysis.

    The analysis sees the readings themselves; on an axis that an effect moves, what it leaves.
    Where that is no sure name, it sees both: two far readings in a row may pass for another level.
    """
    marginal = stages[-1].marginal
    p, at_floor = marginal.gaussian_outlier, marginal.gaussian_outlier <= marginal.floor
    far = set()
    if p <= FLAG_LEVEL:
        far.add((residual.axes[marginal.outlier_axis], marginal.outlier_row))
    moved = np.flatnonzero(np.any([term.moves for term in fitted.terms], axis=0))
    left = {residual.axes[a]: residual.values[:, a] - fitted.predicted[:, a] for a in moved}
    doubtful = (one for one in effects if one.probability <= UNSURE and one.effect != ODD)
    seen = {*run.axes} - {*left} | {axis for one in doubtful for axis in one.axes}
    for name, readings in (*((name, run.axes[name].readings) for name in seen), *left.items()):
        far |= {(name, k) for k in far_readings(readings, run.axes[name].resolution)}
    yield from (Flag(axis, int(run.cycle[row]), p, at_floor) for axis, row in sorted(far))


def _coarse(shares: Mapping[str, Shares]) -> list[str]:
    coarse = {a: one.resolution for a, one in shares.items() if one.resolution > MUCH_ROUNDING}
    if not coarse:
        return []
    said = ", ".join(f"{share:.0%}" for share in coarse.values())
    return [f"{', '.join(coarse)}: {said} of the variance is the dial's rounding: use a finer one"]


def _stated_otherwise(problem: SearchProblem, seed: int) -> list[str]:
    """Return a note for each axis whose scatter, where none is stated, is not the stated one."""
    if not np.any(problem.sigma):
        return []
    values = problem.residual.values
    terms = find(replace(problem, sigma=0.0), np.random.default_rng(seed))[0]
    fitted = fit(terms, values, problem.rows, len(values))
    left = (values - fitted.predicted).std(axis=0, ddof=1) * fitted.wider
    by_axis = zip(problem.residual.axes, left, left * 0 + problem.sigma, strict=True)
    return [
        f"{axis}: scatter {scatter:.3g}, not {stated:.3g} as stated: leave the stated one out"
        for axis, scatter, stated in by_axis
        if stated and not 1 / SAME_SCATTER < scatter / stated < SAME_SCATTER
    ]


def learned_courses(
    residual: Residual, fitted: Fit
) -> tuple[Learned | None, tuple[UnexplainedCourse, ...]]:
    """Return the learned courses of a fit, each about its mean, and in words; None without any.

    The words are of the whole course, the effects found included: that is what the readings do.
    """
    courses, said, cycle = {}, [], residual.conditions.cycle
    for term, part in zip(fitted.terms, fitted.parts, strict=True):
        if term.effect == UNKNOWN and isinstance(term.form, Process):
            a = int(np.flatnonzero(term.moves)[0])
            left = residual.values[:, a] - fitted.predicted[:, a]
            u = _uncertainty(term.form.covariance, float(left.std(ddof=1) * fitted.wider[a]))
            value = part[:, a] - part[:, a].mean()
            low, high = (value - _TWO_SIDED * u).tolist(), (value + _TWO_SIDED * u).tolist()
            band = tuple(zip(low, high, strict=True))
            courses[residual.axes[a]] = LearnedCourse(cycle, value, band)
            words = in_words(fitted.predicted[:, a], cycle)
            said.append(UnexplainedCourse(residual.axes[a], words))
    return Learned(courses) if courses else None, tuple(said)


def _uncertainty(K: FloatArray, scatter: float) -> FloatArray:
    """Return the standard deviation (n,) of a course about its mean, given the readings."""
    given = K - K @ np.linalg.solve(K + np.eye(len(K)), K)
    about_mean = given - given.mean(axis=0) - given.mean(axis=1)[:, np.newaxis] + given.mean()
    return np.asarray(scatter * np.sqrt(np.maximum(np.diag(about_mean), 0.0)))


def last_cycles(problem: SearchProblem, terms: Sequence[Term]) -> Iterator[str]:
    """Yield how well the last cycles follow from a course learned of those before them."""
    residual = problem.residual
    n, last = len(residual), len(residual) // _LAST
    rows = np.arange(n - last)
    learned = learn(problem, terms, rows)
    if not learned:
        return
    values = residual.values
    with_it, without = (
        np.sqrt(((values - fit(own, values[rows], rows, n).predicted)[-last:] ** 2).mean(axis=0))
        for own in ((*terms, *learned), terms)
    )
    said = "; ".join(
        f"{residual.axes[a]} {with_it[a]:.2g}, without it {without[a]:.2g}"
        for term in learned
        for a in np.flatnonzero(term.moves)
    )
    yield (
        f"cycles to come: error on the last {last} by a course learned of those before them {said}"
    )


def in_words(smooth: FloatArray, cycle: IntArray) -> str:
    """Return what a smooth course (n,) does over the cycles (n,), empty where it does nothing."""
    if not np.ptp(smooth):
        return ""
    parts = [part for a, b in pairwise(_turns(smooth)) for part in _parts(smooth, a, b)]
    if len(parts) > _MOST_PARTS:
        swings = sum(verb != _STAYS for verb, _ in parts)
        return f"goes up and down, {swings} times in {len(smooth)} cycles"
    return _said([[*same][-1] for _, same in groupby(parts, lambda part: part[0])], cycle)


def _turns(smooth: FloatArray) -> list[int]:
    """Return both ends, and the rows between at which the course turns by a share of its range."""
    least = _TURN * np.ptp(smooth)
    turns, farthest, direction = [0], 0, 0.0
    for i in range(1, len(smooth)):
        beyond = smooth[i] - smooth[farthest]
        if direction * beyond > 0:
            farthest = i
        elif abs(beyond) >= least:
            turns += [farthest] if direction else []
            direction, farthest = np.sign(beyond), i
    return [*turns, len(smooth) - 1]


def _parts(smooth: FloatArray, first: int, last: int) -> list[tuple[str, int]]:
    """Return what the course does between two turns, and the row up to which."""
    change = smooth[last] - smooth[first]
    if abs(change) < _TURN * np.ptp(smooth):
        return [(_STAYS, last)]
    share = (smooth[first : last + 1] - smooth[first]) / change
    begins = first + int(np.flatnonzero(share >= _LEVEL)[0])
    ends = first + int(np.flatnonzero(share <= 1 - _LEVEL)[-1]) + 1
    long = _LONG * len(smooth)
    before = [(_STAYS, begins)] if begins - first >= long else []
    after = [(_STAYS, last)] if last - ends >= long else []
    return [*before, ("rises" if change > 0 else "falls", ends if after else last), *after]


def _said(parts: list[tuple[str, int]], cycle: IntArray) -> str:
    (verb, last), *others = parts
    if not others:
        return f"{verb} all the time"
    said = [f"{verb} in the first {last + 1} cycles"]
    said += [f"{verb} until cycle {cycle[row]}" for verb, row in others[:-1]]
    return f"{', '.join(said)}, then {others[-1][0]}"
