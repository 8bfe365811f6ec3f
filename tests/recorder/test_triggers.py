"""A reading is taken when the dial came to rest, or when the robot says that it is there."""

import os
import socket
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from scara_iso import read_table, recorder
from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.base.files import Disk
from scara_iso.rawfile import Tour
from scara_iso.recorder import (
    Job,
    RecordingPlan,
    RobotLine,
    Settled,
    choose_clock,
    parse_gauges,
    parse_trigger,
)
from scara_iso.recorder.events import Noticed, Quit, Stored
from scara_iso.recorder.ports.port import Port
from scara_iso.recorder.robot_line import RobotOperator
from scara_iso.recorder.visits import AtRest

DIVISION = {"X": 0.001}
SIM = "X=opto-rs232@sim:?pace=0&scatter=0.01"


def visits(readings, *, last=None, step=0.1, rule=None):
    """Return the numbers of the readings at which a dial is said to have arrived."""
    watch = AtRest(rule or Settled(), {None: last} if last else {})
    found = []
    for k, value in enumerate(readings):
        if watch.arrived(k * step, {"X": value}, DIVISION):
            found.append(k)
            watch.stored({"X": value})
    return found


AWAY, THERE = [3.0] * 15, [0.500] * 15


def test_each_return_is_one_visit_and_a_free_plunger_is_none():
    assert visits([*AWAY, *THERE, *AWAY, *THERE, *THERE, *AWAY]) == [25, 55]


def test_a_dial_that_does_not_move_is_no_visit():
    assert visits(THERE * 5) == []
    assert visits(THERE * 5, last={"X": 0.5}) == []


def test_a_dial_that_is_restless_by_more_than_a_division_has_not_arrived():
    assert visits([*AWAY, *([0.500, 0.502] * 30)]) == []
    assert visits([*AWAY, *([0.500, 0.501] * 30)]) == [25]


def test_a_creeping_dial_has_not_arrived_while_it_creeps():
    creeping = [0.5 + 0.0004 * k for k in range(30)]
    assert visits([*AWAY, *creeping, *([0.512] * 15)])[0] >= 15 + 30 + 6


def test_a_rest_far_from_the_visits_before_is_none():
    assert visits([*AWAY, *([1.2] * 15), *AWAY, *THERE], last={"X": 0.5}) == [55]


def tour(readings, poses, *, visits=None, step=0.1):
    """Return the numbers of the readings that are taken, with the pose that each is taken for."""
    watch = AtRest(Settled(), visits or {})
    found = []
    for k, value in enumerate(readings):
        pose = poses[len(found) % len(poses)]
        if watch.arrived(k * step, {"X": value}, DIVISION, pose):
            found.append((k, pose))
            watch.stored({"X": value}, pose)
    return found


P2 = [10.200] * 15


def test_of_a_tour_each_pose_has_its_place():
    cycle = [*AWAY, *THERE, *AWAY, *P2]
    assert tour(cycle * 2, ("P1", "P2")) == [(25, "P1"), (55, "P2"), (85, "P1"), (115, "P2")]


def test_a_pose_left_out_by_the_arm_is_not_taken_for_the_next():
    left_out = [*AWAY, *THERE]
    assert tour([*AWAY, *THERE, *AWAY, *P2, *left_out, *left_out, *AWAY, *P2], ("P1", "P2")) == [
        (25, "P1"), (55, "P2"), (85, "P1"), (145, "P2"),
    ]  # fmt: skip


def test_a_resumed_tour_knows_where_its_poses_are():
    known = {"P2": {"X": 10.2}, "P1": {"X": 0.5}}
    assert tour([*AWAY, *THERE, *AWAY, *P2], ("P2", "P1"), visits=known) == [(55, "P2")]


def test_all_axes_have_to_rest():
    watch = AtRest(Settled(), {})
    size = {"X": 0.001, "Y": 0.001}
    arrived = [
        watch.arrived(0.1 * k, {"X": 3.0 if k < 5 else 0.5, "Y": 0.2 + 0.01 * k}, size)
        for k in range(40)
    ]
    assert not any(arrived)


