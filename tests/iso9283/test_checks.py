"""Every check meets one contract; each is shown where it speaks and where it is silent."""

import inspect
import re
from types import SimpleNamespace

import numpy as np
import pytest

from scara_iso import analyze, read_table
from scara_iso.base.errors import DataError
from scara_iso.base.plugins import find_modules
from scara_iso.base.quantities import Dimension
from scara_iso.iso9283 import checks, exchanged_in, far_readings, parse_moment
from scara_iso.iso9283.checks import doubtful_resolution
from scara_iso.iso9283.checks.recording_disturbed import resumed_before
from scara_iso.iso9283.checks.trend import holm, mann_kendall
from scara_iso.iso9283.core.results import Finding
from scara_iso.iso9283.core.slips import REPEATED_BY_CHANCE, find_copied
from scara_iso.run import Axis, Run

MODULES = find_modules(checks, "scara_iso.checks")
STATED = {"payload": "2 kg", "velocity": "100 %", "temperature": "20 C", "indicator": "ID-H"}


def clean_run(rng, *, poses=5, metadata=None, covariates=None, **changes):
    """Return a run that no check has anything to say about, but for the changes."""
    rows = 31 * poses
    axes = {name: Axis(name, rng.normal(0, 0.01, rows).round(3), resolution=0.001) for name in "XY"}
    return Run(
        cycle=np.tile(np.arange(1, 32), poses),
        axes={**axes, **changes},
        pose=np.repeat([f"P{k}" for k in range(1, poses + 1)], 31),
        metadata={**STATED, **(metadata or {})},
        covariates=covariates or {},
    )


def codes(run, **options):
    return {finding.code for finding in analyze(run, **options).findings}


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__.split(".")[-1])
def test_contract(module, rng):
    assert re.fullmatch(r"[a-z]+(-[a-z]+)*", module.CODE)
    title, _, page = inspect.getdoc(module).partition("\n\n")
    assert title.endswith(".")
    assert len(page) > 100, "the docstring is the page that explains the finding"
    assert module.check(analyze(clean_run(rng))) is not None
    for finding in module.check(analyze(clean_run(rng, poses=1, metadata={"payload": ""}))):
        assert isinstance(finding, Finding)
        assert finding.code == module.CODE
        assert len(finding.message) < 200


def test_codes_are_unique():
    assert len({module.CODE for module in MODULES}) == len(MODULES)


def test_nothing_is_said_of_a_clean_run(rng):
    assert codes(clean_run(rng)) == set()


def x_axis(readings, resolution=0.001, *, poses=5):
    return Axis("X", np.tile(readings, poses), resolution=resolution)


def test_coarse_resolution(rng):
    run = clean_run(rng, X=x_axis(rng.permutation([0.01] * 15 + [0.0] * 16), 0.01))
    assert "coarse-resolution" in codes(run)


def test_indicator_uncertainty_counts_beside_the_resolution(rng):
    good = Axis("X", rng.normal(0, 0.01, 155).round(3), resolution=0.001, uncertainty=0.0005)
    poor = Axis("X", good.readings, resolution=0.001, uncertainty=0.02)
    assert "coarse-resolution" not in codes(clean_run(rng, X=good))
    assert "coarse-resolution" in codes(clean_run(rng, X=poor))


@pytest.mark.parametrize(("share", "flagged"), [(0.12, False), (0.13, True)])
def test_a_quarter_of_rp_is_the_largest_share_of_the_dial(rng, share, flagged):
    readings = np.tile(rng.normal(0, 0.01, 31).round(3), 5)
    RP = analyze(clean_run(rng, X=Axis("X", readings))).poses[0].axes["X"].RP
    run = clean_run(rng, X=Axis("X", readings, uncertainty=share * RP))
    named = {f.axis for f in analyze(run).findings if f.code == "coarse-resolution"}
    assert ("X" in named) == flagged


