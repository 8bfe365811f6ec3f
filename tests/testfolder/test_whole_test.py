"""A whole test as a folder: from plan to report, and what goes wrong on the way."""

import errno
import json
import re
import shutil
import tomllib
from dataclasses import replace
from datetime import date
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from scara_iso.base import files
from scara_iso.base.errors import DataError, InstrumentError, UsageError
from scara_iso.base.files import KeyFaults
from scara_iso.commands import main, new_test, read_conditions
from scara_iso.recorder import recording
from scara_iso.reporting import Notice, status_report
from scara_iso.testfolder import assign, parse_test, read_folder, strike, toml_of
from scara_iso.testfolder.whole_test import (
    CommandPose,
    Cube,
    Instrument,
    People,
    RobotTested,
    Schedule,
    Struck,
    Surroundings,
    WholeTest,
)

MODEL = Path(__file__).parents[2] / "examples" / "fum_scara.toml"
GAUGE = "X=opto-rs232@sim:?pace=0&seed={}"


@pytest.fixture
def folder(tmp_path):
    """Return the folder of a new test of five poses at one velocity."""
    new_test(tmp_path / "acceptance", MODEL)
    return tmp_path / "acceptance"


def record(folder, seed=1, *options, gauges=(GAUGE,)):
    words = [word for gauge in gauges for word in ("--gauge", gauge.format(seed))]
    return main(["record", str(folder), *words, "--trigger", "timer:2", *options])


def said(capsys, *words):
    """Return exit code and JSON object of a command."""
    capsys.readouterr()
    code = main([*map(str, words), "--json"])
    return code, json.loads(capsys.readouterr().out)


def states(folder):
    return {one.part.name: one.state for one in read_folder(folder).parts}


def edit(folder, before, after):
    path = folder / "test.toml"
    text = path.read_text("utf-8")
    assert before in text
    path.write_text(text.replace(before, after, 1), "utf-8")


def test_from_new_to_report_without_a_question(folder, capsys, tmp_path):
    code, found = said(capsys, "test", "status", folder)
    assert (code, found["next"], found["seconds_left"]) == (0, "P1-v100-l100", None)
    for seed in range(5):
        assert record(folder, seed) == 0
    code, found = said(capsys, "test", "status", folder)
    assert (code, found["next"], found["complete"], found["missing"]) == (0, None, True, [])
    assert {part["state"] for part in found["parts"]} == {"done"}
    assert record(folder) == 0
    assert "nothing is missing" in capsys.readouterr().out
    code, found = said(capsys, "analyze", folder)
    assert (code, [pose["pose"] for pose in found["poses"]]) == (0, ["P1", "P2", "P3", "P4", "P5"])
    assert main(["report", str(folder), "-o", str(tmp_path / "report.html")]) == 0
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "P5-v100-l100.csv" in page
    code, found = said(capsys, "diagnose", folder)
    assert code == 0


def test_an_incomplete_folder_says_what_is_missing(folder, capsys, tmp_path):
    record(folder)
    code, found = said(capsys, "analyze", folder)
    assert code == 0
    assert found["missing"] == [f"P{k}-v100-l100" for k in (2, 3, 4, 5)]
    assert [f["code"] for f in found["findings"]].count("parts-missing") == 1
    assert any("P5-v100-l100" in one["message"] for one in found["deviations"])
    assert main(["report", str(folder), "-o", str(tmp_path / "report.md")]) == 0
    assert "P2-v100-l100" in (tmp_path / "report.md").read_text("utf-8")


def test_a_new_folder_has_nothing_to_analyse(folder, capsys):
    code, found = said(capsys, "analyze", folder)
    assert (code, found["poses"], len(found["missing"])) == (0, [], 5)
    page = folder.parent / "out.md"
    assert main(["report", str(folder), "-o", str(page)]) == 0
    assert f"{page} is not written: nothing is recorded" in capsys.readouterr().err
    assert not page.exists()


