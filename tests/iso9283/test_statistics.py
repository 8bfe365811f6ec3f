"""RP and its interval against the formulas of docs/repeatability.md, summed up in plain Python."""

import math
from statistics import mean, stdev

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
from oracles.scatter import Z, lengths, limits, rp, rss, three_sigma
from scipy import integrate, stats

from scara_iso.iso9283.core.statistics import (
    GAUSSIAN_ERROR,
    GAUSSIAN_RP,
    hidden,
    median,
    repeatability,
    root_sum_of_squares,
    rp_interval,
    rss_interval,
    standard_deviation,
    three_sigma_interval,
    two_divisions,
)

X = [0.0, 1.0, 4.0, 2.5, -3.0, 0.5, 1.5, -1.0, 0.25]
Y = [2.0, -1.0, 0.0, 3.5, 1.0, -2.0, 0.5, 0.75, -0.25]


def test_one_axis_and_a_plane_are_eq_2_to_6_of_distances():
    for components in ([X], [X, Y], [X, Y, X[::-1]]):
        found = repeatability(np.array(components))
        distance = lengths(components)
        assert found.n == 9
        np.testing.assert_allclose(found.mean, [mean(values) for values in components])
        assert found.l_bar == pytest.approx(mean(distance))
        assert found.S_l == pytest.approx(stdev(distance))
        assert found.RP == pytest.approx(mean(distance) + 3 * stdev(distance))


@pytest.mark.parametrize("components", [1, 2, 3])
def test_rp_of_gaussian_scatter_and_its_error(components):
    length = stats.chi(components)
    mu, sigma = length.mean(), length.std()
    assert GAUSSIAN_RP[components] == pytest.approx(mu + 3 * sigma, abs=5.1e-6)
    influence = length.expect(lambda x: (x - mu + 1.5 * ((x - mu) ** 2 - sigma**2) / sigma) ** 2)
    error = math.sqrt(influence) / (mu + 3 * sigma)
    assert GAUSSIAN_ERROR[components] == pytest.approx(error, abs=5.1e-6)


def test_far_from_zero_no_digit_is_lost():
    """A millimetre of scatter at ten kilometres, read to a nanometre."""
    near, far = np.array([X]) * 1e-3, np.array([X]) * 1e-3 + 2.0**23
    assert repeatability(far).RP == pytest.approx(float(repeatability(near).RP), rel=1e-5)
    assert repeatability(far).mean == pytest.approx(2.0**23 + mean(X) * 1e-3, rel=1e-15)
    assert standard_deviation(far)[0] == pytest.approx(stdev(X) * 1e-3, rel=1e-5)


def test_poses_in_front_are_kept():
    poses = np.array([[[X, Y], [Y, X]], [[X, X], [Y, Y]], [[X[::-1], Y], [Y[::-1], X]]])
    found = repeatability(poses)
    assert found.mean.shape == (3, 2, 2)
    assert found.RP.shape == found.l_bar.shape == found.S_l.shape == (3, 2)
    lower, upper = rp_interval(poses, resolutions=None)
    for p in range(3):
        for q in range(2):
            one = poses[p, q].tolist()
            assert found.RP[p, q] == pytest.approx(rp(one))
            expected = limits(rp, GAUSSIAN_RP[2], GAUSSIAN_ERROR[2], one)
            assert (lower[p, q], upper[p, q]) == pytest.approx(expected)


def test_eq_23_is_the_root_of_the_sum_of_the_axes_squares():
    assert root_sum_of_squares(np.array([X, Y])) == pytest.approx(rss([X, Y]))
    assert standard_deviation(np.array([X, Y])) == pytest.approx([stdev(X), stdev(Y)])


@pytest.mark.parametrize("components", [[X], [X, Y], [X, Y, Y[::-1]]])
def test_the_interval_of_rp(components):
    q = len(components)
    found = rp_interval(np.array(components), resolutions=None)
    assert found == pytest.approx(limits(rp, GAUSSIAN_RP[q], GAUSSIAN_ERROR[q], components))
    fine = rp_interval(np.array(components), resolutions=[0.0] * q)
    np.testing.assert_allclose(fine, found)


def test_the_interval_of_eq_23_and_of_three_sigma():
    found = rss_interval(np.array([X, Y]), resolutions=None)
    root = math.sqrt(2)
    expected = limits(rss, root * GAUSSIAN_RP[1], GAUSSIAN_ERROR[1] / root, [X, Y])
    assert found == pytest.approx(expected)
    found = three_sigma_interval(np.array([X]), resolutions=None)
    assert found == pytest.approx(limits(three_sigma, 3.0, math.sqrt(0.5), [X]))


@pytest.mark.parametrize("steps", [[0.25, 0.25], [1.0, 1.0], [1.2, 0.4], [0.0, 0.25]])
def test_rounding_is_taken_off_the_lower_limit(steps):
    components = [X, Y]
    found = rp_interval(np.array(components), resolutions=steps)
    expected = limits(rp, GAUSSIAN_RP[2], GAUSSIAN_ERROR[2], components, steps)
    assert found == pytest.approx(expected)
    found = rss_interval(np.array(components), resolutions=steps)
    root = math.sqrt(2)
    expected = limits(rss, root * GAUSSIAN_RP[1], GAUSSIAN_ERROR[1] / root, components, steps)
    assert found == pytest.approx(expected)


