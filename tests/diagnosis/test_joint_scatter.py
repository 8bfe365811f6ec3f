"""Scatter of several poses traced to joints and dial, and RP where nobody measured."""

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from budget import examples
from hypothesis import given, strategies as st
from scipy.optimize import minimize

import scara_iso
from scara_iso.commands import main
from scara_iso.diagnosis.joint_scatter import (
    ScatterAtPose,
    joint_scatter,
    reach_map,
    trace_poses,
)
from scara_iso.diagnosis.sources import (
    PoseCovariances,
    deviance,
    fit_variances,
    gaussian_rp,
    patterns_of,
    rounding_of,
    source_intervals,
    trace,
)
from scara_iso.robot import Arm

LINKS = 250.0, 200.0
ARM = Arm(*LINKS)
POSES = {"P1": (-40.0, 60.0), "P2": (-10.0, 100.0), "P3": (20.0, 40.0), "P4": (45.0, 90.0)}
TRUE = np.array([10e-6, 15e-6, 1.5e-3])
DIVISION = (0.001, 0.001)


def tool(q):
    a, b = math.radians(q[0]), math.radians(q[0] + q[1])
    return np.array([LINKS[0] * math.cos(a) + LINKS[1] * math.cos(b),
                     LINKS[0] * math.sin(a) + LINKS[1] * math.sin(b)])  # fmt: skip


def readings(rng, q, n=30, true=TRUE, division=0.001):
    """Return what dials show of n arrivals (n, 2): forward kinematics of scattered joints."""
    joints = np.array(q) + np.degrees(rng.normal(size=(n, 2)) * true[:2])
    moved = np.array([tool(one) for one in joints]) + rng.normal(size=(n, 2)) * true[2]
    return np.round(moved / division) * division


def measured(seed=0, poses=POSES, **how):
    rng = np.random.default_rng(seed)
    return {pose: at_pose(q, readings(rng, q, **how)) for pose, q in poses.items()}


def at_pose(joints, left):
    return ScatterAtPose(joints, left, left)


def traced(poses, **more):
    division = more.pop("division", DIVISION)
    given = {"elsewhere": {}, "held_out": {}} | more
    return joint_scatter(trace_poses(poses, ARM, division), poses, ARM, **given)


def covariances(variances, joints, freedom=29.0):
    """Return those without chance; ``variances`` (4,), the last the joints' covariance."""
    patterns = patterns_of(ARM, joints)
    known = rounding_of(DIVISION)
    observed = known + np.einsum("k,pkij->pij", variances, patterns)
    return PoseCovariances(observed, np.full(len(joints), freedom), patterns, known)


@pytest.mark.parametrize("n", [8, 30])
@pytest.mark.parametrize("narrow", [1.0, 0.4, 0.0])
def test_expected_rp_is_that_of_simulated_tests(n, narrow):
    turn = np.array([[math.cos(1), -math.sin(1)], [math.sin(1), math.cos(1)]])
    shape = turn @ np.diag([2.0, 2.0 * narrow])
    drawn = shape @ np.random.default_rng(1).normal(size=(20_000, 2, n))
    length = np.linalg.norm(drawn - drawn.mean(axis=-1, keepdims=True), axis=1)
    RP = length.mean(axis=-1) + 3 * length.std(axis=-1, ddof=1)
    value, error = gaussian_rp(shape @ shape.T, n)
    assert value == pytest.approx(RP.mean(), rel=0.01)
    assert error == pytest.approx(RP.std() / RP.mean(), rel=0.05)


@examples(25)
@given(
    joints=st.lists(
        st.tuples(st.floats(-120, 120), st.floats(20, 140)), min_size=3, max_size=6,
        unique_by=lambda q: round(q[1] / 15),
    ),
    variances=st.tuples(*[st.sampled_from([0.0, 0.3, 1.0, 4.0])] * 3).filter(any),
    rho=st.sampled_from([-0.7, 0.0, 0.5]),
)  # fmt: skip
def test_covariances_without_chance_give_back_what_they_were_made_of(joints, variances, rho):
    first, second, dial = np.array(variances) * np.array([1e-10, 2e-10, 4e-6])
    made = np.array([first, second, dial, rho * math.sqrt(first * second)])
    found = fit_variances(covariances(made, joints), together=True)
    assert found == pytest.approx(made, rel=1e-3, abs=1e-3 * max(first, second, dial / 1e5))


def test_the_fit_is_the_likeliest_one():
    given_ = trace_poses(measured(3), ARM, DIVISION).given

    def minus(logs):
        return float(deviance(given_, np.array([*TRUE**2 * np.exp(logs), 0.0])))

    best = minimize(minus, np.zeros(3), method="Nelder-Mead", options={"xatol": 1e-6})
    assert fit_variances(given_, together=False)[:3] == pytest.approx(
        TRUE**2 * np.exp(best.x), rel=1e-3
    )


