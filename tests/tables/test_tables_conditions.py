"""What a column of time, temperature or signs means in a run, and a size of what no axis is in.

A condition is in seconds, °C or kg there, whatever its unit was.
"""

import re
from datetime import UTC, datetime, timedelta

import numpy as np
import pandas as pd
import pytest

from scara_iso import Run, analyze, read_table
from scara_iso.base.errors import DataError
from scara_iso.base.quantities import Dimension
from scara_iso.run import Axis
from scara_iso.tables import write_table


def table(heading, below="", cell="{}", step=1.0):
    rows = "".join(f"{k},0.1{k:02},{cell.format(round(step * k, 6))}\n" for k in range(1, 32))
    return f"cycle,X,{heading}\n,mm,{below}\n{rows}".encode()


@pytest.mark.parametrize(
    ("heading", "below", "cell", "name", "first", "last"),
    [
        ("time [min]", "", "{}", "time_s", 60, 1860),
        ("Zeit", "min", "{}", "time_s", 60, 1860),
        ("time_min", "", "{}", "time_s", 60, 1860),
        ("Elapsed (ms)", "", "{}", "time_s", 0.001, 0.031),
        ("Zeit in h", "", "{}", "time_s", 3600, 31 * 3600),
        ("t", "Sekunden", "{}", "time_s", 1, 31),
        ("Zeit", "", "{} min", "time_s", 60, 1860),
        ("time_s", "sec", "{}", "time_s", 1, 31),
        ("temperature_F", "", "{}", "temperature_C", -31 / 1.8, -1 / 1.8),
        ("Temperature", "°F", "{}", "temperature_C", -31 / 1.8, -1 / 1.8),
        ("Raumtemperatur", "", "{} °F", "temperature_C", -31 / 1.8, -1 / 1.8),
        ("temperature_base_F", "", "{}", "temperature_base_C", -31 / 1.8, -1 / 1.8),
        ("Temperatur [K]", "", "{}", "temperature_C", 1 - 273.15, 31 - 273.15),
        ("payload", "g", "{}", "payload_kg", 0.001, 0.031),
        ("time_s", "-", "{}", "time_s", 1, 31),
        ("force_N", "N", "{}", "force_N", 1, 31),
        ("Sensor A", "V", "{}", "Sensor A", 1, 31),
    ],
)
def test_a_condition_is_converted_to_the_unit_of_a_run(heading, below, cell, name, first, last):
    run = read_table(table(heading, below, cell))
    assert list(run.covariates) == [name]
    assert run.covariates[name][[0, -1]] == pytest.approx([first, last])
    said = any("is converted to" in note for note in run.origin.notes)
    assert said == (first not in (1, 31))


@pytest.mark.parametrize(
    ("heading", "below", "cell", "said"),
    [
        ("time_s", "min", "{}", "line 1, column 3: 'time_s' is in s, the unit row says min"),
        ("time [min]", "s", "{}", "'time \\[min\\]' is in min, the unit row says s"),
        ("temperature_C", "°F", "{}", "is in C, the unit row says °F"),
        ("force [N]", "kN", "{}", "is in N, the unit row says kN"),
        ("time [min]", "", "{} s", "line 3, column 3: time_s: 's' behind a value"),
        ("Temperature", "°C", "{} °F", "'°F' behind a value"),
    ],
)
def test_two_units_of_one_condition_are_refused(heading, below, cell, said):
    with pytest.raises(DataError) as refused:
        read_table(table(heading, below, cell))
    text = " ".join([str(refused.value), *refused.value.fault_lines()])
    assert re.search(said, text), text


def test_of_two_columns_of_time_the_one_in_seconds_is_the_clock():
    rows = "".join(f"{k},0.1{k:02},{k},{k / 60:.4f}\n" for k in range(1, 32))
    run = read_table(f"cycle,X [mm],time_s,Zeit [min]\n{rows}".encode())
    assert [*run.covariates] == ["time_s", "Zeit [min]"]
    assert read_table(write_table(run).encode()).covariates.keys() == run.covariates.keys()


def test_a_data_frame_is_converted_too():
    frame = pd.DataFrame({"X": np.arange(31) / 1000, "time_min": np.arange(31.0),
                          "temperature_F": np.full(31, 68.0)})  # fmt: skip
    run = Run.from_frame(frame, unit="mm")
    assert run.covariates["time_s"][-1] == 1800
    assert run.covariates["temperature_C"][0] == pytest.approx(20)
    with pytest.raises(DataError, match="'time_min' is time_s too"):
        Run.from_frame(frame.assign(time_s=1.0), unit="mm")


