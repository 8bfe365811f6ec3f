"""What the shape of a table tells, in whatever language its headings are."""

import io
import re

import numpy as np
import openpyxl
import pytest

from scara_iso.base.errors import DataError
from scara_iso.iso9283 import analyze, moment_of_test
from scara_iso.run.columns import pose_column
from scara_iso.tables import read_table

RNG = np.random.default_rng(9283)
X, Y = (np.round(at + 0.005 * RNG.standard_normal(31), 3) for at in (0.812, 0.353))


def rows(*columns, delimiter=","):
    return "".join(delimiter.join(map(str, row)) + "\n" for row in zip(*columns, strict=True))


def table(head, *columns, above=""):
    return f"{above}{head}\n{rows(*columns)}".encode()


def refused(data, **options):
    with pytest.raises(DataError) as error:
        read_table(data, **options)
    return error.value


@pytest.mark.parametrize(
    "heading", ["P{}{}", "P{}/{}", "{1}@P{0}", "{1}P{0}", "位置{} {}", "姿勢{}{}", "{1} (P{0})"]
)
def test_a_pose_and_an_axis_need_nothing_between_them(heading):
    names = [f"{heading.format(pose, axis)} [mm]" for pose in (1, 2) for axis in "XY"]
    run = read_table(table(",".join(["cycle", *names]), range(1, 32), X, Y, Y, X))
    assert [str(label) for label, _ in run.rows_by_pose()] == ["P1", "P2"]
    assert run.axes["X"].readings.tolist() == [*X, *Y]
    assert run.axes["Y"].readings.tolist() == [*Y, *X]


def test_a_unit_behind_the_pose_is_that_of_its_axis():
    run = read_table(table("cycle,X_P1_um,X_P2_um", range(1, 32), 1000 * X, 1000 * Y))
    assert run.axes["X"].readings == pytest.approx([*X, *Y], abs=1e-12)


def test_axes_with_numbers_of_no_pose_are_runs_side_by_side():
    error = refused(table("cycle,1X [mm],1Y [mm],2X [mm],2Y [mm]", range(1, 32), X, Y, Y, X))
    assert "head them P1_X" in error.remedy


def test_columns_of_a_frame_that_name_a_pose_each_are_refused():
    for name in ("P2X", "X@P2", "XP2"):
        with pytest.raises(DataError):
            pose_column(["cycle", name])


def test_advice_names_no_axis_that_the_heading_does_not():
    data = table("count,Fall X,Fall Y,other", range(1, 32), X, Y, X + Y)
    columns = re.findall("`columns=([^`]+)`", refused(data).remedy)
    assert columns == ["cycle,X,Y,-"]
    assert list(read_table(data, unit="mm", columns=columns[0]).axes) == ["X", "Y"]


def test_a_column_of_another_axis_is_not_read_as_the_stated_one():
    data = table("cycle,P1X [mm],P1Y [mm],P2X [mm]", range(1, 32), X, Y, X + 1)
    error = refused(data, columns="cycle,X,Y,Z")
    assert [(fault.line, fault.column) for fault in error.faults] == [(1, 4)]


LONG = "Zyklus;Achse;Messwert\n" + "".join(
    f"{n};{axis};{value:.3f}\n".replace(".", ",")
    for axis, values in (("X", X), ("Y", Y))
    for n, value in enumerate(values, 1)
)
BOTH = "Nr;X/Y [mm]\n" + "".join(
    f"{n};{x:.3f} / {y:.3f}\n".replace(".", ",")
    for n, (x, y) in enumerate(zip(X, Y, strict=True), 1)
)


@pytest.mark.parametrize("data", [LONG, BOTH])
@pytest.mark.parametrize("columns", ["-,X", "-,X,-", "-,-,X", "cycle,X", "X,-,-", "-,X,-,-"])
def test_stated_columns_part_no_row_at_its_decimal_comma(data, columns):
    refused(data.encode(), unit="mm", columns=columns)


