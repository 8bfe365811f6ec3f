"""The screen of a recording: what of many readings stands on it."""

import io

import pytest
from rich.console import Console

from scara_iso.render.live import AxisView, LiveView, draw


@pytest.mark.parametrize("count", [30, 50, 51, 500])
def test_the_strip_shows_the_last_readings_each_by_a_sign_on_one_line(count):
    readings = (0.5,) * (count - 30) + (0.0, 1.0) * 15
    view = LiveView("record run.csv", count, 999, [AxisView("X", "0.1", "mm", count, readings)])
    file = io.StringIO()
    Console(file=file, width=60, force_terminal=False).print(draw(view, Console(width=60)))
    lines = file.getvalue().splitlines()
    assert max(map(len, lines)) <= 60
    (strip,) = (line.strip() for line in lines if set(line.strip()) & set("▁▂▃▄▅▆▇█"))
    assert len(strip) == min(count, 50)
    assert strip.endswith("▁█" * 15)
