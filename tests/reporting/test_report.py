"""The report of a test: what it says, in every form, and that text of a file stays text."""

import csv
import importlib
import io
import json
import math
import pkgutil
import re
import shutil
import statistics
import sys
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import openpyxl
import pytest
from hostile import TEXTS
from once import forget

import scara_iso
from scara_iso import analyze, read_table
from scara_iso.commands import main
from scara_iso.diagnosis.closed_loop import close_the_loop
from scara_iso.diagnosis.engine.residual import CyclesWanted
from scara_iso.iso9283 import checks
from scara_iso.render import endings, find_format
from scara_iso.render.formats import csv as csv_format, html, md, pdf, xlsx
from scara_iso.reporting.dossier import Dossier, InputFile, Provenance
from scara_iso.reporting.report import document
from scara_iso.reporting.shared.blocks import Figure, Table, Text
from scara_iso.reporting.shared.digits import NOT_STATED
from scara_iso.reporting.shared.stated import (
    FIELDS,
    head,
    left_unused,
)

EXAMPLES = Path(__file__).parents[2] / "examples"
TABLE_1, WARM_UP = EXAMPLES / "fum_scara_table1.csv", EXAMPLES / "warm_up.csv"
MODEL = EXAMPLES / "fum_scara.toml"
MADE = Provenance((InputFile("table", "run.csv", "00"),), "0", "scara-iso report run.csv")
KINDS = ("html", "md", "csv", "xlsx", "json", "pdf")
HOSTILE = {
    "robot": "<script>alert(1)</script>",
    "laboratory": "=cmd|' /C calc'!A0",
    "customer": "[red]bold[/red]",
    "serial_number": "javascript:alert(1)",
    "operator": "</style><style>*{display:none}</style>",
    "temperature": "\u202eevil\u2066",
    "indicator": "@SUM(1)",
    "calibration_date": "+1+1",
    "payload": "-2+3",
    "report_number": "00123",
    "note": "<img src=x onerror=alert(1)> {{7*7}} ![x](http://e/x) `a` |b|",
}


@pytest.fixture
def hostile(tmp_path):
    """Return a table whose every field and whose name wants to be something else than text."""
    rows = [r for r in WARM_UP.read_text().splitlines() if not r.startswith("# robot")]
    head_lines = [f"# {key}: {value}" for key, value in HOSTILE.items()]
    path = tmp_path / "=<b onclick=x>[red].csv"
    path.write_text("\n".join([*head_lines, *rows]) + "\n", encoding="utf-8")
    return path


@pytest.fixture
def five_poses(tmp_path, rng):
    """Return a table of five poses."""
    path = tmp_path / "five.csv"
    lines = ["# unit: mm", "# resolution: 0.001", "pose,cycle,X,Y"]
    for pose in range(1, 6):
        readings = rng.normal(0, 0.005, (31, 2)).round(3)
        lines += [f"P{pose},{k},{x},{y}" for k, (x, y) in enumerate(readings, start=1)]
    path.write_text("\n".join(lines) + "\n")
    return path


def section(report, heading):
    return next(s for s in report.sections if s.heading == heading)


def rows_of(report, heading):
    table = next(b for b in section(report, heading).blocks if isinstance(b, Table))
    return {str(row[0]): dict(zip(table.header, map(str, row), strict=True)) for row in table.rows}


def make(tmp_path, table, model=None):
    """Return the bytes of one report in each form."""
    made = scara_iso.report(table, model=model)
    kinds = KINDS[:-1]  # a .pdf is the .html on paper
    return {kind: made.write(tmp_path / f"out.{kind}").read_bytes() for kind in kinds}


def test_every_intermediate_value_leads_from_the_readings_to_the_figure():
    analysis = analyze(read_table(TABLE_1))
    report = document(Dossier(analysis, MADE))
    readings = rows_of(report, "Raw data")
    used = [float(row["X [mm]"]) for row in readings.values() if row["counts"] == "yes"]
    found = {k: float(v) for k, v in rows_of(report, "Intermediate values")["X"].items()
             if k not in ("figure", "unit")}  # fmt: skip
    mean = sum(used) / len(used)
    distances = [abs(x - mean) for x in used]
    l_bar = statistics.fmean(distances)
    expected = {
        "n": len(used),
        "sum": sum(used),
        "mean": mean,
        "sum of l_j": sum(distances),
        "l_bar": l_bar,
        "sum of (l_j - l_bar)²": sum((d - l_bar) ** 2 for d in distances),
        "S_l": statistics.stdev(distances),
        "RP = l_bar + 3 S_l": l_bar + 3 * statistics.stdev(distances),
    }
    assert found == pytest.approx(expected, abs=1e-6)
    assert found["RP = l_bar + 3 S_l"] == pytest.approx(analysis.poses[0].axes["X"].RP, abs=1e-6)


