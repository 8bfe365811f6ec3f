"""Repeatability against the paper's table, NIST's certified sets, exact fractions and scipy."""

import csv
import math
import re
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
from scipy import integrate, stats

from scara_iso.iso9283.core import statistics as module
from scara_iso.iso9283.core.statistics import (
    repeatability,
    rp_interval,
    rss_interval,
    standard_deviation,
    three_sigma_interval,
)

ROOT = Path(__file__).parents[2]
NIST = ROOT / "tests" / "fixtures" / "nist_strd"

sizes = st.integers(2, 40)
components = st.integers(1, 3)
places = st.floats(-10, 10).map(lambda x: round(x, 3))


@st.composite
def positions(draw, poses=None, fewest=2):
    """Readings of a dial with three decimals, shape ([poses,] components, n)."""
    shape = (draw(components), draw(st.integers(fewest, 40)))
    shape = shape if poses is None else (draw(poses), *shape)
    return draw(arrays(np.float64, shape, elements=places))


@pytest.fixture(scope="module")
def table_1():
    """Return the paper's Table I in hundredths of a millimetre, shape (30,) by axis."""
    lines = (ROOT / "examples" / "fum_scara_table1.csv").read_text(encoding="utf-8").splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    return {name: np.array([float(row[name]) for row in rows]) for name in ("X", "Y", "Z", "theta")}


@pytest.mark.parametrize(
    ("axis", "mean", "l_bar", "S", "RP", "three_sigma"),
    [
        ("X", 9.73333, 0.48889, 0.30492, 1.40365, 1.74988),
        ("Y", 80.53333, 0.49778, 0.03383, 0.59926, 1.52225),
        ("Z", 36.90000, 0.67333, 0.56013, 2.35373, 2.65421),
        ("theta", 47.66667, 0.31111, 0.16220, 0.79771, 1.06674),
    ],
)
def test_table_1_recomputed(table_1, axis, mean, l_bar, S, RP, three_sigma):
    found = repeatability(table_1[axis][np.newaxis])
    assert found.n == 30
    assert found.mean == pytest.approx([mean], abs=5e-6)
    assert found.l_bar == pytest.approx(l_bar, abs=5e-6)
    assert found.S_l == pytest.approx(S, abs=5e-6)
    assert found.RP == pytest.approx(RP, abs=5e-6)
    assert 3 * standard_deviation(table_1[axis]) == pytest.approx(three_sigma, abs=5e-6)


def test_table_1_in_the_plane(table_1):
    plane = np.stack([table_1["X"], table_1["Y"]])
    assert np.linalg.norm(repeatability(plane[:, np.newaxis]).RP) == pytest.approx(
        1.52622, abs=5e-6
    )
    assert repeatability(plane).RP == pytest.approx(1.40566, abs=5e-6)


@pytest.mark.parametrize(
    ("axis", "wrong"), [("X", 1.2031), ("Y", 0.5520), ("Z", 2.4036), ("theta", 0.8029)]
)
def test_table_1_with_row_1_discarded_again_is_another_answer(table_1, axis, wrong):
    found = repeatability(table_1[axis][np.newaxis, 1:]).RP
    assert found == pytest.approx(wrong, abs=5e-5)
    assert abs(found - repeatability(table_1[axis][np.newaxis]).RP) > 0.005


def read_nist(name):
    text = (NIST / f"{name}.dat").read_text(encoding="ascii")
    certified = re.findall(r"Sample (?:Mean|Standard Deviation).*?:\s*(\S+)\n", text)
    data = re.split(r"-{5,}\n", text)[-1].split()
    assert len(data) == int(re.search(r"Number of Observations:\s*(\d+)", text)[1])
    return (*map(Fraction, certified), np.array(data, dtype=float))


def digits(found, certified):
    """Return the log relative error: how many digits agree; 17 where all do."""
    error = abs(Fraction(float(found)) / certified - 1)
    return -math.log10(error) if error else 17.0


