"""Programs for robots: what they say, what they refuse, and each language played on the line."""

import json
import re
import socket
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from controllers import Dial, Krl, Rapid, Spel, StoppedError, URScript
from jsonschema import Draft202012Validator
from robots import Serving

import scara_iso
from scara_iso.base.errors import UsageError
from scara_iso.commands import main
from scara_iso.recorder import Pause, find_language, find_languages
from scara_iso.recorder.programs import ProgramPart, ProgramPlan, Served, program_id, write_program

POSES = ("P1", "P2", "P3", "P4", "P5")
SCHEMAS = Path(__file__).parents[2] / "docs" / "schemas"
LINE = "192.168.1.10:5000"
SERVED = Served("192.168.1.10", 5000)
PLAYED = {"urscript": URScript, "rapid": Rapid, "krl": Krl, "spel": Spel}
LANGUAGES = sorted(find_languages())


pytestmark = pytest.mark.usefixtures("closed")


def plan(poses=POSES, cycles=31, line=SERVED, **kwargs):
    stage = ProgramPart(program_id(poses, cycles), tuple(poses), cycles, 100.0)
    return ProgramPlan("iso_test", (stage,), 5.0, line, "0", **kwargs)


def text_of(language, found):
    return next(iter(write_program(find_languages()[language], found).values()))


def played(language, serving, poses, cycles):
    """Return a program that speaks to a recording, with what a technician fills in."""
    text = text_of(language, plan(poses, cycles, Served(*serving.where)))
    Krl.server = serving.where  # KRL has it in its XML file
    return text.replace("FULL_SPEED = 0.0", "FULL_SPEED = 3.14")


def run(language, text, dial, poses, mishaps=()):
    """Run a program to its end, or until it stops; return its controller and why it stopped."""
    controller = PLAYED[language](dial, mishaps)
    points = [one for pose in poses for one in (pose, f"appro_{pose}")]
    try:
        controller.run(text, points)
    except StoppedError as stopped:
        over = str(stopped) == "The test is over."
        return controller, "" if over else str(stopped)
    finally:
        controller.shut()
    return controller, ""


def assert_complete(table, poses, cycles):
    """Every visit is there, once, and its reading was taken at its pose and at that arrival."""
    rows = zip(table.cycle.tolist(), table.pose.tolist(), table.axes["X"].readings, strict=True)
    rows = list(rows)
    assert [row[:2] for row in rows] == [(c, p) for c in range(1, cycles + 1) for p in poses]
    arrivals = {pose: [] for pose in poses}
    for _, pose, value in rows:
        assert int(value) == int(pose[1])
        arrivals[pose].append(round(value % 1 * 1000))
    for pose in poses:
        assert arrivals[pose] == sorted(set(arrivals[pose])), pose


@pytest.mark.parametrize("language", PLAYED)
def test_a_program_is_played(language, tmp_path):
    dial, poses = Dial(), POSES[:2]
    serving = Serving(tmp_path / "run.csv", poses=poses, cycles=3, gauge=dial.gauge)
    robot, why = run(language, played(language, serving, poses, 3), dial, poses,
                     {3: "lose", 6: "drop"})  # fmt: skip
    assert why == ""
    assert_complete(serving.ended(), poses, 3)
    assert robot.shown[-1] == "The test is over."
    assert dial.arrivals == {"P1": 3, "P2": 3}


@pytest.mark.slow
@pytest.mark.parametrize("language", PLAYED)
def test_a_whole_tour_with_mishaps_on_the_way(language, tmp_path):
    """31 cycles at five poses: lost connections and answers, a refused visit, a wrong pose."""
    dial = Dial()
    serving = Serving(tmp_path / "run.csv", poses=POSES, cycles=31, gauge=dial.gauge)
    right = played(language, serving, POSES, 31)
    swapped = right.replace('P2"', 'P9"').replace('P3"', 'P2"').replace('P9"', 'P3"')
    assert swapped != right
    _, why = run(language, swapped, dial, POSES)
    assert why == "NO P2 is awaited" or "cycle 1 at P2 is awaited" in why
    _, why = run(language, right, dial, POSES, {20: "drop", 33: "lose", 34: "drop", 60: "lose"})
    assert why == ""
    assert_complete(serving.ended(), POSES, 31)