@pytest.mark.parametrize("heading", ["X direction", "X-Richtung [mm]"])
def test_signs_under_a_heading_of_a_direction_are_no_readings(heading):
    def with_cells(cells):
        rows = "".join(f"{k},{cells[k % 2]},0.1{k:02}\n" for k in range(1, 32))
        return f"# unit: mm\ncycle,{heading},Y\n{rows}".encode()

    with pytest.raises(DataError) as refused:
        read_table(with_cells(["+1", "-1"]))
    assert "line 2, column 2" in "".join(refused.value.fault_lines())
    assert "call it approach" in refused.value.remedy
    assert [*read_table(with_cells(["0.9", "-1"])).axes] == ["X", "Y"]


def test_a_direction_of_approach_is_one_by_its_german_name():
    rows = "".join(f"{k},{'+-'[k % 2]}x,0.1{k:02}\n" for k in range(1, 32))
    run = read_table(f"# unit: mm\ncycle,Anfahrrichtung,X\n{rows}".encode())
    assert set(run.direction) == {"+x", "-x"}
    called = f"# unit: mm\ncycle,direction,X\n{rows}".encode()
    with pytest.raises(DataError) as refused:
        read_table(called)
    assert refused.value.remedy == "call the column approach"


@pytest.mark.parametrize(
    ("head", "axis"),
    [
        ("# resolution: 0.01 deg\n# unit: mm", "X"),
        ("# indicator_uncertainty: 0.01 deg\n# unit: mm", "X"),
        ("# resolution: 0.001 mm\n# unit: deg", "theta"),
    ],
)
def test_a_size_in_a_unit_that_no_axis_is_in_is_refused(head, axis):
    rows = "".join(f"{k},0.1{k:02}\n" for k in range(1, 32))
    with pytest.raises(DataError, match="no axis is in such a unit") as refused:
        read_table(f"{head}\ncycle,{axis}\n{rows}".encode())
    assert "line 1" in "".join(refused.value.fault_lines())


def test_a_size_of_the_option_in_a_unit_that_no_axis_is_in_is_refused():
    rows = "".join(f"{k},0.1{k:02}\n" for k in range(1, 32))
    with pytest.raises(DataError) as refused:
        read_table(f"cycle,X [mm]\n{rows}".encode(), unit="deg", resolution=0.01)
    assert "let `unit=` be a unit of the readings" in refused.value.remedy


def test_a_statement_about_an_axis_that_is_not_there_is_said():
    rows = "".join(f"{k},0.1{k:02}\n" for k in range(1, 32))
    head = "# unit: mm\n# resolution_Y: 0.001\n# command_z[P2]: 3\n# resolution_X: 0.001\n"
    notes = read_table(f"{head}cycle,X\n{rows}".encode()).origin.notes
    assert notes == ("resolution_y not used: there is no axis Y",
                     "command_z[p2] not used: there is no axis Z")  # fmt: skip


@pytest.mark.parametrize(
    ("head", "resolution", "notes"),
    [
        ("Robot FUM-1\nResolution 0.01\nUnit mm\n", 0.01, ["line 1: 'Robot FUM-1' not used"]),
        ("# Resolution 0.01\n# unit mm\n", 0.01, []),
        ("Auflösung X 10\nEinheit µm\n", None, ["line 1: 'Auflösung X 10' not used"]),
        ("Auflösung X 10 µm\nEinheit mm\n", 0.01, []),
        ("Unit mm\nPage 1 of 3\n", None, ["line 2: 'Page 1 of 3' not used"]),
        ("Unit mm\nUnit number 7\n", None, ["line 2: 'Unit number 7' not used"]),
    ],
)
def test_lines_of_a_form_without_colons_are_read_where_they_are_sure(head, resolution, notes):
    rows = "".join(f"{k},0.{k:02}\n" for k in range(1, 32))
    run = read_table(f"{head}cycle,X\n{rows}".encode())
    assert run.axes["X"].resolution == resolution
    assert [note for note in run.origin.notes if "not used" in note] == notes


