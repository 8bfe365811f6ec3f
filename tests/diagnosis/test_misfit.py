"""What strong smooth courses leave: a misfit that is said, and effects beside it that are found."""

import numpy as np
import pytest

from scara_iso.diagnosis.readings import diagnose_readings
from scara_iso.run import Axis, Run

J = np.arange(30)
WARM = 1 - np.exp(-J / 5)
TWO_TIMES = 0.6 * (1 - np.exp(-J / 2)) + 0.4 * (1 - np.exp(-J / 12))


def diagnosed(course, seed=3):
    scatter = np.random.default_rng(seed).normal(size=30)
    run = Run(J + 2, {"Z": Axis("Z", np.round(course + scatter), resolution=1.0)})
    return diagnose_readings(run)


def misfits(diagnosis):
    return [note for note in diagnosis.notes if note.startswith("misfit")]


def test_two_time_constants_are_one_warm_up_and_a_misfit():
    found = diagnosed(200 * TWO_TIMES)
    assert [one.effect for one in found.effects] == ["warm_up"]
    (said,) = misfits(found)
    assert "the course of warm up differs from its equation by 9%" in said


def test_a_course_that_follows_its_equation_has_no_misfit():
    found = diagnosed(200 * WARM)
    assert [one.effect for one in found.effects] == ["warm_up"]
    assert not misfits(found)


@pytest.mark.parametrize(
    ("course", "second"),
    [(200 * WARM + 1.5 * (-1.0) ** J, "contact_side"),
     (200 * WARM + 3 * np.sin(2 * np.pi * J / 6), "periodic")],
)  # fmt: skip
def test_what_is_no_such_course_is_found_however_small_it_is_beside_the_first(course, second):
    assert [one.effect for one in diagnosed(course).effects] == ["warm_up", second]