def exact_moments(readings):
    """Return mean and sample standard deviation of the stored doubles, to 40 digits."""
    exact = [Fraction(x) for x in readings.tolist()]
    mean = sum(exact) / len(exact)
    variance = sum((x - mean) ** 2 for x in exact) / (len(exact) - 1)
    return mean, exact_root(variance)


def exact_root(value):
    with localcontext() as context:
        context.prec = 40
        return Fraction((Decimal(value.numerator) / Decimal(value.denominator)).sqrt())


# NumAcc4 is written in decimals that doubles cannot hold: near 1e7 two neighbours are 1.9e-9
# apart, and the stored readings themselves have a standard deviation that agrees with the
# certified 0.1 in 8.25 digits only. The same takes digits from NumAcc3, Michelso and Mavro. What
# is left to the algorithm is held by the test below: all digits of the readings as stored.
@pytest.mark.parametrize(
    ("name", "mean_digits", "sd_digits"),
    [
        ("Lew", 15, 15),
        ("Mavro", 15, 13),
        ("Michelso", 15, 13.8),
        ("NumAcc1", 17, 17),
        ("NumAcc2", 15, 15),
        ("NumAcc3", 15, 9.4),
        ("NumAcc4", 15, 8.25),
    ],
)
def test_nist_certified_values(name, mean_digits, sd_digits):
    mean, deviation, readings = read_nist(name)
    assert digits(repeatability(readings[np.newaxis]).mean[0], mean) >= mean_digits
    assert digits(standard_deviation(readings), deviation) >= sd_digits


@pytest.mark.parametrize("path", sorted(NIST.glob("*.dat")), ids=lambda path: path.stem)
def test_nist_sets_lose_no_digit_beyond_what_doubles_store(path):
    readings = read_nist(path.stem)[2]
    mean, deviation = exact_moments(readings)
    assert digits(repeatability(readings[np.newaxis]).mean[0], mean) >= 15.5
    assert digits(standard_deviation(readings), deviation) >= 15.5


@pytest.mark.parametrize("n", [2, 3, 30, 31])
def test_equally_spaced_readings(n):
    readings = np.arange(n, dtype=float)
    found = repeatability(readings[np.newaxis])
    l_bar = (n * n - n % 2) / (4 * n)
    squares = n * (n * n - 1) / 12
    S = math.sqrt(max(squares - n * l_bar**2, 0) / (n - 1))
    assert found.mean == pytest.approx([(n - 1) / 2])
    assert found.RP == pytest.approx(l_bar + 3 * S)
    assert standard_deviation(readings) == pytest.approx(math.sqrt(n * (n + 1) / 12))


@pytest.mark.parametrize("high", range(1, 30))
def test_two_level_readings(high):
    readings = np.array([1.0] * high + [0.0] * (30 - high))
    p = high / 30
    l_bar, S = 2 * p * (1 - p), abs(1 - 2 * p) * math.sqrt(p * (1 - p) * 30 / 29)
    found = repeatability(readings[np.newaxis])
    assert found.l_bar == pytest.approx(l_bar)
    assert found.S_l == pytest.approx(S, abs=1e-15)
    assert found.RP == pytest.approx(l_bar + 3 * S)


def test_a_square_of_positions_has_no_spread_of_distances():
    corners = np.array([[1.0, 1, -1, -1], [1, -1, -1, 1]])
    found = repeatability(corners + 5)
    assert found.mean == pytest.approx([5, 5])
    assert found.RP == pytest.approx(math.sqrt(2))
    assert found.S_l == pytest.approx(0, abs=1e-15)


@given(positions())
def test_rp_equals_exact_fractions(measured):
    exact = [[Fraction(x) for x in row] for row in measured.tolist()]
    n = measured.shape[1]
    centred = [[x - sum(row) / n for x in row] for row in exact]
    distance = [exact_root(sum(c * c for c in point)) for point in zip(*centred, strict=True)]
    l_bar = sum(distance) / n
    S = exact_root(sum((x - l_bar) ** 2 for x in distance) / (n - 1))
    assert repeatability(measured).RP == pytest.approx(float(l_bar + 3 * S), rel=1e-9, abs=1e-12)


