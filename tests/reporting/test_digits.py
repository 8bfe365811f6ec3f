"""What a figure is printed as: no digit that it does not bear."""

import re
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, strategies as st

import scara_iso
from scara_iso.commands import main
from scara_iso.commands.operator.screen import _figures as live_figures
from scara_iso.diagnosis.closed_loop import close_the_loop
from scara_iso.diagnosis.engine.residual import CyclesWanted
from scara_iso.reporting.diagnosis import diagnosis_report
from scara_iso.reporting.shared.digits import (
    Number,
    U_of_scatter,
    many,
    p_equals,
    p_value,
    result,
    rounded,
)
from scara_iso.tables import read_table


@pytest.mark.parametrize(
    ("figure", "U", "said"),
    [
        (0.014036, 0.01125, "0.014"),
        (0.014036, 0.0037, "0.0140"),
        (0.014036, 0.000996, "0.0140"),  # of 0.0010 the second digit is at 0.0001
        (12.3456, 3.4, "12.3"),
        (1234.6, 340.0, "1235"),
        (0.0, 0.0002, "0.00000"),
        (8.68e-13, 2.1e-13, "8.7e-13"),
        (8.68e-9, 2.1e-9, "0.000000009"),
        (0.014036, 2.1e-13, "0.014036000"),
        (5.1e-17, 2.1e-17, "0.000000000"),  # a computer's rounding
        (0.014036, 0.0, "0.01404"),
        (0.014036, float("inf"), "0.01404"),
    ],
)
def test_a_figure_ends_at_the_second_digit_of_its_uncertainty(figure, U, said):
    assert str(rounded(figure, U)) == said


@given(st.floats(1e-6, 1e6), st.floats(1e-6, 1e3))
def test_rounding_hides_less_than_a_twentieth_of_the_uncertainty(figure, U):
    assert abs(float(str(rounded(figure, U))) - figure) <= max(U / 19, 0.5) * 1.0001


@pytest.mark.parametrize(
    ("value", "ends", "said"),
    [
        (0.03877, (0.01642, 2.789), "0.039 [0.016, 2.789]"),  # one reading carries the figure
        (0.022, (0.018, 0.040), "0.022 [0.018, 0.040]"),
        (-0.0031, (-2.0, -0.001), "-0.0031 [-2.0000, -0.0010]"),
        (0.0031, (-2.0, 2.1), "0.0 [-2.0, 2.1]"),
    ],
)
def test_a_figure_that_is_not_zero_is_never_shown_as_zero(value, ends, said):
    assert str(result(value, ends)) == said


@given(st.floats(1e-4, 1e3), st.floats(0.01, 0.99), st.floats(1.01, 1e4))
def test_of_a_figure_whose_interval_excludes_zero_two_digits_are_shown(value, low, high):
    shown = result(value, (low * value, high * value))
    assert float(str(shown.value)) == pytest.approx(value, rel=0.051)


def test_zero_has_no_sign():
    assert str(result(-0.0002, (-0.007, 0.006), sign="+")) == "+0.000 [-0.007, +0.006]"


def test_the_uncertainty_of_a_scatter_is_that_of_many_samples():
    scatter = np.random.default_rng(9283).normal(size=(20000, 30)).std(axis=1, ddof=1)
    assert U_of_scatter(1.0, 30) == pytest.approx(2 * scatter.std(), rel=0.03)


def test_of_three_cycles_the_parts_of_rp_have_two_digits_of_its_uncertainty(tmp_path, capsys):
    """RP is 0.00792 mm, and U of a scatter of three readings, 2 / sqrt(4), is as much."""
    table, head = tmp_path / "short.csv", "# unit: mm\n# resolution: 0.0001\ncycle,X\n"
    table.write_text(f"{head}1,0.4967\n2,0.5000\n3,0.5033\n")
    assert main(["analyze", str(table), "--cycles", "3", "--all-count", "--full"]) == 0
    assert re.search(r"X +0[.]5000 +0[.]0022 +0[.]0019 ", capsys.readouterr().out)