def test_a_row_for_each_axis_and_two_numbers_in_a_cell_are_to_be_columns():
    assert "names the axis of each row" in refused(LONG.encode()).remedy
    assert "names the axis of each row" in refused(LONG.replace(",", ".").encode()).remedy
    assert "'X/Y [mm]' heads two axes" in refused(BOTH.encode()).remedy
    error = refused(LONG.replace("X", "Z").encode(), unit="mm", columns="-,-,Y")
    assert "names the axis of each row" in str(error)


def by_axis(heading="value [mm]", *, poses=("",), in_turn=True):
    """Return a table with a row for each axis of a visit, its axes in turn or below each other."""
    visits = [(pose, k) for pose in poses for k in range(31)]
    axes = (("X", X), ("Y", Y))
    pairs = (
        [(v, a) for v in visits for a in axes]
        if in_turn
        else [(v, a) for a in axes for v in visits]
    )
    pose = "pose," if poses != ("",) else ""
    lines = [f"{p},{k + 1},{a},{x[k] + (p == 'P2'):.3f}".lstrip(",") for (p, k), (a, x) in pairs]
    return "\n".join([f"{pose}cycle,axis,{heading}", *lines, ""])


@pytest.mark.parametrize("in_turn", [True, False])
@pytest.mark.parametrize("poses", [("",), ("P1", "P2")])
def test_a_row_for_each_axis_of_a_visit_is_read_as_columns(in_turn, poses):
    text = by_axis(poses=poses, in_turn=in_turn)
    cells = [line.split(",") for line in text.splitlines()]
    numbers = [[float(x) if x[0].isdigit() else x for x in row] for row in cells]
    for run in map(read_table, (text.encode(), sheet(*numbers))):
        assert run.cycle.tolist() == [*range(1, 32)] * len(poses)
        for name, x in (("X", X), ("Y", Y)):
            of_poses = np.concatenate([x + k for k in range(len(poses))])
            assert run.axes[name].readings == pytest.approx(of_poses, abs=1e-12)


def test_statements_of_one_axis_are_used_for_that_one():
    head = "# resolution_X: 0.001\n# resolution_Y: 0.002\n# resolution_Z: 0.001\n"
    run = read_table(f"{head}{by_axis()}".encode())
    assert [axis.resolution for axis in run.axes.values()] == [0.001, 0.002]
    assert "axes_recorded" not in run.metadata
    unused = [note for note in run.origin.notes if "there is no axis" in note]
    assert all(note.endswith("no axis Z") for note in unused)
    assert unused


def test_a_visit_that_is_there_twice_breaks_the_cycle_rule_at_its_line():
    run = read_table(f"{by_axis()}7,X,0.810\n7,Y,0.350\n".encode())
    with pytest.raises(DataError) as error:
        analyze(run)
    assert {fault.line for fault in error.value.faults} == {64}


def test_a_row_for_each_axis_wants_a_unit_as_any_table():
    assert read_table(LONG.encode(), unit="mm").axes["Y"].readings.tolist() == Y.tolist()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (f"7,Y,{Y[6]:.3f}\n", "", "not at the same cycles: cycle 7"),
        ("\n8,X", "\n7,X,0.810\n8,X", "not at the same cycles: cycle 7"),
        (f"7,Y,{Y[6]:.3f}", "7,Y,ERR", "line 15, column 3: 'ERR' is not a number"),
        (f"7,X,{X[6]:.3f}", "7,X,", "line 14, column 3: empty cell"),
    ],
)
def test_an_axis_that_a_visit_lacks_or_has_twice_is_named_where_it_is(old, new, said):
    data = by_axis()
    assert old in data
    assert said in str(refused(data.replace(old, new).encode()))


@pytest.mark.parametrize("heading", ["std dev [mm]", "value x100 [mm]", "value (mean of 3)"])
def test_rows_of_an_axis_that_hold_no_plain_readings_are_refused(heading):
    refused(by_axis(heading).encode(), unit="mm")


def test_a_number_of_an_axis_that_was_cut_is_asked_about():
    data = f"# resolution: 0.001\n{by_axis()}"
    assert "is the file cut" in str(refused(data[:-2].encode()))


