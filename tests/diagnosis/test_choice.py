"""The choice of a name on small cases, against marginal likelihoods worked out another way."""

import numpy as np
import pytest

from scara_iso.diagnosis.engine.evidence import (
    AMPLITUDES,
    SHARES,
    Remainder,
    build,
    constant,
    views_of,
)
from scara_iso.diagnosis.engine.hypotheses import Hypothesis
from scara_iso.diagnosis.engine.naming import Weighed, choose, two_states
from scara_iso.diagnosis.engine.rounded import MISFIT
from scara_iso.diagnosis.engine.two_levels import two_levels
from scara_iso.diagnosis.verdict import Choice, posterior
from scara_iso.effects import Chain, Process, Shape

N = 16
ROWS = np.arange(N)
RAMP = Shape(np.arange(N, dtype=float)[:, None])
STEP = Shape(np.where(np.arange(N) >= 6, 1.0, 0.0)[:, None])
LATE = Shape(np.where(np.arange(N) >= 11, 1.0, 0.0)[:, None])
WAVE = Process(np.exp(-np.abs(np.subtract.outer(np.arange(N), np.arange(N))) / 2))
MEMBERS = [
    Hypothesis("drift", RAMP, 0.5),
    Hypothesis("step", STEP, 0.2),
    Hypothesis("step", LATE, 0.3),
    Hypothesis("wave", WAVE, 0.7),
]
BLOCKS = np.arange(24) // 4 % 2
STICKY, BRISK = Chain(0.1, 0.1), Chain(0.3, 0.2)


def covariance_of(form, gain=15.0):
    """Return the covariance of the readings beside their scatter, the pose taken away."""
    centre = np.eye(N) - 1 / N
    if isinstance(form, Process):
        return centre @ form.covariance @ centre
    course = centre @ form.columns[:, 0]
    return gain * np.outer(course, course) / (course @ course)


def bayes(y, covariance, misfit=0.0):
    """Return |C|^(-1/2) (y' C^-1 y / y'y)^(-(n-1)/2) of centred y; the share has a least."""
    whole = np.eye(len(y)) + covariance
    power = y @ np.linalg.solve(whole, y) / (y @ y)
    power += misfit**2 * (1 - power)
    return np.linalg.det(whole) ** -0.5 * power ** (-(len(y) - 1) / 2)


@pytest.fixture
def wandering(rng):
    y = np.cumsum(rng.normal(size=N))
    return y - y.mean()


def chosen(y, beside=(), members=MEMBERS):
    return choose(build(members, ROWS, constant(N)), views_of(y[:, None], constant(N)), beside)


def test_the_posterior_is_the_share_of_the_evidence():
    assert posterior(dict(zip("ab", np.log([8.0, 2.0]), strict=True))) == pytest.approx(
        {"a": 0.8, "b": 0.2}
    )
    assert posterior({"a": 3000.0, "b": 0.0}) == {"a": 1.0, "b": 0.0}


def test_rivals_are_at_least_a_tenth_as_likely_as_the_best():
    probability = {"e": 0.04, "d": 0.05, "best": 0.5, "b": 0.3, "c": 0.11}
    choice = Choice(probability, {})
    assert choice.best == "best"
    assert [rival.effect for rival in choice.ranked] == ["best", "b", "c", "d", "e"]
    assert [rival.probability for rival in choice.ranked] == [0.5, 0.3, 0.11, 0.05, 0.04]
    assert [rival.effect for rival in choice.rivals] == ["b", "c", "d"]


def evidence_by_hand(y):
    """Return {effect: evidence}, and {(member, amplitude): evidence}."""
    each = {
        (i, factor): share * member.weight * bayes(y, factor * covariance_of(member.form), MISFIT)
        for i, member in enumerate(MEMBERS)
        for factor, share in zip(AMPLITUDES, SHARES, strict=True)
    }
    total = dict.fromkeys([member.effect for member in MEMBERS], 0.0)
    for (i, _), evidence in each.items():
        total[MEMBERS[i].effect] += evidence
    return total, each


