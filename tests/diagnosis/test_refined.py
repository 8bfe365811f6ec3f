"""Rivals are refined as the name is: a sine between two periods of the grid is near its rivals."""

import numpy as np
import pytest

from scara_iso.diagnosis.naming.off_the_grid import refined_courses
from scara_iso.diagnosis.problem import problem_of, remainder
from scara_iso.diagnosis.search import chosen
from scara_iso.effects import find_effects
from scara_iso.run import Axis, Run

READINGS = [
    -8, -8, 8, 12, 11, 13, 5, 12, 4, -16, -5, -9, -9, -10, -8, 13, 13, 14, 11, 14, 7, -1, -12, -8,
]  # fmt: skip
"""A flattened sine of period 12.4, between two periods of the grid."""


def problem(y):
    run = Run(np.arange(2, len(y) + 2), {"X": Axis("X", np.array(y, dtype=float), resolution=1.0)})
    return problem_of(run, directions={}, effects=find_effects())


def test_no_name_is_sure_beside_a_sine_between_the_periods_of_the_grid():
    choice = chosen(problem(READINGS), (), np.random.default_rng(1))[0].choice
    assert choice.best == "contact_side"
    assert choice.posterior["contact_side"] > 0.95
    assert choice.near("contact_side")["periodic"] < 4
    assert choice.probability["contact_side"] <= 0.89
    assert "periodic" in {rival.effect for rival in choice.rivals}


@pytest.mark.parametrize("period", [4.37, 6.7, 9.1])
def test_a_course_between_those_of_the_grid_fits_better(period, rng):
    j = np.arange(30)
    searched = problem(np.round(40 * np.sin(2 * np.pi * j / period) + rng.normal(size=30)))
    forms = {m.effect: m.form for m in searched.members if m.effect == "periodic"}
    grid = [m.form for m in searched.members if m.effect == "periodic"]
    y = searched.residual.values[:, 0] - searched.residual.values[:, 0].mean()

    def left(columns):
        both = np.column_stack([np.ones(30), columns])
        return float(((y - both @ np.linalg.lstsq(both, y, rcond=None)[0]) ** 2).sum())

    nearest = min(grid, key=lambda form: left(form.columns))
    found = refined_courses(searched, remainder(searched, (), searched.rows), {"periodic": nearest})
    ((name, course),) = found
    assert name == "periodic"
    assert course.parameters == 1
    assert left(course.columns) < left(nearest.columns) < left(forms["periodic"].columns)
