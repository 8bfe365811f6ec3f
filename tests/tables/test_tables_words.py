"""What a file states in words: judged alike wherever it stands, in any language."""

import io
import re

import openpyxl
import pytest
from openpyxl.comments import Comment

from scara_iso.base.errors import DataError
from scara_iso.tables import read_table, write_table
from scara_iso.tables.vocabulary.sentences import says_that_all_count

READINGS = [(0.1 + 0.001 * (k * 7 % 11), 0.2 + 0.001 * (k * 5 % 9)) for k in range(31)]
ROWS = "".join(f"{k};{x:.3f};{y:.3f}\n" for k, (x, y) in enumerate(READINGS, 1))
HEAD = "unit: mm\nresolution: 0.001 mm\n"


def read(line, *, head=HEAD):
    """Return the run of a table with a line of words above its header."""
    return read_table(f"{head}{line}\nNr;X;Y\n{ROWS}".encode())


def is_said(line, **head):
    """Say whether a line is a fault, or a warning that quotes it."""
    begin = line.strip("# ")[:8]
    try:
        return any(begin in remark for remark in read(line, **head).origin.remarks)
    except DataError as fault:
        return begin in str(fault)


def _in_a_text(head, names, below):
    rows = ROWS.replace("\n", f"{';' * names.count(';')}\n")
    return f"{HEAD}{head}Nr;X;Y{names}\n{rows}{below}".encode()


def _in_a_workbook(place, text):
    book = openpyxl.Workbook()
    sheet = book.active
    for row in (["unit: mm"], ["resolution: 0.001 mm"], ["Nr", "X", "Y"]):
        sheet.append(row)
    for k, row in enumerate(READINGS, 1):
        sheet.append([k, *row])
    if place == "a cell's comment":
        sheet["B3"].comment = Comment(text, "somebody")
    elif place == "the page's header":
        sheet.oddHeader.center.text = text
    elif place == "another sheet":
        book.create_sheet("Info")["A1"] = text
    else:
        sheet[place] = text
    file = io.BytesIO()
    book.save(file)
    return file.getvalue()


def everywhere(text):
    """Yield what a table says with a text in each place, None where it is refused."""
    data = [
        _in_a_text(f"{text}\n", "", ""), _in_a_text("", f";;{text}", ""),
        _in_a_text("", "", f"{text}\n"),
        *(_in_a_workbook(place, text) for place in (
            "A37", "E3", "E9", "a cell's comment", "the page's header", "another sheet")),
    ]  # fmt: skip
    for one in data:
        try:
            yield read_table(one).origin
        except DataError:
            yield None


@pytest.mark.parametrize(
    "text",
    ["lever ratio 2:1", "Hebelübersetzung 2:1", "rapport de levier 2:1", "Rapporto leva 2:1",
     "lever ratio 2 : 1", "Alle Werte in Hundertstel", "Tutte le letture in centesimi",
     "Toutes les valeurs en centièmes", "readings in tenths", "Readings in 1/100 mm"],
)  # fmt: skip
def test_what_makes_readings_another_size_is_refused_wherever_it_stands(text):
    assert not any(everywhere(text))


@pytest.mark.parametrize(
    "text", ["relación de palanca: 2:1", "Przełożenie 5:1", "Zyklus 7 wiederholt"]
)
def test_what_may_make_readings_others_is_a_warning_wherever_it_stands(text):
    for origin in everywhere(text):
        assert any(text in remark for remark in origin.remarks)


@pytest.mark.parametrize("text", ["Messuhr zeigt doppelt", "X und Y vertauscht"])
def test_a_sentence_of_all_readings_is_a_warning_but_on_another_sheet(text):
    *here, other = everywhere(text)
    assert all(any(text in remark for remark in origin.remarks) for origin in here)
    assert any(text in note for note in other.notes)


@pytest.mark.parametrize("text", ["Kühlung an", "Seite 1 von 2", "Pose 1", "Maschine 3, Halle 4"])
def test_harmless_words_are_no_warning_wherever_they_stand(text):
    for k, origin in enumerate(everywhere(text)):
        assert k == 5 or not origin.remarks  # what stands beside one row is a remark of it


