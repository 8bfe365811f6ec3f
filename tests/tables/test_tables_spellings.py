"""One table in all its spellings is read to the same numbers; a random one as well."""

import io
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import openpyxl
import pytest
from budget import examples
from hypothesis import HealthCheck, assume, given, strategies as st
from spelling import ENCODINGS, Spelling, Table, spell, workbook

from scara_iso.base.errors import DataError
from scara_iso.tables import read_table

RNG = np.random.default_rng(1)
TABLE = Table(
    {
        "X": RNG.integers(-9000, 9000, 31).tolist(),
        "Y": RNG.integers(-9000, 9000, 31).tolist(),
        "theta": RNG.integers(-9000, 9000, 31).tolist(),
    },
    {"temperature_C": [f"{20 + k / 10:.1f}" for k in range(31)], "spindle": ["1"] * 31},
)
NBSP, NARROW, MINUS = "\u00a0", "\u202f", "\u2212"
FOOTER = ("Mean", "Std. dev.", "Cpk", "Mittelwert", "Repeatability", "Min", "Max", "n")
SEMICOLON = Spelling(delimiter=";", mark=",")
SPELLINGS = {
    "canonical": Spelling(),
    "semicolon": Spelling(delimiter=";"),
    "tab": Spelling(delimiter="\t"),
    "aligned": Spelling(delimiter=" "),
    "aligned, decimal comma": Spelling(delimiter=" ", mark=","),
    "decimal comma, semicolon": SEMICOLON,
    "decimal comma, tab": Spelling(delimiter="\t", mark=","),
    "decimal comma in quotes": Spelling(mark=",", quoted=True),
    **{name: replace(SEMICOLON, encoding=name) for name in ENCODINGS},
    "CRLF": Spelling(end="\r\n"),
    "CR": Spelling(end="\r"),
    "quoted numbers": Spelling(quoted=True),
    "unit row": Spelling(unit_place="row"),
    "unit row, aligned": Spelling(unit_place="row", delimiter=" ", rule=True),
    "unit in brackets": Spelling(unit_place="bracket"),
    "unit in brackets, aligned": Spelling(unit_place="bracket", delimiter=" "),
    "unit in parentheses": Spelling(unit_place="parenthesis"),
    "unit as suffix": Spelling(unit_place="suffix"),
    "unit after a slash": Spelling(unit_place="slash"),
    "unit behind": Spelling(unit_place="behind"),
    "unit behind, aligned": Spelling(unit_place="behind", delimiter=" ", mark=","),
    "bare preamble": Spelling(preamble="bare"),
    "bare preamble, decimal comma in quotes": Spelling(preamble="bare", mark=",", quoted=True),
    "preamble in cells": replace(SEMICOLON, preamble="cells"),
    "sep=": replace(SEMICOLON, sep_line=True),
    "sep= in UTF-16": replace(SEMICOLON, sep_line=True, encoding="utf-16", end="\r\n"),
    "trailing separators": replace(SEMICOLON, trailing=3, preamble="cells"),
    "plus": Spelling(plus=True),
    "U+2212": Spelling(minus=MINUS),
    "non-breaking blanks": replace(SEMICOLON, blank=NBSP),
    "narrow blanks": replace(SEMICOLON, blank=NARROW),
    "blank lines": Spelling(blank_lines=True),
    "repeated header": Spelling(repeated_header=True),
    "footer": Spelling(footer=FOOTER),
    "other order": Spelling(order=-1),
    "Zyklus": replace(SEMICOLON, cycle="Zyklus", encoding="cp1252"),
    "n": Spelling(cycle="n"),
    "Number of Cycle": Spelling(cycle="Number of Cycle", delimiter=" "),
    "exponents": Spelling(exponent=True),
    "micrometres": Spelling(unit="um"),
    "micrometres behind": replace(SEMICOLON, unit="um", unit_place="behind"),
    "inches": Spelling(unit="inch", unit_place="parenthesis"),
    "hundredths": Spelling(unit="0.01 mm"),
    "hundredths, comma": replace(SEMICOLON, unit="0.01 mm"),
    "no last line end": Spelling(last_end=False),
    "much of it": Spelling(
        delimiter="\t", mark=",", encoding="utf-16", end="\r\n", unit="um", unit_place="bracket",
        preamble="bare", cycle="Takt", quoted=True, trailing=2, plus=True, minus=MINUS, blank=NBSP,
        blank_lines=True, repeated_header=True, footer=FOOTER, order=-1,
    ),
}  # fmt: skip


