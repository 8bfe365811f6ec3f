"""A sine that quickens is no change of sides, though its fast half looks like one."""

import numpy as np
import pytest

from scara_iso.diagnosis import UNKNOWN
from scara_iso.diagnosis.search import chosen, problem_of
from scara_iso.effects import find_effects
from scara_iso.run import Axis, Run

J = np.arange(30)
CHIRP = 3 * np.sin(2 * np.pi * (J / 30 + 2.5 * (J / 30) ** 2))


@pytest.mark.parametrize("seed", [4, 76])
def test_a_sine_that_quickens_has_no_sure_name(seed):
    scatter = np.random.default_rng(seed).normal(size=30)
    run = Run(J + 2, {"Z": Axis("Z", np.round(CHIRP + scatter), resolution=1.0)})
    problem = problem_of(run, directions={}, effects=find_effects())
    choice = chosen(problem, (), np.random.default_rng(1))[0].choice
    assert choice.probability[choice.best] < 0.9
    assert UNKNOWN in {choice.best, *(rival.effect for rival in choice.rivals)}