@pytest.mark.parametrize(
    "line",
    ["Uhrzeit 14:30", "Start 9:30", "Getriebe 1:50", "Zeichnung 1:2", "Norm ISO 9283:1998",
     "Gear ratio 1:20"],
)  # fmt: skip
def test_a_time_and_the_ratio_of_a_drawing_or_gear_are_no_warning(line):
    run = read(line)
    assert not run.origin.remarks
    assert any(line in note for note in run.origin.notes)


@pytest.mark.parametrize(
    "line",
    ["X e Y scambiati", "X和Y列对调了", "X ist in Wirklichkeit Y", "sign of Y reversed",
     "Vorzeichen von Y umgekehrt", "Signo de Y al revés", "Hinweis: Y ist eigentlich X"],
)  # fmt: skip
def test_a_sentence_that_names_an_axis_is_a_warning_in_any_language(line):
    assert is_said(line)


@pytest.mark.parametrize(
    "line",
    ["Position 3 (X=250, Y=100)", "X = Länge, Y = Breite", "Achsen X, Y und Z", "RP XY 0,02 mm",
     "Messuhr X: Mahr 1086 links", "Messungen in X und Y",
     "Dial gauges on X and Y", "Pose P1: X 250, Y 100", "Robot base, X forward",
     "Typ X"],
)  # fmt: skip
def test_coordinates_and_names_of_axes_are_no_warning(line):
    assert not read(line).origin.remarks


@pytest.mark.parametrize(
    "line",
    ["Mnożnik: 10", "Fator: 10", "倍率: 10", "系数: 10", "Korrektur: -0,002",
     "Correzione: 0,002 mm", "Correction: -0.002", "Korekta: 0,001 mm", "Versatz Tisch: 3 µm",
     "Vlag: +0,004"],
)  # fmt: skip
def test_a_number_that_may_be_a_factor_or_a_correction_is_said(line):
    assert is_said(line)


@pytest.mark.parametrize(
    "line",
    ["Pierwszy cykl usunięty", "1回目は除外済み", "第一次循环已删除", "Eerste cyclus verwijderd",
     "Första cykeln borttagen", "Primeiro ciclo removido", "mean of 3 readings",
     "Mittelwert aus 3 Ablesungen", "moyenne de 3 lectures", "moving average applied",
     "Werte geglättet", "Filter: moving average 5", "移動平均あり", "Valori anomali eliminati",
     "best 31 of 50 cycles", "nur jeder zweite Wert notiert",
     "dial re-zeroed at half time", "Messuhr neu genullt", "Messung 7: Tisch angestoßen",
     "Rote Werte nicht verwenden", "gelb markierte Werte nicht auswerten",
     "values after subtracting the mean"],
)  # fmt: skip
def test_words_of_selected_or_changed_readings_are_said(line):
    assert is_said(line)
    assert is_said(f"# {line}")


@pytest.mark.parametrize(
    "line",
    ["Umidità: 45 %", "温度: 20.5 ℃", "Norm: ISO 9283, Abschnitt 7.2", "検査報告書 第12号",
     "Mätklocka: Mitutoyo ID-H 0,001 mm", "Protokół badania nr 12/2026", "Page 31 of 40",
     "No anomalies", "Cell 3, 2 shifts, line 14", "Mean load, temperature 23 °C",
     "Dial gauge zeroed before the test"],
)  # fmt: skip
def test_ordinary_lines_of_a_form_are_no_warning(line):
    assert not read(line).origin.remarks


@pytest.mark.parametrize(
    "line",
    ["All readings valid", "no reading was excluded", "No outliers removed",
     "keine Ausreißer entfernt"],
)  # fmt: skip
def test_what_takes_nothing_out_is_no_warning(line):
    assert not read(line).origin.remarks


@pytest.mark.parametrize(
    "line",
    ["All readings except one valid", "no readings valid", "No outliers removed: cycle 7",
     "Alle Messwerte außer dem letzten gültig", "kein Zyklus verworfen", "all readings rejected"],
)  # fmt: skip
def test_what_takes_something_out_is_said_beside_all_and_none(line):
    assert is_said(line)


@pytest.mark.parametrize("line", ["Resolução: 0,001 mm", "分解能: 0.001 mm", "Stapje: 1 µm"])
def test_a_length_that_is_the_step_of_the_readings_is_no_warning(line):
    assert not read(line, head="unit: mm\n").origin.remarks
    assert read(line.replace("1", "5"), head="unit: mm\n").origin.remarks


