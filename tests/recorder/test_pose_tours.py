"""Recordings that go to several poses in every cycle."""

import io
import json
import math
from contextlib import redirect_stdout

import numpy as np
import pytest
from bench import Orders, Script, run_session
from disks import UnsyncedDisk
from hypothesis import given, strategies as st
from test_session import OPTO, script

import scara_iso
from scara_iso import read_table
from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.commands import main
from scara_iso.rawfile import Tour, raw_path
from scara_iso.recorder import (
    Gross,
    Pause,
    Problem,
    Quit,
    Refused,
    Stored,
    Take,
    Void,
    Voided,
    Waiting,
    parse_poses,
    rebuild,
)
from scara_iso.recorder.gauge import Shown
from scara_iso.recorder.ports.port import StreamClock
from scara_iso.recorder.visits import Visits

FIVE = ("P1", "P2", "P3", "P4", "P5")
X = "X=opto-rs232@sim:?pace=0"
Y = "Y=mitutoyo-mux@sim:?pace=0"


def written(*argv, code=0):
    out = io.StringIO()
    with redirect_stdout(out):
        assert main([str(word) for word in argv]) == code
    return [json.loads(line) for line in out.getvalue().splitlines()]


def tours():
    names = st.lists(st.sampled_from([f"P{k}" for k in range(1, 12)]), unique=True)
    return names.map(lambda found: Tour(tuple(found)))


@given(tours(), st.integers(min_value=1, max_value=10**6))
def test_a_visit_has_one_place_and_a_place_one_visit(tour, visit):
    assert tour.visit(*tour.place(visit)) == visit
    assert tour.visit(**{"pose": None, **tour.state(visit)}) == visit


def test_every_cycle_visits_the_poses_in_their_order():
    assert [Tour(("P1", "P2")).place(k) for k in range(1, 6)] == [
        (1, "P1"), (1, "P2"), (2, "P1"), (2, "P2"), (3, "P1")
    ]  # fmt: skip
    assert [Tour().place(k) for k in (1, 2, 3)] == [(1, None), (2, None), (3, None)]
    with pytest.raises(ValueError, match="P3"):
        Tour(("P1", "P2")).visit(1, "P3")


def test_poses_are_named_once_each():
    assert parse_poses("P1, P2,P3") == ("P1", "P2", "P3") == parse_poses(["P1", "P2", "P3"])


@pytest.mark.parametrize("text", ["P1,p1", "P1,,P2", "", "=P1", "P1;x", "P\n1", "é"])
def test_what_is_no_list_of_poses_is_refused(text):
    with pytest.raises(UsageError) as found:
        parse_poses(text)
    assert "pose=P1,P2" in found.value.remedy


def test_five_poses_go_from_record_to_analyze(tmp_path):
    table = tmp_path / "run.csv"
    said = written(
        "record", table, "--gauge", X, "--gauge", Y, "--trigger", "timer:10",
        "--pose", ",".join(FIVE), "--json",
    )  # fmt: skip
    stored = [one for one in said if one["event"] == "stored"]
    assert len(stored) == 31 * 5 * 2
    assert [one["pose"] for one in stored if one["axis"] == "X"] == list(FIVE) * 31
    assert said[-1] == {
        "event": "done", "cycles": 31, "planned": 31, "table": str(table),
        "raw": str(raw_path(table)),
    }  # fmt: skip
    run = read_table(table)
    assert run.cycle.tolist() == np.repeat(np.arange(1, 32), 5).tolist()
    assert run.pose.tolist() == list(FIVE) * 31
    assert run.axes["X"].readings.tolist() == [o["value"] for o in stored if o["axis"] == "X"]
    found = scara_iso.analyze(table)
    assert [pose.label for pose in found.poses] == list(FIVE)
    assert {len(pose.rows) for pose in found.poses} == {30}


