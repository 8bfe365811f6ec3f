"""Where a finding, a refusal or a figure turns, from both sides; figures against sums of their own.

What is asked here is the package from outside: `analyze` of a run, and what it says and gives.
"""

import math
from datetime import date
from itertools import combinations, permutations

import numpy as np
import push_rig
import pytest
from scipy.special import rel_entr
from scipy.stats import binom
from test_characteristics import drift_test
from test_checks import clean_run, x_axis

from scara_iso.base.errors import DataError
from scara_iso.base.quantities import Dimension
from scara_iso.iso9283 import (
    moment_of_test,
    past_due,
    push_test,
)
from scara_iso.iso9283.analysis import analyze
from scara_iso.iso9283.core.cycles import Counting
from scara_iso.iso9283.core.drift import drift_courses
from scara_iso.iso9283.core.slips import find_repeats
from scara_iso.iso9283.core.statistics import GAUSSIAN_RP, repeatability, rp_interval
from scara_iso.run import Axis, Run
from scara_iso.signals import ForceLoop
from scara_iso.tables import read_table


def one_pose(rng, covariates=None, metadata=None, cycles=31, **axes):
    axes = axes or {"X": Axis("X", rng.normal(0, 0.01, cycles))}
    return Run(np.arange(1, cycles + 1), axes, covariates=covariates or {}, metadata=metadata or {})


def figure(run, code, of="X", **options):
    """Return the estimate of a characteristic."""
    found = [one for one in analyze(run, **options).characteristics if one.code == code]
    return next(one.estimate for one in found if one.of == of)


def test_a_frame_names_the_unit_of_each_row(rng):
    axes = {name: Axis(name, rng.normal(0, 0.01, 31)) for name in "XY"}
    axes["theta"] = Axis("theta", rng.normal(0, 0.01, 31), Dimension.ANGLE)
    frame = analyze(one_pose(rng, **axes)).to_frame()
    assert dict(zip(frame["figure"], frame["unit"], strict=True)) == {
        "X": "mm", "Y": "mm", "theta": "deg", "XY": "mm"
    }  # fmt: skip


def test_a_frame_has_the_figure_of_an_angle_by_which_a_limit_goes(rng):
    axes = {"X": Axis("X", rng.normal(0, 0.01, 31))}
    axes["theta"] = Axis("theta", rng.normal(0, 0.01, 31), Dimension.ANGLE)
    found = analyze(one_pose(rng, **axes), limits={"theta": 0.02})
    frame = found.to_frame().set_index("figure")
    (held,) = found.limits
    assert frame.loc["theta", "RP_a"] == held.RP != frame.loc["theta", "RP"]
    assert tuple(frame.loc["theta", ["RP_a_low", "RP_a_high"]]) == held.interval
    assert np.isnan(frame.loc["X", "RP_a"])


@pytest.mark.parametrize(("far", "said"), [(1, True), (3, True), (4, False)])
def test_more_than_three_gross_readings_are_no_single_ones(rng, far, said):
    readings = rng.normal(0, 0.01, 31).round(3)
    readings[5 : 5 + far] += 0.3
    found = [f for f in analyze(clean_run(rng, X=x_axis(readings))).findings
             if f.code == "gross-reading"]  # fmt: skip
    assert bool(found) is said


def test_the_sampling_of_a_stream_bounds_a_stabilisation_time(rng):
    covariates = {"stabilisation_X_s": np.full(31, 0.15)}
    found = figure(one_pose(rng, covariates, {"stream_rate_hz": "100"}), "stabilisation_time")
    ends = rng.uniform(0, 0.01, (2, 200_000))  # each crossing lies anywhere between two samples
    assert found.u == pytest.approx(np.std(ends[1] - ends[0]), rel=0.01)
    assert found.interval == pytest.approx((0.15 - 2 * found.u, 0.15 + 2 * found.u))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda block, _: block[::-1], "not numbered in order"),
        (lambda block, _: block + 0.5, "not numbered in order"),
        (lambda block, time: (block, time[::-1]), "times go back"),
        (lambda block, _: block * 0, "fewer than 2 blocks of 2 visits"),
        (lambda block, _: np.arange(len(block)) / 1.0, "fewer than 2 blocks of 2 visits"),
    ],
)
def test_a_stated_drift_test_of_no_blocks_is_refused(rng, change, said):
    block, time = np.repeat(np.arange(1.0, 7.0), 5), np.arange(30.0)
    changed = change(block, time)
    block, time = changed if isinstance(changed, tuple) else (changed, time)
    run = one_pose(rng, {"block": block, "time_s": time}, {"test": "drift"}, cycles=30)
    with pytest.raises(DataError, match=said):
        analyze(run)


