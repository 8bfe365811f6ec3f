"""`report --language`: the labels of a report, one file a language."""

import re
from itertools import product

import openpyxl
import pytest

import scara_iso
from scara_iso.commands import main
from scara_iso.reporting import document, known_languages, labels_of
from scara_iso.reporting.languages import in_parts, translated
from scara_iso.reporting.report import SCOPE
from scara_iso.reporting.shared.blocks import Section, Text
from scara_iso.reporting.shared.limits import RULES
from scara_iso.reporting.shared.stated import FIELDS, stated_field
from scara_iso.tables import read_table
from tests.reporting.test_explain import EXAMPLES

TABLE = EXAMPLES / "scatter.csv"
OTHERS = [name for name in known_languages() if name != "en"]
MUST_HAVE = {
    *FIELDS, *RULES.values(), SCOPE,
    "Test report", "pass", "FAIL", "not provable", "limit", "verdict",
    "figure [95 % interval]", "pose",
    "Figures", "Conditions and instruments", "Uncertainty budget", "Appendix", "Raw data",
    "Not stated", "Deviations:", "place, date", "name, signature",
}  # fmt: skip
"""Labels that every file has."""


@pytest.fixture(scope="module")
def english():
    return document(scara_iso.report(TABLE, limits=0.03).dossier)


def test_the_four_languages_are_there():
    assert {"de", "fr", "it", "es"} <= set(OTHERS)


TWO_MEANINGS = {"dirección"}  # address, and direction


@pytest.mark.parametrize("language", known_languages())
@pytest.mark.parametrize("field", FIELDS)
def test_a_table_states_a_field_under_its_name_on_the_page(language, field):
    name = labels_of(language).get(field, field)
    table = f"# unit: mm\n# {name}: abc 12\ncycle,X\n1,0.1\n"
    stated = stated_field(read_table(table.encode()), field)
    assert ("abc 12" in stated) == (name not in TWO_MEANINGS)


@pytest.mark.parametrize("language", OTHERS)
def test_every_language_has_every_label(language):
    labels = labels_of(language)
    assert labels.keys() >= MUST_HAVE
    assert labels.keys() == labels_of("de").keys()
    assert all(labels.values())


@pytest.mark.parametrize("language", OTHERS)
def test_labels_change_and_numbers_stay(language, english):
    told = document(scara_iso.report(TABLE, limits=0.03, language=language).dossier)
    assert told.title != english.title
    for one, other in zip(told.sections, english.sections, strict=True):
        rows = [
            [(b.rows, len(b.header)) for b in section.blocks if hasattr(b, "header")]
            for section in (one, other)
        ]
        assert str(rows[0]).count("Number(") == str(rows[1]).count("Number(")
    text = str(told.sections[0])
    assert labels_of(language)["not provable"] in text
    assert "Decision rule" not in text


@pytest.mark.parametrize("language", OTHERS)
@pytest.mark.parametrize(
    ("name", "limit"),
    [
        ("drift", None),
        *product(("scatter", "warm_up", "three_directions", "five_poses"), (0.01, 1)),
    ],
)
def test_no_sentence_of_page_1_is_of_two_languages(language, name, limit):
    report = scara_iso.report(EXAMPLES / f"{name}.csv", limits=limit, language=language)
    for block in document(report.dossier).sections[0].blocks:
        for text in (getattr(block, "text", ""), getattr(block, "note", "")):
            own = text.replace("a SCARA Robot with Planetary Gearbox", "")
            assert not re.search(r"\b(the|is|are|was|with|count|cycles? read|takes|paper)\b", own)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("NOT PROVABLE with these cycles: X, limit 1 mm; it takes about 370 cycles",
         "NICHT NACHWEISBAR mit diesen Zyklen: X, Grenzwert 1 mm; nötig sind etwa 370 Zyklen"),
        ("Method: a {b} method. 31 cycles read; cycle 1 is discarded; 30 count.",
         "Verfahren: a {b} method. 31 Zyklen gelesen; Zyklus 1 zählt nicht; 30 zählen."),
        ("30 cycles read; all of them count, none was discarded: the standard's own 30 cycles.",
         "30 Zyklen gelesen; alle zählen, keiner wurde verworfen: die 30 Zyklen der Norm."),
        ("PASS SO FAR, parts are not recorded: X, limit 1 mm",
         "BISHER ERFÜLLT, Teile sind nicht aufgenommen: X, Grenzwert 1 mm"),
        ("FAIL: X, limit 1 mm; it takes more than 100000 cycles",
         "NICHT ERFÜLLT: X, Grenzwert 1 mm; nötig sind mehr als 100000 Zyklen"),
        ("Not stated: load, date of issue.", "Nicht angegeben: Last, Ausgabedatum."),
        ("velocity 1000 mm/s (100 %); ambient temperature 20,4 °C",
         "Geschwindigkeit 1000 mm/s (100 %); Umgebungstemperatur 20,4 °C"),
        ("figure and its 95 % interval, of 10 visits in a block, 8 blocks and 9 readings; RP",
         "Kennwert mit 95-%-Intervall, aus 10 Besuchen je Block, 8 Blöcken und 9 Messwerten; RP"),
        ("Not stated: load, address and 20 more, under Conditions and instruments.",
         "Nicht angegeben: Last, Anschrift und 20 weitere, unter Bedingungen und Messmittel."),
    ],
)  # fmt: skip
def test_a_sentence_is_filled_with_its_numbers_and_names(text, said):
    assert in_parts(text, labels_of("de")) == said