def test_conditions_are_analyses_of_their_own(tmp_path, capsys):
    new_test(tmp_path / "a", MODEL, velocities=(100, 50))
    for seed in range(6):
        record(tmp_path / "a", seed)
    assert list(states(tmp_path / "a").values())[:7] == ["done"] * 6 + ["missing"]
    code, found = said(capsys, "analyze", tmp_path / "a")
    assert code == 0
    assert [(c["velocity"], len(c["poses"])) for c in found["conditions"]] == [(100, 5), (50, 1)]
    _, one = said(capsys, "analyze", tmp_path / "a", "--condition", "v50-l100")
    assert [pose["pose"] for pose in one["poses"]] == ["P1"]
    assert said(capsys, "tables", tmp_path / "a", "--condition", "v50-l100")[1]["rows"] == 31
    for command in ("analyze", "diagnose"):
        assert main([command, str(tmp_path / "a")]) == 0
        above = [line for line in capsys.readouterr().out.splitlines() if line.endswith("load:")]
        assert above == ["100 % velocity, 100 % load:", "50 % velocity, 100 % load:"]
    # the same figures as the part's own table
    _, alone = said(capsys, "analyze", tmp_path / "a" / "P1-v50-l100.csv")
    assert one["poses"][0]["axes"] == alone["poses"][0]["axes"]


def test_the_head_of_a_part_says_what_the_test_states(folder):
    edit(folder, "# rated_payload_kg = 5", "rated_payload_kg = 5")
    edit(folder, "# rated_velocity_mm_s = 2000", "rated_velocity_mm_s = 2000")
    edit(folder, '# operator = "A. Name"', 'operator = "A. Name"')
    edit(folder, "loads = [100]", "loads = [10]")
    record(folder)
    head = read_conditions(folder)[0].run.metadata
    assert head["payload"] == "0.5 kg (10 % of rated)"
    assert head["velocity"] == "2000 mm/s (100 % of rated)"
    assert (head["operator"], head["robot"]) == ("A. Name", "FUM SCARA")
    found = read_conditions(folder)[0].analysis()
    assert any("10 % of the rated load" in finding.message for finding in found.deviations)
    assert states(folder)["P1-v100-l10"] == "done"  # as planned


@pytest.mark.parametrize(
    ("before", "after", "code"),
    [
        ("# temperature_C = 20.5", "temperature_C = 35", "temperature-limits"),
        ("dwell_s = 2", "dwell_s = 2\nstabilisation_time_s = 3", "short-dwell"),
        ('# approach = "one side"', 'approach = "both sides"', "mixed-approach"),
        ("# warm_up_min = 30", "warm_up_min = 0", "cold-start"),
        ("cycles = 31", "cycles = 21", "cycle-count"),
        ("# date = 2026-05-12", "date = 2026-05-12\n[instrument.X]\ncalibration_due = 2026-05-01",
         "calibration-date"),
    ],
)  # fmt: skip
def test_a_part_out_of_its_conditions_is_seen(folder, before, after, code):
    edit(folder, before, after)
    record(folder)
    part = read_folder(folder).parts[0]
    assert part.state == "out of its conditions"
    assert code in [finding.code for finding in part.deviations]
    assert code in [f.code for f in read_conditions(folder)[0].analysis().deviations]


@pytest.mark.parametrize(
    ("stated", "today", "past"),
    [("", date(2026, 5, 2), True), ("", date(2026, 5, 1), False),
     ("date = 2026-05-02", date(2026, 1, 1), True), ("date = 2026-05-01", date(2027, 1, 1), False)],
)  # fmt: skip
def test_a_calibration_that_has_run_out_is_said_before_anything_is_recorded(
    folder, stated, today, past
):
    edit(folder, "# date = 2026-05-12", f"{stated}\n[instrument.X]\ncalibration_due = 2026-05-01")
    blocks = status_report(read_folder(folder), today)[0].blocks
    said = [block for block in blocks if isinstance(block, Notice)]
    assert [one.subject for one in said] == (["X"] if past else [])


def test_one_warm_part_of_several_is_a_deviation(folder):
    record(folder)
    record(folder, 2, "--meta", "temperature=35 C")
    found = read_conditions(folder)[0].analysis()
    assert any("temperature[P2] 35 C is outside" in one.message for one in found.deviations)


def test_what_the_model_does_not_rate_is_a_deviation(folder):
    record(folder)
    said = [one.message for one in read_conditions(folder)[0].analysis().deviations]
    assert any("rated velocity" in one and "rated payload" in one for one in said)


