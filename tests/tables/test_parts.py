"""Several tables as the poses of one test: files, folders, sheets, blocks; and what is refused."""

import io
import json
from contextlib import redirect_stdout
from itertools import combinations

import numpy as np
import openpyxl
import pytest
from hypothesis import given, strategies as st

import scara_iso
from scara_iso import Run, read_table
from scara_iso.base.errors import DataError, NoInputError
from scara_iso.base.published import to_json
from scara_iso.commands import main
from scara_iso.run import Axis
from scara_iso.tables import PosePart, merge, pose_in, write_table

HEAD = {"unit": "mm", "resolution": "0.001", "robot": "FUM SCARA", "payload": "2 kg"}
POSES = ("P1", "P2", "P3", "P4", "P5")


def readings(k):
    rng = np.random.default_rng(k)
    return np.round(np.array([k / 10, 0.5]) + rng.normal(0, 0.004, (31, 2)), 3)


def head(**others):
    return "".join(f"# {key}: {text}\n" for key, text in {**HEAD, **others}.items() if text)


def rows(k):
    return [f"{c},{x:.3f},{y:.3f}" for c, (x, y) in enumerate(readings(k), 1)]


def table(k, **others):
    return head(**others) + "\n".join(["cycle,X,Y", *rows(k), ""])


@pytest.fixture
def folder(tmp_path):
    """Return a folder with a table for each of five poses."""
    for k, pose in enumerate(POSES, 1):
        (tmp_path / f"{pose}.csv").write_text(table(k), encoding="utf-8")
    return tmp_path


def files(folder):
    return [folder / f"{pose}.csv" for pose in POSES]


def sheets(folder):
    book = openpyxl.Workbook()
    book.active.title = "Notes"
    for k, pose in enumerate(POSES, 1):
        sheet = book.create_sheet(pose)
        for key, text in HEAD.items():
            sheet.append([key, text])
        sheet.append(["cycle", "X", "Y"])
        for c, xy in enumerate(readings(k), 1):
            sheet.append([c, *map(float, xy)])
    book.save(folder / "five.xlsx")
    return folder / "five.xlsx"


def below(folder):
    blocks = "\n".join(
        "\n".join([pose, "cycle,X,Y", *rows(k), ""]) for k, pose in enumerate(POSES, 1)
    )
    (folder / "below.txt").write_text(head() + blocks, encoding="utf-8")
    return folder / "below.txt"


def stated_below(folder):
    parts = [
        "\n".join([f"# pose: {pose}", "cycle,X,Y", *rows(k), ""]) for k, pose in enumerate(POSES, 1)
    ]
    (folder / "stated.txt").write_text(head() + "".join(parts), encoding="utf-8")
    return folder / "stated.txt"


def beside(folder):
    lines = [";".join(f"Pose {k};;;" for k in range(1, 6)), ";".join(["cycle;X;Y;"] * 5)]
    every = [readings(k) for k in range(1, 6)]
    lines += [
        ";".join(f"{c + 1};{xy[c][0]:.3f};{xy[c][1]:.3f};" for xy in every) for c in range(31)
    ]
    text = head() + "\n".join(lines[:2]) + "\n" + "\n".join(lines[2:]).replace(".", ",") + "\n"
    (folder / "beside.txt").write_text(text, encoding="utf-8")
    return folder / "beside.txt"


def beside_one_cycle_column(folder):
    book = openpyxl.Workbook()
    for key, text in HEAD.items():
        book.active.append([key, text])
    book.active.append([None, *(cell for pose in POSES for cell in (pose, None))])
    book.active.append(["cycle", *["X", "Y"] * 5])
    for c in range(31):
        book.active.append([c + 1, *(float(v) for k in range(1, 6) for v in readings(k)[c])])
    book.save(folder / "beside.xlsx")
    return folder / "beside.xlsx"


def of_one_pose(path):
    found = to_json(scara_iso.analyze(path).poses[0])
    return {key: value for key, value in found.items() if key != "pose"}


