"""Rests of a stream by their definitions: windows, halves, and the top of a swing."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

import scara_iso
from scara_iso.base.errors import DataError, UsageError
from scara_iso.run import Axis, Run
from scara_iso.signals.doubts import Samples, Stay, sort
from scara_iso.signals.rests import Rest, _of_swing, motion


@given(gap=st.integers(0, 38), half=st.integers(2, 6), seed=st.integers(0, 99))
def test_the_range_around_each_sample_is_infinite_where_samples_miss(gap, half, seed):
    values = np.random.default_rng(seed).normal(size=40)
    time = np.arange(40) + 20.0 * (np.arange(40) > gap)
    found = motion(time, [values, -2 * values], 2 * half)
    assert (found.window, found.gaps) == (2 * half + 1, (gap,))
    for k, size in enumerate(found.ranges):
        first, last = max(0, k - half), min(39, k + half)
        expected = math.inf if first <= gap < last else 2 * np.ptp(values[first : last + 1])
        assert size == pytest.approx(expected)


@given(st.integers(10, 60), st.integers(0, 9), st.integers(0, 99))
def test_a_rest_creeps_by_what_its_halves_are_apart(count, first, seed):
    values = np.random.default_rng(seed).normal(size=count + first + 5).cumsum()
    end, half = first + count, first + count // 2
    moved = abs(values[half:end].mean() - values[first:half].mean())
    samples = Samples(np.arange(len(values)) - 1.0, {"X": values}, [values], "mm")
    for still, creeps in ((moved * 0.999, True), (moved * 1.001, False)):
        kept, doubts, _ = sort(samples, [Stay((Rest(first, end - 1),))], 1.0, still)
        if first:
            assert (len(kept), len(doubts)) == (not creeps, creeps)
            assert not creeps or f"creeps by {moved:.3g} mm" in doubts[0].message
        else:
            assert [doubt.code for doubt in doubts] == ["begins-at-rest"]


@given(height=st.floats(0.001, 10), step=st.floats(0.2, 1.2), late=st.floats(-0.49, 0.49))
def test_the_top_of_a_swing_is_found_through_three_samples(height, step, late):
    near = height * np.cos(step * (np.array([-1, 0, 1]) + late))
    assert _of_swing(near) == pytest.approx(height)


def test_a_dwell_as_long_as_the_stream_is_none_that_is_too_long():
    time = np.arange(0, 10.01, 0.02)
    reading = np.where(time < 1, 3.0, 0.3)
    run = Run(np.arange(len(time)), {"X": Axis("X", reading)}, covariates={"time_s": time})
    whole = float(time[-1] - time[0])
    with pytest.raises(DataError, match="no rest of 10 s"):
        scara_iso.visits(run, poses=["P1"], dwell=whole)
    with pytest.raises(UsageError, match="the stream lasts 10 s"):
        scara_iso.visits(run, poses=["P1"], dwell=whole * 1.001)