def test_a_repeated_part_strikes_the_old_one_and_keeps_it(folder, capsys):
    record(folder)
    before = (folder / "P1-v100-l100.csv").read_bytes()
    assert record(folder, 2, "--part", "P1-v100-l100") == 2
    again = ("--part", "P1-v100-l100", "--repeat", "the plunger stuck")
    assert record(folder, 2, *again) == 0
    assert (folder / "P1-v100-l100.csv").read_bytes() == before
    assert (folder / "P1-v100-l100-r2.csv").exists()
    _, found = said(capsys, "test", "status", folder)
    assert found["parts"][0]["recording"] == "P1-v100-l100-r2.csv"
    assert found["parts"][0]["struck"] == [
        {"recording": "P1-v100-l100", "reason": "the plunger stuck"}
    ]
    analysis = read_conditions(folder)[0].analysis()
    assert any("the plunger stuck" in one.message for one in analysis.deviations)
    assert len(analysis.run) == 31


def test_a_port_that_cannot_be_opened_strikes_nothing(folder):
    record(folder)
    again = ("--part", "P1-v100-l100", "--repeat", "why")
    assert record(folder, 2, *again, gauges=("X=opto-rs232@/dev/nowhere",)) == 69
    assert states(folder)["P1-v100-l100"] == "done"


def test_in_a_test_it_is_advised_to_record_again(folder, tmp_path, monkeypatch, capsys):
    def lost(*_, **__):
        raise InstrumentError("lost", remedy=f"reconnect it, {recording._GO_ON}")

    monkeypatch.setattr("scara_iso.recorder.record", lost)
    gauge = ["--gauge", GAUGE.format(1), "--trigger", "timer:2"]
    for table, advised in ((folder, "record again"), (tmp_path / "run.csv", "--resume")):
        assert main(["record", str(table), *gauge]) == 69
        said = capsys.readouterr().err
        assert [word for word in ("record again", "--resume") if word in said] == [advised]


def test_an_unfinished_part_is_gone_on_with(folder, monkeypatch):
    real = files.Disk.write
    written = []

    def full(self, file, data):
        written.append(data)
        if len(written) > 40:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(self, file, data)

    monkeypatch.setattr(files.Disk, "write", full)
    assert record(folder) == 74
    monkeypatch.undo()
    assert states(folder)["P1-v100-l100"] == "unfinished"
    stored = read_folder(folder).parts[0].recording.cycles[0]
    assert stored > 0
    assert read_conditions(folder)[0].missing[0] == f"P1-v100-l100 ({stored} of 31 cycles)"
    assert record(folder) == 0
    assert states(folder)["P1-v100-l100"] == "done"
    assert read_folder(folder).next.part.name == "P2-v100-l100"


def test_a_second_recorder_in_the_folder_is_told(folder, capsys):
    fcntl = pytest.importorskip("fcntl")
    record(folder)
    raw = folder / "P2-v100-l100.raw.jsonl"
    with raw.open("w") as held:  # another recorder that has just begun
        fcntl.flock(held, fcntl.LOCK_EX)
        assert record(folder) == 73
    assert "another recorder" in capsys.readouterr().err


def test_a_part_of_another_robot_or_pose_is_refused(folder, capsys):
    record(folder)
    shutil.copy(folder / "P1-v100-l100.csv", folder / "P2-v100-l100.csv")
    text = (folder / "P1-v100-l100.csv").read_text("utf-8").replace("FUM SCARA", "another")
    (folder / "P3-v100-l100.csv").write_text(text.replace("P1", "P3"), "utf-8")
    assert states(folder) == {
        "P1-v100-l100": "done", "P2-v100-l100": "faulty", "P3-v100-l100": "faulty",
        "P4-v100-l100": "missing", "P5-v100-l100": "missing",
    }  # fmt: skip
    capsys.readouterr()
    assert main(["analyze", str(folder)]) == 65
    err = capsys.readouterr().err
    assert "P2-v100-l100: part is 'P1-v100-l100'" in err
    assert "robot is 'another'" in err


