"""What could be read two ways, or is no reading, is refused: what, where and what to do."""

import datetime as dt
import io
import zipfile

import openpyxl
import pytest
from openpyxl.utils import get_column_letter

import scara_iso
from scara_iso.base.errors import DataError, Fault, NoInputError, UsageError
from scara_iso.commands import main
from scara_iso.tables import read_table


def faults(data, **options):
    with pytest.raises(DataError) as caught:
        read_table(data if isinstance(data, bytes) else data.encode(), **options)
    assert caught.value.where == "bytes"
    assert caught.value.remedy
    return caught.value


def places(error):
    return [(fault.line, fault.column) for fault in error.faults]


MM = "# unit: mm\n"
ODD = [
    "ERR3", "OV", "nan", "inf", "-inf", "1e400", "1_0", "٣", "３", "", "  ", "=1+2", "0x10", "--1",
    "1.2.3", "1e", "0.1 0.2", "(0.1)", "0.1-", "12:30", "TRUE", "#DIV/0!", "+", ".", "1 234",
]  # fmt: skip


@pytest.mark.parametrize("cell", ODD)
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_what_is_no_number_among_the_readings_is_a_fault_with_its_place(cell, separator):
    rows = f"{MM}cycle,Y,X\n1,0.1,0.2\n2,0.3,@\n3,@,0.2\n".replace(",", separator)
    error = faults(rows.replace("@", cell))
    assert places(error) == [(4, 3), (5, 2)]


@pytest.mark.parametrize("code", ["#DIV/0!", "#N/A", "#NV", "#WERT!", "####", "#NAME?"])
def test_an_error_code_is_no_comment(code):
    assert places(faults(f"{MM}X,Y\n0.1,0.2\n{code},0.2\n")) == [(4, 1)]


@pytest.mark.parametrize("cell", ["x", "1.5", "-1", "", "1e30", "=1", "1 mm", "1_0"])
def test_a_bad_cycle_number_is_a_fault(cell):
    assert (4, 1) in places(faults(f"{MM}cycle,X\n1,0.1\n{cell},0.2\n3,0.3\n"))


def test_a_covariate_beyond_a_double_is_a_fault():
    assert places(faults(f"{MM}cycle,X,speed\n1,0.1,5\n2,0.2,1e400\n")) == [(4, 3)]


@pytest.mark.parametrize("name", ["pose", "operator", "speed"])
def test_a_row_commented_out_is_no_reading_whatever_its_first_column_is(name):
    run = read_table(f"{MM}{name},cycle,X\n1,1,0.1\n#1,2,0.9\n1,3,0.3\n".encode())
    assert run.cycle.tolist() == [1, 3]
    assert any("line 4" in note for note in run.origin.notes)


def test_every_fault_is_counted_and_a_thousand_are_listed():
    rows = "".join(f"{k},ERR\n" for k in range(5000))
    error = faults(f"{MM}cycle,X\n{rows}")
    assert len(error.faults) == 1000
    assert "5000 faults" in error.what


@pytest.mark.parametrize(
    ("data", "option"),
    [
        (f"{MM}cycle;X\n1;1,234\n2;2,345\n", "`decimal="),
        (f"{MM}cycle;X\n1;1.234,5\n2;1,234.5\n", "`decimal="),
        (f"{MM}cycle;X\n1;0,5\n2;0.5\n", "`decimal="),
        (f"{MM}cycle;X\n1;1,234.5\n2;0.5\n", "`decimal="),
        (f'{MM}cycle,X\n1,"1,234"\n2,"2,345"\n', "`decimal="),
        ("cycle,X\n1,0.1\n", "`unit="),
    ],
)
def test_an_option_is_named_where_a_file_can_be_read_two_ways(data, option):
    error = faults(data)
    assert option in error.remedy
    assert "`decimal=" not in str(error.faults[0])  # said once