def test_two_visits_a_block_are_enough_for_a_drift_test(rng):
    block, time = np.repeat(np.arange(1.0, 16.0), 2), np.arange(30.0)
    run = one_pose(rng, {"block": block, "time_s": time}, {"test": "drift"}, cycles=30)
    assert len(np.unique(analyze(run).block)) == 15


def binary_rows(rng, visits, twice):
    """Return visits of one axis, some of them written twice."""
    return np.repeat(rng.normal(0, 1, visits), np.isin(np.arange(visits), twice) + 1)[:, np.newaxis]


def test_the_chance_of_repeats_is_bounded_and_not_by_much(rng):
    """Twice Chernoff's bound of a binomial, with the share of near rows that a fine dial has."""
    visits, twice = 40, [2, 3, 7, 12, 20, 21, 30]
    found = find_repeats(binary_rows(rng, visits, twice), np.zeros(1))
    share = 1 / (1 + sum(visits - lag for lag in (1, 2, 3)))
    part = len(twice) / visits
    bound = math.exp(-visits * (rel_entr(part, share) + rel_entr(1 - part, 1 - share)))
    assert (found.rows, found.visits, found.repeated) == (47, 40, 7)
    assert found.p_value == pytest.approx(2 * bound, rel=1e-9)
    assert binom.sf(len(twice) - 1, visits, share) <= bound


def test_a_rhythm_of_repeats_is_counted_as_all_places_that_have_one():
    """Against all ways to lay changes among the rows, one by one."""
    rows, every = 13, 3
    visits = np.array([0.0, 1.0, 10.0, 11.0, 20.0])  # half of them near the one before
    readings = np.repeat(visits, every)[:rows, np.newaxis]
    changes = np.flatnonzero(np.diff(readings[:, 0]))
    ways = sum(
        len({place % k for place in places}) == 1
        for k in range(every, rows - 1)
        for places in combinations(range(rows - 1), len(changes))
    )
    found = find_repeats(readings, np.ones(1))
    assert found.p_value == pytest.approx(2 * ways / math.comb(rows - 1, len(changes)))


def test_the_uncertainty_of_a_push_test_is_that_of_its_fit(rng):
    """The figures as functions of compliance, play and friction, differentiated by steps."""
    force, reading = push_rig.readings(rng, noise=0.001, half_play=0.03, friction=5.0)
    found = push_test(ForceLoop(force, reading))
    c, b, friction = found.fit.compliance, found.fit.half_play, found.fit.friction
    functions = {
        "lost_motion": lambda c, b, _: 2 * b,
        "friction_width": lambda c, _, friction: 2 * c * friction,
        "hysteresis": lambda c, b, friction: 2 * (b + c * friction),
        "compliance": lambda c, *_: 100 * c,
        "friction_force": lambda *of: of[2],
    }
    for code, of in functions.items():
        point, steps = np.array([c, b, friction]), np.diag([1e-7 * c, 1e-7 * b, 1e-7 * friction])
        slope = [(of(*(point + s)) - of(*(point - s))) / (2 * s.sum()) for s in steps]
        estimate = found.estimate(code, "reading")
        assert estimate.value == pytest.approx(of(c, b, friction))
        assert estimate.u == pytest.approx(
            math.sqrt(slope @ found.fit.covariance @ slope), rel=1e-4
        )
    known = push_test(ForceLoop(force, reading, uncertainty=0.002))
    certified = {one.code for one in known.characteristics if one.calibration == 0.002}
    assert certified == {"lost_motion", "friction_width", "hysteresis"}
    apart = math.sqrt(2) * 0.002  # of two readings, in mm; a loop is 2 c wide for each newton
    for code, reach in {"lost_motion": apart, "friction_force": apart / (2 * c)}.items():
        assert known.estimate(code, "reading").parts["reading"] == pytest.approx(reach)
    frame = known.to_frame()
    intervals = [one.estimate.interval for one in known.characteristics]
    assert list(zip(frame["low"], frame["high"], strict=True)) == intervals


