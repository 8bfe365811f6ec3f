"""`--excel-locale`: what a German and an English spreadsheet make of every table."""

import csv
import io
import re
from datetime import date, time
from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd
import pytest
from hostile import FORMULAS, TEXTS
from office import OFFICE, opened

from scara_iso.base.errors import DataError
from scara_iso.commands import main
from scara_iso.run import Axis, Run
from scara_iso.tables import find_locale, read_table, write_rows, write_table

READINGS = [-1.234, 0.5, -0.001, 12.0]


def run_of(**metadata):
    axis = Axis("X", np.array(READINGS), resolution=0.001)
    return Run(np.arange(1, 5), {"X": axis}, metadata=metadata)


def test_the_german_table_to_the_letter():
    assert write_table(run_of(robot="a; b"), find_locale("de")) == (
        "\ufeff# unit: mm\n# resolution: 0.001\n# robot: a; b\n"
        "cycle;X\n1;-1,234\n2;0,500\n3;-0,001\n4;12,000\n"
    )


def test_numbers_that_could_all_group_thousands_end_in_a_zero():
    run = Run(np.array([1]), {"X": Axis("X", np.array([1.234]), resolution=0.001)})
    text = write_table(run, find_locale("de"))
    assert text.endswith("1;1,2340\n")
    assert read_table(text.encode()).axes["X"].readings.tolist() == [1.234]


@pytest.mark.parametrize(("name", "sep", "decimal"), [("de", ";", ","), ("en", ",", ".")])
def test_an_independent_reader_finds_the_same_numbers(name, sep, decimal):
    text = write_table(run_of(robot="=1+1"), find_locale(name))
    assert text.encode().startswith(b"\xef\xbb\xbf")
    frame = pd.read_csv(
        io.BytesIO(text.encode()), sep=sep, decimal=decimal, comment="#", encoding="utf-8-sig"
    )
    assert frame["X"].tolist() == READINGS


@pytest.mark.parametrize("name", [None, "de", "en"])
def test_hostile_rows_stay_text_and_numbers_stay_numbers(name):
    locale = find_locale(name)
    text = write_rows([(t, -0.5, 3, None, float("nan")) for t in TEXTS], locale)
    frame = pd.read_csv(
        io.BytesIO(text.encode(errors="replace")), sep=locale.delimiter,
        decimal=locale.decimal, header=None, keep_default_na=False,
    )  # fmt: skip
    assert len(frame) == len(TEXTS)
    assert set(frame[1]) == {-0.5}
    assert not any(cell.lstrip().startswith(("=", "+", "-", "@")) for cell in frame[0])


@pytest.mark.parametrize("name", [None, "de", "en"])
@pytest.mark.parametrize("hostile", TEXTS)
def test_a_hostile_head_harms_no_reading(name, hostile):
    locale = find_locale(name)
    data = write_table(run_of(robot=hostile), locale).encode("utf-8", "backslashreplace")
    assert read_table(data).axes["X"].readings.tolist() == READINGS


@pytest.mark.parametrize("command", ["simulate", "plan"])
def test_commands_write_it(command, tmp_path):
    out = tmp_path / "out.csv"
    options = ["-o", str(out), "--excel-locale", "de"]
    assert main([command, "examples/fum_scara.toml", *options]) == 0
    frame = pd.read_csv(out, sep=";", decimal=",", comment="#", encoding="utf-8-sig")
    assert len(frame.select_dtypes("number").columns) >= 4


def test_a_report_for_a_german_excel(tmp_path):
    source, out = tmp_path / "in.csv", tmp_path / "out.csv"
    stated = "# serial_number: 12.10\n# operator: =1+1\n"
    source.write_text(stated + Path("examples/scatter.csv").read_text(encoding="utf-8"))
    assert main(["report", str(source), "-o", str(out), "--excel-locale", "de"]) == 0
    text = out.read_text(encoding="utf-8")
    assert text.startswith("\ufeff")
    cells = [cell for row in csv.reader(text[1:].splitlines(), delimiter=";") for cell in row]
    assert {"0,1", "12.10", "'=1+1"} <= set(cells)
    assert not {"0.1", "12,10", "12,1"} & set(cells)