def follow(data):
    """Return the run after the advice of each refusal was done, and the columns that it named."""
    options = {}
    for _ in range(3):
        try:
            return read_table(data, **options), options.get("columns")
        except DataError as error:
            advised = re.findall("`(unit|columns)=([^`]+)`", error.remedy)
            options |= {key: value for key, value in reversed(advised) if key not in options}
    raise AssertionError(options)


@pytest.mark.parametrize("delimiter", [",", ";", "\t", ", "])
@pytest.mark.parametrize("remark", ["moved; again", "moved | again", "a; b; c"])
def test_a_mark_in_every_remark_parts_no_cells(delimiter, remark):
    run, columns = follow(
        rows(range(1, 32), X, Y, [f'"{remark}"'] * 31, delimiter=delimiter).encode()
    )
    assert columns == "cycle,X,Y,-"
    assert run.axes["Y"].readings.tolist() == Y.tolist()
    plain = rows(range(1, 32), X, Y, [remark] * 31, delimiter=delimiter).encode()
    if delimiter.strip() not in (";", ""):
        assert follow(plain)[0].axes["Y"].readings.tolist() == Y.tolist()


@pytest.mark.parametrize("delimiter", [" ", "  ", "\t", ";"])
@pytest.mark.parametrize("before", ["ok", "10:00:07", "A"])
def test_the_advice_parts_rows_as_they_are_then_read(delimiter, before):
    commas = [[f"{x:.3f}".replace(".", ",") for x in values] for values in (X, Y)]
    run, columns = follow(rows([before] * 31, *commas, delimiter=delimiter).encode())
    assert columns == "-,X,Y"
    assert run.axes["X"].readings.tolist() == X.tolist()
    run, columns = follow(rows([before] * 31, commas[0], delimiter=delimiter).encode())
    assert (columns, run.axes["X"].readings.tolist()) == ("-,X", X.tolist())


def test_a_comma_that_is_a_decimal_one_or_parts_cells_is_asked_about():
    data = rows((1000 * X).round().astype(int), (1000 * Y).round().astype(int)).encode()
    assert "`columns=X` or `columns=X,Y`" in refused(data).remedy
    assert read_table(data, unit="um", columns="X,Y").axes["Y"].readings == pytest.approx(Y)


INSTANTS = [f"15.02.2026 10:{k:02}" for k in range(31)]


@pytest.mark.parametrize("heading", ["Data/Ora", "Datum/Tid", "日付/時刻", "Kiedy", "timestamp"])
@pytest.mark.parametrize(
    "day", ["15.02.2026", "15/02/2026", "02/15/2026", "2026/2/15", "2026-02-15", "15-Feb-2026"]
)
def test_a_column_of_instants_is_the_time_whatever_its_heading(heading, day):
    stamps = [stamp.replace("15.02.2026", day) for stamp in INSTANTS]
    run = read_table(table(f"cycle,{heading},X [mm]", range(1, 32), stamps, X))
    assert run.covariates["time_s"].tolist() == [60.0 * k for k in range(31)]
    assert run.metadata["timestamp_start"] == "2026-02-15T10:00:00"


@pytest.mark.parametrize(
    "cell", ["2026/2/15", "15.02.2026", "05/06/2026", "05/06/2026 10:00", "10:00", "9:30 AM"]
)
def test_dates_and_times_that_tell_no_instant_are_not_used_and_said(cell):
    run = read_table(table("cycle,Kiedy,X [mm]", range(1, 32), [cell] * 31, X))
    assert not run.covariates
    assert any("'Kiedy' not used" in note for note in run.origin.notes)


def test_a_day_that_is_clear_in_some_rows_only_is_not_used():
    stamps = ["05/31/2026 23:59"] * 15 + ["06/01/2026 00:01"] * 16
    run = read_table(table("cycle,Date,X [mm]", range(1, 32), stamps, X))
    assert not run.covariates
    assert any("'Date' not used" in note for note in run.origin.notes)


