"""One contract for every file of the catalogue and of third parties, met without being told.

The known effects are then held against their formulas and limits.
"""

import json
import math
import re
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from scara_iso import effects
from scara_iso.base.files import KeyFaults
from scara_iso.commands import main
from scara_iso.diagnosis.engine.hypotheses import hypotheses_of
from scara_iso.diagnosis.readings import diagnose_readings as diagnose
from scara_iso.effects import (
    Chain,
    Conditions,
    Effect,
    GearEffect,
    Grid,
    Parameter,
    Process,
    RandomCourse,
    Shape,
    Spread,
    Sweep,
    find_effects,
    find_gear_effects,
    own_effects,
)
from scara_iso.reporting.diagnosis import diagnosis_report
from scara_iso.reporting.explain import find_pages
from scara_iso.robot.model_file import read_model
from scara_iso.robot.prediction import predict
from scara_iso.run import Axis, Run

ON_READINGS = {
    "linear_drift", "warm_up", "step", "periodic", "contact_side", "lost_motion", "temperature",
    "covariate", "compliance", "random_walk", "outlier", "resolution", "scatter_change",
    "coast_in_gap",
}  # fmt: skip
ON_THE_GEAR = {"reflected_inertia", "friction_hold", "wind_up", "held_motor", "gap"}
CHANCE = {"contact_side", "random_walk", "resolution", "scatter_change"}

J = np.arange(1, 31)
APPROACH = np.resize([1.0, 1.0, -1.0], 30)
TEMPERATURE = 20 + np.sqrt(J)
PAYLOAD = np.resize([0.0, 1.0, 2.5], 30)
SPEED = np.resize([10.0, 50.0, 100.0], 30)
HUMIDITY = np.resize([40.0, 45.0, 43.0, 41.0], 30)
RECORDED = Conditions(
    J,
    {"approach": APPROACH, "temperature_C": TEMPERATURE, "payload_kg": PAYLOAD, "speed": SPEED,
     "humidity": HUMIDITY},
)  # fmt: skip

# Each formula once more, in the words of its source and not of its module.
FORMULAS = {
    "linear_drift": ({"size": 0.1}, 0.1 * (J - 1)),
    "warm_up": ({"size": 2.0, "tau": 4.0}, [2.0 * (1 - math.exp(-(j - 1) / 4.0)) for j in J]),
    "step": ({"size": 2.0, "at_cycle": 9.0}, [0.0] * 8 + [2.0] * 22),
    "periodic": (
        {"size": 2.0, "period": 7.0, "phase": 0.4},
        [2.0 * math.sin(2 * math.pi * (j - 1) / 7.0 + 0.4) for j in J],
    ),
    "contact_side": ({"size": 2.0, "switching": 1.0}, [2.0, 0.0] * 15),
    "lost_motion": ({"size": 2.0}, 2.0 * APPROACH),
    "temperature": (
        {"size": 2.0, "column": "temperature_C"},
        2.0 * (TEMPERATURE - sum(TEMPERATURE) / 30),
    ),
    "covariate": ({"size": 2.0, "column": "humidity"}, 2.0 * (HUMIDITY - sum(HUMIDITY) / 30)),
    "compliance": ({"size": 2.0}, 2.0 * (PAYLOAD - sum(PAYLOAD) / 30)),
    "outlier": ({"size": 2.0, "at_cycle": 9.0}, [0.0] * 8 + [2.0] + [0.0] * 21),
    "coast_in_gap": ({"size": 2.0, "full_at": 60.0}, np.resize([2 / 36, 2 * 25 / 36, 2.0], 30)),
    "onset": ({"size": 0.1, "at_cycle": 9.0}, [0.0] * 9 + [0.1 * k for k in range(1, 22)]),
    "settles": (
        {"size": 2.0, "at_cycle": 9.0, "tau": 4.0},
        [0.0] * 8 + [2.0 * (1 - math.exp(-k / 4.0)) for k in range(1, 23)],
    ),
    "transient that decays": (
        {"size": 2.0, "at_cycle": 9.0, "width": 4.0, "rise": 0.0},
        [0.0] * 8 + [2.0 * math.exp(-k / 4.0) for k in range(22)],
    ),
    "transient that rises": (
        {"size": 2.0, "at_cycle": 9.0, "width": 4.0, "rise": 1.0},
        [2.0 * math.exp(-((j - 9) ** 2) / 32.0) for j in J],
    ),
    "indicator_hysteresis": ({"size": 2.0}, 2.0 * APPROACH),
    "gap_growth": ({"size": 2.0, "growth": 0.1}, (2.0 + 0.1 * (J - 1)) * APPROACH),
}
GEAR = Sweep(
    I_m=np.array([2.65e-4, 1e-3]), I_L=np.array([4.749, 2.0]), gap=np.array([3.5e-3, 1e-3]),
    torque=np.array([10.0, -20.0]),
)  # fmt: skip
EQ_16 = -GEAR.gap / (1 + GEAR.I_L / GEAR.I_m)
GEAR_FORMULAS = {
    "reflected_inertia": ({"N": 50.0}, -GEAR.gap / (1 + GEAR.I_L / (2500 * GEAR.I_m))),
    "friction_hold": ({"held": 0.25}, 0.75 * EQ_16),
    "wind_up": ({"compliance": 1e-5}, EQ_16 * (GEAR.gap + np.array([2e-4, 4e-4])) / GEAR.gap),
    "held_motor": ({}, -GEAR.gap),
    "gap": ({"factor": 1.5}, 1.5 * EQ_16),
}

