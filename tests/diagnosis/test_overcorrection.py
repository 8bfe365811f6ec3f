"""Readings of which each deviation is taken back in the next, and what random courses amount to."""

import numpy as np
import pytest

from scara_iso.diagnosis.engine.fit import fit, problem_of
from scara_iso.diagnosis.engine.search import chosen, find
from scara_iso.diagnosis.held_out import scatter_draws
from scara_iso.diagnosis.readings import diagnose_readings
from scara_iso.effects import Conditions, find_effects
from scara_iso.iso9283 import repeatability
from scara_iso.run import Axis, Run

EFFECT = {effect.name: effect for effect in find_effects()}["overcorrection"]


def run_of(y):
    return Run(np.arange(2, len(y) + 2), {"X": Axis("X", np.round(y), resolution=1.0)})


def corrected(rng, share, n):
    """Return readings of scatter 3 by the rule: what each shows is taken off before the next."""
    readings, at = [], 0.0
    for scatter in 3 * rng.normal(size=n + 30):
        readings.append(at + scatter)
        at -= share * readings[-1]
    return np.array(readings[30:])


def choice_of(y):
    problem = problem_of(run_of(y), directions={}, effects=find_effects())
    return chosen(problem, (), np.random.default_rng(1))[0].choice


@pytest.mark.parametrize("share", [0.7, 1.0, 1.4, 1.7])
def test_it_is_searched_as_the_rule_makes_it(share):
    forms = EFFECT.forms(Conditions(np.arange(200)))
    form = next(one for one in forms if one.parameters["share"] == share)
    memory = [form.unit[150, 150 - lag] for lag in range(4)]
    expected = [1.0, *(-share / 2 * (1 - share) ** lag for lag in range(3))]
    assert memory == pytest.approx(expected, abs=1e-9)
    drawn = EFFECT.series(
        Conditions(np.arange(20_000)), {"share": share, "size": 2.0}, np.random.default_rng(2)
    )
    assert drawn.std() == pytest.approx(2.0, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("share", [1.0, 1.4])
def test_what_takes_each_deviation_back_is_named(share):
    for seed in range(4):
        choice = choice_of(corrected(np.random.default_rng([seed, 6]), share, 60))
        assert choice.best == "overcorrection"
        assert choice.probability["contact_side"] < 0.1


def test_sides_that_alternate_are_no_overcorrection():
    for seed in range(4):
        scatter = 3 * np.random.default_rng(seed).normal(size=30)
        choice = choice_of(6 * (np.arange(30) % 2) + scatter)
        assert choice.best == "contact_side"


def test_sides_that_mostly_alternate_are_no_overcorrection():
    for seed in range(6):
        rng = np.random.default_rng(seed)
        sides = np.cumsum(rng.random(30) < 0.9) % 2
        choice = choice_of(15 * sides + 3 * rng.normal(size=30))
        assert choice.best == "contact_side"


@pytest.mark.slow
def test_readings_that_nobody_corrects_repeat_better_by_as_much_as_theory_says():
    left, shares = [], []
    for seed in range(3):
        y = corrected(np.random.default_rng(seed), 1.0, 60)
        found = diagnose_readings(run_of(y))
        (effect,), said = found.effects, found.repeatability
        assert effect.effect == "overcorrection"
        assert effect.parameters["size"]["X"] == pytest.approx(y.std(), rel=0.15)
        left.append(said.with_effect_removed["X"] / said.measured["X"])
        shares.append(found.shares["X"].effects)
    assert np.mean(left) == pytest.approx(0.5**0.5, rel=0.1)
    assert np.mean(shares) == pytest.approx(0.5, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["overcorrection", "random_walk"])
def test_a_random_course_is_of_the_axes_that_show_it(name):
    alone = 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        steps = corrected(rng, 1.0, 40)
        moved = np.cumsum(3 * rng.normal(size=40)) if name == "random_walk" else steps
        other = np.round(4 * rng.normal(size=40))
        axes = {"X": np.round(moved + rng.normal(size=40)), "Z": other}
        run = Run(np.arange(2, 42), {n: Axis(n, y, resolution=1.0) for n, y in axes.items()})
        problem = problem_of(run, directions={}, effects=find_effects())
        terms = find(problem, np.random.default_rng(1))[0]
        if [term.effect for term in terms] == [name] and not terms[0].moves[1]:
            alone += 1
            fitted = fit(terms, problem.residual.values, problem.rows, 40)
            assert np.ptp(fitted.predicted[:, 1]) == pytest.approx(0, abs=1e-9)
            scatter = scatter_draws(problem.residual, fitted, rng)
            assert np.median(scatter[:, 1]) == pytest.approx(other.std(ddof=1), rel=0.1)
            assert np.median(scatter[:, 0]) < 0.8 * axes["X"].std(ddof=1)
    assert alone >= 3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "filtered"),
    [
        ("random_walk", lambda rng: 3 * np.cumsum(rng.normal(size=60))),
        ("overcorrection", lambda rng: corrected(rng, 1.0, 60)),
    ],
)
def test_the_next_test_of_a_random_course_is_foretold(name, filtered):
    """What a random course leaves of readings is narrower than the scatter that made them."""
    held = named = 0
    for seed in range(5):
        rng = np.random.default_rng([seed, 5])
        found = diagnose_readings(run_of(filtered(rng) + rng.normal(size=60)))
        if [one.effect for one in found.effects] != [name]:
            continue
        named += 1
        told = found.repeatability.completed["X"]
        then = np.round(filtered(rng) + rng.normal(size=60))
        held += told.interval[0] <= float(repeatability(then[np.newaxis]).RP) <= told.interval[1]
    assert named >= 3
    assert held >= named - 1