def test_a_part_that_lost_a_line_says_which_and_how_to_go_on(folder, capsys):
    record(folder)
    path = folder / "P1-v100-l100.csv"
    lines = path.read_text("utf-8").splitlines(keepends=True)
    lost = next(k for k, line in enumerate(lines) if line.startswith("12,"))
    path.write_text("".join(lines[:lost] + lines[lost + 1 :]), "utf-8")
    assert read_folder(folder).parts[0].why.endswith(f"line {lost + 1}: cycle 12 is missing")
    capsys.readouterr()
    assert main(["analyze", str(folder)]) == 65
    remedy = "scara-iso record {} --part P1-v100-l100 --repeat"
    assert remedy.format(folder) in capsys.readouterr().err
    assert record(folder, 2, "--part", "P1-v100-l100", "--repeat", "a line was lost") == 0
    assert states(folder)["P1-v100-l100"] == "done"


def test_a_part_without_its_first_cycle_is_answered_with_what_helps(folder, capsys):
    table = folder / "P1-v100-l100.csv"
    rows = "cycle,X [mm]\n" + "".join(f"{k},0.45{k % 7}\n" for k in range(1, 31))
    table.write_text(rows)
    assert main(["analyze", str(folder)]) == 65
    err = " ".join(capsys.readouterr().err.split())
    assert "'# first_cycle_discarded: true' in the file" in err
    assert "here as a line of the file, cycles in test.toml" in err
    table.write_text(f"# first_cycle_discarded: true\n{rows}")
    assert main(["analyze", str(folder)]) == 0


def test_what_lacks_parts_passes_so_far_only(folder, capsys):
    record(folder)
    capsys.readouterr()
    main(["analyze", str(folder), "--limit", "X=9"])
    assert capsys.readouterr().out.strip().startswith("PASS SO FAR, parts are not recorded:")


def test_what_lacks_a_test_beside_the_poses_passes_so_far_only(folder, capsys):
    edit(folder, "# [push]", "[push]")
    for seed in range(5):
        record(folder, seed)
    for words in (["analyze"], ["analyze", "--condition", "v100-l100"]):
        capsys.readouterr()
        main([*words, str(folder), "--limit", "X=9"])
        out = capsys.readouterr().out
        assert out.strip().startswith("PASS SO FAR, parts are not recorded:")
        assert f"Next: scara-iso test status {folder}" in out
    report = str(folder.parent / "out.md")
    main(["report", str(folder), "--condition", "v100-l100", "--limit", "X=9", "-o", report])
    page = Path(report).read_text("utf-8")
    assert "PASS SO FAR" in page
    assert "Not recorded: push \\[the test's own plan: the tests beside the poses" in page


def test_one_step_follows_a_whole_test_and_it_is_of_all_of_it(folder, capsys):
    edit(folder, "# [push]", "[push]")
    for seed in range(5):
        record(folder, seed)
    force = [*range(0, 50, 10), *range(50, -50, -10), *range(-50, 50, 10)]
    rows = "".join(f"{f},{f / 1e4:.3f}\n" for f in force * 2)
    (folder / "push.csv").write_text(f"# unit: mm\n# resolution: 0.001\nforce_N,reading\n{rows}")
    capsys.readouterr()
    main(["analyze", str(folder), "--limit", "X=9"])
    out = capsys.readouterr().out
    assert [one.split("  ")[0] for one in re.findall("Next: (.*)", out)] == [
        f"scara-iso report {folder} --limit X=9"
    ]
    main(["diagnose", str(folder)])
    out = capsys.readouterr().out
    assert [one.split("  ")[0] for one in re.findall("Next: (.*)", out)] == [
        f"scara-iso report {folder}"
    ]


def test_a_part_that_is_there_twice_is_refused(folder):
    record(folder)
    shutil.copy(folder / "P1-v100-l100.csv", folder / "P1-v100-l100-r2.csv")
    why = read_folder(folder).parts[0].why
    assert "recorded twice" in why
    assert '[[struck]] with recording = "P1-v100-l100-r2"' in why
    with pytest.raises(DataError, match="cannot be taken"):
        read_conditions(folder)
    strike(folder, Struck("P1-v100-l100-r2", "a copy"))
    assert states(folder)["P1-v100-l100"] == "done"


