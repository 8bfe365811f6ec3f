"""Where a reading of a table turns: each bound from both sides, by what `read_table` gives."""

from pathlib import Path

import numpy as np
import openpyxl
import pytest

from scara_iso import analyze, gauge_study, push
from scara_iso.base.errors import DataError, ScaraIsoError
from scara_iso.run import Axis, Run
from scara_iso.tables import read_table, write_table
from scara_iso.tables.vocabulary.names import read_unit

MINUS = "\u2212"
READINGS = np.random.default_rng(3).integers(100, 900, 31).tolist()


def table(columns, head="# unit: mm\n# resolution: 0.001\n"):
    """Return a table of columns by name."""
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(columns), *(",".join(map(str, row)) for row in rows)]
    return (head + "\n".join(lines) + "\n").encode()


def x(count):
    return [f"0.{n}" for n in READINGS[:count]]


@pytest.mark.parametrize("last", [2**53 - 1, 2**53])
def test_a_cycle_number_is_told_from_its_neighbours_or_refused(last):
    data = table({"cycle": [last - 1, last], "X": x(2)})
    if last < 2**53:
        assert read_table(data).cycle.tolist() == [last - 1, last]
    else:
        with pytest.raises(DataError, match=f"line 5, column 1: '{last}' is not a cycle number"):
            read_table(data)


@pytest.mark.parametrize(("each", "is_pose"), [(1, False), (2, True), (3, True)])
def test_places_that_hardly_come_again_are_no_poses(each, is_pose):
    places = np.repeat(np.arange(1, 13), each)[:12].tolist()
    run = read_table(table({"cycle": range(1, 13), "X": x(12), "position": places}))
    assert (run.pose is not None) is is_pose
    assert ("position" in run.covariates) is not is_pose


@pytest.mark.parametrize(
    ("readings", "said"),
    [(["0.1", "20.1"], False), (["0.1", "20.2"], True), (["1", "1"], False), (["1", "2"], True)],
)
def test_metres_of_no_robot_are_asked(readings, said):
    data = table({"cycle": [1, 2], "X": readings}, "# unit: m\n")
    if said:
        with pytest.raises(DataError, match="was its unit"):
            read_table(data)
    else:
        assert read_table(data).axes["X"].readings[0] == pytest.approx(1000 * float(readings[0]))


@pytest.mark.parametrize(("rows", "start", "said"), [(9, 1, False), (10, 1, True), (12, 0, True),
                                                     (12, 2, False)])  # fmt: skip
def test_an_axis_that_counts_rows_is_asked(rows, start, said):
    data = table({"X": x(rows), "Y": range(start, start + rows)})
    if said:
        with pytest.raises(DataError, match="Y counts the rows"):
            read_table(data)
    else:
        assert read_table(data).axes["Y"].readings[-1] == start + rows - 1


@pytest.mark.parametrize(
    ("clocks", "seconds"),
    [
        (["08:00:00", "08:00:01.5", "08:02:00"], [0, 1.5, 120]),
        (["23:59:58", "23:59:59", "00:00:01"], [0, 1, 3]),
        (["11:59:59 am", "12:00:00 pm", "1:00:00 PM"], [0, 1, 3601]),
        (["12:00:01 am", "12:00:02 am", "1:00:00 am"], [0, 1, 3599]),
        (["08:00:00", "08:00:00", "08:00:00"], None),
        (["23:59:58", "00:00:01", "23:59:58"], [0, 3, 86400]),
        (["08:00:01", "08:00:00", "08:00:02"], None),
        (["08:00:00", "08:00:01", "24:00:00"], None),
        (["08:00:00", "08:00:60", "08:01:01"], None),
    ],
)
def test_a_clock_tells_the_seconds_where_it_goes_on(clocks, seconds):
    run = read_table(table({"cycle": [1, 2, 3], "X": x(3), "time": clocks}))
    if seconds is None:
        assert "time_s" not in run.covariates
    else:
        assert run.covariates["time_s"] == pytest.approx(seconds)


@pytest.mark.parametrize(("name", "said"), [("command_X [um]", None), ("command_X", None),
                                            ("command_X [deg]", "not a unit of X"),
                                            ("command_X [furlong]", "furlong")])  # fmt: skip
def test_a_command_column_is_in_a_unit_of_its_axis(name, said):
    data = table({"pose": ["P1", "P1", "P2", "P2"], "cycle": [1, 2, 1, 2], "X": x(4),
                  name: [1.5, 1.5, 2.5, 2.5]})  # fmt: skip
    if said:
        with pytest.raises(DataError, match=said):
            read_table(data)
    else:
        size = 1e-3 if "um" in name else 1.0
        command = read_table(data).axes["X"].command
        assert command == pytest.approx({"P1": 1.5 * size, "P2": 2.5 * size})