@pytest.mark.filterwarnings("ignore:Precision loss")  # scipy's own, of distances all equal
@given(positions())
def test_agrees_with_scipy(measured):
    distance = np.linalg.norm(measured - measured.mean(axis=1, keepdims=True), axis=0)
    found = repeatability(measured)
    assert found.l_bar == pytest.approx(stats.describe(distance).mean, abs=1e-12)
    assert found.S_l == pytest.approx(stats.tstd(distance), abs=1e-12)
    assert standard_deviation(measured) == pytest.approx(stats.tstd(measured, axis=1), abs=1e-12)


@given(positions(), st.floats(-100, 100))
def test_a_shift_moves_only_the_mean(measured, shift):
    here, there = repeatability(measured), repeatability(measured + shift)
    assert there.mean == pytest.approx(here.mean + shift, abs=1e-11)
    assert there.RP == pytest.approx(here.RP, abs=1e-11)


@given(positions(), st.sampled_from([1e-6, 0.01, 25.4, 1e6]), st.sampled_from([-1, 1]))
def test_scale(measured, size, sign):
    here, there = repeatability(measured), repeatability(sign * size * measured)
    assert there.mean == pytest.approx(sign * size * here.mean, rel=1e-9, abs=1e-12 * size)
    assert there.RP == pytest.approx(size * here.RP, rel=1e-9, abs=1e-12 * size)


@given(positions(), st.integers(0, 2**32 - 1))
def test_turning_the_base_frame_keeps_the_radial_figure(measured, seed):
    if len(measured) == 1:
        turned = -measured
    else:
        turned = stats.special_ortho_group.rvs(len(measured), random_state=seed) @ measured
    assert repeatability(turned).RP == pytest.approx(repeatability(measured).RP, abs=1e-11)


@given(positions(), st.randoms())
def test_order_of_cycles_and_of_axes_does_not_matter(measured, random):
    cycles, axes = list(range(measured.shape[1])), list(range(len(measured)))
    random.shuffle(cycles)
    random.shuffle(axes)
    shuffled = measured[axes][:, cycles]
    assert repeatability(shuffled).RP == pytest.approx(repeatability(measured).RP, abs=1e-12)
    assert repeatability(shuffled).mean == pytest.approx(
        repeatability(measured).mean[axes], abs=1e-12
    )


@given(positions(poses=st.integers(1, 4), fewest=5))
def test_a_batch_of_poses_equals_one_by_one(measured):
    together = repeatability(measured)
    lower, upper = rp_interval(measured, resolutions=[0.001] * measured.shape[1])
    for k, alone in enumerate(measured):
        one = repeatability(alone)
        for field in ("mean", "l_bar", "S_l", "RP"):
            assert getattr(together, field)[k] == pytest.approx(getattr(one, field), abs=1e-12)
        found = np.stack(rp_interval(alone, resolutions=[0.001] * len(alone)))
        # Of tests that leaving out a cycle hardly changes, the skewness is noise.
        assert np.stack([lower[k], upper[k]]) == pytest.approx(found, rel=1e-5, abs=1e-9)


@given(positions().filter(lambda x: len(x) == 1))
def test_one_component_is_eq_2_to_6(measured):
    x, n = measured[0], measured.shape[1]
    mean = sum(x) / n
    distances = [abs(x_j - mean) for x_j in x]
    l_bar = sum(distances) / n
    S = math.sqrt(sum((l_j - l_bar) ** 2 for l_j in distances) / (n - 1))
    assert repeatability(measured).RP == pytest.approx(l_bar + 3 * S, abs=1e-11)


@given(positions())
def test_a_component_without_scatter_adds_nothing(measured):
    flat = np.vstack([measured, np.full(measured.shape[1], 7.0)])
    assert repeatability(flat).RP == pytest.approx(repeatability(measured).RP, abs=1e-12)


# The interval


@given(positions(fewest=5), st.sampled_from([None, 0.0005, 0.001, 0.1, 5.0]))
def test_the_interval_is_finite_and_holds_rp(measured, resolution):
    RP = repeatability(measured).RP
    resolutions = None if resolution is None else [resolution] * len(measured)
    lower, upper = rp_interval(measured, resolutions=resolutions)
    assert 0 <= lower <= RP <= upper < math.inf
    assert RP == 0 or lower < upper


