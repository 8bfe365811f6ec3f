"""What a file states: used, refused by its name, or (a cover sheet) listed as not used."""

import csv
import re
import shutil

import hypothesis
import numpy as np
import openpyxl
import pytest
from asked import (
    CYCLES,
    HEAD,
    READINGS,
    ask,
    figures,
    given,
    heard,
    names,
    repeatability,
    table,
)
from budget import examples
from hypothesis import strategies as st
from openpyxl.comments import Comment
from openpyxl.styles import Font, PatternFill

from scara_iso import read_table
from scara_iso.base.errors import DataError
from scara_iso.tables.vocabulary.words import WORDS

RP = repeatability(READINGS[1:])
ODD = [0.55 if cycle == 7 else reading for cycle, reading in zip(CYCLES, READINGS, strict=True)]
RP_WITHOUT_7 = repeatability(ODD[1:6] + ODD[7:])
BESIDE = [round(r + 0.3 + 0.001 * (k % 3), 3) for k, r in enumerate(READINGS)]


@pytest.fixture
def path(folder):
    return folder / "run.csv"


# ---- a scale for all values

SCALES = [  # key, value, by which a reading is to be multiplied; None: it can be read two ways
    ("scale", "0.01", 0.01), ("scaling", "0.01", 0.01), ("conversion", "0.01", 0.01),
    ("divisor", "100", 0.01), ("Maßstab", "0.01", 0.01), ("mm_per_count", "0.01", 0.01),
    ("gain", "10", None), ("lever_ratio", "2", None), ("conversion_factor", "0.01", 0.01),
    ("calibration_factor", "0.98", 0.98), ("multiply by", "0.01", 0.01),
    ("mm_per_digit", "0.01", 0.01), ("counts_per_mm", "100", 0.01), ("X_scale", "0.01", 0.01),
    ("scale X", "0.01", 0.01), ("magnification", "10", None), ("amplification", "10", None),
    ("sensitivity", "0.01", None), ("lever ratio", "1:2", None), ("Skalierung", "0.01", 0.01),
    ("Umrechnung", "0.01", 0.01), ("Kalibrierfaktor", "0.98", 0.98), ("Verstärkung", "10", None),
    ("Hebelverhältnis", "2", None), ("Teiler", "100", 0.01), ("échelle", "0.01", 0.01),
    ("facteur", "0.01", 0.01), ("facteur d'échelle", "0.01", 0.01), ("diviseur", "100", 0.01),
    ("scala", "0.01", 0.01), ("fattore di scala", "0.01", 0.01), ("guadagno", "10", None),
    ("escala", "0.01", 0.01), ("factor de escala", "0.01", 0.01), ("ganancia", "10", None),
    ("correction factor", "0.98", 0.98), ("Korrekturfaktor", "0.98", 0.98), ("LSB", "0.01", 0.01),
    ("mm/div", "0.01", 0.01), ("scale_factor", "0.01", 0.01), ("factor", "0.01", 0.01),
    ("multiplier", "0.01", 0.01), ("Faktor", "0.01", 0.01), ("Umrechnungsfaktor", "0.01", 0.01),
    ("Multiplikator", "0.01", 0.01),
]  # fmt: skip


@pytest.mark.parametrize(("key", "value", "factor"), SCALES)
def test_a_scale_is_used_or_refused(key, value, factor, path):
    table(path, {"cycle": CYCLES, "X": READINGS}, [*HEAD, f"# {key}: {value}"])
    heard(path, [key], None if factor is None else {"X": RP * factor})


@pytest.mark.parametrize(
    ("line", "factor"),
    [
        ("Table I (mm x 10^-2)", 0.01),
        ("Table I (mm × 10⁻²)", 0.01),
        ("values x 0.01 mm", 0.01),
        ("Values multiplied by 100", 0.01),
        ("readings, scaled by 0.01", 0.01),
        ("values (scaled by 0.01)", 0.01),
        ("all values in hundredths of a mm", 0.01),
        ("mesures en centièmes de mm", 0.01),
        ("valori in centesimi di mm", 0.01),
        ("readings in 1/100 mm", 0.01),
        ("readings in µm", 0.001),
        ("Messwerte in 1/100 mm", 0.01),
        ("1 digit = 0.01 mm", 0.01),
        ("1 Digit entspricht 0,01 mm", 0.01),
        ("one unit = 10 um", 0.01),
        ("values divided by 100", 0.01),
        ("(x 0.01)", 0.01),
        ("mm/100", 0.01),
        ("(all dimensions in inches)", 25.4),
        ("displayed in µm", 0.001),
        ("valores en micras", 0.001),
        ("en micromètres", 0.001),
    ],
)  # fmt: skip
def test_a_scale_in_a_line_without_a_key_is_used_or_refused(line, factor, path):
    table(path, {"cycle": CYCLES, "X": READINGS}, [*HEAD, f"# {line}"])
    heard(path, [line[:12], "unit"], {"X": RP * factor})


# ---- a unit under another key

UNITS = [
    "X_unit", "X unit", "X.unit", "unitX", "unit-X", "unit(X)", "Unit of X", "dial_unit",
    "indicator_unit", "gauge unit", "reading_unit", "readings_unit", "unit_of_readings",
    "measurement unit", "length unit", "data unit", "engineering unit", "display_unit",
    "output unit", "UoM", "values in", "values_in", "readings are in", "measured in",
    "Längeneinheit", "Einheit der Messwerte", "Angaben in", "unité de mesure", "mesures en",
    "unità", "unità di misura", "valori in", "unidad de medida", "given in", "display", "mode",
    "dimension", "dial reads", "units", "unit X", "unit_X", "unit of measurement", "Einheit",
    "Maßeinheit", "Messeinheit", "Einheit X", "unité", "unité X", "unidad",
]  # fmt: skip


@pytest.mark.parametrize("key", UNITS)
def test_a_unit_is_used_or_refused(key, path):
    table(path, {"cycle": CYCLES, "X": READINGS}, [*HEAD, f"# {key}: um"])
    heard(path, [key, "unit"], {"X": RP / 1000})


# ---- an uncertainty, and its coverage factor

UNCERTAINTIES = [  # key and the standard uncertainties that 0.004 may mean
    ("calibration_uncertainty", (0.004, 0.002)), ("gauge_uncertainty", (0.004, 0.002)),
    ("dial_uncertainty", (0.004, 0.002)), ("measurement_uncertainty", (0.004, 0.002)),
    ("uncertainty", (0.004, 0.002)), ("uncertainty_X", (0.004, 0.002)), ("U95", (0.002,)),
    ("U(k=2)", (0.002,)), ("u_cal", (0.004,)), ("standard_uncertainty", (0.004,)),
    ("expanded_uncertainty", (0.002,)), ("Messunsicherheit", (0.004, 0.002)),
    ("erweiterte Messunsicherheit", (0.002,)), ("Kalibrierunsicherheit", (0.004, 0.002)),
    ("incertitude de mesure", (0.004, 0.002)), ("incertezza", (0.004, 0.002)),
    ("incertidumbre", (0.004, 0.002)), ("indicator_uncertainty", (0.004,)),
    ("indicator uncertainty", (0.004,)),
]  # fmt: skip


def assert_uncertainty(path, words, standard):
    """Assert that u is one of ``standard`` and the dial's rounding, or refused by name."""
    answer = ask("analyze", path, "--json", "--limit", "X=0.013")
    if answer.refused:
        assert names(answer, *words), answer.err
        return
    u = answer.document["poses"][0]["axes"]["X"]["uncertainty"]
    expected = [np.hypot(value, 0.001 / np.sqrt(12)) for value in standard]
    assert any(u == pytest.approx(value, rel=1e-6) for value in expected), f"u = {u} mm"