def test_of_an_angle_3_s_is_compared(rng):
    readings = np.tile(np.resize([-0.01, 0.01, 0.009, -0.009], 31), 5)
    axis = analyze(clean_run(rng, theta=Axis("theta", readings, Dimension.ANGLE))).poses[0]
    RP, three_sigma = axis.axes["theta"].RP, axis.axes["theta"].three_sigma
    assert RP < 0.9 * three_sigma
    for U, flagged in ((0.24 * three_sigma, False), (0.26 * three_sigma, True)):
        theta = Axis("theta", readings, Dimension.ANGLE, uncertainty=U / 2)
        named = {f.axis for f in analyze(clean_run(rng, theta=theta)).findings
                 if f.code == "coarse-resolution"}  # fmt: skip
        assert ("theta" in named) == flagged


@pytest.mark.parametrize(
    ("key", "said", "code"),
    [
        ("record_unit", "X: mm as the option states, not confirmed by the gauge",
         "unit-not-confirmed"),
        ("record_doubted", "X: cycle 4, cycle 9 | Y: cycle 12", "frame-in-doubt"),
    ],
)  # fmt: skip
def test_what_the_recorder_cannot_vouch_for_is_said(rng, key, said, code):
    found = [f for f in analyze(clean_run(rng, metadata={key: said})).findings if f.code == code]
    assert [f.axis for f in found] == ["X", "Y"][: len(found)]
    assert len(found) == said.count(" | ") + 1
    assert said.partition(": ")[2].partition(" |")[0] in found[0].message


def test_what_disturbed_a_recording_is_quoted(rng):
    head = {"record_01_resumed": "before cycle 17", "record_02_note": "coffee",
            "record_03_changed": "X: the indicator shows inch"}  # fmt: skip
    run = clean_run(rng, metadata=head)
    (found,) = (f for f in analyze(run).findings if f.code == "recording-disturbed")
    assert found.message == "resumed before cycle 17; X: the indicator shows inch"
    assert resumed_before(run.metadata) == (17,)
    assert "recording-disturbed" not in codes(clean_run(rng))


def test_few_levels(rng):
    assert "few-levels" in codes(clean_run(rng, X=x_axis(rng.integers(0, 3, 31) * 0.01)))


def test_no_scatter(rng):
    found = codes(clean_run(rng, X=x_axis(np.full(31, 0.5))))
    assert "no-scatter" in found
    assert "few-levels" not in found


def test_stuck_channel(rng):
    readings = rng.normal(0, 0.01, 31).round(3)
    assert "stuck-channel" not in codes(clean_run(rng, X=x_axis(readings)))
    readings[18:] = readings[17]
    assert "stuck-channel" in codes(clean_run(rng, X=x_axis(readings)))


def test_a_stretch_of_equal_readings_in_the_middle(rng):
    readings = rng.normal(0, 0.01, 31).round(3)
    readings[8:18] = readings[8]
    assert "stuck-channel" in codes(clean_run(rng, X=x_axis(readings)))
    readings[12] += 0.001
    assert "stuck-channel" not in codes(clean_run(rng, X=x_axis(readings)))


def test_the_plane_may_be_too_fine_for_the_dial(rng):
    coarse = {name: rng.permutation([0.01] * 8 + [0.0] * 23) for name in "XY"}
    axes = {name: x_axis(values, 0.01) for name, values in coarse.items()}
    axes["Y"] = Axis("Y", axes["Y"].readings, resolution=0.01, uncertainty=0.02)
    found = analyze(clean_run(rng, **axes)).findings
    assert {"XY", "Y"} <= {f.axis for f in found if f.code == "coarse-resolution"}


def test_trend(rng):
    ramp = rng.normal(0, 0.01, 31) + np.linspace(0, 0.05, 31)
    assert "trend" in codes(clean_run(rng, X=x_axis(ramp.round(3))))


def test_gross_reading(rng):
    readings = rng.normal(0, 0.01, 31).round(3)
    readings[20] += 0.2
    found = [f for f in analyze(clean_run(rng, X=x_axis(readings))).findings
             if f.code == "gross-reading"]  # fmt: skip
    assert len(found) == 5
    assert "in cycle 21" in found[0].message