def test_a_clock_of_any_name_is_the_time_unless_its_date_changes_elsewhere():
    clock = [f"10:00:{k:02}" for k in range(31)]
    run = read_table(table("cycle,時刻,X [mm]", range(1, 32), clock, X))
    assert run.covariates["time_s"].tolist() == [*range(31)]
    days = ["2026/2/15"] * 20 + ["2026/2/16"] * 11
    run = read_table(table("cycle,日付,時刻,X [mm]", range(1, 32), days, clock, X))
    assert "time_s" not in run.covariates


@pytest.mark.parametrize(
    ("key", "text"),
    [
        ("Data", "2026-02-15"),
        ("Data", "15/02/2026"),
        ("日期", "2026-02-15"),
        ("測定日", "2026/2/15"),
        ("Prüfdatum", "15.02.26"),
        ("Date", "02/15/2026"),
        ("Date", "15-Feb-2026"),
        ("Datum", "15. Feb 2026"),
    ],
)
def test_the_date_of_a_test_is_known_by_its_key_in_several_languages(key, text):
    run = read_table(table("cycle,X [mm]", range(1, 32), X, above=f"{key}: {text}\n"))
    assert moment_of_test(run).isoformat() == "2026-02-15T00:00:00"


@pytest.mark.parametrize("text", ["05/02/2026", "15/02/26", "31.02.2026"])
def test_a_date_that_may_be_two_is_none(text):
    run = read_table(table("cycle,X [mm]", range(1, 32), X, above=f"Date: {text}\n"))
    assert moment_of_test(run) is None


def test_data_of_no_date_are_no_date_of_the_test():
    run = read_table(table("cycle,X [mm]", range(1, 32), X, above="Data: raw 0.1\n"))
    assert run.metadata == {"data": "raw 0.1"}


def test_texts_of_a_workbook_with_three_decimals_in_micrometres_are_asked_about():
    data = sheet(["cycle", "X [µm]"], *([k, f"{1 + x:.3f}"] for k, x in enumerate(X, 1)))
    assert "group thousands" in str(refused(data))
    assert read_table(data, decimal=".").axes["X"].readings[0] == (1 + X[0]) / 1000


FIGURES = {
    "Mittel": np.mean,
    "Mínimo": np.min,
    "最大": np.max,
    "3s": lambda x: 3 * np.std(x, ddof=1),
    "6 s": lambda x: 6 * np.std(x, ddof=1),
}


def with_footer(*names):
    lines = [f"{name},{FIGURES[name](X):.4f},{FIGURES[name](Y):.4f}\n" for name in names]
    return table("cycle,X [mm],Y [mm]", range(1, 32), X, Y) + "".join(lines).encode()


@pytest.mark.parametrize("name", FIGURES)
def test_a_row_of_an_extreme_or_of_several_deviations_is_no_reading(name):
    for data in (with_footer("Mittel", name), with_footer(*FIGURES)):
        run = read_table(data)
        assert len(run) == 31
        assert any(f"footer '{name}" in note for note in run.origin.notes)


@pytest.mark.parametrize("row", ["Mínimo,0.799,0.340\n", "3s,0.8,0.3\n", "31a,0.812,0.353\n"])
def test_a_row_of_a_word_and_no_figure_is_still_refused(row):
    data = table("cycle,X [mm],Y [mm]", range(1, 32), X, Y) + row.encode()
    assert "is not a cycle number" in str(refused(data))


def test_a_declared_condition_of_words_in_every_row_is_one():
    state = ["warm", "cold", "cold"] * 10 + ["warm"]
    data = table("cycle,X [mm],State", range(1, 32), X, state, above="# covariates: State\n")
    assert read_table(data).covariates["State cold"].sum() == 20


@pytest.mark.parametrize("heading", ["Geschwindigkeit [%]", "velocità", "Vel (%)", "speed"])
def test_velocities_that_are_pooled_are_warned_of(heading):
    velocity = [100] * 16 + [50] * 15
    above = f"# covariates: {heading}\n"
    run = read_table(table(f"cycle,X [mm],{heading}", range(1, 32), X, velocity, above=above))
    (found,) = [one for one in analyze(run).findings if one.code == "other-velocity"]
    assert "goes from 50 to 100" in found.message
    assert found.advice == "a table for each"