def test_the_choice_sums_each_effect_over_its_forms_and_amplitudes(wandering):
    total, _ = evidence_by_hand(wandering)
    expected = {name: value / sum(total.values()) for name, value in total.items()}
    assert chosen(wandering).probability == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("size", [0.3, 1.0, 3.0, 30.0])
def test_each_effect_has_the_form_and_amplitude_of_its_largest_evidence(rng, size):
    y = np.cumsum(rng.normal(size=N)) * size + rng.normal(size=N)
    y = y - y.mean()
    _, each = evidence_by_hand(y)
    choice = chosen(y)
    i, _ = max((key for key in each if key[0] in (1, 2)), key=each.__getitem__)
    assert choice.forms["step"] is MEMBERS[i].form
    _, factor = max((key for key in each if key[0] == 3), key=each.__getitem__)
    wave = choice.forms["wave"]
    np.testing.assert_allclose(wave.covariance, factor * WAVE.covariance)
    assert wave.variance == pytest.approx(factor * WAVE.variance)


def test_what_was_found_beside_adds_to_its_effect(wandering):
    total, each = evidence_by_hand(wandering)
    strongest = max(value for (i, _), value in each.items() if i in (1, 2))
    weak, strong = (
        Weighed("step", Shape(np.ones((N, 1))), np.log(factor * strongest)) for factor in (0.5, 2)
    )
    for beside, form in ((weak, None), (strong, strong.form)):
        choice = chosen(wandering, [beside])
        odds = (total["step"] + np.exp(beside.log_evidence)) / total["drift"]
        found = choice.probability["step"] / choice.probability["drift"]
        assert found == pytest.approx(odds, rel=1e-3)
        assert (choice.forms["step"] is form) == (form is not None)


def test_an_effect_that_only_was_found_beside_takes_the_first_of_its_strongest_forms(wandering):
    total, _ = evidence_by_hand(wandering)
    forms = [Shape(np.full((N, 1), float(k))) for k in range(3)]
    beside = [Weighed("sides", f, np.log(e)) for f, e in zip(forms, (0.5, 2.0, 2.0), strict=True)]
    choice = chosen(wandering, [*beside, Weighed("never", forms[0], -np.inf)])
    assert choice.forms["sides"] is forms[1]
    found = choice.probability["sides"] / choice.probability["drift"]
    assert found == pytest.approx(4.5 / total["drift"], rel=1e-3)
    assert "never" not in choice.probability
    assert sum(choice.probability.values()) == pytest.approx(1.0)


def sides(rng, apart):
    y = rng.normal(size=(24, len(apart))) + BLOCKS[:, None] * np.array(apart)
    return y - y.mean(axis=0)


def left_in(views, members, division, rows=None, cycles=24):
    """Return what is left with these views, of all cycles unless ``rows`` are given."""
    rows = np.arange(cycles) if rows is None else rows
    values = views.columns[:, : views.axes]
    basis, half, known = constant(len(rows)), 0 * values, np.zeros(views.axes)
    division = np.full(views.axes, division)
    return Remainder(rows, cycles, basis, values, half, known, division, views, tuple(members))


def members_of(chains):
    shape = Shape(np.arange(24.0)[:, None])
    ramp = Hypothesis("drift", shape, 9.0)
    return [ramp, *(Hypothesis(name, chain, weight) for name, chain, weight in chains)]


CHAINS = members_of([("sides", STICKY, 0.2), ("other", BRISK, 0.3), ("sides", BRISK, 0.1)])


