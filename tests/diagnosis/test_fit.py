"""The fit of chosen effects on cases worked out by hand, or by scipy."""

import numpy as np
import pytest
from scipy import linalg, stats

from scara_iso.diagnosis.engine.evidence import Remainder, constant, views_of
from scara_iso.diagnosis.engine.fit import (
    Term,
    fit,
    fitted_basis,
    row_scale,
    term_of,
)
from scara_iso.effects import Process, Shape, Spread

N = 8
ROWS = np.arange(N)
SIGN = np.array([1.0, -1.0] * 4)
LATE = np.array([0.0] * 4 + [1.0] * 4)
RAMP = np.arange(N, dtype=float)
WIDE = Spread(np.array([1.0] * 4 + [3.0] * 4))


def shape(*columns):
    return Shape(np.column_stack(columns))


def term(form, *moves):
    return Term("some", form, np.array(moves))


def left_in(values, rows):
    """Return what is left in some rows beside a pose, of readings without a dial."""
    basis, axes = constant(len(rows)), np.zeros(values.shape[1])
    views = views_of(values, basis)
    return Remainder(rows, N, basis, values, 0 * values, axes, axes, views, ())


def bayes(y, course, gain=15.0):
    """Return the g-prior's Bayes factor by the coefficient of determination."""
    r2 = stats.pearsonr(course, y).statistic ** 2
    return (1 + gain) ** -0.5 * (1 - r2 * gain / (1 + gain)) ** (-(len(y) - 1) / 2)


def with_correlation(r):
    """Return readings whose correlation with LATE is r."""
    a, b = LATE - 0.5, SIGN / 2
    return r * a + np.sqrt(1 - r**2) * b


def test_an_axis_takes_part_where_its_bayes_factor_is_above_three():
    """At n = 8 that is a correlation of 0.736."""
    values = np.column_stack([with_correlation(r) for r in (0.95, 0.745, 0.727, 0.0)])
    assert bayes(values[:, 1], LATE) > 3.0 > bayes(values[:, 2], LATE) > 1.0
    found = term_of("step", shape(LATE), left_in(values, ROWS))
    assert found.effect == "step"
    np.testing.assert_array_equal(found.moves, [True, True, False, False])


def test_the_likeliest_axis_always_takes_part():
    values = np.column_stack([with_correlation(r) for r in (0.1, 0.3, 0.2)])
    found = term_of("step", shape(LATE), left_in(values, ROWS))
    np.testing.assert_array_equal(found.moves, [False, True, False])


def test_only_the_rows_that_are_seen_decide_which_axis_takes_part():
    rows = np.array([0, 1, 2, 5, 6, 7])
    course = np.array([0.0, 0, 0, 50, -50, 1, 1, 1])
    values = np.column_stack([course[rows], [1.0, -1, 1, -1, 1, -1]])
    found = term_of("step", shape(course), left_in(values, rows))
    np.testing.assert_array_equal(found.moves, [True, False])


def test_a_random_course_moves_every_axis():
    found = term_of("walk", Process(np.eye(N)), left_in(np.zeros((N, 3)), ROWS))
    np.testing.assert_array_equal(found.moves, [True, True, True])
    assert found.columns.shape == (N, 0)


def log_normal(y, scale):
    """Return the largest log likelihood of y - mean over the scatter, up to a constant."""
    centred = y - y.mean()
    width = np.sqrt(((centred / scale) ** 2).mean())
    return stats.norm.logpdf(centred, scale=scale * width).sum()


def test_a_change_of_scatter_takes_the_axes_that_are_likelier_with_it():
    narrow_then_wide = SIGN * np.where(LATE > 0, 3.0, 1.0)
    a_little, hardly = (SIGN * np.where(LATE > 0, ratio, 1.0) for ratio in (1.8, 1.7))
    values = np.column_stack([5.0 + narrow_then_wide, a_little, hardly, SIGN])
    expected = [log_normal(y, WIDE.scale) > log_normal(y, np.ones(N)) for y in values.T]
    assert expected == [True, True, False, False]
    found = term_of("scatter_change", WIDE, left_in(values, ROWS))
    np.testing.assert_array_equal(found.moves, expected)
    assert (found.effect, found.form) == ("scatter_change", WIDE)


