"""What is stated of names that hidden states would explain, and a course of no name as well."""

import numpy as np
import pytest

from scara_iso.diagnosis import UNKNOWN
from scara_iso.diagnosis.problem import problem_of
from scara_iso.diagnosis.search import chosen
from scara_iso.diagnosis.tuning import UNDECIDED, UNSURE
from scara_iso.effects import find_effects
from scara_iso.run import Axis, Run

J = np.arange(30)
CHIRP = 3 * np.sin(2 * np.pi * (J / 30 + 2.5 * (J / 30) ** 2))


@pytest.mark.parametrize(("seed", "most"), [(4, UNSURE), (76, UNDECIDED)])
def test_a_sine_that_quickens_is_no_change_of_sides_for_sure(seed, most):
    """Its fast half looks like one; sides are drawn by chance, and so is a course of no name."""
    scatter = np.random.default_rng(seed).normal(size=30)
    run = Run(J + 2, {"Z": Axis("Z", np.round(CHIRP + scatter), resolution=1.0)})
    problem = problem_of(run, directions={}, effects=find_effects())
    choice = chosen(problem, (), np.random.default_rng(1))[0].choice
    assert choice.best == "contact_side"
    assert choice.posterior["contact_side"] > 0.8
    assert choice.probability["contact_side"] <= most
    assert UNKNOWN in {rival.effect for rival in choice.rivals}