MEMORIES = Grid.exact([0.3, 0.8])
BY_NAME = {effect.name: effect for effect in [*find_effects(), *find_gear_effects()]}

every = pytest.mark.parametrize(
    "effect", [*find_effects(), *find_gear_effects()], ids=lambda e: e.name
)
on_readings = pytest.mark.parametrize("effect", find_effects(), ids=lambda e: e.name)
on_the_gear = pytest.mark.parametrize("effect", find_gear_effects(), ids=lambda e: e.name)


def values_of(effect):
    """Some value of every parameter, within its limits."""
    return {p.name: value_of(p) for p in effect.parameters}


def value_of(parameter):
    if parameter.text:
        return parameter.grid(RECORDED).values[0]
    if parameter.name == "at_cycle":
        return 9.0
    lowest = max(parameter.above, -1.0)
    return lowest + 0.4 * min(parameter.up_to - lowest, 4.0)


def rng():
    return np.random.default_rng(5)


def test_the_catalogue_is_whole():
    assert {e.name for e in find_effects()} >= ON_READINGS
    assert {e.name for e in find_gear_effects()} >= ON_THE_GEAR


@every
def test_it_says_what_it_is(effect):
    assert effect.name.isidentifier()
    names = [p.name for p in effect.parameters]
    assert len(set(names)) == len(names)
    for p in effect.parameters:
        assert p.name.isidentifier()
        assert p.symbol
        assert p.meaning
        assert p.above < p.up_to
    assert effect.name == effect.name.lower()
    assert len(effect.cause.split()) > 3
    assert len(effect.confirm_by.split()) > 3


@on_readings
def test_its_course_is_pure_finite_and_in_proportion_to_its_size(effect):
    before = {name: values.copy() for name, values in RECORDED.covariates.items()}
    values = values_of(effect)
    course = effect.series(RECORDED, values, rng())
    assert course.shape == (30,)
    assert np.all(np.isfinite(course))
    assert np.array_equal(course, effect.series(RECORDED, values, rng()))
    assert all(np.array_equal(RECORDED.covariates[name], v) for name, v in before.items())
    sizes = {p.name: 2.0 for p in effect.parameters if p.unit.startswith("reading")}
    unit = effect.series(RECORDED, values | dict.fromkeys(sizes, 1.0), rng())
    assert effect.series(RECORDED, values | sizes, rng()) == pytest.approx(2 * unit)


@on_readings
def test_only_a_random_course_draws(effect):
    values = values_of(effect)
    states = []
    for seed in (1, 2):
        chance = np.random.default_rng(seed)
        course = effect.series(RECORDED, values, chance)
        drawn = chance.bit_generator.state != np.random.default_rng(seed).bit_generator.state
        states.append((course, drawn))
    (one, drawn), (other, _) = states
    assert drawn == effect.is_random(values)
    assert np.array_equal(one, other) != effect.is_random(values)


@pytest.mark.parametrize("name", sorted(ON_READINGS))
def test_what_chance_draws_is_declared(name):
    assert BY_NAME[name].is_random(values_of(BY_NAME[name])) == (name in CHANCE)


