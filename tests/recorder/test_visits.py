"""Readings that come by themselves: every row of the table is of one visit."""

import random

import pytest
from bench import Orders, Script, run_session, stored

from scara_iso import read_table
from scara_iso.base.errors import InstrumentError
from scara_iso.recorder import Quit, Voided
from scara_iso.recorder.ports.port import StreamClock
from scara_iso.recorder.visits import Visits

GAUGES = {
    "X": "X=opto-rs232?unit=mm@a",
    "Y": "Y=opto-rs232?unit=mm@b",
    "Z": "Z=opto-rs232?unit=mm@c",
}


def line(pose):
    return b"+000.%03d\r" % (100 + pose)


def sent(axis, poses, *, delay, damaged=(), missing=()):
    """Return what a gauge sends: the number of the pose, 5 s apart."""
    return [
        (5.0 * pose + delay, b"+000.#03\r" if (axis, pose) in damaged else line(pose))
        for pose in range(1, poses + 1)
        if (axis, pose) not in missing
    ]


@pytest.mark.parametrize("delays", [{"X": 0.0, "Y": 1.0}, {"X": 1.0, "Y": 0.0}])
@pytest.mark.parametrize("axis", ["X", "Y"])
@pytest.mark.parametrize("pose", [1, 2])
def test_a_frame_missing_before_the_time_between_visits_is_known(
    tmp_path, monkeypatch, delays, axis, pose
):
    record(tmp_path, monkeypatch, 6, delays, missing={(axis, pose)})
    assert poses_of(tmp_path)[-3:] == [4, 5, 6]


def record(tmp_path, monkeypatch, poses, delays, **faults):
    ports = {
        axis: lambda c, a=axis: Script(c, pushes=sent(a, poses, delay=delays[a], **faults))
        for axis in delays
    }

    class UntilQuiet(Orders):
        def poll(self):
            return Quit() if clock.now() > 5.0 * poses + 60 else None

    clock = StreamClock(paced=False)
    clock.watch(lambda: 5.0 * poses + 61)
    return run_session(
        tmp_path, [GAUGES[axis] for axis in delays], ports=ports, trigger="data", clock=clock,
        cycles=31, monkeypatch=monkeypatch, operator=UntilQuiet(),
    )  # fmt: skip


def poses_of(tmp_path):
    run = read_table(tmp_path / "run.csv")
    columns = [axis.readings.tolist() for axis in run.axes.values()]
    assert all(len(set(row)) == 1 for row in zip(*columns, strict=True))
    return [round(value * 1000) - 100 for value in columns[0]]


@pytest.mark.parametrize(
    "delays", [{"X": 0.0, "Y": 1.0}, {"X": 1.0, "Y": 0.0}, {"X": 0.0, "Y": 0.0}]
)
@pytest.mark.parametrize("axis", ["X", "Y"])
def test_one_damaged_frame_mixes_no_poses(tmp_path, monkeypatch, delays, axis):
    record(tmp_path, monkeypatch, 6, delays, damaged={(axis, 3)})
    assert poses_of(tmp_path) == [1, 2, 4, 5, 6]


@pytest.mark.parametrize("delays", [{"X": 0.0, "Y": 1.0}, {"X": 1.0, "Y": 0.0}])
@pytest.mark.parametrize("axis", ["X", "Y"])
def test_one_missing_frame_mixes_no_poses(tmp_path, monkeypatch, delays, axis):
    said = record(tmp_path, monkeypatch, 6, delays, missing={(axis, 3)})
    assert poses_of(tmp_path) == [1, 2, 4, 5, 6]
    assert [v.cycle for v in said if isinstance(v, Voided)] == [3]


@pytest.mark.parametrize("seed", range(30))
def test_any_faults_of_three_gauges_mix_no_poses(tmp_path, monkeypatch, seed):
    rng = random.Random(seed)  # noqa: S311 - faults, not secrets
    delays = {axis: round(rng.uniform(0, 1.5), 2) for axis in GAUGES}
    each = [(axis, pose) for axis in GAUGES for pose in range(3, 30)]
    faults = rng.sample(each, 8)
    try:
        record(tmp_path, monkeypatch, 30, delays, damaged=set(faults[:4]), missing=set(faults[4:]))
    except InstrumentError:
        pytest.fail("no cycle at all")
    poses = poses_of(tmp_path)
    assert len(poses) >= 30 - len({pose for _, pose in faults}) - 4


