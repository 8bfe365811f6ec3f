"""The robot paces the test: its line, a server that listens for it, and what may go wrong there."""

import json
import random
import socket
import time
from dataclasses import replace
from itertools import product
from pathlib import Path
from unittest.mock import Mock

import pytest
from controllers import Dial
from jsonschema import Draft202012Validator
from robots import OPEN, SIM, Arm, Attendant, Serving

from scara_iso import read_table
from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.base.files import Disk
from scara_iso.base.published import to_json
from scara_iso.commands import main
from scara_iso.rawfile import raw_path, read_history, read_records
from scara_iso.recorder import (
    Job,
    Noticed,
    Pause,
    RecordingPlan,
    RobotLine,
    Take,
    Unattended,
    Void,
    choose_clock,
    parse_gauges,
    parse_trigger,
    record,
)
from scara_iso.recorder.ports.listening import ListeningLine, SocketLine, listen_address
from scara_iso.recorder.robot_line import (
    LONGEST,
    MOST_WAITING,
    LineError,
    RobotOperator,
    RobotSaid,
    parse_robot_line,
    split_lines,
)

POSES = ("P1", "P2", "P3")


pytestmark = pytest.mark.usefixtures("closed")


def until(holds):
    """Wait for what another thread does."""
    for _ in range(2000):
        if holds():
            return
        time.sleep(0.005)
    raise AssertionError


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as free:
        return free.getsockname()[1]


def noticed(serving):
    return [said.message for said in serving.attendant.heard if isinstance(said, Noticed)]


def test_what_a_line_says():
    assert parse_robot_line("AT P3 T1=31.2 speed=250") == RobotSaid(
        "AT", "P3", None, {"T1": "31.2", "speed": "250"}
    )
    assert parse_robot_line("at p3 cycle=5") == RobotSaid("AT", "p3", 5, {})
    assert parse_robot_line("HELLO program=3f2a poses=5") == RobotSaid(
        "HELLO", "", None, {"program": "3f2a", "poses": "5"}
    )
    assert parse_robot_line("end") == RobotSaid("END")


@pytest.mark.parametrize(
    "line",
    ["AT", "AT 3", "MOVING", "", "AT P3 T1", "AT P3 T1=", "AT P3 T1=hot", "AT P3 T1=1_0",
     "AT P3 T1=nan", "AT P3 cycle=0", "AT P3 cycle=1.5", "AT P3 cycle=-1", "AT P3 a=1 a=2",
     "AT ../P3", "AT [bold]P3", "HELLO who=me", "END now", "AT P3 " + "x" * LONGEST,
     "AT P3 T1=\u0661"],
)  # fmt: skip
def test_what_says_nothing_known_is_refused(line):
    with pytest.raises(LineError):
        parse_robot_line(line)


def test_a_line_of_two_hundred_characters_is_one_and_a_longer_one_is_none():
    line = "AT P3 T1=1." + "5" * 189
    assert parse_robot_line(line).stated == {"T1": line[9:]}
    with pytest.raises(LineError):
        parse_robot_line(line + "5")


class Talkative:
    """A port at which a robot says many lines at once."""

    address, ended = "listen://127.0.0.1:5000", False

    def __init__(self, said):
        self.said, self.written = said, []
        self.write = self.written.append

    def read(self):
        said, self.said = self.said, b""
        return said

    def changes(self):
        return []


def test_a_robot_may_say_a_whole_test_at_once_and_a_flood_is_answered_once(tmp_path):
    for lines in (MOST_WAITING, MOST_WAITING + 1):
        port, attendant = Talkative(b"HELLO\n" * lines), Attendant()
        plan = RecordingPlan(RobotLine(port.address, port), 3, rearm_s=0.0)
        job = Job(tmp_path / "run.csv", parse_gauges([SIM]), plan, {})
        RobotOperator(
            port, attendant, job=job, journal=Mock(), tell=attendant.heard.append
        ).poll()  # fmt: skip
        taken = lines == MOST_WAITING
        assert len(port.written) == (lines if taken else 1)
        assert port.written[-1].startswith(b"OK" if taken else b"NO more than 10000 lines")