@pytest.mark.parametrize(
    "make", [str, files, sheets, below, stated_below, beside, beside_one_cycle_column]
)
def test_the_figures_of_five_poses_are_those_of_five_tables_to_the_bit(folder, make):
    alone = {pose: of_one_pose(folder / f"{pose}.csv") for pose in POSES}
    given = make(folder)
    together = scara_iso.analyze(given)
    assert [pose.label for pose in together.poses] == list(POSES)
    for pose in together.poses:
        found = to_json(pose)
        assert found.pop("pose") == pose.label
        assert found == alone[pose.label]


def test_each_pose_is_said_with_where_it_is_from(folder):
    assert (
        scara_iso.analyze(folder)
        .run.origin.notes[0]
        .startswith("pose P1 from the file's name P1.csv: comma-separated")
    )
    assert read_table(sheets(folder)).origin.notes[2].startswith("pose P3 from the sheet's name P3")
    assert read_table(below(folder)).origin.notes[4].startswith("pose P5 from the name above it")
    (folder / "P1.csv").write_text(table(1, pose="P1"), encoding="utf-8")
    assert (
        scara_iso.analyze(files(folder))
        .run.origin.notes[0]
        .startswith("pose P1 from '# pose:' of ")
    )


@pytest.mark.parametrize(
    ("title", "pose"),
    [("P1.csv", "P1"), ("p1.csv", "P1"), ("run_P3.csv", "P3"), ("P02-v100-l100.csv", "P2"),
     ("Pose 4", "P4"), ("punkt_5.txt", "P5"), ("P12.xlsx", "P12"), ("run.csv", None),
     ("P1_to_P2.csv", None), ("rep1.csv", None), ("P0.csv", None), ("mp3.csv", None)],
)  # fmt: skip
def test_a_name_holds_one_pose_or_none(title, pose):
    assert pose_in(title) == pose


def refused(given, **options):
    with pytest.raises(DataError) as found:
        scara_iso.analyze(given, **options)
    return f"{found.value}\n  {found.value.remedy}"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"robot": "Other"}, "robot: 'FUM SCARA' in"),
        ({"payload": "5 kg"}, "payload: '2 kg' in"),
        ({"indicator": "Mitutoyo 7"}, None),
        ({"resolution": "0.01"}, "0.01 mm in"),
        ({"resolution": ""}, "not stated in"),
        ({"indicator_uncertainty": "0.001"}, "0.001 mm in"),
        ({"pose": "P1"}, "P3.csv: the file's name says pose P3, the table itself P1"),
        ({"first_cycle_discarded": "true"}, "'true' in "),
        ({"dial_zero": "command"}, "dial_zero: "),
        ({"theta_radius_mm": "50"}, "theta_radius_mm: "),
    ],
)
def test_a_table_of_another_test_is_refused_by_name(folder, change, said):
    (folder / "P3.csv").write_text(table(3, **change), encoding="utf-8")
    if said is None:  # only one table states it: no contradiction, and said
        (note,) = [n for n in scara_iso.analyze(folder).run.origin.notes if "indicator" in n]
        assert note.endswith("P3.csv only")
        return
    found = refused(folder)
    assert said in found
    assert "P3.csv" in found


def test_faults_of_several_axes_come_in_the_order_of_the_axes(rng):
    def part(name, resolution):
        axes = {a: Axis(a, rng.normal(size=31), resolution=resolution) for a in "ZYXABCDE"}
        return PosePart(Run(cycle=np.arange(1, 32), axes=axes), name, pose=name)

    with pytest.raises(DataError) as caught:
        merge([part("P1", 0.001), part("P2", 0.01)], "both")
    assert [one.message.split()[2] for one in caught.value.faults] == [f"{a}:" for a in "XYZABCDE"]


def test_all_that_is_wrong_is_said_at_once(folder):
    (folder / "P2.csv").write_text(table(2, robot="Other"), encoding="utf-8")
    (folder / "run_P1.csv").write_text(table(9), encoding="utf-8")
    (folder / "left.csv").write_text(table(8), encoding="utf-8")
    (folder / "P4.csv").write_text(table(4).replace(",Y", ",Z"), encoding="utf-8")
    found = refused(folder)
    for said in ("left.csv: no pose stated", "P1.csv and again in", "run_P1.csv", "Z: not there in",
                 "'Other' in"):  # fmt: skip
        assert said in found