@pytest.mark.parametrize(("key", "standard"), UNCERTAINTIES)
def test_an_uncertainty_is_used_or_refused(key, standard, path):
    table(path, {"cycle": CYCLES, "X": READINGS}, [*HEAD, f"# {key}: 0.004"])
    assert_uncertainty(path, [key], standard)


@pytest.mark.parametrize(
    "key",
    ["coverage_factor", "coverage factor k", "k", "Erweiterungsfaktor",
     "facteur d'élargissement", "fattore di copertura", "factor de cobertura"],
)  # fmt: skip
def test_a_coverage_factor_halves_or_is_refused(key, path):
    head = [*HEAD, "# indicator_uncertainty: 0.004", f"# {key}: 2"]
    table(path, {"cycle": CYCLES, "X": READINGS}, head)
    assert_uncertainty(path, [key], (0.002,))


# ---- seconds of arc

ARCSECONDS = [round(1 + (reading - 0.5) * 3, 3) for reading in READINGS]
RP_THETA_DEG = repeatability(ARCSECONDS[1:]) / 3600


def theta_table(path, heading="theta", head=(), cell="{}", unit_row=None, x="X [mm]"):
    """Write theta beside X, its unit in the heading, the cells, a row or the head."""
    with path.open("w", newline="", encoding="utf-8") as file:
        file.writelines(f"{line}\n" for line in head)
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["cycle", x, heading])
        if unit_row:
            rows.writerow(unit_row)
        for cycle, reading, angle in zip(CYCLES, READINGS, ARCSECONDS, strict=True):
            rows.writerow([cycle, reading, cell.format(angle)])


@pytest.mark.parametrize(
    "spelling",
    [
        *({"heading": heading} for heading in (
            'theta "', 'theta ["]', 'theta ("', 'theta (")', 'theta_"', 'theta / "', 'theta in "',
            'theta, "', "theta [arcsec]", "theta [″]", "theta ('')",
        )),
        {"cell": '{}"'},
        {"cell": '{} "'},
        {"unit_row": ["", "mm", '"'], "x": "X"},
        {"unit_row": ["", "[mm]", '["]'], "x": "X"},
        {"head": ["# unit: mm", '# unit_theta: "']},
        {"head": ["# unit: mm"], "heading": 'theta ["]'},
    ],
    ids=str,
)  # fmt: skip
def test_seconds_of_arc_are_no_inches(spelling, path):
    theta_table(path, **spelling)
    heard(path, ["theta"], {"X": RP, "theta": RP_THETA_DEG})


# ---- columns that change what a reading is

rng = np.random.default_rng(1)
ZEROS = [round(float(zero), 3) for zero in rng.normal(0.1, 0.01, 31)]
ABOVE_ZERO = [round(zero + reading, 3) for zero, reading in zip(ZEROS, READINGS, strict=True)]


@pytest.mark.parametrize(
    ("zero", "reading"),
    [
        ("X zero", "X reading"), ("X tare", "X"), ("X_zero", "X"), ("zero X", "X"),
        ("zero", "X"), ("tare", "X"), ("X0", "X"), ("X offset", "X"), ("X ref", "X"),
        ("X baseline", "X"), ("X Null", "X"), ("Nullpunkt X", "X"), ("zéro X", "X"),
        ("X before", "X"), ("X initial", "X"), ("X nominal", "X"), ("Sollwert X", "X"),
        ("X_cmd", "X"), ("X correction", "X"), ("Korrektur X", "X"), ("drift correction", "X"),
        ("start reading", "X"), ("ref", "X"), ("reference", "X"), ("Anfangswert", "X"),
        ("valeur initiale", "X"), ("idle", "X"), ("backoff", "X"), ("target", "X"),
        ("X before", "X after"),
    ],
)  # fmt: skip
def test_a_zero_is_used_or_refused(zero, reading, path):
    table(path, {"cycle": CYCLES, zero: ZEROS, reading: ABOVE_ZERO})
    heard(path, [zero, "no header"], {"X": RP})


@pytest.mark.parametrize(("heading", "neutral"), [("scale", 1), ("zero", 0), ("X offset", 0)])
def test_a_column_of_one_value_is_asked_about_where_it_changes_readings(heading, neutral, path):
    for value in (neutral, neutral + 2):
        table(path, {"cycle": CYCLES, heading: [value] * len(CYCLES), "X": READINGS})
        answer = ask("analyze", path, "--json")
        assert answer.refused is (value != neutral)
        assert not answer.refused or names(answer, heading)


SIDES = [cycle % 2 for cycle in CYCLES]
TWO_SIDED = [round(r + 0.012 * side, 3) for r, side in zip(READINGS, SIDES, strict=True)]


@pytest.mark.parametrize(
    "heading",
    ["side", "direction", "approach_side", "flank", "dir", "Seite", "côté", "lato", "lado", "hand",
     "elbow", "config", "CW/CCW", "lefty", "arm configuration", "Drehsinn", "codo", "approach"],
)  # fmt: skip
def test_sides_are_not_pooled_in_silence(heading, path):
    table(path, {"cycle": CYCLES, heading: SIDES, "X": TWO_SIDED})
    answer = ask("analyze", path, "--json")
    said = answer.err if answer.refused else str(answer.document["findings"])
    assert heading in said


@pytest.mark.parametrize("heading", ["side", "direction", "Seite", "approach"])
def test_sides_in_letters_are_refused(heading, path):
    sides = ["left" if side else "right" for side in SIDES]
    table(path, {"cycle": CYCLES, heading: sides, "X": TWO_SIDED})
    answer = ask("analyze", path, "--json")
    assert answer.refused
    assert names(answer, "+1")
    assert not names(answer, "call it comment")


@pytest.mark.parametrize(
    ("heading", "marks"), [("fixture", SIDES), ("shift", [1 + side for side in SIDES]),
                           ("comment", ["cw" if side else "ccw" for side in SIDES])],
)  # fmt: skip
def test_a_column_that_parts_readings_is_named(heading, marks, path):
    table(path, {"cycle": CYCLES, heading: marks, "X": TWO_SIDED})
    said = f"column '{heading}' parts the readings of X"
    assert names(ask("analyze", path), said)
    table(
        path, {"cycle": CYCLES, heading: marks, "X": TWO_SIDED}, [*HEAD, f"# covariates: {heading}"]
    )
    assert not names(ask("analyze", path), said)
    table(path, {"cycle": CYCLES, heading: marks, "X": READINGS})
    assert not names(ask("analyze", path), said)


@pytest.mark.parametrize(("heading", "words"), [("Operator", "AB"), ("comment", ("day", "late"))])
def test_a_condition_in_words_is_traced(heading, words, path):
    scatter = np.random.default_rng(4).normal(0, 0.01, len(READINGS))
    by = np.random.default_rng(5).integers(0, 2, len(READINGS))
    columns = {
        "cycle": CYCLES,
        heading: [words[one] for one in by],
        "X": (scatter + 0.03 * by).round(3),
    }
    table(path, columns, [*HEAD, f"# covariates: {heading.lower()}"])
    answer = ask("diagnose", path, "--json")
    first = answer.document["effects"][0]
    column = first["parameters"]["column"]
    assert (first["effect"], column) == ("covariate", f"{heading} {words[1 - by[0]]}")
    assert not names(ask("analyze", path), "not used")


