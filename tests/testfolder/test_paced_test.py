"""A test that a robot paces: taught poses, all parts by one program, a pause at an alarm."""

import json
import socket
import threading
from contextlib import ExitStack

import pytest
from controllers import Dial, Rapid, StoppedError, URScript
from robots import Arm

import scara_iso
from scara_iso.base.errors import UsageError
from scara_iso.commands import main, new_test
from scara_iso.commands.operator.recording import RecordOptions, each_part, prepare
from scara_iso.diagnosis import Watched
from scara_iso.recorder import Noticed, Paused, Quit
from scara_iso.recorder.robot_line import program_id
from scara_iso.testfolder import read_folder

POSES = ("P1", "P2")
POINTS = [one for pose in POSES for one in (pose, f"appro_{pose}")]
SIM = "X=opto-rs232@sim:?pace=0&scatter=0.01"


pytestmark = pytest.mark.usefixtures("closed")


class Recording:
    """`record` of a folder in a thread, at an address of this machine."""

    def __init__(self, folder, gauge, **options):
        with socket.create_server(("127.0.0.1", 0)) as free:
            self.where = free.getsockname()
        self.line = f"{self.where[0]}:{self.where[1]}"
        self.heard, self.error, self.over = [], None, threading.Event()
        self._given = (folder, [gauge]), {"trigger": f"listen://{self.line}", **options}
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        words, options = self._given
        try:
            scara_iso.record(*words, **options, operator=self, tell=self.heard.append)
        except Exception as error:  # noqa: BLE001 - looked at in the test
            self.error = error

    def poll(self):
        return Quit() if self.over.is_set() else None

    def ended(self):
        self._thread.join(60)
        assert not self._thread.is_alive()
        assert self.error is None, self.error


def short_test(folder, cycles=3, **planned):
    """Make a test of taught poses with few cycles."""
    file = new_test(folder, poses=POSES, **planned)
    file.write_text(file.read_text().replace("cycles = 31", f"cycles = {cycles}"))
    return read_folder(folder)


def start(recording):
    """Return a robot's end of the line as soon as somebody listens."""
    for _ in range(1000):
        try:
            return Arm(recording.where)
        except ConnectionRefusedError:
            threading.Event().wait(0.01)
    raise AssertionError


def test_a_test_of_taught_poses_needs_no_model(tmp_path, capsys):
    words = ["test", "new", str(tmp_path / "a"), "--poses", "P1,P2,P3", "--velocities", "100,50"]
    assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["poses"] == ["P1", "P2", "P3"]
    assert len(found["parts"]) == 6
    test = read_folder(tmp_path / "a").test
    assert test.schedule.characteristics == ("RP",)  # AP has no command pose
    assert test.robot.model == ""
    with pytest.raises(UsageError, match="come from a model, or are taught"):
        new_test(tmp_path / "b")
    with pytest.raises(UsageError, match="not a name of a pose"):
        new_test(tmp_path / "b", poses=["P1", "../P2"])
    with pytest.raises(UsageError, match="solid is of a model"):
        new_test(tmp_path / "b", poses=["P1"], solid="box")
    assert main(["test", "new", str(tmp_path / "b"), "--poses", "P1", "--elbow", "left"]) == 2
    assert not (tmp_path / "b").exists()


def test_the_poses_of_a_test_without_a_model_are_analysed_and_their_ap_is_not_missed(tmp_path):
    folder = tmp_path / "a"
    short_test(folder, cycles=31)
    for pose in POSES:
        scara_iso.record(folder, [SIM], trigger="timer:1", part=f"{pose}-v100-l100")
    found = read_folder(folder)
    assert [state.unmeasured for state in found.parts] == [(), ()]
    assert {one.code for one in scara_iso.analyze(folder).characteristics} >= {"RP"}


@pytest.mark.slow
@pytest.mark.parametrize("language", ["urscript", "rapid"])
def test_one_program_goes_through_every_part_of_a_load(language, tmp_path):
    folder, dial = tmp_path / "a", Dial()
    short_test(folder, velocities=(100, 50), loads=(100, 10))
    scara_iso.record(folder, [SIM], trigger="timer:1", part="P2-v100-l100")  # done before
    recording = Recording(folder, dial.gauge)
    found = scara_iso.program(language, folder, line=recording.line, load=100, unattended=True)
    (text,) = found.files.values()
    robot = {"urscript": URScript, "rapid": Rapid}[language](dial, {2: "lose", 5: "drop"})
    start(recording).leave()
    with pytest.raises(StoppedError, match="over") if language == "rapid" else _nothing():
        robot.run(text.replace("FULL_SPEED = 0.0", "FULL_SPEED = 1.0"), POINTS)
    recording.ended()
    states = {state.part.name: state.is_whole for state in read_folder(folder).parts}
    assert states == {
        f"{pose}-v{velocity}-l{load}": load == 100
        for load in (100, 10) for velocity in (100, 50) for pose in POSES
    }  # fmt: skip
    for velocity in (100, 50):
        readings = scara_iso.read_table(folder / f"P1-v{velocity}-l100.csv").axes["X"].readings
        assert [int(value) for value in readings] == [1, 1, 1]
    assert dial.arrivals == {"P1": 6, "P2": 3}