@pytest.mark.parametrize("at", [0.04203, 0.04197])
def test_a_distance_of_robots_is_shown_on_its_side_of_a_limit(at, tmp_path, capsys):
    for name, middle in (("A", 0.0), ("B", at)):
        rows = "".join(f"{k},{0.5 + middle + 0.01 * (k % 5):.5f}\n" for k in range(1, 32))
        head = f"# serial_number: {name}\n# dial_zero: command\n# unit: mm\n# resolution: 0.00001\n"
        (tmp_path / f"{name}.csv").write_text(f"{head}cycle,X\n{rows}")
    tables = [str(tmp_path / "A.csv"), str(tmp_path / "B.csv")]
    main(["compare", *tables, "--exchangeability", "--limit", "exchangeability=0.042"])
    out = capsys.readouterr().out
    (shown,) = re.findall(r": exchangeability X (0[.][0-9]+)", out)
    assert (float(shown) > 0.042) is (at > 0.042)
    assert (float(shown) < 0.042) is (at < 0.042)


def test_the_live_screen_gives_rp_from_five_readings_on():
    readings = (0.1, 0.11, 0.1, 0.1, 0.12, 0.1)
    assert live_figures(readings[:1]) == ""
    assert live_figures(readings[:2]) == "n 2  mean 0.105"
    assert "RP" not in live_figures(readings[:4])
    assert live_figures(readings[:5]) == "n 5  mean 0.1060  RP 0.019"


@dataclass
class Result:
    p_value: float
    p_value_at_floor: bool


@pytest.mark.parametrize(
    ("p", "at_floor", "said"),
    [
        (0.034, False, "p = 0.034"),
        (1.0, False, "p = 1"),
        (1 / 950, True, "p <= 0.0011"),
        (0.001, True, "p <= 0.001"),
        (1 / 300, True, "p <= 0.0034"),  # rounded up: 0.0033 would claim more than was shown
    ],
)
def test_a_p_value_that_no_shuffle_reached_is_a_bound(p, at_floor, said):
    assert p_equals(Result(p, at_floor)) == said
    assert said in (f"p = {p_value(Result(p, at_floor))}", f"p {p_value(Result(p, at_floor))}")


def test_a_strong_effect_has_a_bound_and_a_weak_one_a_value():
    table = read_table("examples/fum_scara_table1.csv")
    found = close_the_loop(table, None, CyclesWanted(), seed=9283)
    assert found.p_value_at_floor
    assert found.p_value == pytest.approx(1 / 700)
    said = [block.text for section in diagnosis_report(found) for block in section.blocks
            if hasattr(block, "text")]  # fmt: skip
    assert any(line.startswith("p <= 0.0015, probability") for line in said)
    quiet = close_the_loop(read_table("examples/scatter.csv"), None, CyclesWanted(), seed=9283)
    assert not quiet.p_value_at_floor


def test_of_one_there_is_no_plural():
    assert [many(n, "part") for n in (0, 1, 2)] == ["0 parts", "1 part", "2 parts"]


def test_where_rp_of_an_angle_is_not_3_s_it_says_so_with_its_unit(rng, tmp_path):
    rows = "".join(f"{c},{x:.3f}\n" for c, x in enumerate(rng.normal(0, 0.02, 31), 1))
    table = f"# resolution: 0.001 deg\n# robot: R\ncycle,theta_deg\n{rows}"
    found = scara_iso.diagnose(table.encode())
    RP, said = found.repeatability.measured["theta"], str(diagnosis_report(found))
    assert f"RP  theta (eq. 2-6) {rounded(RP, U_of_scatter(RP, 30))} deg" in said
    assert "theta (deg, eq. 2-6)" in said
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "a.csv").write_text(table)
    fleet = scara_iso.fleet_figures(tmp_path / "parts", tmp_path / "out", workers=1)
    assert "RP theta (eq. 2-6)" in fleet._repr_html_()


def test_a_figure_that_rounds_to_zero_has_no_sign():
    assert "-" not in str(rounded(-0.00001, 0.01))


@pytest.mark.parametrize("spec", [".6f", "+.6f", ".9f", "+.9f", "+.0%"])
def test_the_sign_of_what_is_zero_hangs_on_no_rounding_of_sums(spec):
    assert str(Number(-1e-16, spec)) == str(Number(1e-16, spec))
