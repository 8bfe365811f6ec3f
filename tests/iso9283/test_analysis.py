"""From a run to its figures: poses, planes, angles, accuracy, definitions and limits."""

import math
from dataclasses import replace

import numpy as np
import pytest

from scara_iso import analyze
from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.quantities import Dimension
from scara_iso.iso9283.core.figures import Conformity
from scara_iso.iso9283.core.limits import EVERY_LENGTH
from scara_iso.iso9283.core.statistics import (
    GAUSSIAN_RP,
    reading_uncertainty,
    repeatability,
    rp_interval,
)
from scara_iso.run import Axis, Run


def run_with(axes, *, poses=1, metadata=None, covariates=None):
    cycle = np.tile(np.arange(1, 32), poses)
    return Run(
        cycle=cycle,
        axes={axis.name: axis for axis in axes},
        pose=np.repeat([f"P{k}" for k in range(poses)], 31) if poses > 1 else None,
        metadata=metadata or {},
        covariates=covariates or {},
    )


def scatter(rng, name, poses=1, **kwargs):
    return Axis(name, rng.normal(0, 0.01, 31 * poses).round(3), resolution=0.001, **kwargs)


def test_each_pose_is_analyzed_by_itself(rng):
    run = run_with([scatter(rng, name, 4) for name in "XYZ"], poses=4)
    analysis = analyze(run)
    assert [pose.label for pose in analysis.poses] == ["P0", "P1", "P2", "P3"]
    for k, pose in enumerate(analysis.poses):
        rows = slice(31 * k + 1, 31 * (k + 1))
        for name, axis in pose.axes.items():
            alone = repeatability(run.axes[name].readings[np.newaxis, rows])
            assert axis.RP == pytest.approx(float(alone.RP), rel=1e-12)
            lower, upper = rp_interval(
                run.axes[name].readings[np.newaxis, rows], resolutions=[0.001]
            )
            assert axis.RP_interval == pytest.approx((float(lower), float(upper)), rel=1e-9)
            assert axis.n == 30


def test_eq_23_and_radial(rng):
    run = run_with([scatter(rng, name) for name in "XYZ"])
    pose = analyze(run).poses[0]
    assert pose.XY.RP_rss == pytest.approx(math.hypot(pose.axes["X"].RP, pose.axes["Y"].RP))
    assert not hasattr(pose.XYZ, "RP_rss")
    centred = [run.axes[n].readings[1:] - run.axes[n].readings[1:].mean() for n in "XYZ"]
    distance = np.sqrt(sum(c**2 for c in centred))
    assert pose.XYZ.RP == pytest.approx(distance.mean() + 3 * distance.std(ddof=1))


def test_no_plane_without_both_axes_or_with_an_angle(rng):
    pose = analyze(run_with([scatter(rng, "X"), scatter(rng, "Z")])).poses[0]
    assert pose.XY is None
    assert pose.XYZ is None
    angle = scatter(rng, "Y", dimension=Dimension.ANGLE)
    assert analyze(run_with([scatter(rng, "X"), angle])).poses[0].XY is None


def test_uncertainty_is_combined_as_in_the_gum():
    zeros = np.zeros(3)
    assert reading_uncertainty(Axis("X", zeros)) is None
    assert reading_uncertainty(Axis("X", zeros, resolution=0.01)) == 0.01 / math.sqrt(12)
    both = Axis("X", zeros, resolution=0.01, uncertainty=0.003)
    assert reading_uncertainty(both) == pytest.approx(math.sqrt(1e-4 / 12 + 9e-6))


