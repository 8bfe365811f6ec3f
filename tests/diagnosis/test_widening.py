"""Scatter that changes is seen by ranks, at the level that all effects share."""

import numpy as np
import pytest
from scipy import stats

from scara_iso.diagnosis.readings import diagnose_readings
from scara_iso.diagnosis.significance.permutation import savage_scores, widening
from scara_iso.run import Axis, Run

N = 24


def test_scores_are_those_of_the_ranks_of_distances(rng):
    y = rng.normal(size=(N, 2)).round(1)
    distance = np.abs(y - np.median(y, axis=0)).round(9)
    expected = -np.log(1 - stats.rankdata(distance, axis=0) / (N + 1))
    np.testing.assert_allclose(savage_scores(y), expected)


def test_its_mean_over_all_orders_is_about_one(rng):
    y = rng.standard_t(2, size=(N, 3))
    orders = np.array([rng.permutation(N) for _ in range(4000)])
    assert 0.5 < widening(y, orders).mean() < 1.3


def test_a_gross_reading_is_no_change_of_scatter(rng):
    y = rng.normal(size=(N, 1))
    as_is = np.arange(N)[np.newaxis]
    before = widening(y, as_is)
    y[N - 1] = 1e9
    assert widening(y, as_is) < 3 * before + 1
    assert widening(y * np.where(np.arange(N) < 12, 1.0, 8.0)[:, np.newaxis], as_is) > 5


@pytest.mark.parametrize("axes", [0, 1])
def test_too_few_cycles_or_axes_say_nothing(axes):
    assert np.all(widening(np.zeros((6, axes)), np.arange(6)[np.newaxis]) == 0)


def test_scatter_that_doubles_on_three_axes_is_found():
    rng = np.random.default_rng(27)  # without these ranks p is 0.09
    wide = np.where(np.arange(30) < 15, 1, 2)[:, np.newaxis]
    x = (0.004 * rng.normal(size=(30, 3)) * wide).round(3)
    axes = {name: Axis(name, x[:, k], resolution=0.001) for k, name in enumerate("XYZ")}
    found = diagnose_readings(Run(np.arange(2, 32), axes), seed=1)
    assert [one.effect for one in found.effects] == ["scatter_change"]
