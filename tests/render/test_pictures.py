"""Pictures of a report: what a scale shows, and that all of it lies on the picture."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from scara_iso.render.pictures import plot
from scara_iso.reporting import Curve, Figure, Panel


def picture_of(x, **more):
    panel = Panel("", (Curve("", np.array(x, dtype=float), np.arange(float(len(x)))),))
    return Figure("RP", "by date", "x", "[mm]", (panel,), **more)


def test_a_single_day_stands_in_the_middle_of_its_scale():
    (axes,) = plot([picture_of([20000.0], dates=True)]).axes
    (day,), (low, high) = axes.lines[0].get_xdata(), axes.get_xlim()
    assert low < day < high
    assert day - low == pytest.approx(high - day)


@pytest.mark.parametrize("shape", [{}, {"square": True}, {"wide": True}])
def test_a_scale_fills_its_picture_and_stays_on_it(shape):
    (axes,) = plot([picture_of([1, 2, 3], **shape)]).axes
    place = axes.get_position()
    assert 0 < place.x0 < place.x1 <= 1
    assert 0 < place.y0 < place.y1 <= 1
    assert place.width > 0.7
    assert place.height > 0.7


@pytest.mark.parametrize("reach", [0.0159, 0.02, 0.00031, 2.0])
def test_the_scales_of_squares_beside_each_other_can_be_read(reach):
    square = Panel("P1", (Curve("", np.array([-reach, reach]), np.array([-reach, reach])),))
    both = {"x_limits": (-reach, reach), "y_limits": (-reach, reach)}
    figure = plot([Figure("XY", "", "x", "y", (square,) * 5, square=True, **both)])
    FigureCanvasAgg(figure).draw()
    boxes = [
        label.get_window_extent()
        for axes in figure.axes
        for label in axes.get_xticklabels()
        if label.get_text()
    ]
    assert len(boxes) == 10
    assert all(one.x1 < other.x0 for one, other in pairwise(boxes))
