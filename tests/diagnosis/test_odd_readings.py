"""`analyze` and `diagnose` agree on readings that lie far off: what one finds the other says."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

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