@pytest.mark.parametrize("stated", ["0", "-0.001", "1,000", "1.000,5", "small", "inf", ""])
def test_a_resolution_is_one_number_above_zero(stated):
    with pytest.raises(DataError, match="resolution"):
        read_table(table({"cycle": [1, 2], "X": x(2)}, f"# unit: mm\n# resolution: {stated}\n"))


def test_what_is_no_approach_is_written_as_a_number():
    run = read_table(table({"cycle": [1, 2], "X": x(2), "approach": [1, -1], "side": [-1, 1]}))
    written = write_table(run)
    header, *rows = [line.split(",") for line in written.splitlines()
                     if not line.startswith("#")]  # fmt: skip
    by_name = dict(zip(header, zip(*rows, strict=True), strict=True))
    assert (by_name["approach"], by_name["side"]) == (("+1", "-1"), ("-1.0", "1.0"))


@pytest.mark.parametrize("name", ["time", "timestamp", "date", "Uhrzeit", "force_N", "spindle"])
def test_a_covariate_is_read_back_under_its_name(name):
    values = np.array([1.5, 2.5])
    run = Run(np.array([1, 2]), {"X": Axis("X", np.array([0.1, 0.2]))}, covariates={name: values})
    assert read_table(write_table(run).encode()).covariates[name].tolist() == values.tolist()


@pytest.mark.parametrize("name", ["comment", "remark", "X", "pose", "cycle"])
def test_a_covariate_that_would_be_read_as_something_else_is_not_written(name):
    axes = {"Y": Axis("Y", np.array([0.1, 0.2]))}
    run = Run(np.array([1, 2]), axes, covariates={name: np.array([1.5, 2.5])})
    with pytest.raises(DataError, match="cannot hold columns"):
        write_table(run)


@pytest.mark.parametrize("sign", ["", "+", "-", MINUS])
def test_a_log_that_names_its_numbers_in_any_spelling_of_them(sign):
    rows = [f"Cycle: {k}  X: {sign}0.{100 + k}  Y: {sign}1.{200 + k}\n" for k in range(1, 4)]
    run = read_table("".join(rows).encode(), unit="mm")
    way = -1 if sign in ("-", MINUS) else 1
    assert run.axes["X"].readings == pytest.approx([way * x for x in (0.101, 0.102, 0.103)])
    assert run.axes["Y"].readings == pytest.approx([way * y for y in (1.201, 1.202, 1.203)])


@pytest.mark.parametrize("between", ["", "\n"], ids=["right above", "apart"])
def test_a_statement_above_a_log_is_read(between):
    log = f"# resolution: 0.01\n{between}Cycle: 1  X: 0.11\nCycle: 2  X: 0.12\n".encode()
    assert read_table(log, unit="mm").axes["X"].resolution == 0.01


@pytest.mark.parametrize(
    ("units", "given", "found"),
    [
        (["# unit: um"], 2, {"X": 0.002}),
        (["# unit: mm"], 0.002, {"X": 0.002}),
        (["# unit_X: um", "# unit_Y: um"], 2, {"X": 0.002, "Y": 0.002}),
        (["# unit_X: um", "# unit: mm"], 0.002, {"X": 0.002, "Y": 0.002}),
    ],
)
def test_a_resolution_that_is_given_is_in_the_unit_stated(units, given, found):
    data = table({"cycle": [1, 2], **dict.fromkeys(found, x(2))}, "\n".join(units) + "\n")
    run = read_table(data, resolution=given)
    assert {n: axis.resolution for n, axis in run.axes.items()} == pytest.approx(found)


def test_a_pose_column_stands_before_other_names_of_places():
    run = read_table(table({"pose": ["P1", "P1", "P2", "P2"], "cycle": [1, 2, 1, 2], "X": x(4),
                            "station": [7, 8, 9, 10]}))  # fmt: skip
    assert run.pose.tolist() == ["P1", "P1", "P2", "P2"]
    assert run.covariates["station"].tolist() == [7, 8, 9, 10]


def test_every_refusal_says_what_to_do(tmp_path):
    """Of one file and of several, of none and of a workbook without a table."""
    book = openpyxl.Workbook()
    book.active.append(["nothing", "here"])
    file = tmp_path / "empty.xlsx"
    book.save(file)
    for source in (b"", b"words\n", b"cycle,X\n1,0.1\n", b"cycle,X\n", file, tmp_path / "none.csv"):
        with pytest.raises(ScaraIsoError) as caught:
            read_table(source)
        assert caught.value.remedy or all(f.message for f in caught.value.faults)
        assert caught.value.remedy
    with pytest.raises(ScaraIsoError) as caught:
        analyze([tmp_path / "none.csv", tmp_path / "no.csv"])
    assert caught.value.remedy


