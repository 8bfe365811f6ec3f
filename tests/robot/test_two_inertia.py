"""The two-inertia model: the paper's figures, its invariants, its limits, and what it refuses."""

import math
from dataclasses import FrozenInstanceError
from fractions import Fraction

import pytest
from hypothesis import assume, given, strategies as st

from scara_iso.base.errors import UsageError
from scara_iso.robot.two_inertia import backlash

PAPER = {"Im": 2.65e-4, "IL": 4.749, "arcmin": 12, "arm": 0.7}
ratios = st.none() | st.floats(0.01, 1e4)
inertias = st.floats(1e-9, 1e9)


@st.composite
def gears(draw):
    return backlash(
        Im=draw(inertias),
        IL=draw(inertias),
        arcmin=draw(st.floats(1e-6, 1e4)),
        arm=draw(st.floats(1e-6, 10)),
        ratio=draw(ratios),
    )


def crossings(gear):
    return [c for c in (gear.as_given, gear.reflected) if c is not None]


def test_the_paper_first_joint_recomputed():
    gear = backlash(**PAPER)
    assert gear.gap_rad == pytest.approx(3.490659e-3, abs=5e-10)
    assert gear.as_given.load_deviation_rad == pytest.approx(-1.947721e-7, abs=5e-14)
    assert gear.as_given.inertia_ratio == pytest.approx(17921.755, abs=5e-4)
    assert gear.as_given.deviation_mm == pytest.approx(1.363405e-4, abs=5e-11)
    assert gear.free_play_mm == pytest.approx(2.443461, abs=5e-7)
    assert gear.reflected is None


def test_the_paper_first_joint_with_its_rotor_seen_through_the_gearbox():
    gear = backlash(**PAPER, ratio=50)
    assert gear.reflected.motor_inertia == pytest.approx(0.6625)
    assert gear.reflected.inertia_ratio == pytest.approx(8.168, abs=5e-4)
    assert gear.reflected.load_deviation_rad == pytest.approx(-4.27342e-4, abs=5e-10)
    assert gear.reflected.deviation_mm == pytest.approx(0.299139, abs=5e-7)
    times = gear.reflected.deviation_mm / gear.as_given.deviation_mm
    assert times == pytest.approx(2194, abs=0.5)
    assert gear.as_given == backlash(**PAPER).as_given


@given(inertias, inertias, st.floats(1e-6, 1e4))
def test_eq_16_in_exact_fractions(Im, IL, arcmin):
    gear = backlash(Im=Im, IL=IL, arcmin=arcmin)
    exact = -Fraction(gear.gap_rad) / (1 + Fraction(IL) / Fraction(Im))
    assert gear.as_given.load_deviation_rad == pytest.approx(float(exact), rel=1e-15)


@given(gears())
def test_invariants(gear):
    for crossing in crossings(gear):
        load = crossing.load_inertia * crossing.load_deviation_rad
        motor = crossing.motor_inertia * crossing.motor_deviation_rad
        assert motor == pytest.approx(-load, rel=1e-14)  # eq. 13: the centre of mass stays
        relative = crossing.motor_deviation_rad - crossing.load_deviation_rad
        assert relative == pytest.approx(gear.gap_rad, rel=1e-14)  # eq. 15: all of 2D
        shown = abs(crossing.load_deviation_rad) * crossing.inertia_ratio
        assert shown == pytest.approx(gear.gap_rad, rel=1e-14)  # eq. 20
        assert 0 < crossing.deviation_mm <= gear.free_play_mm


@given(gears())
def test_a_ratio_is_n_squared_times_the_rotor(gear):
    assume(gear.ratio is not None)
    Im = gear.ratio**2 * gear.as_given.motor_inertia
    alone = backlash(Im=Im, IL=gear.as_given.load_inertia, arcmin=math.degrees(gear.gap_rad) * 60)
    assert gear.reflected.load_deviation_rad == pytest.approx(
        alone.as_given.load_deviation_rad, rel=1e-12
    )


@given(st.floats(1e-9, 1e8))
def test_more_rotor_means_more_deviation(Im):
    less, more = (backlash(Im=x, IL=4.749, arcmin=12).as_given for x in (Im, 2 * Im))
    assert more.load_deviation_rad < less.load_deviation_rad < 0


def test_limits():
    heavy = backlash(**{**PAPER, "Im": 1e12})
    assert heavy.as_given.load_deviation_rad == pytest.approx(-heavy.gap_rad, rel=1e-11)
    assert heavy.as_given.deviation_mm == pytest.approx(heavy.free_play_mm, rel=1e-11)
    equal = backlash(**{**PAPER, "Im": 4.749})
    assert equal.as_given.load_deviation_rad == -equal.gap_rad / 2
    assert equal.as_given.motor_deviation_rad == equal.gap_rad / 2
    light = backlash(**{**PAPER, "Im": 1e-12})
    assert light.as_given.motor_deviation_rad == pytest.approx(light.gap_rad, rel=1e-11)
    assert backlash(**PAPER, ratio=1).reflected == backlash(**PAPER).as_given


def test_without_an_arm_there_is_no_width():
    gear = backlash(Im=1, IL=1, arcmin=1)
    assert (gear.arm_m, gear.free_play_mm, gear.as_given.deviation_mm) == (None, None, None)


def test_a_result_is_frozen():
    with pytest.raises(FrozenInstanceError):
        backlash(**PAPER).gap_rad = 0


@pytest.mark.parametrize("name", ["Im", "IL", "arcmin", "arm", "ratio"])
@pytest.mark.parametrize("value", [0, -0.0, -1, math.nan, math.inf, -math.inf])
def test_every_bad_value_is_refused_by_name(name, value):
    with pytest.raises(UsageError) as refused:
        backlash(**{**PAPER, "ratio": 50, name: value})
    assert f"`{name}={value:g}`" in str(refused.value)
    assert refused.value.exit_code == 2


def test_all_bad_values_are_named_in_one_line():
    with pytest.raises(UsageError) as refused:
        backlash(Im=0, IL=-1, arcmin=math.nan, arm=math.inf, ratio=-50)
    said = str(refused.value)
    assert said.startswith("`Im=0`, `IL=-1`, `arcmin=nan`, `arm=inf`, `ratio=-50`: ")
    assert "\n" not in said


@pytest.mark.parametrize(
    "change",
    [
        {"Im": 5e-324},
        {"Im": 1e-300, "IL": 1e300},
        {"Im": 1e308, "IL": 1e308},
        {"IL": 1e308, "Im": 1e-10},
        {"arcmin": 5e-324},
        {"arm": 5e-324},
        {"ratio": 1e200},
        {"ratio": 1e-200},
    ],
    ids=str,
)
def test_what_doubles_cannot_hold_is_refused_and_never_zero_or_infinite(change):
    with pytest.raises(UsageError, match="too far apart"):
        backlash(**{**PAPER, **change})


@given(*[st.floats(min_value=0, exclude_min=True)] * 5)
def test_any_positive_values_give_positive_finite_figures_or_are_refused(
    Im, IL, arcmin, arm, ratio
):
    try:
        gear = backlash(Im=Im, IL=IL, arcmin=arcmin, arm=arm, ratio=ratio)
    except UsageError:
        return
    figures = [gear.gap_rad, gear.free_play_mm]
    for crossing in crossings(gear):
        figures += [
            -crossing.load_deviation_rad,
            crossing.motor_deviation_rad,
            crossing.deviation_mm,
            crossing.inertia_ratio,
            crossing.motor_inertia,
        ]
    assert all(0 < figure < math.inf for figure in figures)