def test_cycles_wanted_shrink_the_reach_to_the_room_that_is_left(rng):
    """Four of five tests prove it: of a mean by the reach, of RP by the errors in its logarithm."""
    x = Axis("X", rng.normal(0.02, 0.01, 31), command=0.0)
    run = one_pose(rng, metadata={"dial_zero": "command"}, X=x)
    RP, AP = figure(run, "RP"), figure(run, "AP")
    for end, held, proven in zip(RP.interval, (-2, 10), (2, 10), strict=True):
        reach = abs(math.log(end / RP.value))
        for share in (0.2, 0.9):
            limit = RP.value * (end / RP.value) ** share
            now = min(e for e in np.roots([held, 1.96, -reach]) if e > 0)
            then = max(np.roots([proven, 2.80, -share * reach]))
            wanted = math.ceil(30 * (now / then) ** 2)
            assert limits_of(run, X=limit).cycles_wanted == pytest.approx(wanted, rel=1e-3, abs=1)
    reach = AP.interval[1] - AP.value
    for side, share in ((1, 0.2), (-1, 0.2), (1, 0.9), (-1, 0.9)):
        limit = AP.value + side * share * reach
        wanted = math.ceil(30 * (1.3 / share) ** 2)
        assert limits_of(run, AP=limit).cycles_wanted == pytest.approx(wanted, abs=1)
    assert limits_of(run, X=RP.value * 1.0001).cycles_wanted == 100_000
    assert limits_of(run, X=RP.value).cycles_wanted is None
    assert limits_of(run, AP=AP.value).cycles_wanted is None
    low, high = RP.interval
    near = RP.value * (low / RP.value) ** 0.5
    both = limits_of(run, X=(near, 10 * high))
    assert both.cycles_wanted == limits_of(run, X=near).cycles_wanted


@pytest.mark.parametrize(
    ("axes", "share"), [("X", 0.7), ("X", 0.8), ("X", 0.9), ("XY", 0.8), ("X", 1.2), ("XY", 1.1)]
)
def test_the_cycles_wanted_prove_a_limit_in_about_4_of_5_tests(axes, share):
    rng, k = np.random.default_rng(9283), len(axes)
    limit = GAUSSIAN_RP[k] / share
    wanted = []
    while len(wanted) < 25:  # tests that read about the true figure
        x = rng.normal(size=(k, 30))
        if abs(repeatability(x).RP / GAUSSIAN_RP[k] - 1) < 0.03:
            rows = {n: Axis(n, row, resolution=1e-6) for n, row in zip(axes, x, strict=True)}
            run = Run(np.arange(2, 32), rows)
            wanted.append(analyze(run, limits={axes: limit}).limits[0].cycles_wanted)
    n = int(np.median([count for count in wanted if count]))
    low, high = rp_interval(rng.normal(size=(400, k, n)), None)
    assert 0.7 <= np.mean(high <= limit if share < 1 else low > limit) <= 0.9


def limits_of(run, **limits):
    (found,) = analyze(run, limits=limits).limits
    return found


def test_what_the_calibration_leaves_is_shrunk_by_no_cycle(rng):
    """Reach and room of a mean, each without the calibration in quadrature."""
    u = 0.001
    x = Axis("X", rng.normal(0.02, 0.01, 31), uncertainty=u, command=0.0)
    run = one_pose(rng, metadata={"dial_zero": "command"}, X=x)
    AP = figure(run, "AP")
    reach, room = AP.interval[1] - AP.value, 0.003
    wanted = 30 * 1.3**2 * (reach**2 - 4 * u**2) / (room**2 - 4 * u**2)
    assert limits_of(run, AP=AP.value + room).cycles_wanted == math.ceil(wanted)
    assert limits_of(run, AP=AP.value + 1.99 * u).cycles_wanted is None


def test_a_distance_wants_two_cycles_that_both_poses_have(rng):
    def codes_with(missing):
        pose, cycle = np.tile(["P1", "P2"], 31), np.repeat(np.arange(1, 32), 2)
        command = {"P1": 0.0, "P2": 40.0}
        x = Axis("X", rng.normal(0, 0.01, 62) + np.where(pose == "P2", 40, 0), command=command)
        kept = ~((pose == "P1") & np.isin(cycle, missing[0]))
        kept &= ~((pose == "P2") & np.isin(cycle, missing[1]))
        run = Run(cycle, {"X": x}, pose, metadata={"dial_zero": "command"})
        found = analyze(run.take(np.flatnonzero(kept)), Counting(allow_gaps=True))
        return {one.code for one in found.characteristics}

    assert {"AD", "RD"} <= codes_with((range(4, 18), [2, *range(18, 31)]))  # both have 3 and 31
    assert not {"AD", "RD"} & codes_with((range(3, 18), [2, *range(18, 31)]))