@pytest.mark.parametrize("name", FORMULAS)
def test_its_course_is_that_of_its_formula(name):
    values, formula = FORMULAS[name]
    assert BY_NAME[name.partition(" ")[0]].series(RECORDED, values, rng()) == pytest.approx(
        np.asarray(formula), abs=1e-12
    )


@on_readings
def test_what_is_searched_is_what_is_simulated(effect):
    """One formula: the columns of a form, times coefficients, are the course of its parameters."""
    for shape in [form for form in effect.forms(RECORDED) if isinstance(form, Shape)]:
        coefficients = np.arange(1.0, shape.columns.shape[1] + 1)
        values = {**shape.parameters, **effect.linear.sizes(coefficients)}
        assert values.keys() == {p.name for p in effect.parameters}
        course = effect.series(RECORDED, values, rng())
        assert shape.columns @ coefficients == pytest.approx(course, abs=1e-12)
        again = effect.course(RECORDED, shape.parameters)
        assert (again is None) == (not effect.recurs)
        assert again is None or np.array_equal(again.columns, shape.columns)


@on_readings
def test_every_form_is_sound_and_within_the_limits_of_its_parameters(effect):
    known = {p.name: p for p in effect.parameters}
    forms = effect.forms(RECORDED)
    for form in forms:
        assert form.weight > 0
        if not isinstance(form, Chain):
            for name, value in form.parameters.items():
                p = known[name]
                assert isinstance(value, str) if p.text else p.above < value <= p.up_to
        match form:
            case Shape():
                assert len(form.columns) == 30
                assert np.all(np.isfinite(form.columns))
            case Process():
                assert form.covariance.shape == (30, 30)
                assert np.linalg.eigvalsh(form.covariance).min() > -1e-9
            case Spread():
                assert form.scale.shape == (30,)
                assert form.scale[0] == 1
                assert np.all(form.scale > 0)
            case Chain():
                assert 0 < form.leave_lower <= 1
                assert 0 < form.leave_upper <= 1


@on_readings
def test_forms_nearby_lie_between_those_of_the_grid(effect):
    shapes = [form for form in effect.forms(RECORDED) if isinstance(form, Shape)]
    for shape in shapes[1:-1]:
        for near in effect.near(RECORDED, shape.parameters):
            assert near.parameters.keys() == shape.parameters.keys()
            assert near.columns.shape == shape.columns.shape


@on_readings
def test_what_is_near_a_value_of_the_grid_is_about_it_and_between_its_neighbours(effect):
    for grid in [p.grid(RECORDED) for p in effect.parameters if p.grid and not p.text]:
        for below, value, above in zip(*(sorted(grid.values)[k:] for k in range(3)), strict=False):
            near = np.asarray(grid.near(value))
            if len(near):
                assert 0.99 * below <= near.min() <= value <= near.max() <= 1.01 * above


@on_readings
def test_what_takes_seconds_in_the_place_of_cycles_says_so(effect):
    for parameter in effect.parameters:
        assert parameter.timed == ("if time_s is there" in parameter.meaning)


@on_readings
def test_it_declares_the_columns_that_it_needs(effect):
    """Without them nothing is searched; with them, and no other, its course is the same."""
    if not effect.needs:
        assert effect.columns_needed(values_of(effect)) == ()
        return
    assert effect.forms(Conditions(J)) == ()
    values = values_of(effect)
    needed = effect.columns_needed(values)
    assert needed
    assert all(effect.takes(name) for name in needed)
    only = Conditions(J, {name: RECORDED.covariates[name] for name in needed})
    assert np.array_equal(
        effect.series(only, values, rng()), effect.series(RECORDED, values, rng())
    )


@pytest.mark.parametrize("name", sorted(ON_READINGS))
def test_without_its_column_it_searches_nothing(name):
    through = {"lost_motion", "temperature", "covariate", "compliance", "coast_in_gap"}
    searched = bool(BY_NAME[name].forms(Conditions(J)))
    assert searched == (name not in through | {"resolution"})


def test_a_load_that_varies_hides_a_gap_that_grows():
    side = np.resize([1.0, -1.0], 32)
    for payload, hidden in ((np.full(32, 2.0), False), (np.repeat([0.0, 4.0, 8.0, 16.0], 8), True)):
        conditions = Conditions(np.arange(32), {"approach": side, "payload_kg": payload})
        assert (BY_NAME["gap_growth"].forms(conditions) == ()) is hidden


