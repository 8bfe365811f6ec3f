"""`--excel-locale`: what a German and an English spreadsheet make of every table."""

import csv
import io
from pathlib import Path

import numpy as np
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