@pytest.mark.skipif(OFFICE is None, reason="LibreOffice is not installed")
@pytest.mark.parametrize("name", ["de", "en"])
def test_libreoffice_finds_numbers_and_no_formula(name, tmp_path):
    stated = {f"key_{k}": text for k, text in enumerate(FORMULAS)}
    text = write_table(run_of(**stated), find_locale(name))
    source = tmp_path / "in.csv"
    source.write_text(text, encoding="utf-8", errors="backslashreplace", newline="")
    (rows,) = opened(name, source)
    assert [row[1].value for row in rows[-4:]] == READINGS
    assert not [c.value for row in rows for c in row if c.data_type == "f"]


def test_one_cell_with_the_other_mark_is_named_with_what_to_write(tmp_path):
    rows = "\n".join(f"{k};0,12{k % 9};{'-0.121' if k == 14 else '-0,120'}" for k in range(1, 32))
    path = tmp_path / "run.csv"
    path.write_text(f"# unit: mm\ncycle;X;Y\n{rows}\n")
    with pytest.raises(DataError, match=r"line 16, column 3: '-0\.121' with") as odd:
        read_table(path)
    assert odd.value.remedy.startswith("write them alike;")
    with pytest.raises(DataError, match=r"'-0\.121' is not a number with a decimal comma"):
        read_table(path, decimal=",")


def form_of(head, header, footer, mark=","):
    """Return a form of 31 cycles, with its footer's ``{mean}`` and ``{s}`` of both axes."""
    readings = 5 + np.random.default_rng(3).integers(-9, 9, (31, 2)) / 1000
    rows = [f"{k};{x:.3f};{y:.3f}" for k, (x, y) in enumerate(readings, 1)]
    figures = {"mean": readings.mean(0), "s": readings[1:].std(0, ddof=1)}
    cells = {name: ";".join(f"{one:.4f}" for one in both) for name, both in figures.items()}
    lines = "\n".join([*rows, *(line.format(**cells) for line in footer)]).replace(".", mark)
    return "\n".join([*head, header, lines, ""]).encode(), readings


@pytest.mark.parametrize(
    ("head", "header", "footer"),
    [
        (["Jednostka: mm"], "Cykl;X;Y", ["Średnia;{mean}", "Odchylenie;{s}"]),
        (["Enhet: mm"], "Cykel;X;Y", ["Medelvärde;{mean}", "Spridning;{s}"]),
        (["単位: mm"], "回;X;Y", ["平均;{mean}", "標準偏差;{s}"]),
        (["Unidade: mm"], "Ciclo;X;Y", ["Média;{mean}", "Desvio;{s}"]),
        (["Yksikkö: mm", "Erottelukyky: 0,001 mm"], "Toisto;X;Y", []),
    ],
)
def test_a_form_in_a_language_of_no_list_is_read_by_its_shape(head, header, footer):
    table, readings = form_of(head, header, footer)
    run = read_table(table)
    assert run.cycle.tolist() == list(range(1, 32))
    assert not run.covariates
    assert run.axes["X"].readings == pytest.approx(readings[:, 0])
    assert run.axes["Y"].readings == pytest.approx(readings[:, 1])


@pytest.mark.parametrize("row", ["Wiederholt;5,004;5,001", "Granica;0,020;0,020", "bis;5,003;"])
def test_a_row_of_a_word_that_holds_no_figure_of_those_above_is_refused(row):
    table, _ = form_of(["Einheit: mm", "Auflösung: 0,001 mm"], "Cykl;X;Y", [row])
    with pytest.raises(DataError, match="is not a cycle number"):
        read_table(table)


