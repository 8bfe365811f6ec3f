"""`analyze` and `diagnose` agree on readings that lie far off: what one finds the other says."""

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

from scara_iso import analyze, diagnose
from scara_iso.run import Axis, Run

SCATTER = {
    "gaussian": lambda rng: rng.normal(size=30),
    "t5": lambda rng: rng.standard_t(5, size=30),
    "laplace": lambda rng: rng.laplace(size=30),
}


@pytest.mark.slow
@settings(max_examples=12)
@given(
    seed=st.integers(0, 10_000),
    scatter=st.sampled_from(sorted(SCATTER)),
    axes=st.integers(1, 3),
    odd=st.integers(0, 3),
    size=st.floats(4, 20),
)
@example(seed=488, scatter="laplace", axes=2, odd=2, size=16.0)
def test_what_analyze_finds_far_off_diagnose_does_not_pass_over(seed, scatter, axes, odd, size):
    rng = np.random.default_rng(seed)
    readings = {axis: 3 * SCATTER[scatter](rng) for axis in "XYZ"[:axes]}
    cycles = rng.choice(30, odd, replace=False)
    readings["X"][cycles] += 3 * size * rng.choice([-1, 1], odd)
    run = Run(
        np.arange(2, 32),
        {a: Axis(a, np.round(z) / 1000, resolution=0.001) for a, z in readings.items()},
        metadata={"first_cycle_discarded": "true"},
    )
    far = {f.axis for f in analyze(run).findings if f.code == "gross-reading"}
    found = diagnose(run)
    told = {axis for one in found.effects if one.effect == "outlier" for axis in one.axes}
    told |= {flag.axis for flag in found.flags}
    assert far <= told


@pytest.mark.parametrize("odd", [1, 2, 3, 4])
def test_a_dial_that_shows_one_value_but_for_some(odd):
    """All others are alike: they have no skewness."""
    readings = np.full(30, 0.5)
    readings[[3, 9, 14, 20][:odd]] += np.array([0.01, -0.008, 0.004, 0.001])[:odd]
    metadata = {"first_cycle_discarded": "true"}
    axis = Axis("X", readings.round(3), resolution=0.001)
    found = diagnose(Run(np.arange(2, 32), {"X": axis}, metadata=metadata))
    assert found.effects or found.flags


@pytest.mark.slow
def test_a_gross_reading_hides_no_course_of_the_others():
    found = 0
    for seed in range(20):
        rng, j = np.random.default_rng(seed), np.arange(30)
        moved = 13.5 * j / 29 if seed % 2 else 12.0 * (j > 12)
        readings = 3 * rng.normal(size=30) + moved
        readings[rng.integers(30)] += rng.choice([-1, 1]) * rng.uniform(30, 60)
        axis = Axis("X", np.round(readings) / 1000, resolution=0.001)
        metadata = {"first_cycle_discarded": "true"}
        named = {e.effect for e in diagnose(Run(j + 2, {"X": axis}, metadata=metadata)).effects}
        found += bool(named - {"outlier"})
    assert found == 20
