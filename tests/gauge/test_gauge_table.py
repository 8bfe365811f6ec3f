"""What is stated of a gauge study: in its table, and by whoever asks for it."""

import json
import math
import re

import numpy as np
import pytest
from scipy import stats

import scara_iso
from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.published import to_json
from scara_iso.commands import main
from scara_iso.gauge import Criterion
from scara_iso.iso9283 import DecisionRule
from scara_iso.reporting import study_picture
from scara_iso.reporting.gauge_study import _criterion

HEAD = "# unit: mm\n# resolution: 0.001\n# tolerance: 0.04\n"
TABLE = HEAD + "cycle,X\n" + "".join(f"{k},{5 + 0.001 * (k % 4):.3f}\n" for k in range(1, 31))


def test_a_tolerance_may_be_stated_twice_and_not_in_two_ways():
    alone, twice = (scara_iso.gauge_study(TABLE.encode(), tolerance=t) for t in (None, 0.04))
    assert twice.axes["X"].figures == alone.axes["X"].figures
    with pytest.raises(UsageError, match="the tolerance is stated in two ways") as caught:
        scara_iso.gauge_study(TABLE.encode(), tolerance=0.05)
    assert caught.value.remedy == "leave one"


def study(head="", rows=10, columns="cycle,X"):
    lines = "".join(f"{k}{',5.00' * columns.count(',')}{k % 4}\n" for k in range(1, rows + 1))
    return f"# unit: mm\n# resolution: 0.001\n{head}{columns}\n{lines}".encode()


@pytest.mark.parametrize(
    ("one", "other", "said"),
    [
        ({}, {"head": "# resolution_X: 0.01\n"}, "the tables have not the same resolution"),
        ({"head": "# part: 1\n"}, {}, "states no part, and another table does"),
        ({}, {"columns": "cycle,Y"}, "has the dials Y, and another table X"),
    ],
)
def test_tables_of_one_study_are_of_one_dial_and_state_the_same(one, other, said):
    with pytest.raises(DataError, match=said):
        scara_iso.gauge_study([study(**one), study(**other)], tolerance=0.1)


def test_tables_that_differ_in_nothing_are_sessions():
    found = scara_iso.gauge_study([study(), study(rows=12)], tolerance=0.1)
    assert found.axes["X"].figures.n == 22


def test_a_tolerance_with_a_unit_is_of_the_kind_of_the_readings():
    with pytest.raises(UsageError, match="`tolerance=30deg`: the readings are in mm"):
        scara_iso.gauge_study(study(), tolerance="30deg")
    found = scara_iso.gauge_study(study(), tolerance="30um")
    assert found.axes["X"].tolerance == pytest.approx(0.03)


def test_the_whole_study_is_advised_where_it_is_not_shown(tmp_path, capsys):
    (tmp_path / "dial.csv").write_bytes(study(rows=30))
    words = ["gauge-study", str(tmp_path / "dial.csv"), "--reference", "5", "--tolerance", "0.1"]
    advised = []
    for more in ([], ["--full"]):
        main([*words, *more])
        advised.append("Next: scara-iso gauge-study" in capsys.readouterr().out)
    assert advised == [True, False]


def test_sessions_of_one_reading_have_no_scatter_of_their_own_to_compare():
    lines = "".join(f"{k},5.00{k % 4}\n" for k in range(1, 13))
    found = scara_iso.gauge_study(f"# unit: mm\nsession,X\n{lines}".encode(), tolerance=0.1)
    stability = found.axes["X"].figures
    assert stability.between == 0
    moves = np.abs(np.diff([0.001 * (k % 4) for k in range(1, 13)]))
    assert stability.sigma == pytest.approx(moves.mean() / 1.128, rel=1e-3)  # d2 of two: ISO 7870-2


def test_between_sessions_is_what_the_scatter_within_them_leaves():
    lines = "".join(
        f"{k},{5 + 0.01 * k + sign * 0.002:.3f}\n" for k in range(5) for sign in (1, -1)
    )
    found = scara_iso.gauge_study(f"# unit: mm\nsession,X\n{lines}".encode(), tolerance=0.1)
    sigma = 0.002 * math.sqrt(2) / 0.7979  # c4 of two readings: ISO 7870-2
    between = math.sqrt(np.var(0.01 * np.arange(5), ddof=1) - sigma**2 / 2)
    assert found.axes["X"].figures.between == pytest.approx(between, rel=1e-4)


def test_a_session_of_one_reading_among_others_has_the_sigma_of_theirs():
    x = np.random.default_rng(4).normal(5, 0.002, (20, 5)).round(4)
    rows = [f"{k},{one}\n" for k, readings in enumerate(x) for one in readings]
    whole, alone = (
        scara_iso.gauge_study(f"# unit: mm\nsession,X\n{''.join(lines)}".encode()).axes["X"].figures
        for lines in (rows[:95], rows[:96])
    )
    assert alone.sigma == whole.sigma
    assert alone.half_width[-1] == pytest.approx(3 * alone.sigma)
    assert (alone.scatters, alone.outside) == ((*whole.scatters, None), whole.outside)