@pytest.mark.parametrize("mark", [",", ";", "\t", "   "])
def test_an_empty_cell_in_quotes_is_an_empty_cell(mark):
    rows = [["cycle", "X", ""], *([str(k), f"0.{100 + k}", ""] for k in range(1, 40))]
    text = "\n".join(mark.join(f'"{cell}"' for cell in row) for row in rows) + "\n"
    run = read_table(text.encode(), unit="mm")
    assert (len(run), list(run.axes), list(run.covariates)) == (39, ["X"], [])
    assert run.axes["X"].readings[-1] == 0.139


PUSHED = (Path(__file__).parents[2] / "examples" / "push.csv").read_text("utf-8").splitlines()


@pytest.mark.parametrize(
    ("above", "between"),
    [
        ([], ["# the first loop is a rehearsal"]),
        ([], ["# 2 loops, 5 N a step", "# and more"]),
        (["Operator,Anna", "Date,today"], []),
        (["Operator,Anna", "# 7 of 9"], ["# 1,2"]),
        (["Serial number,4711"], []),
    ],
)
def test_a_form_around_the_columns_changes_no_number(above, between):
    k = next(k for k, line in enumerate(PUSHED) if line.startswith("force"))
    lines = [*PUSHED[:k], *above, PUSHED[k], *between, *PUSHED[k + 1 :], ""]
    plain, found = (push("\n".join(text).encode()) for text in (PUSHED, lines))
    assert found.loop.force.tolist() == plain.loop.force.tolist()
    assert found.loop.reading.tolist() == plain.loop.reading.tolist()


def test_a_column_that_is_there_twice_is_refused_with_what_to_do():
    text = "\n".join(f"{line},{line}" if not line.startswith("#") else line for line in PUSHED)
    with pytest.raises(DataError, match="there twice") as caught:
        push(text.encode())
    assert caught.value.remedy
    assert [fault.line for fault in caught.value.faults] == [5, 5]


@pytest.mark.parametrize("size", ["0", "-0.001", "1,000", "0.001 deg", "small"])
@pytest.mark.parametrize("key", ["resolution", "indicator_uncertainty"])
def test_a_size_of_a_loop_is_one_length_above_zero(key, size):
    lines = [f"# {key}: {size}" if line.startswith(f"# {key}") else line for line in PUSHED]
    with pytest.raises(DataError, match=key):
        push("\n".join(lines).encode())


def test_a_run_says_what_each_field_of_its_table_was():
    run = read_table(table({"No.": [1, 2], "x [um]": x(2), "Temp (C)": [20, 21], "note": ["a", "b"],
                            "command_X [um]": [0, 0]}, "# resolution: 0.001\n"))  # fmt: skip
    assert [(f.header, f.kind, f.name, f.unit) for f in run.origin.fields] == [
        ("No.", "cycle", "", ""), ("x [um]", "axis", "X", "um"),
        ("Temp (C)", "covariate", "temperature_C", ""), ("note", "comment", "", ""),
        ("command_X [um]", "command coordinate", "X", "um"),
    ]  # fmt: skip


def test_decimal_commas_of_a_loop_are_the_same_numbers():
    text = "\n".join(PUSHED)
    commas = text.replace(",", ";").replace(".", ",").replace("0,001", "0.001")
    assert push(commas.encode()).loop.reading.tolist() == push(text.encode()).loop.reading.tolist()
    with pytest.raises(DataError, match="commas and points"):
        push(commas.replace("0,3", "0.3").encode())


@pytest.mark.parametrize(("blanks", "is_unit"), [(38, True), (39, False)])
def test_a_unit_of_more_than_forty_characters_is_none(blanks, is_unit):
    assert (read_unit("mm" + " " * blanks) is not None) is is_unit


@pytest.mark.parametrize(
    ("first", "ninth", "place", "said"),
    [
        ("X [mm]", "0.509 um", (10, 2), "X: unit mm against um"),
        ("X", "0.509 um", (2, 2), "X: a unit behind some values only"),
    ],
)
def test_another_unit_in_one_cell_is_a_fault_of_that_cell(first, ninth, place, said):
    rows = [f"{k};{ninth if k == 9 else f'0.50{k}'}" for k in range(1, 32)]
    with pytest.raises(DataError) as caught:
        read_table("\n".join([f"cycle;{first}", *rows]).encode())
    (fault,) = caught.value.faults
    assert (fault.line, fault.column) == place
    assert said in str(fault)


def test_a_number_with_the_other_decimal_mark_is_to_be_written_with_the_one_asked_for():
    rows = [f"{k};{'0.110' if k == 5 else f'0,5{k:02}'}" for k in range(1, 32)]
    with pytest.raises(DataError, match="1 fault") as caught:
        read_table("\n".join(["cycle;X [mm]", *rows]).encode(), decimal=",")
    assert str(caught.value.faults[0]).endswith("'0.110' is not a number with a decimal comma")
    assert caught.value.remedy == "write it with a decimal comma, as the others"