def test_a_refused_visit_stops_the_robot_and_it_goes_on_when_started_again(tmp_path):
    dial, poses = Dial(), POSES[:2]
    serving = Serving(tmp_path / "run.csv", poses=poses, cycles=3, gauge=dial.gauge)
    serving.attendant.commands.append(Pause())
    program = played("urscript", serving, poses, 3)
    robot, why = run("urscript", program, dial, poses)
    assert why == "NO paused"
    assert robot.said[-1].startswith("AT P1 cycle=1 T1_C=30.5 ")
    serving.attendant.commands.append(Pause())
    assert run("urscript", program, dial, poses)[1] == ""
    table = serving.ended()
    assert_complete(table, poses, 3)
    assert table.covariates["T6_C"].tolist() == [35.5] * 6


@pytest.mark.parametrize("language", PLAYED)
def test_a_program_of_another_test_is_refused(language, tmp_path):
    dial = Dial()
    serving = Serving(tmp_path / "run.csv", poses=POSES[:2], cycles=3, gauge=dial.gauge)
    _, why = run(language, played(language, serving, POSES[:2][::-1], 3), dial, POSES)
    assert why.startswith("NO program=")
    assert dial.arrivals == {}
    serving.stop()


def test_no_recorder_and_a_recorder_that_is_silent_stop_the_robot(monkeypatch):
    with socket.create_server(("127.0.0.1", 0)) as server:
        where = server.getsockname()
        text = text_of("urscript", plan(line=Served(*where))).replace("= 0.0  # rad", "= 1.0  #")
        monkeypatch.setattr(URScript, "byte", lambda *_: (_ for _ in ()).throw(TimeoutError))
        _, why = run("urscript", text, Dial(), POSES)
        assert why.startswith("no answer to HELLO program=")
    assert run("urscript", text, Dial(), POSES)[1] == "no connection to the recorder"
    assert run("rapid", text_of("rapid", plan(line=Served(*where))), Dial(), POSES)[1] == (
        "no connection to the recorder"
    )


