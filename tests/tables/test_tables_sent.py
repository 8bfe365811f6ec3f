"""What technicians send is read to its numbers, or refused with the one thing to do, which works.

The files are made after the manner of each program: tests/fixtures/tables/sent/README.md.
"""

import io
import re
from pathlib import Path

import numpy as np
import openpyxl
import pytest

from scara_iso.base.errors import DataError, UsageError
from scara_iso.commands import main
from scara_iso.commands.shared.output import as_options
from scara_iso.iso9283 import Counting, analyze
from scara_iso.tables import read_table

SENT = Path(__file__).parents[1] / "fixtures" / "tables" / "sent"
X = [0.112, 0.113, -0.108, 0.112, 1.110]
Y = [0.811, 0.812, 0.811, 0.810, 0.811]
Z = [0.360, 0.361, 0.359, 0.360, 0.362]
INCH = 25.4

READ = {
    "excel_notes_beside.xlsx": ({}, {"X": X, "Y": Y}),
    "excel_pose_blocks.xlsx": ({}, {"X": X + Y, "Y": Y + X}),
    "excel_sheets.xlsx": ({}, {"X": X + Y}),
    "klipper.log": ({}, {"Z": Z}),
    "marlin_m48.log": ({}, {"Z": Z}),
    "fanuc_us_dates.csv": ({}, {"X": [INCH * x for x in X], "Y": [INCH * y for y in Y]}),
    "markdown.md": ({}, {"X": X, "Y": Y, "Z": Z}),
    "tracker_german.txt": ({}, {"X": X, "Y": Y, "Z": Z}),
}
"""Read as they are."""
UNIT, FIELDS, ONE_HEADER = "unit=mm", "columns=", "in one header row"
REFUSED = {
    "excel_merged_heading.xlsx": (UNIT, {"X": X, "Y": Y, "Z": Z}),
    "robot_controller.log": (UNIT, {"X": X, "Y": Y, "Z": Z}),
    "tracker.csv": (UNIT, {"X": X, "Y": Y, "Z": Z}),
    "gauge_app.csv": ("columns=-,X,-", {"X": X}),
    "keyence.csv": ("columns=cycle,-,X,Y", {"X": X, "Y": Y}),
    "labview.lvm": ("columns=-,X,Y,-", {"X": X, "Y": Y}),
    "marker.csv": ("columns=cycle,X,Y,Z", {"X": X, "Y": Y, "Z": Z}),
    "numpy.txt": ("columns=X,Y,Z", {"X": X, "Y": Y, "Z": Z}),
    "oscilloscope.csv": ("columns=-,X,Y", {"X": X, "Y": Y}),
    "oscilloscope_head.csv": ("columns=-,X", {"X": X}),
    "rostopic.csv": ("columns=-,cycle,X,Y,Z", {"X": X, "Y": Y, "Z": Z}),
    "rtde.csv": ("columns=-,X,Y,Z", {"X": X, "Y": Y, "Z": Z}),
    "usb_wedge.txt": ("columns=X", {"X": X}),
}
"""Refused; the option that the remedy names reads them."""
EDITED = {
    "bed_mesh.log": ("lines of one place", lambda t: t.split("\n")[0] + "\n" + t.split("\n")[0]),
    "cmm_report.txt": ("begin with a header row", lambda _: "cycle,X,Y\n1,0.112,0.811\n"),
    "excel_summary_beside.xlsx": ("remove the column", lambda _: "n,X\n1,0.112\n"),
    "excel_two_rows_of_headings.xlsx": (ONE_HEADER, lambda _: "n;X;Abw.;Y\n1;0,1;0;0,8\n"),
    "grbl_probe.log": ("begin with a header row", lambda _: "cycle,Z\n1,0.360\n"),
    "iso230.csv": ("a row for each reading", lambda _: "pose,approach,cycle,X\nT1,+x,1,0.001\n"),
    "iso230_list.txt": ("a row for each reading", lambda _: "pose,cycle,X\nT1,1,1.2\n"),
    "iso230_targets.csv": ("a row for each reading", lambda _: "pose,cycle,X\nT1,1,0.0012\n"),
    "klipper_two_tests.log": ("lines of one test", lambda t: "\n".join(t.split("\n")[:3])),
    "marlin_m114.log": ("one column for each axis", lambda t: re.sub(" Count.*", "", t)),
    "matlab.m": ("begin with a header row", lambda _: "X,Y\n0.112,0.811\n"),
    "psql.txt": ("remove lines", lambda t: t.replace("(5 rows)\n", "")),
    "readings.json": ("begin with a header row", lambda _: "X,Y\n0.112,0.811\n"),
    "robot_controller_poses.log": ("lines of one place", lambda t: "\n".join(t.split("\n")[::2])),
    "spc_export.csv": ("leave one table", lambda t: t[t.index("Sample;") :]),
}
"""Refused; with the file as the remedy says it is read."""