@pytest.mark.parametrize("line", ["first cycle not removed", "erster Zyklus nicht entfernt"])
def test_a_first_cycle_that_is_not_gone_is_not_refused(line):
    assert len(read(line)) == 31


@pytest.mark.parametrize(
    ("heading", "factor"),
    [("X [mm/100];Y [mm/100]", 0.01), ("X (1/100mm);Y (1/100mm)", 0.01), ("X [мм];Y [мм]", 1),
     ('X [1/1000"];Y [1/1000"]', 0.0254), ("X [hundredths mm];Y [hundredths mm]", 0.01),
     ("X坐标(mm);Y坐标(mm)", 1), ("偏差X(mm);偏差Y(mm)", 1)],
)  # fmt: skip
def test_other_spellings_of_units_and_axes_are_read(heading, factor):
    run = read_table(f"Nr;{heading}\n{ROWS}".encode())
    assert run.axes["Y"].readings[0] == pytest.approx(READINGS[0][1] * factor)


@pytest.mark.parametrize("heading", ["Belastung (kg)", "Carico [kg]", "Zuladung [kg]"])
def test_a_column_of_loads_is_the_payload(heading):
    rows = ROWS.replace("\n", ";2,5\n").replace(".", ",")
    run = read_table(f"Nr;X [mm];Y [mm];{heading}\n{rows}".encode())
    assert run.covariates["payload_kg"].tolist() == [2.5] * 31


@pytest.mark.parametrize(
    "text",
    ["alle Werte verworfen", "alle Werte gestrichen", "alle Werte ungültig", "all valid: no"],
)
def test_all_readings_that_are_discarded_are_no_clean_form(text):
    assert not says_that_all_count(text)


@pytest.mark.parametrize(
    "line",
    ["All readings but the last are valid", "All but the last valid", "all valid but one",
     "Nothing removed but the last", "last value omitted", "The last is void",
     "The last reading is not valid", "Alle Werte gültig ab Mittag",
     "Only the last reading counts"],
)  # fmt: skip
def test_what_takes_some_readings_away_is_never_quiet(line):
    assert is_said(line)


@pytest.mark.parametrize(
    "line", ["All readings valid", "max. Last 5 kg", "Last service 2025", "Last: 5 kg",
             "Last calibration: 2025-03-01", "Load 2 kg", "Kalibrierung gültig: ja",
             "First used 2023", "Zuletzt verwendet 2025", "Certificate valid until 12/2027",
             "Dial X: Mitutoyo ID-C112, valid until 2027-03", "Indicators used: X and Y",
             "Verwendete Messuhren: X und Y", "certificate: X 1234, valid to 2027-03",
             "Last calibration valid until 2027", "letzte Kalibrierung gültig",
             "Werte P1 bis P5", "Auswertung P1 bis P5"]
)  # fmt: skip
def test_what_takes_no_reading_away_is_quiet(line):
    assert not read(line).origin.remarks


POSES = "".join(
    f"P{k};{c};{x + k:.3f};{y:.3f}\n" for k in range(1, 6) for c, (x, y) in enumerate(READINGS, 1)
)


def of_poses(line):
    return read_table(f"{HEAD}{line}\nPose;Nr;X;Y\n{POSES}".encode()).origin


@pytest.mark.parametrize(
    "line",
    ["pose P5 not valid, robot was hit", "Hinweis: P3 mit 50 % Last", "P3 à 50 % de charge",
     "note: pose 2 with the new dial", "# P4: cover open"],
)  # fmt: skip
def test_a_line_that_names_some_of_the_poses_is_a_warning_in_any_words(line):
    assert any(line.strip("# ") in remark for remark in of_poses(line).remarks)


@pytest.mark.parametrize(
    "line",
    ["Poses P1 to P5", "P1..P5", "# order: P5 P4 P3 P2 P1", "# operator[P3]: Smith", "P1-P5",
     "# P1-5", "# P1...5", "# Pose 1 - 5", "# Pose 1 to pose 5", "# P1, ..., P5", "# P1 thru P5",
     "# P1 -> P5", "# P1 → P5", "# P5 to P1"],
)  # fmt: skip
def test_a_line_that_names_all_poses_or_what_one_is_known_to_state_is_quiet(line):
    assert not of_poses(line).remarks


