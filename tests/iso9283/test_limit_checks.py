"""A figure against its limits: at most the one, at least the other, both included."""

import pytest

from scara_iso.iso9283 import Conformity, DecisionRule, LimitCheck

PASS, FAIL, OPEN = Conformity.PASS, Conformity.FAIL, Conformity.NOT_PROVABLE


def check(value, interval, rule):
    return LimitCheck(
        figure="AP X", code="AP", RP=value, limit=0.1, guard=None, pose=None, interval=interval,
        decision=rule, cycles_wanted=None, lower=-0.1,
    ).verdict  # fmt: skip


@pytest.mark.parametrize(
    ("value", "verdict"),
    [(-0.11, FAIL), (-0.1, PASS), (0.0, PASS), (0.1, PASS), (0.11, FAIL)],
)
def test_by_simple_acceptance_the_figure_decides_at_its_limits_too(value, verdict):
    assert check(value, None, DecisionRule.SIMPLE) is verdict


@pytest.mark.parametrize(
    ("interval", "verdict"),
    [
        ((-0.3, -0.11), FAIL), ((-0.3, -0.1), OPEN), ((-0.11, 0.0), OPEN), ((-0.1, 0.1), PASS),
        ((0.0, 0.11), OPEN), ((0.1, 0.3), OPEN), ((0.11, 0.3), FAIL), ((-0.3, 0.3), OPEN),
        (None, OPEN),
    ],
)  # fmt: skip
def test_by_the_interval_all_of_it_decides(interval, verdict):
    assert check(0.0, interval, DecisionRule.INTERVAL) is verdict