def test_the_option_decides():
    data = f"{MM}cycle;X\n1;1,234\n2;2,345\n".encode()
    assert read_table(data, decimal=",").axes["X"].readings.tolist() == [1.234, 2.345]
    assert read_table(data, decimal=".").axes["X"].readings.tolist() == [1234, 2345]
    both = f"{MM}cycle;X\n1;1.234,5\n2;0,5\n".encode()
    assert read_table(both, decimal=",").axes["X"].readings.tolist() == [1234.5, 0.5]
    assert places(faults(both, decimal=".")) == [(3, 2), (4, 2)]


def test_decimal_commas_between_commas_double_the_fields():
    error = faults(f"{MM}cycle,X,Y\n1,0,112,0,811\n2,0,113,0,812\n")
    assert places(error) == [(3, 4), (4, 4)]
    assert "semicolons" in error.remedy


@pytest.mark.parametrize(
    ("data", "line"),
    [
        (f"{MM}cycle,X\n1,0.1\n2,0.2\n\ncycle,Y\n1,0.1\n", 6),
        (f"{MM}cycle,X\n1,0.1\n2,0.2\ncycle,X\n1,0.1\n2,0.2\n", 5),
        (f"{MM}X\n0.1\n0.2\nX\n0.1\n0.2\n", 5),
        (f"{MM}cycle,X\n1,0.1\nMean,0.1\n1,0.1\n2,0.3\n", 5),
        (f"{MM}cycle,X,,cycle,X\n1,0.1,,1,0.2\n", 2),
        (f"{MM}cycle,X\n1,0.1\n# unit: um\n2,0.2\n", 4),
        (f"{MM}cycle,A\n1,0.1\n2,0.1\ncycle,X\n1,0.1\n", 3),
        (f"{MM}cycle,X,x_mm\n1,0.1,0.2\n", 2),
    ],
)
def test_two_tables_in_one_file_are_refused(data, line):
    assert places(faults(data))[0][0] == line


def test_blank_lines_that_part_rows_without_numbers_unequally_are_asked_about():
    assert "summary" in str(faults(f"{MM}X\n0.1\n0.2\n0.3\n\n0.2\n").faults[0])
    assert len(read_table(f"{MM}X\n0.1\n\n0.2\n\n0.3\n".encode())) == 3


def test_a_footer_label_as_a_pose_is_asked_about():
    faults(f"{MM}pose,cycle,X\nP1,1,0.1\nMean,30,0.1\n")
    faults(f"{MM}pose,X\nP1,0.1\nTarget,0.1\nTarget,0.2\n")


@pytest.mark.parametrize("mark", [",", ";", "\t", "  "])
def test_quotes_around_a_cell_are_not_of_it(mark):
    rows = 'Cycle no.,Dial X (mm),"pose"\n1,"0.1","the A"\n2,"0.2","the A"\n'
    run = read_table((MM + rows.replace(",", mark)).encode())
    assert (run.axes["X"].readings.tolist(), run.pose.tolist()) == ([0.1, 0.2], ["the A"] * 2)


@pytest.mark.parametrize("heading", ["pose", "comment"])
def test_a_footer_where_no_cycle_is_numbered_is_not_averaged(heading):
    rows = "".join(f"P{k % 2},0.{100 + k}\n" for k in range(20))
    run = read_table(f"{MM}{heading},X\n{rows}Mean,0.109\n".encode())
    assert len(run) == 20
    assert "line 23: footer 'Mean, 0.109' not averaged" in run.origin.notes