def test_a_zero_is_asked_about_at_each_pose(path):
    visits = [(cycle, pose) for cycle in range(31) for pose in range(3)]
    zeros = np.random.default_rng(2).normal(0.1, 0.01, len(visits)).round(3)
    readings = [READINGS[cycle] + pose for cycle, pose in visits] + zeros
    columns = {
        "cycle": [1 + cycle for cycle, _ in visits],
        "pose": [f"P{1 + pose}" for _, pose in visits],
        "idle": zeros,
        "X": readings.round(3),
    }
    table(path, columns)
    answer = ask("analyze", path)
    assert answer.refused
    assert names(answer, "follows column 'idle' one to one")


@pytest.mark.parametrize(
    ("heading", "values", "head"),
    [
        ("idle", ZEROS, ["# covariates: idle"]),
        ("force_N", ZEROS, []),
        ("hours", [round(0.5 + 0.001 * cycle, 3) for cycle in CYCLES], []),
        ("idle", ZEROS[::-1], []),
    ],
    ids=["a stated condition", "a force", "what rises all along", "what is not followed"],
)
def test_a_column_of_no_zero_is_a_covariate(heading, values, head, path):
    readings = [round(value + reading, 3) for value, reading in zip(values, READINGS, strict=True)]
    readings = ABOVE_ZERO if values == ZEROS[::-1] else readings
    table(path, {"cycle": CYCLES, heading: values, "X": readings}, [*HEAD, *head])
    assert heading in read_table(path).covariates


@pytest.mark.parametrize(
    ("heading", "axis"),
    [
        ("X x10", "X"),
        ("Z abs", "Z"),
        ("-X", "X"),
        ("X1", "X"),
        ("X_um_avg", "X"),
        ("theta2", "theta"),
    ],
)
def test_a_column_named_after_an_axis_that_is_not_there_is_no_covariate(heading, axis, path):
    other = {"X": "Y"}.get(axis, "X")
    table(path, {"cycle": CYCLES, other: READINGS, heading: BESIDE})
    answer = ask("analyze", path, "--json")
    assert answer.refused
    assert names(answer, f"begins as the axis {axis}, which is not there")


@pytest.mark.parametrize("heading", ["unit", "Einheit", "unité"])
@pytest.mark.parametrize("cell", ["um", "0.01"])
@pytest.mark.parametrize("head", [HEAD, []])
def test_a_column_of_units_is_neither_a_covariate_nor_a_comment(heading, cell, head, path):
    table(path, {"cycle": CYCLES, "X": READINGS, heading: [cell] * len(CYCLES)}, head)
    answer = ask("analyze", path, "--json")
    assert answer.refused
    assert names(answer, "write the unit above the header")
    assert not names(answer, "call it comment")


@pytest.mark.parametrize("heading", ["X raw", "X_corrected", "X deviation"])
def test_of_two_columns_of_one_axis_one_is_to_be_left(heading, path):
    beside = [round(1.02 * reading, 4) for reading in READINGS]
    table(path, {"cycle": CYCLES, "X": READINGS, heading: beside})
    answer = ask("analyze", path, "--json")
    assert names(answer, "which of them are the readings? leave one column of readings of X")
    assert not names(answer, "zero")


@pytest.mark.parametrize("heading", ["valid", "ok", "gültig"])
def test_a_column_that_excludes_readings_is_not_to_be_a_comment(heading, path):
    marks = ["no" if cycle == 12 else "yes" for cycle in CYCLES]
    table(path, {"cycle": CYCLES, "X": READINGS, heading: marks})
    answer = ask("analyze", path, "--json")
    assert names(answer, "remove the rows that do not count (--allow-gaps), and the column")
    assert not names(answer, "call it comment")


@pytest.mark.parametrize("marks", [("ok", "nok"), ("yes", "no"), ("1", "0")])
def test_a_remark_in_each_row_that_parts_a_few_from_the_others_is_asked_about(marks, path):
    for at, refused in ((7, True), (1, False)):
        remarks = [marks[cycle == at] for cycle in CYCLES]
        table(path, {"cycle": CYCLES, "X": READINGS, "comment": remarks})
        answer = ask("analyze", path)
        assert answer.refused is refused
        assert names(answer, "do all of them count?" if refused else f"'{marks[1]}')")


def test_an_abscissa_named_after_an_axis_is_a_covariate(path):
    table(path, {"cycle": CYCLES, "Y": READINGS, "X_Value": [0.1 * cycle for cycle in CYCLES]})
    assert ask("analyze", path).code == 0


@pytest.mark.parametrize(
    "heading", ["robot", "Serial no", "machine", "Messuhr Nr", "gauge", "N° de série"]
)
def test_readings_of_several_robots_are_not_taken_together(heading, path):
    numbers = [17 if cycle < 12 else 42 for cycle in CYCLES]
    table(path, {"cycle": CYCLES, "X": READINGS, heading: numbers})
    answer = ask("analyze", path, "--json")
    assert answer.refused
    assert names(answer, "holds 2 numbers: readings of several robots or dials?")
    table(path, {"cycle": CYCLES, "X": READINGS, heading: [17] * len(CYCLES)})
    assert not ask("analyze", path, "--json").refused


@pytest.mark.parametrize("heading", ["machine_load_kg", "robot speed", "gauge humidity"])
def test_a_condition_named_after_a_robot_or_dial_is_a_covariate(heading, path):
    steps = [40 + cycle % 3 for cycle in CYCLES]
    table(path, {"cycle": CYCLES, "X": READINGS, heading: steps})
    assert not ask("analyze", path, "--json").refused


POSES = ((300, 100), (400, -50), (200, 150), (350, 220), (250, -120))


@pytest.mark.parametrize("heading", ["dial", "reading", "indicator", "gauge", "Messuhr"])
def test_coordinates_of_poses_are_no_readings(heading, path):
    visited = [POSES[k % 5] for k in range(30)]
    x, y = ([pose[k] for pose in visited] for k in (0, 1))
    table(path, {"X": x, "Y": y, heading: READINGS[:30]})
    answer = ask("analyze", path, "--json", "--all-count")
    assert answer.refused
    assert names(answer, heading, "coordinates", "parts the readings")


def test_coordinates_of_poses_in_turn_are_refused(path):
    visited = [pose for _ in CYCLES for pose in POSES]
    x, y = ([pose[k] for pose in visited] for k in (0, 1))
    dial = [reading for reading in READINGS for _ in POSES]
    table(path, {"cycle": [c for c in CYCLES for _ in POSES], "X": x, "Y": y, "dial": dial})
    assert ask("analyze", path, "--json").refused


ROLLED = [round((0.999 + 6 * (reading - 0.5)) % 1, 3) for reading in READINGS]


@pytest.mark.parametrize("head", [HEAD, [*HEAD, "# range: 1 mm"]], ids=["bare", "range stated"])
def test_a_dial_that_rolls_over_is_asked_about(head, path):
    table(path, {"cycle": CYCLES, "X": ROLLED}, head)
    heard(
        path,
        ["rolls over", "rolled over", "turn", "range"],
        {"X": repeatability([0.999 + 6 * (reading - 0.5) for reading in READINGS[1:]])},
    )