@pytest.mark.parametrize(
    "line",
    ["X ignorieren", "Lauf 3: Anschlag", "Run 3: hit", "1 div = 0.01 mm", "pose P5 not valid"],
)
def test_a_line_that_names_an_axis_a_cycle_or_a_division_is_said(line):
    assert is_said(line)


def test_words_between_readings_are_a_warning_which_the_table_made_of_it_keeps():
    rows = ROWS.splitlines()
    text = "\n".join([f"{HEAD}Nr;X;Y", *rows[:15], "# neue Messuhr ab hier", *rows[15:], ""])
    run = read_table(text.encode())
    assert [one.partition(" '")[2] for one in run.origin.remarks] == ["neue Messuhr ab hier'"]
    assert read_table(write_table(run).encode()).origin.remarks == run.origin.remarks
    dated = text.replace("neue Messuhr ab hier", "2026-03-12")
    assert not read_table(dated.encode()).origin.remarks


def test_a_resolution_that_is_not_used_is_advised_in_its_own_size():
    notes = read("Graduation of the dial 0.01 mm, values are graduations", head="unit: mm\n")
    assert any(note.endswith("'resolution: 0.01 mm'") for note in notes.origin.notes)


def test_a_line_that_leaves_an_axis_out_is_quoted_as_it_stands_and_its_column_to_be_removed():
    with pytest.raises(DataError, match="'Ignore the Y column', which") as refused:
        read("Ignore the Y column")
    assert refused.value.remedy == "remove the columns that do not count, and leave this out"
    with pytest.raises(DataError, match="'excluded X: 5', which") as refused:
        read("excluded X: 5")
    assert "remove the rows" in refused.value.remedy


@pytest.mark.parametrize("heading", ["zählt", "Gültig", "gewertet"])
def test_the_advice_on_a_column_that_says_what_counts_loses_no_exclusion(heading):
    rows = "".join(f"{row};{'nein' if k == 4 else 'ja'}\n" for k, row in enumerate(ROWS.split()))
    with pytest.raises(DataError) as refused:
        read_table(f"{HEAD}Nr;X;Y;{heading}\n{rows}".encode())
    assert refused.value.remedy.startswith("remove the rows that do not count")


@pytest.mark.parametrize(
    ("heading", "cell"), [("Status", "OK"), ("Flag", "ok"), ("OK", "x"), ("Gültig", "x")]
)
def test_a_column_that_says_of_every_row_that_it_counts_is_no_fault(heading, cell):
    rows = "".join(f"{row};{cell}\n" for row in ROWS.split())
    assert len(read_table(f"{HEAD}Nr;X;Y;{heading}\n{rows}".encode())) == len(READINGS)


@pytest.mark.parametrize(
    ("heading", "cell"), [("Status", "fail"), ("OK", "no"), ("excluded", "yes"), ("Status", "void")]
)
def test_a_column_that_says_of_every_row_that_it_does_not_count_is_a_fault(heading, cell):
    rows = "".join(f"{row};{cell}\n" for row in ROWS.split())
    with pytest.raises(DataError, match=r"counted|excluded"):
        read_table(f"{HEAD}Nr;X;Y;{heading}\n{rows}".encode())


@pytest.mark.parametrize(
    "line",
    ["Auflösung;0,001 mm;Datum;12.03.2026", "Échelon : 0,001 mm", "Divisione: 0,001 mm"],
)
def test_a_resolution_with_its_unit_is_read_beside_other_cells_and_by_its_other_names(line):
    rows = "".join(f"{k};0,{k + 100}\n" for k in range(1, 32))
    run = read_table(f"{line}\nZyklus;X [mm]\n{rows}".encode())
    assert run.axes["X"].resolution == 0.001


@pytest.mark.parametrize("line", ["MPE: 3 µm", "Fehlergrenze: 3 µm", "Fehlergrenze Messuhr 3 µm"])
def test_a_limit_of_error_of_the_dial_is_to_be_written_as_its_uncertainty(line):
    with pytest.raises(DataError) as refused:
        read(line)
    assert "a limit of error divided by 1.73" in refused.value.remedy


