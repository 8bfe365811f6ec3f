"""A test under several velocities and loads is one report: page 1 shows all of them."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

import scara_iso
from scara_iso.base.errors import DataError
from scara_iso.commands import main, new_test
from scara_iso.commands.evidence import REGISTER
from scara_iso.reporting import Facts, Figure, Table, Text, document, joined_dossier
from scara_iso.run import Axis, Run
from scara_iso.testfolder import Condition

MODEL = Path(__file__).parents[2] / "examples" / "fum_scara.toml"
POSES = ("P1", "P2")


def measured(seed, velocity, axes="XY", **stated):
    """Return the run of two poses, 31 cycles each, and its readings by axis."""
    rng = np.random.default_rng(seed)
    readings = {name: np.round(rng.normal(0, 0.01, 62), 3) for name in axes}
    return Run(
        cycle=np.tile(np.arange(1, 32), 2),
        axes={name: Axis(name, values, resolution=0.001) for name, values in readings.items()},
        pose=np.repeat(POSES, 31),
        metadata={"velocity": velocity, "robot": "A SCARA", **stated},
    )


def chapter(name, run, **options):
    velocity, load = name.split("-")
    condition = Condition(float(velocity[1:]), float(load[1:]))
    return condition, scara_iso.report(run, **options).dossier


@pytest.fixture(scope="module")
def runs():
    return [measured(1, "1000 mm/s"), measured(2, "500 mm/s")]


@pytest.fixture(scope="module")
def whole(runs):
    limits = {"XY": 0.05}
    names = ("v100-l100", "v50-l100")
    chapters = dict(chapter(n, run, limits=limits) for n, run in zip(names, runs, strict=True))
    return joined_dossier(chapters, ["P1-v10-l100"])


def blocks(dossier, kind):
    sections = document(dossier).sections
    return [block for section in sections for block in section.blocks if isinstance(block, kind)]


def test_page_1_has_a_row_for_each_pose_under_each_condition(whole, runs):
    page = document(whole).sections[0].blocks
    table = next(block for block in page if isinstance(block, Table))
    assert table.header[:3] == ("velocity", "load", "pose")
    rows = [row[:3] for row in table.rows if row[0] != "limit"]
    assert rows == [("100 %", "100 %", "P1"), ("100 %", "100 %", "P2"),
                    ("50 %", "100 %", "P1"), ("50 %", "100 %", "P2")]  # fmt: skip
    column = table.header.index("RP XY [mm]")
    said = [row[column].value.value for row in table.rows if row[0] != "limit"]
    # 7.2.2 by hand, cycle 1 of each pose left out
    own = []
    for run in runs:
        for k in (0, 31):
            XY = np.stack([run.axes[axis].readings[k + 1 : k + 31] for axis in "XY"])
            l = np.hypot(*(XY - XY.mean(axis=1, keepdims=True)))  # noqa: E741
            own.append(l.mean() + 3 * l.std(ddof=1))
    assert said == pytest.approx(own)


def test_every_pose_of_every_condition_has_its_place_in_the_rest(whole):
    labels = [f"{pose}-{name}" for name in ("v100-l100", "v50-l100") for pose in POSES]
    assert [pose.label for pose in whole.analysis.poses] == labels
    assert list(whole.diagnoses) == labels
    assert {check.pose for check in whole.analysis.limits} == set(labels)
    courses = next(f for f in blocks(whole, Figure) if f.title == "X over the cycles")
    assert [panel.title for panel in courses.panels] == labels
    headings = [section.heading for section in document(whole).sections]
    assert all(f"Raw data at pose {label}" in headings for label in labels)


def test_the_rows_of_a_pose_are_its_own(whole, runs):
    for k, run in enumerate(runs):
        for j, pose in enumerate(POSES):
            found = whole.analysis.poses[2 * k + j]
            own = run.axes["X"].readings[31 * j + 1 : 31 * j + 31]
            assert np.array_equal(found.axes["X"].readings, own), (k, pose)
            assert np.array_equal(whole.analysis.run.axes["X"].readings[found.rows], own)


def test_what_the_conditions_state_otherwise_is_said_of_each(whole):
    said = dict(row for facts in blocks(whole, Facts) for row in facts.rows)
    assert said["velocity"] == "v100-l100: 1000 mm/s; v50-l100: 500 mm/s"
    assert said["item"] == "A SCARA"


def test_a_finding_of_all_conditions_is_said_once(whole):
    about_conditions = [f for f in whole.analysis.findings if "not stated" in f.message]
    assert about_conditions
    assert all(found.pose is None for found in about_conditions)
    assert len({found.message for found in about_conditions}) == len(about_conditions)


def test_a_finding_of_one_condition_names_it():
    runs = [measured(1, "1000 mm/s", "X", temperature="35 C"), measured(2, "500 mm/s", "X")]
    found = joined_dossier(dict([chapter("v100-l100", runs[0]), chapter("v50-l100", runs[1])]))
    hot = [f for f in found.analysis.findings if "35" in f.message]
    assert [f.pose for f in hot] == ["v100-l100"]


def test_a_condition_without_a_recording_is_a_deviation(whole):
    said = [b.text for b in document(whole).sections[0].blocks if isinstance(b, Text)]
    assert any("Not recorded: P1-v10-l100" in text for text in said)


def test_conditions_of_other_axes_are_not_mixed():
    chapters = dict(
        [
            chapter("v100-l100", measured(1, "a", "X")),
            chapter("v50-l100", measured(2, "b", "Y")),
        ]
    )
    with pytest.raises(DataError, match="not the same axes") as caught:
        joined_dossier(chapters)
    assert "condition=v100-l100" in str(caught.value.remedy)


def test_a_folder_of_several_conditions_is_one_report(tmp_path, capsys):
    folder, page, pack = tmp_path / "a", tmp_path / "a.html", tmp_path / "a.zip"
    new_test(folder, MODEL, velocities=(100, 50, 10))
    gauge = "X=opto-rs232@sim:?pace=0&seed={}"
    for seed in range(6):
        assert (
            main(["record", str(folder), "--gauge", gauge.format(seed), "--trigger", "data"]) == 0
        )
    capsys.readouterr()
    assert main(["report", str(folder), "-o", str(page), "--archive", str(pack)]) == 0
    written = sorted(p.name for p in tmp_path.iterdir())
    assert written == [REGISTER, "a", "a.html", "a.zip"]
    text = page.read_text("utf-8")
    assert text.count('<th scope="row">100 %</th>') == 5
    assert "P2-v50-l100, P3-v50-l100" in text
    assert "Not recorded: P1-v10-l100, P2-v10-l100" in text
    with zipfile.ZipFile(pack) as held:
        names = held.namelist()
    assert {"data/P1-v100-l100.csv", "data/P1-v50-l100.csv"} <= set(names)
    assert main(["report", str(folder), "--json"]) == 0
    found = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert [one["velocity"] for one in found["conditions"]] == [100, 50]
    part = str(folder / "P1-v100-l100.csv")
    assert main(["report", part, "-o", str(page)]) == 73
    assert "is the report of more tables, a/P1-v100-l100.csv, " in capsys.readouterr().err
    assert page.read_text("utf-8") == text
    assert main(["report", part, "-o", str(page), "--replace"]) == 0
    assert main(["report", str(folder), "-o", str(page)]) == 0, "the test has become more"


def test_what_each_pose_states_in_its_own_way_is_stated():
    run = measured(1, "a", "X", **{"indicator[P1]": "dial 1", "indicator[P2]": "dial 2"})
    dossier = scara_iso.report(run).dossier
    said = dict(row for facts in blocks(dossier, Facts) for row in facts.rows)
    assert said["instrument"] == "P1: dial 1; P2: dial 2"
    page = [b.text for b in document(dossier).sections[0].blocks if isinstance(b, Text)]
    missing = next(text for text in page if text.startswith("Not stated"))
    assert "instrument," not in missing