@pytest.mark.parametrize(
    "head",
    [
        "# unit: mm\ncycle,X [um]\n1,0.1\n",
        "# unit: mm\n# unit: um\ncycle,X\n1,0.1\n",
        "cycle,X [mm],Y\n,um,mm\n1,0.1,0.2\n",
        "cycle,X [mm],Y [mm]\n,um,mm\n1,0.1,0.2\n",
        "cycle,X\n1,0.1 mm\n2,200 um\n",
        "cycle,X\n1,0.1 mm\n2,200\n",
        "# unit: furlong\ncycle,X\n1,0.1\n",
        "# unit: mm x 100\ncycle,X\n1,0.1\n",
        "cycle,X [mm×100]\n1,0.1\n",
        "cycle,X [volt]\n1,0.1\n",
        "# unit: deg\ncycle,X\n1,0.1\n",
        "cycle,X\n1,0.1 V\n",
        "# unit_Y: um\ncycle,X_mm,Y [mm]\n1,0.1,0.2\n",
        "# resolution: 1\ncycle,X_mm,Y_um\n1,0.1,2\n",
        "# unit: mm\n# resolution: 0\ncycle,X\n1,0.1\n",
        "# unit: mm\n# resolution: 1,000\ncycle,X\n1,0.1\n",
        "# unit: mm\n# resolution_X: 1 deg\ncycle,X\n1,0.1\n",
        "# unit: mm\n# note: a\n# note: b\ncycle,X\n1,0.1\n",
        "# unit: mm\ncycle,X,speed\n1,0.1,3 rpm\n2,0.1,3\n",
        "# unit: m\ncycle,X\n1,1e300\n",
    ],
)
def test_statements_that_conflict_or_say_nothing_known_are_faults(head):
    error = faults(head)
    assert all(fault.line for fault in error.faults)


def test_options_stand_for_statements_and_must_not_conflict():
    bare = b"cycle,X\n1,35\n"
    axis = read_table(bare, unit="0.01 mm", resolution=1).axes["X"]
    assert (axis.readings.tolist(), axis.resolution) == ([0.35], 0.01)
    stated = b"# unit: mm\n# resolution: 0.001\ncycle,X\n1,35\n"
    assert read_table(stated, unit="mm", resolution=0.001).axes["X"].resolution == 0.001
    faults(stated, unit="um")
    faults(stated, resolution=0.01)
    for options in ({"unit": "furlong"}, {"decimal": ";"}, {"resolution": 0.0}):
        with pytest.raises(UsageError):
            read_table(bare, **options)


def test_units_and_sizes_of_single_axes():
    data = b"""# unit: mm
# unit_Y: um
# resolution: 0.001
# resolution_Y: 0.5
# resolution_theta: 0.01
# indicator_uncertainty: 2 um
# command_X: -1.5
cycle,X,Y,theta_deg
1,0.1,20,0.5
"""
    axes = read_table(data).axes
    assert [a.readings[0] for a in axes.values()] == [0.1, 0.02, 0.5]
    assert [a.resolution for a in axes.values()] == [0.001, 0.0005, 0.01]
    assert [a.uncertainty for a in axes.values()] == [0.002, 0.002, None]
    assert [a.command for a in axes.values()] == [-1.5, None, None]
    assert axes["theta"].unit == "deg"
    assert read_table(b"# unit: mm\ncycle,theta\n1,0.5\n").axes["theta"].unit == "mm"


@pytest.mark.parametrize(
    "data",
    [
        b"", b"\n \n", b"0.112\n0.113\n", b"# unit: mm\ncycle,X\n",
        b"# unit: mm\ncycle,X\n1,0\x001\n",
        bytes(range(256)) * 40, b"\xff\xfe\x00", b"# unit: mm\ncycle,X\n1," + b"1" * 10_000_000,
        b"# unit: mm\ncycle,X" + b",a" * 1_000_000 + b"\n1,0.1\n",
        b"# unit: mm\ncycle,X" + b",a" * 2_000 + b"\n1,0.1\n", b"# unit: mm\ncycle,=X,X\n1,1,1\n",
        b"# unit: mm\npose,cycle,X\n=A1,1,0.1\n", b"# unit: mm\npose,cycle,X\n,1,0.1\n",
        b'# unit: mm\ncycle,X\n1,"0.1\n2,0.2\n', b"# unit: mm\ncycle,X,status\n1,0.1,OK\n",
        b"# unit: mm\n,cycle,X\n0,1,0.1\n", b"# unit: mm\ncycle,X,Y\n1,0.1\n2,0.1,0.2,0.3\n",
        b"# unit: mm\ntimestamp,X\n2024-05-13T14:03:22,0.1\nnoon,0.2\n",
        b"# unit: mm\ntimestamp,X\n2024-05-13T14:03:22,0.1\n2024-05-13T14:03:22Z,0.2\n",
        b"\xd0\xcf\x11\xe0" + bytes(600), b"PK\x03\x04" + bytes(600),
    ],
)  # fmt: skip
def test_what_is_no_table_is_refused(data):
    assert faults(data).faults