def test_at_the_ends_of_an_interval_the_fit_is_as_unlikely_as_a_normal_distribution_says():
    fit = trace_poses(measured(3), ARM, DIVISION)
    for k, ends in enumerate(source_intervals(fit)):
        for end in ends:
            variances = fit.variances.copy()
            variances[k] = end**2
            if end:
                away = abs(end**2 - fit.variances[k])
                assert away == pytest.approx(1.96 * fit.errors(variances)[k, k] ** 0.5, rel=1e-3)


def test_scatter_is_traced_to_where_it_comes_from():
    found = traced(measured(0))
    for name, true in zip(("joint 1", "joint 2", "dial"), TRUE, strict=True):
        source = found.sources[name]
        assert source.interval[0] < true < source.interval[1]
    assert found.sources["neither"].interval[0] == 0
    assert found.sources["joint 1"].unit == "rad"
    assert 0.8 < sum(one.share or 0 for one in found.sources.values()) < 1  # the rest is rounding


def test_a_joint_that_does_not_scatter_gets_nothing_or_an_interval_from_nothing():
    found = [traced(measured(seed, true=TRUE * [1, 0, 1])).sources["joint 2"] for seed in range(3)]
    assert [one.interval[0] for one in found] == [0.0] * 3
    assert 0.0 in [one.value for one in found]
    assert all(one.interval[1] > one.value for one in found)


def test_joints_that_scatter_together_are_seen_to_do_so():
    rng = np.random.default_rng(2)
    mixed = np.array([[1.0, 0.0], [-0.8, 0.6]]) * TRUE[:2, np.newaxis]
    poses = {}
    for pose, q in POSES.items():
        moved = rng.normal(size=(30, 2)) @ mixed.T @ ARM.jacobian(q).T
        poses[pose] = at_pose(q, moved + rng.normal(size=(30, 2)) * TRUE[2])
    found = traced(poses, division=(0.0, 0.0))
    assert found.together.interval[0] < -0.8 < found.together.interval[1] < -0.5
    assert found.together.p_value < 0.001
    assert sum(one.share or 0 for one in found.sources.values()) == pytest.approx(1)
    for name, true in zip(("joint 1", "joint 2", "dial"), TRUE, strict=True):
        assert found.sources[name].interval[0] < true < found.sources[name].interval[1]
    assert traced(measured(0)).together is None


def test_what_scatters_at_one_pose_only_is_neither_and_widens_the_intervals():
    poses = measured(2)
    plain = traced(poses, elsewhere={"P9": (0.0, 75.0)})
    rng = np.random.default_rng(5)
    loose = poses["P3"].left + rng.normal(size=(30, 1)) * [0.008, 0.008]
    found = traced(poses | {"P3": at_pose(POSES["P3"], loose)}, elsewhere={"P9": (0.0, 75.0)})
    assert found.misfit.p_value < 0.001 < plain.misfit.p_value
    assert found.sources["neither"].interval[0] > 0.003
    assert "something else scatters" in found.notes[0]
    before, after = plain.predicted_RP["P9"], found.predicted_RP["P9"]
    assert (after.interval[1] / after.interval[0]) > 1.5 * (before.interval[1] / before.interval[0])


def test_a_dial_of_half_the_scatter_in_divisions_is_too_coarse_and_says_so():
    poses = measured(0, division=0.02)
    found = traced(poses, division=(0.02, 0.02))
    assert "rounding to the dial's division" in found.notes[0]


@pytest.mark.parametrize(
    ("angle", "factor", "said"),
    [(0.0, 1.0, "do not tell the scatter"), (90.0, 1.0, ""), (90.0, 0.0, "of the variance is")],
)
def test_poses_that_tell_little_give_finite_figures_and_say_so(angle, factor, said):
    rng = np.random.default_rng(1)
    poses = {}
    for k, first in enumerate((0.0, 30.0, 60.0)):
        left = np.round(rng.normal(size=(20, 2)) * 0.005, 3) * (1.0 if k else factor) * factor
        poses[f"P{k}"] = at_pose((first, angle), left)
    found = traced(poses, elsewhere={"P9": (0.0, 75.0)})
    told = found.predicted_RP["P9"]
    assert 0 < told.interval[0] < told.value < told.interval[1] < 1
    assert all(
        0 <= one.interval[0] <= one.value <= one.interval[1] < 1 for one in found.sources.values()
    )
    assert any(said in note for note in found.notes) or not said