def test_the_distance_of_each_cycle_gives_the_radial_figure():
    analysis = analyze(read_table(TABLE_1))
    by_cycle = rows_of(document(Dossier(analysis, MADE)), "Deviations of each cycle")
    distances = [float(row["l_j XY [mm]"]) for row in by_cycle.values()]
    RP = statistics.fmean(distances) + 3 * statistics.stdev(distances)
    assert pytest.approx(analysis.poses[0].XY.RP, abs=1e-5) == RP
    one = next(iter(by_cycle.values()))
    sides = (float(one["X - mean [mm]"]), float(one["Y - mean [mm]"]))
    assert float(one["l_j XY [mm]"]) == pytest.approx(math.hypot(*sides), abs=2e-6)


def test_the_report_says_what_its_results_relate_to():
    report = document(Dossier(analyze(read_table(WARM_UP)), MADE))
    said = [b.text for s in report.sections for b in s.blocks if isinstance(b, Text)]
    assert [text for text in said if "relate only to the item tested" in text]


def test_a_condition_is_what_was_stated_and_what_was_measured():
    run = read_table(WARM_UP)
    stated = {"speed": "100 %", "jig[P1]": "a vice"}
    run = replace(run, metadata=stated, covariates={"speed": run.cycle + 50.0})
    rows = dict(head(run, analyze(run).cycles).rows)
    assert rows["velocity"] == "100 %; 51 .. 81 (speed, by cycle)"
    assert rows["jig at P1"] == "a vice"


def test_colours_of_the_dark_reach_the_marks_of_a_picture():
    """A mark is drawn by ``use``: in its copy it has no svg above it."""
    page = html.render(document(Dossier(analyze(read_table(WARM_UP)), MADE))).decode()
    dark = page.partition("prefers-color-scheme: dark")[2].partition("* { box-sizing")[0]
    assert '[stroke="#444444"]' in dark
    assert "svg [" not in dark


def test_what_nobody_stated_is_said_to_be_not_stated():
    run = read_table(TABLE_1)
    stated = dict(head(run, analyze(run).cycles).rows)
    assert stated["item"] == "FUM SCARA"
    assert stated["laboratory"] == stated["calibration date"] == NOT_STATED
    assert set(FIELDS) <= set(stated)
    assert "9283:1998" in stated["method"]


def test_every_key_of_the_head_reaches_its_field(tmp_path):
    for field, keys in FIELDS.items():
        for key in keys:
            path = tmp_path / "run.csv"
            path.write_text(f"# {key}: something\n" + WARM_UP.read_text().replace("# robot", "# x"))
            run = read_table(path)
            assert "something" in dict(head(run, analyze(run).cycles).rows)[field], key


def test_what_nothing_acts_on_is_named_in_one_line(tmp_path, capsys):
    path = tmp_path / "run.csv"
    path.write_text("# shift supervisor: Bob\n# Halle: 7\n# customer: A\n" + WARM_UP.read_text())
    for command in ("analyze", "tables"):
        assert main([command, str(path)]) == 0
        assert "stated and not used: halle, shift supervisor\n" in capsys.readouterr().out