def test_a_number_in_the_row_of_headings_is_said_to_be_what_is_wrong():
    rows = ROWS.replace("\n", ";;\n")
    with pytest.raises(DataError) as refused:
        read_table(f"Nr;X [mm];Y [mm];;Limit;0.02\n{rows}".encode())
    assert "row 1 names an axis, and '0.02' names no column" in refused.value.remedy


@pytest.mark.parametrize(
    "remark",
    ["Messung lief ohne Auffälligkeiten, aber der Wert ist ungültig",
     f"Der Prüfer war da und der Taster lag an{' und alles lief wie sonst' * 3}; ungültig",
     "dial touched, robot ok, reading invalid", "Roboter stand schief, n.i.O.", "bumped, delete"],
)  # fmt: skip
def test_a_remark_of_which_any_clause_voids_its_row_is_refused_and_quoted_whole(remark):
    cells = ("", *[f'"{remark}"' if k == 12 else "" for k in range(1, 31)])
    rows = "".join(map("{};{}\n".format, ROWS.split(), cells))
    with pytest.raises(DataError) as refused:
        read_table(f"{HEAD}Nr;X;Y;Bemerkung\n{rows}".encode())
    assert repr(remark) in str(refused.value)


def test_a_remark_and_a_line_are_quoted_to_their_end_also_by_the_table_made_of_it():
    remark = "Der Prüfer hat hier die Messuhr am Ständer nachgestellt, Taster lag dabei an " * 3
    line = "The dial on Y was replaced at noon by the old one, from cycle 17 on all are doubtful"
    rows = "".join(f"{row};{remark * (k == 12)}\n" for k, row in enumerate(ROWS.split()))
    run = read_table(f"{HEAD}{line}\nNr;X;Y;Bemerkung\n{rows}".encode())
    assert any(remark.strip() in one for one in run.origin.remarks)
    assert any(line in one for one in run.origin.remarks)
    assert any(line in one for one in run.origin.notes)
    assert read_table(write_table(run).encode()).origin.remarks == run.origin.remarks


@pytest.mark.parametrize(
    "line",
    ["readings in inches x 1000", "indicator set to inch", "Dial in inch mode", "Anzeige Zoll",
     "Messuhr zeigt Zoll", "Messuhr auf inch gestellt", "milli-inch", "Note: values in inch mode",
     "Dies ist der Roboter ohne Last, Werte in Zoll/1000", "Werte auf 0,01 Mikron genau"],
)  # fmt: skip
def test_a_line_that_names_another_unit_of_length_is_never_quiet(line):
    assert is_said(line)


@pytest.mark.parametrize("line", ["Gripper 12 inch", "Messuhr in mm", "Approach distance 50 mm"])
def test_a_size_of_a_thing_and_the_own_unit_are_no_warning(line):
    assert not read(line).origin.remarks


@pytest.mark.parametrize(
    "line",
    ["cycle 31 is the mean of the others", "Zyklus 31 geschätzt", "mesure 17 estimée",
     "load changed after 15 cycles", "Run 30 repeated"],
)  # fmt: skip
def test_a_line_that_names_or_counts_cycles_by_a_number_is_a_warning(line):
    assert is_said(line)


@pytest.mark.parametrize("line", ["31 Zyklen je Pose", "30 cycles each"])
def test_as_many_cycles_as_a_pose_has_are_no_warning(line):
    assert not of_poses(line).remarks


@pytest.mark.parametrize(
    "line",
    ["valeurs doublées", "Nullpunkt verschoben", "zero shifted during the test",
     "von links und rechts angefahren", "worst reading left out", "fixture was loose",
     "measured with MAX mode", "Roboter ohne Last, Messuhr war locker"],
)  # fmt: skip
def test_a_clause_of_readings_that_is_not_understood_is_a_warning(line):
    assert is_said(line)


@pytest.mark.parametrize(
    "line",
    ["Messuhr am Stativ montiert", "Digital dial indicator readings", "Werte für Firma Schulz",
     "Mesures du 12 mars", "Data logged with Keyence", "Messung mit Messuhr Mahr", "Fixture no. 7"],
)  # fmt: skip
def test_a_title_with_usual_words_and_names_is_no_warning(line):
    assert not read(line).origin.remarks