@pytest.mark.parametrize("correlation", [-0.97, -0.7, 0.9])
def test_joints_that_scatter_together_have_intervals(correlation):
    made = np.array([*TRUE**2, correlation * TRUE[0] * TRUE[1]])
    for noisy in (1.0, 1.5):
        given_ = covariances(made, list(POSES.values()), freedom=4.0)
        fit = trace(replace(given_, observed=given_.observed * np.array([[1, 1], [1, noisy]])))
        for (low, high), variance in zip(source_intervals(fit), fit.variances, strict=False):
            assert low <= variance**0.5 * (1 + 1e-9)
            assert variance**0.5 <= high * (1 + 1e-9) < math.inf


@pytest.mark.parametrize("seed", range(12))
def test_scatters_of_any_size_at_any_poses_give_finite_figures(seed):
    rng = np.random.default_rng(seed)
    poses = {}
    for k in range(2 + seed % 4):
        joints = (rng.uniform(-150, 150), rng.choice([0.0, 180.0, 90.0]) if seed % 3 else 60.0)
        left = rng.normal(size=(3 + seed, 2)) * 10.0 ** rng.uniform(-6, 1)
        poses[f"P{k}"] = ScatterAtPose(joints, left, left, float(seed % 2))
    division = (1.0, 0.001, 0.0)[seed % 3]
    found = traced(poses, division=(division, division), elsewhere={"P9": (10.0, 70.0)})
    for one in found.sources.values():
        assert 0 <= one.interval[0] <= one.value + 1e-12
        assert one.value <= one.interval[1] * (1 + 1e-9) + 1e-12 < math.inf
    told = found.predicted_RP["P9"]
    assert all(map(math.isfinite, (told.value, *told.interval)))


def test_poses_left_out_are_foretold_by_the_others_only():
    poses = measured(4)
    found = traced(poses)
    others = {pose: one for pose, one in poses.items() if pose != "P2"}
    alone = traced(others, held_out={"P2": poses["P2"]})
    assert alone.held_out["P2"].predicted.value == pytest.approx(
        found.left_out["P2"].predicted.value, rel=1e-4
    )
    assert alone.predicted_RP.keys() == {"P2"}
    assert found.left_out["P2"].measured == alone.held_out["P2"].measured


def test_the_map_is_the_same_all_around_the_base_and_ends_where_the_arm_does():
    arm = Arm(*LINKS, joint_2_deg=(-140.0, 140.0))
    found = reach_map(trace_poses(measured(1), arm, DIVISION), arm, POSES, cells=40)
    x, y = np.meshgrid(found.x, found.y)
    radius = np.hypot(x, y)
    assert np.isnan(found.RP[radius > 450.1]).all()
    assert np.isnan(found.RP[radius < 150]).all()
    ring = np.abs(radius - 320) < 3
    assert np.ptp(found.RP[ring]) < 0.01 * found.RP[ring].mean()
    assert found.best.RP == pytest.approx(np.nanmin(found.RP), abs=1e-9)
    assert np.hypot(found.worst.x_mm, found.worst.y_mm) > np.hypot(found.best.x_mm, found.best.y_mm)


MODEL = """
[robot]
link_1_mm = 250
link_2_mm = 200
joint_2_deg = [-145, 145]
[indicator.X]
[indicator.Y]
"""


@pytest.fixture(scope="module")
def test_of_three(tmp_path_factory):
    folder = tmp_path_factory.mktemp("joints")
    rng = np.random.default_rng(9)
    named = {pose: POSES[pose] for pose in ("P1", "P2", "P3")}
    columns = {pose: readings(rng, q, n=13) - tool(q) for pose, q in named.items()}
    lines = ["# unit: mm", "# resolution: 0.001", "cycle,pose,X,Y,approach"]
    lines += [
        f"{k + 1},{pose},{x:.3f},{y:.3f},{(-1) ** k:+d}"
        for k in range(13) for pose, values in columns.items() for x, y in values[k : k + 1]
    ]  # fmt: skip
    (folder / "three.csv").write_text("\n".join(lines))
    poses = "".join(f"[pose.{pose}]\njoint_deg = {list(q)}\n" for pose, q in POSES.items())
    (folder / "robot.toml").write_text(MODEL + poses)
    (folder / "nowhere.toml").write_text(MODEL + "[pose.P4]\njoint_deg = [0, 90]\n")
    (folder / "no_arm.toml").write_text("[indicator.X]\n[pose.P1]\njoint_deg = [0, 90]\n")
    return folder