def test_a_column_that_names_a_pose_in_each_row_is_of_poses():
    rows = "".join(f"{k};Pose {k % 3 + 1};{k % 7};{k % 5}\n" for k in range(1, 37))
    run = read_table(f"# unit: mm\nCykl;Miejsce;X;Y\n{rows}".encode())
    assert sorted(set(run.pose.tolist())) == ["Pose 1", "Pose 2", "Pose 3"]
    assert run.cycle.tolist() == [k // 3 + 1 for k in range(36)]


@pytest.mark.parametrize("line", ["Einheit: mm, Auflösung 0,001 mm", "Unit: mm; resolution 1 um"])
def test_a_unit_and_the_sizes_behind_it_are_statements_each(line):
    run = read_table(f"{line}\nNr;X\n1;0,112\n2;0,113\n".encode())
    assert run.axes["X"].resolution == pytest.approx(0.001)
    assert run.axes["X"].readings.max() == 0.113


def test_a_remark_that_is_nothing_but_a_unit_is_used_and_no_remark():
    run = read_table(b"# unit: mm\n# remark: Y in um\nn,X,Y\n1,0.1,100\n2,0.2,200\n")
    assert run.axes["Y"].readings.tolist() == [0.1, 0.2]
    assert "remark" not in run.metadata


def test_numbers_in_rotation_count_no_cycles():
    rows = "".join(f"{k % 12 + 1};{k % 7};{k % 5}\n" for k in range(36))
    run = read_table(f"# unit: mm\nHoek;X;Y\n{rows}".encode())
    assert run.cycle.tolist() == list(range(1, 37))
    assert "Hoek" in run.covariates


@pytest.mark.parametrize(
    ("head", "said"),
    [(["A: mm", "B: um"], "no unit"), (["Weg frei: mm"], "no unit"), (["Limite: mm"], "no unit")],
)
def test_a_unit_behind_other_than_one_word_is_asked_for(head, said):
    table, _ = form_of([*head, "Auflösung: 0,001 mm"], "Cykl;X;Y", [])
    with pytest.raises(DataError, match=said):
        read_table(table)


def test_columns_that_are_advised_for_a_form_with_a_footer_read_it():
    table, readings = form_of(["Unidade: mm"], "Ciclo;Leitura X;Leitura Y", ["Média;{mean}"])
    with pytest.raises(DataError) as refused:
        read_table(table)
    (names,) = re.findall("`columns=([^`]+)`", refused.value.remedy)
    run = read_table(table, columns=names.split(","))
    assert run.axes["Y"].readings == pytest.approx(readings[:, 1])


NOTHING_EXPLAINS = [
    "Cyclus 9 overgeslagen",
    "Cykl 9 powtórzony",
    "第9次重测",
    "各値は5回の平均",
    "Each value is the mean of 5 visits",
    "wartości pomnożone przez 2",
    "単位は1/100mm",
    "数值单位：0.01mm",
    "補正係数: 1.02",
    "Uwagi: Cykl 9 powtórzony",
]
EXPLAINED = [
    "ISO 9283 test of a SCARA",
    "Prüfprotokoll Nr. 17",
    "Seite 1 von 2",
    "1/3ページ",
    "Room 204, 21.5 °C",
    "27.11.2026",
    "Nov 28, 2026",
    "Mitutoyo 543-390B",
    "Dial gauge 0-12.7 mm",
    "load 5 kg",
    "2026年4月15日",
    "Cliente: Firma 24",
    "Prüfprotokoll 2026/117",
    "Uhrzeit 14:30",
    "Kalibriert bis 12/2027",
    "31 Zyklen, 1. Zyklus verworfen",
    "Werk 2, Halle 4",
    "Measured at 5 poses",
    "After service 2",
    "Pose P3 of 5",
    "Firmware: 1.05",
    "Robotzelle 12",
    "Certificate DKD-K-12345",
    "Fixture no. 7",
]


@pytest.mark.parametrize("line", NOTHING_EXPLAINS)
def test_a_number_that_nothing_explains_is_a_warning_in_any_language(line):
    table, _ = form_of(["Einheit: mm", "Auflösung: 0,001 mm", line], "Nr;X;Y", [])
    assert any(line[:8] in remark for remark in read_table(table).origin.remarks)


@pytest.mark.parametrize("line", EXPLAINED)
def test_dates_pages_sizes_and_names_are_no_warning(line):
    table, _ = form_of(["Einheit: mm", "Auflösung: 0,001 mm", line], "Nr;X;Y", [])
    assert not read_table(table).origin.remarks


@pytest.mark.parametrize("line", ["Waarden in honderdsten van een millimeter", "U: 0,002 mm (k=2)",
                                  "Wartości w setnych milimetra"])  # fmt: skip
def test_parts_of_a_millimetre_and_coverage_factors_are_refused_in_any_language(line):
    table, _ = form_of(["Einheit: mm", "Auflösung: 0,001 mm", line], "Nr;X;Y", [])
    with pytest.raises(DataError):
        read_table(table)


def test_counts_from_2_are_asked_about_by_any_heading():
    table, _ = form_of(["Einheit: mm"], "Cykl;X;Y", [])
    rows = re.sub(rb"\n([0-9]+);", lambda m: b"\n%d;" % (int(m[1]) + 1), table)
    with pytest.raises(DataError, match="numbers the rows"):
        read_table(rows, decimal=",")


def test_a_column_is_not_declared_by_the_letters_of_another():
    rows = "".join(f"{k},{k % 7},{k % 5}\n" for k in range(1, 32))
    run = read_table(f"# unit: mm\n# covariates: load\no,X,load\n{rows}".encode())
    assert "o" not in run.covariates


@pytest.mark.parametrize("word", ["Mértékegység", "Jednotka", "Birim", "Eenheid", "Unité"])
def test_a_word_for_the_unit_states_it(word):
    rows = "".join(f"{k};{k % 7}\n" for k in range(1, 32))
    assert read_table(f"{word}: mm\nn;X\n{rows}".encode()).origin.units == {"X": "mm"}


def test_a_column_that_is_declared_a_condition_is_one_though_it_counts():
    rows = "".join(f"{k},{k % 7}\n" for k in range(1, 32))
    run = read_table(f"# unit: mm\n# covariates: load\nload,X\n{rows}".encode())
    assert "load" in run.covariates


def test_a_column_that_is_taken_by_its_cells_is_named():
    rows = "".join(f"{k},{k % 7}\n" for k in range(1, 32))
    run = read_table(f"# unit: mm\nminute,X\n{rows}".encode())
    assert any("'minute'" in note for note in run.origin.notes)


@pytest.mark.parametrize("seed", range(20))
def test_a_reading_under_a_word_is_never_left_out(seed):
    rng = np.random.default_rng(seed)
    x = 5 + np.round(rng.normal(0, 0.01, 31), 2)
    rows = "".join(f"{k},{one:.2f}\n" for k, one in enumerate(x[:30], 1))
    with pytest.raises(DataError, match="is not a cycle number"):
        read_table(f"# unit: mm\ncycle,X\n{rows}redo,{x[30]:.2f}\n".encode())


@pytest.mark.parametrize("key", ["Flange", "Encoder", "Stroke"])
def test_a_unit_of_another_thing_is_not_that_of_readings(key):
    rows = "".join(f"{k},{k % 7}\n" for k in range(1, 32))
    with pytest.raises(DataError, match="no unit stated"):
        read_table(f"{key}: um\ncycle,X\n{rows}".encode())


@pytest.mark.parametrize("line", ["# theta in decimal degrees", "# values in decimal notation"])
def test_decimal_is_no_tenth(line):
    rows = "".join(f"{k},{k % 7}\n" for k in range(1, 32))
    assert len(read_table(f"{line}\n# unit: mm\ncycle,X\n{rows}".encode())) == 31


def test_a_date_column_of_a_workbook_is_no_time(tmp_path):
    book = openpyxl.Workbook()
    book.active.append(["Date", "Time", "X (mm)"])
    for k in range(31):
        book.active.append([date(2026, 11, 27), time(9, k), 0.1 + k % 7 / 1000])
    book.save(path := tmp_path / "times.xlsx")
    run = read_table(path.read_bytes())
    assert run.covariates["time_s"].tolist() == [60.0 * k for k in range(31)]


def test_a_date_above_the_readings_of_a_workbook_is_no_midnight(tmp_path):
    book = openpyxl.Workbook()
    for row in (["Datum", date(2026, 11, 28)], ["Einheit", "mm"], ["Zyklus", "X"], [1, 0.1]):
        book.active.append(row)
    book.save(path := tmp_path / "dated.xlsx")
    assert read_table(path.read_bytes()).metadata["date"] == "2026-11-28"


@pytest.mark.parametrize("title", ["Pozycja", "Positie", "Posição", "位置", "Lage", "Pos."])
def test_blocks_under_a_word_for_a_pose_and_its_number_are_poses(title):
    blocks = [
        f"{title} {n}\n\ncycle;X [mm]\n" + "".join(f"{k};{(n * k) % 7}.5\n" for k in range(1, 32))
        for n in (1, 2)
    ]
    run = read_table("\n".join(blocks).encode())
    assert sorted(set(run.pose.tolist())) == ["P1", "P2"]


@pytest.mark.parametrize(
    "header",
    [
        "No;X軸 (mm);Y軸 (mm)",
        "序号;X轴[mm];Y轴[mm]",
        "No;Ｘ（ｍｍ）;Ｙ（ｍｍ）",
        "n;X [㎜];Y [毫米]",
    ],
)
def test_axes_and_units_of_chinese_and_japanese_headings_are_known(header):
    rows = "".join(f"{k};{k % 5}.1;{k % 3}.2\n" for k in range(1, 32))
    run = read_table(f"{header}\n{rows}".encode())
    assert run.axes["X"].readings.max() == 4.1
    assert set(run.origin.units.values()) == {"mm"}