@pytest.mark.parametrize(
    "line",
    ["Tisch wackelt", "table got bumped around lunch", "interpolated where missing",
     "order of visits was random", "# divide by two", "low-pass filtered", "copied from old sheet",
     "signe inversé", "Teken omgedraaid", "Znak odwrócony", "Hodnoty vydělit 2", "sorted by size",
     "stół się przesunął", "tafel is verschoven", "tabla yerinden oynadı", "テーブルが動いた",
     "Kommentar: Tisch wurde verschoben", "Nota: reloj flojo", "Uwaga: czujnik luźny",
     "odd cycles from left: even ones were from right", "Vorzeichen: invertiert",
     "Korrektur: +0,002 mm addieren", ";gemittelt;gemittelt", "* suspicious"],
)  # fmt: skip
def test_a_sentence_of_which_nothing_is_known_is_a_warning_in_any_language(line):
    assert is_said(line)


@pytest.mark.parametrize(
    "line",
    ["Annual acceptance test", "Laboratoire de métrologie", "vertraulich",
     "Universität Stuttgart, Institut für Technik", "geprüft am 01.03.2026",
     "Selon norme ISO 9283", "Tested according to ISO 9283", "Klient: firma Nowak",
     "Umgebung: klimatisiert", "Environment: air-conditioned lab", "Zkouška Brno",
     "株式会社田中製作所", "Dateiname: P:\\Messungen\\scara.xlsx",
     "Robot was warmed up"],
)  # fmt: skip
def test_names_dates_and_values_of_few_words_are_no_warning(line):
    assert not read(line).origin.remarks


def test_the_first_line_of_a_file_is_its_title_the_last_is_none():
    rows = f"Nr;X [mm];Y [mm]\n{ROWS}"
    title = read_table(f"Zkouška opakovatelnosti ramene\n\nAuflösung: 0,001 mm\n{rows}".encode())
    assert not title.origin.remarks
    below = read_table(f"{rows}zkouška byla přerušena\n".encode())
    assert len(below.origin.remarks) == 1


@pytest.mark.parametrize("line", ["X is robot Y", "axe X = axe Y du robot", "X -> -Y", "Y ist X"])
def test_a_line_by_which_one_axis_is_another_is_a_warning(line):
    assert is_said(line)


def test_a_formula_of_readings_is_refused():
    with pytest.raises(DataError, match="multiplied by no factor"):
        read("True value = reading / 2")


@pytest.mark.parametrize("line", ["limit 0.008 mm", "max. 0,008 mm zulässig", "RP limit 8 µm"])
def test_a_limit_without_a_colon_is_stated(line):
    size = line.split("mm")[0].split()[-1]
    assert any(size in value for value in read(line).metadata.values())


@pytest.mark.parametrize("word", ["Průměr", "En büyük", "Rozstęp", "最大值"])
@pytest.mark.parametrize("figure", [max, min, lambda x: sum(x) / 31, lambda x: max(x) - min(x)])
def test_a_word_in_any_language_before_figures_of_the_columns_is_a_footer(word, figure):
    x, y = (round(figure(axis), 3) for axis in zip(*READINGS, strict=True))
    run = read_table(f"{HEAD}Nr;X;Y\n{ROWS}{word};{x:.3f};{y:.3f}\n".encode())
    assert len(run) == 31
    with pytest.raises(DataError, match="is not a cycle number"):
        read_table(f"{HEAD}Nr;X;Y\n{ROWS}{word};{x:.3f};{y + 0.05:.3f}\n".encode())


@pytest.mark.parametrize("heading", ["Bewertung", "comment", "Result"])
@pytest.mark.parametrize(("good", "bad"), [("i.O.", "n.i.O."), ("pass", "fail")])
def test_each_row_that_is_marked_as_bad_is_named(heading, good, bad):
    rows = "".join(f"{row};{bad if k in (6, 9) else good}\n" for k, row in enumerate(ROWS.split()))
    with pytest.raises(DataError, match=r"(?s)lines? 10.*line 13|lines 10 to 13") as refused:
        read_table(f"{HEAD}Nr;X;Y;{heading}\n{rows}".encode())
    assert "remove the rows that do not count" in refused.value.remedy


