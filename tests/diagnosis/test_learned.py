"""A learned course follows what is there and leaves the scatter, on courses of other equations."""

from pathlib import Path

import numpy as np
import pytest

import scara_iso
from scara_iso.commands import main
from scara_iso.diagnosis.readings import diagnose_readings
from scara_iso.robot import predict, read_model
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


EXAMPLE = Path(__file__).parents[2] / "examples" / "unexplained.csv"
MODEL = Path(__file__).parents[2] / "examples" / "fum_scara.toml"


@pytest.fixture(scope="module")
def example():
    return scara_iso.diagnose(EXAMPLE, model=MODEL)


def test_what_it_leaves_is_no_less_than_half_of_the_error_on_unseen_cycles(example):
    """A smoother with half as many degrees of freedom as readings leaves about half of it."""
    error = example.error.after
    assert {"X", "Y"} <= set(example.learned.axes)
    for axis in example.learned.axes:
        assert error.rms[axis] > 0.4 * error.held_out_rms[axis]


def test_a_model_file_holds_it_and_predicts_it(example, tmp_path, capsys):
    saved = tmp_path / "new.toml"
    words = ["diagnose", str(EXAMPLE), "--model", str(MODEL), "--save-model", str(saved)]
    assert main(words) == 0
    run = scara_iso.read_table(EXAMPLE)
    before, after = (predict(read_model(path), run) for path in (MODEL, saved))
    for axis, learned in example.learned.axes.items():
        rows = np.isin(run.cycle, learned.cycle)
        moved = (after.axes[axis].readings - before.axes[axis].readings)[rows]
        np.testing.assert_allclose(moved - moved.mean(), learned.value, atol=2e-6)


@pytest.mark.parametrize(
    ("wrong", "what"),
    [
        ('axis = "X"\ncycle = [1, 2]\nvalue = [0.1]\nu = [0.1, 0.1]', "learned 1"),
        ('axis = "Q"\ncycle = [1, 2]\nvalue = [0.1, 0.2]\nu = [0.1, 0.1]', "learned 1"),
        ('axis = "X"\ncycle = [2, 1]\nvalue = [0.1, 0.2]\nu = [0.1, 0.1]', "learned 1"),
        ('axis = "X"\ncycle = [1, 2]\nvalue = [0.1, nan]\nu = [0.1, 0.1]', "learned 1"),
    ],
)
def test_a_course_that_is_none_is_refused_with_its_place(wrong, what, tmp_path):
    path = tmp_path / "model.toml"
    path.write_text(MODEL.read_text("utf-8") + f"\n[[learned]]\n{wrong}\n", "utf-8")
    with pytest.raises(scara_iso.DataError, match=what):
        read_model(path)