@pytest.mark.parametrize("heading", ["Tempo [mm/s]", "v (m/s)", "Bahn in mm/s", "set_mm/s"])
def test_a_unit_of_velocity_says_that_a_column_of_settings_is_one(heading):
    found = {}
    for name, values in {
        "two": [100] * 16 + [50] * 15,
        "one": [100] * 31,
        "measured": [100 + k / 10 for k in range(31)],
    }.items():
        run = read_table(table(f"cycle,X [mm],{heading}", range(1, 32), X, values))
        found[name] = [one.code for one in analyze(run).findings].count("other-velocity")
    assert found == {"two": 1, "one": 0, "measured": 0}


def test_velocities_below_each_other_are_said_to_be_a_table_each():
    velocity = [100] * 31 + [50] * 31
    for y in (Y, Y + 1):
        with pytest.raises(DataError) as error:
            analyze(read_table(table("Vel (%),cycle,X [mm]", velocity, range(1, 63), [*Y, *y])))
        assert "a table of its own" in error.value.remedy


def sheet(*rows):
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    book.save(file := io.BytesIO())
    return file.getvalue()


@pytest.mark.parametrize("gap", [1, 2])
def test_what_stands_beside_the_table_of_a_sheet_is_named_by_its_cell(gap):
    lines = [[k, float(x)] for k, x in enumerate(X, 1)]
    lines[4] += [None] * gap + ["Wert ungültig"]
    (fault,) = refused(sheet(["cycle", "X [mm]"], *lines)).faults
    assert (fault.line, fault.column) == (6, 3 + gap)
    lines[4][-1] = 0.5
    assert "semicolons" not in refused(sheet(["cycle", "X [mm]"], *lines)).remedy


@pytest.mark.parametrize("start", [0, 1])
def test_an_unnamed_first_column_that_counts_numbers_the_cycles(start):
    counts = range(start, start + 31)
    for head in (",X [mm],Y [mm]", "X [mm],Y [mm]"):
        run = read_table(table(head, counts, X, Y))
        assert run.cycle.tolist() == [*counts]
        assert run.axes["X"].readings.tolist() == X.tolist()
        assert any("is taken for the cycle" in note for note in run.origin.notes)


def test_an_unnamed_column_that_does_not_count_is_asked_about():
    for counts in ([*range(30, -1, -1)], [*range(5, 36)], [7] * 31):
        assert "in a column without a name" in str(refused(table(",X [mm]", counts, X)))
        refused(table("X [mm]", counts, X))
    refused(table("cycle,X [mm]", range(1, 32), [0] * 31, [round(1000 * x) for x in X]))


@pytest.mark.parametrize("heading", ["Pos", "Punto", "Posizione", "位置", "Pozycja", "姿勢"])
def test_names_of_poses_head_a_column_in_several_languages(heading):
    data = table(f"{heading},cycle,X [mm]", [1] * 31 + [2] * 31, [*range(1, 32)] * 2, [*X, *Y])
    assert [str(label) for label, _ in read_table(data).rows_by_pose()] == ["1", "2"]


@pytest.mark.parametrize("title", ["Pose P{}:", "姿勢{}", "Pose {}:"])
def test_the_name_of_a_pose_above_its_block_may_end_in_a_colon(title):
    blocks = [
        f"{title.format(k)}\n" + table("cycle,X [mm]", range(1, 32), x).decode()
        for k, x in ((1, X), (2, Y))
    ]
    run = read_table("\n".join(blocks).encode())
    assert [str(label) for label, _ in run.rows_by_pose()] == ["P1", "P2"]


def test_a_pose_that_a_few_rows_mention_is_a_remark():
    mentions = [""] * 30 + ["P3"]
    run = read_table(table("cycle,X [mm],Ort", range(1, 32), X, mentions))
    assert run.pose is None


