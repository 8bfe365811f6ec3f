"""The report that is signed: ISO/IEC 17025 field by field, page 1, amendments, evidence."""

import base64
import io
import json
import re
import sys
import zipfile
from hashlib import sha256

import numpy as np
import openpyxl
import pytest
from once import forget

from scara_iso import UsageError, analyze, read_table, report, simulate
from scara_iso.commands import main
from scara_iso.render.formats import html, md, xlsx
from scara_iso.reporting import Amendment, Dossier, InputFile, Provenance, document
from tests.render.test_report_page import CHROMIUM, DRIVER, browser  # noqa: F401 - a fixture
from tests.reporting.test_report import HOSTILE, MODEL, WARM_UP

MADE = Provenance((InputFile("table", "run.csv", "0123456789"),), "0", "scara-iso report run.csv")
STATED = {
    "report_number": "2026-017",
    "laboratory": "Robot Laboratory",
    "address": "Bench Street 1",
    "location": "Hall 3",
    "customer": "Example GmbH",
    "customer_contact": "a@example.org",
    "robot": "FUM SCARA",
    "serial_number": "4711",
    "item_condition": "run in for 50 h",
    "date_received": "2026-05-08",
    "date": "2026-05-12",
    "date_issued": "2026-05-14",
    "sampling": "one robot of a lot of ten",
    "authorized_by": "Dr. A. Signer",
    "external_provider": "calibration by Another Laboratory",
    "temperature": "20.4 C",
    "payload": "2 kg",
}
WHERE_IT_APPLIES = {"item_condition", "date_received", "sampling", "external_provider"}
WORDS = {
    "robot": "item",
    "location": "place of the test",
    "date": "date of the test",
    "date_issued": "date of issue",
    "customer_contact": "customer's contact",
    "temperature": "ambient temperature",
}
CLAUSES = {
    "7.8.2.1 a": "Test report",
    "7.8.2.1 b name": "Robot Laboratory",
    "7.8.2.1 b address": "Bench Street 1",
    "7.8.2.1 c": "Hall 3",
    "7.8.2.1 d identification": "Test report 2026-017",
    "7.8.2.1 d end": "End of Test report 2026-017",
    "7.8.2.1 e name": "Example GmbH",
    "7.8.2.1 e contact": "a@example.org",
    "7.8.2.1 f": "ISO 9283:1998",
    "7.8.2.1 g item": "FUM SCARA",
    "7.8.2.1 g identification": "4711",
    "7.8.2.1 g condition": "run in for 50 h",
    "7.8.2.1 h": "2026-05-08",
    "7.8.2.1 i": "2026-05-12",
    "7.8.2.1 j": "2026-05-14",
    "7.8.2.1 k": "one robot of a lot of ten",
    "7.8.2.1 l": "relate only to the item tested",
    "7.8.2.1 m": "RP XY [mm]",
    "7.8.2.1 n": "1 pose measured; the standard visits P1 to P5",
    "7.8.2.1 o": "Dr. A. Signer",
    "7.8.2.1 p": "Another Laboratory",
    "7.8.2.1 note": "copied in full only",
    "7.8.3.1 a": "20.4 C",
    "7.8.3.1 b": "NOT PROVABLE",
    "7.8.3.1 b rule (7.8.6.2)": "Decision rule: pass where",
    "7.8.3.1 c": "95 % interval",
    "7.8.3.1 d (7.8.7)": "Interpretation: ",
}


