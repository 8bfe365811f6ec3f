"""Other trades' words for repeatability, from the same readings."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy import stats

from scara_iso.iso9283.analysis import definitions

readings = st.lists(st.floats(-10, 10).map(lambda x: round(x, 3)), min_size=2, max_size=40)


def found(values, approach=None):
    approach = None if approach is None else np.array(approach, dtype=float)
    return {d.name: d.value for d in definitions(np.array(values, dtype=float), approach)}


@given(readings)
def test_half_range_and_sigmas(values):
    figures = found(values)
    assert figures["half range"] == (max(values) - min(values)) / 2
    assert figures["half range of 7"] == (max(values[:7]) - min(values[:7])) / 2
    s = np.std(values, ddof=1)
    assert figures["2 s"] == pytest.approx(2 * s, abs=1e-12)
    assert figures["3 s"] == pytest.approx(3 * s, abs=1e-12)
    assert figures["half range"] >= figures["half range of 7"]


@pytest.mark.filterwarnings("ignore:Precision loss")  # scipy's own, of readings all equal
@given(readings, readings)
def test_iso_230_2(up, down):
    S_up, S_down = stats.tstd(up), stats.tstd(down)
    B = np.mean(up) - np.mean(down)
    R = max(2 * S_up + 2 * S_down + abs(B), 4 * S_up, 4 * S_down)
    figures = found([*up, *down], [1] * len(up) + [-1] * len(down))
    assert figures["R up"] == pytest.approx(4 * S_up, abs=1e-12)
    assert figures["R down"] == pytest.approx(4 * S_down, abs=1e-12)
    assert figures["B"] == pytest.approx(B, abs=1e-12)
    assert figures["R"] == pytest.approx(R, abs=1e-12)


def test_the_order_of_approaches_does_not_matter():
    alternating = found([1, 5, 2, 6, 3, 7], [1, -1, 1, -1, 1, -1])
    assert alternating == found([1, 2, 3, 5, 6, 7], [1, 1, 1, -1, -1, -1])
    assert alternating["B"] == -4
    assert alternating["R"] == 8


@pytest.mark.parametrize("approach", [None, [1, 1, 1, 1], [-1, -1, -1, -1], [1, 1, 1, -1]])
def test_one_direction_has_no_iso_230_2(approach):
    assert set(found([1, 2, 3, 5], approach)) == {"half range", "half range of 7", "2 s", "3 s"}


def test_every_figure_says_what_it_is():
    for figure in definitions(np.arange(30.0), np.tile([1.0, -1.0], 15)):
        assert figure.meaning
