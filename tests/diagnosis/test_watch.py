"""The watch over a recording: what it says, when, and that nothing of the recording hears of it."""

import copy
import io
import json
import shutil
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from scara_iso import read_table, record
from scara_iso.base.published import to_json
from scara_iso.commands import Watcher, main
from scara_iso.commands.operator.keyboard import Keys
from scara_iso.commands.operator.screen import Screen
from scara_iso.diagnosis import ALARM, Monitor, Watched, live
from scara_iso.diagnosis.live import PAUSE, level_of, look
from scara_iso.rawfile import Tour, raw_path, read_history
from scara_iso.recorder import (
    CycleDone,
    Job,
    Pause,
    Paused,
    Quit,
    RecordingPlan,
    Started,
    Stored,
    Timer,
    Voided,
    Waiting,
    parse_gauges,
)
from scara_iso.render.live import LiveScreen, draw
from scara_iso.reporting import warning

EXAMPLE = Path(__file__).parents[2] / "examples" / "slipping_fixture.toml"
SLIP = "sim:?model=slipping_fixture.toml&pace=0"
X, Y = [["--gauge", f"{axis}=opto-rs232@{SLIP}"] for axis in "XY"]
TIMER = ["--trigger", "timer:10"]


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run the command beside the example; return exit code and JSON lines."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(EXAMPLE, tmp_path)

    def call(*arguments):
        code = main(["record", *arguments, "--json"])
        return code, [json.loads(line) for line in capsys.readouterr().out.splitlines()]

    return call


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the table of a watched recording in which the fixture slips, and its events."""
    table, said = tmp_path_factory.mktemp("slip") / "run.csv", []
    slip = f"sim:?model={EXAMPLE}&pace=0"
    record(table, [f"{axis}=opto-rs232@{slip}" for axis in "XY"], trigger="timer:10", watch=True,
           tell=lambda one: said.append(to_json(one)))  # fmt: skip
    return table, said


def watched(events):
    return [event for event in events if event["event"] == "watch"]


def test_a_fixture_that_slips_at_cycle_12_is_told_by_cycle_19(whole):
    events = whole[1]
    found = watched(events)
    assert [event["cycle"] for event in found] == list(range(1, 32))
    alarm = next(event for event in found if event["says"] == "structure")
    assert 14 <= alarm["cycle"] <= 19
    assert (alarm["effect"], alarm["since"]) == ("step", 12)
    assert set(alarm) == {
        "event", "cycle", "evidence", "says", "effect", "since", "share", "rivals"}  # fmt: skip
    assert alarm["share"] + sum(alarm["rivals"].values()) <= 1.001
    for event in found:
        assert (event["says"] == "structure") == (event["evidence"] >= ALARM)
        assert event["says"] in ("structure", "nothing yet")
    assert events[-1]["event"] == "done"
    assert events[-1]["cycles"] == 31


def test_off_the_wire_nothing_changes(run, tmp_path, whole):
    _, plain = run("run.csv", *X, *Y, *TIMER)
    files = [path.read_bytes() for path in sorted(tmp_path.glob("run.*"))]
    for path in tmp_path.glob("run.*"):
        path.unlink()
    _, events = run("run.csv", *X, *Y, *TIMER, "--watch")
    assert watched(plain) == []
    assert watched(events) == watched(whole[1]), "a rerun says the same"
    assert [event for event in events if event["event"] != "watch"] == plain
    assert [path.read_bytes() for path in sorted(tmp_path.glob("run.*"))] == files


def test_a_resumed_recording_says_the_same(whole, tmp_path):
    table, events = whole
    raw = raw_path(table).read_bytes().splitlines(keepends=True)
    stop = next(k for k, line in enumerate(raw) if b'"stored"' in line and b'"cycle":14' in line)
    (tmp_path / "cut.raw.jsonl").write_bytes(b"".join(raw[: stop + 1]))
    resumed = watched(_resumed(tmp_path / "cut.csv", events))
    assert resumed == watched(events)[13:]


def _resumed(table, events):
    """Hear the cycles from 14 on of a recording that is resumed, as the session tells them."""
    earlier, told = read_history(raw_path(table)), []
    watch = Watcher(_job(table, cycles=31), earlier, told.append)
    watch.hear(Started({"X": "", "Y": ""}, 14, 31, "timer:10"))
    for event in events:
        if event["event"] == "stored" and event["cycle"] >= 14:
            watch.hear(Stored(event["cycle"], event["axis"], event["value"], "0.000", "mm"))
        if event["event"] == "cycle" and event["cycle"] >= 14:
            watch.hear(CycleDone(event["cycle"], False))
            watch.hear(Waiting(event["cycle"] + 1, ("X", "Y")))
    return [to_json(said) for said in told]


def _job(table=Path("run.csv"), *, cycles=31, axes="XY", poses=(), **metadata):
    gauges = parse_gauges([f"{axis}=opto-rs232@sim:" for axis in axes], unit=None)
    return Job(table, gauges, RecordingPlan(Timer(10.0), cycles, tour=Tour(poses)), metadata)


def say_cycles(watch, values, *, first=1, unit="mm"):
    """Tell ``watch`` cycles of one axis, with the event that follows each."""
    for k, value in enumerate(values, first):
        watch.hear(Stored(k, "X", value, f"{value:.3f}", unit))
        watch.hear(CycleDone(k, False))
        watch.hear(Waiting(k + 1, ("X",)))


def last(told):
    return [said for said in told if isinstance(said, Watched)][-1]


def test_struck_cycles_take_the_alarm_with_them(rng):
    told = []
    watch = Watcher(_job(axes="X"), None, told.append)
    values = rng.normal(0, 0.01, 31) + 0.1 * (np.arange(31) >= 12)
    say_cycles(watch, values[:23])
    assert last(told).says == "structure"
    for cycle in range(23, 12, -1):
        watch.hear(Voided(cycle, ("X",), "slipped"))
    assert last(told) == Watched(12, last(told).evidence, "nothing yet")
    say_cycles(watch, rng.normal(0, 0.01, 3), first=13)
    assert last(told).cycle == 15
    assert last(told).says == "nothing yet"


def test_a_cycle_of_several_poses_is_judged_when_it_is_whole(rng):
    told = []
    watch = Watcher(_job(axes="X", poses=("P1", "P2")), None, told.append)
    for cycle in (1, 2):
        for pose in ("P1", "P2"):
            watch.hear(Stored(cycle, "X", 0.1, "0.100", "mm", pose))
            watch.hear(CycleDone(cycle, False, pose))
            watch.hear(Waiting(cycle, ("X",)))
    assert [said.cycle for said in told if isinstance(said, Watched)] == [1, 2]


def test_an_angle_that_passes_zero_is_no_step(rng):
    plain, turned = [], []
    angles = rng.normal(0, 0.01, 14)
    angles[5:] += 0.05
    say_cycles(Watcher(_job(axes="X"), None, plain.append), angles, unit="deg")
    say_cycles(Watcher(_job(axes="X"), None, turned.append), angles % 360, unit="deg")
    assert last(turned) == last(plain)
    assert last(turned).evidence > 1


def test_an_empty_raw_file_is_gone_on_with(run, tmp_path):
    (tmp_path / "run.raw.jsonl").write_bytes(b"")
    code, events = run("run.csv", *X, *TIMER, "--watch", "--resume", "--cycles", "3")
    assert code == 0
    assert [event["cycle"] for event in watched(events)] == [1, 2, 3]


def test_a_watch_that_fails_ends_and_the_recording_goes_on(monkeypatch, tmp_path):
    monkeypatch.setattr(Monitor, "take", lambda *_: 1 / 0)
    said = []
    run = record(tmp_path / "run.csv", ["X=opto-rs232@sim:?pace=0"], trigger="timer:1", cycles=5,
                 watch=True, tell=said.append)  # fmt: skip
    assert len(run) == 5
    notices = [one.message for one in said if "watch" in str(getattr(one, "message", ""))]
    assert notices == ["the watch has ended: division by zero"]


def test_what_is_known_does_not_depend_on_the_order_of_what_is_stated():
    """Readings on few divisions have ties, which a seed from the statements breaks."""
    said = []
    for stated in ({"robot": "A", "load": "1 kg"}, {"load": "1 kg", "robot": "A"}, {"robot": "B"}):
        said.append([])
        say_cycles(Watcher(_job(axes="X", **stated), None, said[-1].append), [0, 0, 0.01] * 5)
    one, again, other = ([w.evidence for w in heard if isinstance(w, Watched)] for heard in said)
    assert one == again != other


@pytest.mark.parametrize(("planned", "looks"), [(31, 11), (None, 13), (500, 13)])
def test_a_drift_test_and_a_long_plan_are_of_open_length(planned, looks, monkeypatch, rng):
    levels = []
    monkeypatch.setattr(live, "look", lambda _, level, __: levels.append(level) or 1.0)
    monitor = Monitor(planned=planned, seed=1)
    for value in rng.normal(size=37):
        monitor.take([value])
    assert len(levels) == looks
    assert levels[0] < levels[-1] if planned == 31 else levels[0] > levels[-1]


def test_a_drift_test_has_an_open_length(monkeypatch):
    planned = []
    monkeypatch.setattr(live, "level_of", lambda _, wanted: planned.append(wanted) or 0.0)
    watch = Watcher(_job(axes="X", test="drift"), None, lambda _: None)
    say_cycles(watch, [0.1, 0.2, 0.1])
    assert set(planned) == {None}


def looks(planned, until):
    return [n for n in range(1, until) if level_of(n, planned)]


def test_the_looks_are_every_two_readings_from_the_tenth_and_at_the_end():
    assert looks(30, 40) == list(range(10, 31, 2))
    assert looks(13, 40) == [10, 12, 13]
    assert looks(8, 40) == [8]
    assert looks(7, 40) == []
    assert looks(None, 40) == [*range(10, 31, 2), 33, 36, 39]


def test_the_looks_of_an_open_length_never_spend_their_level():
    spent = sum(level_of(n, None) for n in range(2000))
    assert spent < sum(level_of(n, None) for n in range(4000)) < live._OPEN


def test_the_same_cycles_in_any_unit_say_the_same(rng):
    values = rng.normal(size=(16, 2))
    first = look(values, 0.01, np.random.default_rng(1))
    assert look(1e3 * values + 7, 0.01, np.random.default_rng(1)) == first


def test_a_step_on_three_axes_raises_the_alarm_of_an_open_length(rng):
    monitor = Monitor(planned=None, seed=1)
    alarms = []
    for k in range(40):
        monitor.take((rng.normal(size=3) + 3.0 * (k >= 20)).tolist())
        alarms.append(monitor.evidence >= ALARM)
    assert not any(alarms[:20])
    assert alarms.index(True) <= 29
    assert all(late or not early for early, late in pairwise(alarms))


@pytest.mark.parametrize("width", [40, 80])
def test_the_screen_says_what_where_and_what_to_do(width):
    console = Console(width=width, file=io.StringIO(), force_terminal=True, color_system=None)
    screen = Screen(LiveScreen(console), Keys(lambda: ""), title="record run.csv", earlier={})
    screen._take(Started({"X": "a"}, 1, 31, "enter"))
    screen._warn(Watched(13, 2.0, "nothing yet"))
    assert screen._view().warning == ()
    screen._warn(Watched(19, 46.2, "structure", "step", 12, 0.97, {}))
    with console.capture() as capture:
        console.print(draw(screen._view(), console))
    lines = capture.get().splitlines()
    text = " ".join(" ".join(lines).split())
    assert "More than scatter: likeliest step (97%), since cycle 12 (evidence 46.2" in text
    assert "Check the clamps of fixture and indicator; strike cycles 12-19, or start again" in text
    assert "conform to ISO 9283" in text
    assert all(len(line) <= width for line in lines)
    assert len(screen._bells) == 2


def test_a_name_that_is_not_sure_stands_beside_its_rivals():
    rivals = {"onset": 0.2, "linear_drift": 0.12, "transient": 0.07}
    first, *_ = warning(Watched(19, 46.2, "structure", "step", 12, 0.61, rivals))
    assert "likeliest so far step (61%) or onset (20%) or linear drift (12%), since" in first
    first, *_ = warning(Watched(19, 46.2, "structure", "unknown", 12, 0.6, {"step": 0.4}))
    assert "nothing known fits yet or step (40%)" in first
    first, *_ = warning(Watched(19, 46.2, "structure", "step", 12, 0.45, {"onset": 0.4}))
    assert "too early for a cause: step (45%) or onset (40%)" in first


def test_the_share_of_a_name_is_its_probability_among_all(rng):
    monitor = Monitor(planned=31, seed=1)
    for value in rng.normal(0, 1, 31) + 3.0 * (np.arange(31) >= 12):
        monitor.take([value])
    found = monitor.watched()
    assert found.says == "structure"
    assert 0 < found.share <= 1
    assert all(0 < rival <= found.share for rival in found.rivals.values())


def test_a_pause_tells_a_drift_from_a_step():
    rng, monitor = np.random.default_rng(9), Monitor(planned=31, seed=1)
    for k in range(19):
        monitor.take([0.2 * k + rng.normal()])
    before = monitor.watched()
    assert before.effect == "step"
    assert "linear_drift" in before.rivals
    stayed, shares = copy.deepcopy(monitor), []
    monitor.pause()
    for one, stood in ((monitor, 20), (stayed, 0)):
        rng = np.random.default_rng(99)
        for k in range(19 + stood, 23 + stood):
            one.take([0.2 * k + rng.normal()])
        shares.append((one.watched().effect, one.watched().share))
    assert [effect for effect, _ in shares] == ["linear_drift", "linear_drift"]
    assert shares[0][1] > 0.8 > shares[1][1] + 0.2


def test_a_course_runs_through_a_pause_stops_in_it_or_begins_anew():
    """A drift over ten cycles, the robot at rest before the fifth; a walk only runs or stops."""
    named = [one for one in live.named_over(np.arange(1, 11), [4]) if one.effect == "linear_drift"]
    courses = [one.form.columns[:, 0] - one.form.columns[0, 0] for one in named]
    rows, behind = np.arange(10), np.arange(10) >= 4
    for course, clock in zip(
        courses, [rows, rows + PAUSE * behind, rows - 4 * behind], strict=True
    ):
        np.testing.assert_allclose(course / course[1], clock)
    walks = [one for one in live.named_over(np.arange(1, 11), [4]) if one.effect == "random_walk"]
    assert {one.form.unit.shape for one in walks} == {(10, 10)}


def test_a_pause_is_heard_and_stays_before_what_is_taken_again(rng):
    watch = Watcher(_job(axes="X"), None, lambda _: None)
    values = rng.normal(0, 0.01, 16)
    say_cycles(watch, values[:12])
    watch.hear(Paused(on=True))
    watch.hear(Paused(on=False))
    assert watch._stood == {12}
    say_cycles(watch, values[12:], first=13)
    assert watch._monitor._pauses == {12}
    watch.hear(Voided(11, ("X",), "slipped"))
    assert watch._monitor._pauses == {10}


def test_a_test_stopped_early_says_so(tmp_path, capsys):
    operator = Quits()
    record(tmp_path / "short.csv", ["X=opto-rs232@sim:?pace=0"], trigger="timer:10",
           operator=operator, tell=operator.told)  # fmt: skip
    assert read_table(tmp_path / "short.csv").metadata["cycles_planned"] == "31"
    assert main(["analyze", str(tmp_path / "short.csv"), "--cycles", "9", "--json"]) == 0
    findings = json.loads(capsys.readouterr().out)["findings"]
    (found,) = [one for one in findings if one["code"] == "stopped-early"]
    assert found["message"] == "stopped after 9 of 31 planned cycles: this is not an ISO 9283 test"


def test_a_resumed_recording_knows_where_the_operator_paused(tmp_path):
    operator = Quits(*[Pause()] * 2)
    table = tmp_path / "short.csv"
    record(table, ["X=opto-rs232@sim:?pace=0"], trigger="timer:10", operator=operator,
           tell=operator.told)  # fmt: skip
    assert read_history(raw_path(table)).pauses == [9]


class Quits:
    """An operator who ends the session after its ninth cycle, and does something before."""

    cycle = 0

    def __init__(self, *before):
        self.due = [*before, Quit()]

    def told(self, said):
        self.cycle = getattr(said, "cycle", self.cycle) - isinstance(said, Waiting)

    def poll(self):
        return self.due.pop(0) if self.cycle >= 9 and self.due else None
