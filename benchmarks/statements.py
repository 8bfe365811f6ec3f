"""Whether anything that a table states is passed over: keys in five languages, in eleven places.

Every table holds the same 31 readings and one statement that changes the figure: a factor, a unit,
an uncertainty, a zero, struck cycles, or a column of such. The right figure is computed apart, by
eq. 2-6 written here. A table is `used` where that figure comes out, `refused` where reading it
raises, and `passed over` where another figure comes out: of those there may be none.

Prints the table of benchmarks/results/statements.md; ``--write`` puts it there.
``python benchmarks/statements.py --tables 6000 --seed 1``.
"""

from __future__ import annotations

import argparse
import io
import itertools
import random
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import openpyxl

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from page import RESULTS, put  # noqa: E402

from scara_iso import analyze, read_table  # noqa: E402
from scara_iso.base.errors import DataError  # noqa: E402

READINGS = np.round(0.5 + 0.003 * np.random.default_rng(7).normal(size=31), 3).tolist()
ODD = [0.55 if k == 6 else reading for k, reading in enumerate(READINGS)]
ZEROS = np.round(np.random.default_rng(8).normal(0.1, 0.01, 31), 3).tolist()
SIDES = [k % 2 for k in range(31)]
RESOLUTION = 0.001
LANGUAGES = ("English", "German", "French", "Italian", "Spanish")


def repeatability(readings: list[float]) -> float:
    """Return RP by eq. 2-6 of the readings behind the first."""
    used = np.asarray(readings[1:])
    distances = np.abs(used - used.mean())
    return float(distances.mean() + 3 * distances.std(ddof=1))


RP = repeatability(READINGS)
RP_WITHOUT_7 = repeatability(ODD[:6] + ODD[7:])