def test_lines_come_in_any_pieces_and_an_endless_one_takes_no_memory():
    text = b"AT P1\r\nAT P2\n\n" + b"x" * 5000 + b"AT P3\nEND\n"
    for size in (1, 3, 7, 1000):
        found, begun = [], b""
        for k in range(0, len(text), size):
            lines, begun = split_lines(begun, text[k : k + size])
            found += lines
            assert len(begun) <= LONGEST + 1
        assert found[:2] + found[3:] == ["AT P1", "AT P2", "END"]
        with pytest.raises(LineError):
            parse_robot_line(found[2])
    lines, begun = split_lines(b"", b"y" * 10**6)
    assert not lines
    assert len(begun) == LONGEST + 1


@pytest.mark.parametrize(
    "text",
    ["listen://", "listen://robot:5000", "listen://127.0.0.1", "listen://127.0.0.1:0",
     "listen://0.0.0.0:5000", "listen://[::]:5000", "listen://127.0.0.1:5000?to=1.2.3.4",
     "listen://0.0.0.0:5000?from=robot", "listen://1.2.3.4.5:5000", "listen://127.0.0.1:99999"],
)  # fmt: skip
def test_an_address_that_is_not_plainly_one_is_refused(text):
    with pytest.raises(UsageError):
        parse_trigger(text)


def test_an_address_and_the_robot_that_may_connect():
    assert listen_address("listen://127.0.0.1:5000") == ("127.0.0.1", 5000, None)
    assert listen_address("listen://[::]:5000?from=10.0.0.2") == ("::", 5000, "10.0.0.2")
    text = "listen://0.0.0.0:5000?from=10.0.0.2"
    assert str(parse_trigger(text)) == text


