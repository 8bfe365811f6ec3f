"""Effects on the gear, on sweeps that the drive train through time gives."""

import numpy as np
import pytest
from undeclared.gearbox import GAP, MOTOR, free_motor

from scara_iso.diagnosis import Verdict
from scara_iso.diagnosis.gears import Reversals, diagnose_sweep, fit_family, single_families
from scara_iso.effects import Sweep, find_gear_effects

LOADS = np.array([0.5, 1.0, 2.0, 4.749, 8.0, 12.0])
EFFECTS = {effect.name: effect for effect in find_gear_effects()}


def sweep_of(loads, **columns):
    return Sweep(np.full(len(loads), MOTOR), np.array(loads), np.full(len(loads), GAP), **columns)


def noisy(true, size, rng):
    return true + size * np.abs(true) * rng.normal(size=len(true))


def names(found):
    return {effect.effect for effect in found.effects}


@pytest.mark.slow
@pytest.mark.parametrize("known", [True, False])
def test_scatter_that_grows_with_the_deviation_is_no_effect(known):
    sweep, alarms = sweep_of(LOADS), 0
    for seed in range(100):
        measured = noisy(sweep.deviation, 0.1, np.random.default_rng(seed))
        u = 0.1 * np.abs(sweep.deviation) if known else None
        found = diagnose_sweep(sweep, measured, uncertainty=u)
        alarms += found.verdict is not Verdict.NOTHING
    assert alarms <= 10


@pytest.mark.parametrize("known", [True, False])
def test_a_second_effect_is_added_where_the_sweep_can_hold_it(known, rng):
    loads = np.tile(LOADS, 2)
    true = np.array([free_motor(load, ratio=50, gap=1.6 * GAP) for load in loads])
    u = 0.02 * np.abs(true) if known else None
    found = diagnose_sweep(sweep_of(loads), noisy(true, 0.02, rng), uncertainty=u)
    assert names(found) == {"reflected_inertia", "gap"}
    values = {k: v for e in found.effects for k, v in e.parameters.items()}
    ends = {k: v for e in found.effects for k, v in e.intervals.items()}
    for name, value in {"N": 50, "factor": 1.6}.items():
        assert values[name] == pytest.approx(value, rel=0.1)
        assert ends[name][0] < value < ends[name][1]
    assert found.error.after.held_out_rms < 0.1 * found.error.before.held_out_rms


def test_one_inertia_holds_one_effect_and_says_so(rng):
    loads = np.full(8, 4.749)
    true = np.array([free_motor(load, ratio=50, gap=1.6 * GAP) for load in loads])
    found = diagnose_sweep(sweep_of(loads), noisy(true, 0.02, rng))
    assert len(found.effects) == 1
    assert "vary the inertia of the payload" in " ".join(found.notes)


@pytest.mark.parametrize("known", [True, False])
def test_structure_of_no_known_effect_is_unexplained(known, rng):
    loads = np.tile(LOADS, 2)
    true = -1e-4 * np.sqrt(loads)
    u = 0.03 * np.abs(true) if known else None
    found = diagnose_sweep(sweep_of(loads), noisy(true, 0.03, rng), uncertainty=u)
    assert found.verdict is Verdict.UNEXPLAINED
    assert found.effects == ()
    assert found.error.after.rms == found.error.before.rms


def test_a_bump_is_unexplained_where_the_rows_show_its_course(rng):
    loads = np.geomspace(0.5, 12.0, 12)
    bump = -2e-4 * np.exp(-(np.log(loads / 3) ** 2))
    found = diagnose_sweep(sweep_of(loads), noisy(bump, 0.03, rng))
    assert found.verdict is Verdict.UNEXPLAINED


def test_what_scatter_may_hide_is_said(rng):
    """Six reversals a thousand times too large, and as unequal."""
    uneven = -1e-4 * np.array([0.1, 2.0, 0.3, 1.5, 0.1, 0.2])
    found = diagnose_sweep(sweep_of(LOADS), uneven)
    assert found.verdict is Verdict.NOTHING
    assert "times its own prediction" in found.notes[0]
    following = diagnose_sweep(sweep_of(LOADS), noisy(sweep_of(LOADS).deviation, 0.05, rng))
    assert "times its own" not in " ".join(following.notes)


@pytest.mark.parametrize(("measured", "u"), [(0.0, None), (-1e-3, 1e-13), (-1e-3, None)])
def test_reversals_that_are_all_zero_or_exactly_known_end_in_no_fault(measured, u):
    given = None if u is None else np.full(6, u)
    found = diagnose_sweep(sweep_of(LOADS), np.full(6, measured), uncertainty=given)
    assert 0 <= found.p_value <= 1


def test_a_known_ratio_is_used(rng):
    ratio = np.resize([50.0, 50.0, 100.0], 6)
    true = np.array([free_motor(load, ratio=n) for load, n in zip(LOADS, ratio, strict=True)])
    found = diagnose_sweep(sweep_of(LOADS, ratio=ratio), noisy(true, 0.01, rng))
    assert names(found) == {"reflected_inertia"}
    assert found.effects[0].parameters["N"] == pytest.approx(50, rel=0.02)
    without = diagnose_sweep(sweep_of(LOADS), noisy(true, 0.01, rng))
    assert without.error.after.rms > 5 * found.error.after.rms
    wrong = sweep_of(LOADS, ratio=np.full(6, 5.0))
    tried = EFFECTS["reflected_inertia"].candidates(wrong)
    assert all(4 <= values["N"] <= 6.25 for values in tried)


def test_the_rotor_is_not_reflected_twice():
    sweep = sweep_of(LOADS, ratio=np.full(6, 50.0))
    effect = EFFECTS["reflected_inertia"]
    once = effect.changed(sweep, N=50.0)
    np.testing.assert_allclose(once.deviation, [free_motor(load, ratio=50) for load in LOADS])
    assert np.median([values["N"] for values in effect.candidates(once)]) == pytest.approx(1)


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=lambda e: e.name)
def test_columns_of_values_give_a_row_for_each(effect):
    sweep = sweep_of(LOADS, torque=np.arange(1.0, 7.0))
    values = effect.candidates(sweep)[::100][:5]
    columns = {p.name: np.array([[v[p.name]] for v in values]) for p in effect.parameters}
    together = np.atleast_2d(effect.changed(sweep, **columns).deviation)
    alone = np.stack([effect.changed(sweep, **v).deviation for v in values])
    np.testing.assert_array_equal(together, alone)


def test_the_grids_close_in_on_the_likeliest_value(rng):
    true = EFFECTS["reflected_inertia"].changed(sweep_of(LOADS), N=37.123456).deviation
    data = Reversals(
        true, {None: sweep_of(LOADS)}, {None: np.ones(6)}, np.arange(6), 1e-6 * np.abs(true)
    )
    (family,) = single_families(data, [EFFECTS["reflected_inertia"]])
    fitted = fit_family(data, family)
    assert fitted.values[0]["N"] == pytest.approx(37.123456, rel=1e-6)
    wider = Reversals(
        true, {None: sweep_of(LOADS)}, {None: np.ones(6)}, np.arange(6), 1e-2 * np.abs(true)
    )
    assert fit_family(wider, family).log_evidence > fitted.log_evidence