def test_what_decides_about_the_first_cycle_is_read_without_a_colon():
    rows = "".join(f"{k},0.{k:02}\n" for k in range(1, 31))
    run = read_table(f"unit mm\nfirst_cycle_discarded true\ncycle,X\n{rows}".encode())
    assert run.metadata == {"first_cycle_discarded": "true"}


def clocked(cells, heading="Uhrzeit", beside=None):
    pairs = zip(cells, beside or [""] * len(cells), strict=True)
    rows = "".join(f"{k};0,1{k:02};{a};{b}\n" for k, (a, b) in enumerate(pairs, 1))
    return read_table(f"cycle;X [mm];{heading};Datum\n{rows}".encode())


def times(seconds, shown="%H:%M:%S"):
    first = datetime(2026, 3, 1, 23, 50, tzinfo=UTC)
    return [(first + timedelta(seconds=s)).strftime(shown) for s in seconds]


STEADY = [10 * k for k in range(31)]
PAST_MIDNIGHT = [40 * k for k in range(31)]


@pytest.mark.parametrize(
    ("seconds", "shown", "heading"),
    [
        (STEADY, "%H:%M:%S", "Uhrzeit"),
        (STEADY, "%H:%M:%S", "Time"),
        (STEADY, "%H:%M:%S", "timestamp"),
        (STEADY, "%I:%M:%S %p", "Time of day"),
        (STEADY, "%H:%M:%S,500", "Zeit [hh:mm:ss]"),
        (PAST_MIDNIGHT, "%H:%M:%S", "Zeit"),
    ],
)
def test_a_clock_that_goes_on_is_the_time_of_each_row(seconds, shown, heading):
    run = clocked(times(seconds, shown), heading)
    assert run.covariates["time_s"].tolist() == seconds
    assert any("is the time of each row" in note for note in run.origin.notes)


def test_a_date_that_changes_at_midnight_agrees_with_the_clock():
    run = clocked(times(PAST_MIDNIGHT), beside=times(PAST_MIDNIGHT, "%d.%m.%Y"))
    assert run.covariates["time_s"].tolist() == PAST_MIDNIGHT


@pytest.mark.parametrize(
    ("cells", "beside", "said"),
    [
        (times([0, 20, *STEADY[:29]]), None, "it goes back in line 4; write date"),
        (times([30_000 * k for k in range(31)]), None, "it passes midnight"),
        (times(STEADY), ["1.3.2026"] * 20 + ["2.3.2026"] * 11, "the date changes at other rows"),
        (times(PAST_MIDNIGHT), ["1.3.2026"] * 31, "the date changes at other rows"),
        (times(STEADY, "%H:%M"), None, "line 2 holds no time such as 14:03:22"),
        (times([0] * 31), None, "it stands still"),
    ],
)
def test_a_clock_that_does_not_tell_the_time_for_sure_is_said(cells, beside, said):
    run = clocked(cells, beside=beside)
    assert "time_s" not in run.covariates
    assert any(f"'Uhrzeit' not used as the time: {said}" in note for note in run.origin.notes)


def test_a_clock_beside_another_time_and_a_time_without_a_unit_are_said():
    rows = "".join(f"{k},0.1{k:02},{20 * k},{cell}\n" for k, cell in enumerate(times(STEADY), 1))
    run = read_table(f"cycle,X [mm],time_s,Uhrzeit\n{rows}".encode())
    assert run.covariates["time_s"][-1] == 620
    assert any("there is another time" in note for note in run.origin.notes)
    run = read_table(f"cycle,X [mm],Zeit,comment\n{rows}".encode())
    assert any("states no unit, not used as the time" in note for note in run.origin.notes)


def test_a_clock_of_rows_sorted_by_pose_goes_on_within_each():
    rows = "".join(f"P{p},{k},0.1{k:02},{times([20 * k + 10 * p])[0]}\n"
                   for p in (1, 2) for k in range(1, 15))  # fmt: skip
    run = read_table(f"pose,cycle,X [mm],Uhrzeit\n{rows}".encode())
    assert run.covariates["time_s"][[1, 14, 15]].tolist() == [20, 10, 30]


def test_ordinals_number_cycles_beside_decimal_commas():
    rows = "".join(f"{k}.;0,1{k:02}\n" for k in range(1, 32))
    run = read_table(f"Zyklus;X [mm]\n{rows}".encode())
    assert run.cycle.tolist() == [*range(1, 32)]
    assert run.axes["X"].readings[0] == 0.101