@pytest.mark.parametrize("numbered", [False, True], ids=["rows only", "numbered on"])
@pytest.mark.parametrize("summary", [np.mean, np.median, np.min, np.max])
def test_a_row_of_figures_at_the_end_is_no_reading(summary, numbered, path):
    columns = {
        name: [*column[:30], round(float(summary(column[:30])), 4)]
        for name, column in {"X": READINGS, "Y": BESIDE}.items()
    }
    table(path, {"cycle": CYCLES, **columns} if numbered else columns)
    answer = ask("analyze", path, "--json")
    assert answer.refused
    assert names(answer, "last row", "line 33", "line 34", "mean", "median", "min", "max")


def test_a_row_of_means_without_a_number_is_refused(path):
    columns = {"X": [*READINGS, 0.5001], "Y": [*BESIDE, 0.8011]}
    table(path, {"cycle": [*CYCLES, ""], **columns})
    assert ask("analyze", path, "--json").refused


@pytest.mark.parametrize("level", [lambda k: k % 3, lambda k: k // 8], ids=["in turn", "in blocks"])
def test_parted_levels_are_never_one_pose(level, path):
    parted = [round(reading + 0.5 * level(k), 3) for k, reading in enumerate(READINGS)]
    table(path, {"cycle": CYCLES, "X": parted})
    answer = ask("analyze", path, "--json")
    assert answer.refused
    assert names(answer, "level", "levels", "pose", "poses")


def test_parted_levels_beside_a_column_are_refused(path):
    parted = [round(reading + 0.5 * (k % 3), 3) for k, reading in enumerate(READINGS)]
    table(path, {"cycle": CYCLES, "station": [k % 3 for k in CYCLES], "X": parted})
    assert ask("analyze", path, "--json").refused


# ---- readings that are struck


@pytest.mark.parametrize(
    "line",
    [
        "excluded cycles: 7", "excluded: 7", "exclude: 7", "struck: 7", "rejected: 7",
        "invalid: 7", "invalid cycles: 7", "not valid: cycle 7", "omitted cycles: 7",
        "discarded: 7", "ignore: 7", "skip: 7", "outliers: 7", "bad cycles: 7",
        "gestrichen: 7", "ungültig: 7", "ausgeschlossen: 7", "Ausreißer: 7", "exclu: 7",
        "escluso: 7", "excluido: 7",
    ],
)  # fmt: skip
def test_excluded_cycles_are_used_or_refused(line, path):
    table(path, {"cycle": CYCLES, "X": ODD}, [*HEAD, f"# {line}"])
    heard(path, [line.partition(":")[0]], {"X": RP_WITHOUT_7})


@pytest.mark.parametrize(
    ("heading", "usual", "struck"),
    [
        ("valid", 1, 0), ("valide", 1, 0), ("gültig", 1, 0), ("ok", 1, 0), ("use", 1, 0),
        ("excluded", 0, 1), ("rejected", 0, 1), ("flag", 0, 1), ("struck", "", "x"),
        ("i.O.", 1, 0), ("n.i.O.", "", "x"), ("error", 0, 1), ("alarm", "", "x"),
        ("result", "pass", "fail"), ("valid", "yes", "no"), ("status", "ok", "void"),
        ("quality", "good", "bad"), ("weight", 1, 0), ("Gewicht", 0, 1),
    ],
)  # fmt: skip
def test_a_column_of_validity_is_used_or_refused(heading, usual, struck, path):
    marks = [struck if cycle == 7 else usual for cycle in CYCLES]
    table(path, {"cycle": CYCLES, "X": ODD, heading: marks})
    heard(path, [heading, "column 3"], {"X": RP_WITHOUT_7})


# ---- workbooks


def hidden_row(sheet):
    sheet.row_dimensions[9].hidden = True


def filtered_row(sheet):
    sheet.auto_filter.ref = "A2:B33"
    sheet.auto_filter.add_filter_column(0, [str(cycle) for cycle in CYCLES if cycle != 7])
    sheet.row_dimensions[9].hidden = True


def struck_row(sheet):
    for cell in sheet[9]:
        cell.font = Font(strike=True)


def struck_cell(sheet):
    sheet["B9"].font = Font(strike=True)


def percent_column(sheet):
    for (cell,) in sheet.iter_rows(min_row=3, min_col=2, max_col=2):
        cell.number_format = "0.0%"


def percent_cell(sheet):
    sheet["B9"].number_format = "0.0%"


def workbook(path, columns, prepare):
    """Write a workbook with a unit above the header, made ready as a hand would."""
    book = openpyxl.Workbook()
    sheet = book.active
    for row in (["unit", "mm"], list(columns), *zip(*columns.values(), strict=True)):
        sheet.append(row)
    prepare(sheet)
    book.save(path)


@pytest.mark.parametrize(
    ("prepare", "words"),
    [
        (hidden_row, ("hidden", "row 9")), (filtered_row, ("hidden", "filtered", "row 9")),
        (struck_row, ("struck", "row 9")), (struck_cell, ("struck", "row 9")),
        (percent_column, ("%", "percent")), (percent_cell, ("%", "percent", "row 9")),
    ],
)  # fmt: skip
def test_a_cell_is_read_as_it_is_shown(prepare, words, folder):
    book = folder / "run.xlsx"
    workbook(book, {"cycle": CYCLES, "X": ODD}, prepare)
    heard(book, words, None if "%" in words else {"X": RP_WITHOUT_7})


@pytest.mark.parametrize(
    ("rows", "said"),
    [([9], ("row 9, coloured unlike the others",)), ([3], ()), (range(3, 34, 2), ())],
)
@pytest.mark.parametrize(
    "style", [{"fill": PatternFill("solid", fgColor="FFFF0000")}, {"font": Font(color="FFFF0000")}]
)
def test_a_few_rows_of_another_colour_are_a_warning_but_the_first(rows, said, style, folder):
    def paint(sheet):
        for row in rows:
            for name, value in style.items():
                setattr(sheet.cell(row, 2), name, value)

    workbook(folder / "run.xlsx", {"cycle": CYCLES, "X": READINGS}, paint)
    assert read_table(folder / "run.xlsx").origin.remarks == said


@pytest.mark.parametrize(
    ("number_format", "shown"),
    [('"x2 "0.000', None), ('"ca. "0.000', None), ('"-"0.000', -1), ("-0.000", -1),
     ('"+"0.000', 1), ("+0.000;-0.000", 1), ("_-* #,##0.000_-", 1), ("[Red]0.000", 1)],
)  # fmt: skip
def test_what_a_format_shows_in_front_of_a_number_is_read(number_format, shown, folder):
    def prepare(sheet):
        for (cell,) in sheet.iter_rows(min_row=3, min_col=2, max_col=2):
            cell.number_format = number_format

    workbook(folder / "run.xlsx", {"cycle": CYCLES, "X": READINGS}, prepare)
    if shown is None:
        with pytest.raises(DataError, match="is not a number"):
            read_table(folder / "run.xlsx")
    else:
        read = read_table(folder / "run.xlsx").axes["X"].readings
        assert np.allclose(read, shown * np.array(READINGS))


def test_numbers_of_cycles_that_a_format_names_are_cycles(folder):
    def prepare(sheet):
        for (cell,) in sheet.iter_rows(min_row=3, max_col=1):
            cell.number_format = '"Zyklus "0'

    workbook(folder / "run.xlsx", {"Zyklus": CYCLES, "X": READINGS}, prepare)
    assert read_table(folder / "run.xlsx").cycle.tolist() == list(CYCLES)


def test_a_statement_of_another_sheet_is_placed_there(folder):
    def cover(sheet):
        sheet.parent.create_sheet("Cover").append(["unit", "um"])

    book = folder / "run.xlsx"
    workbook(book, {"cycle": CYCLES, "X": READINGS}, cover)
    assert names(ask("analyze", book), "and 'um' in another sheet")


@pytest.mark.parametrize(
    ("cell", "remark", "said"),
    [
        ("A1", "really hundredths of mm", None), ("B2", "divide by 10", None),
        ("B2", "old gauge", "row 2: '# old gauge' not used"),
        ("B9", "discarded", None), ("B9", "dial bumped", "row 9: 'dial bumped' beside the table"),
    ],
)  # fmt: skip
def test_a_comment_of_a_cell_is_said_or_refused(cell, remark, said, folder):
    def comment(sheet):
        sheet[cell].comment = Comment(remark, "somebody")

    book = folder / "run.xlsx"
    workbook(book, {"cycle": CYCLES, "X": READINGS}, comment)
    answer = ask("analyze", book)
    assert answer.refused is (said is None)
    assert names(answer, said or remark.removesuffix(" 10"))


def test_a_cell_beside_the_statement_of_a_head_is_named(path):
    rows = (f"{cycle};{reading}" for cycle, reading in zip(CYCLES, READINGS, strict=True))
    path.write_text("\n".join(["unit;mm;;values are too large", "cycle;X", *rows]))
    assert names(ask("analyze", path), "line 1: 'values are too large' not used")


def test_a_hidden_column_is_no_axis_in_silence(folder):
    def hide(sheet):
        sheet.column_dimensions["C"].hidden = True

    book = folder / "run.xlsx"
    workbook(book, {"cycle": CYCLES, "X": READINGS, "Z": BESIDE}, hide)
    assert names(ask("analyze", book, "--full"), "hidden")


def test_a_unit_in_the_format_of_a_number_is_read(folder):
    def show_um(sheet):
        for (cell,) in sheet.iter_rows(min_row=3, min_col=2, max_col=2):
            cell.number_format = '0.000" um"'

    book = folder / "run.xlsx"
    workbook(book, {"cycle": CYCLES, "X": READINGS}, show_um)
    heard(book, ["um"], {"X": RP / 1000})


def test_a_percentage_of_humidity_is_read_as_it_is_shown(folder):
    def show_percent(sheet):
        for (cell,) in sheet.iter_rows(min_row=3, min_col=3, max_col=3):
            cell.number_format = "0%"

    book = folder / "run.xlsx"
    workbook(book, {"cycle": CYCLES, "X": READINGS, "humidity": [0.45] * 31}, show_percent)
    run = read_table(book)
    assert set(run.covariates["humidity"].tolist()) == {45.0}


@pytest.mark.parametrize("stated", ["unit", "resolution"])
def test_a_struck_statement_is_not_used(stated, folder):
    def strike(sheet):
        sheet.insert_rows(1)
        sheet["A1"], sheet["B1"] = stated, "0.01" if stated == "resolution" else "um"
        sheet["B1"].font = Font(strike=True)

    book = folder / "run.xlsx"
    workbook(book, {"cycle": CYCLES, "X": READINGS}, strike)
    assert names(ask("analyze", book, "--json"), "struck through")


def test_a_hidden_sheet_is_no_table_in_silence(folder):
    def hide(sheet):
        other = sheet.parent.create_sheet("Old")
        for row in (["unit", "mm"], ["cycle", "X"], *zip(CYCLES, ODD, strict=True)):
            other.append(row)
        other.sheet_state = "hidden"

    book = folder / "run.xlsx"
    workbook(book, {"cycle": CYCLES, "X": READINGS}, hide)
    answer = ask("analyze", book, "--full")
    assert names(answer, "'Old' is hidden")
    assert figures(ask("analyze", book, "--json")) == pytest.approx({"X": RP})


@pytest.mark.parametrize(
    ("key", "value"), [("unit", "um"), ("scale", 0.01), ("excluded", "7"), ("U95", 0.004)]
)
def test_a_cover_sheet_that_changes_a_figure_is_refused(key, value, folder):
    def cover(sheet):
        sheet.parent.create_sheet("Cover", 0).append([key, value])

    book = folder / "run.xlsx"
    workbook(book, {"cycle": CYCLES, "X": READINGS}, cover)
    answer = ask("analyze", book, "--json")
    assert answer.refused
    assert names(answer, key)


COVER = {"Customer": "Acme GmbH", "Robot": "FUM SCARA 2", "Date": "2026-03-01"}


@pytest.mark.parametrize(("key", "value"), COVER.items())
def test_a_cover_sheet_is_used_or_listed(key, value, folder):
    book = openpyxl.Workbook()
    cover, readings = book.active, book.create_sheet("Readings")
    cover.title = "Cover"
    for row in (["Test report"], *COVER.items()):
        cover.append(row)
    for row in (["unit", "mm"], ["cycle", "X"], *zip(CYCLES, READINGS, strict=True)):
        readings.append(row)
    path = folder / "run.xlsx"
    book.save(path)
    used = value in str(ask("analyze", path, "--json").document["metadata"].values())
    assert used or names(ask("analyze", path, "--full"), "cover", key)


# ---- other commands


@pytest.mark.parametrize("second", ["P1.csv", "P2.csv"])
def test_the_same_file_twice_is_refused(second, folder):
    first = table(folder / "P1.csv", {"cycle": CYCLES, "X": READINGS})
    if second != first.name:
        shutil.copy(first, folder / second)
    answer = ask("analyze", first, folder / second)
    assert answer.refused
    assert names(answer, "the very readings of")


def test_a_pose_with_the_readings_of_another_is_refused(folder):
    rows = {"pose": ["P1"] * 31 + ["P2"] * 31, "cycle": [*CYCLES, *CYCLES], "X": [*READINGS] * 2}
    answer = ask("analyze", table(folder / "run.csv", rows))
    assert answer.refused
    assert names(answer, "pose P2 holds the very readings of pose P1")
    moved = [*READINGS, *[round(reading + 0.001, 3) for reading in READINGS]]
    assert not ask("analyze", table(folder / "run.csv", {**rows, "X": moved})).refused


@pytest.mark.parametrize(
    ("rows", "options", "advice"),
    [
        (32, (), "say --cycles N for a test of another length, here N = 32; else remove"),
        (31, ("--cycles", "30"), "say --cycles N for a test of another length, here N = 31"),
        (31, ("--first-cycle-discarded",), "leave out --first-cycle-discarded"),
        (29, (), "repeat the missing cycles"),
    ],
)
def test_another_number_of_rows_is_answered_with_what_helps(rows, options, advice, folder):
    readings = [0.5 + 0.001 * (k % 7) + 0.002 * (k % 3) for k in range(rows)]
    path = table(folder / "run.csv", {"cycle": [*range(1, rows + 1)], "X": readings})
    answer = ask("analyze", path, *options)
    assert answer.refused
    assert names(answer, advice)
    if "N = " in advice:
        assert not ask("analyze", path, "--cycles", rows).refused


SENTENCES = ["Anzeige X mal 2 nehmen", "X und Y vertauscht", "Messuhr X ab Zyklus 12 neu genullt"]


@pytest.mark.parametrize("said", [*SENTENCES, "Zyklus 7 ungültig (Stoß am Tisch)"])
@pytest.mark.parametrize("first", ["Roboter: LS6", "Prüfprotokoll"])
def test_a_sentence_of_a_cover_sheet_is_quoted(said, first, folder):
    """Also where the sheet holds a statement that is used."""
    book = openpyxl.Workbook()
    cover, readings = book.active, book.create_sheet("Messung")
    for text in (first, "Auflösung 0,001 mm", said):
        cover.append([text])
    for row in (["unit", "mm"], ["cycle", "X"], *zip(CYCLES, READINGS, strict=True)):
        readings.append(row)
    path = folder / "run.xlsx"
    book.save(path)
    for command in ("analyze", "tables"):
        assert names(ask(command, path), said)
    struck = "remarked-rows" in ask("analyze", path, "--json").out
    assert struck == ("Zyklus" in said)


@pytest.mark.parametrize(
    ("remark", "factor"),
    [
        ("Hinweis: X in 1/100 mm", 0.01),
        ("Bemerkung: alle Werte in µm", 0.001),
        ("Note: values in inch", 25.4),
        ("Achtung: Messwerte in Zoll", 25.4),
        ("Remarque: mesures en micromètres", 0.001),
        ("Note: lever ratio 2:1", None),
        ("Note: raw counts, 1 count = 0.5 um", None),
        ("Kalibrierschein: DKD 123, U = 1,2 µm (k = 2)", None),
        ("Certificate: K-17; expanded uncertainty 0.0012 mm", None),
    ],
)
def test_what_a_remark_says_of_all_readings_is_used_or_refused(remark, factor, path):
    table(path, {"cycle": CYCLES, "X": READINGS}, [f"# {remark}"])
    heard(path, [remark[-10:], "unit"], None if factor is None else {"X": RP * factor})
    table(path, {"cycle": CYCLES, "X [mm]": READINGS}, [f"# {remark}"])
    assert ask("analyze", path).refused


OF_CYCLES = [
    "Zyklen 7 und 8 nicht auswerten", "Remark: cycles 7-9 do not count", "Nota: ciclo 7 no contado",
    "Hinweis: Zyklus 12 wiederholt", "comment: dial was re-zeroed after cycle 12",
    "Note: drop the first 2 cycles", "Remark: first three cycles are warm-up", "7. Zyklus gestört",
    "Note: only cycles 2-20 valid", "Comment: reading 14: bumped the table", "cycle 31 not counted",
    "all 31 cycles count", "kein Zyklus verworfen", "die ersten drei Messungen zählen nicht",
    "discard first 3", "letzter Zyklus ungültig", "2 outliers removed",
    "les 2 premiers cycles ne comptent pas", "first cycle counts",
]  # fmt: skip


@pytest.mark.parametrize("line", OF_CYCLES)
def test_a_line_that_speaks_of_some_cycles_is_a_warning(line, path):
    table(path, {"cycle": CYCLES, "X": READINGS}, [*HEAD, f"# {line}"])
    assert "remarked-rows" in ask("analyze", path, "--json").out


_OF_ALL = [
    "Note: cycles 31", "31 cycles, the first discarded", "Hinweis: Zyklus 1 verworfen",
    "the first cycle does not count", "31 cycles measured", "Messuhr kalibriert, gültig bis 2027",
]  # fmt: skip
_OF_ANOTHER = ["Auftrag Nr. 12", "Messung 3 von Montag", "recorded in 2 cycles a minute"]


@pytest.mark.parametrize("line", [*_OF_ALL, *_OF_ANOTHER])
def test_a_line_of_all_cycles_or_of_another_thing_is_no_warning(line, path):
    table(path, {"cycle": CYCLES, "X": READINGS}, [*HEAD, f"# {line}"])
    answer = ask("analyze", path, "--json")
    assert not answer.refused
    assert "remarked-rows" not in answer.out


@pytest.mark.parametrize("key", ["Nicht gewertet", "Nicht werten", "not counted"])
def test_a_key_that_denies_a_number_is_refused(key, path):
    table(path, {"cycle": CYCLES, "X": READINGS}, [*HEAD, f"# {key}: Zyklus 7"])
    assert ask("analyze", path).refused
    table(path, {"cycle": CYCLES, "X": READINGS}, [*HEAD, f"# {key}: keine"])
    assert not ask("analyze", path).refused


def test_a_remark_is_quoted_with_its_words(path):
    table(path, {"cycle": CYCLES, "X": READINGS}, [*HEAD, "# Hinweis: X und Y vertauscht"])
    assert names(ask("analyze", path), "hinweis 'X und Y vertauscht'")


def test_what_is_wrong_on_a_cover_sheet_is_said_once_and_of_its_row(folder):
    book = openpyxl.Workbook()
    cover = book.active
    cover.title = "Deckblatt"
    for row in (["Roboter:", "LS6"], ["Messunsicherheit:", "U = 1,2 µm (k=2)"]):
        cover.append(row)
    for k, pose in enumerate(("P1", "P2")):
        sheet = book.create_sheet(pose)
        rows = [(cycle, reading + k) for cycle, reading in zip(CYCLES, READINGS, strict=True)]
        for row in (["cycle", "X [mm]"], *rows):
            sheet.append(row)
    path = folder / "run.xlsx"
    book.save(path)
    answer = ask("analyze", path)
    assert answer.refused
    assert names(answer, "1 fault", "Deckblatt, row 2", "# indicator_uncertainty: 0.002 mm")
    cover["A2"], cover["B2"] = "indicator_uncertainty", "0.0006 mm"
    book.save(path)
    assert not ask("analyze", path).refused


@pytest.mark.parametrize("line", ["Pose P2", "P2", "Punkt 2", "Messpunkt P2"])
def test_a_line_above_that_names_another_pose_than_its_sheet_is_refused(line, folder):
    """A sheet that was copied, and its line not changed."""
    for above, refused in ((line, True), (line.replace("2", "1"), False)):
        book = openpyxl.Workbook()
        book.remove(book.active)
        for pose, first in (("P1", above), ("P3", "Pose 3")):
            sheet = book.create_sheet(pose)
            rows = [(c, x + int(pose[1])) for c, x in zip(CYCLES, READINGS, strict=True)]
            for row in ([first], ["cycle", "X [mm]"], *rows):
                sheet.append(row)
        path = folder / "run.xlsx"
        book.save(path)
        assert ask("analyze", path).refused == refused


def test_what_was_used_of_a_title_is_not_said_to_be_unused(folder):
    path = folder / "run.csv"
    rows = [f"{c};{1000 * x:.0f}" for c, x in zip(CYCLES, READINGS, strict=True)]
    path.write_text("\n".join(["Werte in 1/1000 mm", "cycle;X", *rows]), encoding="utf-8")
    answer = ask("analyze", path, "--json")
    assert answer.document["poses"][0]["axes"]["X"]["RP"] == pytest.approx(RP, rel=1e-9)
    assert answer.document["notes"] == []


@pytest.mark.parametrize(
    ("heading", "advice"),
    [
        ("Roboter", "save the readings of each as a table of its own"),
        ("Anfahrt", "approach (+1, -1)"),
    ],
)
def test_words_in_every_row_of_another_column_are_answered_with_what_they_may_be(
    heading, advice, folder
):
    path = folder / "run.csv"
    rows = [f"{c};{x};{'AB'[c % 2]}" for c, x in zip(CYCLES, READINGS, strict=True)]
    path.write_text("\n".join([f"cycle;X [mm];{heading}", *rows]))
    answer = ask("analyze", path)
    assert answer.refused
    assert names(answer, advice)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("Nächste Kalibrierung: 03.11.2024", "is past on the day of the test"),
        ("Temp.: 27 °C", "27 °C is outside"),
        ("Last: 2 kg", "2 kg is 40 % of the rated load"),
    ],
)
def test_conditions_in_german_are_compared(line, said, folder):
    path = folder / "run.csv"
    rows = [f"{c};{x}" for c, x in zip(CYCLES, READINGS, strict=True)]
    head = [line, "Datum: 12.03.2026", "max. Nutzlast: 5 kg", "cycle;X [mm]"]
    path.write_text("\n".join([*head, *rows]), encoding="utf-8")
    assert names(ask("analyze", path, "--full"), said)