def test_readings_that_crowd_about_the_median_make_no_other_far():
    """One division behind the next one, and 2.4 standard deviations of all (seen on a robot)."""
    readings = [0.8] * 10 + [0.799] * 4 + [0.801] * 4 + [0.792, 0.793, 0.795, 0.803, 0.804] * 2
    readings += [0.808, 0.809]
    assert far_readings(np.array(readings), 0.001) == []
    assert far_readings(np.array([*readings, 0.87]), 0.001) == [len(readings)]


def test_of_gaussian_readings_few_are_said_to_be_far(rng):
    rows = np.round(rng.normal(0, 0.004, (4000, 30)), 3)
    assert sum(bool(far_readings(row, 0.001)) for row in rows) / 4000 < 0.0025


def test_a_gross_reading_among_equal_ones_needs_no_resolution(rng):
    readings = np.full(31, 0.1)
    readings[5] = 1.1
    (finding, *_) = [f for f in analyze(clean_run(rng, X=x_axis(readings, None))).findings
                     if f.code == "gross-reading"]  # fmt: skip
    assert "1.1 mm in cycle 6" in finding.message
    readings[[5, 8, 9]] = 0.5, 0.11, 0.11  # the nearest is taken as one division off
    (finding, *_) = [f for f in analyze(clean_run(rng, X=x_axis(readings, None))).findings
                     if f.code == "gross-reading"]  # fmt: skip
    assert finding.message == "far from all others: 0.5 mm in cycle 6"
    several = x_axis(np.resize([0.1, 0.1, 0.1, 0.11], 31), None)
    assert "gross-reading" not in codes(clean_run(rng, X=several))


def test_one_division_is_never_a_gross_reading(rng):
    readings = np.zeros(31)
    readings[7] = 0.01
    assert "gross-reading" not in codes(clean_run(rng, X=x_axis(readings, 0.01)))


@pytest.mark.parametrize("key", sorted(STATED))
def test_conditions_not_stated(rng, key):
    (finding,) = analyze(clean_run(rng, metadata={key: " "})).findings
    assert finding.code == "not-stated"
    assert finding.rule.startswith("ISO 9283")


def test_a_covariate_states_its_condition(rng):
    run = clean_run(
        rng, metadata={"temperature": ""}, covariates={"temperature_C": np.full(155, 21.0)}
    )
    assert codes(run) == set()


def test_other_cycle_counts(rng):
    run = clean_run(rng)
    short = Run(run.cycle[:20], {"X": Axis("X", run.axes["X"].readings[:20], resolution=0.001)},
                metadata=STATED)  # fmt: skip
    found = [f for f in analyze(short, cycles=20).findings if f.code == "cycle-count"]
    assert found[0].message.startswith("19 cycles count")
    assert found[0].rule.startswith("ISO 9283 6.9")


def test_axes_of_separate_runs(rng):
    assert "separate-axes" in codes(clean_run(rng, metadata={"axes_recorded": "separately"}))


def test_resolution_not_stated(rng):
    run = clean_run(rng, X=x_axis(rng.integers(0, 9, 31) / 100, None))
    (message,) = [f.message for f in analyze(run).findings if f.code == "resolution-not-stated"]
    assert "on steps of 0.01 mm, taken as the dial's" in message


@pytest.mark.parametrize(
    ("step", "stated", "said"),
    [
        (0.01, 0.001, "on steps of 0.01 mm; uncertainty and interval rest on it"),
        (0.005, 0.001, "on steps of 0.005 mm"),
        (0.002, 0.001, "on steps of 0.002 mm"),
        (0.05, 0.001, "on steps of 0.05 mm"),
        (0.001, 0.001, None),
        (0.0015, 0.001, "between its divisions"),
        (0.01, 0.01, None),
        (0.001, 0.01, "between its divisions"),
        (0.01, 1e-300, None),
        (0.001, 10.0, "between its divisions"),
        (0.001, 1.0, "between its divisions"),
    ],
)
def test_readings_on_another_grid_than_stated(rng, step, stated, said):
    readings = 0.123 + step * np.array([*range(7), *rng.integers(0, 7, 24)])
    found = [
        f.message
        for f in analyze(clean_run(rng, X=x_axis(readings, stated))).findings
        if f.code == "doubtful-resolution"
    ]
    assert len(found) == (said is not None)
    assert all(said in message for message in found)