@given(positions(fewest=5), st.floats(-50, 50), st.sampled_from([1e-6, 0.01, 25.4, 1e6]))
def test_the_interval_scales_and_does_not_shift(measured, shift, size):
    if repeatability(measured).RP < 1e-6:
        measured = measured + np.arange(measured.shape[1]) ** 2
    resolutions = np.full(len(measured), 0.001)
    here = np.stack(rp_interval(measured, resolutions=resolutions))
    moved = np.stack(rp_interval(measured + shift, resolutions=resolutions))
    scaled = np.stack(rp_interval(measured * size, resolutions=resolutions * size))
    assert moved == pytest.approx(here, rel=1e-5, abs=1e-9)
    assert scaled == pytest.approx(here * size, rel=1e-5, abs=1e-9 * size)


@given(positions(fewest=5), st.floats(0, 10), st.floats(0, 10))
def test_a_coarser_dial_never_narrows_the_interval(measured, one, other):
    fine, coarse = sorted((one, other))
    inner = rp_interval(measured, resolutions=[fine] * len(measured))
    outer = rp_interval(measured, resolutions=[coarse] * len(measured))
    assert outer[0] <= inner[0]
    if not module.two_divisions(measured, [coarse] * len(measured)):
        assert outer[1] >= inner[1]  # what two divisions hold tells no law: another rule


def test_only_a_coarse_dial_takes_long_tails_for_its_own(rng):
    long_tailed = rng.standard_cauchy((1, 30))
    unknown = rp_interval(long_tailed, resolutions=None)
    fine, coarse = (rp_interval(long_tailed, resolutions=[step]) for step in (1e-9, 20.0))
    assert np.stack(fine) == pytest.approx(np.stack(unknown))
    assert coarse[0] < unknown[0]


@pytest.mark.parametrize("axes", [1, 2])
@pytest.mark.parametrize("n", [30, 100])
def test_the_lower_limit_holds_at_the_worst_place_between_two_divisions(rng, axes, n):
    readings = np.rint(0.4 * rng.standard_normal((2000, axes, n)))
    lower = rp_interval(readings, resolutions=[1.0] * axes)[0]
    assert np.mean(lower > 0.4 * module.GAUSSIAN_RP[axes]) < 0.04


@pytest.mark.parametrize("n", [5, 8, 10, 16, 30, 31, 32, 100, 1000])
@pytest.mark.parametrize("axes", [1, 2, 3])
def test_equal_readings_are_bounded_by_what_a_division_hides(n, axes):
    lower, upper = rp_interval(np.full((axes, n), 0.36), resolutions=[0.005] * (axes - 1) + [0.01])
    sigma = 0.005 / stats.norm.isf((1 - 0.05 ** (1 / n)) / 2)
    assert lower == 0
    assert upper == pytest.approx(module.GAUSSIAN_RP[axes] * sigma)
    chance = (1 - 2 * stats.norm.sf(0.005, scale=sigma)) ** n
    assert chance == pytest.approx(0.05)


def test_equal_readings_of_an_unknown_dial_bound_nothing():
    assert rp_interval(np.full((1, 30), 0.36), resolutions=None) == (0, 0)


