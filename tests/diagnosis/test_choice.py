"""The choice of a name on small cases, against marginal likelihoods worked out another way."""

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

from scara_iso.diagnosis.likelihood.evidence import Views, joint_evidence, views_of
from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis
from scara_iso.diagnosis.likelihood.hypothesis_set import build, constant
from scara_iso.diagnosis.likelihood.two_state import between_levels
from scara_iso.diagnosis.naming import choice as module
from scara_iso.diagnosis.naming.choice import (
    Choice,
    Weighed,
    as_often_right,
    beside_near_rivals,
    choose,
    posterior,
    two_states,
)
from scara_iso.diagnosis.tuning import AMPLITUDES, RIVAL, SHARPNESS, UNDECIDED, UNKNOWN, UNSURE
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


def bayes(y, covariance):
    """Return |C|^(-1/2) (y' C^-1 y / y'y)^(-(n-1)/2) of centred y."""
    whole = np.eye(len(y)) + covariance
    power = y @ np.linalg.solve(whole, y) / (y @ y)
    return np.linalg.det(whole) ** -0.5 * power ** (-(len(y) - 1) / 2)


@pytest.fixture
def wandering(rng):
    y = np.cumsum(rng.normal(size=N))
    return y - y.mean()


def chosen(y, beside=(), members=MEMBERS):
    return choose(build(members, ROWS, constant(N)), views_of(y[:, None], constant(N)), beside)


def test_the_posterior_is_the_share_of_the_sharpened_evidence():
    assert posterior({"a": 8.0, "b": 2.0}) == pytest.approx({"a": 0.8, "b": 0.2})
    assert posterior({"a": 8.0, "b": 2.0}, 2.0) == pytest.approx({"a": 16 / 17, "b": 1 / 17})
    huge = posterior({"a": 1e300, "b": 2e300, "c": 1e300}, 3.0)
    assert huge == pytest.approx({"a": 0.1, "b": 0.8, "c": 0.1})


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
        (i, factor): share * member.weight * bayes(y, factor * covariance_of(member.form))
        for i, member in enumerate(MEMBERS)
        for factor, share in AMPLITUDES
    }
    total = dict.fromkeys([member.effect for member in MEMBERS], 0.0)
    for (i, _), evidence in each.items():
        total[MEMBERS[i].effect] += evidence
    return total, each


def test_the_choice_sums_each_effect_over_its_forms_and_amplitudes(wandering):
    total, _ = evidence_by_hand(wandering)
    sharp = {name: evidence**SHARPNESS for name, evidence in total.items()}
    expected = {name: value / sum(sharp.values()) for name, value in sharp.items()}
    assert chosen(wandering).probability == pytest.approx(expected, rel=1e-3)


@given(
    st.floats(0, 1),
    st.dictionaries(st.sampled_from("bcd"), st.floats(0.001, 1), min_size=1),
    st.dictionaries(st.sampled_from(["b", "c", "d", "e", UNKNOWN]), st.floats(-20, 4), min_size=1),
)
def test_no_name_stands_alone_while_another_effect_is_near(best, others, near):
    whole = sum(others.values()) / (0.2 + best / 5)
    before = {"a": 1 - sum(others.values()) / whole} | {n: p / whole for n, p in others.items()}
    assume(max(before, key=before.get) == "a")
    after = beside_near_rivals(before, near)
    assert sum(after.values()) == pytest.approx(1)
    assert after["a"] < 0.9
    ahead = near.get(UNKNOWN, 0.0) < 0
    most = UNDECIDED if ahead else UNSURE
    assert after["a"] <= most
    assert max(after, key=after.get) == "a"
    if before["a"] > most:
        nearest = min(near, key=near.get)
        rival, least = (UNKNOWN, 2 / 3) if ahead else (nearest, RIVAL)
        assert nearest in {rival.effect for rival in Choice(after, {}).rivals} or ahead
        assert after[rival] >= least * after["a"] * (1 - 1e-12)
    else:
        assert after == before


@pytest.mark.parametrize(
    ("near", "said"), [({UNKNOWN: -0.1}, UNDECIDED), ({UNKNOWN: 0.1}, 0.85), ({"b": -5.0}, 0.85)]
)
def test_a_name_that_no_name_is_ahead_of_is_undecided(near, said):
    choice = Choice({"a": 0.85, UNKNOWN: 0.15}, {}, near=lambda _: near)
    assert choice.probability["a"] == pytest.approx(said)


def test_a_name_that_is_undecided_already_asks_for_no_rival():
    choice = Choice({"a": 0.5, "b": 0.3, "c": 0.2}, {}, near=pytest.fail)
    assert choice.probability["a"] < UNDECIDED


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
    assert wave.amplitude == pytest.approx(np.sqrt(factor))