def test_only_the_robot_that_is_named_may_connect(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    line = ListeningLine(f"listen://0.0.0.0:{port}?from=10.255.0.1")
    OPEN.append(line)
    arm = Arm(("127.0.0.1", port))
    until(lambda: line.read() == b"" and line.changes())
    assert arm.answer() == "NO not the robot that `from` names"
    with pytest.raises(InstrumentError, match="cannot be listened on"):
        ListeningLine(f"listen://127.0.0.1:{port}")
    line.close()


def test_a_robot_that_says_no_hello_is_answered_at_its_end(tmp_path):
    serving = Serving(tmp_path / "run.csv", cycles=2)
    arm = Arm(serving.where)
    assert [arm.says(f"AT P1 cycle={cycle}") for cycle in (1, 2)] == ["OK 1", "OK 2"]
    assert arm.says("END") == "OK 2"
    assert len(serving.ended()) == 2


def test_a_recorded_robot_that_has_said_all_ends_the_recording(tmp_path):
    serving = Serving(tmp_path / "run.csv", cycles=2)
    arm = Arm(serving.where)
    assert [arm.says(f"AT P1 cycle={cycle}") for cycle in (1, 2)] == ["OK 1", "OK 2"]
    serving.ended()
    trigger = RobotLine(f"replay:{tmp_path}/run.raw.jsonl")
    job = replace(
        serving.job,
        table=tmp_path / "more.csv",
        plan=replace(serving.job.plan, trigger=trigger, cycles=9),
    )
    clock = choose_clock(spec.address for spec in job.gauges)
    record(job, disk=Disk(), operator=Unattended(), clock=clock, tell=lambda _: None)
    assert read_table(tmp_path / "more.csv").cycle.tolist() == [1, 2]


def test_every_visit_is_at_its_pose_with_what_the_robot_stated(tmp_path):
    serving = Serving(tmp_path / "run.csv", poses=POSES, cycles=3)
    arm = Arm(serving.where)
    assert arm.says("HELLO poses=3 cycles=3") == "OK 0"
    for cycle in (1, 2, 3):
        for k, pose in enumerate(POSES):
            assert (
                arm.says(f"AT {pose} cycle={cycle} T1={20 + cycle}.{k} speed=250") == f"OK {cycle}"
            )
    assert arm.says("END") == "OK 3"
    run = serving.ended()
    assert list(zip(run.cycle.tolist(), run.pose.tolist(), strict=True)) == [
        (cycle, pose) for cycle in (1, 2, 3) for pose in POSES
    ]
    assert run.covariates["T1"].tolist() == [21.0, 21.1, 21.2, 22.0, 22.1, 22.2, 23.0, 23.1, 23.2]
    assert set(run.covariates) == {"time_s", "T1", "speed"}


def test_a_visit_on_the_disk_is_answered_and_not_read_again(tmp_path):
    serving = Serving(tmp_path / "run.csv", poses=POSES, cycles=2)
    arm = Arm(serving.where)
    assert arm.says("AT P1 cycle=1") == "OK 1"
    assert arm.says("AT P1 cycle=1") == "OK 1"  # the first answer was lost
    assert arm.says("AT P2 cycle=1") == "OK 1"
    assert arm.says("AT P1 cycle=1") == "OK 1"
    assert arm.says("AT P2") == "NO P3 is awaited"
    assert arm.says("AT P1 cycle=2") == "NO cycle 1 at P3 is awaited"
    assert arm.says("AT P3 cycle=3") == "NO 2 cycles are recorded"
    assert arm.says("AT P9 cycle=1") == "NO P3 is awaited"
    assert arm.says("END").startswith("NO 4 visits are missing, from cycle 1 at P3 on")
    serving.stop()
    assert len(read_history(raw_path(tmp_path / "run.csv")).readings()["X"]) == 2


def test_the_last_answer_may_be_asked_for_again_and_a_dropped_line_comes_back(tmp_path):
    serving = Serving(tmp_path / "run.csv", poses=POSES[:2], cycles=1)
    arm = Arm(serving.where)
    arm.says("HELLO")
    arm.says("AT P1 cycle=1")
    arm.send("AT P2 cyc")
    arm.leave()  # in the middle of a line
    arm = Arm(serving.where)
    assert arm.says("AT P2").startswith("NO reconnected")
    arm.send("AT P2 cycle=1")
    arm.leave()  # before the answer
    arm = Arm(serving.where)
    assert arm.says("AT P2 cycle=1") == "OK 1"
    assert arm.says("END") == "OK 1"
    run = serving.ended()
    assert len(run) == 2
    states = [r["state"] for _, r in read_records(raw_path(tmp_path / "run.csv"))
              if r["event"] == "connection"]  # fmt: skip
    assert states == ["connected", "lost", "connected", "lost", "connected"]


def test_after_a_reconnection_the_operator_says_where_the_arm_stands(tmp_path):
    serving = Serving(tmp_path / "run.csv", cycles=2)
    arm = Arm(serving.where)
    assert arm.says("AT P1") == "OK 1"
    arm.leave()
    arm = Arm(serving.where)
    assert arm.says("AT P1").startswith("NO reconnected")
    serving.attendant.commands.append(Take())
    until(lambda: not serving.attendant.commands)
    assert arm.says("AT P1") == "OK 2"
    assert len(serving.ended()) == 2


def test_a_second_robot_is_refused_and_the_first_goes_on(tmp_path):
    serving = Serving(tmp_path / "run.csv", cycles=2)
    first = Arm(serving.where)
    assert first.says("AT P1 cycle=1") == "OK 1"
    second = Arm(serving.where)
    assert second.answer() == "NO another robot is connected"
    assert first.says("AT P1 cycle=2") == "OK 2"
    assert len(serving.ended()) == 2
    assert any("refused another robot is connected" in message for message in noticed(serving))


def test_a_robot_that_leaves_and_comes_back_while_it_is_looked_at_is_no_second_robot():
    line = ListeningLine(f"listen://127.0.0.1:{free_port()}")
    OPEN.append(line)
    where = listen_address(line.address)[:2]
    arm = Arm(where)
    until(lambda: line.read() or line._peer)

    class Leaving:
        """Nothing has come, and then it leaves and comes back at once."""

        def __init__(self, peer):
            self.peer = peer

        def recv(self, _most):
            line._peer = self.peer
            arm.leave()
            OPEN.append(Arm(where))
            raise BlockingIOError

    line._peer = Leaving(line._peer)
    line.changes()
    found = []
    until(lambda: line.read() or found.extend(line.changes()) or len(found) > 1)
    assert [change.state for change in found] == ["lost", "connected"]


def test_a_program_of_another_test_is_refused(tmp_path):
    serving = Serving(tmp_path / "run.csv", poses=POSES, cycles=2, program="aaaa1111",
                      recorded={"bbbb2222": 31})  # fmt: skip
    arm = Arm(serving.where)
    assert arm.says("HELLO poses=5") == "NO poses=5, and 3 is to be recorded"
    assert arm.says("HELLO program=cccc3333").startswith("NO program=cccc3333, and aaaa1111")
    assert arm.says("HELLO program=bbbb2222 poses=1 cycles=31") == "OK 31"
    assert arm.says("AT P7 cycle=31") == "OK 31"  # recorded already: nothing is read
    assert arm.says("END") == "OK 31"
    assert arm.says("HELLO program=aaaa1111 poses=3 cycles=2") == "OK 0"
    serving.stop()
    assert isinstance(serving.error, InstrumentError)  # no reading was recorded


@pytest.mark.parametrize("hello", ["HELLO program=deadbeef", "hello who=me"])
def test_no_visit_is_taken_behind_a_refused_hello_until_a_right_one(tmp_path, hello):
    serving = Serving(tmp_path / "run.csv", poses=POSES[:1], cycles=3)
    arm = Arm(serving.where)
    assert arm.says("AT P1 cycle=1") == "OK 1"  # a robot that says no HELLO is believed
    refused = arm.says(hello)
    assert refused.startswith("NO ")
    assert [arm.says(f"AT P1 cycle={k}") for k in (1, 2, 2)] == [refused] * 3
    assert arm.says("HELLO poses=1") == "OK 1"
    assert arm.says("AT P1 cycle=2") == "OK 2"
    assert arm.says(hello) == refused
    arm.leave()
    arm = Arm(serving.where)
    assert arm.says("AT P1 cycle=3") == "OK 3"
    assert arm.says("END") == "OK 3"
    assert len(serving.ended()) == 3


@pytest.mark.parametrize(
    "name",
    ["X", "cycle_", "pose", "time_s", "Theta", "temperature_F", "T1_F", "unit", "reading", "mm"],
)
def test_a_name_that_a_table_takes_for_something_else_is_refused(tmp_path, name):
    serving = Serving(tmp_path / "run.csv", cycles=1)
    arm = Arm(serving.where)
    refused = arm.says(f"AT P1 cycle=1 {name}=1")
    if name == "T1_F":
        assert refused == "OK 1"
        assert name in serving.ended().covariates
    else:
        assert refused == f"NO {name} cannot be the name of a column"
        serving.stop()


def test_a_column_with_gaps_stays_in_the_raw_file_and_is_stated(tmp_path):
    serving = Serving(tmp_path / "run.csv", cycles=3)
    arm = Arm(serving.where)
    arm.says("AT P1 cycle=1 T1=20")
    arm.says("AT P1 cycle=2 T1=21 T2=30")
    arm.says("AT P1 cycle=3 T1=22")
    run = serving.ended()
    assert set(run.covariates) == {"time_s", "T1"}
    assert run.metadata["record_columns_with_gaps"] == "T2 in 1 of 3 visits"
    assert "T2: not stated before cycle 2" in noticed(serving)


def test_a_visit_that_is_struck_is_awaited_again_with_what_is_stated_then(tmp_path):
    serving = Serving(tmp_path / "run.csv", cycles=2)
    arm = Arm(serving.where)
    arm.says("AT P1 cycle=1 T1=20")
    serving.attendant.commands.append(Void("bumped"))
    until(lambda: not serving.attendant.commands)
    assert arm.says("AT P1 cycle=1 T1=25") == "OK 1"
    assert arm.says("AT P1 cycle=2 T1=26") == "OK 2"
    assert serving.ended().covariates["T1"].tolist() == [25.0, 26.0]


def test_nothing_is_taken_while_the_recording_is_paused(tmp_path):
    serving = Serving(tmp_path / "run.csv", cycles=2)
    arm = Arm(serving.where)
    arm.says("AT P1 cycle=1")
    serving.attendant.commands.append(Pause())
    until(lambda: not serving.attendant.commands)
    assert arm.says("AT P1 cycle=2") == "NO paused"
    serving.attendant.commands.append(Pause())
    until(lambda: not serving.attendant.commands)
    assert arm.says("AT P1 cycle=2") == "OK 2"
    assert len(serving.ended()) == 2


def test_a_session_that_goes_on_answers_for_the_visits_before(tmp_path):
    serving = Serving(tmp_path / "run.csv", poses=POSES, cycles=2)
    arm = Arm(serving.where)
    for pose in POSES:
        assert arm.says(f"AT {pose} cycle=1 T1=20") == "OK 1"
    serving.stop()
    serving = Serving(tmp_path / "run.csv", poses=POSES, cycles=2, resume=True)
    arm = Arm(serving.where)
    assert arm.says("HELLO poses=3 cycles=2") == "OK 1"
    for cycle in (1, 2):
        for pose in POSES:
            assert arm.says(f"AT {pose} cycle={cycle} T1=2{cycle}") == f"OK {cycle}"
    arm.says("END")
    assert serving.ended().covariates["T1"].tolist() == [20.0] * 3 + [22.0] * 3


HOSTILE = [
    b"\x00\xff\xfe\r\n", b"AT P1 cycle=99999999999\n", b"AT P9 cycle=1 X=5\n", b"A" * 3000 + b"\n",
    b"AT $(rm -rf /)\n", b"AT P1 ../../etc=1\n", b"GET / HTTP/1.1\r\n", b"AT P1 cycle=1=1\n",
    "AT P\u0661\n".encode(), b"HELLO cycles=3000\n", b"NO\n", b"OK 1\n",
]  # fmt: skip


def say_badly(arm, line, how, chance):
    """Say a line as a bad network or a stranger would; return what was answered, and the arm."""
    match how:
        case "doubled":
            arm.send(f"{line}\n{line}\n".encode())
            answer = arm.answer()
            arm.answer()
            return answer, arm
        case "lost":
            arm.send(f"{line}\n".encode()[: chance.randrange(1, len(line) + 2)])
            arm.leave()
            return "", Arm(arm.where)
        case "foreign":
            other = Arm(arm.where)
            assert other.answer().startswith("NO")
            other.leave()
        case "hostile":
            assert arm.says(chance.choice(HOSTILE)).startswith("NO")
    return arm.says(line), arm


@pytest.mark.parametrize("seed", range(8))
def test_lines_that_are_dropped_doubled_late_foreign_or_hostile_spoil_no_reading(tmp_path, seed):
    chance = random.Random(seed)  # noqa: S311 - faults, no secrets
    serving = Serving(tmp_path / "run.csv", poses=POSES, cycles=4)
    arm = Arm(serving.where)
    assert arm.says("HELLO poses=3 cycles=4") == "OK 0"
    known = {}
    for cycle, (k, pose) in product((1, 2, 3, 4), enumerate(POSES)):
        line = f"AT {pose} cycle={cycle} at={cycle * 10 + k}"
        known[cycle, pose] = cycle * 10.0 + k
        answer = ""
        while answer != f"OK {cycle}":
            assert arm.says(f"AT {pose} cycle={cycle + 1}").startswith("NO")
            how = chance.choice(["well", "doubled", "lost", "foreign", "hostile"])
            answer, arm = say_badly(arm, line, how, chance)
    assert arm.says("END") == "OK 4"
    run = serving.ended()
    found = zip(run.cycle.tolist(), run.pose.tolist(), run.covariates["at"].tolist(), strict=True)
    assert {(cycle, pose): at for cycle, pose, at in found} == known


def test_a_line_that_follows_its_answer_at_once_is_not_late(tmp_path):
    """Two hundred answers, each followed by the next line at once: the arm did not leave before."""
    serving = Serving(tmp_path / "run.csv", poses=("P1",), cycles=200)
    arm = Arm(serving.where)
    assert [arm.says(f"AT P1 cycle={k}") for k in range(1, 201)] == [
        f"OK {k}" for k in range(1, 201)
    ]
    assert len(serving.ended()) == 200


def test_a_robot_that_left_during_a_reading_is_answered_once_when_it_asks_again(tmp_path):
    """An answer to a line of the connection before would be taken for that of the next line."""
    serving = Serving(tmp_path / "run.csv", poses=POSES, cycles=3)
    for cycle, pose in product((1, 2), POSES):
        first = Arm(serving.where)
        first.send(f"AT {pose} cycle={cycle}")
        first.leave()
        arm = Arm(serving.where)
        assert arm.says(f"AT {pose} cycle={cycle}") == f"OK {cycle}"
        arm.send("HELLO cycles=9")
        assert arm.answer() == "NO cycles=9, and 3 is to be recorded"  # and not a second OK
        arm.leave()
    serving.stop()
    assert len(serving.ended()) == 6


def test_two_lines_at_once_are_one_visit_and_one_that_came_too_soon(tmp_path):
    """The arm is where the first line says; a reading for the second would be of another pose."""
    dial = Dial()
    serving = Serving(tmp_path / "run.csv", poses=POSES, cycles=1, gauge=dial.gauge)
    arm = Arm(serving.where)
    dial.move("P1")
    arm.send("AT P1 cycle=1\nAT P2 cycle=1")
    assert [arm.answer(), arm.answer()] == ["OK 1", "NO came while a reading was being taken"]
    for pose in POSES[1:]:
        dial.move(pose)
        assert arm.says(f"AT {pose} cycle=1") == "OK 1"
    assert serving.ended().axes["X"].readings.tolist() == [1.001, 2.001, 3.001]


def test_a_line_on_which_no_robot_is_says_which():
    line = ListeningLine(f"listen://127.0.0.1:{free_port()}")
    try:
        with pytest.raises(InstrumentError, match="no robot is connected") as caught:
            line.write(b"OK 1\r\n")
    finally:
        line.close()
    assert caught.value.where == line.address


def test_a_robot_s_server_that_does_not_read_is_lost_and_stays_so():
    with socket.create_server(("127.0.0.1", 0)) as server:
        line = SocketLine(f"socket://127.0.0.1:{server.getsockname()[1]}")
        peer, _ = server.accept()
        with peer:
            with pytest.raises(InstrumentError, match="does not read"):
                any(line.write(b"x" * 4096) for _ in range(10_000))
            for _ in range(2):
                with pytest.raises(InstrumentError, match="the robot's line is lost"):
                    line.read()
        line.close()


LINE_OF_RECORD = Draft202012Validator(
    json.loads((Path(__file__).parents[2] / "docs" / "schemas" / "record.json").read_text())
)


@pytest.fixture
def troubled(tmp_path, monkeypatch):
    """Record a session with a struck visit, a refused line, a lost one and a stranger."""
    monkeypatch.chdir(tmp_path)
    dial = Dial()
    serving = Serving(tmp_path / "run.csv", poses=POSES[:2], cycles=3, gauge=dial.gauge)
    arm = Arm(serving.where)
    arm.says("HELLO poses=2 cycles=3")
    for cycle in (1, 2, 3):
        for pose in POSES[:2]:
            dial.move(pose)
            if (cycle, pose) == (2, "P1"):
                arm.says("AT P2 cycle=2 T1_C=99")
                Arm(serving.where).answer()
                arm.leave()
                arm = Arm(serving.where)
            assert arm.says(f"AT {pose} cycle={cycle} T1_C={20 + cycle / 8:g}") == f"OK {cycle}"
            if (cycle, pose) == (2, "P2"):
                serving.attendant.commands.append(Void("knocked"))
                until(lambda: "voided" in events_of(serving))
                dial.move(pose)
                assert arm.says("AT P2 cycle=2 T1_C=22.25") == "OK 2"
    arm.says("END")
    return serving, serving.ended()


def events_of(serving):
    return [to_json(one)["event"] for one in serving.attendant.heard]


def test_a_robot_s_session_is_replayed_from_its_raw_file(troubled, capsys):
    _, run = troubled
    words = ["record", "again.csv", "--json", "--pose", "P1,P2", "--cycles", "3"]
    words += ["--gauge", "X=opto-rs232@replay:run.raw.jsonl", "--trigger", "replay:run.raw.jsonl"]
    assert main(words) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    for line in lines:
        LINE_OF_RECORD.validate(line)
    assert (lines[0]["event"], lines[0]["trigger"]) == ("started", "replay:run.raw.jsonl")
    again = read_table("again.csv")
    assert again.axes["X"].readings.tolist() == run.axes["X"].readings.tolist()
    assert again.pose.tolist() == run.pose.tolist()
    assert again.covariates["T1_C"].tolist() == run.covariates["T1_C"].tolist()
    assert again.covariates["T1_C"][3] == 22.25
    # asking takes 0.045 s a visit (the answer, and a second one awaited); this robot less than that
    assert again.covariates["time_s"] == pytest.approx(run.covariates["time_s"], abs=6 * 0.045)


def test_a_recorded_robot_paces_no_indicator_that_is_there(troubled, capsys):
    dial = Dial()
    words = ["record", "again.csv", "--gauge", dial.gauge, "--pose", "P1,P2"]
    assert main([*words, "--trigger", "replay:run.raw.jsonl"]) == 2
    assert "brings no arm to this indicator" in capsys.readouterr().err
    assert not Path("again.csv").exists()


def test_what_a_robot_s_session_says_is_as_described(troubled):
    serving, _ = troubled
    said = [json.loads(json.dumps(to_json(one))) for one in serving.attendant.heard]
    for line in said:
        LINE_OF_RECORD.validate(line)
    assert said[0]["trigger"] == serving.line.address
    assert said[0]["poses"] == ["P1", "P2"]
    stored = [(one["cycle"], one["pose"]) for one in said if one["event"] == "stored"]
    assert stored == [(1, "P1"), (1, "P2"), (2, "P1"), (2, "P2"), (2, "P2"), (3, "P1"), (3, "P2")]
    assert [one["reason"] for one in said if one["event"] == "voided"] == ["knocked"]
    assert said[-1] == {
        "event": "done", "cycles": 3, "planned": 3,
        "table": str(serving.job.table), "raw": str(raw_path(serving.job.table)),
    }  # fmt: skip
    messages = [one["message"] for one in said if one["event"] == "notice"]
    words = ("connected", "refused another robot is connected", "not taken: ", "lost")
    assert all(any(word in message for message in messages) for word in words)