@on_readings
def test_its_weights_are_positive_and_its_rivals_known(effect):
    assert effect.weight > 0
    assert effect.test_weight > 0
    assert effect.gain > 0
    assert effect.unsettled.keys() <= BY_NAME.keys()


def test_no_effect_is_named_outside_its_file():
    """Neither where it is looked for nor where it is spoken of: the code asks its contract."""
    package = Path(effects.__file__).parents[1]
    common = {"step", "gap", "resolution", "temperature", "covariate", "lost_motion", "compliance",
              "warm_up"}  # fmt: skip
    # words of other things too: figures of the push test, a line of a table's head
    words = {*ON_READINGS, *ON_THE_GEAR} - common
    pattern = re.compile("|".join(rf"[\"']{name}[\"']" for name in sorted(words)))
    for path in package.rglob("*.py"):
        if path.stem not in words:
            assert not pattern.findall(path.read_text(encoding="utf-8")), path


def test_contact_sides_are_two_levels_that_switch_as_often_as_stated():
    effect = BY_NAME["contact_side"]
    many = Conditions(np.arange(20_001))
    course = effect.series(many, {"size": 3.0, "switching": 0.2}, rng())
    assert set(course.tolist()) == {0.0, 3.0}
    assert np.mean(np.diff(course) != 0) == pytest.approx(0.2, abs=0.01)


def test_new_tests_have_their_own_sides_as_often_and_as_long():
    rng, sides = np.random.default_rng(1), BY_NAME["contact_side"]
    states = np.cumsum(rng.random(2000) < 0.1) % 2 * 1.0
    found = Shape(states[:, np.newaxis], {"switching": 0.1})
    drawn = sides.in_new_tests(found, np.arange(2000), 50, rng)[..., 0]
    assert drawn.shape == (50, 2000)
    assert np.abs(np.diff(drawn)).mean() == pytest.approx(0.1, abs=0.02)
    assert drawn.mean() == pytest.approx(states.mean(), abs=0.05)
    alternating = Shape(found.columns, {"switching": 1.0})
    assert (sides.in_new_tests(alternating, np.arange(9), 50, rng)[0] == found.columns).all()


@pytest.mark.parametrize(("accidents", "come"), [(1, 0.0), (3, 3.5 / 31 * 30)])
def test_one_accident_does_not_come_again_and_several_do(accidents, come):
    columns = np.eye(30)[:, :accidents]
    drawn = BY_NAME["outlier"].in_new_tests(
        Shape(columns, {"at_cycle": 1}), np.arange(30), 4000, np.random.default_rng(1)
    )
    assert drawn.sum(axis=(1, 2)).mean() == pytest.approx(come, abs=0.15)
    assert drawn.sum(axis=2).max() <= 1


def test_chance_has_the_size_that_is_stated():
    many = Conditions(np.arange(1, 20_001))
    walk = BY_NAME["random_walk"].series(many, {"size": 3.0}, rng())
    assert np.std(np.diff(walk)) == pytest.approx(3.0, rel=0.03)
    rounding = BY_NAME["resolution"].series(many, {"division": 3.0}, rng())
    assert np.std(rounding) == pytest.approx(3.0 / math.sqrt(12), rel=0.03)
    wider = BY_NAME["scatter_change"].series(
        many, {"at_cycle": 10_001.0, "ratio": 3.0, "scatter": 0.5}, rng()
    )
    assert not np.any(wider[:10_000])
    assert np.hypot(np.std(wider[10_000:]), 0.5) == pytest.approx(1.5, rel=0.03)


def first_order(innovations, *, memory):
    """Return innovations (n, m) through y_j = memory y_(j-1) + e_j."""
    course = innovations.copy()
    for j in range(1, len(course)):
        course[j] += memory * course[j - 1]
    return course


