"""One contract meets every effect; then each one's own physics."""

import numpy as np
import pytest

from scara_iso.effects import (
    Conditions,
    Effect,
    Sweep,
    find_effects,
    find_gear_effects,
)

EFFECTS = {effect.name: effect for effect in find_effects()}
GEAR = {effect.name: effect for effect in find_gear_effects()}

# Values by parameter name, for any effect; one that has others fails here until it is listed.
VALUES = {
    "size": 2.0, "at_cycle": 12, "tau": 5.0, "period": 6.0, "phase": 0.3, "switching": 0.2,
    "ratio": 2.0, "scatter": 1.0, "division": 0.5, "full_at": 0.8,
    "N": 50.0, "factor": 1.5, "held": 0.3, "compliance": 1e-4,
}  # fmt: skip


@pytest.fixture
def conditions(rng):
    n = 30
    return Conditions(
        np.arange(2, n + 2),
        {
            "time_s": np.arange(n) * 7.0,
            "approach": np.tile([1.0, -1.0], n // 2),
            "payload_kg": rng.choice([1.0, 2.0, 3.0], n),
            "temperature_C": 20 + rng.random(n),
            "speed": rng.uniform(0.1, 1.0, n),
            "humidity": rng.random(n),
        },
    )


@pytest.fixture
def sweep():
    return Sweep(
        I_m=np.full(4, 2.65e-4),
        I_L=np.array([1.0, 2.0, 4.0, 8.0]),
        gap=np.full(4, 3.49e-3),
        torque=np.array([1.0, 3.0, 2.0, 5.0]),
    )


def test_the_catalogue_holds_every_name_that_the_interface_promises():
    promised = {
        "linear_drift", "warm_up", "step", "periodic", "contact_side", "lost_motion",
        "temperature", "compliance", "random_walk", "outlier", "resolution", "scatter_change",
        "coast_in_gap",
    }  # fmt: skip
    assert promised <= EFFECTS.keys()
    assert {"reflected_inertia", "friction_hold", "wind_up", "held_motor"} <= GEAR.keys()


@pytest.mark.parametrize("effect", [*EFFECTS.values(), *GEAR.values()], ids=lambda e: e.name)
def test_every_effect_says_what_it_is(effect):
    assert effect.name.isidentifier()
    assert effect.name == effect.name.lower()
    assert len(effect.cause) > 20
    assert len(effect.confirm_by) > 20
    assert all(p.name and p.symbol and p.meaning for p in effect.parameters)


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=lambda e: e.name)
def test_every_effect_gives_one_finite_value_a_cycle(effect, conditions):
    values = {p.name: VALUES[p.name] for p in effect.parameters if p.name != "column"}
    series = effect.series(conditions, values, np.random.default_rng(3))
    assert series.shape == (len(conditions),)
    assert np.all(np.isfinite(series))
    again = effect.series(conditions, values, np.random.default_rng(3))
    np.testing.assert_array_equal(series, again)
    assert np.ptp(series) > 0


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=lambda e: e.name)
def test_every_shape_has_a_row_for_each_cycle(effect: Effect, conditions):
    names = {p.name for p in effect.parameters}
    for shape in effect.shapes(conditions):
        assert len(shape.columns) == len(conditions)
        assert np.all(np.isfinite(shape.columns))
        assert shape.weight > 0
        assert set(shape.parameters) <= names
        assert set(effect.sizes(np.ones(shape.columns.shape[1]))) <= names
    for process in effect.processes(conditions):
        assert np.linalg.eigvalsh(process.covariance).min() > -1e-9


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=lambda e: e.name)
def test_a_series_lies_in_the_span_of_its_own_shapes(effect: Effect, conditions):
    for shape in effect.shapes(conditions)[:5]:
        size = {"size": 2.0, "phase": 0.3} | {
            k: v for k, v in shape.parameters.items() if k != "column"
        }
        if effect.chains:  # a course drawn at random; its shapes hold one order of it only
            continue
        if shape.parameters.get("column", "humidity") not in ("humidity", "temperature_C"):
            continue
        series = effect.series(conditions, size, np.random.default_rng(0))
        design = np.column_stack([np.ones(len(series)), shape.columns])
        left = series - design @ np.linalg.lstsq(design, series, rcond=None)[0]
        assert np.abs(left).max() < 1e-9


def test_effects_of_covariates_that_were_not_recorded_are_not_searched():
    bare = Conditions(np.arange(2, 32))
    for name in ("lost_motion", "compliance", "temperature", "covariate", "coast_in_gap"):
        assert EFFECTS[name].shapes(bare) == ()


def test_time_is_in_cycles_whatever_the_clock():
    by_number = Conditions(np.arange(2, 32))
    by_clock = Conditions(np.arange(2, 32), {"time_s": 100 + 12.5 * np.arange(30)})
    np.testing.assert_allclose(by_number.time, by_clock.time)


@pytest.mark.parametrize("effect", GEAR.values(), ids=lambda e: e.name)
def test_every_gear_effect_predicts_a_deviation_within_its_gap(effect, sweep):
    for values in effect.candidates(sweep):
        assert set(values) == {p.name for p in effect.parameters}
    values = {p.name: VALUES[p.name] for p in effect.parameters}
    deviation = effect.deviation(sweep, values)
    assert deviation.shape == sweep.gap.shape
    assert np.all(deviation <= 0)


def test_reflected_inertia_is_the_published_figure_seen_through_the_gearbox():
    paper = Sweep(np.array([2.65e-4]), np.array([4.749]), np.array([3.490659e-3]))
    deviation = GEAR["reflected_inertia"].deviation(paper, {"N": 50})
    assert deviation[0] == pytest.approx(-4.27342e-4, rel=1e-5)


def test_gear_effects_reach_their_limits(sweep):
    np.testing.assert_allclose(GEAR["held_motor"].deviation(sweep, {}), -sweep.gap)
    far = GEAR["reflected_inertia"].deviation(sweep, {"N": 1e6})
    np.testing.assert_allclose(far, -sweep.gap, rtol=1e-6)
    assert not np.any(GEAR["friction_hold"].deviation(sweep, {"held": 1.0}))
    free = GEAR["gap"].deviation(sweep, {"factor": 1.0})
    np.testing.assert_allclose(free, GEAR["wind_up"].deviation(sweep, {"compliance": 0.0}))