def test_a_speed_that_is_not_filled_in_moves_nothing():
    dial = Dial()
    assert "fill in FULL_SPEED" in run("urscript", text_of("urscript", plan()), dial, POSES)[1]
    assert dial.at == ""


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_program_says_what_it_is_and_names_points_only(language):
    text = text_of(language, plan())
    head = "\n".join(text.splitlines()[:14])
    assert "NEVER RUN ON A CONTROLLER" in head
    assert "10 % speed in manual mode" in head
    assert "30 s without an answer, stops the robot" in head
    assert " ".join(plan().points[:6]) in head
    assert f"HELLO program={program_id(POSES, 31)} poses=5 cycles=31" in text
    for pose in POSES:
        assert re.search(rf"\bX?appro_{pose}(_q)?\b", text)
        assert f'AT {pose}"' in text or f'"{pose}"' in text
    assert " cycle=" in text
    assert "END" in text
    assert text.isascii()
    assert max(map(len, text.splitlines())) < 120
    assert text == text_of(language, plan())


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_is_written_is_described(language, capsys):
    assert main(["program", language, "--poses", "P1,P2", "--line", LINE, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    Draft202012Validator(json.loads((SCHEMAS / "program.json").read_text())).validate(found)
    assert found["run_on_a_controller"] is False
    assert found["points"] == ["appro_P1", "P1", "appro_P2", "P2"]
    assert main(["program", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    schema = json.loads((SCHEMAS / "program-languages.json").read_text())
    Draft202012Validator(schema).validate(found)
    assert language in {one["language"] for one in found["languages"]}


FOLDER = """
[test]
velocities = [100, 50]
loads = [100, 10]
cycles = 31
dwell_s = 3
approach = "both sides"
[pose.P1]
[pose.P2]
[drift]
"""


def test_a_test_s_folder_says_poses_velocities_order_and_dwell(tmp_path):
    (tmp_path / "test.toml").write_text(FOLDER)
    with pytest.raises(UsageError, match="several loads"):
        scara_iso.program("rapid", tmp_path, line=LINE)
    with pytest.raises(UsageError, match="says the dwell"):
        scara_iso.program("rapid", tmp_path, line=LINE, load=10, dwell=4)
    with pytest.raises(UsageError, match="no load of 20 %"):
        scara_iso.program("rapid", tmp_path, line=LINE, load=20)
    found = scara_iso.program("rapid", tmp_path, line=LINE, load=10)
    assert found.dwell_s == 3
    assert [(part.poses, part.speed) for part in found.stages] == [
        (("P1",), 100), (("P2",), 100), (("P1",), 50), (("P2",), 50),
    ]  # fmt: skip
    assert found.stages[2].program == program_id(("P1",), 31, "P1-v50-l10")
    (text,) = found.files.values()
    assert [float(one) for one in re.findall(r"VelSet (\S+),", text)] == [100, 100, 50, 50]
    assert "approach=-1" in text
    assert text.count("    Stop;") == 3
    alone = scara_iso.program("rapid", tmp_path, line=LINE, load=10, unattended=True)
    assert "Stop;" not in next(iter(alone.files.values()))


@pytest.mark.parametrize("language", LANGUAGES)
def test_two_sides_take_turns_and_are_said(language):
    text = text_of(language, plan(both_sides=True))
    for pose in POSES:
        assert f"appro2_{pose}" in text
    assert text.count("approach=+1") == text.count("approach=-1") == 5


@pytest.mark.parametrize(
    "name", ["", "1P", "P 1", "P1;", 'P"', "P\n1", "../P", "Pé", "P" * 17, "[b]", "iso_test", "P-1"]
)
def test_a_name_that_is_no_identifier_is_refused(name):
    with pytest.raises(UsageError):
        plan(poses=("P1", name))


@pytest.mark.parametrize(
    "line",
    ["robot:5000", "1.2.3.4", "1.2.3.4:0", "1.2.3.4:99999", "serial", "1.2.3.4:5000\n",
     "1.2.3.4;:5", "::1:5000", "1.2.3.4:\uff15"],
)  # fmt: skip
def test_an_address_that_is_not_plainly_one_is_refused(line):
    with pytest.raises(UsageError):
        scara_iso.program("rapid", poses=POSES, line=line)


def test_a_serial_line_where_the_language_has_one():
    found = scara_iso.program("spel", poses=POSES, line="serial")
    (text,) = found.files.values()
    assert "OpenCom #1" in text
    assert "#201" not in text
    assert found.line == "serial"


def test_the_connection_of_krl_is_an_xml_file_of_the_program_s_name(tmp_path, capsys):
    out = tmp_path / "acceptance.src"
    assert main(["program", "krl", "--poses", "P1,P2", "--line", LINE, "-o", str(out)]) == 0
    tree = ET.parse(tmp_path / "acceptance.xml")  # noqa: S314 - written by the program under test
    assert tree.findtext("CONFIGURATION/EXTERNAL/PORT") == "5000"
    assert tree.findtext("CONFIGURATION/EXTERNAL/IP") == "192.168.1.10"
    text = out.read_text()
    assert 'EKI_Init("acceptance")' in text
    assert text.count("\nDEF ") + text.count("\nDEFFCT ") + 1 == len(
        re.findall("\nEND(FCT)?\n", text)
    )
    assert main(["program", "krl", "--poses", "P1", "--line", LINE]) == 2
    assert "2 files" in capsys.readouterr().err


def test_a_file_that_is_there_stays_unless_it_is_to_be_replaced(tmp_path, capsys):
    out = tmp_path / "acceptance.xml"
    out.write_text("mine")
    words = ["program", "krl", "--poses", "P1", "--line", LINE, "-o", str(tmp_path / "acceptance")]
    assert main(words) == 73
    assert "--replace" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["acceptance.xml"]
    assert list(find_languages()["krl"].endings) == [".src", ".xml"]
    assert out.read_text() == "mine"
    assert main([*words, "--replace"]) == 0
    assert "ETHERNETKRL" in out.read_text()
    assert main([*words[:-1], str(tmp_path / "acceptance.mod")]) == 2


@pytest.mark.parametrize(("key", "meant"), [("Rapit", "rapid"), ("7", None)])
def test_a_language_that_is_not_known_is_answered_by_the_nearest_and_all(key, meant):
    with pytest.raises(UsageError, match=f"unknown language '{key}'") as caught:
        find_language(key)
    nearest = f"did you mean {meant}? " if meant else ""
    assert caught.value.remedy == f"{nearest}known: {', '.join(LANGUAGES)}"


@pytest.mark.parametrize("dwell", [0.0, 3600.0])
def test_a_robot_may_rest_for_no_time_or_an_hour(dwell):
    found = scara_iso.program("rapid", poses=["P1"], cycles=3, line=LINE, dwell=dwell)
    assert found.dwell_s == dwell


@pytest.mark.parametrize("dwell", [-0.1, 3600.1])
def test_another_rest_is_refused(dwell):
    with pytest.raises(UsageError, match="a dwell of"):
        scara_iso.program("rapid", poses=["P1"], cycles=3, line=LINE, dwell=dwell)
