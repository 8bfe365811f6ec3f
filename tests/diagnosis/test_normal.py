"""The normal distribution function against scipy's."""

import numpy as np
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
from scipy.special import ndtr

from scara_iso.diagnosis.engine.rounded import normal_cdf


def test_it_is_scipys_over_the_whole_line():
    x = np.concatenate([np.linspace(-37, 37, 40_001), [0.0, -0.0, 1e-300, 1e300, -1e300]])
    np.testing.assert_allclose(normal_cdf(x), ndtr(x), rtol=1e-12, atol=0)


@given(arrays(np.float64, st.tuples(st.integers(0, 3), st.integers(0, 4)),
              elements=st.floats(-40, 40)))  # fmt: skip
def test_shapes_stay_and_both_tails_add_to_one(x):
    assert normal_cdf(x).shape == x.shape
    np.testing.assert_allclose(normal_cdf(x) + normal_cdf(-x), 1, rtol=0, atol=1e-15)
