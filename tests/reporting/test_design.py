"""What a planned test will be able to tell, in words."""

import numpy as np

from scara_iso.diagnosis.planning import Alike, Change, Design, PlannedRun
from scara_iso.effects import Conditions
from scara_iso.reporting import Number, Table, Text, design_report

PLAN = PlannedRun(
    Conditions(np.arange(2, 32), {"temperature_C": np.full(30, 20.0)}), sigma=0.01, division=0.002
)


def test_a_design_shows_each_travel_beside_that_of_each_change():
    found = Design(
        plan=PLAN,
        smallest={"step": 0.0234, "linear_drift": None},
        alike=(Alike(("linear_drift", "warm_up"), 0.968),),
        changes=(
            Change("sixty cycles", {"step": 0.0171, "linear_drift": 0.0298}),
            Change("with the load recorded", {"step": 0.0234, "compliance": 0.05}),
        ),
    )
    head, smallest, alike = design_report(found)
    said = [block.text for block in head.blocks if isinstance(block, Text)]
    assert said[1] == ("30 cycles, scatter 0.01 mm, dial 0.002 mm, columns: temperature_C")
    (table,) = smallest.blocks
    assert isinstance(table, Table)
    assert table.header == ("effect", "as planned", "a", "b")
    shown = [
        [str(cell) if isinstance(cell, Number) else cell for cell in row] for row in table.rows
    ]
    assert shown == [
        ["step", "0.0234", "0.0171", "0.0234"],
        ["linear drift", "-", "0.0298", ""],  # not found at all; not asked
        ["compliance", "", "", "0.0500"],
    ]
    assert table.note == "a: sixty cycles; b: with the load recorded"
    (pair,) = alike.blocks
    assert pair.text == "linear drift and warm up (cosine 0.97)"


def test_a_design_without_changes_or_columns_says_so():
    plan = PlannedRun(Conditions(np.arange(2, 32)), sigma=0.01, division=0.0)
    head, smallest, alike = design_report(
        Design(plan=plan, smallest={"step": 0.02}, alike=(), changes=())
    )
    assert head.blocks[1].text.endswith("columns: none")
    assert smallest.blocks[0].note == ""
    assert alike.blocks[0].text == "every pair of effects has shapes that differ"
