"""Each statement and verdict that was once passed over or meant two things, played as a command.

Every table is made here, and its right figure computed apart by eq. 2-6. Of the first part a line
is right where that figure comes out or reading is refused by its name; of the second where exit
code and words are those that are asked for. Prints the tables of benchmarks/results/statements.md;
``--write`` puts them there. ``python benchmarks/line_by_line.py``.
"""

from __future__ import annotations

import contextlib
import csv
import io
import json
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import openpyxl
from openpyxl.styles import Font
from page import RESULTS, run

from scara_iso.commands import main

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
CYCLES = list(range(1, 32))
READINGS = np.round(0.5 + 0.0039 * np.random.default_rng(31).normal(size=31), 3).tolist()
ODD = [0.55 if k == 6 else reading for k, reading in enumerate(READINGS)]
ZEROS = np.round(np.random.default_rng(8).normal(0.1, 0.01, 31), 3).tolist()
HEAD = ("# unit: mm", "# resolution: 0.001")
J = np.arange(31)

Columns = dict[str, Sequence[object]]


def repeatability(readings: Sequence[float]) -> float:
    """Return RP by eq. 2-6 of the readings behind the first."""
    used = np.asarray(readings[1:])
    distances = np.abs(used - used.mean())
    return float(distances.mean() + 3 * distances.std(ddof=1))


RP = repeatability(READINGS)
RP_WITHOUT_7 = repeatability(ODD[:6] + ODD[7:])


def added(*parts: object) -> list[float]:
    """Return readings with something added to each, in the dial's steps."""
    return np.round(sum(map(np.asarray, parts), np.asarray(READINGS)), 3).tolist()


@dataclass(frozen=True, slots=True)
class Answer:
    """What a command gave."""

    code: int
    out: str
    err: str

    @property
    def refused(self) -> bool:
        """Whether nothing was computed."""
        return self.code in (2, 65, 73)

    @property
    def words(self) -> str:
        """All that was said, on one line."""
        return " ".join(f"{self.out} {self.err}".split())