def assert_readings(run, expected):
    assert set(run.axes) == set(expected)
    for name, readings in expected.items():
        assert run.axes[name].readings.tolist() == pytest.approx(readings, rel=1e-15)


def test_every_file_is_here_and_on_its_page():
    files = {path.name for path in SENT.iterdir()} - {"README.md"}
    assert files == {*READ, *REFUSED, *EDITED}
    page = (SENT / "README.md").read_text(encoding="utf-8")
    assert {name for name in files if f"`{name}`" not in page} == set()


@pytest.mark.parametrize("name", READ)
def test_read_as_it_is(name):
    options, expected = READ[name]
    assert_readings(read_table(SENT / name, **options), expected)


def option_in(remedy):
    """Return the option that a remedy names, as a keyword."""
    key, value = re.search(r"`(unit|columns)=([^`]+)`", remedy).groups()
    return {key: value}


@pytest.mark.parametrize("name", REFUSED)
def test_the_option_that_a_refusal_names_reads_the_file(name):
    wanted, expected = REFUSED[name]
    with pytest.raises(DataError) as refused:
        read_table(SENT / name)
    assert f"`{wanted}`" in refused.value.remedy
    options = option_in(refused.value.remedy)
    if "unit" not in options:  # gauges whose file states none are asked next
        try:
            read_table(SENT / name, **options)
        except DataError as asked:
            options |= option_in(asked.remedy)
    assert_readings(read_table(SENT / name, **options), expected)


@pytest.mark.parametrize("name", EDITED)
def test_what_a_refusal_says_to_do_is_enough(name, tmp_path):
    wanted, edit = EDITED[name]
    with pytest.raises(DataError) as refused:
        read_table(SENT / name, unit="mm")
    assert wanted in refused.value.remedy
    text = "" if name.endswith(".xlsx") else (SENT / name).read_text(encoding="utf-8")
    assert len(read_table(edit(text).encode(), unit="mm")) > 0


@pytest.mark.parametrize("title", ["Pose {} (500/200/100)", "P{} [A]"])
def test_coordinates_behind_a_pose_s_name_are_not_read(title):
    table = "".join(f"{title.format(k)}\nNr;X（mm）\n1;0,{k}\n\n" for k in (1, 2))
    run = read_table(table.encode())
    assert run.pose.tolist() == ["P1", "P2"]
    assert run.axes["X"].readings.tolist() == [0.1, 0.2]


HEADINGS = [
    "X", "Messwert X", "Wert X", "dX", "Dial 1 (X)", "dial X", "Messuhr X", "X Messwert",
    "Dial 2 (X) [mm]", "X-Achse", "X Ist", "Lectura X",
]  # fmt: skip


@pytest.mark.parametrize("head", HEADINGS)
def test_a_heading_names_its_axis(head):
    run = read_table(f"cycle;{head}\n1;0,112\n2;0,113\n".encode(), unit="mm")
    assert run.axes["X"].readings.tolist() == [0.112, 0.113]


def test_words_in_some_rows_are_a_comment_and_in_every_row_refused():
    data = b"cycle,X,Wetter\n1,0.1,\n2,0.2,door opened\n"
    run = read_table(data, unit="mm")
    assert "column 3 'Wetter' not used" in run.origin.notes
    full = data.replace(b"0.1,", b"0.1,dry")
    with pytest.raises(DataError) as refused:
        read_table(full, unit="mm")
    assert "call it comment" in refused.value.remedy
    assert len(read_table(full.replace(b"Wetter", b"comment"), unit="mm")) == 2


def test_two_headings_of_one_axis_are_refused():
    with pytest.raises(DataError, match="two columns for X"):
        read_table(b"cycle,X,dX\n1,0.112,0.1\n", unit="mm")


def test_an_abscissa_is_no_axis():
    assert set(read_table(b"X_Value,Y\n1,0.2\n2,0.3\n", unit="mm").axes) == {"Y"}


def test_columns_that_the_header_names_otherwise_are_refused():
    with pytest.raises(DataError, match="Y by the header") as refused:
        read_table(b"Y,X\n0.1,0.2\n0.2,0.3\n", unit="mm", columns="X,Y")
    assert "leave `columns=` out" in refused.value.remedy
    assert [(fault.line, fault.column) for fault in refused.value.faults] == [(1, 1), (1, 2)]
    run = read_table(b"Y,X\n0.1,0.2\n0.2,0.3\n", unit="mm")
    assert run.axes["X"].readings.tolist() == [0.2, 0.3]