def test_even_scatter_has_the_interval_of_gaussian_scatter_at_least():
    """The jackknife of evenly spread readings is too sure: Gaussian scatter is the least."""
    even = [-1.0, 1.0] * 5 + [0.9, -0.9]
    found = rp_interval(np.array([even]), resolutions=None)
    assert found == pytest.approx(limits(rp, GAUSSIAN_RP[1], GAUSSIAN_ERROR[1], [even]))
    least = GAUSSIAN_ERROR[1] / math.sqrt(len(even) - 1)
    assert found[1] >= rp([even]) * math.exp(Z * least) - 1e-12


def test_two_divisions_hold_what_stands_on_their_border():
    """On one division or two neighbouring ones nothing is known but that it lies inside them."""
    two = np.array([[0.0, 0.1] * 5])
    assert two_divisions(two, [0.1]) == pytest.approx(0.2)
    assert two_divisions(two * 0, [0.1]) == pytest.approx(0.1)
    assert two_divisions(two * 2, [0.1]) == 0.0
    assert two_divisions(two, [0.0]) == 0.0
    plane = np.array([[0.0, 0.1] * 5, [0.0] * 10])
    assert two_divisions(plane, [0.1, 0.5]) == pytest.approx(0.5)
    assert two_divisions(np.array([[0.0, 0.1] * 5, [0.0, 9.0] * 5]), [0.1, 0.1]) == 0.0


@pytest.mark.parametrize("n", [10, 30])
def test_scatter_that_a_division_hides_stays_inside_it_one_time_in_twenty(n):
    figure = float(hidden(np.array(0.1), 2.6, n))
    sigma = figure / 2.6
    inside = stats.norm.cdf(0.05 / sigma) - stats.norm.cdf(-0.05 / sigma)
    assert inside**n == pytest.approx(0.05)


@pytest.mark.parametrize("high", [0.0, 0.1])
def test_on_two_divisions_the_lower_limit_is_0_and_the_upper_holds_what_is_hidden(high):
    positions = np.array([[0.0, high] * 5])
    lower, upper = rp_interval(positions, resolutions=[0.1])
    assert lower == 0.0
    value = rp(positions.tolist())
    least = GAUSSIAN_ERROR[1] / 3.0
    plain = value * math.exp(Z * least + (Z**2 + 2) / 3 * least**2)
    inside = float(hidden(np.array(0.1 + high), GAUSSIAN_RP[1], 10))
    assert upper == pytest.approx(max(plain, inside))


def test_one_reading_that_carries_the_figure_has_a_limit_all_the_same():
    lower, upper = rp_interval(np.array([[0.0] * 9 + [1.0]]), resolutions=None)
    value = rp([[0.0] * 9 + [1.0]])
    assert upper == pytest.approx(1e6 * value)
    # an error above one counts as one: the formula turns back beyond it
    assert lower == pytest.approx(value * (1 - 4 / 9 + 2 / 3 * Z) ** -1.5)


def test_readings_without_any_scatter_have_figures_of_0():
    lower, upper = rp_interval(np.zeros((1, 10)), resolutions=None)
    assert (lower, upper) == (0.0, 0.0)


def test_long_tests_leave_out_128_groups():
    """Each group is every 128th reading; beside the whole jackknife the limits hardly differ."""
    values = np.random.default_rng(1).normal(size=200)
    logs = [
        math.log(rp([[v for k, v in enumerate(values) if k % 128 != group]]))
        for group in range(128)
    ]
    error = math.sqrt(127 / 128 * sum((log - mean(logs)) ** 2 for log in logs))
    error = max(error, GAUSSIAN_ERROR[1] / math.sqrt(199))
    shortfall = 127 * (math.log(rp([list(values)])) - mean(logs))
    upper = Z * error + (Z**2 + 2) / 3 * error**2 + 3 * max(shortfall, 0.0)
    found = rp_interval(values[np.newaxis], resolutions=None)[1]
    assert found == pytest.approx(rp([list(values)]) * math.exp(upper))


@pytest.mark.parametrize("q", [1, 2, 3])
def test_the_constants_are_those_of_gaussian_scatter(q):
    """E l + 3 sd l of chi scatter in q directions, and the error of its estimate times sqrt n."""
    law = stats.chi(q)
    assert GAUSSIAN_RP[q] == pytest.approx(law.mean() + 3 * law.std(), abs=6e-6)
    m, s = law.mean(), law.std()
    l = np.linspace(0, 12, 200_001)  # noqa: E741 - the paper's letter
    influence = (l - m) + 1.5 * ((l - m) ** 2 - s**2) / s
    error = math.sqrt(integrate.trapezoid(influence**2 * law.pdf(l), l)) / (m + 3 * s)
    assert GAUSSIAN_ERROR[q] == pytest.approx(error, abs=1e-4)


@given(
    arrays(np.float64, st.tuples(st.integers(1, 9), st.integers(1, 3)), elements=st.floats(-9, 9))
)
def test_medians_are_those_of_numpy(values):
    assert np.array_equal(median(values), np.median(values, axis=0))
    assert np.array_equal(median(values, axis=1), np.median(values, axis=1))
