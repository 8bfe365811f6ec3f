"""The table of limits: how many cycles a proof wants."""

import pytest

from scara_iso.iso9283 import DecisionRule, LimitCheck
from scara_iso.reporting.shared.limits import table_of_limits


@pytest.mark.parametrize(
    ("interval", "cycles", "void", "said"),
    [
        ((0.02, 0.09), None, False, ""),  # decided
        ((0.12, 0.19), None, False, ""),
        ((0.02, 0.19), 62, False, "62"),
        ((0.02, 0.19), None, False, "no number suffices"),
        ((0.02, 0.19), 62, True, "find the cause first"),
        ((0.02, 0.19), 100_000, False, "over 100000"),
    ],
)
def test_cycles_are_said_where_a_limit_is_not_decided(interval, cycles, void, said):
    check = LimitCheck(
        figure="X", code="RP", RP=sum(interval) / 2, limit=0.1, guard=None, pose=None,
        interval=interval, decision=DecisionRule.INTERVAL, cycles_wanted=cycles,
        interval_void=void,
    )  # fmt: skip
    (section,) = table_of_limits([check])
    (table,) = section.blocks
    row = dict(zip(table.header, table.rows[0], strict=True))
    assert str(row["cycles needed"]) == said