def test_a_random_course_is_searched_with_the_covariance_of_what_it_draws():
    """One formula, the filter: of memory a, covariance a^|i-j| (1 - a^2i) / (1 - a^2)."""
    effect = RandomCourse(
        name="memory",
        parameters=(
            Parameter("size", "s", "reading", "standard deviation of one innovation"),
            Parameter("memory", "a", "", "kept from cycle to cycle", grid=lambda _: MEMORIES),
        ),
        cause="what comes is like what was",
        confirm_by="wait longer between the cycles",
        filtered=first_order,
        variances=(0.5, 2.0),
    )
    forms = effect.forms(Conditions(J[:6]))
    assert [form.parameters["memory"] for form in forms] == [0.3, 0.3, 0.8, 0.8]
    i = np.arange(1, 7)
    for form, variance in zip(forms, (0.5, 2.0, 0.5, 2.0), strict=True):
        a = form.parameters["memory"]
        earlier = np.minimum.outer(i, i)
        expected = a ** np.abs(np.subtract.outer(i, i)) * (1 - a ** (2 * earlier)) / (1 - a**2)
        np.testing.assert_allclose(form.covariance, variance * expected)
    drawn = effect.series(Conditions(np.arange(20_000)), {"size": 2.0, "memory": 0.8}, rng())
    assert drawn.std() == pytest.approx(2 / math.sqrt(1 - 0.64), rel=0.05)
    assert np.corrcoef(drawn[1:], drawn[:-1])[0, 1] == pytest.approx(0.8, abs=0.02)


def test_time_is_in_cycles_whatever_the_clock():
    steady = Conditions(J, {"time_s": 100 + 12.5 * J})
    np.testing.assert_allclose(Conditions(J).time, steady.time)


def test_time_in_seconds_takes_the_place_of_cycles():
    clock = Conditions(J, {"time_s": np.where(J > 10, 60.0 * J + 600, 60.0 * J)})
    course = BY_NAME["warm_up"].series(clock, {"size": 1.0, "tau": 4.0}, rng())
    assert course[10] == pytest.approx(1 - math.exp(-20 / 4.0))


@pytest.mark.parametrize("name", ["speed_mm_s", "approach_angle", "payload_g", "humidity"])
def test_whatever_no_other_effect_acts_through_is_a_covariate(name):
    recorded = {name: HUMIDITY, "time_s": J * 1.0, "speed": SPEED, "Temperature_in": TEMPERATURE}
    members = hypotheses_of(find_effects(), Conditions(J, recorded))
    (found,) = [member.form for member in members if member.effect == "covariate"]
    assert found.parameters["column"] == name


@pytest.mark.parametrize(("ratio", "wider"), [(3.0, slice(12, 30)), (0.25, slice(0, 12))])
def test_scatter_is_added_on_the_wider_side_only(ratio, wider):
    values = {"at_cycle": 13.0, "ratio": ratio, "scatter": 0.5}
    added = BY_NAME["scatter_change"].series(RECORDED, values, rng())
    inside = np.zeros(30, dtype=bool)
    inside[wider] = True
    assert np.array_equal(added != 0, inside)


@on_the_gear
def test_a_gear_effect_changes_eq_16(effect):
    assert effect.changed(GEAR, **values_of(effect)).deviation.shape == (2,)
    assert effect.changed(GEAR, **values_of(effect)).I_L is GEAR.I_L
    for values in effect.candidates(GEAR):
        assert set(values) == {p.name for p in effect.parameters}
        assert all(p.above < values[p.name] <= p.up_to for p in effect.parameters)
        deviation = effect.changed(GEAR, **values).deviation
        assert deviation.shape == (2,)
        assert np.all(np.isfinite(deviation))
        assert np.all(deviation <= 0)


@pytest.mark.parametrize("name", sorted(ON_THE_GEAR))
def test_a_gear_effect_is_its_formula(name):
    values, formula = GEAR_FORMULAS[name]
    assert BY_NAME[name].changed(GEAR, **values).deviation == pytest.approx(formula, rel=1e-12)


def test_reflected_inertia_is_the_published_figure_seen_through_the_gearbox():
    paper = Sweep(np.array([2.65e-4]), np.array([4.749]), np.array([3.490659e-3]))
    deviation = BY_NAME["reflected_inertia"].changed(paper, N=50).deviation
    assert deviation[0] == pytest.approx(-4.27342e-4, rel=1e-5)


def test_gear_effects_reach_their_limits():
    far = BY_NAME["reflected_inertia"].changed(GEAR, N=1e6).deviation
    np.testing.assert_allclose(far, -GEAR.gap, rtol=1e-6)
    assert not np.any(BY_NAME["friction_hold"].changed(GEAR, held=1.0).deviation)
    free = BY_NAME["gap"].changed(GEAR, factor=1.0).deviation
    np.testing.assert_allclose(free, BY_NAME["wind_up"].changed(GEAR, compliance=0.0).deviation)


