"""RP of cycles that the fit did not see, beside what the completed model foretells of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from scara_iso.diagnosis.fit import Fit, fit
from scara_iso.diagnosis.gain.completed import foretold, scatter_draws
from scara_iso.diagnosis.gain.findings import repeatabilities
from scara_iso.diagnosis.problem import SearchProblem
from scara_iso.diagnosis.residual import Predicted
from scara_iso.diagnosis.result import SECOND, UnseenRP
from scara_iso.diagnosis.search import Stage, find_again
from scara_iso.diagnosis.tuning import FEWEST_CYCLES, UNKNOWN
from scara_iso.diagnosis.unexplained import learn
from scara_iso.run import IntArray, Run

Groups = Mapping[str, tuple[str, ...]]
"""The axes of each RP."""
Standing = Mapping[str, tuple[tuple[int, float], ...]]
"""The axes of the search that stand for those of each RP, and their slopes."""


def of_second_run(
    problem: SearchProblem,
    fitted: Fit,
    groups: Groups,
    standing: Standing,
    second: tuple[Run, Predicted | None],
    rng: np.random.Generator,
) -> UnseenRP:
    """Return RP of another run of the same axes, of its model's prediction, and foretold of it."""
    run, predicted = second
    drawn = scatter_draws(problem.residual, fitted, rng)
    told = foretold(problem, fitted, problem.effects, standing, drawn, rng, cycles=len(run))
    measured, before = _measured(run, predicted, np.arange(len(run)), groups)
    return UnseenRP(SECOND, len(run), measured, before, told)


def of_other_half(
    problem: SearchProblem,
    stages: Sequence[Stage],
    fitted: Fit,
    groups: Groups,
    standing: Standing,
    run: tuple[Run, Predicted | None],
    rng: np.random.Generator,
) -> UnseenRP | None:
    """Return RP of every other cycle, foretold by what is found anew in the rest of them.

    ``stages`` are those of the search in the whole run, which ``fitted`` holds.
    """
    n = len(problem.residual)
    seen, at = np.arange(0, n, 2), np.arange(1, n, 2)
    if len(at) < FEWEST_CYCLES:
        return None
    count = sum(term.effect != UNKNOWN for term in fitted.terms)
    chosen = [stage for stage in stages if stage.choice]
    changes = [stage.choice.log_change for stage in chosen if stage.choice]
    limits = [stage.limit for stage in chosen]
    terms = find_again(problem, seen, count, hidden=count, log_changes=changes, limits=limits)
    terms = (*terms, *learn(problem, terms, seen)) if count < len(fitted.terms) else terms
    known = fit(terms, problem.residual.values[seen], seen, n)
    drawn = scatter_draws(problem.residual, known, rng, seen)
    told = foretold(
        problem, known, problem.effects, standing, drawn, rng, cycles=len(at), seen=seen, at=at
    )
    return UnseenRP("every other cycle", len(at), *_measured(*run, at, groups), told)


def _measured(
    run: Run, predicted: Predicted | None, rows: IntArray, groups: Groups
) -> tuple[dict[str, float], dict[str, float]]:
    """Return RP of some rows as measured, and as the model predicts them."""
    read = {name: np.asarray(axis.readings)[rows] for name, axis in run.axes.items()}
    still = np.zeros(len(run))
    model = {name: np.asarray((predicted or {}).get(name, still))[rows] for name in read}
    return repeatabilities(read, groups), repeatabilities(model, groups)