@pytest.mark.parametrize("step", [0.0127, 0.0254])
def test_a_dial_of_inches_stated_in_mm_is_seen_where_its_steps_are_rounded(rng, step):
    """Their distances in divisions, 12 and 13, have no common divisor."""
    readings = np.round(step * np.array([*range(7), *rng.integers(0, 7, 24)]), 3)
    (found,) = [
        one
        for one in analyze(clean_run(rng, X=x_axis(readings))).findings
        if one.code == "doubtful-resolution"
    ]
    assert found.severity == "warning"
    assert f"all readings lie on steps of {step:g} mm" in found.message
    assert found.advice.endswith(f"if these are its steps, state {step:g} mm")


def test_scatter_on_few_divisions_is_no_coarser_dial():
    """30 readings: none of 2,000 axes with scatters of 0.3 to 5 divisions is doubted."""
    rng = np.random.default_rng(5)
    for scatter in (0.3, 0.5, 0.7, 1.0, 2.0, 5.0):
        for _ in range(330):
            shown = 0.001 * np.rint(rng.normal(rng.uniform(), scatter, 30))
            axis = Axis("X", shown, resolution=0.001)
            measured = SimpleNamespace(run=Run(np.arange(30), {"X": axis}))
            assert not list(doubtful_resolution.check(measured))


@pytest.mark.parametrize(
    "levels",
    [
        pytest.param([0, 1, 0, 0, 1, 1, 0, 0, 1, 1], id="two levels, ten divisions apart"),
        pytest.param([0, 1, 2, 1, 0, 0, 2, 0, 1, 2], id="three levels"),
    ],
)
def test_few_levels_on_a_coarse_grid_are_doubted(rng, levels):
    """A resolution stated ten times too fine, where no reading lies between the levels."""
    readings = 0.01 * np.tile(levels, 4)[:31]
    assert "doubtful-resolution" in codes(clean_run(rng, X=x_axis(readings)))


@pytest.mark.parametrize(
    "levels",
    [
        pytest.param(np.tile([0, 10], 80), id="approached from two sides"),
        pytest.param(np.repeat([0, 10], 80), id="a step"),
        pytest.param(np.where(np.arange(160) == 70, 10, 0), id="one far reading"),
        pytest.param(np.tile([0, 2, 2, 0, 0, 0, 0, 0], 20)[:31], id="two divisions apart"),
    ],
)
def test_levels_that_a_robot_itself_may_rest_on_are_not_doubted(levels):
    axis = Axis("X", 0.001 * levels, resolution=0.001)
    measured = SimpleNamespace(run=Run(np.arange(len(levels)), {"X": axis}))
    assert not list(doubtful_resolution.check(measured))


@pytest.mark.parametrize(
    ("where", "said"),
    [
        (slice(17, None), "from cycle 18 on X lies where Y was, and Y where X was"),
        (slice(0, 5), "from cycle 6 on X lies where Y was"),
        (slice(9, 20), "at cycles 10 to 20 X lies where Y was"),
        (slice(8, 9), "at cycle 9 X lies where Y was"),
        (slice(0, 0), None),
    ],
)
def test_axes_that_change_places_are_asked_about(rng, where, said):
    x, y = rng.normal(0.12, 0.01, 31), rng.normal(-0.25, 0.01, 31)
    x[where], y[where] = y[where].copy(), x[where].copy()
    run = clean_run(rng, X=x_axis(x), Y=Axis("Y", np.tile(y, 5), resolution=0.001))
    found = [f for f in analyze(run).findings if f.code == "axes-exchanged"]
    assert len(found) == (5 if said else 0)
    assert all(one.message.startswith(said) for one in found)


def test_robots_that_move_both_axes_are_not_said_to_change_them(rng):
    """Steps, swings in mirror image, drifts and heavy scatter of two dials set to zero."""
    cycle, alarms = np.arange(31.0), 0
    for k in range(300):
        swing = np.sin(2 * np.pi * cycle / rng.uniform(4, 40))
        step = rng.normal(0, 0.1, (2, 1)) * (cycle > rng.integers(3, 28))
        x, y = rng.standard_t(3, (2, 31)) * 0.01 + (step, (0.1 * swing, -0.1 * swing))[k % 2]
        axes = [Axis(name, readings, resolution=0.001) for name, readings in (("X", x), ("Y", y))]
        alarms += bool(exchanged_in(cycle.astype(int), *axes, np.arange(31)))
    assert alarms == 0