THIRD_PARTY = """
\"\"\"The moon pulls: as the square of the cycles since the first.\"\"\"

from scara_iso.effects import KnownCourse, Parameter, as_column

EFFECT = KnownCourse(
    name="moon_phase",
    parameters=(Parameter("size", "m", "reading", "pull"),),
    cause="the moon pulls at the robot",
    confirm_by="measure again after two weeks",
    weight=5.0,
    columns=lambda conditions: as_column((conditions.elapsed / 29) ** 6),
)
"""
PULL = ((J - 1) / 29) ** 6


@pytest.fixture
def moon(tmp_path, monkeypatch):
    """Return the effect of a package that was never heard of."""
    (tmp_path / "lunar.py").write_text(THIRD_PARTY, encoding="utf-8")
    declared = tmp_path / "lunar-1.0.dist-info"
    declared.mkdir()
    (declared / "METADATA").write_text("Metadata-Version: 2.1\nName: lunar\nVersion: 1.0\n")
    (declared / "entry_points.txt").write_text("[scara_iso.effects]\nmoon = lunar\n")
    monkeypatch.syspath_prepend(tmp_path)
    effects._catalogue.cache_clear()
    yield next(e for e in find_effects() if e.name == "moon_phase")
    effects._catalogue.cache_clear()
    sys.modules.pop("lunar", None)


def test_an_effect_of_a_third_party_keeps_the_contract(moon):
    assert isinstance(moon, Effect)
    assert not isinstance(moon, GearEffect)
    for contract in (
        test_it_says_what_it_is,
        test_its_course_is_pure_finite_and_in_proportion_to_its_size,
        test_only_a_random_course_draws,
        test_what_is_searched_is_what_is_simulated,
        test_every_form_is_sound_and_within_the_limits_of_its_parameters,
        test_it_declares_the_columns_that_it_needs,
        test_its_weights_are_positive_and_its_rivals_known,
    ):
        contract(moon)


@pytest.mark.usefixtures("moon")
def test_an_effect_of_a_third_party_is_met_by_all(tmp_path, capsys):
    readings = 0.5 * PULL + 0.02 * rng().normal(size=30)
    found = diagnose(Run(J, {"X": Axis("X", readings)}))
    assert found.effects[0].effect == "moon_phase"
    assert found.effects[0].parameters["size"]["X"] == pytest.approx(0.5, abs=0.05)
    said = repr(diagnosis_report(found))
    assert "the moon pulls at the robot" in said
    assert find_pages("moon-phase")[0].title.startswith("The moon pulls")
    model = tmp_path / "m.toml"
    model.write_text("[indicator.X]\n[[effect]]\nname='moon_phase'\nsize={X=0.5}\n")
    expected = predict(read_model(model), Conditions(J)).axes["X"].readings
    assert expected == pytest.approx(0.5 * PULL)
    model.write_text("[indicator.X]\n")
    effect = ["--effect", "moon_phase:size=0.5", "--cycles", "30"]
    assert main(["simulate", str(model), *effect, "--json"]) == 0
    simulated = json.loads(capsys.readouterr().out)["axes"]["X"]["readings"]
    assert simulated == pytest.approx(0.5 * PULL, abs=1e-6)


OWN = """
[[effect]]
name = "own"
formula = "size * (humidity - dry) * exp(-k / life) * (k > 3)"
parameters = { dry = { value = 40, unit = "humidity" }, life = { from = 2, to = 20 } }
"""


def test_an_effect_of_a_users_file_keeps_the_contract():
    faults = KeyFaults()
    (own,) = own_effects(tomllib.loads(OWN)["effect"], "effect", (), faults)
    assert faults == []
    for contract in (
        test_it_says_what_it_is,
        test_its_course_is_pure_finite_and_in_proportion_to_its_size,
        test_only_a_random_course_draws,
        test_what_is_searched_is_what_is_simulated,
        test_every_form_is_sound_and_within_the_limits_of_its_parameters,
        test_forms_nearby_lie_between_those_of_the_grid,
        test_it_declares_the_columns_that_it_needs,
        test_its_weights_are_positive_and_its_rivals_known,
    ):
        contract(own)
    catalogue = hypotheses_of(find_effects(), RECORDED)
    beside = hypotheses_of(find_effects([own]), RECORDED)
    assert [m.effect for m in catalogue] == [m.effect for m in beside if m.effect != "own"]