def test_every_note_of_many_sheets_is_shown_in_full(folder):
    book = openpyxl.Workbook()
    book.remove(book.active)
    for k, pose in enumerate(("P1", "P2", "P3")):
        sheet = book.create_sheet(pose)
        lines = [f"Zeile {n} von {pose}" for n in range(6)]
        rows = [(cycle, reading + k) for cycle, reading in zip(CYCLES, READINGS, strict=True)]
        for row in (*([line] for line in lines), ["unit", "mm"], ["cycle", "X"], *rows):
            sheet.append(row)
    path = folder / "run.xlsx"
    book.save(path)
    assert not names(ask("analyze", path), "Zeile 5 von P3")
    assert names(ask("analyze", path, "--full"), "Zeile 5 von P3")


@pytest.mark.parametrize(
    ("head", "rows", "advice"),
    [
        ("", lambda x, y: f"{x}", "--columns X"),
        ("Zeit;Kanal1;Kanal2\ns;mm;mm\n", lambda x, y: f"12,5;{x};{y}", "--columns -,X,Y"),
        ("", lambda x, y: f"1.250,{x.replace(',', '.')}", "--columns -,X"),
    ],
)
def test_the_columns_proposed_part_no_number_at_its_decimal_comma(head, rows, advice, folder):
    texts = [f"{reading:.3f}".replace(".", ",") for reading in READINGS]
    path = folder / "run.csv"
    path.write_text(head + "".join(f"{rows(x, x)}\n" for x in texts))
    answer = ask("analyze", path)
    assert answer.refused
    assert names(answer, advice)
    read = ask("analyze", path, *advice.split(), "--unit", "mm", "--json")
    axis = read.document["poses"][0]["axes"]["X"]
    assert axis["RP"] == pytest.approx(RP, rel=1e-9)