def test_faults_of_every_table_are_listed_with_its_name(folder):
    for pose, k in (("P2", 2), ("P5", 5)):
        broken = table(k).replace("\n7,", "\n7,x")
        (folder / f"{pose}.csv").write_text(broken, encoding="utf-8")
    found = refused(folder)
    assert "2 of 5 tables" in found
    assert f"{folder / 'P2.csv'}: line 12, column 2: 'x0." in found
    assert f"{folder / 'P5.csv'}: line 12, column 2: 'x0." in found


def test_the_cycle_rule_is_broken_with_file_and_line(folder):
    for pose in ("P2", "P4"):
        lines = (folder / f"{pose}.csv").read_text(encoding="utf-8").splitlines(keepends=True)
        (folder / f"{pose}.csv").write_text("".join(lines[:12] + lines[13:]), encoding="utf-8")
    found = refused(folder)
    for pose in ("P2", "P4"):
        assert f"line 13: pose {pose} ({folder / f'{pose}.csv'}): cycle 8 is missing" in found
    poses = scara_iso.analyze(folder, allow_gaps=True).poses
    assert [len(pose.rows) for pose in poses] == [30, 29, 30, 29, 30]


def test_another_unit_is_converted_and_said(folder):
    text = head(unit="um", resolution="1") + "cycle,X,Y\n"
    text += "".join(
        f"{c},{x * 1000:.0f},{y * 1000:.0f}\n" for c, (x, y) in enumerate(readings(3), 1)
    )
    before = scara_iso.analyze(folder).poses["P3"].axes["X"].RP
    (folder / "P3.csv").write_text(text, encoding="utf-8")
    found = scara_iso.analyze(folder)
    assert found.poses["P3"].axes["X"].RP == pytest.approx(before, rel=1e-12)
    (note, _) = [n for n in found.run.origin.notes if "converted" in n]
    assert note.endswith(
        "X in um, and in mm in " + str(folder / "P1.csv") + "; all is converted to mm"
    )


def test_a_sheet_of_readings_without_a_pose_is_left_out_by_nobody_but_its_user(folder):
    path = sheets(folder)
    book = openpyxl.load_workbook(path)
    sheet = book.create_sheet("Old")
    sheet.append(["cycle", "X [mm]"])
    for cycle in range(1, 32):
        sheet.append([cycle, 0.5])
    book.save(path)
    with pytest.raises(DataError, match="sheet 'Old' holds readings and names no pose"):
        read_table(path)
    assert len(read_table(path, sheet="P2")) == 31
    sheet.sheet_state = "hidden"
    book.save(path)
    run = read_table(path)
    assert list(dict.fromkeys(run.pose.tolist())) == list(POSES)
    assert "sheet 'Old' is hidden: not used" in run.origin.notes


def test_the_faults_of_two_sheets_are_told_together(folder):
    path = sheets(folder)
    book = openpyxl.load_workbook(path)
    for pose in ("P1", "P4"):
        book[pose]["B9"] = "bad"
    book.save(path)
    found = refused(path)
    assert "P1!B9: " in found
    assert "P4!B9: " in found


def test_lines_and_columns_of_a_block_are_those_of_the_file(folder):
    path = beside(folder)
    lines = path.read_text(encoding="utf-8").splitlines()
    cells = lines[9].split(";")
    cells[5] = "oops"
    lines[9] = ";".join(cells)
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    assert "block of P2: cannot be read" in refused(path)
    assert "line 10, column 6: 'oops' is not a number" in refused(path)


def test_a_second_table_without_a_pose_is_still_refused(folder):
    path = folder / "two.txt"
    two = head() + "\n".join(["cycle,X,Y", *rows(1), "", "cycle,X,Y", *rows(2), ""])
    path.write_text(two, encoding="utf-8")
    assert "second table begins" in refused(path)
    path.write_text(two.replace("cycle", "P1\ncycle", 1), encoding="utf-8")
    assert "second table begins" in refused(path)