def test_a_recording_of_poses_replayed_gives_the_readings_again(tmp_path):
    run_session(tmp_path, [X], cycles=4, poses=FIVE, table="a.csv")
    again = f"X=opto-rs232@replay:{tmp_path / 'a.raw.jsonl'}"
    run_session(tmp_path, [again], cycles=4, poses=FIVE, table="b.csv", rearm_s=0.0)
    first, second = (read_table(tmp_path / name) for name in ("a.csv", "b.csv"))
    assert second.axes["X"].readings.tolist() == first.axes["X"].readings.tolist()
    assert second.pose.tolist() == first.pose.tolist()


@pytest.mark.parametrize("poses", [(), ("P2", "P1"), ("P1", "P2", "P3")])
def test_a_stream_of_poses_is_not_taken_for_others(tmp_path, poses):
    run_session(tmp_path, [X], cycles=4, poses=("P1", "P2"), table="a.csv")
    again = f"X=opto-rs232@replay:{tmp_path / 'a.raw.jsonl'}"
    with pytest.raises(UsageError) as found:
        run_session(tmp_path, [again], poses=poses, table="b.csv")
    assert found.value.remedy == "give `pose=P1,P2`"
    assert not (tmp_path / "b.csv").exists()


def test_a_struck_visit_is_asked_again_at_its_pose(tmp_path):
    orders = Orders(Take(), Take(), Void("the arm was pushed"), Take(), *[Take()] * 9)
    said = run_session(
        tmp_path, [X], cycles=2, poses=("P1", "P2"), trigger="enter", operator=orders
    )
    assert [(s.cycle, s.pose) for s in said if isinstance(s, Stored)] == [
        (1, "P1"), (1, "P2"), (1, "P2"), (2, "P1"), (2, "P2")
    ]  # fmt: skip
    assert Voided(1, ("X",), "the arm was pushed", "P2") in said
    run = read_table(tmp_path / "run.csv")
    assert run.metadata["record_01_struck"].startswith("cycle 1 at P2, X ")
    last = [s.value for s in said if isinstance(s, Stored)]
    assert run.axes["X"].readings.tolist() == [last[0], *last[2:]]


def test_a_recording_goes_on_at_the_pose_where_it_stopped(tmp_path):
    orders = Orders(*[Take()] * 4, Quit())
    run_session(tmp_path, [X], cycles=3, poses=("P1", "P2", "P3"), trigger="enter", operator=orders)
    part = read_table(tmp_path / "run.csv")
    assert part.pose.tolist() == ["P1", "P2", "P3", "P1"]
    assert part.metadata["cycles_planned"] == "3"
    said = run_session(tmp_path, [X], cycles=3, poses=("P1", "P2", "P3"), resume=True)
    assert next(s for s in said if isinstance(s, Waiting)) == Waiting(2, ("X",), "P2")
    whole = read_table(tmp_path / "run.csv")
    assert whole.cycle.tolist() == [1, 1, 1, 2, 2, 2, 3, 3, 3]
    assert "cycles_planned" not in whole.metadata
    assert whole.axes["X"].readings.tolist()[:4] == part.axes["X"].readings.tolist()


@pytest.mark.parametrize("poses", [(), ("P2", "P1"), ("P1",)])
def test_other_poses_on_resume_are_refused(tmp_path, poses):
    run_session(tmp_path, [X], cycles=2, poses=("P1", "P2"))
    before = (tmp_path / "run.csv").read_bytes()
    with pytest.raises(UsageError) as found:
        run_session(tmp_path, [X], cycles=3, poses=poses, resume=True)
    assert found.value.remedy == "give `pose=P1,P2`"
    assert (tmp_path / "run.csv").read_bytes() == before


def test_resume_takes_the_poses_of_the_raw_file(tmp_path):
    run_session(tmp_path, [X], cycles=2, poses=("P1", "P2"))
    written(
        "record", tmp_path / "run.csv", "--resume", "--gauge", X, "--cycles", "3", "--trigger",
        "timer:1", "--json",
    )  # fmt: skip
    assert read_table(tmp_path / "run.csv").pose.tolist() == ["P1", "P2"] * 3