@pytest.mark.parametrize(
    "text",
    ["Sekunden,X [mm]\n" + "".join(f"{k},0,{k % 7 + 10}\n" for k in range(31)),
     "temperature_C,X [mm],Y [mm]\n" + "".join(
         f"{k},20.1,0.5{k % 7},0.8{k % 5}\n" for k in range(1, 32))],
    ids=["a decimal comma that is split", "a field without a name"],
)  # fmt: skip
def test_a_header_one_name_short_is_asked_about(text):
    with pytest.raises(DataError):
        read_table(text.encode())


@pytest.mark.parametrize("heading", ["Duration", "Dauer", "Durée", "Time"])
def test_times_that_may_be_durations_are_the_time_only_where_the_heading_says_so(heading):
    for start in (0, 12, 3600):
        times = [f"{(start + k) // 3600:02}:00:{(start + k) % 60:02}" for k in range(31)]
        run = read_table(table(f"cycle,{heading},X [mm]", range(1, 32), times, X))
        sure = heading == "Time" or start != 12
        assert ("time_s" in run.covariates) is sure
        said = "is the time of each row" if sure else "are these durations?"
        assert any(said in note for note in run.origin.notes)


def test_a_day_between_two_rows_is_no_hour():
    stamps = ["2026-05-12T00:00:00"] * 15 + ["2026-05-14T00:00:00"] * 16
    rows = "".join(f"{k},0.5{k % 7},{stamps[k - 1]},10:{k:02d}:00\n" for k in range(1, 32))
    run = read_table(f"cycle,X [mm],Datum,Zeit\n{rows}".encode())
    seconds = run.covariates.get("time_s", np.array([0.0, 86_400.0]))
    assert np.ptp(seconds) > 80_000


def in_blocks(names, *, cycle=True):
    """Return lines whose pose stands in the first row of its block alone."""
    values = [[*X], [*Y], [*(X + 1)]]
    return [
        [name if k == 0 else None, *([k + 1] if cycle else []), float(x)]
        for name, block in zip(names, values, strict=False)
        for k, x in enumerate(block)
    ]


def of_text(head, lines):
    return table(head, *zip(*[["" if x is None else x for x in row] for row in lines], strict=True))


@pytest.mark.parametrize("names", [["P1", "P2"], ["1", "2"], ["oben", "unten", "links"]])
def test_a_pose_in_the_first_row_of_its_block_is_that_of_all_its_rows(names):
    lines, head = in_blocks(names), ["Pose", "cycle", "X [mm]"]
    for data in (of_text(",".join(head), lines), sheet(head, *lines)):
        run = read_table(data)
        assert [(str(label), len(rows)) for label, rows in run.rows_by_pose()] == [
            (name, 31) for name in names
        ]
        assert any("in the first row of its block" in note for note in run.origin.notes)


@pytest.mark.parametrize("names", [["P1", "P2", "P1"], ["P1", None, "P3"], [None, "P2"]])
def test_a_pose_that_may_be_of_other_rows_is_asked_about(names):
    data = of_text("Pose,cycle,X [mm]", in_blocks(names))
    assert "an empty cell is not a pose" in str(refused(data))
    refused(of_text("Pose,X [mm]", in_blocks(["P1", "P2"], cycle=False)))


def test_a_merged_pose_is_that_of_each_of_its_rows():
    book = openpyxl.Workbook()
    for row in [["Pose", "X [mm]"], *in_blocks(["P1", "P2"], cycle=False)]:
        book.active.append(row)
    book.active.merge_cells("A2:A32")
    book.save(file := io.BytesIO())
    assert {fault.line for fault in refused(file.getvalue()).faults} == {*range(34, 64)}
    book.active.merge_cells("A33:A63")
    book.save(file := io.BytesIO())
    assert [len(rows) for _, rows in read_table(file.getvalue()).rows_by_pose()] == [31, 31]


