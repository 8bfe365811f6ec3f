"""A drift test and push tests in the folder of a whole test: recorded, counted, in one report."""

import json
import re
import shutil
import tomllib
from pathlib import Path

import pytest
from test_schemas import validator

import scara_iso
from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.files import KeyFaults
from scara_iso.commands import main, new_test
from scara_iso.iso9283 import block_of_rows
from scara_iso.testfolder import parse_test, read_folder, toml_of
from scara_iso.testfolder.whole_test import CommandPose, DriftTest, PushTest, WholeTest

EXAMPLES = Path(__file__).parents[2] / "examples"
DECLARED = """
[drift]
pose = "P1"
blocks = 4
limits = { dAP = 0.5 }

[push.joint_1]
arm_m = 0.25
limits = { lost_motion = 1.2 }

[push.joint_2]
arm_m = 0.5
"""


def of_sim(seed):
    return [f"{axis}=opto-rs232@sim:?pace=0&value=0.1&seed={seed}{axis == 'Y':d}" for axis in "XY"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the folder of a test at P1 alone, with a drift test and two push tests."""
    folder = tmp_path_factory.mktemp("whole") / "a"
    new_test(folder, EXAMPLES / "fum_scara.toml")
    path = folder / "test.toml"
    text = path.read_text("utf-8")
    first, _, rest = text.partition("[pose.P2]")
    path.write_text(f"{first}[limits]{rest.partition('[limits]')[2]}{DECLARED}", "utf-8")
    scara_iso.record(folder, of_sim(1), trigger="timer:2")
    scara_iso.record(folder, of_sim(2), trigger="timer:900")
    for joint in ("joint_1", "joint_2"):
        shutil.copy(EXAMPLES / "push.csv", folder / f"push-{joint}.csv")
    return folder


@pytest.fixture
def begun(whole, tmp_path):
    """Return a copy of it, to be changed."""
    return Path(shutil.copytree(whole, tmp_path / "a"))


def said(capsys, *words):
    capsys.readouterr()
    code = main([*map(str, words), "--json"])
    return code, json.loads(capsys.readouterr().out)


def edit(folder, before, after):
    path = folder / "test.toml"
    text = path.read_text("utf-8")
    assert before in text
    path.write_text(text.replace(before, after), "utf-8")


def test_status_counts_them_and_record_fills_them_in(whole, begun, capsys):
    code, found = said(capsys, "test", "status", whole)
    assert (code, found["complete"], found["next"]) == (0, True, None)
    parts = {part["part"]: part for part in found["parts"]}
    assert list(parts) == ["P1-v100-l100", "drift", "push-joint_1", "push-joint_2"]
    assert (parts["drift"]["pose"], parts["drift"]["cycles"]) == ("P1", 40)
    assert (parts["push-joint_1"]["velocity"], parts["push-joint_1"]["pose"]) == (None, None)
    for name in ("drift.csv", "drift.raw.jsonl", "drift.manifest.json"):
        (begun / name).unlink()
    code, found = said(capsys, "test", "status", begun)
    assert (found["next"], found["missing"], found["seconds_left"]) == ("drift", ["drift"], None)
    run = scara_iso.record(begun, of_sim(2), trigger="timer:900")
    assert (begun / "drift.csv").exists()
    assert list(block_of_rows(run)) == [k // 10 for k in range(40)]


def test_a_push_is_typed_and_not_recorded(begun):
    (begun / "push-joint_2.csv").unlink()
    with pytest.raises(UsageError) as told:
        scara_iso.record(begun, of_sim(3), trigger="timer:2")
    assert "push-joint_2.csv" in told.value.remedy


def test_no_visit_of_a_drift_test_is_called_discarded(begun, capsys):
    words = [word for gauge in of_sim(2) for word in ("--gauge", gauge)]
    options = ["--part", "drift", "--repeat", "again", "--trigger", "timer:900", "--json"]
    capsys.readouterr()
    assert main(["record", str(begun), *words, *options]) == 0
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [one["discarded"] for one in events if one["event"] == "cycle"] == [False] * 40


def test_one_object_and_one_page_hold_their_figures(whole, tmp_path, capsys):
    code, found = said(capsys, "analyze", whole)
    assert (code, found["missing"], found["conformity"]) == (0, [], "pass")
    figures = {(one["code"], one["of"]): one for one in found["characteristics"]}
    drift = scara_iso.analyze(whole / "drift.csv")
    alone = {(one.code, one.of): one.estimate.value for one in drift.characteristics}
    assert figures["dAP", "XY"]["value"] == pytest.approx(alone["dAP", "XY"])
    assert figures["dRP", "X"]["value"] == pytest.approx(alone["dRP", "X"])
    assert figures["dAP", "XY"]["pose"] == "P1"
    push = scara_iso.push(whole / "push-joint_1.csv", arm=0.25)
    lost = push.estimate("lost_motion", "joint").value
    assert figures["lost_motion", "joint_1"]["value"] == pytest.approx(lost)
    assert figures["lost_motion", "joint_2"]["value"] == pytest.approx(lost / 2)  # twice the arm
    assert figures["lost_motion", "joint_1"]["limit"]["verdict"] == "pass"
    assert "lost_motion joint_1" in {one["figure"] for one in found["limits"]}
    made = scara_iso.report(whole, to=tmp_path / "report.md")
    assert {"drift.csv", "push-joint_2.csv"} <= set(made.files)
    page, _, rest = (tmp_path / "report.md").read_text("utf-8").partition("## Figures")
    assert all(words in page for words in ("dAP XY", "dRP XY", "lost motion joint 2", "1.2"))
    assert all(words in rest for words in ("Drift at pose P1", "Push test of joint\\_2"))
    assert re.search(
        r"interval, of 30 cycles, \d+ visits in a block(, \d+ blocks)? and \d+ readings;", page
    )
    assert "| conditions | velocity 100 % of rated; payload 100 % of rated |" in page
    assert "first cycle discarded" not in rest  # the line on the cycles says it
    assert rest.count("Loops of the push test") == 2
    one = said(capsys, "analyze", whole, "--condition", "v100-l100")[1]
    assert {found["code"] for found in one["characteristics"]} == {"RP", "RP_rss"}


def test_what_is_written_is_as_its_schema_says(whole, begun, capsys):
    edit(begun, "velocities = [100]", "velocities = [100, 50]")
    edit(begun, "lost_motion = 1.2", "lost_motion = [0.1, 1.2]")
    for name, words in (("analyze", ["analyze"]), ("test-status", ["test", "status"])):
        for folder in (whole, begun):
            validator(name).validate(said(capsys, *words, folder)[1])
    validator("test-conditions").validate(said(capsys, "report", begun)[1])


def test_of_several_conditions_they_stand_beside(begun, tmp_path, capsys):
    edit(begun, "velocities = [100]", "velocities = [100, 50]")
    scara_iso.record(begun, of_sim(5), trigger="timer:2")
    code, found = said(capsys, "analyze", begun)
    assert (code, len(found["conditions"])) == (0, 2)
    assert {"dAP", "dRP", "lost_motion"} <= {one["code"] for one in found["characteristics"]}
    assert not any(one["code"] == "dAP" for one in found["conditions"][0]["characteristics"])
    assert main(["report", str(begun), "-o", str(tmp_path / "r.md")]) == 0
    page = (tmp_path / "r.md").read_text("utf-8").partition("## Figures")[0]
    assert "dAP XY" in page
    assert "50 %" in page


def test_what_is_declared_and_missing_is_a_deviation(begun, capsys):
    (begun / "push-joint_2.csv").unlink()
    code, found = said(capsys, "analyze", begun)
    assert (code, found["missing"]) == (0, ["push-joint_2"])
    assert any("push-joint_2" in one["message"] for one in found["deviations"])


def test_a_limit_of_theirs_decides_the_exit_code(begun, capsys):
    edit(begun, "lost_motion = 1.2", "lost_motion = 0.5")
    code, found = said(capsys, "analyze", begun)
    assert (code, found["conformity"]) == (1, "fail")
    assert main(["report", str(begun), "-o", str(begun / "r.md")]) == 1
    page = (begun / "r.md").read_text("utf-8")
    assert "FAIL: OUTSIDE the limit with the whole 95 % interval: lost\\_motion joint\\_1" in page


def test_a_table_that_is_no_loop_is_faulty(begun):
    (begun / "push-joint_2.csv").write_text("force_N,reading\n1,2\n", "utf-8")
    states = {one.part.name: one.state for one in read_folder(begun).parts}
    assert states["push-joint_2"] == "faulty"
    with pytest.raises(DataError, match="1 part cannot be taken"):
        scara_iso.analyze(begun)


def test_pauses_inside_a_block_are_told(begun):
    table = begun / "drift.csv"
    lines = table.read_text("utf-8").splitlines()
    rows = [k for k, line in enumerate(lines) if line[:1].isdigit()]
    for k in rows[15:]:
        head, _, time = lines[k].rpartition(",")
        lines[k] = f"{head},{float(time) + 9000}"
    table.write_text("\n".join(lines), "utf-8")
    found = scara_iso.analyze(table)
    assert any("long pauses" in finding.message for finding in found.findings)


@pytest.mark.parametrize(
    "pushes", [{"push": PushTest(0.25)}, {"push-a": PushTest(0.3, {"lost_motion": 1.0})}]
)
def test_test_toml_is_written_and_read_back(pushes):
    test = WholeTest(poses={"P1": CommandPose(1.0)}, drift=DriftTest(blocks=9), pushes=pushes)
    faults = KeyFaults()
    read = parse_test(tomllib.loads(toml_of(test)), faults)
    assert not faults
    assert (read.drift, dict(read.pushes)) == (test.drift, pushes)


def test_wrong_keys_are_all_named():
    faults = KeyFaults()
    document = {"pose": {"P1": {}}, "drift": {"pose": "P9", "visits": 1}, "push": {"arm_m": -1}}
    parse_test(document, faults)
    said = {fault.message.partition(":")[0] for fault in faults}
    assert said == {"drift.visits", "push.arm_m", "drift.pose"}