def test_rebuild_gives_the_same_table(tmp_path):
    run_session(tmp_path, [X, Y], cycles=3, poses=("P1", "P2"))
    made = (tmp_path / "run.csv").read_bytes()
    path, _ = rebuild(tmp_path / "run.raw.jsonl", tmp_path / "again.csv", disk=UnsyncedDisk())
    assert path.read_bytes() == made


@given(
    commands=st.lists(
        st.sampled_from([Take(), Take(), Take(), Void("knocked"), Pause(), Quit()]), max_size=25
    ),
    poses=st.sampled_from([(), ("P1",), ("P1", "P2"), ("P1", "P2", "P3")]),
)
def test_whatever_the_operator_does_the_table_holds_what_was_announced(
    tmp_path_factory, commands, poses
):
    folder, tour = tmp_path_factory.mktemp("tour"), Tour(poses)
    try:
        run_session(
            folder, [X, Y], cycles=3, poses=poses, trigger="enter",
            operator=Orders(*commands, Quit()),
        )  # fmt: skip
    except InstrumentError:
        assert not (folder / "run.csv").exists()
    told = {}
    for event in run_session.said:
        match event:
            case Stored():
                told[tour.visit(event.cycle, event.pose), event.axis] = event.value
            case Voided():
                for axis in event.axes:
                    del told[tour.visit(event.cycle, event.pose), axis]
    if not told:
        return
    run = read_table(folder / "run.csv")
    labels = [None] * len(run) if run.pose is None else run.pose.tolist()
    visits = [tour.visit(*one) for one in zip(run.cycle.tolist(), labels, strict=True)]
    table = {
        (visit, name): axis.readings[k]
        for k, visit in enumerate(visits)
        for name, axis in run.axes.items()
    }
    assert table == told


def test_each_pose_has_a_level_of_its_own_for_gross_readings_and_units():
    shown = Shown(fixed_decimals=True, poses=2)
    for visit in range(1, 21):
        shown.put(visit, "10.000" if visit % 2 else "254.000")
    assert shown.changed("254.001", 22) == ""
    assert shown.far("254.001", 22) is None
    assert "25.4" in shown.changed("10.001", 22)
    assert math.isclose(float(shown.far("11.000", 21)), 1.0)


def test_a_gross_reading_names_its_pose(tmp_path, monkeypatch):
    texts = [text for _ in range(6) for text in ("0.101", "5.001")]
    said = run_session(
        tmp_path, [OPTO], ports={"X": script(*texts, "0.101", "9.001")}, cycles=7,
        monkeypatch=monkeypatch, poses=("P1", "P2"),
    )  # fmt: skip
    (gross,) = [one for one in said if isinstance(one, Gross)]
    assert (gross.cycle, gross.pose, gross.distance) == (7, "P2", 4.0)
    assert "of cycle 7 at P2 is 4 mm from the others" in gross.message
    assert not [one for one in said if isinstance(one, Problem)]


def test_ways_of_another_length_are_no_frames_sent_twice():
    visits = Visits("XY", present=(), timed=True, one_pose=False)
    time = 0.0
    for k in range(12):
        time += (20.0, 20.0, 2.0)[k % 3]
        for axis, delay in (("X", 0.0), ("Y", 0.5)):
            heard = visits.hear(axis, time + delay, f"{k}")
            assert heard.doubt == heard.refused == ""