NOTE = "the clamp of the dial was loose again and then it was set"


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"\x89PNG\r\n\x1a\n" + bytes(99), "this is a picture, not a table"),
        (b"%PDF-1.7\n1 0 obj", "this is a PDF, not a table"),
        (f"# About 1 robot\n{NOTE}\n".encode() * 20, "this is a text, not a table"),
        (b"# unit: mm\nX,note\n" + f"0.81x,{NOTE}\n".encode() * 31, "31 faults"),
    ],
)
def test_a_file_of_another_kind_is_called_that_and_a_table_with_long_notes_is_none(data, said):
    assert said in faults(data).what


def test_no_such_file_a_folder_and_a_bad_name_are_no_input(tmp_path):
    for source in (tmp_path / "none.csv", tmp_path, "a\0b"):
        with pytest.raises(NoInputError):
            read_table(source)


def test_notes_say_what_was_not_used():
    data = b"""Repeatability test 7
# unit: mm
# begun early
Date,Time,cycle,X,Operator
2024-05-13,14:03,1,0.1,AS
# 2024-05-13,14:03,2,0.9,AS
2024-05-13,14:04,2,0.2,AS
,,Mean,0.15,

Inspector: A. Smith
"""
    run = read_table(data)
    assert run.axes["X"].readings.tolist() == [0.1, 0.2]
    assert run.lines.tolist() == [5, 7]
    text = "\n".join(run.origin.notes)
    for word in ("Repeatability test 7", "'Date'", "'Time'", "'Operator'", "line 6", "line 8",
                 "Smith"):  # fmt: skip
        assert word in text
    assert run.origin.understood == (
        "comma-separated, UTF-8, decimal point; X in mm; 2 rows (lines 5-7)"
    )


def test_times_become_seconds_and_rows_without_cycles_are_numbered():
    data = b"# unit: mm\ntimestamp,X\n2024-05-13T14:03:22,0.1\n2024-05-13 14:03:25.5,0.2\n"
    run = read_table(data)
    assert run.covariates["time_s"].tolist() == [0.0, 3.5]
    assert run.metadata["timestamp_start"] == "2024-05-13T14:03:22"
    assert run.cycle.tolist() == [1, 2]
    assert "no cycle column" in run.origin.notes[0]


@pytest.mark.parametrize(
    "name", ["Temperature [°C]", "temperature_c", "Temperatur (C)", "TEMPERATURE_C"]
)
def test_the_known_covariates_have_one_name(name):
    run = read_table(f"# unit: mm\ncycle,X,{name},Drehzahl\n1,0.1,20,5\n".encode())
    assert list(run.covariates) == ["temperature_C", "Drehzahl"]


# workbooks


def book(*sheets):
    found = openpyxl.Workbook()
    found.remove(found.active)
    for k, rows in enumerate(sheets, 1):
        sheet = found.create_sheet(f"S{k}")
        for row in rows:
            sheet.append(row)
    file = io.BytesIO()
    found.save(file)
    return file.getvalue()


ROWS = [["cycle", "X [mm]"], [1, 0.1], [2, 0.2]]


def test_of_several_sheets_the_user_says_which():
    other = [["cycle", "X [mm]"], [1, 0.5]]
    assert len(read_table(book(ROWS, [["notes"], ["none"]]))) == 2
    assert "`sheet=" in faults(book(ROWS, other)).remedy
    assert read_table(book(ROWS, other), sheet="S2").axes["X"].readings.tolist() == [0.5]
    assert "S1" in faults(book(ROWS, other), sheet="S3").what
    faults(b"cycle,X [mm]\n1,0.1\n", sheet="S1")