def test_an_empty_folder_and_missing_tables_are_no_input(tmp_path):
    with pytest.raises(NoInputError):
        scara_iso.analyze(tmp_path)
    with pytest.raises(NoInputError) as found:
        scara_iso.analyze([tmp_path / "P1.csv", tmp_path / "P2.csv"])
    assert "P1.csv" in found.value.headline
    assert "P2.csv" in found.value.headline


def test_a_given_pose_goes_before_and_contradiction_is_refused(folder):
    run, other = (read_table(folder / f"P{k}.csv") for k in (1, 2))
    parts = [
        PosePart(run, "a.csv", "", "test.toml", "A"),
        PosePart(other, "b.csv", "P7.csv", pose="B"),
    ]
    merged = merge(parts, "acceptance")
    assert list(dict.fromkeys(merged.pose.tolist())) == ["A", "B"]
    assert merged.origin.source == "acceptance"
    assert merged.origin.files == {"A": "a.csv", "B": "b.csv"}
    stated = read_table(io.BytesIO(table(2, pose="P1").encode()))
    with pytest.raises(DataError, match="1 fault"):
        merge([parts[0], PosePart(stated, "c.csv", pose="P2")], "acceptance")


def test_statements_that_differ_keep_their_pose(folder):
    for pose, k in (("P1", 1), ("P2", 2)):
        (folder / f"{pose}.csv").write_text(table(k, operator=f"Op {k}", note="n"), "utf-8")
    stated = scara_iso.analyze(folder).run.metadata
    assert stated["operator"] == "P1: Op 1; P2: Op 2"
    assert stated["note"] == "n"


def test_what_one_table_alone_states_is_of_its_pose_and_not_of_the_test(folder):
    own = {"payload": "5 kg", "robot": "Robot B", "temperature": "20 C"}
    for k, pose in enumerate(POSES, 1):
        of = own if pose == "P3" else {}
        text = table(k, **{"payload": "", "robot": "", **of})
        (folder / f"{pose}.csv").write_text(text, encoding="utf-8")
    found = scara_iso.analyze(folder)
    stated = found.run.metadata
    assert {key for key in stated if key.startswith(tuple(own))} == {f"{key}[P3]" for key in own}
    (lacking,) = (one.message for one in found.findings if one.code == "not-stated")
    others = "at P1, P2, P4, P5"
    assert f"load {others}, velocity, ambient temperature {others}" in lacking
    assert main(["report", str(folder), "-o", str(folder / "r.md")]) == 0
    page = (folder / "r.md").read_text()
    assert "Repeatability of P3: Robot B" in page
    assert "temperature P3: 20 C" in page
    assert "| payload | P3: 5 kg |" in page


def test_poses_compare_pose_by_pose(folder, tmp_path):
    after = tmp_path / "after"
    after.mkdir()
    for k, pose in enumerate(POSES[:4], 1):
        (after / f"{pose}.csv").write_text(table(k + 20), encoding="utf-8")
    found = scara_iso.compare(files(folder), after)
    (pair,) = found.pairs
    assert {one.pose for one in pair.spreads} == set(POSES[:4])
    assert {f.code for f in pair.findings} >= {"other-pose"}


def out(*argv, code=0):
    text = io.StringIO()
    with redirect_stdout(text):
        assert main([str(word) for word in argv]) == code
    return text.getvalue()