def test_repetitions_of_an_axis_are_no_other_axes(folder):
    columns = {"Nr.": CYCLES, "X1 [mm]": READINGS, "X2 [mm]": READINGS, "X3 [mm]": READINGS}
    path = folder / "run.csv"
    rows = zip(*columns.values(), strict=True)
    path.write_text("\n".join([";".join(columns), *(";".join(map(str, row)) for row in rows)]))
    answer = ask("analyze", path)
    assert answer.refused
    assert names(answer, "write a row for each reading")
    assert not names(answer, "--columns")


@pytest.mark.parametrize(
    ("unit", "shown", "example"),
    [("um", "{:.0f}", "1"), ("inch", "{:.4f}", "0.0001"), ("mm", "{:.3f}", "0.001")],
)
def test_the_resolution_proposed_is_in_the_unit_of_the_table(unit, shown, example, folder):
    sizes = {"um": 1000, "inch": 1 / 25.4, "mm": 1}
    rows = [f"{k},{shown.format(x * sizes[unit])}" for k, x in zip(CYCLES, READINGS, strict=True)]
    path = folder / "run.csv"
    path.write_text("\n".join([f"cycle,X [{unit}]", *rows]))
    assert names(ask("analyze", path), f"(state it, as --resolution {example})")
    codes = {
        one["code"]
        for one in ask("analyze", path, "--resolution", example, "--json").document["findings"]
    }
    assert not codes & {"resolution-not-stated", "doubtful-resolution"}


