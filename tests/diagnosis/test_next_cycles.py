"""Which next cycles would tell rivals apart, by what the rivals foretell of them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t as student

from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis
from scara_iso.diagnosis.readings import diagnose_readings
from scara_iso.diagnosis.rivals import _foretold, right_after
from scara_iso.effects import Shape
from scara_iso.run import Axis, Run


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


def loaded(payload):
    """Return a run of an arm that yields by 2.5 scatters under the payload."""
    scatter = np.random.default_rng(8).normal(size=34)[: len(payload)]
    readings = np.round(0.003 * (1.25 * payload + scatter), 3)
    cycle = np.arange(len(payload)) + 2
    axis = Axis("X", readings, resolution=0.001)
    return Run(cycle, {"X": axis}, covariates={"payload_kg": payload})


def test_the_payload_that_is_advised_tells_compliance_from_a_warm_up():
    payload = np.repeat([0.0, 2.0], 15)
    before = diagnose_readings(loaded(payload))
    assert before.effects[0].effect == "warm_up"
    (said,) = [note for note in before.notes if "apart" in note]
    assert said.startswith("payload_kg 0 in the next 4 cycles would tell rivals apart")
    after = diagnose_readings(loaded(np.append(payload, np.zeros(4))))
    assert (after.effects[0].effect, after.effects[0].rivals) == ("compliance", ())
    assert not any("apart" in note for note in after.notes)