@pytest.mark.parametrize(
    ("rows", "of", "said"),
    [(slice(21, 31), slice(1, 11), "cycles 22 to 31 repeat every reading of cycles 2 to 11"),
     (slice(24, 31), slice(23, 24), "cycles 25 to 31 repeat every reading of cycle 24"),
     (slice(9, 16), slice(2, 9), "cycles 10 to 16 repeat every reading of cycles 3 to 9"),
     (slice(9, 12), slice(2, 5), "")],
)  # fmt: skip
def test_rows_that_were_filled_down_or_pasted_are_named(rng, rows, of, said):
    axes = rng.normal(0, 0.01, (2, 31)).round(3)
    axes[:, rows] = axes[:, of]
    columns = {
        name: Axis(name, values, resolution=0.001) for name, values in zip("XY", axes, strict=True)
    }
    found = analyze(clean_run(rng, poses=1, **columns)).findings
    found = [one.message for one in found if one.code == "repeated-rows"]
    assert len(found) == bool(said)
    assert all(one.startswith(f"{said}, copied or stuck") for one in found)


def test_readings_that_come_again_by_themselves_are_no_copies(rng):
    """Coarse dials, sides in turns, stairs of a drift, waves and walks."""
    cycle, alarms = np.arange(31), 0
    for k in range(400):
        scatter = rng.normal(0, rng.choice([0.1, 0.3, 1, 3, 10]), 31)
        sides, wave = 5 * (cycle % 4 < 2), 50 * np.sin(cycle / 5)
        course = (0, sides, cycle / 4, wave, scatter.cumsum())[k % 5]
        found = find_copied(np.round(course + scatter)[:, np.newaxis], np.ones(1))
        alarms += found is not None and found.p_value < REPEATED_BY_CHANCE
    assert alarms == 0


@pytest.mark.parametrize("resolution", [None, 0.001])
def test_two_dials_that_never_move_change_no_places(resolution):
    x, y = (Axis(name, np.full(31, 0.1), resolution=resolution) for name in "XY")
    assert exchanged_in(np.arange(31), x, y, np.arange(31)) == ""


@pytest.mark.parametrize(
    ("unit", "step", "shown"),
    [("mm", 0.01, "0.01"), ("um", 5, "5"), ("mm", 0.001, "0.001"), ("inch", 0.0005, "0.0005")],
)
def test_the_resolution_that_is_proposed_is_the_step_of_the_readings(unit, step, shown, rng):
    x, y = np.rint(rng.normal(0, 5, (2, 31))) * step
    rows = "".join(f"{k + 1},{x[k]:.6g},{y[k]:.6g}\n" for k in range(31))
    run = read_table(f"# unit: {unit}\ncycle,X,Y\n{rows}".encode())
    found = {one.in_short for one in analyze(run).findings if one.code == "resolution-not-stated"}
    assert found == {f"state it, as `resolution={shown}`"}


def test_the_resolution_of_a_scaled_unit_is_proposed_as_the_step_of_the_readings(rng):
    rows = "".join(f"{k},{x:.0f}\n" for k, x in enumerate(rng.normal(0, 5, 31), 1))
    run = read_table(f"# unit: 0.01 mm\ncycle,X\n{rows}".encode())
    found = {one.in_short for one in analyze(run).findings if one.code == "resolution-not-stated"}
    assert found == {"state it in its head, as '# resolution: 0.01 mm'"}


