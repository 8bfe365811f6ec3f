"""What the found effects amount to: parameters, directions, repeatability, shares of variance."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import compress

import numpy as np

from scara_iso.base.quantities import rounding_uncertainty
from scara_iso.diagnosis.engine.evidence import build, log_bayes_of_course, log_evidence_by_effect
from scara_iso.diagnosis.engine.fit import Fit, HeldOut, SearchProblem, Term, fitted_basis
from scara_iso.diagnosis.engine.hypotheses import FEWEST_MOVED, ODD, SIZE_AT
from scara_iso.diagnosis.engine.residual import TWO_DIVISIONS, Predicted, Residual
from scara_iso.diagnosis.engine.search import STEP, Stage, is_slow
from scara_iso.diagnosis.result import ByAxis, Found, ParameterValue, Shares
from scara_iso.diagnosis.verdict import UNKNOWN, Choice, Rival
from scara_iso.effects import Effect, Process, Shape, Spread
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, Run

FEWEST_PERIODS = 2.5
"""Fewer periods are surely no sine: two bumps pass for two of them (ablation.py)."""

TURNS_BACK = -0.25
"""Correlation of a random course with itself one cycle later, below which it turns back at each: an
alternation from mid-run on and negative memory are overcorrection to 0.9 and above in 13 of 16
tables else."""

FITS_BETTER = 3.0
"""Bayes factor of another effect on one of several axes, from which no name is sure for them."""

FARTHEST_DEG = 15.0
"""Degrees beyond which no direction is named, however wide the uncertainty."""

UNSURE = 0.89
"""The most that is stated of a name that no evidence makes sure: not 90 %, from which a name stands
alone."""


def shown_by(run: Run, predicted: Predicted, residual: Residual) -> dict[str, FloatArray]:
    """Return how far each axis of a run moves with those of the search, weights (axes,).

    An axis that copies another follows that one; one that never moves follows none.
    """
    values = residual.values - residual.values.mean(axis=0)
    shown = {}
    for name, axis in run.axes.items():
        left = axis.readings - np.asarray(predicted.get(name, 0.0))
        slopes = (left - left.mean()) @ values / (values**2).sum(axis=0)
        own = np.array([name == one for one in residual.axes])
        nearest = np.abs(slopes) * np.linalg.norm(values, axis=0)
        copied = np.where(np.arange(len(own)) == nearest.argmax(), slopes, 0.0)
        shown[name] = own.astype(np.float64) if own.any() else copied
    return shown


def courses_of_axes(
    run: Run, predicted: Predicted, residual: Residual, fitted: Fit, shown: Mapping[str, FloatArray]
) -> tuple[dict[str, FloatArray], ...]:
    """Return by axis: measured, predicted before and after, measured with effects removed."""
    measured = {name: np.asarray(axis.readings) for name, axis in run.axes.items()}
    before, after, removed = {}, {}, {}
    level = residual.values.mean(axis=0)
    left = residual.values - fitted.predicted
    gone = sum(fitted.parts, np.zeros_like(left)) - (fitted.cured - 1) * left
    for name, readings in measured.items():
        model = np.asarray(predicted.get(name, np.zeros(len(run))), dtype=np.float64)
        before[name] = model + (readings - model).mean()
        beside = 0.0 if name in residual.axes else before[name] - model - level @ shown[name]
        after[name] = model + beside + fitted.predicted @ shown[name]
        removed[name] = readings - gone @ shown[name]
    return measured, before, after, removed


def match(
    movement: FloatArray, uncertainty: FloatArray, directions: Mapping[str, FloatArray]
) -> tuple[str | None, dict[str, float]]:
    """Return which of the ``directions`` the ``movement`` of the axes (axes,) has, and the angles.

    Those are between it and each [deg]. ``uncertainty`` (axes,) are standard errors. The nearest
    direction is named if the movement lies along it within its uncertainty and within 15 degrees,
    and along no other; with one axis nothing can be told.
    """
    if len(movement) < 2 or not directions or not np.any(movement):
        return None, {}
    angles = {name: _angle(movement, along) for name, along in directions.items()}
    fitting = [
        name
        for name, along in directions.items()
        if angles[name] <= FARTHEST_DEG and _agrees(movement, uncertainty, along)
    ]
    return fitting[0] if len(fitting) == 1 else None, angles


def _angle(movement: FloatArray, along: FloatArray) -> float:
    lengths = float(np.linalg.norm(movement) * np.linalg.norm(along))
    cosine = abs(float(movement @ along)) / lengths if lengths else 0.0
    return float(np.degrees(np.arccos(min(1.0, cosine))))


def _agrees(movement: FloatArray, uncertainty: FloatArray, along: FloatArray) -> bool:
    """Whether what is left across ``along`` is within twice its expectation (chi-squared)."""
    sigma = np.maximum(uncertainty, 1e-12)
    size = float((movement * along / sigma**2).sum() / (along**2 / sigma**2).sum())
    misfit = float((((movement - size * along) / sigma) ** 2).sum())
    freedom = len(movement) - 1
    return bool(misfit <= freedom + 3 * np.sqrt(2 * freedom))


def found_effects(
    problem: SearchProblem, fitted: Fit, stages: Sequence[Stage], unseen: HeldOut
) -> tuple[Found, ...]:
    """Return what was found, one for each term with a name, in the order of the search.

    ``unseen`` is the error on unseen cycles.
    """
    left = (problem.residual.values - fitted.predicted) * fitted.wider
    return tuple(
        _found(problem, fitted, i, stages, left, unseen)
        for i, term in enumerate(fitted.terms)
        if term.effect != UNKNOWN
    )


def shares_of(residual: Residual, fitted: Fit) -> dict[str, Shares]:
    """Return, for each axis, whose share of the variance of the readings is whose."""
    total = residual.values.var(axis=0, ddof=1)
    left = ((residual.values - fitted.predicted) * fitted.cured).var(axis=0, ddof=1)
    rounding = np.array([rounding_uncertainty(division) ** 2 for division in residual.division])
    unexplained = np.clip(left / total, 0.0, 1.0)
    resolution = np.minimum(rounding / total, unexplained)
    return {
        name: Shares(float(1 - u), float(r), float(u - r))
        for name, u, r in zip(residual.axes, unexplained, resolution, strict=True)
    }


def _found(
    problem: SearchProblem,
    fitted: Fit,
    i: int,
    stages: Sequence[Stage],
    left: FloatArray,
    unseen: HeldOut,
) -> Found:
    term, stage, residual = fitted.terms[i], stages[i], problem.residual
    effect = problem.effects[term.effect]
    assert stage.choice is not None  # noqa: S101 - a term stands for the choice of its stage
    errors = _standard_errors(fitted, i, left)
    joint, angles = None, dict[str, float]()
    if term.located is None:
        joint, angles = match(*_movement(fitted.coefficients[i], errors), problem.directions)
    probability, rivals = stage.choice.probability[effect.name], stage.choice.rivals
    alone = _is_alone(problem, fitted, i) and not (stages[-1].misfit and is_slow(problem, term))
    if not alone or _is_unsure(term, effect, joint, residual, left, unseen):
        probability, rivals = unsure(probability, rivals)
    if other := _fits_better(problem, fitted, i):
        probability, rivals = unsure(probability, rivals, other)
    if effect.needs and _is_one_step(term):
        probability, rivals = unsure(probability, rivals, STEP)
    return Found(
        effect=effect.name,
        units={p.name: p.unit for p in effect.parameters}
        | {p.in_seconds: "s" for p in effect.parameters if p.timed},
        axes=tuple(compress(residual.axes, term.moves)),
        joint=joint,
        angles=angles,
        parameters=_parameters(term, fitted.coefficients[i], residual, effect, left),
        standard_errors={
            **({"size": _by_axis(errors[0], residual, term)} if len(errors) else {}),
            **_sizes_at(term, residual, errors),
        },
        p_value=stage.p_value,
        p_value_at_floor=stage.p_value_at_floor,
        probability=probability,
        rivals=rivals,
        cause=effect.cause,
        confirm_by=effect.confirm_by,
        unidentified=_unidentified(stage.choice, effect, term, residual),
        share=_share(residual, fitted, i),
        left_open=_left_open(term, residual, effect, left),
    )


def _fits_better(problem: SearchProblem, fitted: Fit, i: int) -> str:
    """Return the effect that fits one of the axes of a term far better by itself; empty for none.

    The axis that shows the term most has decided its name. A random course takes one of its own on
    every axis: so may the other effect, and fits all of them together better.
    """
    term, rows = fitted.terms[i], problem.rows
    if term.located is not None or isinstance(term.form, Spread) or term.moves.sum() == 1:
        return ""
    values = problem.residual.values - fitted.predicted + fitted.parts[i]
    basis = fitted_basis((), rows)
    views = replace(problem, sigma=0.0).views_of(values, basis)
    compared = [m for m in problem.members if isinstance(m.form, Shape) or m.effect == term.effect]
    every = log_evidence_by_effect(build(compared, rows, basis), views)
    random = every.pop(term.effect, np.zeros(views.axes))
    least = math.log(FITS_BETTER)
    if isinstance(term.form, Shape):
        own = log_bayes_of_course(term.form.columns[rows], basis, values)
        beyond = np.where(term.moves & (own < own.max()), own, np.inf) + least
        better = {name: float(np.max(found - beyond)) for name, found in every.items()}
    else:
        better = {
            name: float((found - random)[term.moves].sum()) - least for name, found in every.items()
        }
    best = max(better, key=lambda name: better[name], default="")
    return best if best and better[best] > 0 and term.effect != ODD else ""


def _is_alone(problem: SearchProblem, fitted: Fit, i: int) -> bool:
    """Return whether all that a term leaves on its axes is scatter, as far as order tells.

    Two courses over the cycles are as likely one of a form that no effect has. Those through a
    recorded column are no guess, odd readings and a change of scatter no course.
    """

    def is_course(term: Term) -> bool:
        effect = problem.effects.get(term.effect)
        recorded = effect is not None and bool(effect.needs)
        return not recorded and term.effect != ODD and not isinstance(term.form, Spread)

    own, *others = (fitted.terms[i], *fitted.terms[:i], *fitted.terms[i + 1 :])
    beside = (other for other in others if is_course(other))
    return not is_course(own) or not any((other.moves & own.moves).any() for other in beside)


def _is_unsure(
    term: Term,
    effect: Effect,
    direction: str | None,
    residual: Residual,
    left: FloatArray,
    unseen: HeldOut,
) -> bool:
    """Return whether no evidence makes a name sure.

    One edge between divisions that is crossed says little of how. Two levels show no contact by
    themselves: only a movement along one joint does. What turns back from each cycle to the next
    may be a correction, sides by turns, or a fast vibration. Wide scatter in which a cycle tells of
    the next is a course that fades. Fewer than two periods are no sine.
    And where the error on unseen cycles does not fall, a course is no more than a guess; single
    readings say nothing of others, and scatter moves no mean.
    """
    form, crossed = term.form, TWO_DIVISIONS * residual.division
    if isinstance(form, Spread):
        return _is_ordered(left[form.scale == form.scale.max()][:, term.moves])
    size = np.ptp(residual.values, axis=0)
    if term.effect == ODD:
        free = np.abs(residual.values - median(residual.values, axis=0))
        size = free[term.columns.any(axis=1)].max(axis=0)
    if (size < crossed)[term.moves].all():
        return True
    if effect.by_flank and not effect.needs:
        one_dial = int(term.moves.sum()) < 2  # which may move by itself
        joint = term.located.place.joint if term.located else None if one_dial else direction
        return joint is None
    if not isinstance(form, Shape):
        return isinstance(form, Process) and bool(
            np.trace(form.unit, offset=1) < TURNS_BACK * np.trace(form.unit)
        )
    if len(residual) < FEWEST_PERIODS * float(form.parameters.get("period", 0)):
        return True
    squares = [(error[term.moves] ** 2).sum() for error in (unseen.before, unseen.after)]
    moved = int((form.columns != median(form.columns, axis=0)).any(axis=1).sum())
    return bool(moved >= FEWEST_MOVED and squares[1] >= squares[0])


def _is_one_step(term: Term) -> bool:
    """Say whether a course changes once: through a recorded column as a step there would be."""
    return int(np.diff(term.columns, axis=0).any(axis=1).sum()) == 1


def _is_ordered(values: FloatArray) -> bool:
    """Say whether readings (n, axes) tell of those that follow them, by two standard errors."""
    free = values - values.mean(axis=0)
    together = (free[1:] * free[:-1]).sum(axis=0) / np.maximum((free**2).sum(axis=0), 1e-300)
    return bool((np.abs(together) > 2 / math.sqrt(len(values))).any())


def _share(residual: Residual, fitted: Fit, i: int) -> dict[str, float]:
    """Return the share of variance that goes with the course of one effect, by axis.

    What effects of alike courses share counts half for each.
    """
    every = sum(fitted.parts, np.zeros_like(residual.values))
    part = fitted.parts[i] - fitted.parts[i].mean(axis=0)
    together = (part * (every - every.mean(axis=0))).sum(axis=0)
    total = ((residual.values - residual.values.mean(axis=0)) ** 2).sum(axis=0)
    return _by_axis(together / total, residual, fitted.terms[i])


def _parameters(
    term: Term, coefficients: FloatArray, residual: Residual, effect: Effect, left: FloatArray
) -> dict[str, ParameterValue]:
    form = term.form
    match form:
        case Shape():
            sizes: dict[str, dict[str, float]] = {}
            for a in np.flatnonzero(term.moves):
                for name, value in effect.linear.sizes(coefficients[:, a]).items():
                    sizes.setdefault(name, {})[residual.axes[a]] = value
            seconds = effect.timed(residual.conditions, form.parameters)
            odd = _odd_cycles(term, residual) if effect.name == ODD else []
            cycles = {"cycles": tuple(sorted(odd))} if odd else {}
            of_each = _sizes_at(term, residual, coefficients)
            return {**form.parameters, **cycles, **seconds, **sizes, **of_each}
        case Spread():
            return dict(form.parameters)
        case Process():
            size = left.std(axis=0, ddof=1) * form.variance**0.5
            return {**form.parameters, effect.size_name: _by_axis(size, residual, term)}
        case _:
            return {}


def _odd_cycles(term: Term, residual: Residual) -> list[int]:
    return [int(residual.conditions.cycle[rows][0]) for rows in term.columns.T != 0]


def _sizes_at(term: Term, residual: Residual, values: FloatArray) -> dict[str, ByAxis]:
    """Return ``values`` (columns, axes) of several odd readings by cycle; none of a single one."""
    if term.effect != ODD or len(values) < 2:
        return {}
    cycles = _odd_cycles(term, residual)
    return {
        f"{SIZE_AT}{cycles[k]}": _by_axis(values[k], residual, term) for k in np.argsort(cycles)
    }


def _left_open(
    term: Term, residual: Residual, effect: Effect, left: FloatArray
) -> dict[str, ByAxis]:
    """Return the scatter (of what is ``left``) where a term that changes it is narrowest."""
    if not isinstance(term.form, Spread):
        return {}
    narrowest = left[term.form.scale == term.form.scale.min()]
    return {effect.size_name: _by_axis(narrowest.std(axis=0, ddof=1), residual, term)}


def _standard_errors(fitted: Fit, i: int, left: FloatArray) -> FloatArray:
    """Return standard errors (k, axes) of a term's coefficients, free of the other terms."""
    columns, others = fitted.terms[i].columns, (*fitted.terms[:i], *fitted.terms[i + 1 :])
    basis = fitted_basis(others, np.arange(len(left)))
    free = columns - basis @ (basis.T @ columns)
    nu = max(1, len(left) - basis.shape[1] - len(fitted.coefficients[i]))
    scatter = np.sqrt((left**2).sum(axis=0) / nu)
    located = fitted.terms[i].located
    if located is not None and located.place.tied:
        sizes = np.sqrt(((left @ located.weights) ** 2).sum(axis=0) / nu)
        scatter = np.linalg.norm(located.place.movement * sizes, axis=1)
    size = np.maximum(np.linalg.norm(free, axis=0), 1e-12)
    form = fitted.terms[i].form
    if form.of is not None:
        return np.asarray([scatter / size[form.of[: len(scatter)]]])
    return np.asarray(np.outer(1 / size, scatter))