def test_repeating_a_part_that_is_there_twice_strikes_both(folder):
    record(folder)
    shutil.copy(folder / "P1-v100-l100.csv", folder / "P1-v100-l100-r2.csv")
    assert record(folder, 2, "--part", "P1-v100-l100", "--repeat", "which one counts?") == 0
    state = read_folder(folder).parts[0]
    assert (state.state, state.recording.name) == ("done", "P1-v100-l100-r3")
    struck = [(one.recording, one.reason) for one in state.struck]
    assert struck == [(f"P1-v100-l100{k}", "which one counts?") for k in ("", "-r2")]


def test_a_file_of_no_part_is_named_and_not_used(folder):
    record(folder)
    shutil.copy(folder / "P1-v100-l100.csv", folder / "P1-v20-l100.csv")
    assert read_folder(folder).foreign == ("P1-v20-l100",)
    assert len(read_conditions(folder)[0].run) == 31


@pytest.mark.parametrize("ending", [".xlsx", ".CSV", ".txt", "-r2.xlsx"])
def test_a_file_called_as_a_part_that_is_no_recording_is_named(folder, ending):
    (part, *_) = (state.part.name for state in read_folder(folder).parts)
    (folder / f"{part}{ending}").write_text("")
    (folder / "report.html").write_text("")
    assert read_folder(folder).foreign == (f"{part}{ending}",)