@pytest.mark.parametrize("heading", ["X¹)", "X*", "X**) [mm]", "Messwert X †"])
def test_a_footnote_at_a_heading_takes_no_axis_away(heading):
    rows = "".join(f"{k},0.1{k:02},0.2{k:02}\n" for k in range(1, 32))
    assert [*read_table(f"# unit: mm\ncycle,{heading},Y\n{rows}".encode()).axes] == ["X", "Y"]


def test_a_dash_is_a_minus():
    rows = "".join(f"{k},\u20130.1{k:02}\n" for k in range(1, 32))
    assert read_table(f"cycle,X [mm]\n{rows}".encode()).axes["X"].readings[0] == -0.101


def refusal(text, **options):
    with pytest.raises(DataError) as refused:
        read_table(text.encode(), **options)
    return f"{refused.value} {refused.value.remedy}"


@pytest.mark.parametrize("heading", ["x,y", "Z,X", "X,Y"])
@pytest.mark.parametrize("first", [0, 1])
def test_an_axis_that_counts_the_rows_is_no_axis(heading, first):
    rows = "".join(f"{k + first},0.1{k % 7}\n" for k in range(31))
    assert "counts the rows" in refusal(f"# unit: mm\n{heading}\n{rows}")
    with_cycles = "".join(f"{k + 1},{k + first},0.1{k % 7}\n" for k in range(31))
    assert len(read_table(f"# unit: mm\ncycle,{heading}\n{with_cycles}".encode()).axes) == 2


@pytest.mark.parametrize("beside", ["comment", "temperature_C", "Bemerkung", "u"])
def test_decimal_commas_that_parted_a_number_into_two_columns_are_refused(beside):
    rows = "".join(f"{k},0,1{k:02}\n" for k in range(1, 32))
    text = f"# unit: mm\ncycle,X,{beside}\n{rows}"
    assert f"X never changes and {beside} is whole: split decimal commas?" in refusal(text)
    assert read_table(text.encode(), decimal=".").axes["X"].readings[0] == 0


@pytest.mark.parametrize("cells", ["{k}12", "{k}1.5"])
def test_metres_that_were_micrometres_are_refused(cells):
    rows = "".join(f"{k},{cells.format(k=k)}\n" for k in range(1, 32))
    assert "was its unit µm?" in refusal(f"cycle,X [ m]\n{rows}")
    near = "".join(f"{k},1.1{k:02}\n" for k in range(1, 32))
    assert read_table(f"cycle,X [m]\n{near}".encode()).axes["X"].readings[0] == 1101


@pytest.mark.parametrize(
    "head", ["Faktor: 0,01", "# scale factor: 10", "Werte mit 10 multiplizieren", "par 10 divisé"]
)
def test_a_factor_is_refused_and_one_of_1_is_none(head):
    rows = "".join(f"{k};0,1{k:02}\n" for k in range(1, 32))
    assert "multiplied by no factor" in refusal(f"{head}\ncycle;X [mm]\n{rows}")
    read_table(f"Faktor: 1\ncycle;X [mm]\n{rows}".encode())


@pytest.mark.parametrize(
    "title", ["Werte x 10^-3", "# Werte x 10^-3", "×10⁻³;", "(x 10e-3)", "All values * 10**-3",
              "Messwerte mal 10^(-3)"]
)  # fmt: skip
def test_a_power_of_ten_of_all_values_is_refused(title):
    rows = "".join(f"{k};{k}.1\n" for k in range(1, 32))
    with pytest.raises(DataError, match=r"line 1.*multiplied by no factor"):
        read_table(f"{title}\ncycle;X [mm]\n{rows}".encode())
    read_table(f"Objektiv 10x10 mm\ncycle;X [mm]\n{rows}".encode())


@pytest.mark.parametrize("units", [",min,", ",s,C", ",,°F", ",Minuten,"])
def test_a_unit_row_need_not_say_that_of_an_axis(units):
    rows = "".join(f"0.1{k:02},{k},{k}\n" for k in range(1, 32))
    run = read_table(f"# unit: mm\nX,time,temperature\n{units}\n{rows}".encode())
    assert len(run) == 31
    assert ("time_s" in run.covariates) == bool(units.split(",")[1])


