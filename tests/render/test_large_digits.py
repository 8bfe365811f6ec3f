"""The recording screen at a distance: digits as large as the window allows, and its bell."""

import io
import re
from dataclasses import replace

import pytest
from hypothesis import given, strategies as st
from rich.console import Console

from scara_iso.commands.operator import screen as record_screen
from scara_iso.commands.operator.screen import Screen
from scara_iso.recorder import CycleDone, Refused, Started, Stored
from scara_iso.render.live import AxisView, LiveView, _halved, _head, _progress, draw, large

VIEW = LiveView(
    title="scara-iso record run.csv", stored=2, planned=31, large=True,
    axes=[AxisView("X", "-0.812", "mm", 3, (0.81, 0.812))],
)  # fmt: skip


def shown(view, width, height, **kinds):
    file = io.StringIO()
    console = Console(file=file, width=width, height=height, force_terminal=True, **kinds)
    console.print(draw(view, console))
    return file.getvalue()


def test_every_number_has_a_shape_of_its_own():
    shapes = {tuple(large(sign, 80, 20)) for sign in "0123456789-.XYZθ"}
    assert len(shapes) == 16


@pytest.mark.parametrize("width", [20, 40, 80, 120])
@pytest.mark.parametrize("height", [3, 5, 8, 10, 30])
def test_they_fit_and_are_the_largest_that_do(width, height):
    lines = large("-12.345", width, height)
    assert len(lines) <= height
    assert all(len(line) <= width for line in lines)
    assert len(large("-12.345", 200, height)) >= len(lines)
    assert len(lines) > 0 or width < 27


def test_what_is_no_number_is_not_drawn():
    assert large("", 80, 20) == large("ERR", 80, 20) == []


@pytest.mark.parametrize("width", [40, 80, 120])
def test_the_screen_fits_its_window_and_keeps_the_text(width):
    lines = shown(VIEW, width, 24, no_color=True).splitlines()
    assert len(lines) <= 24
    assert any("-0.812 mm" in line for line in lines)
    assert sum("█" in line or "▀" in line for line in lines) >= 3
    assert "\x1b[3" not in shown(VIEW, width, 24, no_color=True)


@given(width=st.integers(30, 120), title=st.text("abc ", max_size=90), stored=st.integers(0, 31))
def test_head_and_progress_fill_the_line_between_two_margins(width, title, stored):
    view = replace(VIEW, title=f"[{title}]", stored=stored)
    head, bar = _head(view, width).plain, _progress(view, width, blocks=False).plain
    count = f" {stored} of 31 {'cycles stored' if width >= 60 else 'stored'}"
    margin = len(bar) - len(bar.lstrip())
    assert head.endswith(count)
    assert len(head) == len(bar) == width - margin
    assert bar.count("#") == (width - 2 * margin) * stored // 31
    room = width - 2 * margin - len(count)
    whole = f"[{title}]"
    cut = "…" + whole[len(whole) - room + 1 :] if room > 4 else ""
    assert head.removesuffix(count).strip() == (whole if len(whole) <= room else cut.rstrip())


@given(st.lists(st.text(" #", min_size=7, max_size=7), min_size=1, max_size=9))
def test_two_rows_of_points_are_one_line_of_halves(rows):
    halves = {"█": "##", "▀": "# ", "▄": " #", " ": "  "}
    lines = [["".join(half) for half in zip(*(halves[c] for c in line), strict=True)]
             for line in _halved(rows)]  # fmt: skip
    points = [row for line in lines for row in line]
    assert points[: len(rows)] == rows
    assert not "".join(points[len(rows) :]).strip()


def test_an_axis_stands_large_before_its_digits_and_above_its_course():
    two = replace(VIEW, axes=[replace(VIEW.axes[0], name=n, shown="0.1") for n in ("Y", "theta")])
    plain = re.sub(r"\x1b\[[0-9;]*m", "", shown(two, 80, 24, no_color=True))
    lines = [line.rstrip() for line in plain.splitlines()]
    for name, sign in (("Y", "Y"), ("theta", "θ")):
        k = next(k for k, line in enumerate(lines) if line.split()[:1] == [name])
        signs = large(f"{sign} 0.1", 76, 5)
        assert len(signs) == 5
        assert lines[k + 1 : k + 6] == [f"  {line}".rstrip() for line in signs]
        assert lines[k + 6].strip() == "▁█"


def test_a_low_window_has_text_only():
    assert "▀" not in shown(VIEW, 80, 12)


class Bell:
    def __init__(self):
        self.rung = 0

    def show(self, view):
        pass

    def ring(self):
        self.rung += 1


class Silent:
    def poll(self):
        return None


@pytest.mark.parametrize(("quiet", "good", "bad"), [(False, 1, 2), (True, 0, 0)])
def test_one_bell_for_stored_and_two_for_refused(monkeypatch, quiet, good, bad):
    bell, now = Bell(), [0.0]
    monkeypatch.setattr(record_screen.time, "monotonic", lambda: now[0])
    screen = Screen(bell, Silent(), title="t", earlier={}, quiet=quiet)

    def heard(*said):
        bell.rung = 0
        for one in said:
            screen.tell(one)
        for _ in range(20):
            now[0] += 0.1
            screen.poll()
        return bell.rung

    screen.tell(Started({"X": "x"}, 1, 31, "enter", None, None))
    assert heard(Stored(1, "X", 0.8, "0.8", "mm", None), CycleDone(1, True, None)) == good
    assert heard(Refused("X", "0.8", "twice")) == bad


def test_the_pace_of_a_session_is_known_from_its_third_visit(monkeypatch):
    now, told = [50.0], {}
    monkeypatch.setattr(record_screen.time, "monotonic", lambda: now[0])

    def place(stored, pace):
        told[stored] = pace
        return ""

    screen = Screen(Bell(), Silent(), title="t", earlier={}, place=place)
    screen.tell(Started({"X": "x"}, 1, 31, "enter", None, None))
    for cycle in range(1, 6):
        now[0] += 10.0
        screen.tell(Stored(cycle, "X", 0.8, "0.8", "mm", None))
        screen.tell(CycleDone(cycle, cycle == 1, None))
        screen.poll()
    assert {told.pop(stored) for stored in range(3)} == {None}
    assert all(10.0 <= pace <= 10.0 * (stored + 1) / stored for stored, pace in told.items())
    assert list(told) == [3, 4]