def test_a_size_that_is_stated_and_not_used_is_quoted_before_all_else(tmp_path, capsys):
    rows = "".join(f"{k};0,8{k % 7}1\n" for k in range(1, 32))
    head = "Grenzwert RP: 0,02 mm\nKunde: Meier\nein Satz\nFarbe: rot\nNr;X [mm]\n"
    (tmp_path / "a.csv").write_text(head + rows)
    assert main(["analyze", str(tmp_path / "a.csv")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    sizes = "stated and not used, nor a limit: grenzwert rp 0,02 mm"
    assert f"{sizes} stated and not used: farbe line 3: 'ein Satz' not used" in out


@pytest.mark.parametrize(
    "stated", ["Grenzwert RP: 0,02 mm", "RP XY <= 20 um", "Toleranz: 0.02", "limit: XY=0.02"]
)
def test_a_stated_limit_that_is_not_held_against_is_a_warning(stated, tmp_path, capsys):
    path = tmp_path / "a.csv"
    path.write_text(f"# {stated}\n# arm: 400 mm\n" + WARM_UP.read_text())
    for limit, warned in (("0.06", True), ("0.02", False)):
        main(["analyze", str(path), "--limit", limit])
        out = capsys.readouterr().out
        assert ("not held against it" in out) is warned
        assert "nor a limit: arm 400 mm" in out
    for command in (["analyze"], ["report", "-o", str(tmp_path / "r.md")]):  # and none is asked for
        main([*command, str(path)])
    page = (tmp_path / "r.md").read_text() + capsys.readouterr().out
    assert page.count("not held against it") == 2


def test_keys_that_a_check_reads_are_not_said_to_be_unused():
    keys = set()
    for one in pkgutil.iter_modules(checks.__path__):
        module = vars(importlib.import_module(f"{checks.__name__}.{one.name}"))
        keys |= {key for found in module.values() if isinstance(found, set) for key in found}
    assert len(keys) > 30
    run = replace(read_table(WARM_UP), metadata=dict.fromkeys(keys, "7"))
    assert left_unused(run) == run.origin.notes


def test_the_budget_combines_resolution_and_certificate(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("# indicator_uncertainty_X: 0.004\n" + WARM_UP.read_text())
    budget = rows_of(document(Dossier(analyze(read_table(path)), MADE)), "Uncertainty budget")
    rounding = 0.01 / math.sqrt(12)
    assert float(budget["X"]["combined u"]) == pytest.approx(math.hypot(rounding, 0.004), abs=5e-5)
    assert float(budget["X"]["expanded U = 2 u"]) == pytest.approx(
        2 * math.hypot(rounding, 0.004), abs=5e-5
    )
    assert budget["Y"]["u of the calibration"] == NOT_STATED


def test_the_raw_data_are_the_lines_of_the_table():
    report = document(Dossier(analyze(read_table(WARM_UP)), MADE))
    lines = WARM_UP.read_text().splitlines()
    for line, row in rows_of(report, "Raw data").items():
        said = [row[name] for name in ("cycle", "X [mm]", "Y [mm]", "Z [mm]", "theta [mm]")]
        assert ",".join(said) == lines[int(line) - 1]


def test_pictures_hold_the_readings_that_count(tmp_path, monkeypatch):
    analysis = analyze(read_table(WARM_UP))
    drawn = [b for b in section(document(Dossier(analysis, MADE)), "Figures").blocks
             if isinstance(b, Figure)]  # fmt: skip
    plane, *courses = drawn
    assert [d.y_label for d in courses] == ["X [mm]", "Y [mm]", "Z [mm]", "theta [mm]"]
    curves = [one.curves for d in courses for one in d.panels]
    assert all(len(readings.y) == 30 for readings, _ in curves)
    X, (discarded,) = analysis.poses[0].axes["X"], curves[0][1:]
    assert discarded.x.tolist() == [1]
    above = analysis.run.axes["X"].readings[0] > X.mean  # so far that it stands at the edge
    assert discarded.look == ("above" if above else "below")
    low, high = courses[0].y_limits
    assert low < discarded.y[0] < high
    circle, places, cross = plane.panels[0].curves
    barycentre = [np.average(v, weights=places.counts) for v in (places.x, places.y)]
    assert [*cross.x, *cross.y] == pytest.approx(barycentre)
    radius = np.hypot(circle.x - cross.x, circle.y - cross.y)
    assert radius == pytest.approx(analysis.poses[0].XY.RP)


def test_the_diagnosis_is_shown_before_and_after_where_it_changed_something():
    run = read_table(WARM_UP)
    found = close_the_loop(run, None, CyclesWanted(), seed=9283)
    report = document(Dossier(analyze(run), MADE, diagnoses={None: found}))
    found = section(report, "Diagnosis: opinions and interpretations")
    drawn = [b for b in found.blocks if isinstance(b, Figure)]
    assert {d.y_label for d in drawn} == {"X [mm]", "Y [mm]"}
    assert section(report, "Diagnosis: warm up")


def test_an_axis_that_is_another_in_its_own_unit_is_reported(tmp_path, rng):
    x = 0.5 + 0.003 * rng.normal(size=31) + 0.03 * (np.arange(31) > 14)
    rows = [f"{k},{value:.4f},{1000 * value:.1f}" for k, value in enumerate(x, 1)]
    table, page = tmp_path / "run.csv", tmp_path / "run.md"
    head = ["# unit: mm", "# unit_Y: um", "# resolution: 0.0001", "cycle,X,Y"]
    table.write_text("\n".join([*head, *rows, ""]), encoding="utf-8")
    assert main(["report", str(table), "-o", str(page)]) == 0
    text = page.read_text("utf-8")
    assert "X before and after the diagnosis" in text
    assert "Y before and after the diagnosis" not in text  # it was left out, and has no error


@pytest.mark.slow
def test_the_same_input_gives_the_same_bytes(tmp_path):
    first = make(tmp_path, WARM_UP, MODEL)
    forget()
    assert make(tmp_path, WARM_UP, MODEL) == first
    assert b"Backlash of joint 1" in first["html"]
    assert rb"fum\_scara.toml" in first["md"]


def test_text_of_a_file_stays_text_in_every_form(tmp_path, monkeypatch, hostile):
    found = make(tmp_path, hostile)
    page = found["html"].decode()
    assert "<script" not in page
    assert page.count("<style") == page.count("</style>") == 1
    assert "<img" not in page
    assert "<b onclick" not in page
    assert "{{7*7}}" in page
    assert "\u202e" not in page
    markdown = found["md"].decode()
    assert not re.search(r"<(script|img|b|style)\b", markdown)
    assert not re.search(r"(?<!\\)\]\(|https?://", markdown)
    cells = [cell for row in csv.reader(io.StringIO(found["csv"].decode())) for cell in row]
    assert not [c for c in cells if c[:1] in "=@|%" and c]
    assert not [c for c in cells if c[:1] in "+-" and c and not re.fullmatch(r"[+-][\d.]+", c)]
    assert json.loads(found["json"])["analysis"]["metadata"]["robot"] == HOSTILE["robot"]
    book = openpyxl.load_workbook(io.BytesIO(found["xlsx"]))
    kinds = {cell.data_type for sheet in book for row in sheet for cell in row}
    assert kinds <= {"s", "n", "inlineStr"}


def test_figures_and_the_appendix_begin_on_pages_of_their_own():
    report = document(Dossier(analyze(read_table(WARM_UP)), MADE))
    new = [section.heading for section in report.sections if section.new_page]
    assert [heading.partition(":")[0] for heading in new] == ["Figures", "Appendix"]


def test_every_hostile_text_is_shown_and_nothing_else():
    run = read_table(WARM_UP)
    run = replace(run, metadata={f"key {k}": text for k, text in enumerate(TEXTS)})
    report = replace(document(Dossier(analyze(run), MADE)), title=TEXTS[0])
    page = html.render(report).decode()
    outside = re.sub(r"<svg.*?</svg>", "", page, flags=re.DOTALL)
    known = {
        "html", "head", "meta", "title", "style", "body", "main", "h1", "h2", "section", "p",
        "div", "table", "thead", "tbody", "tr", "th", "td", "b", "code", "figure", "figcaption",
        "small", "span", "h3", "dl", "dt", "dd",
    }  # fmt: skip
    assert set(re.findall(r"<(\w+)", outside)) <= known
    assert not [c for c in page if ord(c) < 32 and c != "\n"]
    assert md.render(report)
    for cell in (
        c for row in csv.reader(io.StringIO(csv_format.render(report).decode())) for c in row
    ):
        assert cell.strip()[:1] not in ("=", "@")
    book = openpyxl.load_workbook(io.BytesIO(xlsx.render(report)))
    assert {c.data_type for sheet in book for row in sheet for c in row} <= {"s", "n", "inlineStr"}


def test_a_german_excel_gets_its_marks(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["report", str(WARM_UP), "-o", "out.csv", "--excel-locale", "de"]) == 0
    text = Path("out.csv").read_bytes().decode("utf-8-sig")
    assert Path("out.csv").read_bytes().startswith(b"\xef\xbb\xbf")
    assert "7;2;0,11;0,81;0,36;0,48;yes" in text.splitlines()


def test_numbers_of_the_workbook_are_numbers_and_a_serial_number_is_none(
    tmp_path, monkeypatch, hostile
):
    monkeypatch.chdir(tmp_path)
    assert main(["report", str(hostile), "-o", "out.xlsx"]) == 0
    book = openpyxl.load_workbook("out.xlsx")
    rows = list(book["Raw data"].iter_rows(values_only=True))
    body = [row for row in rows if isinstance(row[0], int)]
    assert len(body) == 31
    assert all(isinstance(value, int | float) for row in body for value in row[:6])
    cells = [cell.value for row in book["Report"] for cell in row]
    assert "Test report 00123" in cells


def test_a_cell_that_is_edited_becomes_no_formula_either(tmp_path, monkeypatch, hostile):
    monkeypatch.chdir(tmp_path)
    assert main(["report", str(hostile), "-o", "out.xlsx"]) == 0
    cells = [cell for sheet in openpyxl.load_workbook("out.xlsx") for row in sheet for cell in row]
    guarded = {c.value for c in cells if c.quotePrefix}
    assert guarded == {c.value for c in cells if str(c.value)[0] in "=+-@" and c.data_type == "s"}
    assert guarded


def test_several_poses_are_reported_each(five_poses, tmp_path, monkeypatch):
    found = make(tmp_path, five_poses)
    page = found["html"].decode()
    for pose in range(1, 6):
        assert f"Repeatability at pose P{pose}" in page
    assert page.count("<svg") == 3  # all poses on one scale: X, Y and the plane
    names = re.findall(r' id="([^"]+)"', page)
    assert len(names) == len(set(names))
    document_ = json.loads(found["json"])
    assert [d["pose"] for d in document_["diagnoses"]] == [f"P{k}" for k in range(1, 6)]


def test_every_limit_of_five_poses_is_in_the_report(tmp_path, monkeypatch, rng, capsys):
    lines = ["# unit: mm", "# resolution: 0.001", "pose,cycle,X,Y,Z"]
    for pose in range(1, 6):
        readings = rng.normal(0, 0.005, (31, 3)).round(3).tolist()
        lines += [f"P{pose},{k},{x},{y},{z}" for k, (x, y, z) in enumerate(readings, start=1)]
    (tmp_path / "five.csv").write_text("\n".join(lines) + "\n")
    monkeypatch.chdir(tmp_path)
    assert main(["analyze", "five.csv", "--limit", "1", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["limits"]) == 25
    for kind in ("md", "csv", "html"):
        assert main(["report", "five.csv", "--limit", "1", "-o", f"report.{kind}"]) == 0
        text = Path(f"report.{kind}").read_text(encoding="utf-8-sig")
        assert "--json" not in text
        assert text.count("pass") >= 25


def test_one_pose_of_several_may_be_named(five_poses, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["report", str(five_poses), "--pose", "P3", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert len(found["analysis"]["poses"]) == 1
    assert set(found["readings"]["cycle"]) == set(range(1, 32))
    assert main(["report", str(five_poses), "--pose", "P9", "--json"]) == 2


def test_the_hash_is_that_of_the_table(tmp_path, monkeypatch, capsys):
    assert main(["report", str(WARM_UP), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["files"][0]["sha256"] == sha256(WARM_UP.read_bytes()).hexdigest()
    assert found["command"] == f"scara-iso report {WARM_UP} --json"


def test_a_report_is_not_written_over_what_it_is_made_of(tmp_path, capsys):
    table = tmp_path / "run.csv"
    shutil.copy(WARM_UP, table)
    assert main(["report", str(table), "-o", str(table)]) == 73
    assert table.read_bytes() == WARM_UP.read_bytes()
    assert "an input of this command" in capsys.readouterr().err


@pytest.mark.parametrize("missing", [["no.csv"], [str(WARM_UP), "--model", "no.toml"]])
def test_a_missing_input_is_said_where_the_report_is_there_already(
    missing, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    Path("out.md").touch()
    assert main(["report", *missing, "-o", "out.md"]) == 66
    assert missing[-1] in capsys.readouterr().err


def test_a_spelling_for_excel_wants_a_table(tmp_path, capsys):
    out = tmp_path / "out.html"
    assert main(["report", str(WARM_UP), "--excel-locale", "de", "-o", str(out)]) == 2
    assert ".csv" in capsys.readouterr().err
    assert not out.exists()


def test_another_ending_names_the_known_ones(tmp_path, capsys):
    assert main(["report", str(WARM_UP), "-o", str(tmp_path / "out.docx")]) == 2
    said = capsys.readouterr().err
    assert ", ".join(endings()) in said
    assert main(["report", str(WARM_UP), "-o", str(tmp_path / "no" / "out.md")]) == 73


def test_without_its_library_a_pdf_is_refused_with_what_to_do(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "weasyprint", None)
    assert main(["report", str(WARM_UP), "-o", str(tmp_path / "out.pdf")]) == 2
    assert "uv tool install '.[pdf]'" in capsys.readouterr().err
    assert not (tmp_path / "out.pdf").exists()


def test_without_pango_a_pdf_is_refused_with_what_to_install(tmp_path, monkeypatch, capsys):
    (tmp_path / "weasyprint").mkdir()
    (tmp_path / "weasyprint" / "__init__.py").write_text("raise OSError('cannot load libpango')")
    monkeypatch.syspath_prepend(str(tmp_path))
    for name in [n for n in sys.modules if n.partition(".")[0] == "weasyprint"]:
        monkeypatch.delitem(sys.modules, name)
    assert main(["report", str(WARM_UP), "-o", str(tmp_path / "out.pdf")]) == 2
    assert "libpango-1.0-0" in capsys.readouterr().err


@pytest.mark.slow
def test_the_pdf_is_the_page_and_the_same_every_time(five_poses):
    pytest.importorskip("weasyprint", exc_type=(ImportError, OSError))
    pdfium = pytest.importorskip("pypdfium2")
    report = document(Dossier(analyze(read_table(five_poses)), MADE))
    report = replace(report, sections=report.sections[:2])
    data = pdf.render(report)
    assert data.startswith(b"%PDF")
    pages = [page.get_textpage().get_text_range() for page in pdfium.PdfDocument(data)]
    assert "Figures" in pages[1]
    assert "Attained places in the XY plane:" in pages[1]  # as wide as the sheet
    report = replace(report, sections=report.sections[:1])
    data = pdf.render(report)
    forget()
    assert pdf.render(report) == data
    assert pdf.render(replace(report, title="another")) != data


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_disk_is_said(tmp_path, capsys):
    (tmp_path / "out.md").symlink_to("/dev/full")
    assert main(["report", str(WARM_UP), "-o", str(tmp_path / "out.md")]) == 74
    assert "cannot be written" in capsys.readouterr().err


def test_outside_a_limit_the_report_is_written_and_the_exit_code_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["report", str(WARM_UP), "--limit", "XY=0.02", "-o", "out.md"]) == 1
    assert "OUTSIDE" in Path("out.md").read_text()
    assert (
        main(["report", str(WARM_UP), "--limit", "XY=9", "--decision", "simple", "-o", "out.md"])
        == 0
    )
    assert "by simple acceptance" in Path("out.md").read_text()


def test_without_a_name_the_report_stands_beside_where_it_is_called(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["report", str(WARM_UP)]) == 0
    assert Path("warm_up.html").exists()
    assert capsys.readouterr().out == "warm_up.html is written\n"


def test_too_few_cycles_for_a_diagnosis_are_said(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    short = tmp_path / "short.csv"
    rows = WARM_UP.read_text().splitlines()
    short.write_text("\n".join(rows[:9]) + "\n")
    assert main(["report", str(short), "--cycles", "4", "-o", "out.md"]) == 0
    assert "Deviations from ISO 9283" in Path("out.md").read_text()


@pytest.mark.parametrize("name", ["fum_scara_table1", "warm_up"])
def test_the_reports_among_the_examples_are_what_the_program_writes(tmp_path, monkeypatch, name):
    """Pictures are compared by their words: another matplotlib draws other paths."""
    (tmp_path / "examples" / "reports").mkdir(parents=True)
    for file in (EXAMPLES / f"{name}.csv", MODEL):
        shutil.copy(file, tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    page = f"examples/reports/{name}.html"
    model = ("--model", "examples/fum_scara.toml")
    assert main(["report", f"examples/{name}.csv", *model, "-o", page]) == 0
    written, kept = Path(page).read_text("utf-8"), (EXAMPLES.parent / page).read_text("utf-8")
    assert without_drawing(written) == without_drawing(kept)


def without_drawing(page):
    return re.sub(r"(<svg[^>]*>.*?</desc>).*?(?=</svg>)", r"\1", page, flags=re.DOTALL)


def test_the_page_of_the_fields_names_every_key():
    text = (EXAMPLES.parent / "docs" / "report.md").read_text("utf-8")
    rows = {row.split("|")[1].strip(): row for row in text.splitlines() if row.startswith("| ")}
    for field, keys in FIELDS.items():
        assert all(f"`{key}`" in rows[field] for key in keys), field


def test_numbers_are_whole_where_somebody_computes_and_rounded_where_somebody_reads(
    tmp_path, monkeypatch
):
    found = make(tmp_path, TABLE_1)
    axis = json.loads(found["json"])["analysis"]["poses"][0]["axes"]["X"]
    low, high = axis["RP_interval"]
    header = ["95 % interval, low", "95 % interval, high"]
    rows = list(csv.reader(io.StringIO(found["csv"].decode())))
    above = next(row for row in rows if row[:2] == ["axis", "mean"])
    below = rows[rows.index(above) :]
    of_x = dict(zip(above, next(row for row in below if row[:1] == ["X"]), strict=True))
    assert [float(of_x[name]) for name in header] == [low, high]
    assert (float(of_x["RP"]), float(of_x["U/RP"])) == (axis["RP"], 2 * axis["uncertainty_ratio"])
    book = [list(row) for row in openpyxl.load_workbook(io.BytesIO(found["xlsx"]))["Report"]]
    above = next(row for row in book if row[1].value == "mean")
    at = {name.value: cell for name, cell in zip(above, book[book.index(above) + 1], strict=False)}
    figures = [at[name].value for name in ("RP", *header)]  # openpyxl writes 16 digits
    assert figures == pytest.approx([axis["RP"], low, high], rel=1e-15)
    assert (at["RP"].number_format, at["U/RP"].number_format) == ("0.000", "0%")
    assert "| 0.014 \\[0.009, 0.029\\] | 0.0175 | 41% |" in found["md"].decode()


def test_a_unit_behind_numbers_has_a_column_of_its_own(tmp_path, monkeypatch):
    found = make(tmp_path, TABLE_1, MODEL)
    rows = list(csv.reader(io.StringIO(found["csv"].decode())))
    ends = ["at the tool 95 % interval, low", "at the tool 95 % interval, high"]
    assert ["", "at the tool", "unit", *ends, "what it is"] in rows
    radial = next(row for row in rows if row[:1] == ["actual, radial (ISO 9283)"])
    figure = json.loads(found["json"])["analysis"]["poses"][0]["XY"]["RP_radial"]
    assert (float(radial[1]), radial[2], radial[-1]) == (figure, "mm", "one-sided scatter")
    shown = "| actual, radial (ISO 9283) | 0.014 mm \\[0.009, 0.022\\] | one-sided scatter |"
    assert shown in found["md"].decode()


def test_the_uncertainty_budget_is_data(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    table = tmp_path / "run.csv"
    table.write_text("# indicator_uncertainty_X: 0.004\n" + WARM_UP.read_text())
    assert main(["report", str(table), "-o", "out.json"]) == 0
    X, Y, *_ = json.loads(Path("out.json").read_text())["uncertainty"]
    u = math.hypot(0.01 / math.sqrt(12), 0.004)
    assert X == {
        "axis": "X", "unit": "mm", "resolution": 0.01,
        "u_resolution": pytest.approx(0.01 / math.sqrt(12)), "u_calibration": 0.004,
        "u": pytest.approx(u), "U": pytest.approx(2 * u),
    }  # fmt: skip
    assert Y["u_calibration"] is None


def test_a_format_is_a_file_of_its_folder():
    assert set(endings()) == {".dfq", *(f".{kind}" for kind in KINDS)}  # AQDEF holds readings
    report = document(Dossier(analyze(read_table(WARM_UP)), MADE))
    for ending in endings():
        render = find_format("report", ending.upper())
        if ending != ".pdf":
            assert isinstance(render(report), bytes)
            assert render(report) == render(report)


def test_the_help_names_every_ending(capsys):
    assert main(["report", "--help"]) == 0
    said = capsys.readouterr().out
    assert [ending for ending in endings() if ending not in said] == []