@pytest.mark.parametrize(
    ("title", "factor"),
    [("Alle Werte in µm", 1000), ("Messwerte [1/100 mm]", 100), ("Values (mm)", 1),
     (";Messwerte in mm;", 1)],
)  # fmt: skip
def test_a_title_states_the_unit_of_all_values(title, factor):
    rows = "".join(f"{k};{k};0,1\n" for k in range(1, 32))
    run = read_table(f"{title}\ncycle;X;Y\n{rows}".encode())
    assert run.axes["X"].readings[-1] == 31 / factor
    assert "unit" in refusal(f"{title}\ncycle;X [inch];Y\n{rows}")


@pytest.mark.parametrize("head", ["", "# resolution: 1\n"])
@pytest.mark.parametrize("mark", [";", "\t"])
def test_points_that_may_group_thousands_of_micrometres_are_refused(head, mark):
    rows = "".join(f"{k}{mark}1.1{k:02}\n" for k in range(1, 32))
    text = f"# unit: um\n{head}cycle{mark}X\n{rows}"
    assert "group thousands" in refusal(text)
    fine = text.replace("# resolution: 1", "# resolution: 0.001")
    if head:
        assert read_table(fine.encode()).axes["X"].readings[0] == pytest.approx(0.001101)


def test_a_last_row_that_is_the_mean_of_those_above_is_asked_about():
    readings = [(0.1 + k * 7 % 30 / 900, 0.8 + k * 11 % 30 / 700) for k in range(30)]
    rows = "".join(f"{x:.3f},{y:.3f}\n" for x, y in readings)
    shown = np.array([[float(cell) for cell in row.split(",")] for row in rows.split()])
    mean = ",".join(f"{value:.3f}" for value in shown.mean(axis=0))
    assert "the mean of those above" in refusal(f"# unit: mm\nX,Y\n{rows}{mean}\n")
    stated = f"# unit: mm\n# last_row: counts\nX,Y\n{rows}{mean}\n"
    assert len(read_table(stated.encode())) == 31
    assert len(read_table(f"# unit: mm\nX,Y\n{rows}0.105,0.807\n".encode())) == 31
    numbered = [f"{k},{row}\n" for k, row in enumerate(f"{rows}{mean}".split("\n"), 1)]
    timed = [f"{row.rstrip()},{7 * k}\n" for k, row in enumerate(numbered)]
    assert "the mean" in refusal(f"# unit: mm\ncycle,X,Y\n{''.join(numbered)}")
    assert read_table(f"# unit: mm\ncycle,X,Y,time_s\n{''.join(timed)}".encode())


def run_of(readings):
    axes = {name: Axis(name, readings, Dimension.LENGTH, 0.001) for name in "XY"}
    return Run(np.arange(1, len(readings) + 1), axes)


def test_a_run_whose_last_reading_is_the_mean_is_written_so_that_it_is_read():
    readings = np.round(0.1 + np.arange(30) * 7 % 30 / 900, 3)
    readings = np.append(readings, np.round(readings.mean(), 3))
    text = write_table(run_of(readings))
    assert "# last_row: counts\n" in text
    assert read_table(text.encode()).axes["X"].readings.tolist() == readings.tolist()
    assert "last_row" not in write_table(run_of(readings[::-1]))


def of_a_dial(line):
    rows = "".join(f"{k};0,5{k % 7:02}\n" for k in range(1, 32))
    return read_table(f"Einheit: mm\n{line}\nZyklus;X\n{rows}".encode())


@pytest.mark.parametrize(
    ("line", "resolution"),
    [
        ("Messuhr: Mitutoyo 0,001 mm", 0.001),
        ("Messuhr;Mahr 0,0005 mm", 0.0005),
        ("Messuhr X: Sylvac 0,5 µm", 0.0005),
        ("Dial: Käfer 1/100 mm", 0.01),
        ("Messuhr: Mitutoyo 543-390B, 0,001 mm, Messspanne 12,7 mm", 0.001),
        ("# indicator: Mitutoyo ID-C 0.001 mm (accuracy 0.003 mm)", 0.001),
        ("indicator: Sylvac 12.5 mm", None),
        ("Indicator: Mitutoyo range 0.05 mm", None),
        ("Messuhr: Mahr 0,001 mm oder 0,01 mm", None),
        ("Messuhr: Mahr 0,001 mm\nAuflösung: 0,01 mm", 0.01),
    ],
)
def test_a_size_that_a_line_about_the_dial_holds_is_its_resolution(line, resolution):
    assert of_a_dial(line).axes["X"].resolution == resolution