def test_accuracy_needs_the_command_pose(rng):
    x, y = scatter(rng, "X", command=0.1), scatter(rng, "Y", command=-0.2)
    axes = [x, y, scatter(rng, "Z")]
    assert analyze(run_with(axes)).poses[0].axes["X"].accuracy is None
    pose = analyze(run_with(axes, metadata={"dial_zero": "command"})).poses[0]
    ap_x = x.readings[1:].mean() - 0.1
    ap_y = y.readings[1:].mean() + 0.2
    assert pose.axes["X"].accuracy == pytest.approx(ap_x)
    assert pose.XY.accuracy == pytest.approx(math.hypot(ap_x, ap_y))
    assert pose.axes["Z"].accuracy is None
    assert pose.XYZ.accuracy is None


def test_theta_as_a_length_becomes_an_angle_only_with_its_radius(rng):
    theta = scatter(rng, "theta")
    assert analyze(run_with([theta])).poses[0].axes["theta"].angle is None
    axis = analyze(run_with([theta], metadata={"theta_radius_mm": "50"})).poses[0].axes["theta"]
    s = theta.readings[1:].std(ddof=1)
    assert axis.angle.three_sigma_deg == pytest.approx(math.degrees(3 * s / 50))
    assert axis.angle.RP_deg == pytest.approx(math.degrees(axis.RP / 50))


@pytest.mark.parametrize("radius", ["0", "-3", "nan", "inf", "fifty", ""])
def test_a_radius_that_is_none_is_refused(rng, radius):
    with pytest.raises(DataError, match="theta_radius_mm"):
        analyze(run_with([scatter(rng, "theta")], metadata={"theta_radius_mm": radius}))


def test_definitions_with_both_approaches(rng):
    approach = np.resize([1.0, -1.0], 31)
    x = Axis("X", rng.normal(0, 0.01, 31) + 0.02 * approach)
    run = run_with([x], covariates={"approach": approach})
    axis = analyze(run, other_definitions=True).poses[0].axes["X"]
    found = {d.name: d.value for d in axis.definitions}
    readings, sides = x.readings[1:], approach[1:]
    up, down = readings[sides > 0], readings[sides < 0]
    assert found["2 s"] == pytest.approx(2 * readings.std(ddof=1))
    assert found["3 s"] == pytest.approx(axis.three_sigma)
    assert found["half range"] == pytest.approx(np.ptp(readings) / 2)
    assert found["half range of 7"] == pytest.approx(np.ptp(readings[:7]) / 2)
    assert found["B"] == pytest.approx(up.mean() - down.mean())
    s_up, s_down = up.std(ddof=1), down.std(ddof=1)
    expected = max(2 * s_up + 2 * s_down + abs(found["B"]), 4 * s_up, 4 * s_down)
    assert found["R"] == pytest.approx(expected)


def test_definitions_only_on_request(rng):
    assert analyze(run_with([scatter(rng, "X")])).poses[0].axes["X"].definitions == ()


def test_one_limit_holds_for_every_length_and_not_for_angles(rng):
    theta = scatter(rng, "theta", dimension=Dimension.ANGLE)
    run = run_with([scatter(rng, "X"), scatter(rng, "Y"), theta])
    checks = analyze(run, limits={EVERY_LENGTH: 0.001}).limits
    assert [check.figure for check in checks] == ["X", "Y", "XY"]
    assert not any(check.inside for check in checks)


def test_a_named_limit_goes_before_the_general_one(rng):
    run = run_with([scatter(rng, "X"), scatter(rng, "Y")])
    checks = {c.figure: c for c in analyze(run, limits={EVERY_LENGTH: 9, "X": 0.001}).limits}
    assert not checks["X"].inside
    assert checks["Y"].inside
    (only,) = analyze(run, limits={"XY": 9}).limits
    pose = analyze(run).poses[0]
    assert (only.figure, only.RP) == ("XY", pose.XY.RP_radial)


def test_an_angle_is_held_to_three_sigma(rng):
    theta = scatter(rng, "theta", dimension=Dimension.ANGLE)
    (check,) = analyze(run_with([theta]), limits={"theta": 1.0}).limits
    assert check.RP == pytest.approx(3 * theta.readings[1:].std(ddof=1))