def assert_same(run, table):
    assert run.cycle.tolist() == list(range(1, table.rows + 1))
    assert set(run.axes) == set(table.axes)
    for axis in table.axes:
        expected = table.readings(axis, "mm")
        np.testing.assert_allclose(run.axes[axis].readings, expected, rtol=4e-16, atol=0)
    for name, cells in table.covariates.items():
        assert run.covariates[name].tolist() == [float(cell) for cell in cells]
    assert run.metadata["robot"] == "FUM SCARA"


@pytest.mark.parametrize("name", SPELLINGS)
def test_one_table_in_all_spellings_is_the_same_numbers(name):
    spelling = SPELLINGS[name]
    run = read_table(spell(TABLE, spelling))
    assert_same(run, TABLE)
    assert run.axes["X"].resolution == 0.001
    footers = [note for note in run.origin.notes if "footer" in note]
    assert len(footers) == len(spelling.footer)


@pytest.mark.parametrize("name", ["canonical", "footer", "inches", "other order"])
@pytest.mark.parametrize("first_row", [1, 7])
def test_a_workbook_is_the_same_numbers_whatever_its_name(name, first_row, tmp_path):
    spelling = replace(SPELLINGS[name], unit_place="metadata")
    path = tmp_path / "readings.csv"
    path.write_bytes(workbook(TABLE, spelling, first_row=first_row))
    run = read_table(path)
    assert_same(run, TABLE)
    assert run.lines[0] == first_row + 4
    assert len([n for n in run.origin.notes if "footer" in n]) == len(spelling.footer)


def test_path_standard_input_bytes_and_file_give_the_same(tmp_path, monkeypatch):
    data = spell(TABLE, SEMICOLON)
    path = tmp_path / "readings.txt"
    path.write_bytes(data)

    class Stdin:
        buffer = io.BytesIO(data)

    monkeypatch.setattr(sys, "stdin", Stdin)
    for source in (path, str(path), "-", io.BytesIO(data), data):
        assert_same(read_table(source), TABLE)


FOLDER = Path(__file__).parents[1] / "fixtures" / "tables"
FILES = sorted(path for path in FOLDER.iterdir() if path.is_file())


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_files_as_programs_write_them(path):
    run = read_table(path, unit="mm" if path.name == "scientific.txt" else None)
    assert run.cycle.tolist() == [1, 2, 3, 4, 5]
    expected = {"X": [0.112, 0.113, -0.108, 0.112, 1.11], "Y": [0.811, 0.812, 0.811, 0.81, 0.811]}
    for name, readings in expected.items():
        np.testing.assert_allclose(run.axes[name].readings, readings, rtol=4e-16, atol=0)


steps = st.integers(-(10**8), 10**8)
plain_names = st.sampled_from(["temperature_C", "spindle", "Kraft", "payload_kg", "approach"])


@st.composite
def tables(draw, min_rows=1):
    rows = draw(st.integers(min_rows, 12))
    columns = st.lists(steps, min_size=rows, max_size=rows)
    names = draw(st.lists(st.sampled_from(["X", "Y", "Z", "theta"]), min_size=1, unique=True))
    cells = st.lists(st.sampled_from(["0", "1", "20.5", "-3.25"]), min_size=rows, max_size=rows)
    covariates = draw(st.dictionaries(plain_names, cells, max_size=2))
    return Table({name: draw(columns) for name in names}, covariates)