def test_diagnose_gives_one_object_over_all_poses(folder):
    moved = readings(4) + np.where(np.arange(31) < 15, 0, 0.05)[:, np.newaxis]
    text = head() + "cycle,X,Y\n" + "".join(
        f"{c},{x:.3f},{y:.3f}\n" for c, (x, y) in enumerate(moved, 1)
    )  # fmt: skip
    (folder / "P4.csv").write_text(text, encoding="utf-8")
    found = json.loads(out("diagnose", *files(folder), "--json"))
    assert found["schema"] == "scara-iso/diagnose/2"
    assert [one["pose"] for one in found["poses"]] == list(POSES)
    assert [one["poses"] for one in found["effects"]] == [["P4"]]
    assert found["effects"][0]["effect"] == "step"
    assert found["verdict"] == "explained"
    alone = json.loads(out("diagnose", folder / "P4.csv", "--json"))
    together = found["poses"][3]
    for when in ("before", "after"):
        assert together["error"][when]["rms"] == pytest.approx(alone["error"][when]["rms"])
    for RP in ("measured", "with_effect_removed"):
        assert together["repeatability"][RP] == pytest.approx(alone["repeatability"][RP])
    for axis, read in alone["series"]["measured"].items():
        assert together["series"]["measured"][axis] == read
    assert found["p_value"] <= 0.05


def test_unrelated_tables_are_still_summed_up(folder):
    (folder / "P1.csv").rename(folder / "a.csv")
    (folder / "P2.csv").rename(folder / "b.csv")
    found = json.loads(out("diagnose", folder / "a.csv", folder / "b.csv", "--json"))
    assert found["schema"] == "scara-iso/diagnose-many/1"


def test_the_table_of_poses_comes_before_the_details(folder):
    said = out("analyze", folder, "--full")
    assert said.index("pose               RP XY [mm]") < said.index("pose P1: repeatability")


def test_a_report_of_five_files_holds_the_hash_of_each(folder, tmp_path):
    report = scara_iso.report(folder)
    names = [file.name for file in report.dossier.provenance.files]
    assert names == [str(path) for path in files(folder)]
    assert len({file.sha256 for file in report.dossier.provenance.files}) == 5
    assert out("report", folder, "-o", folder / "P1.csv", code=73) == ""


@st.composite
def several_poses(draw):
    poses = draw(st.lists(st.sampled_from([f"P{k}" for k in range(1, 9)]), min_size=2, unique=True))
    cycles = draw(st.integers(min_value=2, max_value=6))
    count = cycles * len(poses)
    numbers = st.integers(min_value=-(10**6), max_value=10**6).map(lambda k: k / 1000)
    values = draw(st.lists(numbers, min_size=count, max_size=count))
    return Run(
        cycle=np.repeat(np.arange(1, cycles + 1), len(poses)),
        axes={"X": scara_iso.run.Axis("X", np.array(values), resolution=0.001)},
        pose=np.array(poses * cycles),
        metadata={"robot": "FUM SCARA"},
    )


@given(several_poses())
def test_a_test_split_into_tables_and_merged_is_itself(run):
    parts = []
    for pose, rows in run.rows_by_pose():
        text = write_table(run.take(rows)).encode()
        parts.append(PosePart(read_table(text), f"{pose}.csv", f"{pose}.csv"))
    merged = merge(parts, "test")
    for (pose, mine), (label, theirs) in zip(
        run.rows_by_pose(), merged.rows_by_pose(), strict=True
    ):
        assert pose == label
        assert merged.cycle[theirs].tolist() == run.cycle[mine].tolist()
        np.testing.assert_array_equal(
            merged.axes["X"].readings[theirs], run.axes["X"].readings[mine]
        )
    assert merged.axes["X"].resolution == run.axes["X"].resolution
    assert dict(merged.metadata) == dict(run.metadata)


def test_no_two_ways_of_giving_the_poses_differ(folder, tmp_path):
    made = [below(folder), beside(folder), sheets(folder)]
    runs = [read_table(path) for path in made]
    for one, other in combinations(runs, 2):
        assert one.pose.tolist() == other.pose.tolist()
        assert one.axes["Y"].readings.tolist() == other.axes["Y"].readings.tolist()
        assert dict(one.metadata) == dict(other.metadata)


def test_tables_of_which_none_names_a_pose_are_no_poses_and_say_what_else_to_do(tmp_path):
    for k in (1, 2, 3):
        (tmp_path / f"R{k}.csv").write_text(table(k, robot=f"R{k}"), encoding="utf-8")
    found = refused(tmp_path)
    assert "1 fault" in found
    assert "R2.csv and" in found
    assert "scara-iso history" in found
    assert "'R1'" not in found