def test_guard_band(rng):
    run = run_with([scatter(rng, "X")])
    RP = analyze(run).poses[0].axes["X"].RP
    U = 2 * 0.001 / math.sqrt(12)
    for limit, inside, clear in [
        (RP + 1.01 * U, True, True),
        (RP + 0.99 * U, True, False),
        (RP, True, False),
        (RP - 0.99 * U, False, False),
        (RP - 1.01 * U, False, True),
    ]:
        (check,) = analyze(run, limits={"X": limit}, decision="simple").limits
        assert (check.inside, check.clear) == (inside, clear)
        assert check.guard == pytest.approx(U)
        assert check.verdict is (Conformity.PASS if inside else Conformity.FAIL)
        assert check.cycles_wanted is None


def test_the_interval_decides(rng):
    run = run_with([scatter(rng, "X")])
    lower, upper = analyze(run).poses[0].axes["X"].RP_interval
    for limit, verdict in [
        (0.99 * lower, Conformity.FAIL),
        (lower, Conformity.NOT_PROVABLE),
        (0.99 * upper, Conformity.NOT_PROVABLE),
        (upper, Conformity.PASS),
    ]:
        analysis = analyze(run, limits={"X": limit})
        assert analysis.limits[0].verdict is verdict is analysis.conformity
    assert analyze(run).conformity is None
    with pytest.raises(UsageError, match="simpel"):
        analyze(run, limits={"X": 1.0}, decision="simpel")


def test_the_whole_fails_with_one_and_passes_with_all(rng):
    run = run_with([scatter(rng, "X"), scatter(rng, "Y")])
    interval = analyze(run).poses[0].axes["X"].RP_interval
    between = sum(interval) / 2
    for limits, whole in [
        ({"X": 9.0, "Y": 9.0}, Conformity.PASS),
        ({"X": between, "Y": 9.0}, Conformity.NOT_PROVABLE),
        ({"X": between, "Y": 1e-4}, Conformity.FAIL),
    ]:
        assert analyze(run, limits=limits).conformity is whole


def test_a_drift_keeps_no_limit_at_its_pose_and_breaks_one_all_the_same(rng):
    pose = np.repeat(["P1", "P2"], 31)
    moving = np.concatenate([np.zeros(31), np.linspace(0, 0.1, 31)])
    X, Y = (Axis(name, rng.normal(0, 0.002, 62), resolution=1e-6) for name in "XY")
    moved = replace(Y, readings=Y.readings + moving)
    run = Run(np.tile(np.arange(1, 32), 2), {"X": X, "Y": moved}, pose=pose)

    def verdicts(limit: float) -> dict[tuple[str | None, str], str]:
        found = analyze(run, limits={"": limit}).limits
        return {(one.pose, one.figure): one.verdict.value for one in found}

    assert set(verdicts(1.0).values()) == {"pass"}
    assert verdicts(0.02)["P2", "Y"] == "fail"
    void = {
        (one.pose, one.figure) for one in analyze(run, limits={"": 1}).limits if one.interval_void
    }
    assert void == {("P2", "Y"), ("P2", "XY")}
    (in_between,) = (one for one in analyze(run, limits={"Y": 0.12}).limits if one.pose == "P2")
    assert in_between.interval_void


def test_an_angle_is_decided_on_the_interval_of_3_s(rng):
    run = run_with([scatter(rng, "theta", dimension=Dimension.ANGLE)])
    axis = analyze(run).poses[0].axes["theta"]
    assert axis.three_sigma_interval != axis.RP_interval
    (check,) = analyze(run, limits={"theta": axis.three_sigma_interval[1]}).limits
    assert check.interval == axis.three_sigma_interval
    assert check.verdict is Conformity.PASS