def test_dates_errors_booleans_and_blanks_among_the_readings_of_a_workbook_are_faults():
    day = dt.datetime(2024, 5, 1)  # noqa: DTZ001 - as Excel keeps it
    bad = [[3, day], [4, True], [5, None], [6, "=1/0"], [7, "ERR"], [8, dt.time(3, 4)]]
    assert places(faults(book(ROWS + bad))) == [(k, 2) for k in range(4, 10)]
    error = [["X [mm]"], [0.1], ["#DIV/0!"]]
    assert places(faults(book(error))) == [(3, 1)]


@pytest.mark.slow
def test_a_cell_far_away_and_a_bomb_are_refused_before_they_fill_the_memory():
    far = openpyxl.Workbook()
    far.active["A1"], far.active["XFD1048576"] = "X [mm]", 1
    file = io.BytesIO()
    far.save(file)
    assert "1048576 rows" in faults(file.getvalue()).what
    bomb = io.BytesIO()
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive:
        for k in range(6):
            archive.writestr(f"xl/worksheets/sheet{k}.xml", bytes(100 * 2**20))
    assert "48 MB" in faults(bomb.getvalue()).what


MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
SHEET = f'<worksheet xmlns="{MAIN}"><sheetData>%s</sheetData></worksheet>'
OF_TEXTS = (
    '<Override PartName="/xl/sharedStrings.xml" ContentType="application/vnd.openxmlformats-'
    'officedocument.spreadsheetml.sharedStrings+xml"/>'
)
HEADER = '<row r="1"><c r="A1" t="inlineStr"><is><t>X [mm]</t></is></c></row>'