def test_readings_of_another_unit_are_asked_about(rng):
    axes = {name: rng.normal(0, 0.01, 155) for name in "XY"}

    def said(**changed):
        dials = {n: Axis(n, r, resolution=0.001) for n, r in (axes | changed).items()}
        run = clean_run(rng, **dials)
        found = (one for one in analyze(run).findings if one.code == "unit-in-doubt")
        return [(one.pose, one.axis) for one in found]

    at_one = np.where(np.repeat(np.arange(5), 31) == 3, 1000, 1)
    assert said() == []
    assert said(X=axes["X"] * 10) == []
    assert said(X=axes["X"] * at_one) == [("P4", "X")]
    assert said(Y=axes["Y"] * np.where(at_one > 1, 20, 1)) == []
    assert said(X=axes["X"] * 1000) == [(f"P{k}", "X") for k in range(1, 6)]
    assert said(X=axes["X"] / 1000) == [(f"P{k}", "X") for k in range(1, 6)]


def test_times_that_run_backwards_are_said_of_their_pose(rng):
    time = np.tile(np.arange(31.0), 5)  # each pose has a clock of its own
    assert "clock-back" not in codes(clean_run(rng, covariates={"time_s": time}))
    time[40] -= 5
    run = clean_run(rng, covariates={"time_s": time})
    (found,) = (one for one in analyze(run).findings if one.code == "clock-back")
    assert (found.pose, found.message) == (
        "P2", "time_s runs backwards once, first at cycle 10",
    )  # fmt: skip


def test_both_approaches(rng):
    approach = np.tile([1.0, -1.0], 78)[:155]
    assert "mixed-approach" in codes(clean_run(rng, covariates={"approach": approach}))
    assert "mixed-approach" not in codes(clean_run(rng, covariates={"approach": approach**2}))
    by_pose = np.repeat([1.0, -1.0, 1.0, 1.0, -1.0], 31)
    assert "mixed-approach" not in codes(clean_run(rng, covariates={"approach": by_pose}))
    only_the_discarded = np.tile([-1.0, *[1.0] * 30], 5)
    assert "mixed-approach" not in codes(
        clean_run(rng, covariates={"approach": only_the_discarded})
    )


def test_an_approach_of_unknown_coding_is_said(rng):
    run = clean_run(rng, covariates={"approach": np.resize([0.0, 1.0], 155)})
    (finding,) = [f for f in analyze(run).findings if f.code == "mixed-approach"]
    assert finding.severity == "warning"
    assert "holds 0" in finding.message


def test_theta_as_a_length(rng):
    theta = Axis("theta", rng.normal(0, 0.01, 155).round(3), resolution=0.001)
    angle = Axis("theta", theta.readings, Dimension.ANGLE, resolution=0.001)
    assert "theta-as-length" in codes(clean_run(rng, theta=theta))
    assert codes(clean_run(rng, theta=angle)) == set()
    assert codes(clean_run(rng, theta=theta, metadata={"theta_radius_mm": "30"})) == set()


def test_fewer_than_five_poses(rng):
    assert "poses" in codes(clean_run(rng, poses=4))


@pytest.mark.parametrize(
    ("p_values", "tests", "found"),
    [
        ([0.004, 0.004], 2, [True, True]),
        ([0.004, 0.009], 2, [True, True]),
        ([0.006, 0.009], 2, [False, False]),
        ([0.009, 0.001, 0.02], 3, [False, True, False]),
        ([0.002], 6, [False]),
        ([], 0, []),
    ],
)
def test_the_level_is_shared_step_by_step(p_values, tests, found):
    assert holm(p_values, 0.01, tests) == found


def test_the_trend_s_level_is_shared_by_all_axes_and_poses(rng):
    first, second = rng.permutation(15), rng.permutation(15)
    shifted = (0.001 * np.array([0, *first, *(second + shift)]) for shift in range(15))
    ramp = next(r for r in shifted if 0.01 / 80 < mann_kendall(r[1:]) < 0.01)
    alone = Axis("X", ramp, resolution=0.001)
    assert "trend" in codes(Run(np.arange(1, 32), {"X": alone}, metadata=STATED))
    rest = clean_run(rng, poses=40).axes["X"].readings[31:]
    among_many = Axis("X", np.concatenate([ramp, rest]), resolution=0.001)
    assert "trend" not in codes(clean_run(rng, poses=40, X=among_many))


