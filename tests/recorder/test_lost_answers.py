"""One answer is lost: what a timer or a dial at rest takes next is of the visit that it says.

The arm stands at visit n for 5 s, from 5 n on; the dial shows which visit it is.
"""

import math

import numpy as np
import pytest
from bench import Script, run_session, stored

from scara_iso import read_table
from scara_iso.recorder import Quit
from scara_iso.recorder.gauge import HaltError
from scara_iso.recorder.ports.port import StreamClock

OPTO = "X=opto-rs232?unit=mm@script"
EVERY_S = 5.0


def shown_by(value_at, *, lost):
    """Return a dial that shows ``value_at`` the time; its request number ``lost`` is not heard."""

    class Dial(Script):
        def write(self, data):
            if data == b"?\r":
                text = b"" if len(self.requests) == lost else frame(value_at(self._clock.now()))
                self._answer = lambda _, text=text: [(0.02, text)] if text else []
            super().write(data)

    return Dial


def frame(value):
    return f"{value:+08.3f}\r".encode()


def visit_of(time):
    return 1 + int(time / EVERY_S) / 1000


@pytest.mark.parametrize("lost", range(1, 5))
@pytest.mark.parametrize("seconds", [3.0, 5.0, 20.0])
def test_a_timer_takes_no_visit_twice_and_keeps_its_phase(tmp_path, monkeypatch, seconds, lost):
    dial = shown_by(lambda time: 1 + int(time / seconds) / 1000, lost=lost)
    said = run_session(
        tmp_path, [OPTO], ports={"X": dial}, cycles=6, trigger=f"timer:{seconds}",
        monkeypatch=monkeypatch,
    )  # fmt: skip
    texts = [text for _, text in stored(said)]
    assert len(set(texts)) == len(texts) == 6
    times = read_table(tmp_path / "run.csv").covariates["time_s"]
    assert (times % seconds <= seconds / 2).all()
    assert np.median(times % seconds) < 0.1


def test_a_timer_halts_in_a_tour_where_a_visit_was_missed(tmp_path, monkeypatch):
    with pytest.raises(HaltError, match="where the arm stands is not known"):
        run_session(
            tmp_path, [OPTO], ports={"X": shown_by(visit_of, lost=2)}, cycles=4,
            trigger="timer:5", poses=("P1", "P2"), monkeypatch=monkeypatch,
        )  # fmt: skip
    assert stored(run_session.said) == [(1, "1.000"), (1, "1.001")]


def rests(time):
    """Return what a dial shows that is free for a second before each rest, by turns at two."""
    visit, since = divmod(time, EVERY_S)
    return 5.0 if since < 1 else 1.0 + 0.2 * (visit % 2) + visit / 1000


@pytest.mark.parametrize("lost", [70, 71, 75])
def test_a_dial_at_rest_halts_in_a_tour_where_a_visit_may_have_passed(tmp_path, monkeypatch, lost):
    class Ends:
        def poll(self):
            return Quit() if clock.now() > 100 else None

    clock = StreamClock(paced=False)
    clock.watch(lambda: 100.5 if clock.now() < 100.5 else math.inf)
    with pytest.raises(HaltError, match="where the arm stands is not known"):
        run_session(
            tmp_path, [OPTO], ports={"X": shown_by(rests, lost=lost)}, cycles=8, clock=clock,
            trigger="settled", poses=("P1", "P2"), monkeypatch=monkeypatch, operator=Ends(),
        )  # fmt: skip
    for k, (_, text) in enumerate(stored(run_session.said)):
        assert float(text) == pytest.approx(1.0 + 0.2 * (k % 2), abs=0.05)
