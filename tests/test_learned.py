"""A learned course follows what is there and leaves the scatter, on courses of other equations."""

import numpy as np
import pytest

from scara_iso.diagnosis.readings import diagnose_readings
from scara_iso.run import Axis, Run

J = np.arange(30)
COURSES = {
    "chirp": np.sin(2 * np.pi * (J / 30 + 2.5 * (J / 30) ** 2)),
    "vee": 2 * np.abs(J - 15) / 15 - 1,
}


@pytest.mark.parametrize("name", COURSES)
def test_it_comes_near_the_truth_and_leaves_the_scatter(name):
    course, scatter = 15 * COURSES[name], 3.0
    rng = np.random.default_rng(1)
    readings = np.round(course + scatter * rng.normal(size=30)) / 1000
    found = diagnose_readings(Run(J + 2, {"X": Axis("X", readings, resolution=0.001)}), seed=1)
    assert found.learned is not None
    error = 1000 * np.asarray(found.series.predicted_after["X"]) - course
    assert np.std(error) < 0.4 * np.std(course)
    assert 0.5 * scatter < 1000 * found.scatter["X"] < 1.5 * scatter
