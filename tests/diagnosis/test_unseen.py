"""RP of cycles that no fit saw, and folds that decide anew whether there is an effect."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from scara_iso.commands import main
from scara_iso.diagnosis.engine.fit import problem_of
from scara_iso.diagnosis.engine.search import find, find_again
from scara_iso.diagnosis.readings import diagnose_readings
from scara_iso.effects import find_effects
from scara_iso.iso9283 import repeatability
from scara_iso.run import Axis, Run

TABLE_1 = str(Path(__file__).parents[2] / "examples" / "fum_scara_table1.csv")
STEP = 1.0 * (np.arange(30) >= 14)


def run_of(x):
    return Run(np.arange(2, 32), {"X": Axis("X", x, resolution=0.001)})


def unseen(x, held_out=None):
    return diagnose_readings(run_of(x), held_out=held_out).repeatability.unseen


def test_every_other_cycle_is_foretold_by_the_rest():
    x = (0.004 * np.random.default_rng(3).normal(size=30) + 0.03 * STEP).round(3)
    found = unseen(x)
    assert (found.of, found.cycles) == ("every other cycle", 15)
    assert found.measured["X"] == pytest.approx(float(repeatability(x[np.newaxis, 1::2]).RP))
    assert found.model_before["X"] == 0
    told = found.completed["X"]
    assert told.interval[0] < found.measured["X"] < told.interval[1]
    assert told.interval[0] > 0.02  # the step is part of it: scatter alone would give 0.011


def test_the_second_table_is_foretold():
    rng = np.random.default_rng(4)
    first, second = ((0.004 * rng.normal(size=30) + 0.03 * STEP).round(3) for _ in range(2))
    found = unseen(first, run_of(second))
    assert (found.of, found.cycles) == ("the second table", 30)
    assert found.measured["X"] == pytest.approx(float(repeatability(second[np.newaxis]).RP))
    told = found.completed["X"]
    assert told.interval[0] < found.measured["X"] < told.interval[1]


def test_an_axis_that_begins_to_scatter_leaves_the_next_test_of_the_other_as_it_is():
    rng = np.random.default_rng(3)
    wider = np.where(np.arange(30) < 15, 0.001, 0.02)
    x, y = (rng.normal(size=30) * size for size in (wider, 0.005))
    axes = {n: Axis(n, one.round(4), resolution=1e-4) for n, one in (("X", x), ("Y", y))}
    found = diagnose_readings(Run(np.arange(2, 32), axes))
    assert [(one.effect, one.axes) for one in found.effects] == [("scatter_change", ("X",))]
    told, measured = found.repeatability.completed["Y"], float(repeatability(y[np.newaxis]).RP)
    assert told.value == pytest.approx(measured, rel=0.3)


def test_the_next_test_of_a_dial_without_steps_is_foretold():
    x = 0.004 * np.random.default_rng(3).normal(size=30) + 0.03 * STEP
    found = diagnose_readings(Run(np.arange(2, 32), {"X": Axis("X", x)}))
    low, high = found.repeatability.completed["X"].interval
    assert 0.02 < low < float(repeatability(x[np.newaxis]).RP) < high


SIDES = 0.02
MECHANISMS = {
    "anew": lambda rng: SIDES * (rng.random(30) < 0.5),
    "rarely the upper": lambda rng: SIDES * (rng.random(30) < 0.2),
    "stay": lambda rng: SIDES * (np.cumsum(rng.random(30) < 0.2) % 2),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", MECHANISMS)
def test_a_new_test_has_its_own_order_of_sides(name):
    rng = np.random.default_rng(5)

    def readings():
        return (MECHANISMS[name](rng) + 0.002 * rng.normal(size=30)).round(3)

    inside = []
    for _ in range(12):
        low, high = diagnose_readings(run_of(readings())).repeatability.completed["X"].interval
        RP = repeatability(np.stack([readings() for _ in range(20)])[:, np.newaxis]).RP
        inside.append(((low <= RP) & (RP <= high)).mean())
    assert np.mean(inside) > 0.85  # 0.41 to 0.69 where the sides of the first test came again


def test_the_sides_of_unseen_cycles_are_not_known():
    rng = np.random.default_rng(6)
    for _ in range(3):
        found = unseen((MECHANISMS["anew"](rng) + 0.002 * rng.normal(size=30)).round(3))
        low, high = found.completed["X"].interval
        assert low < found.measured["X"] < high


def test_a_fold_that_would_not_find_the_effect_has_none():
    rng = np.random.default_rng(6)
    run = run_of((0.004 * rng.normal(size=30) + 0.01 * STEP).round(3))
    problem = problem_of(run, directions={}, effects=find_effects())
    terms, stages = find(problem, rng)
    assert len(terms) == 1
    assert np.isfinite(stages[0].limit)
    assert stages[0].order.statistic > stages[0].limit
    rows = problem.rows[2:]
    for limit, count in ((stages[0].limit, 1), (stages[0].order.statistic + 5, 0)):
        assert len(find_again(problem, rows, [replace(stages[0], limit=limit)])) == count


def test_it_is_told(capsys):
    assert main(["diagnose", TABLE_1, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)["repeatability"]["unseen"]
    assert document["cycles"] == 15
    for name in ("X", "Y", "Z", "theta", "XY"):
        low, high = document["completed"][name]["interval"]
        assert low <= document["measured"][name] <= high
    assert main(["diagnose", TABLE_1, "--full", "--hold-out", TABLE_1]) == 0
    said = capsys.readouterr().out
    assert "held out: on the second table" in said
    assert "of the second table: 30 cycles that the completed model has not seen" in said
    assert "none of its cycles is unseen" in " ".join(said.split())