def test_of_axes_that_are_likelier_without_a_change_the_likeliest_takes_part():
    values = np.column_stack([SIGN, SIGN * np.where(LATE > 0, 1.4, 1.0), np.zeros(N)])
    found = term_of("s", WIDE, left_in(values, ROWS))
    np.testing.assert_array_equal(found.moves, [False, True, False])


def test_a_change_of_scatter_is_judged_on_the_rows_that_are_seen():
    rows = np.array([0, 1, 2, 3, 4])
    values = np.column_stack([SIGN[rows], SIGN[rows] * [1, 1, 1, 1, 3.0]])
    found = term_of("s", WIDE, left_in(values, rows))
    np.testing.assert_array_equal(found.moves, [False, True])


def test_pose_and_course_come_back_and_an_axis_that_is_not_moved_keeps_its_mean():
    values = np.column_stack([2.0 + 3.0 * LATE, -1.0 + 4.0 * LATE])
    found = fit([term(shape(LATE), True, False)], values, ROWS, N)
    np.testing.assert_allclose(found.coefficients[0], [[3.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(found.parts[0], np.column_stack([3.0 * LATE, np.zeros(N)]))
    np.testing.assert_allclose(found.predicted[:, 0], values[:, 0])
    np.testing.assert_allclose(found.predicted[:, 1], 1.0)
    assert len(found.terms) == 1


def test_courses_of_several_columns_are_fitted_together_on_the_rows_that_are_seen(rng):
    terms = [
        term(shape(LATE, SIGN), True, True),
        term(Process(np.zeros((N, N))), True, True),
        term(WIDE, True, False),
        term(shape(RAMP), False, True),
    ]
    values = rng.normal(size=(7, 2))
    rows = np.delete(ROWS, 3)
    found = fit(terms, values, rows, N)
    one = np.ones(N)
    for axis, columns in enumerate([(one, LATE, SIGN), (one, LATE, SIGN, RAMP)]):
        design = np.column_stack(columns)
        expected = linalg.lstsq(design[rows], values[:, axis])[0]
        np.testing.assert_allclose(found.predicted[:, axis], design @ expected)
        np.testing.assert_allclose(found.coefficients[0][:, axis], expected[1:3])
        np.testing.assert_allclose(found.coefficients[3][:, axis], expected[3:] if axis else 0.0)
    assert [c.shape for c in found.coefficients] == [(2, 2), (0, 2), (0, 2), (1, 2)]
    np.testing.assert_array_equal(found.parts[1], np.zeros((N, 2)))
    np.testing.assert_array_equal(found.parts[2], np.zeros((N, 2)))


def test_columns_that_say_the_same_share_what_they_explain():
    values = (1.0 + 2.0 * LATE)[:, None]
    twice = [term(shape(LATE), True), term(shape(LATE), True)]
    found = fit(twice, values, ROWS, N)
    np.testing.assert_allclose([c.item() for c in found.coefficients], [1.0, 1.0])
    np.testing.assert_allclose(found.predicted, values)


def test_a_nearly_equal_column_is_still_told_apart():
    """Singular values down to 1e-9 of the largest count."""
    almost = LATE + 1e-6 * SIGN
    values = (LATE + almost)[:, None]
    found = fit([term(shape(LATE), True), term(shape(almost), True)], values, ROWS, N)
    np.testing.assert_allclose([c.item() for c in found.coefficients], [1.0, 1.0], rtol=1e-6)
    nearer = LATE + 1e-11 * SIGN
    values = (LATE + SIGN)[:, None]
    found = fit([term(shape(LATE), True), term(shape(nearer), True)], values, ROWS, N)
    assert np.abs(found.predicted).max() < 2.0


def test_a_random_course_is_the_conditional_mean_of_what_the_others_leave():
    """Kriging on seen rows: K(all, seen) (K(seen, seen) + I)^-1 of what is left."""
    covariance = 4.0 * np.exp(-np.abs(np.subtract.outer(RAMP, RAMP)) / 2)
    rows = np.array([0, 2, 3, 5, 7])
    values = np.column_stack([[1.0, 4.0, 2.0, 9.0, 8.0], [0.0, 1.0, 0.0, 1.0, 3.0]])
    found = fit([term(Process(covariance), True, True)], values, rows, N)
    left = values - values.mean(axis=0)
    weights = linalg.inv(covariance[rows][:, rows] + np.eye(5))
    expected = covariance[:, rows] @ weights @ left
    np.testing.assert_allclose(found.parts[0], expected)
    np.testing.assert_allclose(found.predicted, values.mean(axis=0) + expected)


def test_a_random_course_follows_what_a_step_leaves():
    values = (5.0 + 6.0 * LATE + SIGN)[:, None]
    terms = [term(shape(LATE), True), term(Process(3.0 * np.eye(N)), True)]
    found = fit(terms, values, ROWS, N)
    np.testing.assert_allclose(found.parts[0][:, 0], 6.0 * LATE, atol=1e-12)
    np.testing.assert_allclose(found.parts[1][:, 0], 0.75 * SIGN)
    np.testing.assert_allclose(found.predicted[:, 0], 5.0 + 6.0 * LATE + 0.75 * SIGN)


def test_changes_of_scatter_multiply_on_the_axes_that_they_move():
    double = Spread(np.where(SIGN > 0, 2.0, 1.0))
    terms = [term(WIDE, True, False), term(shape(LATE), True, True), term(double, True, True)]
    both = WIDE.scale * double.scale
    np.testing.assert_array_equal(row_scale(terms, N), np.column_stack([both, double.scale]))
    np.testing.assert_array_equal(row_scale(terms[1:2], N), np.ones((N, 1)))


def test_the_basis_spans_pose_and_known_courses_on_the_rows_that_are_seen():
    rows = np.array([0, 1, 3, 4, 6, 7])
    terms = [term(WIDE, True), term(shape(LATE), True), term(shape(LATE, RAMP), True)]
    basis = fitted_basis(terms, rows)
    assert basis.shape == (6, 3)
    np.testing.assert_allclose(basis.T @ basis, np.eye(3), atol=1e-12)
    for column in (np.ones(6), LATE[rows], RAMP[rows]):
        np.testing.assert_allclose(basis @ (basis.T @ column), column, atol=1e-12)
    np.testing.assert_allclose(fitted_basis(terms[:1], rows), constant(6))


def test_a_term_without_a_known_course_has_no_columns():
    assert term(WIDE, True).columns.shape == (N, 0)
    np.testing.assert_array_equal(term(shape(LATE), True).columns[:, 0], LATE)


@pytest.mark.parametrize("moves", [(True, False), (False, True), (False, False)])
def test_what_no_axis_shows_has_no_part(moves):
    values = np.column_stack([RAMP, 2 * RAMP])
    found = fit([term(shape(RAMP), *moves)], values, ROWS, N)
    expected = np.where(moves, values, values.mean(axis=0))
    np.testing.assert_allclose(found.predicted, expected, atol=1e-12)


@pytest.mark.parametrize("variance", [0.3, 4.0, 200.0])
def test_scatter_beside_a_random_course_is_as_wide_as_it_was_made(variance, rng):
    """What the course leaves is narrower: it takes of the scatter too."""
    i = np.arange(40)
    process = Process(0.8 ** np.abs(np.subtract.outer(i, i)), variance=variance, stays=0.25)
    root = np.linalg.cholesky(process.covariance + np.eye(40))
    values = 2 * root @ rng.normal(size=(40, 300))
    fitted = fit([Term("some", process, np.ones(300, dtype=bool))], values, i, 40)
    left = (values - fitted.predicted).std(axis=0, ddof=1)
    assert np.sqrt(np.mean((left * fitted.wider) ** 2)) == pytest.approx(2.0, rel=0.03)
    assert np.mean(left) < 1.9
    assert fitted.cured / fitted.wider == pytest.approx((1 + 0.25 * variance) ** 0.5)


def test_without_a_random_course_what_is_left_is_the_scatter():
    fitted = fit([term(shape(LATE), True)], with_correlation(0.9)[:, np.newaxis], ROWS, N)
    assert fitted.wider == pytest.approx(1.0)
    assert fitted.cured == pytest.approx(1.0)
