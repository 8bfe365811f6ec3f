"""What a file states in words: judged alike wherever it stands, in any language."""

import io

import openpyxl
import pytest
from openpyxl.comments import Comment

from scara_iso.base.errors import DataError
from scara_iso.tables import read_table

READINGS = [(0.1 + 0.001 * (k * 7 % 11), 0.2 + 0.001 * (k * 5 % 9)) for k in range(31)]
ROWS = "".join(f"{k};{x:.3f};{y:.3f}\n" for k, (x, y) in enumerate(READINGS, 1))
HEAD = "unit: mm\nresolution: 0.001 mm\n"


def read(line, *, head=HEAD):
    """Return the run of a table with a line of words above its header."""
    return read_table(f"{head}{line}\nNr;X;Y\n{ROWS}".encode())


def is_said(line, **head):
    """Say whether a line is a fault, or a warning that quotes it."""
    try:
        return any(line[:8] in remark for remark in read(line, **head).origin.remarks)
    except DataError as fault:
        return line[:8] in fault.what


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
     "REPETIBILIDAD Y PRECISION DEL ROBOT", "Messuhr X: Mahr 1086 links", "Messungen in X und Y",
     "Dial gauges on X and Y", "Pose P1: X 250, Y 100", "Robot base, X forward",
     "Typ X"],
)  # fmt: skip
def test_coordinates_and_names_of_axes_are_no_warning(line):
    assert not read(line).origin.remarks