def test_three_changes_make_a_rhythm():
    """Four visits of four rows each, the first like the third: half of the rows two apart."""
    visits = np.array([0.0, 10.0, 1.0, 20.0])
    found = find_repeats(np.repeat(visits, 4)[:, np.newaxis], np.ones(1))
    assert found.p_value < 2 * 0.5**4


def test_each_of_a_batch_of_poses_has_its_number_of_cycles(rng):
    assert repeatability(rng.normal(size=(4, 2, 30))).n == 30


def test_advice_on_what_cannot_be_compared_can_be_followed(rng):
    """What the finding advises to write is compared when it is written."""
    for key, wrong in [("payload", "two kilos"), ("velocity", "fast"), ("temperature", "warm"),
                       ("dwell", "a while"), ("date", "2027-02-30")]:  # fmt: skip
        stated = {"stabilisation_time": "0.1 s"}
        unclear = [f for f in analyze(clean_run(rng, metadata={**stated, key: wrong})).findings
                   if f.severity == "warning" and wrong in f.message]  # fmt: skip
        (finding,) = unclear
        assert finding.advice.startswith("write ")
        for better in finding.advice.removeprefix("write ").split(", or "):
            findings = analyze(clean_run(rng, metadata={**stated, key: better})).findings
            assert [f.message for f in findings if "can be compared" in f.message] == []


def test_what_is_planned_and_not_measured_says_what_it_needs(rng):
    run = clean_run(rng, metadata={"characteristics": "RP, vAP, Unheard"})
    said = [f.message for f in analyze(run).findings if f.code == "not-measured"]
    assert said[0].startswith("vAP is planned and not measured: needs ")
    assert said[1:] == ["Unheard is planned and not measured: no characteristic of this name"]


def test_findings_do_not_depend_on_the_order_of_axes_columns_and_lines(rng):
    """One axis that a check passes over hides no other behind it."""
    rows = 31 * 3
    drift = np.tile(np.linspace(0, 0.05, 31), 3)
    axes = {
        "X": Axis("X", rng.normal(0, 0.01, rows)),
        "Y": Axis("Y", rng.integers(-9, 9, rows) * 0.005, resolution=0.001),
        "Z": Axis("Z", (rng.normal(0, 0.01, rows) + drift).round(2), resolution=0.01),
        "theta": Axis("theta", np.zeros(rows), Dimension.ANGLE, resolution=0.1),
    }
    columns = {"payload_kg": np.full(rows, 2.0), "load_kg": np.linspace(1, 2, rows),
               "speed": np.full(rows, 100.0), "velocity": np.linspace(1, 2, rows),
               "temperature_C": np.full(rows, 20.0),
               "ambient_temperature_C": np.full(rows, 40.0)}  # fmt: skip
    lines = {"payload": "much", "load": "50 %", "velocity": "fast", "test_speed": "80 %",
             "temperature": "warm", "ambient_temperature": "35 C"}  # fmt: skip

    def said(names, columns, lines):
        run = Run(np.tile(np.arange(1, 32), 3), {n: axes[n] for n in names},
                  np.repeat(["P1", "P2", "P3"], 31), dict(columns), dict(lines))  # fmt: skip
        return {(f.code, f.axis, f.pose, f.message) for f in analyze(run).findings}

    items = list(columns.items()), list(lines.items())
    whole = said(axes, *items)
    for names in permutations(axes):
        assert said(names, *items) == whole
    assert said(axes, items[0][::-1], items[1][::-1]) == whole


def test_a_compliance_counts_readings_and_arrivals_are_arrivals(rng):
    force = np.resize([10.0, 20.0, 10.0, 0.0, -10.0, -20.0, -10.0, 0.0], 31)
    x = Axis("X", rng.normal(0, 0.001, 31) + 0.01 * force)
    columns = {"force_N": force, "stabilisation_X_s": rng.uniform(0.1, 0.2, 31)}
    counted = {c.code: c.counted for c in analyze(one_pose(rng, columns, X=x)).characteristics}
    assert (counted["compliance"], counted["stabilisation_time"]) == ("readings", "arrivals")


