"""Gauge studies against AIAG's printed examples, an independent library, and tables as sent."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from aqdefreader import DfqFile
from budget import examples
from capstat_core import bias, gage_rr, gage_rr_range, linearity, xbar_s_chart
from hypothesis import given, strategies as st
from openpyxl import Workbook
from scipy.stats import linregress, t as student

import scara_iso
from scara_iso.base.errors import DataError, UsageError
from scara_iso.commands import main
from scara_iso.gauge.table import read_gauge_tables

FIXTURES = Path(__file__).parents[1] / "fixtures" / "gauge"
CROSSED, LINEARITY, BIAS = (FIXTURES / f"aiag_{n}.csv" for n in ("crossed", "linearity", "bias"))


def figures(table, **options):
    (study,) = scara_iso.gauge_study(table, **options).axes.values()
    return study.figures


def written(path, columns, rows, head=("# unit: mm", "# resolution: 0.001")):
    lines = [*head, ",".join(columns), *(",".join(map(str, row)) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def type_1(path, s=0.001, n=50, mean=0.81, seed=1, head=()):
    readings = np.random.default_rng(seed).normal(mean, s, n).round(3)
    head = ("# unit: mm", "# resolution: 0.001", *head)
    return written(path, ["cycle", "X"], enumerate(readings, 1), head)


def crossed(path, rng, p=5, o=3, r=3, operators=0.002, noise=0.001):
    level, side = rng.normal(0, 0.05, p), rng.normal(0, operators, o)
    rows = [
        (f"part {i}", "ABC"[j], k + 1, round(level[i] + side[j] + rng.normal(0, noise), 4))
        for i in range(p)
        for j in range(o)
        for k in range(r)
    ]
    return written(path, ["part", "operator", "trial", "X"], rows)


def test_crossed_study_of_the_manual():
    """AIAG MSA, tables III-B 7 and 8: ANOVA; figure III-B 16: average and range."""
    found = figures(CROSSED)
    squares = {one.source: one.squares for one in found.anova}
    assert squares["operator"] == pytest.approx(3.1673, abs=1e-4)
    assert squares["part"] == pytest.approx(88.3619, abs=1e-4)
    assert squares["repeatability"] == pytest.approx(0.3590 + 2.7589, abs=1e-4)
    assert squares["total"] == pytest.approx(94.6471, abs=1e-4)
    assert found.interaction_pooled
    printed = {"EV": 0.199933, "AV": 0.226838, "GRR": 0.302373, "PV": 1.042327, "TV": 1.085}
    for name, sigma in printed.items():
        assert found.components[name].sigma == pytest.approx(
            sigma, abs=6e-6 if name != "TV" else 5e-4
        )
    assert 100 * found.components["GRR"].of_study == pytest.approx(27.9, abs=0.05)
    assert found.ndc == 4
    ranges = found.by_ranges
    by_hand = {"EV": 0.20188, "AV": 0.22963, "GRR": 0.30575, "PV": 1.10456, "TV": 1.14610}
    for name, sigma in by_hand.items():
        assert getattr(ranges, name) == pytest.approx(sigma, abs=1.2e-4)
    assert ranges.ndc == 5


def test_linearity_study_of_the_manual():
    """AIAG MSA, figure III-B 3 and what follows: slope, intercept, their t, R squared."""
    found = figures(LINEARITY)
    assert found.slope == pytest.approx(-0.131667, abs=1e-6)
    assert found.intercept == pytest.approx(0.736667, abs=1e-6)
    assert found.residual == pytest.approx(0.23954, abs=1e-5)
    assert found.explained == pytest.approx(0.714, abs=5e-4)
    assert found.biases == pytest.approx([0.491667, 0.125, 0.025, -0.291667, -0.616667], abs=1e-6)
    assert not found.holds_zero
    quantile = 2.00172  # of 58 degrees of freedom, as printed
    half = found.slope_interval[1] - found.slope
    assert found.slope * quantile / half == pytest.approx(-12.043, abs=5e-4)
    assert student.isf(found.intercept_p_value / 2, 58) == pytest.approx(10.158, abs=5e-4)


def test_bias_study_of_the_manual():
    found = figures(BIAS)
    assert (found.n, found.mean) == (15, pytest.approx(6.0067, abs=1e-4))
    assert found.t == pytest.approx(0.12, abs=0.005)
    assert found.bias_interval[0] < 0 < found.bias_interval[1]


@pytest.mark.parametrize("seed", range(3))
def test_crossed_studies_agree_with_an_independent_library(tmp_path, seed):
    operators = (0.0, 0.002, 0.01)[seed]
    path = crossed(tmp_path / "c.csv", np.random.default_rng(seed), p=7, operators=operators)
    found = figures(path, tolerance=0.3)
    theirs, by_hand = gage_rr(found.cells, tolerance=0.3), gage_rr_range(found.cells)
    assert found.interaction_pooled is not theirs.interaction_included
    mine = {name: one.sigma**2 for name, one in found.components.items()}
    assert mine["EV"] == pytest.approx(theirs.var_repeatability)
    assert mine["AV"] == pytest.approx(theirs.var_operator)
    assert mine.get("INT", 0.0) == pytest.approx(theirs.var_interaction)
    assert mine["PV"] == pytest.approx(theirs.var_part)
    share = found.components["GRR"].of_tolerance
    assert 100 * share == pytest.approx(theirs.pct_tolerance_gage_rr)
    assert found.ndc == max(theirs.ndc, 1)
    assert found.components["TV"].of_study_interval == pytest.approx((1, 1))
    assert found.by_ranges.GRR == pytest.approx(math.sqrt(by_hand.var_gage_rr), rel=0.01)


def test_the_others_agree_with_an_independent_library(tmp_path):
    table = np.loadtxt(LINEARITY, delimiter=",", skiprows=2)
    values = [table[table[:, 0] == x, 1] for x in np.unique(table[:, 0])]
    theirs, mine = linearity(np.unique(table[:, 0]), values), figures(LINEARITY)
    assert mine.slope_p_value == pytest.approx(theirs.slope_p_value)
    one, other = figures(BIAS), bias(np.loadtxt(BIAS, skiprows=3), 6.0)
    assert one.p_value == pytest.approx(other.p_value)
    assert one.bias_interval == pytest.approx((other.ci_lower, other.ci_upper))
    rows = np.random.default_rng(3).normal(5, 0.01, (8, 5)).round(4)
    named = [(f"d{k}", value) for k, row in enumerate(rows) for value in row]
    chart = figures(written(tmp_path / "s.csv", ["session", "X"], named))
    slope = linregress(range(len(rows)), rows.mean(axis=1))
    assert (chart.trend, chart.trend_p_value) == pytest.approx((slope.slope, slope.pvalue))
    limits = xbar_s_chart(rows)
    assert chart.centre - chart.half_width[0] == pytest.approx(limits.location.limits.lower)
    assert chart.centre + chart.half_width[0] == pytest.approx(limits.location.limits.upper)
    assert chart.scatter_limits[1][0] == pytest.approx(limits.dispersion.limits.upper)


def test_the_scatter_between_sessions_is_what_their_own_leaves(tmp_path):
    rng, sizes = np.random.default_rng(4), (3, 5, 4, 8, 3)
    each = [rng.normal(5 + 0.02 * rng.normal(), 0.01, n).round(4) for n in sizes]
    rows = [(f"d{k}", value) for k, values in enumerate(each) for value in values]
    found = figures(written(tmp_path / "s.csv", ["session", "X"], rows))
    c4 = [math.sqrt(2 / (n - 1)) * math.gamma(n / 2) / math.gamma((n - 1) / 2) for n in sizes]
    sigma = np.mean([values.std(ddof=1) / c for values, c in zip(each, c4, strict=True)])
    between = np.var([values.mean() for values in each], ddof=1) - sigma**2 * np.mean(
        1 / np.array(sizes)
    )
    assert (found.sigma, found.between) == pytest.approx((sigma, math.sqrt(between)))


@pytest.mark.parametrize(("operators", "few"), [(1, False), (2, True), (3, False)])
def test_two_operators_are_few(tmp_path, rng, operators, few):
    study = scara_iso.gauge_study(crossed(tmp_path / "c.csv", rng, p=15, o=operators))
    assert any("operators tell little" in one.message for one in study.remarks) is few


def test_type_1_by_its_formulas(tmp_path):
    path = type_1(
        tmp_path / "t.csv", head=("# reference: 0.8105", "# indicator_uncertainty: 0.0004")
    )
    readings = np.loadtxt(path, delimiter=",", skiprows=5)[:, 1]
    found = figures(path, tolerance=0.06)
    s, off = readings.std(ddof=1), readings.mean() - 0.8105
    assert found.Cg == pytest.approx(0.2 * 0.06 / (6 * s))
    assert found.Cgk == pytest.approx((0.1 * 0.06 - abs(off)) / (3 * s))
    assert found.Cgk_interval[0] < found.Cgk < found.Cgk_interval[1]
    u = math.sqrt(0.0004**2 + max(s**2, 0.001**2 / 12) + off**2 / 3)
    assert found.budget.u == pytest.approx(u)
    assert found.budget.Q == pytest.approx(4 * u / 0.06)
    assert found.budget.C == pytest.approx(0.3 * 0.06 / (6 * u))
    assert found.budget.zone == pytest.approx(0.06 - 4 * u)
    just = figures(path, tolerance=found.budget.smallest_tolerance).budget
    assert just.Q == pytest.approx(just.limit)


@examples(8)
@given(scale=st.floats(1e-3, 1e3), offset=st.floats(-100, 100))
def test_shares_do_not_change_with_unit_and_zero(tmp_path_factory, scale, offset):
    folder = tmp_path_factory.mktemp("scaled")
    values = np.random.default_rng(4).normal(0, 1, (4, 2, 3)) + np.arange(4)[:, None, None]
    shares = []
    for k, cells in enumerate((values, scale * (values + offset))):
        rows = [(i, j, x) for (i, j, _), x in np.ndenumerate(cells)]
        found = figures(written(folder / f"{k}.csv", ["part", "operator", "X"], rows))
        shares.append([one.of_study for one in found.components.values()])
    assert shares[0] == pytest.approx(shares[1], rel=1e-4, abs=1e-5)


@pytest.mark.parametrize(
    ("s", "tolerance", "rule", "code"),
    [(0.001, 0.08, "simple", 0), (0.001, 0.02, "simple", 1), (0.001, 0.042, "interval", 1),
     (0.001, 0.08, "interval", 0)],
)  # fmt: skip
def test_a_tolerance_decides_the_exit_code(tmp_path, capsys, s, tolerance, rule, code):
    path = type_1(tmp_path / "t.csv", s, head=("# reference: 0.81",))
    command = [
        "gauge-study",
        str(path),
        "--tolerance",
        str(tolerance),
        "--decision",
        rule,
        "--json",
    ]
    assert main(command) == code
    found = json.loads(capsys.readouterr().out)
    assert found["conformity"] == (
        "pass" if code == 0 else "fail" if rule == "simple" else "not-provable"
    )
    assert main(["gauge-study", str(path)]) == 0


def test_a_dial_that_shows_one_value_has_no_figure_and_says_so(tmp_path, capsys):
    path = written(tmp_path / "t.csv", ["X"], [[0.81]] * 30, ("# unit: mm", "# resolution: 0.01"))
    assert (
        main(["gauge-study", str(path), "--tolerance", "0.1", "--reference", "0.81", "--json"]) == 1
    )
    found = json.loads(capsys.readouterr().out)
    assert found["axes"]["X"]["type_1"]["Cg"] is None
    verdicts = {one["criterion"]: one["verdict"] for one in found["criteria"]}
    assert verdicts["Cg"] == "not-provable"
    assert verdicts["resolution/T"] == "fail"
    assert found["axes"]["X"]["uncertainty_budget"]["parts"]["u_RE"] == pytest.approx(
        0.01 / math.sqrt(12)
    )
    assert any("alike" in one["message"] for one in found["findings"])


@pytest.mark.parametrize(
    ("columns", "rows", "kind"),
    [
        (["X"], [[1.0], [1.1], [1.2], [1.0], [1.1]], "type-1"),
        (["pose", "X"], [["P1", 1.0], ["P1", 1.1], ["P2", 2.0], ["P2", 2.1]], "type-3"),
        (["reference", "X"], [[1, 1.0], [1, 1.1], [2, 2.0], [2, 2.1], [3, 3.1]], "linearity"),
        (["day", "X"], [[k, 1 + k % 3 / 10] for k in range(6)], "stability"),
        (["part", "appraiser", "X"],
         [[p, o, p + o / 10 + t / 100] for p in (1, 2) for o in (1, 2) for t in (1, 2)], "type-2"),
    ],
)  # fmt: skip
def test_columns_tell_the_study(tmp_path, capsys, columns, rows, kind):
    path = written(tmp_path / "t.csv", columns, rows)
    assert main(["gauge-study", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["axes"]["X"]["kind"] == kind
    assert main(["gauge-study", str(path), "--full", "--tolerance", "5"]) in (0, 1)


def test_recordings_of_operators_are_one_study(tmp_path, capsys):
    """Poses of a recording are the parts; what its head states holds for all of it."""
    for name in ("Anna", "Ben"):
        command = ["record", str(tmp_path / f"{name}.csv"), "--gauge", "X=opto-rs232@sim:?pace=0",
                   "--trigger", "timer:0.1", "--cycles", "3", "--pose", "1,2,3", "--json",
                   "--meta", f"operator={name}"]  # fmt: skip
        assert main(command) == 0
    capsys.readouterr()
    assert (
        main(["gauge-study", *(str(tmp_path / f"{n}.csv") for n in ("Anna", "Ben")), "--json"]) == 0
    )
    found = json.loads(capsys.readouterr().out)
    assert found["axes"]["X"]["crossed"]["operators"] == ["Anna", "Ben"]
    assert found["axes"]["X"]["crossed"]["trials"] == 3
    assert any("SIMULATED" in one["message"] for one in found["findings"])


def test_tables_that_differ_in_nothing_are_sessions(tmp_path):
    paths = [type_1(tmp_path / f"day{k}.csv", n=5, seed=k) for k in range(4)]
    assert figures(paths).sessions == ("day0", "day1", "day2", "day3")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("part,operator,X\n1,A,1\n1,A,2\n1,B,1\n2,A,1\n2,A,2\n2,B,2\n", "part 1 by B has 1"),
        ("part,operator,X\n" + "".join(f"{p},{o},{p}\n" for p in (1, 2) for o in "AB" for _ in "12")
         + "1,A,1\n", "equally often"),
        ("operator,X\nA,1\nB,2\n", "one part"),
        ("X\n1\n2\n", "2 readings"),
        ("part,operator,X\n1,,1\n", "empty"),
        ("day,X\n1,1\n2,2\n", "2 sessions"),
        ("X,Y,reference\n1,2,1\n", "one reference"),
        ("robot,force\n1,2\n", "no column of readings"),
        ("X,operator\n1,5,A\n", "3 fields"),
    ],
)  # fmt: skip
def test_what_makes_no_study_is_refused(tmp_path, capsys, text, said):
    path = tmp_path / "t.csv"
    path.write_text("# unit: mm\n" + text, encoding="utf-8")
    assert main(["gauge-study", str(path), "--json"]) == 65
    captured = capsys.readouterr()
    assert captured.out == ""
    assert said in captured.err


def test_a_table_that_is_named_twice_would_count_twice(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "t.csv").write_text("# unit: mm\nX\n" + "0.1\n0.2\n" * 10, encoding="utf-8")
    assert main(["gauge-study", "t.csv", str(tmp_path / "t.csv")]) == 2
    assert "t.csv is named twice" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "code"),
    [
        (["--tolerance", "-1"], 2), (["--tolerance", "Y=1"], 2), (["--reference", "x"], 2),
        (["--reference", "0.9"], 2), (["-o", "x.doc"], 2), (["--tolerance", "1,500"], 2),
    ],
)  # fmt: skip
def test_options_that_make_no_sense(tmp_path, capsys, options, code):
    path = type_1(tmp_path / "t.csv", head=("# reference: 0.81",))
    assert main(["gauge-study", str(path), *options]) == code
    assert capsys.readouterr().out == ""


def test_no_unit_and_no_file(tmp_path):
    path = written(tmp_path / "t.csv", ["X"], [[1]] * 6, ())
    with pytest.raises(DataError, match="no unit"):
        scara_iso.gauge_study(path)
    assert figures(path, unit="um").mean == pytest.approx(0.001)
    assert main(["gauge-study", str(tmp_path / "none.csv")]) == 66
    with pytest.raises(UsageError):
        scara_iso.gauge_study(path, unit="um", decision="perhaps")


def part_of(path):
    return DfqFile(path.read_text("cp1252").splitlines()).get_part(0)


def characteristics(path):
    return part_of(path).get_characteristics()


def test_a_study_as_aqdef_is_read_back(tmp_path):
    scara_iso.gauge_study(CROSSED, tolerance=4, to=tmp_path / "s.dfq")
    part = part_of(tmp_path / "s.dfq")
    (dial,) = part.get_characteristics()
    assert [dial.get_data(k) for k in ("K2202", "K2205", "K2220", "K2221")] == [2, 10, 3, 3]
    assert dial.get_data("K2142") == "mm"
    values = [one.value for one in dial.get_measurements()]
    table = np.genfromtxt(CROSSED, delimiter=",", skip_header=2, usecols=3)
    assert values == pytest.approx(table.tolist())
    assert [m.batch_no for m in dial.get_measurements()[:2]] == ["1", "2"]
    assert {m.controller_no for m in dial.get_measurements()} == {1, 2, 3}


def test_a_type_1_study_as_aqdef_states_reference_and_limits(tmp_path):
    path = type_1(tmp_path / "t.csv", head=("# reference: 0.81",))
    scara_iso.gauge_study(path, tolerance=0.06, to=tmp_path / "s.dfq")
    (dial,) = characteristics(tmp_path / "s.dfq")
    assert [float(dial.get_data(k)) for k in ("K2101", "K2110", "K2111", "K2404")] == [
        pytest.approx(0.81), pytest.approx(0.78), pytest.approx(0.84), pytest.approx(0.001)
    ]  # fmt: skip
    assert dial.get_data("K2202") == 1


def test_a_run_as_aqdef_is_read_back(tmp_path):
    """The discarded first cycle is there, and its attribute keeps it from every evaluation."""
    table = Path(__file__).parents[2] / "examples" / "scatter.csv"
    scara_iso.report(table, to=tmp_path / "run.dfq")
    run = scara_iso.read_table(table)
    found = characteristics(tmp_path / "run.dfq")
    assert [one.get_data("K2002") for one in found] == list(run.axes)
    for one, axis in zip(found, run.axes.values(), strict=True):
        values = [m.value for m in one.get_measurements()]
        assert values == pytest.approx(axis.readings[1:].tolist())
    lines = (tmp_path / "run.dfq").read_text("cp1252").splitlines()
    assert sum("\x14255" in line for line in lines) == 1
    assert len(run) == 31


def test_a_second_reader_reads_both(tmp_path):
    parser = pytest.importorskip("qdas_parser")
    rows = [(f"P{p}", 10 * p + k + 0.25) for k in range(3) for p in (1, 2)]
    table = written(tmp_path / "poses.csv", ["pose", "X"], rows, ("# unit: mm", "# robot: A; B"))
    scara_iso.report(table, to=tmp_path / "run.dfq", cycles=3, all_count=True)
    lines = (tmp_path / "run.dfq").read_text("cp1252").splitlines(keepends=True)
    is_key = [line.startswith("K") for line in lines]
    for ending, keys in ((".dfd", True), (".dfx", False)):
        text = "".join(line for line, key in zip(lines, is_key, strict=True) if key is keys)
        (tmp_path / f"run{ending}").write_text(text, encoding="utf-8")
    found = parser.QDASFileParser(tmp_path / "run.dfd", "A", kind="pc")
    _, features = found.parse_description()
    assert [one.label for one in features] == ["P1_X", "P2_X"]
    values = [[float(value) for value, *_ in line] for line in found.rows()]
    assert values == [[10.25, 20.25], [11.25, 21.25], [12.25, 22.25]]


def test_pages_and_pictures(tmp_path):
    path = type_1(tmp_path / "t.csv", head=("# reference: 0.81",))
    for ending in (".html", ".md", ".csv", ".json"):
        found = scara_iso.gauge_study(path, tolerance=0.06, to=tmp_path / f"s{ending}")
        assert (tmp_path / f"s{ending}").stat().st_size > 300
    assert len(found.to_frame()) == len(found.criteria)
    assert main(["gauge-study", str(path), "--plot", str(tmp_path / "s.svg")]) == 0
    assert (tmp_path / "s.svg").stat().st_size > 3000


@pytest.mark.parametrize(
    ("command", "head", "rows"),
    [
        (["gauge-study"], "X;reference", [(f"5,00{k % 3}", "5,000") for k in range(20)]),
        (["push"], "force_N;reading", [("1,000", f"2,00{k}") for k in range(9)]),
        (["backlash", "--Im", "1", "--IL", "2", "--arcmin", "3", "--measured"],
         "Im;IL;arcmin;deviation_rad", [("1,001", "2,002", "12,001", "1,001")]),
    ],
)  # fmt: skip
def test_where_a_comma_can_be_read_two_ways_the_option_that_says_it_is_named_and_taken(
    tmp_path, capsys, command, head, rows
):
    path = tmp_path / "german.csv"
    body = "\n".join(";".join(row) for row in rows)
    path.write_text(f"# unit: mm\n{head}\n{body}\n")
    main([*command, str(path)])
    assert "--decimal ," in capsys.readouterr().err
    main([*command, str(path), "--decimal", ","])
    assert "decimal" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("head", "option"),
    [
        pytest.param("# resolution: 0,001\n", [], id="a size says what commas are"),
        pytest.param("", ["--decimal", ","], id="the option says it"),
    ],
)
def test_a_reference_is_read_by_the_decimal_mark_of_the_readings(tmp_path, capsys, head, option):
    path = tmp_path / "german.csv"
    rows = "\n".join(f"5,00{k % 3}" for k in range(20))
    path.write_text(f"# unit: mm\n{head}# reference: 5,000\nreading\n{rows}\n")
    assert main(["gauge-study", str(path), *option]) == 0
    assert "bias 0.00095 mm" in capsys.readouterr().out


@pytest.mark.parametrize("size", [1, 0.001])
def test_categories_are_whole_in_german_columns_too(tmp_path, capsys, size):
    """ndc is cut, as AIAG has it: 25.6 categories are 25, 0.997 are 1, everywhere."""
    rows = [[o, p, t, p * size + o / 10 + (p * t) % 3 / 10] for o in (1, 2) for p in range(1, 6)
            for t in (1, 2)]  # fmt: skip
    columns = ["Prüfer", "Teil", "Wiederholung", "Messwert"]
    path = written(tmp_path / "t.csv", columns, rows)
    assert main(["gauge-study", str(path), "--json"]) == 0
    crossed = json.loads(capsys.readouterr().out)["axes"]["reading"]["crossed"]
    assert crossed["ndc"] == max(math.floor(crossed["ndc_raw"]), 1)
    assert crossed["ndc_raw"] != crossed["ndc"]
    main(["gauge-study", str(path), "--tolerance", "9"])
    shown = capsys.readouterr().out
    assert f"ndc {crossed['ndc']} " in shown.replace("\n", " ")
    row = next(line for line in shown.splitlines() if line.split()[:1] == ["ndc"] and ">=" in line)
    assert row.split()[1] == str(crossed["ndc"])


ALIKE = {
    "comments": "# unit: mm\n# tolerance: 0.1\n# reference: 5\nn,X\n",
    "colons": "unit: mm\ntolerance: 0.1\nReference: 5\nn,X\n",
    "cells": "Unit,mm\nTolerance,0.1\nReference,5\nOperator,Anna\nn,X\n",
    "German": "Messmittel Prüfung\nEinheit,mm\nToleranz,0.1 mm\nReferenzwert,5\nn,Messwert\n",
    "below a title": "Gauge study of dial 3\n\nunit: mm\ntolerance: 0.1\nreference: 5\nn,X\n",
}


@pytest.mark.parametrize("head", ALIKE.values(), ids=ALIKE)
def test_a_form_above_the_table_states_what_comments_state(head):
    rows = "".join(f"{k},{5 + (k % 5 - 2) / 1000:.3f}\n" for k in range(50))
    tables = read_gauge_tables([f"{head}{rows}".encode()])
    (dial,) = tables.dials
    assert [*tables.tolerances.values()] == [0.1]
    assert set(dial.reference) == {5.0}
    assert len(dial.values) == 50


def test_what_a_form_says_besides_is_named_and_numbers_above_the_header_are_refused():
    rows = "".join(f"{5 + (k % 5 - 2) / 1000:.3f}\n" for k in range(50))
    tables = read_gauge_tables([f"Page 1 of 3\nunit: mm\nX\n{rows}".encode()])
    assert any("'Page 1 of 3' not used" in note for note in tables.notes)
    with pytest.raises(DataError, match="here and"):
        read_gauge_tables([f"unit: mm\ntolerance: 0.1\ntolerance: 0.2\nX\n{rows}".encode()])
    with pytest.raises(DataError, match="two tables in one file"):
        read_gauge_tables([b"unit: mm\n5.001,5.002\npart,X\n1,5.001\n2,5.002\n"])


def test_statements_in_a_workbook_are_read(tmp_path):
    book = Workbook()
    for row in [("# tolerance: 0.1", None), ("Einheit", "mm"), ("Referenz", 5.0), ("n", "X")]:
        book.active.append(row)
    for k in range(50):
        book.active.append((k, 5 + (k % 5 - 2) / 1000))
    book.save(tmp_path / "study.xlsx")
    tables = read_gauge_tables([tmp_path / "study.xlsx"])
    assert tables.tolerances == {"X": 0.1}
    assert set(tables.dials[0].reference) == {5.0}


def test_a_mistyped_reading_is_asked_about(tmp_path, rng):
    rows = [
        [p, o, t, 10 + p / 50 + rng.normal(0, 0.001)]
        for p in range(10) for o in "ABC" for t in range(3)
    ]  # fmt: skip
    rows[40][3] += 1

    def asked():
        text = "\n".join(f"{p},{o},{t},{value:.3f}" for p, o, t, value in rows)
        (tmp_path / "s.csv").write_text(f"# unit: mm\npart,operator,trial,X\n{text}\n")
        found = scara_iso.gauge_study(tmp_path / "s.csv", tolerance=0.03)
        return [one.message for one in found.remarks if "mistyped" in one.message]

    (message,) = asked()
    assert message.startswith("reading 41 (11.0")
    assert "part 4, operator B" in message
    rows[40][3] -= 1
    assert asked() == []


def test_a_robots_test_is_not_taken_for_a_dials(tmp_path):
    def warned(head):
        path = type_1(tmp_path / "t.csv", head=("# robot: R1", *head))
        return "scara-iso analyze" in str(scara_iso.gauge_study(path).remarks)

    assert warned(())
    assert not warned(("# reference: 0.81",))


@pytest.mark.parametrize("key", ["Sollwert", "Endmaß", "Normal", "master", "xm"])
def test_a_stated_size_that_is_not_used_is_named_and_no_pass_is_plain_without_a_true_value(
    tmp_path, capsys, key
):
    readings = 5.001 + 0.0008 * np.random.default_rng(1).normal(size=50)
    rows = [f"{k};{x:.3f}" for k, x in enumerate(readings, 1)]
    table = tmp_path / "t1.csv"
    for head, named in ((key, True), ("Referenz", False)):
        lines = [f"{head};5,000 mm", "Auflösung;0,001 mm", "Nr.;X [mm]"]
        table.write_text("\n".join([*lines, *(row.replace(".", ",") for row in rows)]))
        code = main(["gauge-study", str(table), "--tolerance", "0.04"])
        said = " ".join(capsys.readouterr().out.split())
        assert (f"! {head.lower()}: 5,000 mm is not used" in said) == named
        assert ("its bias is not judged" in said) == named
        assert ("Cgk" in said) != named
        assert code == (0 if named else 1)


def test_a_dial_is_named_as_analyze_knows_it(tmp_path):
    rows = [f"{k // 2 % 10};{'AB'[k % 2]};0,80{k % 7}" for k in range(40)]
    table = tmp_path / "t.csv"
    table.write_text("\n".join(["Teil;Prüfer;Messwert X [mm]", *rows]))
    assert list(scara_iso.gauge_study(table).axes) == ["X"]


def with_column(path, heading, cells, x=lambda k: 5 + (k % 5 - 2) / 1000):
    rows = [(cell, f"{x(k):.3f}") for k, cell in enumerate(cells)]
    return written(path, [heading, "X"], rows)


@pytest.mark.parametrize("heading", ["Foo", "Name", "Nennmasse", "Farbe"])
def test_a_column_that_parts_the_readings_is_used_or_asked_about(tmp_path, heading):
    study = with_column(tmp_path / "t.csv", heading, ["a", "b", "c"] * 10)
    with pytest.raises(DataError, match=rf"column '{heading}' parts the readings into 3 groups"):
        scara_iso.gauge_study(study)


@pytest.mark.parametrize(
    ("heading", "cells"),
    [
        ("Nr.", range(1, 31)),
        ("Zyklus", [1, 2, 3] * 10),
        ("Temp [°C]", [20.1] * 15 + [20.2] * 15),
        ("Bemerkung", [""] * 30),
    ],
)
def test_a_count_a_condition_and_an_empty_column_part_nothing(tmp_path, heading, cells):
    study = scara_iso.gauge_study(with_column(tmp_path / "t.csv", heading, cells))
    assert not any("remark" in one.message for one in study.remarks)


def test_a_row_that_a_remark_strikes_is_refused_and_any_other_remark_quoted(tmp_path):
    cells = [""] * 30
    cells[0] = "ungültig"  # the first reading counts too
    with pytest.raises(DataError, match="'ungültig', and readings of this line are counted"):
        scara_iso.gauge_study(with_column(tmp_path / "t.csv", "Bemerkung", cells))
    cells[0] = "neu eingespannt"
    (remark,) = (
        one
        for one in scara_iso.gauge_study(with_column(tmp_path / "t.csv", "Notiz", cells)).remarks
        if "remark" in one.message
    )
    assert "line 4 'neu eingespannt'" in remark.message


@pytest.mark.parametrize(("head", "operators"), [("Werker", 3), ("Opérateur", 3), ("Operador", 3)])
def test_operators_are_known_by_what_they_are_called(tmp_path, rng, head, operators):
    study = crossed(tmp_path / "t.csv", rng)
    study.write_text(study.read_text().replace("operator", head), encoding="utf-8")
    assert figures(study).cells.shape[1] == operators


def test_readings_that_creep_are_no_scatter_of_the_dial(tmp_path):
    creeps = with_column(tmp_path / "t.csv", "n", range(50), lambda k: 5 + k // 5 / 1000)
    still = type_1(tmp_path / "s.csv")
    for table, moves in ((creeps, True), (still, False)):
        remarks = scara_iso.gauge_study(table).remarks
        assert any("move in their order" in one.message for one in remarks) is moves


def readings_with(*below):
    """Return 50 readings of one part, whose Cg of 0.0359 mm is 1.3258, and rows below them."""
    rng = np.random.default_rng(9)
    values = np.round(5.001 + 0.0008 * rng.normal(size=50), 3)
    rows = [f"{k},{value:.3f}" for k, value in enumerate(values, 1)]
    return "\n".join(["# unit: mm", "# resolution: 0.001", "cycle,X", *rows, *below]).encode()


@pytest.mark.parametrize("below", ["Mean,5.001", "Mittelwert,5.001", "max,5.003", "Summe,250.05"])
def test_a_footer_is_no_reading(below):
    tables = readings_with(), readings_with(below)
    alone, together = (scara_iso.gauge_study(one, tolerance=0.0359) for one in tables)
    Cg = [study.axes["X"].figures.Cg for study in (alone, together)]
    assert Cg[0] == Cg[1] == pytest.approx(1.3258, abs=1e-4)
    shown = f"line 54: {below.replace(',', ', ')!r} counts as no reading"
    assert any(shown in note for note in together.notes)


@pytest.mark.parametrize("below", ["x quer,5.001", "s,0.0009"])
def test_a_word_among_numbers_is_asked_about(below):
    with pytest.raises(DataError, match="a summary"):
        scara_iso.gauge_study(readings_with(below), tolerance=0.0359)


def test_what_a_head_says_of_rows_is_a_warning_and_what_is_not_used_is_shown(tmp_path, capsys):
    table = tmp_path / "study.csv"
    rows = "".join(f"{k},{5 + 0.001 * (k % 4):.4f}\n" for k in range(1, 31))
    table.write_text(f"# reading 12 not valid\n# X reads double\n# unit: mm\ncycle,X\n{rows}")
    assert main(["gauge-study", str(table), "--reference", "5", "--tolerance", "0.4"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "rows with a remark count: line 1 'reading 12 not valid'" in out
    assert "'# X reads double' not used" in out