@pytest.mark.parametrize("heading", ["cycle", "Nr.", "Was"])
@pytest.mark.parametrize("words", ["Zyklus {}", "M{:02}", "{}/31", "第{}回", "{}."])
def test_one_number_in_the_same_words_in_each_row_counts_the_cycles(heading, words):
    cells = [words.format(k) for k in range(1, 32)]
    run = read_table(table(f"{heading},X [mm]", cells, X))
    assert run.cycle.tolist() == [*range(1, 32)]
    cells[6] += "b"
    with pytest.raises(DataError):
        read_table(table(f"{heading},X [mm]", cells, X))


@pytest.mark.parametrize("heading", ["Robot", "Serial no", "Messuhr"])
def test_names_of_robots_or_dials_in_turn_count_no_cycles(heading):
    names = [f"R{k:02}" for k in range(1, 32)]
    assert "a table of its own" in refused(table(f"{heading},X [mm]", names, X)).remedy


@pytest.mark.parametrize("words", ["{} s", "{}.5", "{},5", "{}:00", "P{}"])
def test_sizes_times_and_poses_count_no_cycles(words):
    cells = [words.format(k) for k in range(1, 32)]
    refused(";".join(["cycle", "X [mm]\n"]).encode() + rows(cells, X, delimiter=";").encode())


def on_pages(first, second, head="Cycle X[mm] Y[mm]"):
    lines = rows(*([range(1, 32)] if "Cycle" in head else []), X, Y, delimiter=" ").split("\n")
    return "\n".join([head, *lines[:15], first, *lines[15:-1], second, ""]).encode()


@pytest.mark.parametrize("pages", [("Page 1/2", "Page 2/2"), ("Seite 1 von 2", "Seite 2 von 2")])
def test_lines_that_count_the_pages_between_rows_are_named_and_no_rows(pages):
    run = read_table(on_pages(*pages))
    assert run.axes["X"].readings.tolist() == X.tolist()
    assert [note[:8] for note in run.origin.notes if "not used" in note] == ["line 17:", "line 34:"]


@pytest.mark.parametrize("line", ["Mean 1 2", "32a 0.812 0.353"])
def test_a_line_of_words_with_readings_is_asked_about(line):
    refused(on_pages(line, ""))
    refused(on_pages("Page 1", "Page 2", head="X[mm] Y[mm]"))


@pytest.mark.parametrize("at", [10, 20, 30])
def test_a_mean_amid_rows_without_numbers_is_asked_about(at):
    means = [f"{x[:at].mean():.4f}" for x in (X, Y)]
    columns = [[*x[:at], mean, *x[at:]] for x, mean in zip((X, Y), means, strict=True)]
    data = table("X [mm],Y [mm]", *columns)
    (fault,) = refused(data).faults
    assert fault.line == at + 2
    assert "the mean of those above" in fault.message
    numbered = table("cycle,X [mm],Y [mm]", range(1, 33), *columns)
    assert len(read_table(numbered)) == 32
    # what may be so by chance is a reading
    columns = [[*x[:at], round(x[:at].mean(), 2), *x[at:]] for x in (X, Y)]
    assert len(read_table(table("X [mm],Y [mm]", *columns))) == 32


def test_one_decimal_comma_says_what_commas_are_for_the_poses_of_all_headings():
    rows = "".join(f"{k};0,{k + 100};1,{k + 200}\n" for k in range(1, 32))
    text = f"Zyklus;P1 X [mm];P2 X [mm]\n{rows}"
    assert read_table(text.encode()).axes["X"].readings[[0, -1]].tolist() == [0.101, 1.231]
    with pytest.raises(DataError, match="could have a decimal comma"):
        read_table(text.replace("0,", "2,").encode())
    with pytest.raises(DataError, match="could have a decimal comma"):
        read_table(text.replace("0,120", "0.120").replace("0,", "2,").encode())


def test_a_log_with_the_unit_behind_each_value_states_it():
    lines = [f"Cycle {k}: X=1.{k + 100} mm, Y={k + 300} um" for k in range(1, 32)]
    run = read_table("\n".join(lines).encode())
    assert run.axes["X"].readings[0] == 1.101
    assert run.axes["Y"].readings[0] == pytest.approx(0.301)