def test_mann_kendall_is_kendall_s_tau(rng):
    stats = pytest.importorskip("scipy.stats")
    for _ in range(20):
        readings = rng.integers(0, 6, 31).astype(float)
        other = stats.kendalltau(np.arange(31), readings, method="asymptotic").pvalue
        assert mann_kendall(readings) == pytest.approx(other, rel=0.15, abs=0.01)
    assert mann_kendall(np.full(31, 1.0)) == 1


def test_mann_kendall_holds_its_level(rng):
    readings = rng.normal(size=(2000, 30)).round(1)
    alarms = np.mean([mann_kendall(row) < 0.01 for row in readings])
    assert 0.004 < alarms < 0.018


def test_third_parties_add_checks(monkeypatch, tmp_path):
    (tmp_path / "their_check.py").write_text("CODE = 'theirs'\ncheck = iter\n")
    declared = tmp_path / "theirs-1.0.dist-info"
    declared.mkdir()
    (declared / "METADATA").write_text("Metadata-Version: 2.1\nName: theirs\nVersion: 1.0\n")
    (declared / "entry_points.txt").write_text("[scara_iso.checks]\ntheirs = their_check\n")
    monkeypatch.syspath_prepend(tmp_path)
    found = find_modules(checks, "scara_iso.checks")
    assert found[:-1] == MODULES
    assert found[-1].CODE == "theirs"


def said(rng, metadata, **covariates):
    columns = {name: np.resize(values, 155).astype(float) for name, values in covariates.items()}
    found = analyze(clean_run(rng, metadata=metadata, covariates=columns)).findings
    return {(finding.code, bool(finding.rule)) for finding in found}


CONDITIONS = [
    ({"payload": "2 kg", "rated_payload": "2.0 kg"}, None, False),
    ({"payload": "0.2 kg", "rated_payload": "2 kg"}, "other-load", True),
    ({"payload": "200 g", "rated_load": "2 kg"}, "other-load", True),
    ({"payload": "10 % of rated"}, "other-load", True),
    ({"payload": "2,0 kg (100 % of rated)", "rated_payload": "2 kg"}, None, False),
    ({"payload": "2 kg (50 % of rated)"}, "other-load", True),
    ({"payload": "", "payload_kg": "1.5", "rated_payload_kg": "2"}, "other-load", True),
    ({"payload": "two kilos", "rated_payload": "2 kg"}, "other-load", False),
    ({"payload": "1,500 kg"}, "other-load", False),  # a thousand and a half, or one and a half
    ({"payload": "2"}, "other-load", False),
    ({"velocity": "50 %"}, None, False),
    ({"payload": "1.98 kg", "rated_payload": "2 kg"}, None, False),  # a per cent
    ({"payload": "1.97 kg", "rated_payload": "2 kg"}, "other-load", True),
    ({"velocity": "80 %"}, "other-velocity", True),
    ({"velocity": "99 %"}, None, False),
    ({"velocity": "98.5 %"}, "other-velocity", True),
    ({"velocity": "100 % of rated"}, None, False),
    ({"velocity": "500 mm/s", "rated_velocity": "1 m/s"}, None, False),
    ({"velocity": "700 mm/s", "rated_velocity": "1 m/s"}, "other-velocity", True),
    ({"velocity": "", "velocity_mm_s": "700", "rated_velocity_mm_s": "1000"}, "other-velocity",
     True),
    ({"velocity": "fast"}, "other-velocity", False),
    ({"temperature": "22.0 °C"}, None, False),
    ({"temperature": "35 C"}, "temperature-limits", True),
    ({"temperature": "21 ± 2 C"}, "temperature-limits", True),
    ({"temperature": "19 ± 2 C"}, "temperature-limits", True),
    ({"temperature": "18 .. 22 degC"}, None, False),
    ({"temperature": "35 C", "temperature_limits": "15 .. 40 C"}, None, False),
    ({"temperature": "20 C", "temperature_limits": "22 ± 1 C"}, "temperature-limits", True),
    ({"temperature": "warm"}, "temperature-limits", False),
    ({"temperature": "293 K"}, "temperature-limits", False),
    ({"dwell": "2 s", "stabilisation_time": "0.8 s"}, None, False),
    ({"dwell": "500 ms", "stabilisation_time_s": "0.8"}, "short-dwell", True),
    ({"dwell": "0.5 s"}, None, False),
    ({"dwell": "a while", "stabilisation_time": "0.8 s"}, "short-dwell", False),
    ({"warm_up": "30 min"}, None, False),
    ({"warm_up": "0 min"}, "cold-start", True),
    ({"warm_up": "none"}, "cold-start", False),
    ({"calibration_due": "2026-05-12", "date": "2026-05-12"}, None, False),
    ({"calibration_due": "2026-05-11", "date": "12.05.2026"}, "calibration-date", True),
    ({"calibration_due": "2025-05-11", "timestamp_start": "2026-05-12T08:00:00"},
     "calibration-date", True),
    ({"calibration_date": "2026-06-01", "date": "2026-05-12"}, "calibration-date", True),
    ({"calibration_date": "2026-01-01", "date": "2026-05-12"}, None, False),
    ({"calibration_due": "2026-05-11"}, "calibration-date", False),
    ({"calibration_due": "05/11/2026", "date": "2026-05-12"}, "calibration-date", False),
]  # fmt: skip