@st.composite
def spellings(draw):
    delimiter = draw(st.sampled_from([",", ";", "\t", " "]))
    mark = draw(st.sampled_from([".", ","]))
    blanks = [""] if delimiter == " " else ["", " ", NBSP, NARROW]
    encoding = draw(st.sampled_from(sorted(ENCODINGS)))
    wide = encoding != "cp1252"
    return Spelling(
        delimiter=delimiter,
        mark=mark,
        encoding=encoding,
        end=draw(st.sampled_from(["\n", "\r\n", "\r"])),
        unit=draw(st.sampled_from(["mm", "um", "inch"])),
        unit_place=draw(
            st.sampled_from(
                ["metadata", "bracket", "parenthesis", "suffix", "slash", "row", "behind"]
            )
        ),
        preamble=draw(st.sampled_from(["#", "bare"])),
        cycle=draw(st.sampled_from(["cycle", "Zyklus", "n", "No.", "Takt", "Cycle no"])),
        quoted=draw(st.booleans()) if delimiter != " " else False,
        trailing=draw(st.integers(0, 2)) if delimiter != " " else 0,
        plus=draw(st.booleans()),
        minus=draw(st.sampled_from(["-", MINUS])) if wide else "-",
        blank=draw(st.sampled_from([b for b in blanks if wide or b != NARROW])),
        blank_lines=draw(st.booleans()),
        repeated_header=draw(st.booleans()),
        footer=tuple(draw(st.lists(st.sampled_from(FOOTER), max_size=3))),
        order=draw(st.sampled_from([1, -1])),
        exponent=draw(st.booleans()),
        last_end=draw(st.booleans()),
    )


def can_be_read(spelling):
    """A decimal comma between commas needs quotes."""
    return not (spelling.delimiter == "," and spelling.mark == "," and not spelling.quoted)


@examples(100, suppress_health_check=[HealthCheck.filter_too_much])
@given(tables(), spellings())
def test_a_random_table_in_a_random_spelling_is_the_same_numbers_or_asked(table, spelling):
    assume(can_be_read(spelling))
    data = spell(table, spelling)
    if is_asked(data, "end its last line"):  # a last 0 may be a 0.001 that is cut
        data = spell(table, replace(spelling, last_end=True))
    decimal = spelling.mark if is_asked(data, "`decimal=") else None
    assert_same(read_table(data, decimal=decimal), table)


def is_asked(data, remedy):
    """What may be asked: is the file whole, and do all commas group thousands?"""
    try:
        read_table(data)
    except DataError as error:
        return remedy in error.remedy
    return False


@pytest.mark.parametrize(
    ("page", "key", "text"),
    [("cp1252", "Prüfer", "Jörg Weiß, 20 °C, ±2 µm"), ("cp1252", "Spindel", "½Zoll, ½kg"),
     ("cp1250", "Miasto", "Ľubica, kľúč"), ("cp1250", "Operator", "Łukasz Dąbrowski"),
     ("cp932", "測定者", "山田太郎"), ("gb2312", "说明", "操作员：李雷"),
     ("gb2312", "日期", "张")],
)  # fmt: skip
def test_the_pages_of_old_programs_are_told_apart_by_words_that_are_none(page, key, text):
    rows = "".join(f"{k},{0.1 + k / 1000:.3f}\n" for k in range(1, 32))
    run = read_table(f"# unit: mm\n# {key}: {text}\ncycle,X\n{rows}".encode(page))
    assert text in run.metadata.values()
    assert page in run.origin.understood


@pytest.mark.parametrize("blank", [NBSP, NARROW, "\u2009"])
def test_a_blank_that_splits_no_table_groups_thousands(blank):
    rows = "".join(f"{k};1{blank}{800 + k}\n" for k in range(1, 32))
    run = read_table(f"Zyklus;X [µm]\n{rows}".encode())
    np.testing.assert_allclose(run.axes["X"].readings, 1.8 + np.arange(1, 32) / 1000)


def test_thousands_that_a_number_format_takes_off_are_off():
    book = openpyxl.Workbook()
    book.active.append(["cycle", "X [mm]"])
    for k in range(1, 32):
        book.active.append([k, 800 + k])
        book.active.cell(k + 1, 2).number_format = "0.000,"
    file = io.BytesIO()
    book.save(file)
    run = read_table(file.getvalue())
    np.testing.assert_allclose(run.axes["X"].readings, (800 + np.arange(1, 32)) / 1000)


@pytest.mark.parametrize("text", ["X±Y Achsen", "Leica®AT", "Größe ÄÖ 5"])
def test_a_western_text_with_symbols_is_no_chinese_one(text):
    rows = "".join(f"{k},{100 + k},{20 + k / 10:.1f}\n" for k in range(1, 32))
    head = f"# Bemerkung: {text}\n# Prüfer: Weiß\nn,X [µm],Temp [°C]\n"
    run = read_table((head + rows).encode("cp1252"))
    assert run.axes["X"].readings[0] == pytest.approx(0.101)
    assert "temperature_C" in run.covariates
