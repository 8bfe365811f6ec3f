"""Which next cycles would tell rivals apart, by what the rivals foretell of them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t as student

from scara_iso.diagnosis.hypotheses import Hypothesis
from scara_iso.diagnosis.rivals import _foretold, right_after
from scara_iso.effects import Shape


def _course(name, n):
    """Return a hypothesis over n readings: a step at the fifth, or a drift."""
    course = {"step": np.arange(n) >= 4, "linear_drift": np.arange(n)}[name]
    return Hypothesis(name, Shape(1.0 * course[:, np.newaxis]), 1.0)


def test_more_cycles_tell_rivals_apart_as_far_as_what_they_foretell_differs():
    values = ((np.arange(8) >= 4) + 0.6 * np.sin(9 * np.arange(8.0)))[:, np.newaxis]
    even = {"step": 0.5, "linear_drift": 0.5}

    def right(*members):
        return right_after(values, even, members, np.random.default_rng(1))

    one, ten = (right(_course("step", 8 + m), _course("linear_drift", 8 + m)) for m in (1, 10))
    assert 0.55 < one < ten - 0.1
    step = _course("step", 18)
    assert right(step, replace(step, effect="linear_drift")) == pytest.approx(0.5)


def test_scatter_alone_foretells_what_a_prediction_interval_says(rng):
    values = rng.normal(2.0, 3.0, (12, 1))
    drawn = _foretold(values, np.eye(14), 4000, rng)
    assert drawn.shape == (4000, 2, 1)
    s = values.std(ddof=1) * (1 + 1 / 12) ** 0.5
    for share in (0.05, 0.5, 0.9):
        expected = values.mean() + s * student.ppf(share, 11)
        assert np.mean(drawn[:, 1] < expected) == pytest.approx(share, abs=0.03)