@pytest.mark.parametrize("n", [10, 16, 30, 32])
def test_two_neighbouring_divisions_may_hide_a_robot_without_scatter(n):
    readings = 0.8 + 0.01 * np.tile([0.0, 1.0], n // 2)[np.newaxis]
    lower, upper = rp_interval(readings, resolutions=[0.01])
    assert lower == 0
    sigma = 0.01 / stats.norm.isf((1 - 0.05 ** (1 / n)) / 2)
    assert upper >= module.GAUSSIAN_RP[1] * sigma * (1 - 1e-12)
    readings[0, 0] += 0.02
    assert rp_interval(readings, resolutions=[0.01])[0] > 0


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_the_interval_is_never_narrower_than_that_of_gaussian_scatter(rng, axes):
    readings = rng.permuted(np.tile([0.0, 1.0], (axes, 15)), axis=1)  # the jackknife sees no error
    RP = repeatability(readings).RP
    lower, upper = rp_interval(readings, resolutions=None)
    r = 29 / (2 * module.GAUSSIAN_ERROR[axes] ** 2)
    least, most = np.sqrt(r / stats.chi2.ppf((0.975, 0.025), r))
    assert upper >= RP * most * 0.98  # to second order
    assert lower <= RP * least * 1.001


def test_equal_readings_have_exactly_no_scatter():
    for reading in (0.1, 0.36, 1e7 + 0.1):
        readings = np.full((1, 30), reading)
        assert repeatability(readings).RP == 0
        assert standard_deviation(readings) == 0
        assert repeatability(readings).mean == reading


@pytest.mark.parametrize(("axes", "sigma"), [(1, 0.3), (1, 0.4), (2, 0.4)])
def test_the_upper_limit_holds_on_the_border_of_two_divisions(rng, axes, sigma):
    readings = np.rint(0.5 + sigma * rng.standard_normal((2000, axes, 30)))
    upper = rp_interval(readings, resolutions=[1.0] * axes)[1]
    assert np.mean(upper < sigma * module.GAUSSIAN_RP[axes]) < 0.03


def test_one_reading_that_holds_all_of_rp_has_a_wide_but_finite_interval():
    readings = np.zeros((1, 30))
    readings[0, 7] = 1
    lower, upper = rp_interval(readings, resolutions=None)
    assert 0 < lower < repeatability(readings).RP < upper < math.inf


def test_more_cycles_narrow_the_interval(rng):
    measured = rng.standard_normal((200, 1, 120))
    widths = [np.median(np.subtract(*rp_interval(measured[..., :n], resolutions=None)[::-1]))
              for n in (10, 30, 120)]  # fmt: skip
    assert widths[0] > 1.5 * widths[1]
    assert widths[1] > 1.5 * widths[2]


@pytest.mark.parametrize(
    ("axes", "scatter", "least"),
    [
        (1, lambda rng, shape: rng.standard_normal(shape), 0.95),
        (2, lambda rng, shape: rng.standard_normal(shape), 0.95),
        (1, lambda rng, shape: rng.exponential(size=shape), 0.89),
        (2, lambda rng, shape: rng.standard_t(5, shape), 0.91),
    ],
)
def test_coverage_of_thirty_cycles(rng, axes, scatter, least):
    true = repeatability(scatter(rng, (axes, 500_000))).RP
    lower, upper = rp_interval(scatter(rng, (1000, axes, 30)), resolutions=None)
    assert np.mean((lower <= true) & (true <= upper)) >= least


def population(axes):
    """Return E, sd and the influence function's sd of l + 3 S for unit Gaussian scatter."""
    law = stats.chi(axes)

    def influence(x):
        return x - law.mean() + 3 * ((x - law.mean()) ** 2 - law.var()) / (2 * law.std())

    square = integrate.quad(lambda x: influence(x) ** 2 * law.pdf(x), 0, 40)[0]
    return law.mean() + 3 * law.std(), math.sqrt(square)


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_gaussian_constants(axes):
    RP, spread = population(axes)
    assert module.GAUSSIAN_RP[axes] == pytest.approx(RP, abs=5e-6)
    assert module.GAUSSIAN_ERROR[axes] == pytest.approx(spread / RP, abs=5e-6)


@pytest.mark.parametrize("n", [10, 30, 100])
def test_3_s_of_gaussian_scatter_has_the_interval_of_chi_square(n):
    readings = stats.norm.ppf((np.arange(n) + 0.5) / n)[np.newaxis]
    lower, upper = three_sigma_interval(readings, resolutions=None)
    three_sigma = 3 * readings.std(ddof=1)
    least, most = three_sigma * np.sqrt((n - 1) / stats.chi2.ppf((0.975, 0.025), n - 1))
    assert lower == pytest.approx(least, rel=0.01)
    # raised by what the jackknife says that 3 S of so few cycles falls short
    assert most * (1 - 2 / n) < upper < most * (1 + 3 / n)


@pytest.mark.parametrize("n", [5, 30])
def test_3_s_of_readings_in_one_division_is_below_what_would_leave_it(n):
    """Gaussian scatter of the upper limit stays within the division one time in twenty."""
    lower, upper = three_sigma_interval(np.full((1, n), 0.4), resolutions=[0.2])
    inside = 1 - 2 * stats.norm.sf(0.1, scale=upper / 3)
    assert inside**n == pytest.approx(0.05)
    assert lower == 0


@pytest.mark.parametrize("division", [1e-9, 0.5, 1.0, 2.0])
def test_coverage_of_3_s(rng, division):
    place = rng.uniform(0, 1, (1000, 1, 1))
    drawn = np.rint(rng.standard_normal((1000, 1, 30)) / division + place) * division
    lower, upper = three_sigma_interval(drawn, resolutions=[division])
    assert 0.94 <= np.mean((lower <= 3) & (upper >= 3))
    if division < 1:
        assert np.mean(upper < 3) < 0.025 > np.mean(lower > 3) - 0.01


def test_eq_23_of_a_plane_has_its_own_interval(rng):
    drawn = rng.standard_normal((1000, 2, 30))
    true = math.sqrt(2) * module.GAUSSIAN_RP[1]
    lower, upper = rss_interval(drawn, resolutions=None)
    assert 0.94 <= np.mean((lower <= true) & (upper >= true)) <= 0.995
    RP = module.root_sum_of_squares(drawn)
    each = [repeatability(drawn[:, [k]]).RP for k in (0, 1)]
    assert pytest.approx(np.hypot(*each)) == RP
    assert np.all((lower < RP) & (RP < upper))


# Numbers to test against, by simulation with a fixed seed


@pytest.mark.parametrize(
    ("axes", "mean", "low", "high", "limit"),
    [
        (1, 2.54, 1.88, 3.27, 2.606),
        (2, 3.15, 2.51, 3.83, 3.219),
        (3, 3.54, 2.92, 4.21, 3.616),
    ],
)
def test_rp_of_gaussian_scatter(rng, axes, mean, low, high, limit):
    found = repeatability(rng.standard_normal((20_000, axes, 30))).RP
    assert found.mean() == pytest.approx(mean, abs=0.01)
    assert np.quantile(found, (0.025, 0.975)) == pytest.approx((low, high), abs=0.03)
    assert repeatability(rng.standard_normal((axes, 1_000_000))).RP == pytest.approx(
        limit, abs=0.01
    )


@pytest.mark.parametrize(
    ("sigma", "true", "read"),
    [(1, 3.5, 7.8), (2, 7.1, 11.8), (3, 10.6, 14.3), (5, 17.7, 20.2), (10, 35.4, 36.8)],
)
def test_a_dial_of_ten_micrometres_adds_to_rp(rng, sigma, true, read):
    scatter = sigma * rng.standard_normal((10_000, 3, 30))
    place = rng.uniform(0, 10, (10_000, 3, 1))
    found = repeatability(np.rint((scatter + place) / 10) * 10).RP
    assert repeatability(scatter).RP.mean() == pytest.approx(true, abs=0.06)
    assert found.mean() == pytest.approx(read, abs=0.15)
    assert np.mean(found == 0) == pytest.approx(0.2 if sigma == 1 else 0, abs=0.015)


def test_a_dial_of_one_micrometre_adds_little(rng):
    scatter = rng.standard_normal((10_000, 3, 30))
    read = repeatability(np.rint(scatter + rng.uniform(0, 1, (10_000, 3, 1)))).RP
    assert 0.1 < np.mean(read - repeatability(scatter).RP) < 0.15


@pytest.mark.parametrize(
    ("drift", "read"), [(0, 10.6), (10, 12.2), (20, 16.7), (40, 29.2), (100, 70.5)]
)
def test_warm_up_counts_as_scatter(rng, drift, read):
    scatter = 3 * rng.standard_normal((10_000, 3, 30))
    scatter[:, 0] += drift * -np.expm1(-np.arange(30) / 8)
    assert repeatability(scatter).RP.mean() == pytest.approx(read, abs=0.1)