def test_calibration_widens_the_interval(rng):
    plain = scatter(rng, "X")
    uncertain = Axis("X", plain.readings, resolution=0.001, uncertainty=0.004)
    before, after = (analyze(run_with([x])).poses[0].axes["X"] for x in (plain, uncertain))
    low, high = before.RP_interval
    assert after.RP_interval == pytest.approx(
        (before.RP - math.hypot(before.RP - low, 0.008),
         before.RP + math.hypot(high - before.RP, 0.008))
    )  # fmt: skip


def test_no_number_of_cycles_proves_what_the_calibration_leaves_open(rng):
    x = Axis("X", rng.normal(0, 0.01, 31), resolution=1e-6, uncertainty=0.004)
    RP = analyze(run_with([x])).poses[0].axes["X"].RP
    near, far = (analyze(run_with([x]), limits={"X": RP + d}).limits[0] for d in (0.0079, 0.0081))
    assert near.verdict is far.verdict is Conformity.NOT_PROVABLE
    assert near.cycles_wanted is None
    assert far.cycles_wanted > 30


def test_the_nearer_the_limit_the_more_cycles_are_wanted(rng):
    run = run_with([scatter(rng, "X")])
    axis = analyze(run).poses[0].axes["X"]
    lower, upper = axis.RP_interval
    for ends in (np.linspace(axis.RP, lower, 12), np.linspace(axis.RP, upper, 12)):
        wanted = [analyze(run, limits={"X": x}).limits[0].cycles_wanted for x in ends[1:-1]]
        assert wanted == sorted(wanted, reverse=True)
        assert wanted[-1] > 30


@pytest.mark.slow
def test_of_robots_at_the_limit_few_pass(rng):
    """The true RP, the expected one of 30 cycles, is 2.54 sigma: the limit, or 1.1 times it."""
    runs = 400
    x = Axis("X", rng.standard_normal(31 * runs), resolution=1e-9)
    run = Run(np.tile(np.arange(1, 32), runs), {"X": x}, np.repeat(np.arange(runs).astype(str), 31))
    passed, simple = {}, {}
    for share in (1.0, 1.1, 0.5):
        checks = analyze(run, limits={"X": 2.54 / share}).limits
        passed[share] = np.mean([check.verdict is Conformity.PASS for check in checks])
        simple[share] = np.mean([check.inside for check in checks])
    assert simple[1.1] > 0.2
    assert passed[1.0] <= 0.05
    assert passed[1.1] <= 0.01
    assert passed[0.5] > 0.75


def test_a_step_that_is_not_stated_is_seen(rng):
    """Of a dial of 0.01 with scatter of 3 um: 37 % coverage where it was taken for a fine one."""
    place, runs = rng.uniform(0, 1, (200, 1)), 200
    shown = np.rint(rng.normal(0, 0.3, (runs, 31)) + place).ravel() * 0.01
    both = {}
    for stated in (0.01, None):
        run = Run(
            np.tile(np.arange(1, 32), runs),
            {"X": Axis("X", shown, resolution=stated)},
            np.repeat(np.arange(runs).astype(str), 31),
        )
        both[stated] = [pose.axes["X"].RP_interval for pose in analyze(run).poses]
    assert np.array(both[0.01]) == pytest.approx(np.array(both[None]))
    true = 0.003 * GAUSSIAN_RP[1]
    assert np.mean([low <= true <= high for low, high in both[None]]) > 0.95


@pytest.mark.parametrize("limits", [{"XY": 1.0}, {"Q": 1.0}, {"X": 0.0}, {"X": math.nan}])
def test_a_limit_that_cannot_be_meant_is_refused(rng, limits):
    with pytest.raises(UsageError, match="`limit="):
        analyze(run_with([scatter(rng, "X")]), limits=limits)


def test_a_limit_of_lengths_is_refused_where_there_is_none(rng):
    run = run_with([scatter(rng, "theta", dimension=Dimension.ANGLE)])
    with pytest.raises(UsageError, match="is a length, and this table has none"):
        analyze(run, limits={EVERY_LENGTH: 0.001})