def job(path, trigger, cycles, **metadata):
    plan = RecordingPlan(parse_trigger(trigger), cycles, rearm_s=0.0)
    return Job(path, parse_gauges([SIM]), plan, metadata)


class Watcher:
    """Nobody at the keyboard, who ends the session when told to."""

    def __init__(self):
        self.heard = []
        self.over = threading.Event()

    def poll(self):
        return Quit() if self.over.is_set() else None


def record(work, operator):
    clock = choose_clock(spec.address for spec in work.gauges)
    recorder.record(work, disk=Disk(), clock=clock, operator=operator, tell=operator.heard.append)
    return read_table(work.table)


def test_a_settled_recording_has_one_reading_a_visit(tmp_path):
    run = record(job(tmp_path / "run.csv", "settled", 6), Watcher())
    assert len(run) == 6
    gaps = run.covariates["time_s"][1:] - run.covariates["time_s"][:-1]
    assert gaps == pytest.approx(4.0, abs=0.2)  # the simulated arm's
    assert abs(run.axes["X"].readings - run.axes["X"].readings.mean()).max() < 0.1  # never away
    assert len({*run.axes["X"].readings.tolist()}) > 1  # and at each visit anew


class Robot:
    """A robot's server that says lines and hears the answers."""

    def __init__(self):
        self.server = socket.create_server(("127.0.0.1", 0))
        self.address = f"socket://127.0.0.1:{self.server.getsockname()[1]}"
        self.heard = b""

    def says(self, lines, over=None):
        """Say each line once the one before was answered."""

        def run():
            line, _ = self.server.accept()
            with line:
                for said in lines:
                    line.sendall(said)
                    while said.endswith(b"\n") and not self.heard.endswith(b"\n"):
                        self.heard += line.recv(100)
                    self.heard += b" "
                if over is not None:
                    over.set()
                    line.recv(100)

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        return thread


@pytest.fixture
def robot():
    """Return a robot that listens."""
    found = Robot()
    with found.server:
        yield found


def test_the_robot_says_when_and_is_told_what_is_on_the_disk(tmp_path, robot):
    thread = robot.says([b"AT P3\r\n", b"at p", b"3\r\n", b"AT P3\n"])
    run = record(job(tmp_path / "run.csv", robot.address, 3, pose="P3"), Watcher())
    thread.join(10)
    assert len(run) == 3
    assert robot.heard.split() == b"OK 1 OK 2 OK 3".split()


def test_another_pose_is_not_taken(tmp_path, robot):
    operator = Watcher()
    robot.says([b"AT P3\n", b"AT P2\n", b"MOVING\n", b"AT P3\n"], operator.over)
    run = record(job(tmp_path / "run.csv", robot.address, 31, pose="P3"), operator)
    assert len(run) == 2
    told = [said.message for said in operator.heard if isinstance(said, Noticed)]
    assert "the robot says 'AT P2', not taken: P3 is awaited" in told
    assert "the robot says 'MOVING', not taken: no line such as AT P3" in told


def test_the_pose_awaited_follows_the_tour(tmp_path, robot):
    operator = Watcher()
    lines = [b"AT P2\n", b"AT P1\n", b"AT P1\n", b"AT P2\n", b"AT P1\n", b"AT P2\n"]
    thread = robot.says(lines)
    tour = Tour(("P1", "P2"))
    plan = RecordingPlan(parse_trigger(robot.address), 2, rearm_s=0.0, tour=tour)
    run = record(Job(tmp_path / "run.csv", parse_gauges([SIM]), plan, {}), operator)
    thread.join(10)
    assert list(zip(run.cycle, run.pose, strict=True)) == [
        (1, "P1"), (1, "P2"), (2, "P1"), (2, "P2"),
    ]  # fmt: skip
    told = [said.message for said in operator.heard if isinstance(said, Noticed)]
    assert told == [
        "the robot says 'AT P2', not taken: P1 is awaited",
        "the robot says 'AT P1', not taken: P2 is awaited",
    ]