WORDS = {
    "factor": """
        scale, scale factor, scaling, gain, multiplier, conversion factor, conversion, lever
        ratio, amplification, magnification, calibration factor, multiply by, divisor;
        Faktor, Skalierung, Skalierungsfaktor, Umrechnung, Umrechnungsfaktor, Maßstab,
        Maßstabsfaktor, Verstärkung, Hebelverhältnis, Vergrößerung, Kalibrierfaktor, Teiler;
        facteur, échelle, facteur d'échelle, facteur de conversion, gain, multiplicateur,
        conversion, diviseur, amplification, facteur d'étalonnage;
        fattore, scala, fattore di scala, fattore di conversione, guadagno, moltiplicatore,
        conversione, divisore, amplificazione, fattore di taratura;
        factor, escala, factor de escala, factor de conversión, ganancia, multiplicador,
        conversión, divisor, amplificación, factor de calibración;
    """,
    "equation": """
        1 digit, 1 count, one unit, one tick;
        1 Digit, 1 Einheit, 1 Teilstrich, ein Inkrement;
        1 digit, une unité, 1 pas;
        1 digit, una unità, 1 step;
        1 digit, una unidad, 1 bit;
    """,
    "unit": """
        unit, units, unit of measurement, measurement unit, length unit, display unit,
        values in, readings in, data unit, given in, all dimensions in;
        Einheit, Maßeinheit, Messeinheit, Längeneinheit, Anzeigeeinheit, Werte in, Messwerte
        in, Einheit der Messwerte;
        unité, unités, unité de mesure, unité de longueur, valeurs en, mesures en, unité
        d'affichage, lectures en;
        unità, unità di misura, unità di lunghezza, valori in, misure in, letture in, unità
        di lettura;
        unidad, unidades, unidad de medida, unidad de longitud, valores en, medidas en,
        lecturas en;
    """,
    "uncertainty": """
        uncertainty, measurement uncertainty, calibration uncertainty, expanded uncertainty,
        standard uncertainty, gauge uncertainty, uncertainty of the dial;
        Unsicherheit, Messunsicherheit, Kalibrierunsicherheit, erweiterte Messunsicherheit,
        Standardunsicherheit, Unsicherheit der Messuhr;
        incertitude, incertitude de mesure, incertitude d'étalonnage, incertitude élargie,
        incertitude type, incertitude du comparateur;
        incertezza, incertezza di misura, incertezza di taratura, incertezza estesa,
        incertezza del comparatore;
        incertidumbre, incertidumbre de medida, incertidumbre de calibración, incertidumbre
        expandida, incertidumbre del comparador;
    """,
    "zero": """
        zero, zero offset, offset, tare, zero point, baseline, zero value, zero reading;
        Null, Nullpunkt, Nullwert, Offset, Tara, Nullablesung;
        zéro, décalage, tare, offset, valeur de zéro;
        zero, tara, offset, valore di zero;
        cero, tara, offset, valor de cero;
    """,
    "excluded": """
        excluded, excluded cycles, exclude, struck, rejected, rejected cycles, invalid,
        invalid readings, omitted, omitted cycles, discarded, ignored, skipped, outliers,
        bad cycles, void;
        ausgeschlossen, ausgeschlossene Zyklen, gestrichen, gestrichene Werte, ungültig,
        ungültige Messungen, verworfen, Ausreißer;
        exclu, exclus, cycles exclus, invalide, rejeté, rejetés, omis, valeurs aberrantes,
        rayé;
        escluso, esclusi, cicli esclusi, non valido, scartato, scartati, omesso, annullato;
        excluido, excluidos, ciclos excluidos, no válido, rechazado, rechazados, omitido,
        descartado, anulado;
    """,
    "side": """
        side, direction, approach side, approach direction, flank, hand, elbow, configuration,
        rotation, lefty, cw, left;
        Seite, Richtung, Anfahrrichtung, Anfahrseite, Flanke, Ellbogen, Konfiguration, Drehsinn,
        Drehrichtung, links;
        côté, sens, direction, flanc, direction d'approche, coude, configuration, rotation, gauche;
        lato, direzione, fianco, direzione di avvicinamento, gomito, configurazione, rotazione,
        senso;
        lado, dirección, flanco, dirección de aproximación, codo, configuración, rotación,
        sentido;
    """,
    "validity": """
        valid, ok, use, flag, excluded, rejected, struck, invalid, outlier, error, quality;
        gültig, i.O., n.i.O., Fehler, ungültig, gestrichen, ausgeschlossen, verworfen, Ausreißer;
        valide, exclu, rejeté, invalide, aberrant;
        valido, escluso, scartato, annullato;
        válido, excluido, rechazado, descartado, anulado;
    """,
}
"""Words of each subject, the languages in turn."""
STARTS = """
    start reading, ref, reference, initial, initial value, before, preset, unloaded, idle;
    Startwert, Anfangswert, Referenz, Referenzwert, vorher, Ruhelage;
    référence, valeur initiale, lecture initiale, avant, repos;
    riferimento, valore iniziale, lettura iniziale, prima, riposo;
    referencia, valor inicial, lectura inicial, antes, reposo;
"""
"""What else a column of zeros is called."""
COMPANY = {
    "English": "{}|{} X|X {}|{} of X|{} of the readings|{} of the indicator|indicator {}",
    "German": "{}|{} X|X {}|{} der Messuhr|{} der Messwerte|Messuhr {}|{} (Achse X)",
    "French": "{}|{} X|X {}|{} du comparateur|{} des mesures|{} des lectures",
    "Italian": "{}|{} X|X {}|{} del comparatore|{} delle misure|{} delle letture",
    "Spanish": "{}|{} X|X {}|{} del comparador|{} de las medidas|{} de las lecturas",
}
BLANKS = (" ", " ", "_", "-", "  ")
MARKS = (": ", ":", " = ", "=", " : ", ":\t")
UNITS = {"um": 1e-3, "µm": 1e-3, "inch": 25.4, "0.01 mm": 0.01, "1/100 mm": 0.01, "m": 1e3}
FACTORS = {"0.01": 0.01, "2": None, "0.98": 0.98, "1:2": None, "10": None}
LINES = (
    "head", "form", "cells", "footer", "beside",
    "sheet", "sheet behind", "sheet head", "sheet foot",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Case:
    """A table, where the statement stands in it, and which results are right."""

    subject: str
    language: str
    place: str
    spelt: str
    data: bytes
    right: Callable[[float, float | None], bool]
    """Of RP and the standard uncertainty of X [mm]."""


def rows(columns: dict[str, list[object]]) -> list[list[object]]:
    """Return heading and rows."""
    return [list(columns), *map(list, zip(*columns.values(), strict=True))]


def table(
    place: str, key: str, mark: str, value: str, readings: list[float], *, unit: bool
) -> bytes:
    """Return a table with a statement in a place, as text or as a workbook."""
    body = rows({"cycle": list(range(1, 32)), "X": list(readings)})
    stated = [["unit", "mm"]] if unit else []
    if place.startswith("sheet"):
        book = openpyxl.Workbook()
        sheet = book.active
        if place in ("sheet", "sheet behind"):
            cover = book.create_sheet("Cover", 0 if place == "sheet" else 1)
            cover.append(["Test report"])
            cover.append([key, value])
        above = [[key, value]] if place == "sheet head" else []
        below = [[key, value]] if place == "sheet foot" else []
        for row in [*stated, *above, *body, *below]:
            sheet.append(row)
        file = io.BytesIO()
        book.save(file)
        return file.getvalue()
    if place == "cells":
        lines = [";".join(map(str, row)) for row in [*stated, [key, value], *body]]
        return ("\n".join(lines) + "\n").encode()
    sign = "# " if place == "head" else ""
    head = [f"{sign}unit: mm"] if unit else []
    line = f"{'# ' if place == 'head' else ''}{key}{mark}{value}"
    below = [",".join(map(str, row)) for row in body]
    if place == "beside":
        below[5] += f",{line}"
        return ("\n".join([*head, *below]) + "\n").encode()
    lines = [*head, *below, line] if place == "footer" else [*head, line, *below]
    return ("\n".join(lines) + "\n").encode()


def column(heading: str, values: list[object], readings: list[float]) -> bytes:
    """Return a table with a column beside the readings."""
    found = rows({"cycle": list(range(1, 32)), heading: values, "X": list(readings)})
    return ("# unit: mm\n" + "\n".join(";".join(map(str, row)) for row in found) + "\n").encode()


def is_rp(*right: float | None) -> Callable[[float, float | None], bool]:
    """Return whether RP is one of the right ones; with none of them only a refusal is."""
    known = [one for one in right if one is not None]
    return lambda rp, _: any(np.isclose(rp, one, rtol=1e-6) for one in known)


def is_u(rp: float, u: float | None) -> bool:
    """Say whether RP is the same and 0.004, or half of it, is the uncertainty."""
    return bool(np.isclose(rp, RP)) and u is not None and bool(np.isclose([u, 2 * u], 0.004).any())


def cases(random_: random.Random) -> Iterator[Case]:
    """Yield tables without end."""
    while True:
        subject = random_.choice(list(WORDS))
        k = random_.randrange(len(LANGUAGES))
        language = LANGUAGES[k]
        word = random_.choice(" ".join(WORDS[subject].split()).split(";")[k].strip().split(", "))
        company = random_.choice(COMPANY[language].split("|")) if " in" not in word[-3:] else "{}"
        company = "{}" if word.endswith((" in", " en", " by")) else company
        company = "{}" if subject == "equation" else company
        key = company.format(word).replace(" ", random_.choice(BLANKS))
        key = random_.choice((key, key, key.upper(), key.capitalize()))
        if subject in ("side", "validity") or (subject == "zero" and random_.random() < 0.6):
            others = STARTS.split(";")[k].strip().split(", ")
            other = subject == "zero" and random_.random() < 0.5
            yield of_column(subject, language, random_.choice(others) if other else key, random_)
            continue
        if subject in ("unit", "excluded") and random_.random() < 0.2:
            yield of_unit_row(random_) if subject == "unit" else of_remark(language, word, random_)
            continue
        place, mark = random_.choice(LINES), random_.choice(MARKS)
        readings, value, right = stated(subject, random_)
        unit = subject != "unit" or random_.random() < 0.5
        data = table(place, key, mark, value, readings, unit=unit)
        spelt = f"{key}{mark}{value}"
        yield Case(subject, language, place, spelt, data, right)


def stated(
    subject: str, random_: random.Random
) -> tuple[list[float], str, Callable[[float, float | None], bool]]:
    """Return readings, the value of a statement about them, and what is right."""
    match subject:
        case "factor":
            value, factor = random_.choice(list(FACTORS.items()))
            return READINGS, value, is_rp(None if factor is None else RP * factor)
        case "equation":
            return READINGS, random_.choice(("0.01 mm", "10 um", "0,01 mm")), is_rp(RP * 0.01)
        case "unit":
            value, size = random_.choice(list(UNITS.items()))
            return READINGS, value, is_rp(None if size is None else RP * size)
        case "uncertainty":
            return READINGS, random_.choice(("0.004", "0.004 mm", "4 um")), is_u
        case "zero":
            return READINGS, random_.choice(("0.1", "0.1 mm", "-0.25")), is_rp()
        case _:
            value = random_.choice(("7", "cycle 7", "7, 7", "no. 7"))
            return ODD, value, is_rp(RP_WITHOUT_7)


def of_column(subject: str, language: str, key: str, random_: random.Random) -> Case:
    """Return a table whose column says what its readings are."""
    if subject == "zero":
        above = [round(zero + reading, 3) for zero, reading in zip(ZEROS, READINGS, strict=True)]
        return Case(subject, language, "heading", key, column(key, [*ZEROS], above), is_rp(RP))
    if subject == "side":
        apart = [round(r + 0.012 * side, 3) for r, side in zip(READINGS, SIDES, strict=True)]
        values: list[object] = [*random_.choice((SIDES, [1 - 2 * side for side in SIDES]))]
        return Case(subject, language, "heading", key, column(key, values, apart), is_rp())
    usual, struck = random_.choice(((1, 0), (0, 1), ("", "x"), ("yes", "no"), ("ok", "void")))
    marks = [struck if k == 6 else usual for k in range(31)]
    return Case(subject, language, "heading", key, column(key, marks, ODD), is_rp(RP_WITHOUT_7))


def of_unit_row(random_: random.Random) -> Case:
    """Return a table whose unit stands in a row under the header."""
    value, size = random_.choice(list(UNITS.items()))
    cells = random_.choice((["", value], ["-", f"[{value}]"], ["", f"({value})"]))
    body = rows({"cycle": list(range(1, 32)), "X": [*READINGS]})
    above = random_.choice(([], ["# unit: mm"]))
    lines = [*above, *(";".join(map(str, row)) for row in (body[0], cells, *body[1:]))]
    data = ("\n".join(lines) + "\n").encode()
    return Case("unit", "English", "unit row", value, data, is_rp(RP * size))


def of_remark(language: str, word: str, random_: random.Random) -> Case:
    """Return a table with a remark to cycle 7, in a column of remarks or behind the row."""
    heading = random_.choice(("remark", "Bemerkung", ""))
    marks = [word if k == 6 else "" for k in range(31)]
    body = rows({"cycle": list(range(1, 32)), "X": [*ODD], heading: marks})
    lines = ["# unit: mm", *(";".join(map(str, row)) for row in body)]
    data = ("\n".join(lines) + "\n").encode()
    place = "remark" if heading else "behind a row"
    return Case("excluded", language, place, word, data, is_rp(RP_WITHOUT_7))


def outcome(case: Case) -> str:
    """Return what reading and analysing a table came to."""
    try:
        axis = analyze(read_table(case.data)).poses[0].axes["X"]
        u = read_table(case.data).axes["X"].uncertainty
    except DataError:
        return "refused"
    return "used" if case.right(axis.RP, u) else "passed over"


def counted(found: Counter[tuple[str, str, str]]) -> Iterator[str]:
    """Yield the rows of the table, by subject and place."""
    yield "| what is stated | where | tables | used | refused | passed over |"
    yield "|---|---|---|---|---|---|"
    keys = sorted({key[:2] for key in found})
    for subject, place in keys:
        row = [found[subject, place, one] for one in ("used", "refused", "passed over")]
        yield f"| {subject} | {place} | {sum(row)} | {' | '.join(map(str, row))} |"
    row = [
        sum(n for k, n in found.items() if k[2] == o) for o in ("used", "refused", "passed over")
    ]
    yield f"| all | | {sum(row)} | {' | '.join(map(str, row))} |"


def main() -> None:
    """Count what becomes of the tables; every one that is passed over is printed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tables", type=int, default=6000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", action="store_true")
    asked = parser.parse_args()
    found: Counter[tuple[str, str, str]] = Counter()
    for case in itertools.islice(cases(random.Random(asked.seed)), asked.tables):  # noqa: S311
        came = outcome(case)
        found[case.subject, case.place, came] += 1
        if came == "passed over":
            print(f"PASSED OVER {case.subject} {case.language} {case.place}: {case.spelt!r}")
    body = "\n".join(counted(found))
    print(body)
    if asked.write:
        page = RESULTS / "statements.md"
        said = f"`python benchmarks/statements.py --tables {asked.tables} --seed {asked.seed}`"
        text = put(page.read_text(encoding="utf-8"), "command", said)
        page.write_text(put(text, "statements", body), encoding="utf-8")


if __name__ == "__main__":
    main()