def test_too_few_cycles_for_scatter_or_interval(rng):
    readings = rng.normal(size=5)
    short = Run(np.arange(1, 6), {"X": Axis("X", readings)})
    assert analyze(short, cycles=5).poses[0].axes["X"].RP_interval is None
    one = Run(np.arange(1, 3), {"X": Axis("X", readings[:2])})
    with pytest.raises(DataError, match="no scatter"):
        analyze(one, cycles=2)


def test_one_reading_that_carries_the_figure_gives_no_interval():
    readings = np.linspace(0, 1e-4, 31) ** 2
    readings[7] = 1.0
    axis = analyze(run_with([Axis("X", readings)])).poses[0].axes["X"]
    assert axis.RP > 0
    assert axis.RP_interval is None


def test_a_radial_figure_states_no_uncertainty_where_one_axis_states_none(rng):
    readings = rng.normal(0, 0.01, 31)
    known = Axis("X", readings, resolution=0.01)
    finer = Axis("Y", readings, resolution=0.001)
    unknown = Axis("Y", readings)
    both = analyze(run_with([known, finer])).poses[0].XY
    assert both.uncertainty == 0.01 / math.sqrt(12)
    one = analyze(run_with([known, unknown])).poses[0].XY
    assert one.uncertainty is None
    assert one.uncertainty_ratio is None


def test_a_pose_is_found_by_number_and_by_name(rng):
    rows = np.repeat(np.arange(31), 2)
    run = Run(rows + 1, {"X": Axis("X", rng.normal(0, 0.01, 62))}, pose=np.tile(["P1", "P2"], 31))
    analysis = analyze(run)
    assert analysis.poses["P2"] is analysis.poses[1]
    assert analysis.poses[:1] == (analysis.poses["P1"],)
    with pytest.raises(KeyError, match="no pose 'P3': there is P1, P2"):
        _ = analysis.poses["P3"]
    assert repr(analysis).startswith("<Analysis of a run: 2 pose(s), 30 cycles")
    assert "array" not in repr(analysis.poses)


def test_an_angle_is_never_farther_from_its_command_than_half_a_turn():
    """Commanded 179.9 deg, read as -179.9: 0.2 deg off. A length of 300 mm is 300 mm off."""
    wobble = np.tile([0.01, -0.01], 16)[:31]
    wobble[0] = 0.0
    turned = Axis("theta", -179.9 + wobble, Dimension.ANGLE, 0.001, command=179.9)
    far = Axis("X", 300.0 + wobble, resolution=0.001, command=0.0)
    axes = analyze(run_with([turned, far], metadata={"dial_zero": "command"})).poses[0].axes
    assert axes["theta"].accuracy == pytest.approx(0.2)
    assert axes["X"].accuracy == pytest.approx(300.0)


def test_only_theta_becomes_an_angle_by_its_radius(rng):
    axes = [scatter(rng, name) for name in ("X", "theta", "Z")]
    found = analyze(run_with(axes, metadata={"theta_radius_mm": "100"})).poses[0].axes
    assert (found["X"].angle, found["Z"].angle) == (None, None)
    assert found["theta"].angle.radius_mm == 100.0


def test_two_cycles_are_enough_for_scatter_and_one_is_not(rng):
    axis = Axis("X", np.array([0.0, 0.01, 0.03]), resolution=0.001)
    found = analyze(Run(np.array([1, 2, 3]), {"X": axis}), cycles=3).poses[0].axes["X"]
    assert found.n == 2
    assert found.RP == pytest.approx(0.01)  # both are 10 um from their mean
    with pytest.raises(DataError, match="1 cycle counts"):
        analyze(
            Run(np.array([1, 2]), {"X": Axis("X", np.array([0.0, 0.1]), resolution=0.001)}),
            cycles=2,
        )