def test_the_first_pose_named_is_that_of_a_table_without_one(tmp_path, robot):
    operator = Watcher()
    robot.says([b"AT P4\n", b"AT P1\n"], operator.over)
    assert len(record(job(tmp_path / "run.csv", robot.address, 31), operator)) == 1


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals here")
def test_the_robot_s_line_may_be_serial(tmp_path):
    ours, theirs = os.openpty()
    operator = Watcher()

    def tell(said):
        operator.heard.append(said)
        if isinstance(said, recorder.Waiting):
            os.write(ours, b"AT P1\r\n")

    work = job(tmp_path / "run.csv", f"line:{os.ttyname(theirs)}", 4, pose="P1")
    clock = choose_clock(spec.address for spec in work.gauges)
    recorder.record(work, disk=Disk(), clock=clock, operator=operator, tell=tell)
    assert len(read_table(work.table)) == 4
    os.close(ours)
    os.close(theirs)


class Line(Port):
    """A port that holds what has arrived."""

    address = "line"

    def __init__(self, *arrivals):
        self.arrivals = list(arrivals)
        self.sent = b""

    def read(self):
        return self.arrivals.pop(0) if self.arrivals else b""

    def write(self, data):
        self.sent += data


class Silent:
    """A journal that keeps nothing."""

    def append(self, *_, **__):
        """Keep nothing."""

    def sync(self):
        """Flush nothing."""


@pytest.mark.parametrize(("in_order", "taken"), [(False, 1), (True, 2)])
def test_a_line_that_came_while_a_reading_was_taken_is_late(in_order, taken):
    line, heard = Line(b"AT P1\n", b"AT P1\n"), []
    work = job(Path("run.csv"), "line:x", 31, pose="P1")
    gauges = work.gauges if in_order else parse_gauges(["X=opto-rs232@/dev/ttyUSB0"])
    says = RobotOperator(line, Watcher(), job=replace(work, gauges=gauges), journal=Silent(),
                         tell=heard.append)  # fmt: skip
    assert sum(says.poll() is not None for _ in range(4)) == taken
    assert (b"NO came while" in line.sent) is not in_order


@pytest.mark.parametrize("text", ["settled", "settled?rest=2&within=2&away=1", "line:/dev/ttyS9",
                                  "socket://robot:5000"])  # fmt: skip
def test_a_trigger_is_spelled_as_it_is_written_down(text):
    trigger = parse_trigger(text)
    assert parse_trigger(str(trigger)) == trigger
    assert isinstance(trigger, Settled | RobotLine)


def test_every_option_of_a_dial_at_rest_is_taken():
    assert parse_trigger("settled?rest=2&within=3&away=0.25") == Settled(2.0, 3.0, 0.25)


@pytest.mark.parametrize(
    "text", ["settled?rest=0", "settled?pause=1", "line:", "settle", "timer:1e-320"]
)
def test_what_is_no_trigger_is_refused(text):
    with pytest.raises(UsageError):
        parse_trigger(text)


def test_a_robot_that_says_all_and_leaves_is_heard(tmp_path, robot):
    def run():
        line, _ = robot.server.accept()
        with line:
            line.sendall(b"AT P1\n" * 3)

    threading.Thread(target=run, daemon=True).start()
    assert len(record(job(tmp_path / "run.csv", robot.address, 3, pose="P1"), Watcher())) == 3


def test_nothing_is_stored_while_the_robot_is_silent(tmp_path, robot):
    operator = Watcher()
    robot.says([b""], operator.over)
    with pytest.raises(InstrumentError, match="no reading"):
        record(job(tmp_path / "run.csv", robot.address, 3), operator)
    assert not [said for said in operator.heard if isinstance(said, Stored)]
