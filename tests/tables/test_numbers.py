"""The grammar of a number, cell by cell and in whole columns, and how one is spelt again."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from scara_iso.base.errors import DataError
from scara_iso.tables import read_table
from scara_iso.tables.vocabulary.words import (
    CellNumber,
    Mark,
    count_decimals,
    cut_unit,
    parse_cell,
    parse_clean,
)
from scara_iso.tables.write import (
    EXCEL,
    PLAIN,
    Digits,
    SheetLocale,
    find_locale,
    one_line,
    text_cell,
    write_rows,
)

NBSP, FIGURE, THIN, NARROW = "\u00a0", "\u2007", "\u2009", "\u202f"


@pytest.mark.parametrize(
    ("text", "value", "mark", "unit"),
    [
        ("12", 12.0, Mark.NONE, ""),
        ("-0.5", -0.5, Mark.POINT, ""),
        ("\u22120,5", -0.5, Mark.COMMA, ""),
        ("+.5", 0.5, Mark.POINT, ""),
        ("5.", 5.0, Mark.POINT, ""),
        ("1,234", 1.234, Mark.EITHER, ""),
        ("12,345", 12.345, Mark.EITHER, ""),
        ("123,456", 123.456, Mark.EITHER, ""),
        ("1234,567", 1234.567, Mark.COMMA, ""),
        ("0,123", 0.123, Mark.COMMA, ""),
        ("1,23", 1.23, Mark.COMMA, ""),
        ("1,2345", 1.2345, Mark.COMMA, ""),
        ("1,234.5", 0.0, Mark.BOTH, ""),
        ("1.234,5", 0.0, Mark.BOTH, ""),
        ("1.5e-3", 0.0015, Mark.POINT, ""),
        ("2E+2", 200.0, Mark.NONE, ""),
        (f"{NBSP}7{FIGURE}{THIN}mm{NARROW}\t", 7.0, Mark.NONE, "mm"),
        ("0.01 in", 0.01, Mark.POINT, "in"),
        ("3\u00b5m", 3.0, Mark.NONE, "\u00b5m"),
        ("1e", 1.0, Mark.NONE, "e"),
        ("7 " + "m" * 20, 7.0, Mark.NONE, "m" * 20),
        ("1e400", math.inf, Mark.NONE, ""),
    ],
)
def test_a_cell_is_its_value_its_mark_and_its_unit(text, value, mark, unit):
    assert parse_cell(text) == CellNumber(value, mark, unit)


@pytest.mark.parametrize(
    "text",
    [
        "", " ", ".", ",", "-", "nan", "inf", "1_0", "0x1", "\u0661", "e5", "--1", "+-1",
        "1 2", "1.2.3", "1,2,3", "1,234,567", "=1", "(1)", "1 -", "1)", "1=", "1 m=", "1\n2",
        "7 " + "m" * 21, "1 .5", "12'345",
    ],
)  # fmt: skip
def test_what_float_or_a_spreadsheet_would_guess_at_is_no_number(text):
    assert parse_cell(text) is None


@pytest.mark.parametrize(
    ("text", "decimal", "value"),
    [
        ("1,234", ",", 1.234), ("1,234", ".", 1234.0), ("1.234", ".", 1.234),
        ("1.234", ",", 1234.0), ("1,234,567.5", ".", 1234567.5), ("1.234.567,5", ",", 1234567.5),
        ("12,345.", ".", 12345.0), ("0.5", ".", 0.5), ("0,5", ",", 0.5),
    ],
)  # fmt: skip
def test_a_stated_decimal_mark_makes_the_other_one_group_thousands(text, decimal, value):
    number = parse_cell(text, decimal)
    assert number is not None
    assert number.value == value


@pytest.mark.parametrize(
    ("text", "decimal"),
    [
        ("0,123", "."), ("0.123", ","), ("1,23", "."), ("1.2345", ","), ("1234,567", "."),
        ("1,234,5", "."), ("1.5,234", "."), ("1,5.234", ","), ("1,,234", "."), ("1,2", "."),
        ("1.2.3", "."), ("1,2,3", ","), ("1,234.5.6", "."),
    ],
)  # fmt: skip
def test_what_groups_no_thousands_is_no_number_with_a_stated_mark(text, decimal):
    assert parse_cell(text, decimal) is None


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("1.250", 3), ("1,25 mm", 2), (" 12 ", 0), ("5.", 0), ("\u2212.5", 1), ("1e-3", None),
        ("1.5E2", None), ("x", None), ("", None),
    ],
)  # fmt: skip
def test_the_digits_behind_the_mark_are_the_resolution(text, count):
    assert count_decimals(text) == count


@pytest.mark.parametrize(
    ("cells", "decimal", "values", "mark"),
    [
        (["1", "-2", "+3"], None, [1, -2, 3], Mark.NONE),
        (["1.5", "2"], None, [1.5, 2], Mark.POINT),
        (["1.5", "2e3"], ".", [1.5, 2000], Mark.POINT),
        (["1,5", "2"], None, [1.5, 2], Mark.COMMA),
        (["1,5", "2"], ",", [1.5, 2], Mark.COMMA),
        (["1,234", "2,345", "7"], None, [1.234, 2.345, 7], Mark.EITHER),
        ([" +1,234 ", "-2,345"], None, [1.234, -2.345], Mark.EITHER),
        (["1,234", "0,345"], None, [1.234, 0.345], Mark.COMMA),
        ([" 4 ", "5"], None, [4, 5], Mark.NONE),
    ],
)
def test_a_clean_column_is_read_as_its_cells_are(cells, decimal, values, mark):
    found = parse_clean(cells, decimal)
    assert found is not None
    np.testing.assert_array_equal(found[0], values)
    assert found[1] is mark


@pytest.mark.parametrize(
    ("cells", "decimal"),
    [
        (["1.5", "1,5"], None),  # points and commas in one column: one of them is wrong
        (["1.5"], ","), (["1,5"], "."), (["1", ""], None), (["1", "x"], None), (["nan"], None),
        (["1_0"], None), (["\u0661"], None), (["\u22121"], None), (["1e400", "1"], None),
        (["-1e400", "1"], None), (["1,2,3"], None), (["1 mm"], None), (["1-2"], None),
    ],
)  # fmt: skip
def test_a_column_that_is_not_clean_is_read_cell_by_cell(cells, decimal):
    assert parse_clean(cells, decimal) is None


@pytest.mark.parametrize(
    ("name", "locale"),
    [("de", SheetLocale(";", ",", "\ufeff")), ("en", SheetLocale(",", ".", "\ufeff")),
     ("fr", PLAIN), (None, PLAIN), (1, PLAIN), ([], PLAIN)],
)  # fmt: skip
def test_a_locale_is_found_by_its_language_and_is_plain_else(name, locale):
    assert find_locale(name) == locale
    assert SheetLocale(",", ".", "") == PLAIN


@pytest.mark.parametrize(
    ("text", "cell"),
    [
        ("plain", "plain"), ("", ""), ("a\r\nb\tc\x9fd", "a b c d"), ("-2.5", "-2.5"),
        ("+1", "+1"), ("-2 mm", "'-2 mm"), ("=1+1", "'=1+1"), ("@x", "'@x"), ("  =1", "'  =1"),
        ("\uff1d1", "'\uff1d1"), ("\uff0b1", "'\uff0b1"), ("\uff0d1", "'\uff0d1"),
        ("\uff20x", "'\uff20x"), ("'quoted", "''quoted"), ("  'q", "'  'q"), ("-x", "'-x"),
        ("1-1", "1-1"), ("a=1", "a=1"), ("\t=1", "' =1"),
    ],
)  # fmt: skip
def test_text_never_becomes_a_formula(text, cell):
    assert text_cell(text) == cell


def test_control_characters_are_a_blank():
    assert one_line("a\x00\x1f\nb\x7fc d") == "a b c d"


def test_rows_are_spelt_to_the_letter():
    rows = [["a,b", 1.5, -2, None, math.nan, math.inf, Digits("0.50"), "0.50", "=x", 1e-7]]
    assert write_rows(rows) == '"a,b",1.5,-2,,,,0.50,0.50,\'=x,1e-07\n'
    assert write_rows(rows, EXCEL["de"]) == "a,b;1,5;-2;;;;0,50;0.50;'=x;1e-07\n"
    assert write_rows([]) == ""
    assert write_rows([["x"], [1]]) == "x\n1\n"


@pytest.mark.parametrize(
    ("numbers", "spelt"),
    [
        ([1.234], "1,2340"), ([1.234, 5], "1,2340;5"), ([1.234, 22.345], "1,2340;22,3450"),
        ([1.234, 1.5], "1,234;1,5"), ([1.5, 1.234], "1,5;1,234"), ([0.234, 1.234], "0,234;1,234"),
        ([Digits("1.234e-05")], "1,2340e-05"), ([-1.234], "-1,2340"), (["1,234"], "1,234"),
        ([1.234, "1,5"], "1,2340;1,5"), ([12], "12"),
    ],
)  # fmt: skip
def test_a_number_that_could_group_thousands_is_settled_where_no_other_one_does(numbers, spelt):
    """1,234 alone could be a thousand; beside 1,5 it cannot. Text settles nothing."""
    assert write_rows([numbers], EXCEL["de"]) == spelt + "\n"
    plain = write_rows([numbers], EXCEL["en"])
    assert "1,2340" not in plain


def test_numbers_and_locales_never_change():
    for kind in (CellNumber, SheetLocale):
        assert kind.__dataclass_params__.frozen
        assert "__slots__" in vars(kind)
    assert not vars(Digits).get("__dict__")
    assert not hasattr(Digits("1"), "__dict__")


pieces = st.sampled_from([*"0123456789", "-", "+", ".", ",", "e", " ", NBSP, "mm", "m", "in", "°C"])
spellings = st.lists(pieces, max_size=6).map("".join)


@given(st.lists(spellings, min_size=1, max_size=4), st.sampled_from(["", " mm", "m", "e", " °C"]))
def test_a_column_with_a_unit_behind_each_value_is_as_its_cells_are(numbers, behind):
    cells = [number + behind for number in numbers]
    cut, unit = cut_unit(cells)
    found = parse_clean(cut, None)
    if unit and found is not None:
        one_by_one = [parse_cell(cell) for cell in cells]
        assert [one and (one.value, one.unit) for one in one_by_one] == [
            (value, unit) for value in found[0].tolist()
        ]


def test_a_table_in_many_pieces_is_the_same(monkeypatch):
    rows = [f"{k},{k / 7:.4f},{-k / 3:.3f}" for k in range(1, 61)]
    head = "# unit: mm\ncycle,X,Y\n"
    whole = read_table((head + "\n".join(rows) + "\n").encode())
    monkeypatch.setattr("scara_iso.tables.grid._CHUNK", 100)
    pieces = read_table((head + "\n".join(rows) + "\n").encode())
    assert pieces.to_frame().equals(whole.to_frame())
    assert (pieces.lines == whole.lines).all()
    rows[40] = "41,0.1.2,3.0"
    with pytest.raises(DataError, match=r"line 43, column 2.*0\.1\.2"):
        read_table((head + "\n".join(rows) + "\n").encode())