def test_a_copied_part_is_seen(folder, capsys):
    rows = "".join(f"{k},{0.1 + k * 7 % 11 / 1000:.3f}\n" for k in range(1, 32))
    first, second = (state.part.name for state in read_folder(folder).parts[:2])
    for part in (first, second):
        (folder / f"{part}.csv").write_text(f"# unit: mm\n# resolution: 0.001\ncycle,X\n{rows}")
    assert main(["analyze", str(folder)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert f"{second} holds the very readings of {first}: a copy?" in said
    assert "rows repeat (those of P1)" in said


def test_parts_of_other_axes_are_not_mixed(folder):
    record(folder)
    with pytest.raises(UsageError, match="was recorded on X"):
        assign(read_folder(folder), ["X", "Y"])
    assert record(folder, 2, gauges=("Y=opto-rs232@sim:?pace=0",)) == 2


def test_an_edited_table_is_seen(folder):
    record(folder)
    path = folder / "P1-v100-l100.csv"
    lines = path.read_text("utf-8").splitlines(keepends=True)
    path.write_text("".join([*lines[:-1], "31,0.500,60.02\n"]), "utf-8")
    assert states(folder)["P1-v100-l100"] == "out of its conditions"
    assert any(f.code == "edited" for f in read_conditions(folder)[0].analysis().findings)


def test_a_part_of_another_instrument_is_a_finding(folder, capsys):
    edit(folder, "[limits]", '[instrument.X]\nname = "ID-C112"\nserial_number = "17"\n\n[limits]')
    record(folder)
    edit(folder, 'serial_number = "17"', 'serial_number = "18"')
    record(folder)
    found = read_folder(folder).parts
    assert (found[0].state, found[1].state) == ("out of its conditions", "done")
    said = [one.message for one in read_conditions(folder)[0].analysis().deviations
            if one.code == "other-instrument"]  # fmt: skip
    assert said == ["at P1: indicator_serial_number is 'X 17', and the test says 'X 18'"]
    assert main(["report", str(folder), "-o", str(folder.parent / "report.md")]) == 0
    assert "the test says 'X 18'" in (folder.parent / "report.md").read_text("utf-8")


def test_what_is_planned_and_not_measured_is_said(folder, capsys):
    edit(folder, 'characteristics = ["RP", "AP"]', 'characteristics = ["RP", "vAP", "speed"]')
    record(folder)
    _, status = said(capsys, "test", "status", folder)
    assert [line.partition(":")[0] for line in status["not_measured"]] == [
        "vAP is planned and not measured", "speed is planned and not measured",
    ]  # fmt: skip
    assert "three perpendicular directions" in status["not_measured"][0]
    assert status["parts"][0]["state"] == "done"
    _, found = said(capsys, "analyze", folder)
    told = [one["message"] for one in found["deviations"] if "planned" in one["message"]]
    assert told == status["not_measured"]


def test_ap_is_measured_where_the_dials_were_zeroed_at_the_command_pose(folder, capsys):
    edit(folder, '# dial_zero = "command"', 'dial_zero = "command"')
    record(folder)
    assert said(capsys, "test", "status", folder)[1]["not_measured"] == []


def test_what_was_struck_is_in_the_report(folder):
    record(folder)
    record(folder, 2, "--part", "P1-v100-l100", "--repeat", "the plunger stuck")
    assert main(["report", str(folder), "-o", str(folder.parent / "report.md")]) == 0
    page = (folder.parent / "report.md").read_text("utf-8")
    assert "P1-v100-l100: the plunger stuck" in page


@pytest.mark.parametrize(
    ("stated", "state"),
    [("velocity=500 mm/s", "faulty"), ("velocity=25 % of rated", "faulty"),
     ("payload=2 kg", "faulty"), ("velocity=2000 mm/s", "done"),
     ("payload=as on the plate", "done")],
)  # fmt: skip
def test_a_part_under_other_conditions_than_its_name_is_not_mixed(folder, stated, state, capsys):
    edit(folder, "# rated_payload_kg = 5", "rated_payload_kg = 5")
    edit(folder, "# rated_velocity_mm_s = 2000", "rated_velocity_mm_s = 2000")
    record(folder, 1, "--meta", stated)
    assert states(folder)["P1-v100-l100"] == state
    capsys.readouterr()
    assert main(["analyze", str(folder)]) == (65 if state == "faulty" else 0)
    key, _, text = stated.partition("=")
    said = f"{key} is '{text}', and the part is at 100 % of the rated one"
    assert (said in " ".join(capsys.readouterr().err.split())) == (state == "faulty")


def test_a_part_of_another_unit_is_said_and_not_mixed(folder):
    """A hand-made table in inches beside a recorded one in mm: all figures are in mm."""
    record(folder)
    head = {"part": "P2-v100-l100", "pose": "P2", "robot": "FUM SCARA", "unit": "inch"}
    rows = [f"{k},{0.5 + k % 3 / 1000:.3f}" for k in range(1, 32)]
    lines = [*(f"# {key}: {text}" for key, text in head.items()), "cycle,X", *rows]
    (folder / "P2-v100-l100.csv").write_text("\n".join(lines) + "\n", "utf-8")
    found = read_conditions(folder)[0]
    analysis = found.analysis()
    assert analysis.poses[1].axes["X"].mean == pytest.approx(12.7254, abs=0.01)
    said = "X in inch, and in mm in P1"
    found = [one for one in analysis.findings if one.code == "other-unit"]
    assert [(one.severity, one.message) for one in found] == [
        ("warning", f"P2: {said}; all is converted to mm")
    ]
    state = read_folder(folder).parts[1]
    assert state.state == "out of its conditions"
    assert any(said in one.message for one in state.deviations)


def test_the_limits_of_the_test_decide(folder, capsys):
    edit(folder, "# XY = 0.02", "X = 0.0001")
    record(folder)
    code, found = said(capsys, "analyze", folder)
    assert (code, found["conformity"]) == (1, "fail")
    assert said(capsys, "analyze", folder, "--limit", "X=9")[0] == 0
    assert main(["report", str(folder), "-o", str(folder.parent / "why.md")]) == 1
    assert "scara-iso: FAIL: OUTSIDE the limit" in capsys.readouterr().err


def test_the_pace_says_how_long_is_left(folder, capsys):
    record(folder)
    _, found = said(capsys, "test", "status", folder)
    assert found["seconds_a_cycle"] == pytest.approx(2)
    assert found["seconds_left"] == pytest.approx(2 * 31 * 4)
    assert assign(read_folder(folder), ["X"]).said(0) == (
        "part 2 of 5, P2 at 100 %, about 5 minutes left"
    )


def test_every_fault_is_named_by_its_key(folder, capsys):
    edit(folder, "velocities = [100]", 'velocities = [100, 130]\nspeed = 3\napproach = "left"')
    edit(folder, "[pose.P2]", "[pose.P2]\ncolour = 1")
    edit(folder, 'decision = "interval"', 'decision = "guess"\nXY = -1')
    assert main(["test", "status", str(folder)]) == 65
    err = capsys.readouterr().err
    for key in ("test.velocities", "test.speed", "test.approach", "pose.P2.colour",
                "limits.decision", "limits.XY"):  # fmt: skip
        assert key in err


@pytest.mark.parametrize("words", [["test", "status"], ["analyze"], ["report"], ["record"]])
def test_a_limit_of_no_figure_and_a_velocity_of_0_are_faults_at_every_command(
    folder, capsys, tmp_path, words
):
    edit(folder, "velocities = [100]", "velocities = [100, 0]")
    edit(folder, "# XY = 0.02", "foo = 0.02\nXY = 0.02\nAP = 0.1\nRP_a = 0.1")
    more = {"record": ["--gauge", GAUGE.format(1)], "report": ["-o", str(tmp_path / "r.md")]}
    assert main([*words, str(folder), *more.get(words[0], [])]) == 65
    err = capsys.readouterr().err
    assert "2 faults" in err
    assert "limits.foo: no such figure; known are X, Y, Z, theta, XY" in err
    assert "test.velocities: at 0 per cent" in err


def test_a_test_is_not_written_over(folder):
    assert main(["test", "new", str(folder), "--model", str(MODEL)]) == 73


WORDS = st.text(st.characters(categories=("L", "Nd", "Sm")), min_size=1, max_size=8)
NUMBERS = st.floats(-1e6, 1e6, allow_nan=False)
SIZES = st.floats(1e-6, 1e6)
PERCENTS = st.lists(st.floats(0, 100), min_size=1, max_size=3, unique=True).map(tuple)
DAYS = st.none() | st.dates(date(1990, 1, 1), date(2100, 1, 1))
MAYBE = st.none() | SIZES
TESTS = st.builds(
    WholeTest,
    robot=st.builds(RobotTested, WORDS, WORDS, WORDS, MAYBE, MAYBE),
    schedule=st.builds(
        Schedule, st.just(("RP",)), PERCENTS, PERCENTS, st.integers(3, 100),
        st.sampled_from(["discarded", "counts"]), MAYBE, MAYBE,
        st.sampled_from(["", "one side", "both sides"]), MAYBE, st.sampled_from(["", "command"]),
        DAYS,
    ),
    cube=st.builds(Cube, WORDS, st.tuples(SIZES, SIZES, SIZES), WORDS, WORDS),
    poses=st.dictionaries(
        st.sampled_from(["P1", "P2", "P3"]),
        st.builds(
            CommandPose, NUMBERS, NUMBERS, NUMBERS, NUMBERS,
            st.dictionaries(st.sampled_from(["X", "Y"]), NUMBERS),
        ),
        min_size=1,
    ),
    decision=st.sampled_from(["interval", "simple"]),
    limits=st.dictionaries(st.sampled_from(["", "X", "XY"]), SIZES),
    instruments=st.dictionaries(
        st.sampled_from(["X", "theta"]),
        st.builds(Instrument, WORDS, WORDS, WORDS, DAYS, DAYS, MAYBE),
    ),
    people=st.builds(People, WORDS),
    surroundings=st.builds(Surroundings, st.none() | NUMBERS, st.just((18.0, 22.0)), MAYBE.map(
        lambda size: None if size is None else min(size, 100.0)
    )),
    struck=st.lists(st.builds(Struck, WORDS, WORDS), max_size=2).map(tuple),
)  # fmt: skip


@given(TESTS)
def test_a_test_is_read_back_as_it_was_written(test):
    faults = KeyFaults()
    assert parse_test(tomllib.loads(toml_of(test)), faults) == test
    assert faults == []


@given(TESTS)
def test_a_strike_changes_nothing_else(tmp_path_factory, test):
    path = tmp_path_factory.mktemp("strike")
    text = f"# mine\n{toml_of(test)}"
    (path / "test.toml").write_text(text, "utf-8")
    strike(path, Struck("P1-v100-l100", "knocked"))
    struck = (path / "test.toml").read_text("utf-8")
    faults = KeyFaults()
    wanted = replace(test, struck=(*test.struck, Struck("P1-v100-l100", "knocked")))
    assert parse_test(tomllib.loads(struck), faults) == wanted
    assert struck.startswith("# mine\n")


def test_a_folder_that_is_no_test_is_said_with_what_makes_it_one(tmp_path, capsys):
    assert main(["test", "status", str(tmp_path)]) == 66
    said = capsys.readouterr().err
    assert "is not the folder of a test" in said
    assert f"scara-iso test new {tmp_path} --model MODEL.toml" in " ".join(said.split())