@pytest.mark.parametrize(
    ("robot", "page"),
    [("Škoda dílna č. 3, měření", "cp1250"), ("Őrség, ismétlőképesség", "cp1250"),
     ("Protokół pomiarowy, dokładność", "cp1250"), ("Protokół", "cp1250"),
     ("Prüfstand Süd, Messgröße", "cp1252"), ("Thérèse, relevé à la tête", "cp1252"),
     ("Robô, medições de posição", "cp1252"), ("Mätning på plats, Åre", "cp1252"),
     ("Qualità: è la prova", "cp1252"), ("Măsurări făcute", "cp1250")],
)  # fmt: skip
def test_letters_of_a_language_are_read_in_its_code_page(robot, page):
    run = read_table(f"{HEAD}robot: {robot}\nNr;X;Y\n{ROWS}".encode(page))
    assert run.metadata["robot"] == robot
    assert f"{page}," in run.origin.understood


def test_letters_of_no_one_language_are_said_to_be_in_doubt():
    data = f"{HEAD}robot: Mäßigè Ñandúø\nNr;X;Y\n{ROWS}".encode("cp1252")
    assert "cp1252 (letters in doubt)" in read_table(data).origin.understood


@pytest.mark.parametrize(
    ("line", "advised"),
    [("Incerteza expandida: U = 1,2 µm (k=2)", "0.0006 mm"), ("U(k=3): 0.0015 mm", "0.0005 mm"),
     ("Unsicherheit 3 µm", "0.002 mm")],
)  # fmt: skip
def test_the_advice_on_an_uncertainty_has_the_figure_where_its_factor_is_known(line, advised):
    with pytest.raises(DataError) as refused:
        read(line)
    assert f"'# indicator_uncertainty: {advised}'" in refused.value.remedy


def test_what_another_sheet_says_of_one_axis_is_of_that_alone_and_its_place_is_said():
    book, file = openpyxl.Workbook(), io.BytesIO()
    for row in (["Nr", "X [mm]", "Y [mm]"], *((k, *row) for k, row in enumerate(READINGS, 1))):
        book.active.append(row)
    book.create_sheet("Notizen")["A1"] = "Messuhr Y: Anzeige in 1/100 mm"
    book.save(file)
    with pytest.raises(DataError) as refused:
        read_table(file.getvalue())
    assert "Y: unit mm against 0.01 mm (in another sheet" in str(refused.value)
    assert "X: unit" not in str(refused.value)


def test_a_first_cycle_that_is_gone_is_refused_in_words_that_fit():
    with pytest.raises(DataError, match="entfernt', which is not acted on in these words"):
        read("erster Zyklus bereits entfernt")


def test_a_header_that_names_an_axis_is_not_said_to_name_none():
    book, file = openpyxl.Workbook(), io.BytesIO()
    for row in (["Nr", "X [mm]", "Y [mm]", None, "Limit", 0.02], *map(list, READINGS)):
        book.active.append(row)
    book.save(file)
    with pytest.raises(DataError) as refused:
        read_table(file.getvalue())
    assert "no sheet with a header of names alone" in str(refused.value)
    assert "row 1 names an axis" in refused.value.remedy


@pytest.mark.parametrize(
    "line",
    ["Y: 1/100 mm", "Y-Achse: 1/100 mm", "Messuhr Y: Hundertstel", "Y: hundredths",
     "Y dial: 1/100 mm", "Anzeige: Hundertstel", "Y: µm", "Y: mm/100", "Y: (1/100 mm)"],
)  # fmt: skip
def test_a_unit_of_one_axis_that_readings_are_not_in_is_refused(line):
    unit = re.escape(line.split(": ")[1])
    with pytest.raises(DataError, match=f"line 3: .*{unit}.*taken in mm"):
        read(line)


def test_a_unit_in_the_brackets_of_an_axis_is_refused_too():
    with pytest.raises(DataError, match=r"1/100 mm.*taken in mm"):
        read("Y [1/100 mm]:")


@pytest.mark.parametrize(
    ("line", "matters"),
    [("Y: x10", True), ("Y: -1", True), ("Dial X: 1/1000", True), ("Y: 0.01 mm", True),
     ("Y: Mitutoyo 543", False), ("Y: mm", False), ("Y: 12.5 mm Hub", False)],
)  # fmt: skip
def test_a_number_of_one_axis_that_is_no_name_of_its_dial_is_a_remark(line, matters):
    assert bool(read(line).origin.remarks) == matters
