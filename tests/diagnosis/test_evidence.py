"""Bayes factors against marginal likelihoods that are integrated or solved another way."""

import numpy as np
import pytest
from scipy import stats

from scara_iso.diagnosis.engine.evidence import (
    LARGEST_LOG,
    Views,
    build,
    constant,
    joint_evidence,
    log_bayes,
    log_bayes_of_course,
    views_of,
)
from scara_iso.diagnosis.engine.hypotheses import Hypothesis
from scara_iso.effects import Process, Shape, Spread

N = 10
ROWS = np.arange(N)
STEP = np.where(ROWS >= 4, 1.0, 0.0)
RAMP = ROWS.astype(float)
WIDE = np.where(ROWS >= 5, 3.0, 1.0)
WIDER = np.where(ROWS >= 7, 5.0, 1.0)
QUIET = 29
"""A known scatter counts as seen in so many more cycles."""


@pytest.fixture
def two(rng):
    """Readings of two axes that move together, and the same about their means."""
    y = rng.normal(size=(N, 2)) @ np.array([[1.0, 0.5], [0.0, 3.0]]) + [100.0, -7.0]
    return y, y - y.mean(axis=0)


def test_one_axis_is_seen_once_about_its_mean_at_unit_length(two):
    y, free = two
    views = views_of(y[:, :1], constant(N))
    np.testing.assert_allclose(views.columns, free[:, :1] / np.linalg.norm(free[:, 0]))
    assert (views.axes, views.columns.shape, views.known.tolist()) == (1, (N, 1), [0.0])


def test_two_axes_are_seen_alone(two):
    y, free = two
    views = views_of(y, constant(N))
    assert (views.axes, views.columns.shape, views.known.tolist()) == (2, (N, 2), [0.0, 0.0])
    np.testing.assert_allclose(views.columns, free / np.linalg.norm(free, axis=0))


def test_a_named_direction_weighs_the_axes_by_their_covariance(two):
    """The column is F (F'F)^-1 m: the best linear unbiased estimate of a movement along m."""
    y, free = two
    moves = {"payload": np.array([0.3, -2.0]), "heat": np.array([1.0, 0.0])}
    views = views_of(y, constant(N), moves)
    assert views.columns.shape == (N, 4)
    for k, movement in enumerate(moves.values()):
        expected = free @ np.linalg.solve(free.T @ free, movement)
        np.testing.assert_allclose(views.columns[:, 2 + k], expected)


def test_a_known_scatter_counts_as_29_cycles_of_each_axis_that_has_one(two):
    y, free = two
    squares = (free**2).sum(axis=0)
    views = views_of(y, constant(N), {"heat": np.ones(2)}, np.array([0.5, 0.0]))
    np.testing.assert_allclose(views.known, [QUIET * 0.25 / squares[0], *[0.0] * 2])
    one = views_of(y[:, 1:], constant(N), sigma=np.array([0.2]))
    np.testing.assert_allclose(one.known, [QUIET * 0.04 / squares[1]])
    assert views_of(y, constant(N), sigma=np.zeros(2)).known.tolist() == [0.0, 0.0]


def test_axes_that_do_not_move_or_move_as_one_stay_finite(two):
    y, _ = two
    still = views_of(np.column_stack([y[:, 0], np.zeros(N)]), constant(N), {"a": np.ones(2)})
    assert np.isfinite(still.columns).all()
    assert not still.columns[:, 1].any()
    same = views_of(y[:, [0, 0]], constant(N), {"a": np.ones(2)}, np.ones(2))
    assert np.isfinite(same.columns).all()
    assert np.isfinite(same.known).all()
    # what rounding leaves in the direction that does not move is not blown up
    assert np.abs(same.columns).max() < 1.01
    none = views_of(np.zeros((N, 1)), constant(N), sigma=np.ones(1))
    assert np.isfinite(none.known).all()


def whole_log_bayes(y, covariance, quiet=0.0):
    """Return log |C|^(-1/2) (y' C^-1 y / y'y)^(-nu/2), quiet cycles of these squares appended."""
    whole = np.eye(N) + covariance
    nu = N - 1 + (QUIET if quiet else 0)
    power = (y @ np.linalg.solve(whole, y) + quiet) / (y @ y + quiet)
    return -0.5 * np.linalg.slogdet(whole)[1] - nu / 2 * np.log(power)


def projected(*columns, gain=15.0):
    """Return the g-prior's covariance of courses beside a constant pose."""
    centred = np.column_stack(columns) - np.mean(columns, axis=1)
    return gain * centred @ np.linalg.pinv(centred)


def test_a_bayes_factor_is_that_of_its_covariance(two):
    """Shapes of one and of two columns, a process, each column on its own, known or not."""
    _, free = two
    centre = np.eye(N) - 1 / N
    wave = np.exp(-np.abs(np.subtract.outer(ROWS, ROWS)) / 2)
    members = [
        Hypothesis("a", Shape(STEP[:, None]), 1.0),
        Hypothesis("b", Shape(np.column_stack([STEP, RAMP])), 1.0),
        Hypothesis("c", Process(wave), 1.0),
    ]
    hypotheses = build(members, ROWS, constant(N))
    covariances = [projected(STEP), projected(STEP, RAMP), centre @ wave @ centre]
    for known in (np.zeros(2), np.array([0.0, 4.0])):
        found = log_bayes(hypotheses, free, known)
        expected = [
            [whole_log_bayes(free[:, a], covariance, known[a]) for a in (0, 1)]
            for covariance in covariances
        ]
        np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-3)