def ask(command: str) -> Answer:
    """Run a command in this process and folder."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(command.split())
    return Answer(code, out.getvalue(), err.getvalue())


def table(columns: Columns, head: Iterable[str] = HEAD, name: str = "run.csv") -> None:
    """Write a table in the folder."""
    rows = [list(columns), *zip(*columns.values(), strict=True)]
    lines = [*head, *(",".join(map(str, row)) for row in rows)]
    Path(name).write_text("\n".join(lines) + "\n", encoding="utf-8")


def book(columns: Columns, prepare: Callable[[openpyxl.Workbook], object]) -> None:
    """Write a workbook in the folder, made ready as a hand would; it is named run.xlsx."""
    made = openpyxl.Workbook()
    for row in (["unit", "mm"], list(columns), *zip(*columns.values(), strict=True)):
        made.active.append(row)
    prepare(made)
    made.save("run.xlsx")


@dataclass(frozen=True, slots=True)
class Line:
    """What is stated, what came out of it before, and how to make the table that states it."""

    stated: str
    before: str
    make: Callable[[], object]
    right: dict[str, float] | None = None
    """RP by axis; None where only a refusal, or a word, is right."""
    command: str = "analyze run.csv"
    says: str = ""
    """What a refusal, or what is printed, must say (a regular expression)."""
    code: int | None = None
    """Exit code that is asked for; None: a refusal, or the right figure."""


def plain(columns: Columns, head: Iterable[str] = HEAD) -> Callable[[], object]:
    """Return what writes a table."""
    return lambda: table(columns, head)


def stated(text: str, factor: float | None, before: str, *, says: str = "") -> Line:
    """Return a line of a head, and by what it multiplies the readings."""
    right = None if factor is None else {"X": RP * factor}
    columns: Columns = {"cycle": CYCLES, "X": READINGS}
    return Line(f"`# {text}`", before, plain(columns, [*HEAD, f"# {text}"]), right, says=says)


_MM = "read as mm"
SCALES = """
scale, gain, scaling, lever_ratio, conversion, divisor, Maßstab, mm_per_count, conversion_factor,
calibration_factor, mm_per_digit, magnification, amplification, sensitivity, Skalierung,
Umrechnung, Kalibrierfaktor, Verstärkung, Hebelverhältnis, Teiler, échelle, scala, escala
"""
UNITS = """
X_unit, dial_unit, unit X, measurement unit, indicator_unit, reading_unit, length unit, data unit,
display_unit, UoM, values in, Längeneinheit, Einheit der Messwerte
"""
UNCERTAINTIES = """
calibration_uncertainty, gauge_uncertainty, U95, u_cal, expanded_uncertainty, Messunsicherheit
"""


def listed(text: str) -> list[str]:
    """Return the keys of a list."""
    return " ".join(text.split()).split(", ")


def heads() -> Iterator[Line]:
    """Yield the statements of heads."""
    for key in listed(SCALES):
        factor = 0.01 if key in ("scale", "scaling", "conversion", "Maßstab") else None
        yield stated(f"{key}: 0.01", factor, _MM, says="multiplied by no factor")
    for key in listed(UNITS):
        yield stated(f"{key}: um", 1e-3, _MM, says="unit")
    yield stated("Table I (mm x 10^-2)", 0.01, _MM, says="multiplied by no factor")
    limit = "analyze run.csv --limit X=0.013"
    for key in listed(UNCERTAINTIES):
        line = stated(f"{key}: 0.004", None, "PASS", says="indicator_uncertainty")
        yield Line(line.stated, line.before, line.make, None, limit, line.says)
    yield Line(
        "`# indicator_uncertainty: 0.004` and `# coverage_factor: 2`",
        "does not halve",
        plain(
            {"cycle": CYCLES, "X": READINGS},
            [*HEAD, "# indicator_uncertainty: 0.004", "# coverage_factor: 2"],
        ),
        command=limit,
        says="divided by its coverage factor",
    )
    for text in ("excluded cycles: 7", "struck: 7"):
        make = plain({"cycle": CYCLES, "X": ODD}, [*HEAD, f"# {text}"])
        yield Line(f"`# {text}`", "counted", make, {"X": RP_WITHOUT_7}, says="remove the rows")


def arcseconds() -> Iterator[Line]:
    """Yield angles whose seconds are written with one ASCII mark."""
    angles = np.round(1 + (np.asarray(READINGS) - 0.5) * 3, 3).tolist()
    right = {"X": RP, "theta": repeatability(angles) / 3600}
    before = "inches: 0.22 mm"

    def angled(heading: str, cell: str = "{}", below: Sequence[str] = ()) -> Callable[[], object]:
        rows = [["cycle", "X [mm]" if not below else "X", heading], list(below)]
        rows += [
            [str(c), str(x), cell.format(a)]
            for c, x, a in zip(CYCLES, READINGS, angles, strict=True)
        ]
        written = io.StringIO()
        csv.writer(written, lineterminator="\n").writerows(row for row in rows if row)
        return lambda: Path("run.csv").write_text(written.getvalue(), encoding="utf-8")

    for heading in ('theta "', 'theta ["]', 'theta (")', 'theta_"', 'theta / "', 'theta in "'):
        yield Line(f"heading `{heading}`", before, angled(heading), right, says="theta")
    for cell in ('{}"', '{} "'):
        says = f"cells `{cell.format('1.004')}`"
        yield Line(says, before, angled("theta", cell), right, says="theta")
    made = angled("theta", below=["", "mm", '"'])
    yield Line('unit row `"`', before, made, right, says="theta")


def columns() -> Iterator[Line]:
    """Yield columns and rows that change what a reading is."""
    above = added(ZEROS)
    for zero, reading in (("X zero", "X reading"), ("X tare", "X"), ("start reading", "X"),
                          ("ref", "X"), ("reference", "X"), ("initial", "X"),
                          ("idle", "X")):  # fmt: skip
        made = plain({"cycle": CYCLES, zero: ZEROS, reading: above})
        yield Line(f"columns `{zero}`, `{reading}`", "0.031 mm", made, {"X": RP}, says="zero")
    sides, apart = [k % 2 for k in CYCLES], added(0.012 * (J % 2 == 0))
    for side in ("side", "hand", "elbow", "config", "CW/CCW"):
        made = plain({"cycle": CYCLES, side: sides, "X": apart})
        yield Line(f"column `{side}` of 0 and 1", "pooled: 0.034 mm", made, says="a side")
    words = ["lefty" if side else "righty" for side in sides]
    made = plain({"cycle": CYCLES, "arm": words, "X": apart})
    yield Line("column `arm` of lefty and righty", "pooled", made, says="lefty")
    made = plain({"cycle": CYCLES, "fixture": sides, "X": apart})
    parted = r"column 'fixture' parts the readings of X, which are taken together"
    yield Line("column `fixture` of 0 and 1", "pooled", made, says=parted, code=0)
    poses = [(300, 100), (400, -50), (200, 150), (350, 220), (250, -120)] * 6
    coordinates: Columns = {
        "X": [x for x, _ in poses], "Y": [y for _, y in poses], "dial": READINGS[:30]
    }  # fmt: skip
    asked = "analyze run.csv --all-count"
    yield Line("`X, Y, dial`, the poses' coordinates", "RP XY 204 mm", plain(coordinates),
               command=asked, says="coordinates")  # fmt: skip
    truth = 0.999 + 6 * (np.asarray(READINGS) - 0.5)
    made = plain({"cycle": CYCLES, "X": np.round(truth % 1, 3).tolist()})
    right = {"X": repeatability(truth.tolist())}
    yield Line("a dial that rolls over at 1 mm", "0.586 for 0.06 mm", made, right, says="roll over")
    for figure in (np.mean, np.median, np.min, np.max):
        both: Columns = {
            name: [*values[:30], round(float(figure(values[:30])), 4)]
            for name, values in {"X": READINGS, "Y": added(0.3, 0.001 * (J % 3))}.items()
        }
        yield Line(f"last row: the {figure.__name__}, no label", "counted; first discarded",
                   plain(both), says="the last row is the")  # fmt: skip
    for how, level in (("in turn", J % 3), ("in blocks", J // 8)):
        made = plain({"cycle": CYCLES, "X": added(0.5 * level)})
        yield Line(f"levels 0.5 mm apart, {how}", "one pose", made, says="poses")
    for heading, usual, struck in (("valid", 1, 0), ("status", "ok", "void"), ("foo", "", "x")):
        marks = [struck if k == 7 else usual for k in CYCLES]
        made = plain({"cycle": CYCLES, "X": ODD, heading: marks})
        yield Line(f"column `{heading}`: `{struck}` in cycle 7", "counted", made,
                   {"X": RP_WITHOUT_7}, says="counted|excluded|'ok' is not a number")  # fmt: skip
    for remark in ("not counted", "ungültig", "void", "scrapped"):
        for heading in ("remark", ""):
            marks = [remark if k == 7 else "" for k in CYCLES]
            made = plain({"cycle": CYCLES, "X": ODD, heading: marks})
            place = "in a column of remarks" if heading else "behind a row"
            yield Line(f"`{remark}` {place}", "counted", made, {"X": RP_WITHOUT_7}, says="counted")


def hide_row(made: openpyxl.Workbook) -> None:
    """Hide the row of cycle 7."""
    made.active.row_dimensions[9].hidden = True


def filter_row(made: openpyxl.Workbook) -> None:
    """Filter the row of cycle 7 away."""
    made.active.auto_filter.ref = "A2:B33"
    made.active.auto_filter.add_filter_column(0, [str(k) for k in CYCLES if k != 7])
    hide_row(made)


def strike_row(made: openpyxl.Workbook) -> None:
    """Strike the row of cycle 7 through."""
    for cell in made.active[9]:
        cell.font = Font(strike=True)


def hide_column(made: openpyxl.Workbook) -> None:
    """Hide the third column."""
    made.active.column_dimensions["C"].hidden = True


def show_percent(made: openpyxl.Workbook) -> None:
    """Show readings as percentages."""
    for (cell,) in made.active.iter_rows(min_row=3, min_col=2, max_col=2):
        cell.number_format = "0.0%"


def add_cover(made: openpyxl.Workbook) -> None:
    """Put a sheet in front, as a laboratory does."""
    cover = made.create_sheet("Cover", 0)
    for row in (["Customer", "Acme GmbH"], ["Robot", "SCARA 2"], ["Date", "2026-03-01"]):
        cover.append(row)


def workbooks() -> Iterator[Line]:
    """Yield workbooks whose cells are not what they show."""
    asked = "analyze run.xlsx"
    for name, prepare, says in (
        ("hidden row 7", hide_row, "hidden"), ("filtered row 7", filter_row, "hidden"),
        ("row 7 struck through", strike_row, "struck"),
    ):  # fmt: skip
        made = lambda one=prepare: book({"cycle": CYCLES, "X": ODD}, one)  # noqa: E731
        yield Line(f"workbook: {name}", "counted", made, {"X": RP_WITHOUT_7}, asked, says)
    yield Line("workbook: readings shown as 50.1 %", "0.501 mm",
               lambda: book({"cycle": CYCLES, "X": READINGS}, show_percent), None, asked,
               "%|percent")  # fmt: skip
    yield Line("workbook: hidden column Z", "an axis",
               lambda: book({"cycle": CYCLES, "X": READINGS, "Z": ODD}, hide_column), None, asked,
               "hidden")  # fmt: skip
    yield Line("workbook: cover with customer, robot, date", "not used, not listed",
               lambda: book({"cycle": CYCLES, "X": READINGS}, add_cover), None,
               "report run.xlsx -o run.md", "Acme GmbH", 0)  # fmt: skip


def other_commands() -> Iterator[Line]:
    """Yield what other commands took."""
    one = plain({"cycle": CYCLES, "X": READINGS})

    def copy() -> None:
        one()
        for name in ("P1.csv", "P2.csv"):
            shutil.copy("run.csv", name)

    yield Line("the same file twice", "two poses", copy, command="analyze P1.csv P1.csv",
               says="the very readings of P1")  # fmt: skip
    yield Line("a file and its copy", "two poses", copy, command="analyze P1.csv P2.csv",
               says="the very readings of P1")  # fmt: skip
    gear = "backlash --Im 2.65e-4 --IL 4.749 --arcmin 12 --arm 700"
    yield Line("an arm of 700", "700 metres", lambda: None, command=gear, says="--arm")
    for what, first in (("counts", lambda k: k + 1), ("repeats", lambda k: k % 5 + 1)):
        rows = [f"{first(k)},{READINGS[k]},{added(0.3)[k]}" for k in range(31)]
        made = lambda rows=rows: Path("run.csv").write_text("\n".join(rows) + "\n", "utf-8")  # noqa: E731
        yield Line(f"rows that begin with an integer that {what}",
                   "hint `--columns X,Y,Z,-`, RP XY 115 mm", made,
                   command="analyze run.csv --unit mm",
                   says=r"--columns (cycle|pose),")  # fmt: skip


def verdicts() -> Iterator[Line]:
    """Yield what a verdict says."""
    shutil.copy(EXAMPLES / "fum_scara_table1.csv", "table1.csv")
    nothing = lambda: None  # noqa: E731
    one = plain({"cycle": CYCLES, "X": READINGS})
    um = plain({"cycle": CYCLES, "X": [round(1000 * x) for x in READINGS]},
               ["# unit: um", "# resolution: 1"])  # fmt: skip
    two = "analyze table1.csv --limit"
    yield Line("limit between 7.2.2 (0.0141) and eq. 23 (0.0153)", "fails by eq. 23", nothing,
               None, f"{two} XY=0.0145 --decision simple", "PASS", 0)  # fmt: skip
    yield Line("eq. 23 by its name", "by `XY`", nothing, None,
               f"{two} XY_eq23=0.0145 --decision simple", "FAIL.*eq.?23", 1)  # fmt: skip
    yield Line("both fail", "headline names eq. 23", nothing, None, f"{two} XY=0.009",
               r"^FAIL(?:(?!eq.?23).)*limit 0\.009 mm", 1)  # fmt: skip
    yield Line("each verdict in its row", "in the headline", nothing, None, f"{two} XY=0.009",
               r"XY +0\.01\S+ .*?FAIL", 1)  # fmt: skip
    yield Line("a table in um, limit 10", "passes at 10 mm", um, None,
               "analyze run.csv --limit 10", "10 mm or 10 um", 2)  # fmt: skip
    for limit in ("0.02mm", "20um"):
        yield Line(f"limit {limit}", "no unit taken", one, None,
                   f"analyze run.csv --limit {limit}", r"limit 0\.02(0)? mm", 0)  # fmt: skip
    shutil.copy(EXAMPLES / "dial_type_1.csv", "dial.csv")
    for size in ("0.03mm", "30um"):
        yield Line(f"tolerance {size}", "no unit taken", nothing, None,
                   f"gauge-study dial.csv --tolerance {size}", r"tolerance 0\.03 mm")  # fmt: skip
    shutil.copytree(EXAMPLES / "months", "months", dirs_exist_ok=True)
    yield Line("a table in um, tolerance 30", "30 mm",
               plain({"cycle": CYCLES, "X": [round(1000 * x) for x in READINGS]},
                     ["# unit: um", "# resolution: 1", "# reference: 500", "# part: block"]), None,
               "gauge-study run.csv --tolerance 30", "30 mm or 30 um", 2)  # fmt: skip
    yield Line("`history --limit` in amber or red", "\"may be met\"", nothing, None,
               "history months --limit XY=0.03", "exceed")  # fmt: skip
    last = max(Path("months").glob("2*.csv")).as_posix()
    for limit in ("XY=0.03", "XY=0.02", "XY=0.05"):
        code = ask(f"analyze {last} --limit {limit}").code
        yield Line(f"`history` exits as `analyze` ({limit})", "they differed", nothing, None,
                   f"history months --limit {limit}", "limit", code)  # fmt: skip
    for what, shape in (("shift", 0.015 * (J >= 13)), ("drift", 0.0006 * J),
                        ("odd reading", 0.05 * (J == 6))):  # fmt: skip
        readings = added(shape)
        limit = f"{1.1 * repeatability(readings):.4f}"
        yield Line(f"a {what} beside a limit", "300 cycles proposed",
                   plain({"cycle": CYCLES, "X": readings}), None,
                   f"analyze run.csv --limit X={limit}",
                   r"^(?!.*cycles would).*[Ff]ind the cause", 1)  # fmt: skip
    shutil.copy(EXAMPLES / "dial_crossed.csv", "crossed.csv")
    yield Line("gauge R&R of 18.1 %", "pass", nothing, None,
               "gauge-study crossed.csv --tolerance 0.03", "R&R/T .conditional")  # fmt: skip
    yield Line("share that passes at the limit", "\"any scatter\"", one, None,
               "analyze run.csv --limit X=0.008 --full",
               r"^(?!.*any scatter).*with Gaussian scatter")  # fmt: skip
    for option in ("--definitions", "--full"):
        yield Line(f"`{option}`", "+/- without a label", one, None, f"analyze run.csv {option}",
                   r"^(?!.*\d (?:±|\+/-) \d(?!.*(?:\bu\b|95 %)))", 0)  # fmt: skip
    yield from reports(one)


def reports(one: Callable[[], object]) -> Iterator[Line]:
    """Yield reports that may not be written."""

    def first(*options: str) -> Callable[[], object]:
        def write() -> None:
            table({"cycle": CYCLES, "X": ODD}, name="other.csv")
            Path("r.md").unlink(missing_ok=True)
            ask(" ".join(("report other.csv -o r.md", *options)))
            one()

        return write

    yield Line("a report over another table's", "written over", first(), None,
               "report run.csv -o r.md", "--replace", 73)  # fmt: skip
    yield Line("a number that another report carries", "given twice",
               first("--meta report_number=17"), None,
               "report run.csv -o s.md --meta report_number=17", "17", 73)  # fmt: skip
    for key, meant in (("report_nr", "report_number"), ("oprator", "operator")):
        yield Line(f"`--meta {key}=3`", "taken as a free key", one, None,
                   f"report run.csv -o t.md --meta {key}=3", meant, 2)  # fmt: skip


def is_right(line: Line, answer: Answer) -> bool:
    """Say whether an answer is what is asked for."""
    if line.code is not None or (line.right is None and not answer.refused):
        text = answer.words
        path = Path("run.md")
        text += path.read_text("utf-8") if line.command.endswith("-o run.md") else ""
        exits = line.code is None and line.command[:5] in ("gauge", "histo", "analy")
        return (exits or answer.code == line.code) and re.search(line.says, text) is not None
    if answer.refused:
        return re.search(line.says, answer.words) is not None
    (pose,) = json.loads(ask(f"{line.command} --json").out)["poses"]
    found = {name: axis["RP"] for name, axis in pose["axes"].items()}
    return found.keys() == line.right.keys() and all(
        np.isclose(found[name], rp, rtol=1e-6) for name, rp in line.right.items()
    )


def what_is_said(line: Line, answer: Answer) -> str:
    """Return the line of an answer that matters, short."""
    lines = [" ".join(text.split()) for text in (answer.err + answer.out).splitlines()]
    lines = [text for text in lines if text and "fault" not in text[-9:]]
    named = [text for text in lines if re.search(line.says, text)]
    figures = [text for text in lines if text.startswith(("RP", "PASS", "FAIL", "NOT"))]
    best = next(iter([*(named if answer.refused or line.right is None else figures), *lines]), "")
    return best.replace("|", "\\|")[:110]


def played(lines: Iterable[Line]) -> Iterator[str]:
    """Yield a row for each line."""
    yield "| stated | before | command | exit code and what is said now | |"
    yield "|---|---|---|---|---|"
    done = []
    for line in lines:
        line.make()
        answer = ask(line.command)
        done.append(is_right(line, answer))
        judged = "right" if done[-1] else "**wrong**"
        said = f"{answer.code}: {what_is_said(line, answer)}"
        yield f"| {line.stated} | {line.before} | `{line.command}` | {said} | {judged} |"
    yield f"| {len(done)} lines, {sum(done)} right | | | | |"


def in_part_one() -> Iterator[Line]:
    """Yield what was silent."""
    for part in (heads, arcseconds, columns, workbooks, other_commands):
        yield from part()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        run({"silent": lambda: played(in_part_one()), "verdicts": lambda: played(verdicts())},
            RESULTS / "statements.md", __doc__)  # fmt: skip
        os.chdir(RESULTS)
