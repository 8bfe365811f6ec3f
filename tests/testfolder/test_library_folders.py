"""The folder of a test in the public functions, where a table would be; and `compare` of tests."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import scara_iso
from scara_iso.base.errors import NoInputError
from scara_iso.commands import main, new_test, read_conditions
from scara_iso.testfolder import read_folder

MODEL = Path(__file__).parents[2] / "examples" / "fum_scara.toml"


def gauges(seed):
    return [f"{axis}=opto-rs232@sim:?pace=0&seed={seed + k}" for k, axis in enumerate("XY")]


def record(folder, seed, **options):
    return scara_iso.record(folder, gauges(seed), trigger="timer:2", **options)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("folders") / "a"
    new_test(folder, MODEL, velocities=(100, 50))
    for seed in range(6):
        record(folder, 10 * seed)
    return folder


@pytest.fixture
def two_conditions(recorded, tmp_path):
    """Return the folder of a test at two velocities: all of the first, P1 of the second."""
    return shutil.copytree(recorded, tmp_path / "a")


def test_a_condition_is_named_and_figures_are_those_of_its_tables(two_conditions):
    with pytest.raises(scara_iso.UsageError) as told:
        scara_iso.analyze(two_conditions)
    assert "v100-l100" in told.value.remedy
    assert "v50-l100" in told.value.remedy
    whole = scara_iso.analyze(two_conditions, condition="v100-l100")
    for pose in whole.poses:
        alone = scara_iso.analyze(two_conditions / f"{pose.label}-v100-l100.csv").poses[0]
        assert {n: a.RP for n, a in pose.axes.items()} == {n: a.RP for n, a in alone.axes.items()}
    part = scara_iso.analyze(str(two_conditions), condition="v50-l100")
    assert "parts-missing" in [finding.code for finding in part.findings]


def test_diagnose_and_report_take_a_folder(two_conditions, tmp_path):
    found = scara_iso.diagnose(two_conditions, condition="v100-l100")
    assert list(found.poses) == ["P1", "P2", "P3", "P4", "P5"]
    made = scara_iso.report(two_conditions, condition="v50-l100", to=tmp_path / "report.md")
    assert {"test.toml", "P1-v50-l100.csv", "P1-v50-l100.raw.jsonl"} == set(made.files)
    assert "P2-v50-l100" in (tmp_path / "report.md").read_text("utf-8")
    assert made.archive(tmp_path / "evidence.zip").exists()


def test_what_test_toml_states_holds_until_another_is_given(two_conditions):
    path = two_conditions / "test.toml"
    path.write_text(path.read_text("utf-8").replace("# XY = 0.02", "XY = 0.0001"), "utf-8")
    for work in (scara_iso.analyze, lambda *a, **b: scara_iso.report(*a, **b).analysis):
        assert work(two_conditions, condition="v50-l100").conformity.value == "fail"
        kept = work(two_conditions, condition="v50-l100", limits={"XY": 9.0})
        assert kept.conformity.value == "pass"


def test_struck_recordings_are_in_no_figure(two_conditions):
    before = scara_iso.analyze(two_conditions, condition="v100-l100")
    repeated = record(two_conditions, 90, part="P1-v100-l100", repeat="the plunger stuck")
    after = scara_iso.analyze(two_conditions, condition="v100-l100")
    assert after.poses[0].axes["X"].mean == pytest.approx(np.mean(repeated.axes["X"].readings[1:]))
    assert after.poses[0].axes["X"].mean != before.poses[0].axes["X"].mean
    assert "parts-struck" in [finding.code for finding in after.findings]


def test_a_folder_is_alone_and_reads_itself(two_conditions):
    table = two_conditions / "P1-v50-l100.csv"
    for wrong in (
        lambda: scara_iso.analyze([two_conditions, table]),
        lambda: scara_iso.analyze(two_conditions, condition="v50-l100", unit="mm"),
        lambda: scara_iso.analyze(two_conditions, condition="v33-l100"),
        lambda: scara_iso.analyze(table, condition="v50-l100"),
        lambda: scara_iso.compare(table, table, condition="v50-l100"),
    ):
        with pytest.raises(scara_iso.UsageError):
            wrong()


def test_nothing_recorded_is_no_input(tmp_path):
    new_test(tmp_path / "a", MODEL)
    with pytest.raises(NoInputError, match="P1-v100-l100, P2-v100-l100"):
        scara_iso.analyze(tmp_path / "a")


def test_record_records_one_part(tmp_path):
    new_test(tmp_path / "a", MODEL)
    heard = []
    run = record(tmp_path / "a", 1, tell=heard.append)
    assert (len(run), run.metadata["part"], run.metadata["pose"]) == (31, "P1-v100-l100", "P1")
    assert any("part 1 of 5" in getattr(said, "message", "") for said in heard)
    assert record(tmp_path / "a", 1, part="P3-v100-l100").metadata["pose"] == "P3"
    assert read_folder(tmp_path / "a").next.part.name == "P2-v100-l100"
    for wrong in ({"part": "P1-v100-l100"}, {"cycles": 5}, {"pose": "P1,P2"}, {"part": "P9"}):
        with pytest.raises(scara_iso.UsageError):
            record(tmp_path / "a", 1, **wrong)
    with pytest.raises(scara_iso.UsageError):
        record(tmp_path / "b.csv", 1, part="P1")
    for _ in range(3):
        record(tmp_path / "a", 1)
    with pytest.raises(scara_iso.UsageError, match="nothing is missing"):
        record(tmp_path / "a", 1)


@pytest.mark.slow
def test_tests_are_compared_under_each_condition(two_conditions, tmp_path, capsys):
    other = tmp_path / "b"
    new_test(other, MODEL, velocities=(50, 100, 10))
    for seed in range(6):
        record(other, 10 * seed + 500)
    found = scara_iso.compare(two_conditions, other, condition="v100-l100")
    assert [(mean.pose, mean.figure) for mean in found.pairs[0].means] == [("P1", "X"), ("P1", "Y")]
    assert any("P2, P3, P4, P5: not compared" in one.message for one in found.pairs[0].findings)
    capsys.readouterr()
    assert main(["compare", str(two_conditions), str(other), "--json"]) == 0
    shown = capsys.readouterr()
    document = json.loads(shown.out)
    assert [one["velocity"] for one in document["conditions"]] == [100.0, 50.0]
    assert "v10-l100 is not in every test" in shown.err
    assert main(["compare", str(two_conditions), str(other), "--condition", "v50-l100",
                 "--json"]) == 0  # fmt: skip
    one = json.loads(capsys.readouterr().out)
    assert one == document["conditions"][1]["result"]
    table = str(other / "P1-v50-l100.csv")
    assert main(["compare", str(two_conditions), table]) == 2
    assert "--condition" in capsys.readouterr().err


def test_conditions_stand_for_a_table_each(two_conditions):
    ran = read_conditions(two_conditions)
    fast = scara_iso.analyze(ran[0])
    assert fast.poses[0].axes["X"].RP == (
        scara_iso.analyze(two_conditions, condition="v100-l100").poses[0].axes["X"].RP
    )
    one = scara_iso.analyze(two_conditions / "P1-v50-l100.csv")
    assert all(mean.before == mean.after for mean in scara_iso.compare(ran[1], one).pairs[0].means)


def test_a_condition_with_missing_parts_is_not_to_be_signed(two_conditions, capsys):
    assert main(["analyze", str(two_conditions), "--condition", "v50-l100"]) == 0
    out = capsys.readouterr().out
    assert f"Next: scara-iso test status {two_conditions}" in out
    assert main(["analyze", str(two_conditions), "--condition", "v100-l100"]) == 0
    assert "Next: scara-iso diagnose" in capsys.readouterr().out