@pytest.mark.parametrize(("noise", "counts"), [(0.0, True), (0.01, False)])
def test_rounding_counts_where_readings_do_not_scatter_over_divisions(rng, noise, counts):
    force, reading = push_rig.readings(rng, noise=noise)
    found = push_test(ForceLoop(force, reading.round(3), resolution=0.001))
    parts = found.estimate("lost_motion", "reading").parts
    assert parts.get("reading") == (pytest.approx(0.001 / math.sqrt(6)) if counts else None)


def test_a_stiffness_is_the_compliance_turned_over_and_has_no_clause(rng):
    force, reading = push_rig.readings(rng, noise=0.001)
    found = push_test(ForceLoop(force, reading), arm_m=0.25)
    clauses = {one.code: one.estimate.clause for one in found.characteristics}
    assert clauses.pop("compliance") == "10"
    assert set(clauses.values()) == {"push test"}
    compliance, stiffness = (found.estimate(*of) for of in
                             (("compliance", "reading"), ("stiffness", "joint")))  # fmt: skip
    turned = [stiffness.value * compliance.value / end for end in compliance.interval[::-1]]
    assert stiffness.interval == pytest.approx(turned)
    assert stiffness.u / stiffness.value == pytest.approx(compliance.u / compliance.value)


@pytest.mark.parametrize(
    "stated", [{}, *({"date": date} for date in ("2026-05-12", "2026-05-12T08:00", "12.05.2026"))]
)
def test_a_moment_is_known_where_it_is_stated(rng, stated):
    assert (moment_of_test(one_pose(rng, metadata=stated)) is None) is (not stated)


@pytest.mark.parametrize("tau_h", [0.5, 5.0])
def test_a_drift_is_followed_however_slow(rng, tau_h):
    analysis = analyze(drift_test(rng, size=0.5, tau_h=tau_h))  # of eight hours
    (course,) = drift_courses(analysis.run, analysis.poses, analysis.block)
    assert course.fit.time_constant_h == pytest.approx(tau_h, rel=0.05)


@pytest.mark.parametrize(
    "stated",
    [{"first_cycle": "perhaps"}, {"first_cycle_discarded": "perhaps"},
     {"first_cycle": "counts", "first_cycle_discarded": "true"}],
)  # fmt: skip
def test_what_is_said_of_the_first_cycle_and_cannot_be_is_refused_with_what_to_do(rng, stated):
    with pytest.raises(DataError) as caught:
        analyze(one_pose(rng, metadata=stated))
    assert caught.value.remedy


def test_uncertainty_and_interval_of_scatter_and_of_a_distance_agree(rng):
    """Of RP without a certificate u is a quarter; the reach of a vector is that of its parts."""
    axes = {name: Axis(name, rng.normal(0.05, 0.01, 31), command=0.0) for name in "XY"}
    run = one_pose(rng, metadata={"dial_zero": "command"}, **axes)
    RP = figure(run, "RP")
    assert RP.u == pytest.approx((RP.interval[1] - RP.interval[0]) / 4)
    ends = [figure(run, "AP", of).interval for of in "XY"]
    AP = figure(run, "AP", "XY")
    reach = math.hypot(*((high - low) / 2 for low, high in ends))
    assert AP.interval == pytest.approx((AP.value - reach, AP.value + reach))


def test_a_temperature_is_held_against_the_rule_that_is_named(rng):
    for stated, rule in [({}, "20 ± 2"), ({"temperature_limits": "25 .. 30 C"}, "25 .. 30")]:
        run = clean_run(rng, metadata={"temperature": "35 C", **stated})
        (found,) = [f for f in analyze(run).findings if f.code == "temperature-limits"]
        assert rule in found.rule


def test_a_correction_says_how_much_it_added():
    raw = (0.5 + np.random.default_rng(1).normal(0, 0.01, 31)).round(3)
    rows = "".join(f"{k},{value:.3f}\n" for k, value in enumerate(raw, 1))
    table = f"# unit: mm\n# correction_X: 0 0.001; 10 -0.011\ncycle,X\n{rows}"
    run = read_table(table.encode())
    (found,) = [f for f in analyze(run).findings if f.code == "corrected"]
    added = run.axes["X"].readings - raw
    assert f"{added.min():+.3g} .. {added.max():+.3g} mm" in found.message
    assert found.axis == "X"


def test_a_calibration_is_past_the_day_after_it_is_due():
    head = {"calibration_due": "2026-05-11", "calibration_date": "2025-05-11"}
    assert past_due(head, date(2026, 5, 11)) == []
    assert past_due(head, date(2026, 5, 12)) == [
        "calibration_due 2026-05-11 is past: calibrate the indicator, or use another"
    ]