def tour_of_keys(tmp_path, monkeypatch, frames, poses=FIVE, **more):
    """Record a tour at the DATA key; ``frames`` are axis, visit (the value too) and time."""
    sent = {a: [(t, b"+000.%03d\r" % v) for b, v, t in frames if a == b] for a in "XY"}
    gauges = [f"{axis}=opto-rs232?unit=mm@{axis}" for axis in sent]
    ends = lambda _: None  # noqa: E731 - the stream ends, and with it the session
    ports = {a: lambda c, a=a: Script(c, pushes=sent[a], answer=ends) for a in sent}
    return run_session(
        tmp_path, gauges, ports=ports, trigger="data", cycles=3, poses=poses,
        monkeypatch=monkeypatch, **more,
    )  # fmt: skip


def keys(*, lost=(), visits=15):
    """Return frames 4 s apart, the second key 1.4 s after the first, their order alternating."""
    return [
        (axis, visit, 4.0 * visit + 1.4 * (k != visit % 2))
        for visit in range(1, visits + 1)
        for k, axis in enumerate("XY")
        if (axis, visit) not in lost
    ]


def test_keys_in_alternating_order_strike_nothing(tmp_path, monkeypatch):
    said = tour_of_keys(tmp_path, monkeypatch, keys())
    assert not [one for one in said if isinstance(one, Voided | Refused)]
    run = read_table(tmp_path / "run.csv")
    for axis in run.axes.values():
        assert axis.readings.tolist() == [k / 1000 for k in range(1, 16)]


@pytest.mark.parametrize("axis", ["X", "Y"])
@pytest.mark.parametrize(("count", "visit"), [(5, 1), (5, 2), (5, 7), (5, 8), (2, 2), (2, 3)])
def test_a_lost_frame_of_a_tour_ends_it_with_what_to_do(tmp_path, monkeypatch, axis, count, visit):
    frames = keys(lost={(axis, visit)}, visits=3 * count)
    with pytest.raises(InstrumentError, match="where the arm stands") as caught:
        tour_of_keys(tmp_path, monkeypatch, frames, FIVE[:count])
    pose = f"cycle {1 + (visit - 1) // count} at P{1 + (visit - 1) % count}"
    assert f"bring the arm to {pose} and continue" in caught.value.remedy
    if visit > 1:
        readings = read_table(tmp_path / "run.csv").axes["X"].readings.tolist()
        assert readings == [k / 1000 for k in range(1, visit)]


def test_who_sits_there_is_asked_where_the_arm_stands_and_goes_on(tmp_path, monkeypatch):
    class GoesOn:
        orders = (Pause(),)

        def poll(self):
            if clock.now() < 41.0 or not self.orders:
                return None
            (order,), self.orders = self.orders, ()
            return order

    clock = StreamClock(paced=False)
    clock.watch(lambda: 41.0 if clock.now() < 41.0 else math.inf)
    early = [one for one in keys(lost={("X", 7)}) if one[1] < 10]
    later = [(axis, visit, time + 20.0) for axis, visit, time in keys() if visit > 6]
    said = tour_of_keys(
        tmp_path, monkeypatch, early + later, attended=True, operator=GoesOn(), clock=clock
    )
    (asked,) = [one.message for one in said if isinstance(one, Problem)]
    assert asked.endswith("bring the arm to cycle 2 at P2, then p goes on, or q ends")
    for axis in read_table(tmp_path / "run.csv").axes.values():
        assert axis.readings.tolist() == [k / 1000 for k in range(1, 16)]


@pytest.mark.parametrize(
    ("trigger", "pose", "said"), [("data", "P1,P2", 1), ("data", "P1", 0), ("timer:2", "P1,P2", 0)]
)
def test_who_counts_poses_by_frames_is_told_what_a_lost_one_does(tmp_path, trigger, pose, said):
    gauge = "X=opto-rs232@sim:?pace=0&every=1"
    words = ["--gauge", gauge, "--trigger", trigger, "--pose", pose, "--cycles", "3", "--json"]
    events = written("record", tmp_path / "run.csv", *words)
    notices = [one for one in events if one["event"] == "notice"]
    assert len([one for one in notices if "shifts the poses" in one["message"]]) == said