@pytest.mark.parametrize("data", ["Samples,5\n1;{}\n2;{}\n", "Samples;5\n1,{}\n2,{}\n"])
def test_named_columns_are_parted_as_most_rows_are(data):
    run = read_table(data.format(0.512, 0.513).encode(), unit="mm", columns="-,X")
    assert run.axes["X"].readings.tolist() == [0.512, 0.513]


@pytest.mark.parametrize("columns", ["", "-", "a,b", "X,", "X,,Y", []])
def test_columns_without_an_axis_are_refused(columns):
    with pytest.raises(UsageError, match="name no axis"):
        read_table(b"0.1,0.2\n", unit="mm", columns=columns)


def test_columns_are_a_sequence_too_and_give_cycle_and_pose():
    data = b"1 P1 0.1 9\n2 P1 0.2 9\n"
    run = read_table(data, unit="mm", columns=["cycle", "pose", "X", "-"])
    assert run.axes["X"].readings.tolist() == [0.1, 0.2]
    assert run.cycle.tolist() == [1, 2]
    assert run.pose.tolist() == ["P1", "P1"]


def test_a_row_of_another_width_is_refused_with_columns():
    with pytest.raises(DataError, match="2 fields, the header has 3"):
        read_table(b"1 0.1 0.2\n2 0.2\n3 0.1 0.3\n", unit="mm", columns="cycle,X,Y")


@pytest.mark.parametrize(
    ("log", "said"),
    [
        ("x=1.234,5 y=0.2\nx=1.334,5 y=0.4\n", "a comma and a point"),
        ("x=0.1mm y=2um\nx=0.3mm y=4um\n", "unit um against mm"),
        ("x=0.1 y=nan\nx=0.3 y=0.2\nx=0.3 y=0.2\n", "'nan' is not a number"),
        ("x=0.1\nx=0.3 y=0.2\nx=0.3 y=0.2\n", "not as the other lines"),
        ("x=0.1 y=0.2\nx=0.3 y=0.2\nx=0.3\n", "not as the other lines"),
        ("dx=0.1 x=0.2\ndx=0.3 x=0.2\n", "two columns for X"),
        ("P1: x=0.1\nP2: x=0.2\n", "another place or pose"),
        ("at 1.0 x=0.1\nat 2.0 x=0.2\n", "another place or pose"),
        ("x=0.1\nx=0.2\nrun 2\nx=0.3\n", "does another test begin"),
        ("x=0.1 at=P1\nx=0.2 at=P2\n", "another place or pose"),
        ("x=0.1 gain=low\nx=0.2 gain=low\nx=0.1 gain=high\nx=0.2 gain=high\n", "an axis too"),
    ],
)
def test_a_log_that_could_be_read_two_ways_is_refused(log, said):
    with pytest.raises(DataError, match=said):
        read_table(log.encode(), unit="mm")


def test_a_log_is_read_with_its_counts_signs_and_words_between():
    log = "visit 1: x = -0.1\ndoor opened\nvisit 2: x= \N{MINUS SIGN}0.2\n"
    run = read_table(log.encode(), unit="mm")
    assert run.axes["X"].readings.tolist() == [-0.1, -0.2]
    assert "line 2: 'door opened' not used" in run.origin.notes


def test_a_cut_row_above_named_columns_is_refused():
    with pytest.raises(DataError, match="1 numbers above the first row") as refused:
        read_table(b"0.3\n0.1 0.2\n0.1 0.2\n", unit="mm", columns="X,Y")
    assert "remove it" in refused.value.remedy


def test_the_command_shows_each_field_and_writes_the_canonical_table(tmp_path, capsys):
    out = tmp_path / "run.csv"
    assert main(["tables", str(SENT / "markdown.md"), "-o", str(out)]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"2 +Messwert X +axis X +mm +0\.112 +1\.11", shown)
    assert "ruled line" in shown
    assert_readings(read_table(out), {"X": X, "Y": Y, "Z": Z})


def test_the_command_says_why_not_and_what_to_do(capsys):
    assert main(["tables", str(SENT / "rtde.csv")]) == 65
    assert "--columns -,X,Y,Z" in capsys.readouterr().err
    assert main(["tables", str(SENT / "rtde.csv"), "--columns", "-,X,Y,Z", "--unit", "mm"]) == 0
    assert as_options("`columns=-,X,Y,Z`") == "--columns -,X,Y,Z"