def test_a_unit_that_is_none_is_shown_in_its_field():
    with pytest.raises(DataError) as caught:
        read_table(table({"cycle": [1, 2], "temperature_C": [20, 21], "X [furlong]": x(2)}))
    assert [(fault.line, fault.column) for fault in caught.value.faults] == [(3, 3)]


def test_points_that_group_thousands_do_so_in_every_row():
    rows = 40_000
    data = table({"cycle": range(1, rows + 1), "X": ["1.234"] * rows})
    assert set(read_table(data, decimal=",").axes["X"].readings.tolist()) == {1234.0}
    assert set(read_table(data, decimal=".").axes["X"].readings.tolist()) == {1.234}


def test_columns_of_parts_are_joined(tmp_path):
    for k in (1, 2):
        data = table({"cycle": range(1, 32), "X": x(31), "temperature_C": [20 + k] * 31})
        (tmp_path / f"P{k}.csv").write_bytes(data)
    run = analyze([tmp_path / "P1.csv", tmp_path / "P2.csv"]).run
    assert run.covariates["temperature_C"].tolist() == [21.0] * 31 + [22.0] * 31


@pytest.mark.parametrize("between", ["", "Operator;Anna\n", "\n"])
def test_a_title_names_the_pose_of_the_block_below_it(between):
    blocks = [f"P{k}\n{between}cycle;X\n1;0.10{k}\n2;0.11{k}\n" for k in (1, 2)]
    run = read_table("\n".join(blocks).encode(), unit="mm")
    assert run.pose.tolist() == ["P1", "P1", "P2", "P2"]
    assert run.axes["X"].readings.tolist() == [0.101, 0.111, 0.102, 0.112]


@pytest.mark.parametrize("heading", ["reading [mm]", "reading_mm", "reading (mm)"])
def test_a_heading_may_state_the_unit_of_a_loop(heading):
    lines = [line for line in PUSHED if not line.startswith("# unit")]
    text = "\n".join(lines).replace("force_N,reading", f"force_N,{heading}")
    same = push(text.encode()).loop.reading
    assert same.tolist() == push("\n".join(PUSHED).encode()).loop.reading.tolist()
    micro = push(text.replace("mm", "um").encode()).loop.reading
    assert micro * 1000 == pytest.approx(same)


@pytest.mark.parametrize(("named", "asked"), [(14, True), (15, False)])
def test_words_among_numbers_are_asked_about_where_most_rows_have_a_number(named, asked):
    names = ["abcdefghijklmno"[k] if k < named else k for k in range(30)]
    data = table({"cycle": names, "X": [f"{5 + 0.001 * (k % 4):.3f}" for k in range(30)]})
    if asked:
        with pytest.raises(DataError, match="a summary"):
            gauge_study(data, tolerance=0.04)
    else:
        assert gauge_study(data, tolerance=0.04).axes["X"].figures.n == 30


@pytest.mark.parametrize("heading", ["correction", "drift correction"])
def test_a_correction_beside_the_readings_is_asked_about_where_it_changes(heading):
    columns = {"cycle": range(1, 31), "X": x(30)}
    data = table({**columns, heading: [k % 3 / 1000 for k in range(30)]})
    with pytest.raises(DataError, match="speaks of a zero, which changes readings"):
        read_table(data)
    run = read_table(table({**columns, heading: [0.002] * 30}))
    assert run.axes["X"].readings[0] == float(x(1)[0])


@pytest.mark.parametrize(("readings", "advised"), [(11, False), (12, True)])
def test_a_long_row_of_readings_is_a_table_to_be_turned(readings, advised):
    data = f"# unit: mm\nX,{','.join(x(readings))}\nY,{','.join(x(readings))}\n"
    with pytest.raises(DataError) as caught:
        read_table(data.encode())
    assert ("turn the table" in caught.value.remedy) is advised


def test_what_names_the_poses_of_a_part_is_said(tmp_path):
    for name, poses in (("one", ["P1"]), ("two", ["P2", "P3"])):
        rows = {"cycle": [], "pose": [], "X": []}
        for k, reading in enumerate(x(31)):
            for p, pose in enumerate(poses):
                rows["cycle"].append(k + 1)
                rows["pose"].append(pose)
                rows["X"].append(f"{reading}{p + len(poses)}")
        (tmp_path / f"{name}.csv").write_bytes(table(rows))
    notes = analyze([tmp_path / "one.csv", tmp_path / "two.csv"]).run.origin.notes
    said = " ".join(notes)
    assert "pose P1 from the column of" in said
    assert "poses P2, P3 from the column of" in said