class _nothing:  # noqa: N801 - like a function of contextlib
    def __enter__(self):
        return None

    def __exit__(self, *_):
        return False


def test_a_program_of_another_load_or_order_is_refused(tmp_path):
    folder = tmp_path / "a"
    short_test(folder, loads=(100, 10))
    recording = Recording(folder, SIM)
    arm = start(recording)
    for part in ("P1-v100-l10", "P2-v100-l100"):
        pose = part[:2]
        said = arm.says(f"HELLO program={program_id((pose,), 3, part)} poses=1 cycles=3")
        assert said.startswith("NO program=")
    assert arm.says(f"HELLO program={program_id(('P1',), 3, 'P1-v100-l100')}") == "OK 0"
    recording.over.set()
    recording._thread.join(60)


def test_a_robot_that_is_started_again_goes_on_behind_what_is_stored(tmp_path):
    folder = tmp_path / "a"
    short_test(folder)
    recording = Recording(folder, SIM)
    hello = [f"HELLO program={program_id((p,), 3, f'{p}-v100-l100')}" for p in POSES]
    arm = start(recording)
    assert [arm.says(line) for line in (hello[0], "AT P1 cycle=1", "AT P1 cycle=2")] == [
        "OK 0", "OK 1", "OK 2",
    ]  # fmt: skip
    arm.leave()
    arm = start(recording)
    assert [arm.says(line) for line in (hello[0], "AT P1 cycle=3", hello[1])] == [
        "OK 2", "OK 3", "OK 0",
    ]  # fmt: skip
    assert arm.says("AT P2 cycle=1") == "OK 1"
    arm.leave()
    arm = start(recording)  # from the beginning
    assert [arm.says(line) for line in (*hello, "AT P2 cycle=2", "AT P2 cycle=3", "END")] == [
        "OK 3", "OK 1", "OK 2", "OK 3", "OK 3",
    ]  # fmt: skip
    recording.ended()
    assert all(state.is_whole for state in read_folder(folder).parts)


def test_the_parts_that_follow_have_the_gauges_that_the_first_went_on_with(tmp_path):
    """Those of its raw file, to which somebody agreed, and not those of another bench."""
    folder = tmp_path / "a"
    short_test(folder)
    begun = Recording(folder, SIM)
    arm = start(begun)
    assert arm.says("AT P1 cycle=1") == "OK 1"
    arm.leave()
    begun.over.set()
    begun.ended()
    options = RecordOptions(
        table=folder, gauges=(f"{SIM}&seed=5",), remembered=True, trigger=f"listen://{begun.line}",
        confirm=lambda *_, **__: None,
    )  # fmt: skip
    first = prepare(options)
    with ExitStack() as stack:
        parts = each_part(first, stack)
        assert next(parts).part.part.name == "P1-v100-l100"
        scara_iso.record(folder, [SIM], trigger="timer:1", part="P1-v100-l100")
        following = next(parts)
    assert following.part.part.name == "P2-v100-l100"
    assert [gauge.text for gauge in following.job.gauges] == [SIM]


@pytest.mark.slow
def test_an_alarm_pauses_the_robot_until_its_program_is_started_again(tmp_path):
    folder, dial = tmp_path / "a", Dial()
    short_test(folder, cycles=31)
    dial.shown = lambda: 1.0 + dial.arrivals.get("P1", 0) ** 2 / 1000  # a drift
    recording = Recording(folder, dial.gauge, part="P1-v100-l100", pause_on_alarm=True)
    arm, refused = start(recording), []
    hello = f"HELLO program={program_id(('P1',), 31, 'P1-v100-l100')}"
    assert arm.says(hello) == "OK 0"
    for cycle in range(1, 32):
        dial.move("P1")
        answer = arm.says(f"AT P1 cycle={cycle}")
        if answer != f"OK {cycle}":
            refused.append(answer)
            assert arm.says(f"AT P1 cycle={cycle}") == answer
            assert arm.says(hello) == f"OK {cycle - 1}"
            assert arm.says(f"AT P1 cycle={cycle}") == f"OK {cycle}"
    arm.says("END")
    recording.ended()
    (said,) = refused
    assert said.startswith("NO paused: ")
    alarm = next(one for one in recording.heard if getattr(one, "says", "") == "structure")
    assert isinstance(alarm, Watched)
    assert said == f"NO paused: {alarm.effect} since cycle {alarm.since}"
    assert [one.on for one in recording.heard if isinstance(one, Paused)] == [True, False]
    assert len(scara_iso.read_table(folder / "P1-v100-l100.csv")) == 31
    assert not [
        one for one in recording.heard if isinstance(one, Noticed) and "ended" in one.message
    ]