def test_what_was_found_beside_adds_to_its_effect(wandering):
    total, each = evidence_by_hand(wandering)
    strongest = max(value for (i, _), value in each.items() if i in (1, 2))
    weak, strong = (
        Weighed("step", Shape(np.ones((N, 1))), factor * strongest) for factor in (0.5, 2)
    )
    for beside, form in ((weak, None), (strong, strong.form)):
        choice = chosen(wandering, [beside])
        odds = (total["step"] + beside.evidence) / total["drift"]
        found = choice.probability["step"] / choice.probability["drift"]
        assert found == pytest.approx(odds**SHARPNESS, rel=1e-3)
        assert (choice.forms["step"] is form) == (form is not None)


def test_an_effect_that_only_was_found_beside_takes_the_first_of_its_strongest_forms(wandering):
    total, _ = evidence_by_hand(wandering)
    forms = [Shape(np.full((N, 1), float(k))) for k in range(3)]
    beside = [Weighed("sides", f, e) for f, e in zip(forms, (0.5, 2.0, 2.0), strict=True)]
    choice = chosen(wandering, [*beside, Weighed("never", forms[0], 0.0)])
    assert choice.forms["sides"] is forms[1]
    found = choice.probability["sides"] / choice.probability["drift"]
    assert found == pytest.approx((4.5 / total["drift"]) ** SHARPNESS, rel=1e-3)
    assert "never" not in choice.probability
    assert sum(choice.probability.values()) == pytest.approx(1.0)


def test_states_are_sought_where_they_can_show(rng):
    y = np.column_stack([rng.normal(size=24), rng.normal(size=24), 1e-9 * rng.normal(size=24)])
    columns = np.column_stack([y, y[:, 0], np.zeros(24), y[:, 1], y])
    views = Views(columns, 3)
    find = module._columns
    assert find(views, np.array([0.1, 0.2, 0.3])) == [(0, 0.1), (1, 0.2), (3, 0.0), (5, 0.0)]
    assert find(views, np.array([np.nan, 0.2, 0.3])) == [(1, 0.2)]
    assert find(views, np.array([np.nan, 0.2, 0.0])) == [(1, 0.2), (2, 0.0), (3, 0.0), (5, 0.0)]
    assert find(views, np.full(3, np.nan)) == []
    three = Views(np.concatenate([y * [1, 1, 1e9]] * 3, axis=1), 3)
    every = [(0, 0.1), (1, 0.2), (2, 0.3), (3, 0.0), (4, 0.0), (5, 0.0)]
    assert find(three, np.array([0.1, 0.2, 0.3])) == every


def sides(rng, apart):
    y = rng.normal(size=(24, len(apart))) + BLOCKS[:, None] * np.array(apart)
    return y - y.mean(axis=0)


def members_of(chains):
    shape = Shape(np.arange(24.0)[:, None])
    ramp = Hypothesis("drift", shape, 9.0)
    return [ramp, *(Hypothesis(name, chain, weight) for name, chain, weight in chains)]


CHAINS = members_of([("sides", STICKY, 0.2), ("other", BRISK, 0.3), ("sides", BRISK, 0.1)])


def test_on_one_axis_the_states_weigh_what_their_chains_do(rng):
    y = sides(rng, [5.0])
    views = views_of(y, constant(24))
    both, other = two_states(
        CHAINS, views, constant(24), division=np.zeros(1), rows=np.arange(24), n=24
    )
    assert (both.effect, other.effect) == ("sides", "other")
    levels = between_levels(views.columns[:, 0], 0.0).under([STICKY, BRISK])
    sticky, brisk = np.exp(levels.log_bf)
    assert both.evidence == pytest.approx(0.2 * sticky + 0.1 * brisk)
    assert other.evidence == pytest.approx(0.3 * brisk)
    np.testing.assert_array_equal(both.form.columns, BLOCKS[:, None])
    assert both.form.parameters == {"switching": levels.switching}


def test_no_states_are_sought_without_chains_or_on_a_dial_that_shows_none(rng):
    views = views_of(sides(rng, [5.0]), constant(24))
    given = {"rows": np.arange(24), "n": 24}
    assert two_states(CHAINS[:1], views, constant(24), division=np.zeros(1), **given) == []
    assert two_states(CHAINS, views, constant(24), division=np.full(1, np.nan), **given) == []
    assert two_states(CHAINS, views, constant(24), division=np.full(1, 9.0), **given) == []


def test_states_bridge_the_cycles_that_are_not_seen(rng):
    y = sides(rng, [8.0])
    rows = np.delete(np.arange(24), [5, 14])
    basis = constant(len(rows))
    views = views_of(y[rows], basis)
    found, _ = two_states(CHAINS, views, basis, division=np.zeros(1), rows=rows, n=24)
    np.testing.assert_array_equal(found.form.columns, BLOCKS[:, None])
    whole = np.full(24, np.nan)
    whole[rows] = views.columns[:, 0]
    levels = between_levels(whole, 0.0).under([STICKY, BRISK])
    assert found.evidence == pytest.approx(np.exp(levels.log_bf) @ [0.2, 0.1])