def test_a_unit_in_the_files_own_heading_is_not_overruled_in_silence():
    rows = b"T(s),OUT1(um)\n1,0.5\n2,0.6\n3,0.5\n"
    for columns in ("-,X", "-,X_um"):
        assert read_table(rows, columns=columns).axes["X"].readings[0] == 0.0005
        with pytest.raises(DataError, match="unit um against mm"):
            read_table(rows, unit="mm", columns=columns)
    with pytest.raises(DataError, match="'um' heads X"):
        read_table(rows, columns="-,X_mm")


FORM = "Nr;X;Y\n1;0,112;0,811\n2;0,113;0,812\n"


@pytest.mark.parametrize(
    ("above", "resolution", "kept"),
    [
        ("Datum:;2026-03-01;;Prüfer:;Meier\n", None, {"date": "2026-03-01", "operator": "Meier"}),
        ("Datum: 2026-03-01;;Prüfer: Meier\n", None, {"date": "2026-03-01", "operator": "Meier"}),
        ("Start:;10:30;Datei:;C:\\p;;Prüfer:;\n", None,
         {"start": "10:30", "datei": "C:\\p", "operator": ""}),
        ("Roboter: A    Auflösung: 0,001 mm\n", 0.001, {"robot": "A"}),
        ("Auflösung 0,001 mm\n", 0.001, {}),
        ("Protokoll;Messuhr: M;Auflösung 1 µm\n", 0.001, {"dial": "M"}),
        ("Auflösung Messuhr;0,001;mm\n", 0.001, {}),
        ("Auflösung X [mm];0,01;;Auflösung Y;10;µm\n", 0.01, {}),
        ("Auflösung;0,001;;Prüfer;Meier\n", None, {}),
        ("Messuhr M;Auflösung 1 µm\n", 0.001, {}),
        ("Auflösung:;0,01;mm;Ort:;Halle 3;Nord\n", 0.01, {"ort": "Halle 3, Nord"}),
        ("Resolution [µm]:;5\n", 0.005, {}),
        ("Nutzlast [kg]:;2,5;;Geschwindigkeit in mm/s:;500\n", None,
         {"payload": "2,5 kg", "velocity": "500 mm/s"}),
        ("Payload (kg): 2\nSerien-Nr.: 0047\n", None,
         {"payload": "2 kg", "serial_number": "0047"}),
        ("Nutzlast: 2 kg\nTraglast: 5 kg\n", None,
         {"payload": "2 kg", "rated_payload": "5 kg"}),
        ("Raumtemperatur: 20 °C\nUmgebungstemperatur: 21 °C\n", None,
         {"ambient_temperature": "20 °C", "umgebungstemperatur": "21 °C"}),
        ("Datum: 01.03.2026\nDate: 2026-03-01\n", None,
         {"datum": "01.03.2026", "date": "2026-03-01"}),
        ("Prüfer [2]: 5\n", None, {"prüfer_[2]": "5"}),
        ("日期：;2026-03-01;;分辨率：;0.001 mm\n", 0.001, {"日期": "2026-03-01"}),
        ("Skalenteilung der Messuhr: 0,01 mm\n", 0.01, {}),
        ("Encoder resolution: 0.001 mm\n", None, {"encoder_resolution": "0.001 mm"}),
        ("Messuhr M, Auflösung 0,001 mm\n", None, {}),
        ("Datum;2026-03-01 10:30;Prüfer;Meier\n", None, {}),
    ],
)  # fmt: skip
def test_the_head_of_a_form_is_read_statement_by_statement(above, resolution, kept):
    run = read_table((above + FORM).encode(), unit="mm")
    assert [axis.resolution for axis in run.axes.values()] == [resolution] * 2
    assert run.metadata == kept
    said = any("if it is the dial's" in note for note in run.origin.notes)
    assert said == (resolution is None and "0.001" in above.replace(",", "."))


@pytest.mark.parametrize(
    ("table", "remedy", "mended"),
    [
        (FORM + "Auflösung:;0,001 mm\n", "above the header", "Auflösung:;0,001 mm\n" + FORM),
        ("Auflösung: 0,01 / 0,001 mm\n" + FORM, "one number", "Auflösung: 0,01\n" + FORM),
        ("Auflösung: 1 µm;Skalenteilung: 1 mm\n" + FORM, "one of them", "Auflösung: 1 µm\n" + FORM),
        ("Nr;X;;Nr;X\n1;0,1;;2;0,2\n", "goes below it", "Nr;X\n1;0,1\n2;0,2\n"),
        ("Nr;X1;X2\n1;0,1;0,2\n", "row for each reading", "Nr;X\n1;0,1\n2;0,2\n"),
        ("Pose;X\nP1;0,1\n;0,2\n", "in each row", "Pose;X\nP1;0,1\nP1;0,2\n"),
    ],
)
def test_what_a_form_s_refusal_says_to_do_is_enough(table, remedy, mended):
    with pytest.raises(DataError) as refused:
        read_table(table.encode(), unit="mm")
    assert remedy in refused.value.remedy
    assert len(read_table(mended.encode(), unit="mm")) == 2