def marginal(y, scale):
    """Return the likelihood of y ~ N(mu, (s r)^2), integrated over mu and log s on a grid."""
    mu = np.linspace(-60, 60, 2401)[:, None, None]
    s = np.exp(np.linspace(-4, 6, 301))[None, :, None]
    density = np.exp(stats.norm.logpdf(y, mu, s * scale).sum(axis=2))
    return density.sum()


@pytest.mark.slow
@pytest.mark.parametrize("known", [0.0, 5.0])
def test_a_change_of_scatter_integrates_mean_and_width_out(rng, known):
    """The known cycles are seen under the narrow width with a mean that is known."""
    scales = [WIDE, WIDER]
    members = [Hypothesis("w", Spread(scale), 1.0) for scale in scales]
    members.insert(0, Hypothesis("a", Shape(STEP[:, None]), 1.0))
    columns = np.column_stack([rng.normal(size=N), rng.normal(size=N) * WIDE])
    columns -= columns.mean(axis=0)
    found = log_bayes(build(members, ROWS, constant(N)), columns, np.full(2, known))
    assert found.shape == (3, 2)
    for i, scale in enumerate(scales):
        for a in (0, 1):
            y, one = columns[:, a], np.ones(N)
            if not known:
                expected = np.log(marginal(y, scale) / marginal(y, one))
            else:
                expected = log_quadrature(y, scale, known) - log_quadrature(y, one, known)
            assert found[1 + i, a] == pytest.approx(expected, abs=1e-3)


def log_quadrature(y, scale, known):
    mu = np.linspace(-60, 60, 2401)[:, None]
    s = np.exp(np.linspace(-4, 6, 301))[None, :]
    squares = (((y - mu[:, :, None]) / scale) ** 2).sum(axis=2) + known
    log = -squares / 2 / s**2 - (N + QUIET) * np.log(s) - np.log(scale).sum()
    return np.log(np.exp(log - log.max()).sum()) + log.max()


@pytest.mark.parametrize("courses", [(STEP,), (STEP, RAMP)])
def test_a_course_weighs_by_its_coefficient_of_determination(two, courses):
    """The g-prior's (1 + g)^(-k/2) (1 - R^2 g / (1 + g))^(-nu/2), beside mean and one more."""
    y, _ = two
    odd = np.where(ROWS % 2, 1.0, -1.0)
    basis = np.linalg.qr(np.column_stack([np.ones(N), odd]))[0]
    found = log_bayes_of_course(np.column_stack(courses), basis, y)
    for a in (0, 1):
        left = [
            np.sum((y[:, a] - X @ np.linalg.lstsq(X, y[:, a])[0]) ** 2)
            for X in (basis, np.column_stack([basis, *courses]))
        ]
        r2, k = 1 - left[1] / left[0], len(courses)
        expected = -k / 2 * np.log(16) - (N - 2) / 2 * np.log(1 - r2 * 15 / 16)
        assert found[a] == pytest.approx(expected)


def test_readings_without_scatter_prove_nothing_and_stay_finite():
    still = np.zeros((N, 1))
    members = [Hypothesis("a", Shape(STEP[:, None]), 1.0), Hypothesis("w", Spread(WIDE), 1.0)]
    found = log_bayes(build(members, ROWS, constant(N)), still)
    assert np.isfinite(found).all()
    assert found[0, 0] == pytest.approx(-np.log(16) / 2)
    course = log_bayes_of_course(STEP[:, None], constant(N), still)
    np.testing.assert_allclose(course, -np.log(16) / 2)


def test_a_course_without_any_scatter_about_it_stays_finite():
    """The share that is left is cut at 1e-12: 4.5 ln 1e12 beside what the prior costs."""
    centred = STEP - STEP.mean()
    huge = build([Hypothesis("a", Shape(STEP[:, None]), 1.0, gain=1e18)], ROWS, constant(N))
    found = log_bayes(huge, centred[:, None])[0, 0]
    assert found == pytest.approx(4.5 * np.log(1e12) - 0.5 * np.log(1e18))


def test_each_axis_takes_part_or_not_and_named_directions_weigh_as_much():
    ratio = np.array([3.0, 5.0, 11.0, 15.0])
    both = (1 + 3) / 2 * (1 + 5) / 2
    found = joint_evidence(np.log(ratio[None, :2, None]), Views(np.empty((N, 2)), 2, np.zeros(2)))
    assert found == pytest.approx(np.array([[both]]))
    named = Views(np.empty((N, 4)), 2, np.zeros(4))
    found = joint_evidence(np.log(ratio[None, :, None]), named)
    assert found == pytest.approx(np.array([[(both + 13) / 2]]))
    alone = Views(np.empty((N, 1)), 1, np.zeros(1))
    one = joint_evidence(np.log([[[3.0, 5.0]], [[7.0, 2.0]]]), alone)
    np.testing.assert_allclose(one, [[3.0, 5.0], [7.0, 2.0]])


@pytest.mark.parametrize("axes", [1, 2])
def test_overwhelming_evidence_is_cut_and_stays_finite(axes):
    """All axes together never exceed exp(600): squares and sums of it would overflow."""
    views = Views(np.empty((N, axes)), axes, np.zeros(axes))
    found = joint_evidence(np.full((1, axes, 1), 1e6), views)[0, 0]
    assert LARGEST_LOG == 600.0
    assert np.isfinite(found)
    assert np.log(found) == pytest.approx(600.0 if axes == 1 else 600.0 - np.log(4), abs=1e-6)


def test_views_never_change_and_are_compared_as_one_object():
    assert Views.__dataclass_params__.frozen
    assert Views.__eq__ is object.__eq__
    assert "__slots__" in vars(Views)