def table_of(folder, poses, axes=("X", "Y", "Z", "theta"), lines=(), step=None, cycles=31):
    """Write a table of several poses visited in turn; ``step`` names one whose Y slips."""
    rng = np.random.default_rng(9)
    head = ["# unit: mm", "# resolution: 0.001", "# unit_theta: deg", "# resolution_theta: 0.001"]
    rows = []
    for cycle in range(1, cycles + 1):
        for k, pose in enumerate(poses):
            values = k + rng.normal(0, 0.004, len(axes))
            values[1] -= 0.03 * (pose == step and 2 * cycle > cycles - 2)
            rows.append(",".join([pose, str(cycle), *(f"{v:.3f}" for v in values)]))
    path = folder / "poses.csv"
    header = ",".join(("pose", "cycle", *axes))
    path.write_text("\n".join([*head, *lines, header, *rows]) + "\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def stated():
    return report(WARM_UP, metadata=STATED, limits={"XY": 0.04})


@pytest.mark.parametrize("clause", CLAUSES)
def test_the_report_states_each_field_of_17025(stated, clause):
    said = md.render(document(stated.dossier)).decode().replace("\\", "")
    assert CLAUSES[clause] in said.replace("&#64;", "@").replace("&lt;", "<")


@pytest.mark.parametrize("key", sorted(set(STATED) - WHERE_IT_APPLIES))
def test_what_is_not_stated_is_named_in_one_line(key):
    given = {k: v for k, v in STATED.items() if k not in (key, "robot")}
    run = read_table(WARM_UP)
    run = type(run)(run.cycle, run.axes, metadata=given, origin=run.origin)
    page = document(Dossier(analyze(run), MADE)).sections[0]
    (line,) = [
        b.text
        for b in page.blocks
        if getattr(b, "text", "").startswith("Not stated:") and b.text[-1] != "]"
    ]
    assert WORDS.get(key, key.replace("_", " ")) in line


def test_a_person_at_a_terminal_is_told_how_to_state_what_is_missing(tmp_path, monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.setattr(sys, "stderr", shown := Terminal())
    assert main(["report", str(WARM_UP), "-o", str(tmp_path / "r.md")]) == 0
    assert "--meta operator=NAME, or --meta-file FILE.toml" in shown.getvalue()


def test_where_much_is_not_stated_page_1_names_the_first_of_it_and_the_conditions_all():
    run = read_table(WARM_UP)
    run = type(run)(run.cycle, run.axes, origin=run.origin)
    page, *others = document(Dossier(analyze(run), MADE)).sections
    (line,) = [
        b.text
        for b in page.blocks
        if getattr(b, "text", "").startswith("Not stated:") and b.text[-1] != "]"
    ]
    assert len(line) < 150
    held = next(one for one in others if one.heading == "Conditions and instruments")
    assert any("calibration certificate" in getattr(b, "text", "") for b in held.blocks)


def test_the_result_is_pose_by_characteristic_on_one_page(tmp_path):
    path = table_of(tmp_path, [f"P{k}" for k in range(1, 6)])
    analysis = analyze(read_table(path), limits={"XY": 0.02, "Z": 0.05})
    page = document(Dossier(analysis, MADE)).sections[0]
    matrix = next(b for b in page.blocks if getattr(b, "header", ("",))[0] == "pose")
    assert [row[0] for row in matrix.rows] == ["P1", "P2", "P3", "P4", "P5", "limit"]
    at = dict(zip(matrix.header, zip(*matrix.rows, strict=True), strict=True))
    for pose, cell in zip(analysis.poses, at["RP XY [mm]"], strict=False):
        assert (cell.value.value, cell.interval.low.value) == (pose.XY.RP, pose.XY.RP_interval[0])
        assert cell.verdict in ("pass", "not provable", "FAIL")
    assert str(at["RP Z [mm]"][-1]) == "0.05 mm"
    assert str(at["RP_a theta [deg]"][0]).startswith("± ")


def test_a_figure_that_is_no_pass_is_in_the_table_even_if_its_plane_passes(tmp_path):
    path = table_of(tmp_path, ["P1", "P2"], axes=("X", "Y"))
    plain = analyze(read_table(path))
    X = max(pose.axes["X"].RP for pose in plain.poses)
    analysis = analyze(read_table(path), limits={"X": X / 2, "XY": 1.0})
    page = document(Dossier(analysis, MADE)).sections[0]
    matrix = next(b for b in page.blocks if getattr(b, "header", ("",))[0] == "pose")
    column = [row[matrix.header.index("RP X [mm]")] for row in matrix.rows]
    assert "FAIL" in [getattr(cell, "verdict", "") for cell in column]


def test_no_advice_for_a_programmer_is_in_a_customers_report(stated):
    said = md.render(document(stated.dossier)).decode().replace("\\", "")
    said = said[: said.index("| command")]
    for advice in ("# key", "run diagnose", "scara-iso explain", "docs/", "add '#", "--"):
        assert advice not in re.sub(r"\|(?: -{2,}:? \|)+", "", said), advice


def test_what_is_overridden_is_said(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "more.toml").write_text('operator = "A. Muster"\nrobot = "another"\n')
    options = ["--meta-file", "more.toml", "--meta", "robot=a third", "-o", "out.md"]
    assert main(["report", str(WARM_UP), *options]) == 0
    said = (tmp_path / "out.md").read_text()
    assert "robot: a third (in place of FUM SCARA)" in said
    assert "operator: A. Muster" in said
    assert (
        capsys.readouterr().err == "scara-iso: overridden, robot: a third (in place of FUM SCARA)\n"
    )


@pytest.mark.parametrize("key", ["unit", "resolution_X", "simulated", "record_01_struck", "doubts",
                                 "first_cycle", "indicator_uncertainty", "=", ""])  # fmt: skip
def test_what_the_readings_were_made_with_is_not_restated(key):
    with pytest.raises(UsageError):
        report(WARM_UP, metadata={key: "no"})


def test_an_amended_report_says_what_it_supersedes_and_why(stated):
    amended = report(WARM_UP, metadata={"report_number": "2026-018"}, supersedes="2026-017",
                     reason="serial number corrected")  # fmt: skip
    assert amended.dossier.amendment == Amendment("2026-017", "serial number corrected")
    said = md.render(document(amended.dossier)).decode()
    assert "This report supersedes report 2026-017. Reason: serial number corrected" in said


@pytest.mark.parametrize("options", [
    {"supersedes": "2026-017"},
    {"reason": "a mistake"},
    {"supersedes": "2026-017", "reason": " "},
    {"supersedes": "2026-017", "reason": "a mistake"},
    {"supersedes": "7", "reason": "a mistake", "metadata": {"report_number": "7"}},
])  # fmt: skip
def test_an_amendment_needs_both_and_a_number_of_its_own(options):
    with pytest.raises(UsageError):
        report(WARM_UP, **options)


def test_the_evidence_is_whole_and_the_same_every_time(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.csv").write_bytes(WARM_UP.read_bytes())
    (tmp_path / "run.raw.jsonl").write_bytes(b'{"event": "session"}\n')
    (tmp_path / "run.manifest.json").write_bytes(b"{}\n")
    made = report("run.csv", model=MODEL)
    made.archive("a.zip", name="out.json")
    forget()
    made.archive("b.zip", name="out.json")
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()
    with zipfile.ZipFile("a.zip") as packed:
        files = {name: packed.read(name) for name in packed.namelist()}
    evidence = json.loads(files.pop("evidence.json"))
    assert set(files) == {
        "data/run.csv", "data/run.raw.jsonl", "data/run.manifest.json", "data/fum_scara.toml",
        "report/out.json",
    }  # fmt: skip
    assert evidence["sha256"] == {name: sha256(data).hexdigest() for name, data in files.items()}
    assert files["data/run.csv"] == WARM_UP.read_bytes()
    assert json.loads(files["report/out.json"])["files"][0]["name"] == "run.csv"


def test_simulated_readings_are_marked_across_every_page():
    run = simulate(MODEL)
    page = html.render(document(Dossier(analyze(run), MADE))).decode()
    assert '<div class="stamp" aria-hidden="true">SIMULATED</div>' in page
    assert "no robot was measured" in page
    assert (
        "SIMULATED"
        not in html.render(document(Dossier(analyze(read_table(WARM_UP)), MADE))).decode()
    )


def test_struck_readings_stand_with_their_reasons(tmp_path):
    path = table_of(tmp_path, ["P1"], lines=["# record_01_struck: cycle 7, X 9.9: someone leaned"])
    said = md.render(document(Dossier(analyze(read_table(path)), MADE))).decode()
    assert "cycle 7, X 9.9: someone leaned" in said


def test_the_workbook_holds_numbers_and_pictures(tmp_path):
    path = table_of(tmp_path, ["P1", "P2", "P3"])
    analysis = analyze(read_table(path), limits={"XY": 0.05})
    book = openpyxl.load_workbook(io.BytesIO(xlsx.render(document(Dossier(analysis, MADE)))))
    rows = list(book["Report"].iter_rows(values_only=True))
    header = next(row for row in rows if row[:1] == ("pose",))
    first = dict(zip(header, rows[rows.index(header) + 1], strict=True))
    XY = analysis.poses[0].XY
    named = ("RP XY [mm]", "RP XY [mm] 95 % interval, low", "RP XY [mm] 95 % interval, high")
    assert [first[name] for name in named] == pytest.approx([XY.RP, *XY.RP_interval], rel=1e-15)
    assert first["RP XY [mm] verdict"] == "pass"
    assert len(book["Figures"]._images) == 5


def test_hostile_statements_stay_text():
    wild = {key: text for key, text in HOSTILE.items() if key != "temperature"}
    wild["report_number"] = '"; } body { display: none } </style><script>'
    made = report(WARM_UP, metadata=wild, supersedes="<b>", reason="=1+1")
    page = html.render(document(made.dossier)).decode()
    assert page.count("<style") == page.count("</style>") == 1
    assert "<script" not in page
    style = page[page.index("<style>") : page.index("</style>")]
    assert "body { display: none" not in style
    cells = [c for sheet in openpyxl.load_workbook(io.BytesIO(xlsx.render(document(made.dossier))))
             for row in sheet for c in row]  # fmt: skip
    assert {c.data_type for c in cells} <= {"s", "n", "inlineStr"}


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None or DRIVER is None, reason="no chromium and chromium-driver")
def test_page_one_decides_and_six_more_explain(browser, tmp_path):  # noqa: F811
    """Five poses x four axes x three velocities, on A4 and Letter."""
    pdfium = pytest.importorskip("pypdfium2")
    poses = [f"P{k} {v} %" for v in (100, 50, 10) for k in range(1, 6)]
    table = table_of(tmp_path, poses, step=poses[2], cycles=16)  # fewer: the pages are as many
    made = report(table, cycles=16, metadata=STATED, limits={"XY": 0.03})
    page = made.write(tmp_path / "out.html")
    browser.get(page.as_uri())
    for width, height in ((8.27, 11.69), (8.5, 11)):
        size = {"paperWidth": width, "paperHeight": height, "printBackground": True}
        printed = browser.execute_cdp_cmd("Page.printToPDF", size)
        pages = ["".join(one.get_textpage().get_text_range().split())
                 for one in pdfium.PdfDocument(base64.b64decode(printed["data"]))]  # fmt: skip
        assert "name,signature" in pages[0]
        assert "Figures" in pages[1]
        appendix = next(k for k, text in enumerate(pages) if "Appendix:" in text)
        assert appendix <= 7
        for k, text in enumerate(pages, start=1):
            assert f"page{k}/{len(pages)}" in text
            assert "Testreport2026-017" in text
        assert "EndofTestreport2026-017" in pages[-1]


def test_page_1_says_what_all_poses_say_together(tmp_path, rng):
    """A step of the X dial at every pose is one cause, not five."""
    rows = [
        f"P{p},{k},{0.1 + 0.03 * (k > 16) + rng.normal(0, 0.004):.3f},{rng.normal(0, 0.004):.3f}"
        for p in range(1, 6)
        for k in range(1, 32)
    ]
    table = tmp_path / "run.csv"
    table.write_text("\n".join(["# unit: mm", "# resolution: 0.001", "pose,cycle,X,Y", *rows]))
    report(table, to=tmp_path / "r.md")
    page = (tmp_path / "r.md").read_text("utf-8")
    assert "All poses together: step in X alike at every pose. The figures above" in page


def test_a_german_key_on_the_command_line_is_the_field_that_it_is_in_a_table(tmp_path):
    page = report(WARM_UP, metadata={"Kunde": "Meier", "Prüfer": "Ä"}).write(tmp_path / "a.html")
    for key, text in (("customer", "Meier"), ("operator", "Ä")):
        assert re.search(rf"<dt>{key}</dt>\s*<dd>{text}\b", page.read_text("utf-8"))
