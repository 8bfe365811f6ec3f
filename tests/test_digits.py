"""What a figure is printed as: no digit that it does not bear."""

from dataclasses import dataclass

import pytest

from scara_iso.closing import CyclesWanted, close_the_loop
from scara_iso.report.diagnosis import diagnosis_report
from scara_iso.report.digits import p_equals, p_value
from scara_iso.tables import read_table


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
    assert found.p_value == pytest.approx(1 / 950)
    said = [block.text for section in diagnosis_report(found, "t") for block in section.blocks
            if hasattr(block, "text")]  # fmt: skip
    assert any(line.startswith("p <= 0.0011, probability") for line in said)
    quiet = close_the_loop(read_table("examples/scatter.csv"), None, CyclesWanted(), seed=9283)
    assert not quiet.p_value_at_floor