def _movement(coefficients: FloatArray, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the axes' movement (axes,) and its standard error.

    Of several columns (sine and cosine) the principal one.
    """
    if not len(coefficients):
        return np.zeros(0), np.zeros(0)
    _, _, along = np.linalg.svd(coefficients, full_matrices=False)
    size = float(np.linalg.norm(coefficients @ along[0]))
    return along[0] * size, errors.max(axis=0)


def _by_axis(values: FloatArray, residual: Residual, term: Term) -> dict[str, float]:
    return dict(compress(zip(residual.axes, values.tolist(), strict=True), term.moves))


def _unidentified(
    choice: Choice, effect: Effect, term: Term, residual: Residual
) -> tuple[str, ...]:
    rivals = {rival.effect for rival in choice.rivals}
    lines = [line for rival, line in effect.unsettled.items() if rival in rivals]
    if UNKNOWN in rivals:
        lines.append("the course may have a form that the catalogue does not hold; repeat the run")
    two = np.ptp(residual.values, axis=0) < TWO_DIVISIONS * residual.division
    coarse = [residual.axes[a] for a in np.flatnonzero(two & term.moves)]
    if coarse:
        lines.append(
            f"size: only two neighbouring divisions in {', '.join(coarse)}; what moved may be less "
            "than one of them, and a slow drift looks like a step: use a finer indicator"
        )
    return tuple(lines)


def unsure(
    probability: float, rivals: tuple[Rival, ...], other: str = UNKNOWN
) -> tuple[float, tuple[Rival, ...]]:
    """Return a probability of at most UNSURE, and rivals of which the ``other`` takes the rest."""
    if probability <= UNSURE:
        return probability, rivals
    known = tuple(rival for rival in rivals if rival.effect != other)
    rest = max(1 - UNSURE - sum(rival.probability for rival in known), probability - UNSURE)
    every = (*known, Rival(other, rest))
    return UNSURE, tuple(sorted(every, key=lambda rival: -rival.probability))