def test_diagnose_traces_the_scatter_of_a_test_and_foretells_a_pose(
    test_of_three, monkeypatch, capsys
):
    monkeypatch.chdir(test_of_three)
    asked = ["diagnose", "three.csv", "--model", "robot.toml", "--cycles", "13"]
    wanted = ["--hold-out", "P3", "--map", "map.csv", "--limit", "XY=0.02", "--json"]
    assert main([*asked, *wanted]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [pose["pose"] for pose in told["poses"]] == ["P1", "P2"]
    assert told["joint_scatter"].keys() == {"joint 1", "joint 2", "dial", "neither"}
    assert told["joint_scatter"]["joint 2"]["unit"] == "rad"
    assert told["predicted_RP"].keys() == {"P3", "P4"}
    low, high = told["predicted_RP"]["P3"]["interval"]
    assert low < told["predicted_RP"]["P3"]["value"] < high
    whole = scara_iso.analyze("three.csv", cycles=13).poses["P3"].XY.RP
    assert told["held_out"]["P3"]["measured"] == pytest.approx(whole)
    rows = list(csv.DictReader((test_of_three / "map.csv").read_text().splitlines()))
    values = [float(row["RP_mm"]) for row in rows]
    assert told["map"]["worst"]["RP"] == pytest.approx(max(values), abs=1e-6)
    assert all(float(row["low_mm"]) < float(row["high_mm"]) for row in rows)
    kept = [row["kept"] == "1" for row in rows]
    assert kept == [float(row["high_mm"]) <= 0.02 for row in rows]
    assert told["map"]["share_kept"] == pytest.approx(sum(kept) / len(kept))


def test_a_second_test_of_the_same_poses_measures_the_error(test_of_three, rng, capsys):
    columns = {pose: readings(rng, POSES[pose], n=12) for pose in ("P1", "P2", "P3")}
    rows = [
        f"{k + 2},{pose},{x:.3f},{y:.3f},{(-1) ** k:+d}"
        for k in range(12) for pose, values in columns.items() for x, y in values[k : k + 1]
    ]  # fmt: skip
    second = test_of_three / "second.csv"
    head = ["# unit: mm", "# resolution: 0.001", "# first_cycle_discarded: true"]
    second.write_text("\n".join([*head, "cycle,pose,X,Y,approach", *rows]))
    table = test_of_three / "three.csv"
    found = scara_iso.diagnose(table, cycles=13, hold_out=second, sigma=0.004)
    shown = np.round(np.array([*columns.values()]), 3)
    expected = np.sqrt(((shown - shown.mean(axis=1, keepdims=True)) ** 2).mean(axis=(0, 1)))
    unseen = found.error.before.held_out_rms
    assert [unseen["X"], unseen["Y"]] == pytest.approx(expected.tolist())
    lacking = test_of_three / "lacking.csv"
    lacking.write_text("\n".join([*head, "cycle,pose,X,Y,approach"] +
                                 [row for row in rows if ",P3," not in row]))  # fmt: skip
    assert main(["diagnose", str(table), "--cycles", "13", "--hold-out", str(lacking)]) == 65
    out, err = capsys.readouterr()
    assert out == ""
    assert "X at P3" in err


@pytest.mark.slow
def test_the_library_says_the_same_of_all_poses(test_of_three):
    table, model = test_of_three / "three.csv", test_of_three / "robot.toml"
    found = scara_iso.diagnose(table, model, cycles=13)
    assert found.joint_scatter.predicted_RP.keys() == {"P4"}
    assert found.joint_scatter.left_out.keys() == {"P1", "P2", "P3"}
    words = [part.texts[0].get_text() for part in found.plot().subfigs[::2]]
    assert [text.partition(":")[0] for text in words[:3]] == ["P1 X", "P1 Y", "P2 X"]
    (one,) = found.followed
    assert (one.effect, one.column, one.sizes["joint 2"].unit) == ("lost_motion", "approach", "rad")
    unknown = scara_iso.diagnose(table, test_of_three / "nowhere.toml", cycles=13)
    assert unknown.joint_scatter is None
    assert any("where the joints are at P1, P2, P3" in note for note in unknown.notes)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--hold-out", "P9", "--model", "robot.toml"], "no pose 'P9'"),
        (["--hold-out", "P3"], "takes the joints"),
        (["--map", "map.csv"], "--map needs --model"),
        (["--map", "map.pdf", "--model", "robot.toml"], "map.pdf: a map is written as"),
        (["--map", "map.csv", "--model", "robot.toml", "--pose", "P1"], "made of several poses"),
        (["--map", "robot.toml", "--model", "robot.toml"], "robot.toml: a map is written as"),
        (["--map", "map.csv", "--model", "no_arm.toml"], "gives no links"),
        (["--map", "map.csv", "--design"], "does not go with"),
        (["--limit", "XY=0.02"], "--limit needs --model"),
        (["--limit", "Z=0.02", "--model", "robot.toml"], "of RP in XY"),
        (["--limit", "-1", "--model", "robot.toml"], "not a positive"),
    ],
)
def test_what_cannot_be_asked_is_refused(test_of_three, monkeypatch, capsys, options, said):
    monkeypatch.chdir(test_of_three)
    before = sorted(path.name for path in test_of_three.iterdir())
    table = [] if "--design" in options else ["three.csv", "--cycles", "13"]
    assert main(["diagnose", *table, *options]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert sorted(path.name for path in test_of_three.iterdir()) == before