def test_one_session_of_two_readings_among_single_ones_does_not_decide_their_sigma():
    x = 5 + 0.001 * (np.arange(12) % 4)
    lines = "".join(f"{k},{one:.3f}\n" for k, one in enumerate(x))
    once, twice = (
        scara_iso.gauge_study(f"# unit: mm\nsession,X\n{lines}{more}".encode()).axes["X"].figures
        for more in ("", f"11,{x[11]:.3f}\n")
    )
    steps = np.abs(np.diff(x)) * np.array([*[1] * 10, math.sqrt(2 / 1.5)])
    assert once.sigma == pytest.approx(np.abs(np.diff(x)).mean() / 1.128, rel=1e-3)
    assert twice.sigma == pytest.approx(steps.mean() / 1.128, rel=1e-3)


def test_bias_and_capability_of_one_part_are_those_of_t_and_chi_square():
    readings = np.round(np.random.default_rng(2).normal(5.001, 0.002, 8), 4)
    lines = "".join(f"{k},{x}\n" for k, x in enumerate(readings, 1))
    table = f"# unit: mm\ncycle,X\n{lines}".encode()
    found = scara_iso.gauge_study(table, reference=5.0, tolerance=0.1).axes["X"].figures
    test = stats.ttest_1samp(readings, 5.0)
    assert (found.t, found.p_value) == pytest.approx((test.statistic, test.pvalue))
    s = readings.std(ddof=1) * np.sqrt(7 / stats.chi2.ppf((0.975, 0.025), 7))
    assert found.s_interval == pytest.approx(tuple(s), rel=1e-6)
    assert found.Cg_interval == pytest.approx(tuple(0.2 * 0.1 / (6 * s[::-1])), rel=1e-6)


def test_the_picture_of_sessions_has_each_above_its_name():
    lines = "".join(f"{name},5.00{k}\n" for k, name in enumerate("abcdef"))
    found = scara_iso.gauge_study(f"# unit: mm\nsession,X\n{lines}".encode(), tolerance=0.1)
    picture = study_picture(found.axes["X"])
    assert picture.ticks == tuple("abcdef")  # the names of 1, 2, 3 and so on
    for curve in picture.panels[0].curves:
        assert curve.x.tolist() == [1, 2, 3, 4, 5, 6]


def of_angles(zero, parts=(0,)):
    apart = np.round(np.random.default_rng(3).normal(0.005, 0.02, 30), 2)
    rows = "".join(f"{p},{(zero + p + x) % 360:.2f}\n" for p in parts for x in apart)
    return f"# resolution: 0.01 deg\npart,theta_deg\n{rows}".encode()


@pytest.mark.parametrize("reference", [0, 360, None])
def test_angles_about_a_full_turn_lie_together(reference):
    stated = None if reference is None else 40
    found = scara_iso.gauge_study(of_angles(0), tolerance=1, reference=reference)
    alike = scara_iso.gauge_study(of_angles(40), tolerance=1, reference=stated)
    one, other = found.axes["theta"].figures, alike.axes["theta"].figures
    assert (one.s, one.Cg, one.bias) == pytest.approx((other.s, other.Cg, other.bias))
    turned = [
        [r.message for r in of.remarks if "a full turn" in r.message] for of in (found, alike)
    ]
    assert turned == [["passes a full turn and is unwrapped"], []]


def test_parts_all_around_the_circle_lie_together_each():
    parts = (0, 90, 180, 270)
    one, other = (
        scara_iso.gauge_study(of_angles(zero, parts)).axes["theta"].figures for zero in (0, 40)
    )
    assert one.components["EV"].sigma == pytest.approx(other.components["EV"].sigma)
    with pytest.raises(DataError, match="scatter over more than half a turn"):
        scara_iso.gauge_study(b"part,theta_deg\n" + b"1,0\n1,90\n1,180\n1,270\n1,350\n")


STILL = {
    "type_1": ("cycle,X", [f"{k}," for k in range(30)]),
    "crossed": ("part,operator,X", [f"{k % 5},{k % 3}," for k in range(30)]),
    "stability": ("session,X", [f"{k // 3}," for k in range(30)]),
}


@pytest.mark.parametrize("decision", ["simple", "interval"])
@pytest.mark.parametrize("kind", STILL)
@pytest.mark.parametrize("at", ["0.811", "0.1"])
def test_of_readings_that_are_all_alike_no_interval_is_known_and_nothing_is_proven(
    kind, decision, at
):
    columns, rows = STILL[kind]
    table = f"# unit: mm\n{columns}\n" + "".join(f"{row}{at}\n" for row in rows)
    reference = None if kind != "type_1" else 0.81
    found = scara_iso.gauge_study(
        table.encode(), tolerance=1, reference=reference, decision=decision
    )
    assert {one.verdict.value for one in found.criteria} == {"not-provable"}
    assert re.findall(r'"[\w_]*interval": \[', json.dumps(to_json(found))) == []


def criterion(name, value, limit):
    return Criterion(name, "", "X", value, None, limit, decision=DecisionRule.SIMPLE)


@pytest.mark.parametrize(
    ("one", "said"),
    [
        (criterion("R&R/T", 0.3004, 0.3), "30.04%"),
        (criterion("R&R/T", 0.2, 0.3), "20.0%"),
        (criterion("Q_MS", 0.15, 0.15), "15.0%"),
        (criterion("sessions outside", 1.0, 0), "1"),
        (criterion("sessions outside", 0.0, 0), "0"),
        (criterion("ndc", 4.99, 5), "4"),
    ],
)
def test_a_share_is_shown_on_its_side_of_the_limit_and_a_count_whole(one, said):
    assert str(_criterion(one)) == said
