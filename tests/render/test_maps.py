"""The map of predicted RP over the reach."""

import numpy as np
import pytest

from scara_iso.diagnosis import ReachMap
from scara_iso.render.plots import plot_reach

X, Y = np.array([0.0, 10.0, 20.0, 30.0]), np.array([-5.0, 5.0, 15.0])
RP = 0.01 + 0.001 * np.arange(12.0).reshape(3, 4)
RP[0, 0] = np.nan


@pytest.mark.parametrize("limit", [None, 0.02])
def test_a_map_marks_its_poses_its_best_and_its_worst_place(limit):
    reach = ReachMap(X, Y, RP, 0.8 * RP, 1.2 * RP, {"P1": (3.0, 4.0), "P2": (20.0, 1.0)}, limit)
    axes = plot_reach(reach).axes[0]
    marks = {
        line.get_marker(): line.get_xydata().tolist()
        for line in axes.lines
        if len(line.get_xdata())
    }
    assert marks["v"] == [[10.0, -5.0]]
    assert marks["^"] == [[30.0, 15.0]]
    poses = [line.get_xydata()[0].tolist() for line in axes.lines if line.get_marker() == "o"]
    assert poses == [[3.0, 4.0], [20.0, 1.0]]
    assert [(text.get_text(), text.xy) for text in axes.texts] == [
        ("P1", (3.0, 4.0)), ("P2", (20.0, 1.0)),
    ]  # fmt: skip
    named = [text.get_text() for text in axes.get_legend().get_texts()]
    assert named[-2:] == ["best 0.011 mm", "worst 0.021 mm"]
    assert named[:-2] == ([] if limit is None else ["hatched: 0.02 mm is not kept"])
    assert reach.share_kept == (None if limit is None else pytest.approx(6 / 11))
    assert axes.get_aspect() == 1