def packed(**parts):
    """Return a workbook with other parts in it, by the beginning of their names."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        whole = zipfile.ZipFile(io.BytesIO(book(ROWS, [["notes"]])))
        texts = {name: whole.read(name).decode() for name in whole.namelist()}
        texts.setdefault("xl/sharedStrings.xml", f'<sst xmlns="{MAIN}"/>')
        listed = texts["[Content_Types].xml"]
        texts["[Content_Types].xml"] = listed.replace("</Types>", f"{OF_TEXTS}</Types>")
        for name, text in texts.items():
            key = name.rpartition("/")[2].partition(".")[0]
            archive.writestr(name, parts.get(key, text))
    return file.getvalue()


def shared(*texts):
    return f'<sst xmlns="{MAIN}">{"".join(f"<si><t>{text}</t></si>" for text in texts)}</sst>'


def test_a_workbook_whose_directory_lies_about_a_size_is_refused():
    rows = HEADER + '<row r="2"><c r="A2"><v>1</v></c></row>'
    honest = packed(sheet1=SHEET % rows, sharedStrings=shared("a" * 1_000_000))
    assert len(read_table(honest)) == 1
    size = (1_000_000 + len(shared(""))).to_bytes(4, "little")
    at = honest.index(b"PK\x01\x02")
    lying = honest[:at] + honest[at:].replace(size, (9).to_bytes(4, "little"))
    assert lying != honest
    assert "not a valid" in faults(lying).what


def test_a_shared_text_counts_in_each_of_its_cells():
    cells = "".join(f'<row r="{k}"><c r="A{k}" t="s"><v>0</v></c></row>' for k in range(2, 1003))
    few = packed(sheet1=SHEET % (HEADER + cells), sharedStrings=shared("1"))
    assert len(read_table(few)) == 1001
    many = packed(sheet1=SHEET % (HEADER + cells), sharedStrings=shared("1" * 30_000))
    assert len(many) < 20_000
    assert "characters in its cells" in faults(many).what


@pytest.mark.parametrize(
    "parts",
    [
        {"sharedStrings": f'<sst xmlns="{MAIN}">{"<si/>" * 2_000_001}</sst>'},
        {"sheet1": SHEET % '<row r="1"><c r="A1" t="s"><v>7</v></c></row>',
         "sharedStrings": shared("X [mm]")},
        {"sharedStrings": '<!DOCTYPE sst [<!ENTITY a "b">]><sst/>'},
    ],
)  # fmt: skip
def test_shared_texts_without_measure_or_sense_are_refused(parts):
    what = faults(packed(**parts)).what
    assert "not a valid" in what or "more than 1000000 cells" in what


def test_two_sheets_of_one_part_are_refused():
    whole = zipfile.ZipFile(io.BytesIO(book(ROWS, ROWS)))
    links = whole.read("xl/_rels/workbook.xml.rels").decode().replace("sheet2.xml", "sheet1.xml")
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in whole.namelist():
            archive.writestr(name, links if "workbook.xml.rels" in name else whole.read(name))
    assert "hold a table each" in faults(file.getvalue()).what


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b'r="A3"', b'r="A999999999999"'),
        (b"</sheetData>", b'</sheetData><mergeCells><mergeCell ref="A9:XFD1048576"/></mergeCells>'),
        (b"<sheetData>", b"<sheetData"),
        (b"<worksheet", b'<!DOCTYPE a [<!ENTITY b "c">]><worksheet'),
    ],
)
def test_a_workbook_out_of_order_is_refused(old, new):
    whole = zipfile.ZipFile(io.BytesIO(book(ROWS)))
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in whole.namelist():
            archive.writestr(name, whole.read(name).replace(old, new))
    what = faults(file.getvalue()).what
    assert "workbook" in what or "more than 1000000 cells" in what


def test_text_numbers_beside_numbers_in_a_workbook_keep_their_value():
    run = read_table(book([["cycle", "X [mm]"], [1, "0,112"], [2, 1.234], [3, "0,5"]]))
    assert run.axes["X"].readings.tolist() == [0.112, 1.234, 0.5]
    assert places(faults(book([["cycle", "X [mm]"], [1, "1,112"], [2, 1.234]]))) == [(2, 2)]


@pytest.mark.parametrize(
    ("header", "row"), [("cycle,X,Y", "{k},0,11{d}"), ("X,Y,Z,theta", "0,11{d},0,81{d}")]
)
def test_decimal_commas_split_into_two_axes_are_asked_about(header, row):
    rows = "\n".join(row.format(k=k, d=k % 5) for k in range(1, 32))
    text = f"# unit: mm\n{header}\n{rows}\n".encode()
    with pytest.raises(DataError, match="split decimal commas") as caught:
        read_table(text)
    assert "`decimal=.`" in caught.value.remedy
    assert read_table(text, decimal=".").axes["X"].readings[0] == 0


@pytest.mark.parametrize(
    ("row", "marks"),
    [
        ("{k};0,11{k};0.81{k}", {2, 3}),
        ("{k};0.11{k};0,81{k}", {2, 3}),
        ("{k};11{k};0.81{k}", set()),
    ],
)  # fmt: skip
def test_points_in_one_column_and_commas_in_another_are_asked_about(row, marks):
    text = f"{MM}cycle;X;Y\n" + "".join(row.format(k=k) + "\n" for k in range(1, 5))
    if not marks:
        assert read_table(text.encode()).axes["Y"].readings[0] == 0.811
        return
    error = faults(text)
    assert {fault.column for fault in error.faults} == marks
    assert "`decimal=" in error.remedy


def sheet_of(cells):
    """Return a workbook with a run of 31 cycles from B3 of sheet ``Run 1``, and these cells."""
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.title = "Run 1"
    for k, name in enumerate(["cycle", "X [mm]", "Y [mm]"], 2):
        sheet.cell(3, k, name)
    for k in range(31):
        for column, value in enumerate([k + 1, 0.112 + k % 3 / 1000, 0.811], 2):
            sheet.cell(4 + k, column, value)
    for place, value in cells.items():
        sheet[place] = value
    file = io.BytesIO()
    book.save(file)
    return file.getvalue()


def test_a_fault_in_a_workbook_names_its_cell():
    with pytest.raises(DataError) as caught:
        read_table(sheet_of({"C14": "abc", "D20": "#N/A"}))
    first, second = map(str, caught.value.faults)
    assert first.startswith("Run 1!C14: 'abc'")
    assert second.startswith("Run 1!D20: ")


def test_a_cycle_out_of_order_in_a_workbook_names_its_row():
    with pytest.raises(DataError) as caught:
        scara_iso.analyze(sheet_of({"B10": 9}))
    assert str(caught.value.faults[0]).startswith("Run 1, row 10: ")


@pytest.mark.parametrize(("column", "cell"), [(1, "A2"), (26, "Z2"), (27, "AA2"), (703, "AAA2")])
def test_columns_have_the_letters_of_a_spreadsheet(column, cell):
    assert cell == f"{get_column_letter(column)}2"
    assert str(Fault("wrong", 2, column, "S")) == f"S!{cell}: wrong"


def test_faults_that_are_alike_are_one_line_with_every_place():
    rows = [
        f"{k},{'n/a' if k > 2 else '0.1'},{'abc' if k in (4, 9) else '0.2'}" for k in range(1, 32)
    ]
    with pytest.raises(DataError) as caught:
        read_table("\n".join(["# unit: mm", "cycle,X,Y", *rows]).encode())
    assert len(caught.value.faults) == 31
    assert caught.value.fault_lines() == [
        "  lines 5 to 33, column 2: 'n/a' is not a number (29 times)",
        "  line 6, column 3: 'abc' is not a number",
        "  line 11, column 3: 'abc' is not a number",
    ]


def test_what_to_do_is_said_of_each_kind_of_fault(tmp_path, capsys):
    table = tmp_path / "run.csv"
    table.write_text("# unit: mm\ncycle;X\n1;1,204\n2;#WERT!\nx;1,203\n")
    assert main(["analyze", str(table)]) == 65
    todo = capsys.readouterr().err.splitlines()[-1]
    assert "--decimal" in todo
    assert "--allow-gaps" in todo
    assert "1 and up" in todo


@pytest.mark.parametrize(
    ("cell", "todo"),
    [(dt.date(2026, 5, 1), "format to Text"), (None, "saved the workbook"), ("?", "one number")],
)
def test_a_cell_of_a_sheet_that_holds_no_reading_says_what_to_do(cell, todo):
    with pytest.raises(DataError) as caught:
        read_table(sheet_of({"C10": cell}))
    assert todo in caught.value.remedy


def test_what_is_said_of_a_reading_that_was_not_taken_works_without_numbers_too(tmp_path, capsys):
    cells = [f"0.50{k % 4}" for k in range(1, 32)]
    table = tmp_path / "run.csv"
    table.write_text("\n".join(["# unit: mm", "X", *cells[:8], "-", *cells[9:], ""]))
    assert main(["analyze", str(table)]) == 65
    todo = capsys.readouterr().err.splitlines()[-1]
    assert "number the rows in a column cycle, then remove the row and say --allow-gaps" in todo
    rows = [f"{k},{cell}" for k, cell in enumerate(cells, 1) if k != 9]
    table.write_text("\n".join(["# unit: mm", "cycle,X", *rows, ""]))
    assert main(["analyze", str(table), "--allow-gaps"]) == 0


def test_what_to_do_stands_above_a_long_list_of_faults(tmp_path, capsys):
    table = tmp_path / "run.csv"
    cells = ["a,0.1", "0.1,b", "c,0.1", "0.1,d", "e,0.1", "0.1,f"]
    table.write_text("\n".join(["# unit: mm", "X,Y", "0.1,0.1", *cells]))
    assert main(["analyze", str(table)]) == 65
    headline, todo, *faults = capsys.readouterr().err.splitlines()
    assert "6 faults" in headline
    assert todo.startswith("  write the reading as one number; where none was taken, number the ")
    assert len(faults) == 6


def test_a_point_in_micrometres_may_group_thousands():
    table = "# unit: um\ncycle;X\n1;998\n2;1.012\n3;1.015"
    assert faults(table).faults[0].message.startswith("1.012 um could have a decimal point")
    assert read_table(table.encode(), decimal=",").axes["X"].readings[1] == pytest.approx(1.012)
    for stated in ({"decimal": "."}, {"resolution": 0.001}):
        run = read_table(table.encode(), **stated)
        assert run.axes["X"].readings[1] == pytest.approx(0.001012)


@pytest.mark.parametrize("cells", [("1.0125", "1.012"), ("0.998", "1.012"), ("1.25", "2.25")])
def test_a_point_in_micrometres_that_can_group_none_is_read(cells):
    run = read_table("# unit: um\nX;Y\n{};1.5\n{};1.5".format(*cells).encode())
    assert run.axes["X"].readings[0] == pytest.approx(float(cells[0]) / 1000)


def test_a_sentence_under_the_readings_is_a_remark():
    numbered = "| # | X (mm) |\n|---|---|\n| 1 | 0.1 |\n| 2 | 0.2 |\n\nAll fine.\n"
    run = read_table(numbered.encode())
    assert run.axes["X"].readings.tolist() == [0.1, 0.2]
    assert "line 6: 'All fine.' not used" in run.origin.notes


def test_a_sentence_between_readings_that_nobody_numbered_may_be_a_lost_one():
    error = faults("# unit: mm\nX,Y\n0.1,0.2\nno reading taken\n0.1,0.3\n")
    assert error.faults == (Fault("readings below the footer of line 4", 5),)


def test_a_column_may_be_named_in_the_row_above_the_axes():
    table = "# unit: mm\nLauf;Messuhr;\n;X;Y\n1;0,1;0,2\n2;0,3;0,4\n"
    run = read_table(table.encode())
    assert run.cycle.tolist() == [1, 2]
    assert run.axes["Y"].readings.tolist() == [0.2, 0.4]
    assert not run.covariates
    error = faults("# unit: mm\nVersuch;Messuhr;\n;X;Y\n1;0,1;0,2\n2;0,3;0,4\n")
    assert places(error) == [(4, 1), (5, 1)]


def test_axes_in_rows_are_to_be_turned():
    error = faults(f"Zyklus;{';'.join(map(str, range(31)))}\nX [mm]{';0,1' * 31}\n")
    assert error.remedy.startswith("the axes stand in rows: turn the table")


def test_a_model_is_no_table(tmp_path):
    model = tmp_path / "robot.toml"
    model.write_text('[robot]\nname = "SR-3"\n[indicator.X]\nscatter = 0.003\n')
    with pytest.raises(DataError, match="not a table of readings") as caught:
        read_table(model)
    assert "`model=`" in caught.value.remedy


def test_a_covariate_in_another_unit_than_its_name_says_is_refused():
    error = faults("# unit: mm\nX,force_N,temperature_C\n0.1,5 N,20 °C\n0.2,0.51 kg,20 °C\n")
    assert error.faults == (Fault("force_N: 'kg' behind a value", 4, 2),)


@pytest.mark.parametrize("heading", ["Abw. Z / mm", "Weg Z [mm]", "Hub Z"])
def test_a_column_that_ends_as_an_axis_is_asked_about(heading):
    rows = "\n".join(f"{k};0.1{k % 7};0.2{k % 5};0.0{k % 9}" for k in range(1, 32))
    with pytest.raises(DataError, match="ends as the axis Z, which is not there"):
        read_table(f"Zyklus;X [mm];Y [mm];{heading}\n{rows}\n".encode())


def test_a_long_remark_is_read_to_its_end():
    rows = "\n".join(
        f"{k};0.1{k % 7};{'Messuhr leicht berührt, daher ungültig' if k == 8 else ''}"
        for k in range(1, 32)
    )
    with pytest.raises(DataError, match="and readings of this line are counted"):
        read_table(f"Nr.;X [mm];Bemerkung\n{rows}\n".encode())
