"""What follows a recorded column is traced to joints, links and dials, from all poses."""

import numpy as np
import pytest

from scara_iso.diagnosis.joint_scatter import followed_in_joints
from scara_iso.effects import Conditions
from scara_iso.robot import Arm

ARM = Arm(250, 200)
POSES = [(10, 80), (-30, 110), (45, 60), (-50, 60), (60, 110)]
FINE = np.zeros(2)
N = 30


def recorded(rng, **columns):
    ways = rng.permutation(np.where(np.arange(N) % 2, 1.0, -1.0))
    return Conditions(np.arange(2, N + 2), {"approach": ways, **columns})


def scatter(rng, poses=POSES):
    turned = np.einsum("pij,npj->npi", ARM.jacobian(poses), rng.normal(0, 1e-5, (N, len(poses), 2)))
    return turned + rng.normal(0, 1.5e-3, (N, len(poses), 2))


def turned(course, joint_1, joint_2, poses=POSES):
    return course[:, None, None] * (ARM.jacobian(poses) @ np.array([joint_1, joint_2]))


def test_sizes_are_given_back_where_nothing_scatters(rng):
    loads = rng.permutation(np.resize([0.0, 1.0, 2.0], N))
    warm = rng.normal(20, 1, N)
    conditions = recorded(rng, payload_kg=loads, temperature_C=warm)
    grown = (warm - warm.mean())[:, None, None] * (12e-6 * ARM.forward(POSES) + [0.0, 0.003])
    shown = turned(conditions.covariates["approach"], 5e-6, -20e-6) + grown
    shown = shown + turned(loads, 0, 8e-6) + rng.normal(0, 1e-9, shown.shape)
    found = {one.effect: one for one in followed_in_joints(shown, POSES, FINE, ARM, conditions)}
    sizes = {name: {k: size.value for k, size in one.sizes.items()} for name, one in found.items()}
    near = {"abs": 1e-8}
    assert sizes["lost_motion"]["joint 1"] == pytest.approx(5e-6, **near)
    assert sizes["lost_motion"]["joint 2"] == pytest.approx(-20e-6, **near)
    assert sizes["compliance"]["joint 2"] == pytest.approx(8e-6, **near)
    assert sizes["temperature"]["along the arm"] == pytest.approx(12e-6, **near)
    assert sizes["temperature"]["Y everywhere"] == pytest.approx(0.003, abs=1e-6)
    units = [size.unit for size in found["temperature"].sizes.values()]
    assert units == ["rad/°C", "rad/°C", "1/°C", "mm/°C", "mm/°C"]
    assert found["lost_motion"].sizes.keys() == {
        "joint 1", "joint 2", "X everywhere", "Y everywhere"}  # fmt: skip


def test_intervals_hold_the_truth(rng):
    inside = []
    for _ in range(60):
        conditions = recorded(rng)
        shown = scatter(rng) + turned(conditions.covariates["approach"], 5e-6, 20e-6)
        (one,) = followed_in_joints(shown, POSES, FINE, ARM, conditions)
        true = {"joint 1": 5e-6, "joint 2": 20e-6, "X everywhere": 0.0, "Y everywhere": 0.0}
        inside += [
            size.interval[0] <= true[name] <= size.interval[1] for name, size in one.sizes.items()
        ]
    assert 0.9 < np.mean(inside) < 0.99  # benchmarks/joint_columns.py has more runs


def test_a_step_that_was_found_does_not_pass_for_what_is_recorded(rng):
    step = (np.arange(N) >= 15) * 1.0
    warm = 20 + step + rng.normal(0, 0.3, N)
    conditions = Conditions(np.arange(2, N + 2), {"temperature_C": warm})
    measured = scatter(rng) + turned(step, 0, 1e-4), POSES, FINE
    (alone,) = followed_in_joints(*measured, ARM, conditions)
    (beside,) = followed_in_joints(*measured, ARM, conditions, [step[:, None]])
    assert alone.sizes["joint 2"].interval[0] > 0
    assert beside.sizes["joint 2"].interval[0] < 0 < beside.sizes["joint 2"].interval[1]


def test_poses_that_disagree_are_said_and_widen_the_intervals(rng):
    conditions = recorded(rng)
    shown, course = scatter(rng), conditions.covariates["approach"]
    (even,) = followed_in_joints(shown, POSES, FINE, ARM, conditions)
    shown[:, 2] += course[:, None] * [0.02, -0.01]  # the indicator of one pose alone
    (odd,) = followed_in_joints(shown, POSES, FINE, ARM, conditions)
    assert odd.misfit_p_value < 1e-3 < even.misfit_p_value
    one, other = (found.sizes["joint 1"] for found in (even, odd))
    assert other.interval[1] - other.interval[0] > 2 * (one.interval[1] - one.interval[0])


@pytest.mark.parametrize(
    ("poses", "columns"),
    [
        (POSES[:2], {}),  # as many numbers as sources
        ([(q, 0) for q, _ in POSES], {}),  # straight: joints 1 and 2 move alike
        (POSES, {"approach": np.ones(N)}),
        (POSES, {"approach": np.where(np.arange(N) % 2, 1.0, -1.0),
                 "payload_kg": 2.0 + np.where(np.arange(N) % 2, 1.0, -1.0)}),
    ],
)  # fmt: skip
def test_what_cannot_be_told_is_not_said(rng, poses, columns):
    conditions = recorded(rng, **columns)
    shown = scatter(rng, poses)
    assert followed_in_joints(shown, poses, FINE, ARM, conditions) == ()


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_what_follows_a_column_is_found_in_any_unit(rng, factor):
    load = rng.permutation(np.resize([0.0, 1.0, 2.0], N))
    shown = scatter(rng) + turned(load, 0, 1e-4)
    (usual,), (other,) = (
        followed_in_joints(
            shown, POSES, FINE, ARM, Conditions(np.arange(2, N + 2), {"payload_kg": one})
        )
        for one in (load, factor * load)
    )
    for place, size in usual.sizes.items():
        assert factor * other.sizes[place].value == pytest.approx(size.value)