@pytest.mark.parametrize(("metadata", "code", "deviates"), CONDITIONS)
def test_a_condition_is_compared_or_said_to_be_unclear(rng, metadata, code, deviates):
    assert said(rng, metadata) == ({(code, deviates)} if code else set())


@pytest.mark.parametrize(
    "text",
    ["2026-05-02", "02.05.2026", " 2.5.2026", "02.05.2026 00:00", "2.5.2026, 00:00:00",
     "2026-05-02T00:00+02:00", "2026-05-02T00:00Z"],
)  # fmt: skip
def test_moments_are_local_and_can_be_put_in_order(text):
    assert parse_moment(text).isoformat() == "2026-05-02T00:00:00"
    assert parse_moment("05/02/2026") is None


def test_a_column_is_compared_as_a_line_is(rng):
    assert said(rng, {"rated_payload": "2 kg"}, payload_kg=[2]) == set()
    assert said(rng, {"rated_payload": "2 kg"}, payload_kg=[1]) == {("other-load", True)}
    assert said(rng, {}, payload_kg=[1, 2]) == {("other-load", True)}
    assert said(rng, {}, speed=[100, 250]) == {("other-velocity", True)}
    assert said(rng, {}, velocity_percent=[30]) == {("other-velocity", True)}
    assert said(rng, {}, velocity_percent=[50]) == set()
    assert said(rng, {"rated_velocity": "1 m/s"}, velocity_mm_s=[700]) == {("other-velocity", True)}
    assert said(rng, {}, speed=[700]) == set()  # of no unit that is known
    assert said(rng, {}, speed=[100]) == set()
    assert said(rng, {}, temperature_C=[20, 35]) == {("temperature-limits", True)}
    assert said(rng, {}, approach=[1, -1]) == {("mixed-approach", True)}


def test_too_few_cycles_for_an_interval_say_so(rng):
    readings = [0.806, 0.8, 0.797, 0.796, 0.8, 0.806, 0.8, 0.797, 0.796, 0.8]
    run = Run(np.arange(1, 11), {"X": Axis("X", np.array(readings), resolution=0.001)})
    found = analyze(run, cycles=10)
    (count,) = (f for f in found.findings if f.code == "cycle-count")
    assert count.message.endswith("they are too few for an interval of RP")
    assert found.poses[0].axes["X"].RP_interval is None


@pytest.mark.parametrize(("rows", "poses"), [(155, 5), (62, 2), (154, 0), (32, 0)])
def test_rows_of_several_poses_are_not_pooled_by_advice(rng, rows, poses):
    readings = rng.normal(0, 0.01, rows).round(3)
    run = Run(np.arange(1, rows + 1), {"X": Axis("X", readings, resolution=0.001)})
    with pytest.raises(DataError) as refused:
        analyze(run)
    asked = f"if these are {poses} poses of 31 cycles, name them in a column pose"
    assert refused.value.remedy.startswith(asked) == bool(poses)