def test_a_known_scatter_counts_in_the_states(rng):
    y = sides(rng, [3.0])
    views = views_of(y, constant(24), sigma=np.array([0.8]))
    found, _ = two_states(
        CHAINS, views, constant(24), division=np.zeros(1), rows=np.arange(24), n=24
    )
    known = float(views.known[0])
    levels = between_levels(views.columns[:, 0], 0.0, known=known).under([STICKY, BRISK])
    assert found.evidence == pytest.approx(np.exp(levels.log_bf) @ [0.2, 0.1])
    free = between_levels(views.columns[:, 0], 0.0).under([STICKY, BRISK])
    assert abs(free.log_bf[0] - levels.log_bf[0]) > 0.1


@pytest.mark.parametrize("apart", [(6.0, 0.0), (0.5, 5.0), (4.0, -4.0)])
def test_over_two_axes_the_course_counts_in_each_as_a_shape(rng, apart):
    """The evidence in the best column, times what the other views say of the course found there."""
    y = sides(rng, apart)
    views = views_of(y, constant(24))
    found, _ = two_states(
        CHAINS, views, constant(24), division=np.zeros(2), rows=np.arange(24), n=24
    )
    alone = [between_levels(views.columns[:, c], 0.0).under([STICKY, BRISK]) for c in range(4)]
    evidence = [float(np.exp(levels.log_bf) @ [0.2, 0.1]) / 4 for levels in alone]
    best = int(np.argmax(evidence))
    course = np.where(alone[best].share_upper > 0.5, 1.0, 0.0)
    np.testing.assert_array_equal(found.form.columns[:, 0], course)
    unit = course - course.mean()
    unit /= np.linalg.norm(unit)
    bf = [bayes(column, 15 * np.outer(unit, unit)) for column in views.columns.T]
    together = ((1 + bf[0]) * (1 + bf[1]) / 4 + (bf[2] + bf[3]) / 2 + (bf[4] + bf[5]) / 2) / 3
    assert found.evidence == pytest.approx(evidence[best] * together / bf[best], rel=1e-6)


def test_very_long_runs_stay_finite():
    y = 1e-6 * np.sin(np.arange(480.0)) + 100.0 * (np.arange(480) // 8 % 2)
    views = views_of(y[:, None], constant(480))
    (found, _) = two_states(
        CHAINS[1:3], views, constant(480), division=np.zeros(1), rows=np.arange(480), n=480
    )
    assert 0 < found.evidence < np.inf


def test_joint_evidence_of_one_axis_two_and_named_directions():
    one = joint_evidence(np.log([[[3.0]]]), Views(np.zeros((N, 1)), 1))
    assert one.item() == pytest.approx(3.0)
    bf = np.array([3.0, 5.0, 2.0, 8.0, 4.0, 10.0])
    free = ((4 / 2) * (6 / 2) + 5.0 + 7.0) / 3
    two = joint_evidence(np.log(bf)[None, :, None], Views(np.zeros((N, 6)), 2))
    assert two.item() == pytest.approx(free)
    named = Views(np.zeros((N, 8)), 2, ("a", "b"))
    both = joint_evidence(np.log([*bf, 9.0, 21.0])[None, :, None], named)
    assert both.item() == pytest.approx((free + 15.0) / 2)
    cut = joint_evidence(np.full((1, 6, 1), 5000.0), Views(np.zeros((N, 6)), 2))
    assert cut.item() == pytest.approx(((np.exp(300.0) / 2) ** 2) / 3, rel=1e-6)


@pytest.mark.parametrize("kind", [Choice, Weighed])
def test_a_result_never_changes_and_is_compared_as_one_object(kind):
    assert kind.__dataclass_params__.frozen
    assert kind.__eq__ is object.__eq__
    assert kind is Choice or "__slots__" in vars(kind)  # it keeps what it has sought


@given(st.lists(st.floats(0.001, 1.0), min_size=2, max_size=6))
def test_a_name_is_raised_to_what_was_right_and_keeps_its_place(shares):
    whole = sum(shares)
    given_ = {str(i): share / whole for i, share in enumerate(shares)}
    said = as_often_right(given_)
    assert sum(said.values()) == pytest.approx(1)
    assert all(said[name] >= 0 for name in given_)
    best = max(given_, key=given_.__getitem__)
    assert max(said, key=said.__getitem__) == best
    assert said[best] >= given_[best] - 1e-12
    others = sorted(given_.keys() - {best}, key=given_.__getitem__)
    assert others == sorted(others, key=said.__getitem__)


@pytest.mark.parametrize("sure", [0.8, 0.89, 0.9, 0.999])
def test_what_is_likely_is_said_as_it_is(sure):
    said = as_often_right({"a": sure, "b": 1 - sure})
    assert said["a"] == pytest.approx(sure)


def test_two_thirds_right_is_said_so():
    assert as_often_right({"a": 0.6, "b": 0.4})["a"] == pytest.approx(0.68)


def test_what_was_a_rival_stays_one_when_the_name_is_raised():
    posterior = {"a": 0.6, "b": 0.338, "c": 0.062}
    choice = Choice(posterior, {}, near=lambda _: {})
    assert choice.probability["a"] == pytest.approx(0.68)
    assert [rival.effect for rival in choice.rivals] == ["b", "c"]