def test_the_line_to_sign_on_below_a_form_is_no_reading():
    run = read_table((FORM + "Datum:;01.03.2026;Unterschrift:;\n").encode(), unit="mm")
    assert len(run) == 2
    assert "'Datum:, 01.03.2026, Unterschrift:' not used" in run.origin.notes[-1]


WIDE = "Auflösung;1 µm\nNr.;{}\n" + "".join(
    f"{k};50{k % 4};60{k % 3};70{k % 5};80{k % 2}\n" for k in range(1, 32)
)


@pytest.mark.parametrize(
    ("heads", "order"),
    [
        ("P1 X [µm];P1 Y [µm];P2 X [µm];P2 Y [µm]", (500, 600, 700, 800)),
        ("X P1 [µm];X P2 [µm];Y-P1 [µm];Y-P2 [µm]", (500, 700, 600, 800)),
        ("Pose 1: X / µm;Punkt 2 Y (µm);P01_Y_um;P2 Achse X [µm]", (500, 700, 800, 600)),
    ],
)
def test_headings_that_name_pose_and_axis_are_poses_in_any_order(heads, order):
    run = read_table(WIDE.format(heads).encode(), decimal=",")
    rows = dict(run.rows_by_pose())
    found = [run.axes[axis].readings[rows[pose]] for pose in ("P1", "P2") for axis in "XY"]
    assert [int(one.min() * 1000) // 10 * 10 for one in found] == list(order)
    assert [len(one) for one in found] == [31] * 4
    assert run.axes["X"].resolution == 0.001


def test_a_pose_that_a_heading_names_once_is_no_table_of_poses():
    with pytest.raises(DataError, match="no header that names an axis"):
        read_table(WIDE.format("P1 X [µm];Kraft;Weg;Zeit").encode(), decimal=",")


@pytest.mark.parametrize("heads", ["X;Y;P2 X;P2 Y", "P1 X;P2 X;Z;theta", "X [µm];Y [µm];P1 X;u"])
def test_an_axis_of_a_pose_beside_one_of_no_pose_is_refused(heads):
    with pytest.raises(DataError, match=r"is of pose P[12], other axes of none"):
        read_table(f"# unit: um\n{WIDE.format(heads)}".encode(), decimal=",")


@pytest.mark.parametrize("heads", ["P0 X [mm];P1 X [mm]", "Pose A X [mm];Pose B X [mm]"])
def test_poses_without_a_number_from_1_are_not_taken_for_axes_of_one(heads):
    rows = "".join(f"{k};0.50{k % 4};0.60{k % 4}\n" for k in range(1, 32))
    with pytest.raises(DataError) as caught:
        read_table(f"Nr;{heads}\n{rows}".encode())
    assert "head them P1_X" in caught.value.remedy


def test_a_row_of_titles_above_the_header_heads_no_columns():
    rows = [[(k + 1) // 2, f"P{2 - k % 2}", 0.5 + k % 4 / 1000] for k in range(1, 63)]
    book, data = openpyxl.Workbook(), io.BytesIO()
    for row in [["X P1", "X P2"], ["Nr", "pose", "X"], *rows]:
        book.active.append(row)
    book.save(data)
    assert len(read_table(data.getvalue(), unit="mm")) == 62


@pytest.mark.parametrize(
    "table",
    [
        "# resolution: 0.001\nP1 X [mm],P2 X [mm]\n" + "0.501,0.601\n" * 9 + "0.502,0.6",
        "# resolution: 0.001\nP1\nX [mm],Y [mm]\n" + "0.501,0.601\n" * 9
        + "P2\nX [mm],Y [mm]\n" + "0.501,0.601\n" * 9 + "0.502,0.6",
    ],
)  # fmt: skip
def test_a_file_of_several_poses_that_is_cut_inside_a_number_is_refused(table):
    assert read_table(f"{table}02\n".encode()).pose is not None
    with pytest.raises(DataError, match="is the file cut"):
        read_table(table.encode())


@pytest.mark.parametrize("head", ["P1 X;P2 X", "P1;;P2\nX;Y;X;Y"])
def test_points_that_may_group_thousands_are_asked_for_of_several_poses_too(head):
    fields = head.rpartition("\n")[2].count(";") + 1
    row = ";".join(["{}"] * fields) + "\n"
    rows = "".join(row.format(*[f"1.5{k}{j}" for j in range(fields)]) for k in range(10, 41))
    with pytest.raises(DataError, match="could have a decimal point or group thousands"):
        read_table(f"# unit: um\n{head}\n{rows}".encode())
    run = read_table(f"# unit: um\n{head}\n{rows}".encode(), decimal=".")
    assert "decimal point as asked" in run.origin.notes[0]


def test_whole_numbers_of_two_poses_are_read():
    run = read_table(b"# unit: um\nP1 X,P2 X\n" + b"500,600\n" * 31)
    assert [len(rows) for _, rows in run.rows_by_pose()] == [31, 31]


@pytest.mark.parametrize(
    ("heads", "covariates"),
    [
        ("Temp (C);Last [kg]", ["temperature_C", "payload_kg"]),
        ("Temperatur in °C;T [°C]", ["temperature_C", "T [°C]"]),
        ("Temp (C);T (C)", ["Temp (C)", "T (C)"]),
        ("Temperature (F);u", ["temperature_C", "u"]),
        ("Ambient temperature;Time\n;µm;µm;°C;s", ["temperature_C", "time_s"]),
    ],
)
def test_a_covariate_is_what_its_heading_means_where_no_other_is(heads, covariates):
    run = read_table(WIDE.format(f"X [µm];Y [µm];{heads}").encode(), decimal=",")
    assert list(run.covariates) == covariates


def test_a_length_or_angle_that_names_no_axis_is_said():
    run = read_table(WIDE.format("X [µm];Höhe [µm];Drehung [°];u").encode(), decimal=",")
    said = [note for note in run.origin.notes if "names no axis" in note]
    assert ["X, Y or Z" in said[0], "theta" in said[1], len(said)] == [True, True, 2]


ONES = "Nr.;X [mm]\n" + "".join(f"{k};1,50{k % 4}\n" for k in range(1, 32))


def test_a_stated_resolution_with_a_decimal_comma_says_what_commas_are():
    run = read_table(f"Auflösung;0,001 mm\n{ONES}".encode())
    assert run.axes["X"].readings.max() == 1.503
    assert "decimal comma" in run.origin.understood
    for head in ("", "# resolution: 0.001\n", "Auflösung;1 µm\n", "Prüfer: 0,5\n"):
        with pytest.raises(DataError, match="could have a decimal comma or group"):
            read_table((head + ONES).encode())


@pytest.mark.parametrize(
    ("name", "said"), [("klipper.log", "Klipper PROBE_ACCURACY"), ("marlin_m48.log", "Marlin M48")]
)
def test_a_machine_that_names_itself_needs_no_unit_and_its_own_deviation_is_not_taken(name, said):
    text = (SENT / name).read_bytes()
    run = read_table(text)
    notes = "\n".join(run.origin.notes)
    assert f"a log of {said}: lengths in mm" in notes
    assert "standard deviation 0.001020 mm divides by n, not by n - 1, and is not taken" in notes
    assert np.std(run.axes["Z"].readings) == pytest.approx(0.00102, abs=5e-7)
    assert analyze(run, Counting(cycles=5, all_count=True)).poses[0].axes["Z"].n == 5
    assert_readings(read_table(text, unit="um"), {"Z": [value / 1000 for value in Z]})
    strange = re.sub(rb"PROBE_ACCURACY|M48", b"OTHER", text)
    with pytest.raises(DataError, match="unit"):
        read_table(strange)


def test_a_log_of_two_machines_states_no_unit():
    text = b"M48 Z-Probe Repeatability Test\n" + (SENT / "klipper.log").read_bytes()
    with pytest.raises(DataError, match="unit"):
        read_table(text)


@pytest.mark.parametrize(
    "label",
    ["St. dev", "S.D.", "Écart type", "Dev. std", "Scarto tipo", "Desviación estándar", "Media"],
)
def test_a_figure_below_unnumbered_readings_is_no_reading_in_five_languages(label):
    rows = [f"{x:.3f}," for x in X + Y] + [f"0.005,{label}"]
    text = "\n".join(["# resolution: 0.001 mm", "X [mm],comment", *rows, ""])
    assert read_table(text.encode()).axes["X"].shown.tolist() == X + Y


@pytest.mark.parametrize(
    "stated",
    ["Einheit: µm", "# unit: um", "# first_cycle: counts", "# correction_X: 0 0; 2 0.1",
     "Roboter: B", "Auflösung: 0,01 mm", "Bemerkung: Zyklus 7 ungültig"],
)  # fmt: skip
def test_a_sheet_that_is_asked_for_takes_nothing_from_another_table(tmp_path, stated):
    book = openpyxl.Workbook()
    first, second = book.active, book.create_sheet("Dienstag")
    first.title, cover = "Montag", book.create_sheet("Deckblatt")
    cover.append(["Kunde:", "Meier"])
    second.append([stated])
    for sheet in (first, second):
        sheet.append(["Nr", "X [mm]"])
        for k in range(1, 32):
            sheet.append([k, 0.1 + 0.001 * (k * 7 % 11)])
    book.save(tmp_path / "two.xlsx")
    run = read_table(tmp_path / "two.xlsx", sheet="Montag")
    assert run.metadata == {"client": "Meier"}
    assert run.axes["X"].resolution is None
    assert run.axes["X"].readings.max() < 1
    assert "sheet 'Dienstag' holds another table: not used" in run.origin.notes
    assert run.origin.remarks == ()


def rows_of(cells):
    """Return 31 rows: a number, a cell for each reading, then what ``cells`` gives for the row."""
    return "".join(f"{k};0.5{k % 7};0.6{k % 5}{cells(k)}\n" for k in range(1, 32))


@pytest.mark.parametrize(
    "heads",
    ["Uhr X (mm);Uhr Y (mm)", "Sonde X [mm];Sonde Y [mm]", "X Fühler [mm];Y Fühler [mm]",
     "Laser-Sonde X [mm];Laser-Sonde Y [mm]", "Axe X [mm];Axe Y [mm]"],
)  # fmt: skip
def test_any_one_word_may_stand_with_the_axes(heads):
    run = read_table(f"Nr;{heads}\n{rows_of(lambda _: '')}".encode())
    assert list(run.axes) == ["X", "Y"]
    assert run.axes["Y"].readings[2] == 0.63
    word = heads.split(";", maxsplit=1)[0].replace("X", "").split("[")[0].split("(")[0].strip()
    assert word == "Axe" or any(f"'{word.lower()}' before" in note for note in run.origin.notes)


@pytest.mark.parametrize("word", ["abs", "X filt", "neg", "corrected", "Ø", "Rohwert"])
def test_a_word_with_each_axis_that_names_no_instrument_is_a_warning(word):
    first = word if "X" in word else f"{word} X"
    heads = ";".join(f"{first.replace('X', axis)} [mm]" for axis in "XY")
    (remark,) = read_table(f"Nr;{heads}\n{rows_of(lambda _: '')}".encode()).origin.remarks
    assert remark == f"line 1 {word.replace('X ', '').lower()!r} with each axis"


@pytest.mark.parametrize("word", ["Sonde", "Kanal", "Uhr", "Messtaster"])
def test_an_instrument_with_each_axis_is_no_warning(word):
    heads = f"{word} X [mm];{word} Y [mm]"
    assert not read_table(f"Nr;{heads}\n{rows_of(lambda _: '')}".encode()).origin.remarks


@pytest.mark.parametrize(
    ("heading", "of_row", "said"),
    [("Wdh.", lambda k: 2 if k in (3, 9) else 1, "is 1 or 2, one of them rarely"),
     ("Korrektur [mm]", lambda k: "0,002" if k > 15 else "0,000", "a zero"),
     ("offset (mm)", lambda k: "0,002" if k > 15 else "0,000", "a zero")],
)  # fmt: skip
def test_a_column_that_marks_or_moves_some_readings_is_asked_about(heading, of_row, said):
    rows = rows_of(lambda k: f";{of_row(k)}").replace("0.", "0,")
    with pytest.raises(DataError, match=said):
        read_table(f"Nr;X [mm];Y [mm];{heading}\n{rows}".encode())


@pytest.mark.parametrize(
    "heads",
    ["Soll X [mm];Soll Y [mm]", "Std X [mm];Std Y [mm]", "Offset X [mm];Offset Y [mm]",
     "Tol X [mm];Tol Y [mm]", "Max X [mm];Max Y [mm]", "Motor X [mm];Motor Y [mm]",
     "Setpoint X [mm];Setpoint Y [mm]", "Uhr X [mm];Sonde Y [mm]", "Uhr X [mm];Uhr X [mm]",
     "Temp X;Temp Y", "Counts X;Counts Y"],
)  # fmt: skip
def test_a_word_of_no_readings_stands_with_no_axis(heads):
    with pytest.raises(DataError, match="no header that names an axis"):
        read_table(f"# unit: mm\nNr;{heads}\n{rows_of(lambda _: '')}".encode())


@pytest.mark.parametrize(
    ("heading", "cell"),
    [("Werker", lambda _: ";Meier"), ("Blick", lambda k: (";ok", ";-", ";")[k % 3]),
     ("Remarque", lambda k: ";" if k > 3 else ""), ("", lambda k: (";ok", ";-", ";")[k % 3])],
)  # fmt: skip
def test_a_column_that_remarks_nothing_is_no_fault(heading, cell):
    run = read_table(f"Nr;X [mm];Y [mm];{heading}\n{rows_of(cell)}".encode())
    assert len(run) == 31
    with pytest.raises(DataError, match="fields, the header has"):
        read_table(f"Nr;X [mm];Y [mm];{heading}\n{rows_of(cell)}32;0.5\n".encode())


def test_a_number_sign_over_the_count_shifts_no_column():
    """``# X Y`` over two columns is how numpy writes it; over three it is the first one's name."""
    head, rows = "#;Zeit [s];X [mm];Bemerkung\n", [f"{k};{12.5 * k};0.5{k}" for k in range(10, 41)]
    run = read_table(
        (head + "".join(f"{row};{'ok' * (k == 9)}\n" for k, row in enumerate(rows))).encode()
    )
    assert run.axes["X"].readings[:2].tolist() == [0.510, 0.511]
    assert run.covariates["time_s"][0] == 125.0


@pytest.mark.parametrize(
    "line",
    ["Werte in Hundertstel", "Einheit 1/100", "Anzeige in 1/100", "readings in hundredths",
     "lecture en centièmes", "letture in centesimi", "Werte in Teilstrichen",
     "Values in divisions", "values in counts"],
)  # fmt: skip
def test_a_unit_in_words_is_held_against_the_option(line):
    table = f"{line}\nNr;X;Y\n{rows_of(lambda _: '')}".encode()
    with pytest.raises(DataError, match="which of them is it"):
        read_table(table, unit="mm")
    assert read_table(table, unit="0.01 mm").axes["X"].readings[0] == pytest.approx(0.0051)
    with pytest.raises(DataError, match="which of them is it"):
        read_table(f"# unit: mm\n{table.decode()}".encode())


@pytest.mark.parametrize(
    ("line", "heading"),
    [("Abweichungen in µm", "X [mm]"), ("Toutes les cotes en centièmes", "X [mm]"),
     ("all dims in mil", "X (mm)"), ("Werte in 1/1000", "X_mm"), ("deviations in mm", "X [um]"),
     ("Ablesung in Strich (0,01 mm)", "X [mm]")],
)  # fmt: skip
def test_a_unit_in_words_is_held_against_the_heading(line, heading):
    table = f"{line}\nNr;{heading};Z [mm]\n{rows_of(lambda _: '')}".encode()
    with pytest.raises(DataError, match="which of them is it"):
        read_table(table.replace(b"Z [mm]", heading.replace("X", "Z").encode()))
    alike = "Angaben in mm\nVorschub 250 mm/s\nWeg des Roboters in m\nReport in English"
    assert len(read_table(f"{alike}\nNr;X [mm];Y [mm]\n{rows_of(lambda _: '')}".encode())) == 31


@pytest.mark.parametrize(
    "line",
    ["[1/100 mm]", "x 0.01 mm", "1 Strich = 0,01 mm", "Alle Werte mal 0,01", "durch 10 teilen",
     "Messuhr zeigt 2 % zu viel", "X um 0,05 zu groß", "subtract 0.05 from X",
     "even cycles from the other side", "abwechselnd von +X und -X",
     "the first cycle was already taken out", "erster Zyklus bereits entfernt",
     "Messunsicherheit 3 µm (k=2)"],
)  # fmt: skip
def test_a_sentence_that_would_change_readings_is_refused(line):
    with pytest.raises(DataError, match="line 1"):
        read_table(f"{line}\nNr;X [mm];Y [mm]\n{rows_of(lambda _: '')}".encode())


@pytest.mark.parametrize(
    "line",
    ["Temperature was 2 K too high", "Raumtemperatur 2 Grad zu hoch", "Kaffee zu heiß",
     "measured in 10 minutes", "Decimal separator .", "Robot (type: X)"],
)  # fmt: skip
def test_a_sentence_of_something_else_is_quoted(line):
    assert len(read_table(f"{line}\nNr;X [mm];Y [mm]\n{rows_of(lambda _: '')}".encode())) == 31


@pytest.mark.parametrize(
    ("line", "is_remark"),
    [("Zyklus 7 wiederholt", True), ("cycle 7 not counted", True), ("Page 1 of 2", False),
     ("geprüft am 01.03.2026", False), ("Formblatt FB-17 Rev. 3", False), ("Seite 2", False)],
)  # fmt: skip
def test_a_sentence_below_numbered_cycles_may_hold_numbers(line, is_remark):
    run = read_table(f"Zyklus;X [mm];Y [mm]\n{rows_of(lambda _: '')}{line}\n".encode())
    assert len(run) == 31
    assert any(line in note for note in run.origin.notes)
    assert bool(run.origin.remarks) == is_remark