def test_a_damaged_frame_sent_again_asks_for_all_again(tmp_path, monkeypatch):
    x = [(5.0, line(1)), (10.0, line(2)), (12.0, line(2))]
    y = [(5.5, line(1)), (10.5, b"+00\r"), (11.5, line(2))]
    said = run_session(
        tmp_path, [GAUGES["X"], GAUGES["Y"]], trigger="data", cycles=2, monkeypatch=monkeypatch,
        ports={"X": lambda c: Script(c, pushes=x), "Y": lambda c: Script(c, pushes=y)},
    )  # fmt: skip
    assert poses_of(tmp_path) == [1, 2]
    assert stored(said, "X") == [(1, "0.101"), (2, "0.102"), (2, "0.102")]


def all_heard(axes, *frames, one_pose=True):
    visits = Visits(axes, present=(), timed=True, one_pose=one_pose)
    return [visits.hear(*frame) for frame in frames]


def test_one_gauge_alone_breaks_nothing():
    heard = all_heard("X", ("X", 1.0, "1"), ("X", 2.0, "2"), ("X", 9.0, "3"))
    assert not any(one.doubt or one.refused for one in heard)


def test_a_reading_asked_for_again_is_taken_however_late_it_comes():
    visits = Visits("X", present=(), timed=True, one_pose=True)
    for time, text in ((0.0, "0.521"), (2.0, "0.522"), (4.0, "0.5")):
        visits.hear("X", time, text)
    visits.forget("X")
    heard = visits.hear("X", 9.0, "0.520")
    assert (heard.doubt, heard.refused) == ("", "")


def test_a_frame_sent_twice_is_refused_at_one_pose_and_a_doubt_in_a_tour():
    frames = [("X", 0.0, "1"), ("Y", 1.0, "2"), ("X", 1.7, "1")]
    assert all_heard("XY", *frames)[-1].refused == "X sent twice"
    assert all_heard("XY", *frames, one_pose=False)[-1].back
    another = [*frames[:2], ("X", 1.7, "3")]
    assert all_heard("XY", *another)[-1].back


def test_a_whole_visit_with_a_damaged_frame_is_refused_and_kept_by_none():
    damaged = all_heard("XY", ("X", 0.0, "1"), ("Y", 0.5, None))[-1]
    assert damaged.refused
    assert damaged.kept == frozenset()


def test_frames_of_two_visits_are_parted_at_the_longest_gap():
    heard = all_heard("XY", ("X", 0.0, "1"), ("Y", 4.0, "2"), ("X", 4.5, "2"))
    assert (heard[-1].kept, heard[-1].back) == ({"Y"}, True)


def test_a_missing_frame_does_not_stretch_the_time_between_visits():
    sent = [("Y", 1.0), ("X", 1.3), ("X", 5.3), ("X", 9.3), ("Y", 9.5), ("Y", 13.5), ("X", 13.7)]
    heard = all_heard("XY", *((axis, time, str(time)) for axis, time in sent))
    assert [bool(one.doubt) for one in heard] == [k == 3 for k in range(7)]
    assert not any(one.back or one.refused for one in heard)


QUICK = [("X", 0.0, "1"), ("Y", 0.2, "2"), ("X", 5.0, "3"), ("Y", 5.2, "4")]


def test_a_key_as_late_as_the_next_visit_is_of_that():
    heard = all_heard("XY", *QUICK, ("X", 10.0, "5"), ("Y", 14.0, "6"))
    assert heard[-1].doubt == "Y came 4.0 s later, as of the next visit"
    assert (heard[-1].kept, heard[-1].back) == (frozenset(), False)


@pytest.mark.parametrize(("text", "back"), [("3", False), ("9", True)])
def test_a_frame_near_the_visit_before_puts_that_in_doubt_unless_it_repeats_it(text, back):
    heard = all_heard("XY", *QUICK, ("X", 6.2, text), ("Y", 10.0, "6"))
    assert (bool(heard[-1].doubt), heard[-1].back) == (True, back)


def test_a_whole_visit_sent_twice_does_not_strike_all_that_follow():
    twice = [("X", 0.0, "1"), ("Y", 0.1, "2"), ("X", 0.7, "3"), ("Y", 0.8, "4")]
    more = [(a, 5.0 + 4 * k + d, f"{k}{a}") for k in range(9) for a, d in (("X", 0.0), ("Y", 1.4))]
    doubts = [bool(one.doubt) for one in all_heard("XY", *twice, *more)]
    assert any(doubts)
    assert not any(doubts[-12:])
