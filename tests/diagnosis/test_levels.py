"""Courses of several levels, against every course that there is."""

from itertools import combinations

import numpy as np
import pytest

from scara_iso.diagnosis import UNKNOWN
from scara_iso.diagnosis.likelihood.evidence import log_bayes
from scara_iso.diagnosis.naming.off_the_grid import best_changes, several_levels, with_levels
from scara_iso.diagnosis.problem import problem_of, remainder
from scara_iso.diagnosis.tuning import FEWEST_ON_A_LEVEL
from scara_iso.effects import find_effects
from scara_iso.run import Axis, Run

N = 21
DIAL = np.full(2, 0.5)
BUMP = 6.0 * np.repeat([0.0, 1.0, 2.2, 0.5], [5, 6, 4, 6])


def left(*courses):
    axes = {name: Axis(name, y, resolution=1.0) for name, y in zip("XY", courses, strict=False)}
    run = Run(np.arange(2, N + 2), axes)
    problem = problem_of(run, directions={}, effects=find_effects())
    return remainder(problem, (), problem.rows)


def within(y, changes):
    """Return the sum of squares about the means of the parts of ``y`` (n, axes)."""
    return sum(((part - part.mean(axis=0)) ** 2).sum() for part in np.split(y, changes))


@pytest.mark.parametrize("levels", [3, 4])
def test_the_best_course_of_all(rng, levels):
    y = rng.normal(size=(N, 1))
    every = [
        changes
        for changes in combinations(range(1, N), levels - 1)
        if np.diff([0, *changes, N]).min() >= FEWEST_ON_A_LEVEL
    ]
    found = {len(changes) + 1: changes for changes in best_changes(y, DIAL[:1], levels)}
    assert tuple(found[levels]) == min(every, key=lambda changes: within(y, changes))


def test_too_few_readings_for_several_levels(rng):
    short = rng.normal(size=(4 * FEWEST_ON_A_LEVEL - 1, 1))
    assert [len(changes) for changes in best_changes(short, DIAL[:1], 4)] == [2]
    assert not list(best_changes(short[: 3 * FEWEST_ON_A_LEVEL - 1], DIAL[:1], 4))


def test_an_axis_that_never_moves_changes_nothing(rng):
    y = BUMP + rng.normal(size=N)
    for half in (DIAL, np.zeros(2)):
        alone = best_changes(y[:, np.newaxis], half[:1], 4)
        beside = best_changes(np.column_stack([np.zeros(N), y]), half, 4)
        for changes, same in zip(alone, beside, strict=True):
            np.testing.assert_array_equal(same, changes)


def test_levels_off_the_grid_of_changes_are_met(rng):
    found = left(np.round(BUMP + rng.normal(size=N)), np.round(rng.normal(size=N) - 0.5 * BUMP))
    four = several_levels(found, N)[-1]
    assert four.effect == UNKNOWN
    assert list(four.form.parameters.values()) == [5, 11, 15]
    every = with_levels(found.hypotheses, found, N)
    assert len(every.members) == len(found.hypotheses.members) + 2
    likeliest = every.members[int(log_bayes(every, found.views.columns)[:, 0].argmax())]
    assert likeliest.form.parameters == four.form.parameters