def test_many_tables_say_each_what_to_do_with_it(tmp_path):
    """One line of advice for all of them would not say which is for which."""
    for k, broken in enumerate((b"", b"%PDF", b"X;Y\n0,1;0,2\n", b"# unit: mm\nX,Y\n0.1,a\n"), 1):
        (tmp_path / f"P{k}.csv").write_bytes(broken)
    found = refused(tmp_path).splitlines()
    assert found[-1].strip() == "follow the advice below each table"
    for k, todo in enumerate(("header row", "into a spreadsheet", "`unit=mm`", "one number"), 1):
        assert any(f"P{k}.csv: " in line and todo in line for line in found)


def one_axis(path, axis, *, cycles=31, head=""):
    rows = "\n".join(f"{k},{0.1 + k % 7 / 1000:.3f},{k}.5" for k in range(1, cycles + 1))
    path.write_text(f"# unit: mm\n{head}cycle,{axis},time_s\n{rows}\n")
    return path


@pytest.mark.parametrize("head", ["", "# pose: P1\n"])
def test_tables_of_an_axis_each_are_one_test_recorded_separately(tmp_path, head):
    dials = [f"# indicator: {serial}\n" for serial in ("ID-1", "ID-2")]
    x = one_axis(tmp_path / "a.csv", "X", head=head + dials[0])
    y = one_axis(tmp_path / "b.csv", "Y", head=head + dials[1])
    both = scara_iso.analyze([x, y])
    (pose,) = both.poses
    assert [*pose.axes] == ["X", "Y"]
    assert "separate-axes" in {one.code for one in both.findings}
    assert both.run.metadata["indicator"] == "X: ID-1; Y: ID-2"
    assert "time_s" in both.run.covariates
    assert pose.axes["X"].RP == scara_iso.analyze(x).poses[0].axes["X"].RP
    out = io.StringIO()
    with redirect_stdout(out):
        assert main(["diagnose", str(x), str(y), "--json"]) == 0
    assert [*json.loads(out.getvalue())["series"]["measured"]] == ["X", "Y"]


def test_axes_of_other_cycles_are_not_paired(tmp_path):
    x = one_axis(tmp_path / "a.csv", "X")
    y = one_axis(tmp_path / "b.csv", "Y", cycles=30)
    with pytest.raises(DataError, match="1 fault") as refused:
        scara_iso.analyze([x, y])
    assert "not at the same cycles" in refused.value.faults[0].message


def test_axes_of_two_robots_are_not_paired(tmp_path):
    x = one_axis(tmp_path / "a.csv", "X", head="# robot: R1\n")
    y = one_axis(tmp_path / "b.csv", "Y", head="# robot: R2\n")
    with pytest.raises(DataError) as refused:
        scara_iso.analyze([x, y])
    assert "robot" in refused.value.faults[0].message


def places(path, axis, order, side="+x"):
    """Write two cycles at P1 and P2 in an ``order``, each approached from a side."""
    rows = "\n".join(f"{pose},{cycle},0.{k},{side}" for k, (pose, cycle) in enumerate(order, 1))
    path.write_text(f"# unit: mm\npose,cycle,{axis},approach\n{rows}\n")
    return PosePart(read_table(path), path.name)


def test_axes_are_paired_at_the_same_places_in_the_same_order(tmp_path):
    order = [("P1", 1), ("P2", 1), ("P1", 2), ("P2", 2)]
    x = places(tmp_path / "x.csv", "X", order)
    both = merge([x, places(tmp_path / "y.csv", "Y", order)], "both")
    assert both.direction.tolist() == ["+x"] * 4
    other_order = [("P1", 1), ("P2", 1), ("P2", 2), ("P1", 2)]
    for rows, side in ((other_order, "+x"), (order, "-x")):
        with pytest.raises(DataError):
            merge([x, places(tmp_path / "z.csv", "Z", rows, side)], "both")