def test_a_size_of_the_dial_that_another_line_contradicts_is_named():
    (note,) = of_a_dial("Messuhr: Mahr 0,001 mm\nAuflösung: 0,01 mm").origin.notes
    assert note.startswith("line 2: the resolution in 'Messuhr: Mahr 0,001 mm' not used")


@pytest.mark.parametrize(
    ("heading", "cell", "below", "note"),
    [
        (";note", ";restarted", "", "column 3 'note' not used (line 14 'restarted')"),
        ("", "", "lubricated\n", "line 15: 'lubricated' not used"),
        ("", ";restarted", "", "line 14: 'restarted' beside the table not used"),
    ],
)
def test_what_happened_at_a_row_is_named(heading, cell, below, note):
    rows = [
        f"{k};0.5{k % 7:02}{cell if k == 12 else ';' * bool(heading)}\n{below if k == 12 else ''}"
        for k in range(1, 32)
    ]
    run = read_table(f"unit: mm\ncycle;X{heading}\n{''.join(rows)}".encode())
    assert (len(run), run.origin.notes) == (31, (note,))
    assert run.origin.remarks == (() if below else ("line 14 'restarted'",))


@pytest.mark.parametrize(
    ("at", "said"),
    [
        ((7,), "line 8 'Messuhr berührt'"),
        ((7, 9), "line 8 'Messuhr berührt', line 10 'Messuhr berührt'"),
        ((3, 7, 9, 20), "line 10 'Messuhr berührt' and 1 more"),
        ((1,), None),
        (range(1, 32), None),
        (range(1, 32, 2), None),
    ],
)
def test_a_remark_at_a_few_rows_that_count_is_a_warning(tmp_path, at, said):
    """Whatever it says: no list knows what a technician writes; of the first cycle none counts."""
    rows = [f"{k};0.5{k % 7:02};{'Messuhr berührt' * (k in at)}" for k in range(1, 32)]
    text = "\n".join(["cycle;X [mm];Bemerkung", *rows])
    table, folder = tmp_path / "run.csv", tmp_path / "poses"
    table.write_text(text)
    folder.mkdir()
    (folder / "P1.csv").write_text(text)
    (folder / "P2.csv").write_text(text.replace("Messuhr berührt", "").replace(";0.5", ";0.7"))
    for tables in (table, sorted(folder.iterdir())):
        found = [one for one in analyze(tables).findings if one.code == "remarked-rows"]
        assert [one.severity for one in found] == ["warning"] * bool(said)
        assert all((said or "") in re.sub(r"\S*P1.csv: ", "", one.message) for one in found)


def with_last_row(figure, *, numbered=False, center=0.8):
    """Return 30 rows whose last figures come again and again, and a row of figures of them."""
    readings = [(center + k * 7 % 9 / 1000, center + k * 5 % 7 / 1000) for k in range(30)]
    rows = [*readings, tuple(figure([row[j] for row in readings]) for j in (0, 1))]
    lines = (f"{k}," * numbered + f"{x:.3f},{y:.3f}\n" for k, (x, y) in enumerate(rows, 1))
    return f"# unit: mm\n{'cycle,' * numbered}X,Y\n{''.join(lines)}"


def rp(readings):
    apart = np.abs(np.array(readings) - np.mean(readings))
    return apart.mean() + 3 * apart.std(ddof=1)


@pytest.mark.parametrize(("figure", "center"), [(rp, 0.8), (np.sum, 0.8), (np.sum, 0.0)])
def test_a_last_row_of_sums_or_of_the_repeatability_is_asked_about(figure, center):
    assert "of those above, in every column" in refusal(with_last_row(figure, center=center))


def test_a_last_row_that_is_a_mean_as_others_are_readings_is_a_warning_but_with_a_number():
    (remark,) = read_table(with_last_row(np.mean).encode()).origin.remarks
    assert "line 33 is the mean" in remark
    assert not read_table(with_last_row(np.mean, numbered=True).encode()).origin.remarks
    counts = with_last_row(np.mean).replace("X,Y", "# last_row: counts\nX,Y")
    assert not read_table(counts.encode()).origin.remarks
