"""`report -o x.xlsx` of a hostile table: text stays text, numbers numbers, in two readers."""

import io
import zipfile
from xml.etree import ElementTree as ET

import openpyxl
import pytest
from hostile import TEXTS, table
from openpyxl.utils.escape import unescape
from python_calamine import CalamineWorkbook

from scara_iso import read_table
from scara_iso.commands import main
from scara_iso.render.formats import xlsx
from scara_iso.reporting.shared.blocks import Document, Section, Table, Text
from scara_iso.reporting.shared.digits import Number, printable

LONGEST = 32_767
MAIN = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"


@pytest.fixture(
    scope="module", params=[TEXTS[::9], pytest.param(TEXTS, marks=pytest.mark.slow)],
    ids=["some poses", "all poses"],
)  # fmt: skip
def source(request, tmp_path_factory):
    poses = [f"p{k}{text[:30]}" for k, text in enumerate(request.param)]
    return table(tmp_path_factory.mktemp("xlsx") / "=1+1_x0041_.xlsx", poses=poses)


@pytest.fixture(scope="module")
def book(source):
    out = source.with_name("out.xlsx")
    assert main(["report", str(source), "--cycles", "4", "-o", str(out)]) == 0
    return out.read_bytes()


def by_calamine(data):
    found = CalamineWorkbook.from_filelike(io.BytesIO(data))
    return {n: found.get_sheet_by_name(n).to_python() for n in found.sheet_names}


def by_openpyxl(data):
    """Return the cells; openpyxl leaves the codes of characters to its caller."""
    return {
        sheet.title: [[unescape(c) if isinstance(c, str) else c for c in row]
                      for row in sheet.iter_rows(values_only=True)]
        for sheet in openpyxl.load_workbook(io.BytesIO(data))
    }  # fmt: skip


def shown(text):
    return printable(text)[:LONGEST]


@pytest.mark.parametrize("read", [by_openpyxl, by_calamine])
def test_every_text_is_shown_as_it_is(source, book, read):
    cells = {cell for rows in read(book).values() for row in rows for cell in row}
    run = read_table(source)
    free = [text for key, text in run.metadata.items() if key.startswith("free")]
    assert len(free) > len(TEXTS) - 5
    assert {shown(text) for text in free if text.strip()} <= cells
    assert {shown(name) for name in run.covariates} <= cells
    assert shown(f"Raw data at pose {run.pose[0]}") in cells


@pytest.mark.parametrize("read", [by_openpyxl, by_calamine])
def test_readings_are_numbers(source, book, read):
    rows = read(book)["Raw data"]
    run = read_table(source)
    body = [row for row in rows if isinstance(row[0], int | float)]
    assert len(body) == len(run)
    width = 4 + len(run.covariates)
    assert all(isinstance(cell, int | float) for row in body for cell in row[:width])
    assert [row[2] for row in body] == pytest.approx(run.axes["X"].readings)


def test_the_file_holds_no_formula_link_or_control_character(book):
    with zipfile.ZipFile(io.BytesIO(book)) as archive:
        names = [name for name in archive.namelist() if not name.endswith(".png")]
        parts = {n: ET.fromstring(archive.read(n)) for n in names}  # noqa: S314 - our own file
    assert not [n for n in names if "externalLink" in n or "vba" in n.lower()]
    for part in parts.values():
        assert not list(part.iter(f"{MAIN}f"))
        assert not list(part.iter(f"{MAIN}hyperlink"))
        assert not [e for e in part.iter() if e.get("TargetMode") == "External"]
    sheets = [s.get("name") for s in parts["xl/workbook.xml"].iter(f"{MAIN}sheet")]
    assert sheets == ["Report", "Figures", "Raw data"]


@pytest.mark.parametrize("read", [by_openpyxl, by_calamine])
@pytest.mark.parametrize("text", TEXTS, ids=lambda text: ascii(text)[:24])
def test_a_text_anywhere_in_a_report(text, read):
    stated = Table((text, text), ((text, text),), text)
    data = xlsx.render(Document(text, (Section(text, (Text(text), stated)),), None))
    cells = [c for rows in read(data).values() for row in rows for c in row if c not in ("", None)]
    assert [c for c in cells if c != " "] == [shown(text)] * 8


def test_a_text_that_is_edited_becomes_no_formula():
    texts = ("=1+1", "-2", "+x", "@x", "\uff1d1", "x", "12", "")
    data = xlsx.render(Document("t", (Section("", (Table(texts, (texts,)),)),), None))
    *_, row = openpyxl.load_workbook(io.BytesIO(data))["Report"]
    assert [bool(cell.quotePrefix) for cell in row] == [True] * 5 + [False] * 3


@pytest.mark.parametrize(
    ("number", "shape"),
    [
        (Number(-1.94773e-07, ".3e"), "0.000E+00"),
        (Number(0.0010234, ".4f"), "0.0000"),
        (Number(0.000001, ".3g"), "0E+00"),
        (Number(12), "0"),
        (Number(0.4071, ".0%"), "0%"),
        (Number(0.0126667, "+.4f"), "+0.0000;-0.0000;+0.0000"),
        (Number(0.0058, ".4f", mark="± "), '"± "0.0000'),
    ],
)
def test_a_number_keeps_all_digits_and_is_shown_with_those_of_the_report(number, shape):
    data = xlsx.render(Document("t", (Section("", (Table(("a",), ((number,),)),)),), None))
    cell = openpyxl.load_workbook(io.BytesIO(data))["Report"].cell(3, 1)
    assert cell.value == number.value
    assert cell.number_format == shape