def test_temperatures_of_several_poses_are_each_compared(folder):
    for k, (pose, temperature) in enumerate((("P1", "20 °C"), ("P2", "26 °C"))):
        rows = [f"{c};{x + k:.3f}" for c, x in zip(CYCLES, READINGS, strict=True)]
        head = [f"# temperature: {temperature}", "cycle;X [mm]"]
        (folder / f"{pose}.csv").write_text("\n".join([*head, *rows]))
    said = ask("analyze", folder / "P1.csv", folder / "P2.csv", "--full")
    assert names(said, "Temperature[P2] 26 °C is outside")
    assert not names(said, "can be compared")


def test_one_pose_of_thirty_rows_beside_one_of_thirty_one_is_to_be_repeated(folder):
    for k, rows in ((1, 31), (2, 30)):
        lines = [f"{c};{x + k:.3f}" for c, x in zip(CYCLES[:rows], READINGS, strict=False)]
        (folder / f"P{k}.csv").write_text("\n".join(["cycle;X [mm]", *lines]))
    answer = ask("analyze", folder / "P1.csv", folder / "P2.csv")
    assert answer.refused
    assert names(
        answer, "repeat P2, or save each pose as a table of its own and analyze these one by one"
    )


def test_a_force_loop_is_for_the_command_push(folder):
    rows = {"force_N": [50 * (-1) ** k for k in range(31)], "reading": READINGS}
    answer = ask("analyze", table(folder / "run.csv", rows))
    assert answer.refused
    assert names(answer, "push")


def test_an_arm_of_700_metres_is_asked_about():
    gear = ("backlash", "--Im", "2.65e-4", "--IL", "4.749", "--arcmin", "12")
    answer = ask(*gear, "--arm", "700")
    assert answer.refused
    assert names(answer, "--arm")


FIRST_FIELDS = {  # of rows without a header, beside two readings
    "a running integer": lambda k: (k + 1,),
    "an integer that repeats": lambda k: (k % 5 + 1,),
    "a running integer beside one that repeats": lambda k: (k + 1, k % 5 + 1),
}


@pytest.mark.parametrize("fields", FIRST_FIELDS.values(), ids=FIRST_FIELDS)
def test_the_hint_proposes_what_counts_as_cycle_or_pose(fields, path):
    rows = [(*fields(k), READINGS[k], BESIDE[k]) for k in range(31)]
    path.write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n")
    proposed = re.search(r"--columns (\S+)", ask("analyze", path, "--unit", "mm").err)
    given(proposed)
    leading = proposed[1].split(",")[: len(fields(0))]
    assert set(leading) <= {"cycle", "pose"}


# ---- a resolution under another name


@pytest.mark.parametrize(
    "key", ["least count", "smallest division", "graduation value", "Teilung", "apprezzamento",
            "apreciación", "valeur de la graduation"],
)  # fmt: skip
def test_a_resolution_is_used_under_each_name(key, path):
    table(path, {"cycle": CYCLES, "X": READINGS}, ["# unit: mm", f"# {key}: 0.01"])
    assert read_table(path).axes["X"].resolution == 0.01


def test_a_unit_that_is_not_of_the_readings_is_no_statement_of_them(path):
    """A key of the robot may hold a unit; so may any in that of the readings."""
    head = ["# unit: mm", "# display: mm", "# robot units: inch", "# mode: in"]
    table(path, {"cycle": CYCLES, "X": READINGS}, head)
    assert read_table(path).axes["X"].readings.tolist() == READINGS


@pytest.mark.parametrize("heading", ["error", "result", "quality"])
def test_a_column_of_many_values_marks_no_rows(heading, path):
    table(path, {"cycle": CYCLES, "X": READINGS, heading: [k / 10 for k in CYCLES]})
    assert heading in read_table(path).covariates