def test_on_one_axis_the_states_weigh_what_their_chains_do(rng):
    y = sides(rng, [5.0])
    views = views_of(y, constant(24))
    both, other = two_states(left_in(views, CHAINS, 0.0))
    assert (both.effect, other.effect) == ("sides", "other")
    levels = two_levels(views.columns[:, 0], 0.0, [STICKY, BRISK])
    sticky, brisk = np.exp(levels.log_bf)
    assert np.exp(both.log_evidence) == pytest.approx(0.2 * sticky + 0.1 * brisk)
    assert np.exp(other.log_evidence) == pytest.approx(0.3 * brisk)
    np.testing.assert_array_equal(both.form.columns, BLOCKS[:, None])
    assert both.form.parameters == {"switching": levels.switching}


def test_no_states_are_sought_without_chains_or_on_a_dial_that_shows_none(rng):
    views = views_of(sides(rng, [5.0]), constant(24))
    assert two_states(left_in(views, CHAINS[:1], 0.0)) == []
    assert two_states(left_in(views, CHAINS, np.nan)) == []
    assert two_states(left_in(views, CHAINS, 9.0)) == []


def test_states_bridge_the_cycles_that_are_not_seen(rng):
    y = sides(rng, [8.0])
    rows = np.delete(np.arange(24), [5, 14])
    views = views_of(y[rows], constant(len(rows)))
    found, _ = two_states(left_in(views, CHAINS, 0.0, rows))
    np.testing.assert_array_equal(found.form.columns, BLOCKS[:, None])
    whole = np.full(24, np.nan)
    whole[rows] = views.columns[:, 0]
    levels = two_levels(whole, 0.0, [STICKY, BRISK])
    assert np.exp(found.log_evidence) == pytest.approx(np.exp(levels.log_bf) @ [0.2, 0.1])


def test_a_known_scatter_counts_in_the_states(rng):
    y = sides(rng, [3.0])
    views = views_of(y, constant(24), sigma=np.array([0.8]))
    found, _ = two_states(left_in(views, CHAINS, 0.0))
    known = float(views.known[0])
    levels = two_levels(views.columns[:, 0], 0.0, [STICKY, BRISK], known=known)
    assert np.exp(found.log_evidence) == pytest.approx(np.exp(levels.log_bf) @ [0.2, 0.1])
    free = two_levels(views.columns[:, 0], 0.0, [STICKY, BRISK])
    assert abs(free.log_bf[0] - levels.log_bf[0]) > 0.1


@pytest.mark.parametrize("apart", [(6.0, 0.0), (0.5, 5.0), (4.0, -4.0)])
def test_over_two_axes_the_course_counts_in_each_as_a_shape(rng, apart):
    """The evidence in the best column, times what all axes say of the course found there."""
    y = sides(rng, apart)
    views = views_of(y, constant(24))
    found, _ = two_states(left_in(views, CHAINS, 0.0))
    axes = views.columns
    widest = axes @ np.linalg.eigh(axes.T @ axes)[1][:, -1]
    columns = [*axes.T, widest / np.linalg.norm(widest)]
    alone = [two_levels(column, 0.0, [STICKY, BRISK]) for column in columns]
    evidence = [float(np.exp(levels.log_bf) @ [0.2, 0.1]) / 3 for levels in alone]
    best = int(np.argmax(evidence))
    course = np.where(alone[best].share_upper > 0.5, 1.0, 0.0)
    np.testing.assert_array_equal(found.form.columns[:, 0], course)
    unit = course - course.mean()
    unit /= np.linalg.norm(unit)
    bf = [bayes(column, 15 * np.outer(unit, unit)) for column in columns]
    together = (1 + bf[0]) * (1 + bf[1]) / 4
    expected = evidence[best] * together / bf[best]
    assert np.exp(found.log_evidence) == pytest.approx(expected, rel=1e-6)


def test_very_long_runs_stay_finite():
    y = 1e-6 * np.sin(np.arange(480.0)) + 100.0 * (np.arange(480) // 8 % 2)
    views = views_of(y[:, None], constant(480))
    (found, _) = two_states(left_in(views, CHAINS[1:3], 0.0, cycles=480))
    assert np.isfinite(found.log_evidence)