def test_a_verdict_is_in_the_language_behind_page_1_too():
    verdict = Text("NOT PROVABLE with these loops: X, limit 1.2 arcmin", "warn")
    report = (Section("", ()), Section("Push test", (verdict,)))
    told = list(translated(report, labels_of("de")))[1].blocks[0]
    assert told.text == "NICHT NACHWEISBAR mit diesen Schleifen: X, Grenzwert 1.2 arcmin"


@pytest.fixture(scope="module")
def whole_test(tmp_path_factory):
    """Return a test in a folder, of which a model states only the poses."""
    folder = tmp_path_factory.mktemp("whole") / "test"
    assert main(["test", "new", str(folder), "--model", str(EXAMPLES / "fum_scara.toml")]) == 0
    gauges = [f"--gauge={axis}=opto-rs232@sim:?pace=0" for axis in "XY"]
    for _ in range(5):
        assert main(["record", str(folder), *gauges, "--trigger", "timer:60"]) == 0
    return folder


@pytest.mark.parametrize("language", OTHERS)
def test_what_a_test_in_a_folder_says_on_page_1_is_in_the_language(language, tmp_path, whole_test):
    """What its own statements say: rated values, the conditions, a planned AP, several poses."""
    page = tmp_path / "page.md"
    assert main(["report", str(whole_test), "-o", str(page), "--language", language]) == 0
    first = page.read_text(encoding="utf-8").split("\n## ")[0]
    said = first.replace("Analysis of a SCARA Robot with Planetary Gearbox", "")
    english = r"\b(rated|warm up|from|of|needs|planned|at [0-9]|with|the|velocity|payload)\b"
    assert not re.findall(english, said)
    assert "AP" in said


def test_an_unknown_language_is_refused_with_the_list(tmp_path, capsys):
    assert main(["report", str(TABLE), "--language", "xx", "-o", str(tmp_path / "r.html")]) == 2
    assert "de, es, fr, it" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_sentence_that_begins_with_no_label_stays_english():
    labels = labels_of("de")
    assert in_parts("X drifted, so the interval of X at P1 does not hold", labels).startswith("X d")
    assert in_parts("FAIL: XY, limit 0.02 mm", labels) == "NICHT ERFÜLLT: XY, Grenzwert 0.02 mm"
    assert in_parts("Not stated: payload, humidity", labels) == "Nicht angegeben: Last, Luftfeuchte"


@pytest.mark.parametrize("language", OTHERS)
def test_raw_data_have_their_sheet_in_every_language(language, tmp_path):
    page = tmp_path / "out.xlsx"
    assert main(["report", str(TABLE), "-o", str(page), "--language", language]) == 0
    rows = list(openpyxl.load_workbook(page)["Raw data"].iter_rows(values_only=True))
    assert len([row for row in rows if isinstance(row[0], int)]) == 31


def test_signature_columns_pages_and_what_is_not_stated_are_in_the_language(tmp_path):
    options = {"limits": 0.03, "language": "de", "metadata": {"authorized_by": "B. Head of Lab"}}
    report = scara_iso.report(TABLE, **options)
    texts = {end: report.write(tmp_path / f"r.{end}").read_text("utf-8") for end in ("csv", "html")}
    assert "Name, Unterschrift: B. Head of Lab" in texts["csv"]
    assert "Nicht angegeben: Berichtsnummer, Labor, Anschrift, Ort der Prüfung, Auf" in texts["csv"]
    assert not re.search(
        r"Not stated: report|, (low|high)\b|\b(unit|counts|verdict)[,\n]", texts["csv"]
    )
    assert 'content: "Seite " counter(page)' in texts["html"]