# ---- what stands beside the table, and in a row's remark


@pytest.mark.parametrize(
    ("text", "factor"),
    [("scale: 0.01", 0.01), ("x 0.01", 0.01), ("values in um", 0.001), ("zero: 0.1", None)],
)  # fmt: skip
def test_a_statement_beside_the_table_is_used_or_refused(text, factor, path):
    table(path, {"cycle": CYCLES, "X": READINGS})
    lines = path.read_text("utf-8").splitlines()
    path.write_text("\n".join([*lines[:5], f"{lines[5]},{text}", *lines[6:]]) + "\n", "utf-8")
    heard(path, [text[:5], "unit"], None if factor is None else {"X": RP * factor})


@pytest.mark.parametrize("text", ["operator: Anna", "unit: mm", "see page 2"])
def test_an_ordinary_text_beside_the_table_is_accepted(text, path):
    table(path, {"cycle": CYCLES, "X": READINGS})
    lines = path.read_text("utf-8").splitlines()
    path.write_text("\n".join([*lines[:5], f"{lines[5]},{text}", *lines[6:]]) + "\n", "utf-8")
    assert read_table(path).axes["X"].readings.tolist() == READINGS


@pytest.mark.parametrize(
    "remark", ["excluded", "struck", "invalid", "Ausreißer", "gestrichen", "exclu", "scartato",
               "anulado", "not valid", "not counted", "does not count", "do not use", "don't use",
               "void", "ungültig", "nicht gezählt", "zählt nicht", "non compté", "no vale",
               "scrapped", "misread", "failed", "n.i.O.", "x"],
)  # fmt: skip
@pytest.mark.parametrize("heading", ["remark", "foo", ""], ids=["remark", "foo", "behind the row"])
def test_a_remark_that_a_row_does_not_count_is_refused(heading, remark, path):
    remarks = [remark if cycle == 7 else "" for cycle in CYCLES]
    table(path, {"cycle": CYCLES, "X": ODD, heading: remarks})
    heard(path, [remark], {"X": RP_WITHOUT_7})


@pytest.mark.parametrize(
    ("cycle", "remark"),
    [(1, "discarded"), (1, "not counted"), (7, "door opened"), (7, "ok"), (7, "no alarm"),
     (7, "no contact with the door"), (7, "valid"), (7, "nothing unusual"), (7, "rebooted")],
)  # fmt: skip
@pytest.mark.parametrize("heading", ["remark", ""], ids=["remark", "behind the row"])
def test_another_remark_and_that_of_the_first_cycle_are_accepted(heading, cycle, remark, path):
    remarks = [remark if k == cycle else "" for k in CYCLES]
    table(path, {"cycle": CYCLES, "X": READINGS, heading: remarks})
    assert read_table(path).axes["X"].readings.tolist() == READINGS


REMARKS = [
    "readings are ten times too large", "cycles 5 and 9 are invalid", "X and Y swapped",
    "Vorzeichen von X gedreht", "Anzeige x 0,1", "erste Messung verworfen",
    "gauge reads half the displacement", "mean of three readings each",
]  # fmt: skip


@pytest.mark.parametrize("command", ["analyze", "diagnose", "compare"])
def test_every_command_names_what_was_not_used(command, path):
    table(path, {"cycle": CYCLES, "X": READINGS}, [*HEAD, "# X and Y swapped", "# flavour: mint"])
    said = ("'# X and Y swapped' not used", "stated and not used: flavour")
    tables = [path] * (2 if command == "compare" else 1)
    answer = ask(command, *tables)
    assert all(names(answer, one) for one in said)
    assert names(ask(command, *tables, "--json"), said[0])


@pytest.mark.parametrize("remark", REMARKS)
def test_a_remark_of_a_head_is_named_as_not_used(remark, path):
    run = read_table(table(path, {"cycle": CYCLES, "X": READINGS}, [*HEAD, f"# {remark}"]))
    assert f"line {len(HEAD) + 1}: '# {remark}' not used" in run.origin.notes


@examples(100)
@hypothesis.given(st.text("abcdefgXYZ0123456789 ,.;äß%()", min_size=1, max_size=70))
def test_no_line_of_a_head_is_passed_over(tmp_path_factory, text):
    text = f"Q{text}".rstrip()
    path = tmp_path_factory.mktemp("head") / "run.csv"
    table(path, {"cycle": CYCLES, "X": READINGS}, [*HEAD, f"# {text}"])
    plain = read_table(table(path.with_name("plain.csv"), {"cycle": CYCLES, "X": READINGS}))
    try:
        run = read_table(path)
    except DataError:
        return
    stated = run.metadata.items() - plain.metadata.items()
    word = re.match(r"\w+", text)[0]
    assert stated or any(word in note for note in run.origin.notes)


@pytest.mark.parametrize("label", sorted(WORDS["footer"]["any"]))
def test_every_summary_below_the_readings_is_not_averaged(label, path):
    table(path, {"cycle": CYCLES, "X": READINGS})
    path.write_text(f"{path.read_text('utf-8')}{label.capitalize()},0.5\n", "utf-8")
    run = read_table(path)
    assert run.axes["X"].readings.tolist() == READINGS
    assert any("not averaged" in note for note in run.origin.notes)


@pytest.mark.parametrize(
    "line",
    ["Note: X, Y in um, Z in mm", "Note: X and Y in um, Z in mm", "Note: X & Y: um",
     "Note: X; Y in um", "Hinweis: X, Y in 1/100 mm"],
)  # fmt: skip
def test_a_unit_of_several_axes_is_of_all_of_them_or_asked_about(line, path):
    table(path, {"cycle": CYCLES, "X": READINGS, "Y": READINGS}, [*HEAD, f"# {line}"])
    with pytest.raises(DataError, match="line 3"):
        read_table(path)


def test_the_size_of_two_dials_is_the_resolution_of_neither_alone(path):
    head = ["# unit: mm", "Dial X, Y: 0.01 mm"]
    table(path, {"cycle": CYCLES, "X": READINGS, "Y": READINGS}, head)
    assert {axis.resolution for axis in read_table(path).axes.values()} == {None}


@pytest.mark.parametrize(
    "line",
    ["Note: dial Y reads double", "Dial Y lever ratio 2:1", "Uhr Y zeigt den doppelten Weg",
     "Nota: il comparatore Y segna il doppio", "Y-Werte halbieren", "Y gain error 3 %",
     "X dial mounted at 30 degrees", "each value is the average of 5 samples",
     "sign of Y inverted"],
)  # fmt: skip
def test_a_line_by_which_readings_may_be_other_sizes_is_a_warning(line, path):
    table(path, {"cycle": CYCLES, "X": READINGS, "Y": READINGS}, [*HEAD, f"# {line}"])
    assert "remarked-rows" in ask("analyze", path, "--json").out


@pytest.mark.parametrize(
    "line",
    ["Repeatability test ISO 9283", "Messuhr: Mitutoyo ID-C112 Nr. 1234", "Humidity 45 %",
     "Velocity: 100 %", "Datum: 20.11.2026 10:30", "RP limit XY 0.02 mm", "Measurement 3 of 5"],
)  # fmt: skip
def test_a_line_of_the_test_is_no_warning(line, path):
    table(path, {"cycle": CYCLES, "X": READINGS, "Y": READINGS}, [*HEAD, f"# {line}"])
    assert "remarked-rows" not in ask("analyze", path, "--json").out
