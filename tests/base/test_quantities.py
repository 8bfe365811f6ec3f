"""Units: exact conversions, every spelling, scaled units, and what is refused."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, strategies as st

from scara_iso.base.errors import UsageError
from scara_iso.base.quantities import (
    Dimension,
    find_unit,
    parse_unit,
    rounding_uncertainty,
    size_in,
    unwrap,
)

EXACT = {
    "mm": Fraction(1),
    "um": Fraction(1, 1000),
    "nm": Fraction(1, 10**6),
    "cm": Fraction(10),
    "m": Fraction(1000),
    "inch": Fraction(254, 10),
    "thou": Fraction(254, 10_000),
    "deg": Fraction(1),
    "arcmin": Fraction(1, 60),
    "arcsec": Fraction(1, 3600),
}


def test_hundredths_of_a_millimetre_are_exact():
    hundredth = parse_unit("0.01 mm")
    assert hundredth.to_base(35.0) == 0.35
    for count in range(10_000):
        assert hundredth.to_base(float(count)) == float(f"{count // 100}.{count % 100:02}")


@pytest.mark.parametrize("name", EXACT)
@given(divisions=st.integers(-999_999, 999_999))
def test_a_reading_is_converted_to_the_nearest_double(name, divisions):
    unit = parse_unit(name)
    assert unit.to_base(float(divisions)) == float(divisions * EXACT[name])
    assert unit.to_base(np.array([float(divisions)]))[0] == float(divisions * EXACT[name])


@given(st.floats(-1e6, 1e6), st.sampled_from(sorted(EXACT)))
def test_any_reading_is_converted_within_two_roundings(reading, name):
    exact = Fraction(reading) * EXACT[name]
    assert parse_unit(name).to_base(reading) == pytest.approx(float(exact), rel=3e-16, abs=1e-320)


@given(
    st.decimals("0.0001", "1000", places=4), st.sampled_from(sorted(EXACT)), st.integers(-999, 999)
)
def test_a_scaled_unit_is_its_scale_times_the_unit(scale, name, divisions):
    unit = parse_unit(f"{scale} {name}")
    exact = divisions * Fraction(scale) * EXACT[name]
    assert unit.to_base(float(divisions)) == pytest.approx(float(exact), rel=3e-16)
    assert unit.dimension is parse_unit(name).dimension


@pytest.mark.parametrize(
    ("name", "one_turn"), [("rad", 2 * math.pi), ("mrad", 2000 * math.pi), ("arcmin", 21_600)]
)
def test_angles(name, one_turn):
    unit = parse_unit(name)
    assert unit.to_base(one_turn) == pytest.approx(360, rel=1e-15)
    assert unit.dimension is Dimension.ANGLE
    assert unit.base_name == "deg"


@pytest.mark.parametrize(
    ("spelling", "name"),
    [
        *((name, name) for name in EXACT),
        ("MM", "mm"),
        ("  mm ", "mm"),
        ("millimetre", "mm"),
        ("Millimeter", "mm"),
        ("\N{MICRO SIGN}m", "um"),
        ("\N{GREEK SMALL LETTER MU}m", "um"),
        ("microns", "um"),
        ("in", "inch"),
        ("Inches", "inch"),
        ('"', "inch"),
        ("Zoll", "inch"),
        ("\N{DEGREE SIGN}", "deg"),
        ("degrees", "deg"),
        ("'", "arcmin"),
        ("\N{PRIME}", "arcmin"),
        ("\N{DOUBLE PRIME}", "arcsec"),
        ("radians", "rad"),
    ],
)
def test_spellings(spelling, name):
    assert parse_unit(spelling).name == name


@pytest.mark.parametrize(
    ("spelling", "name", "one"),
    [
        ("0.01 mm", "0.01 mm", 0.01),
        ("0.01mm", "0.01 mm", 0.01),
        ("0.01 x mm", "0.01 mm", 0.01),
        ("1e-2 mm", "1e-2 mm", 0.01),
        ("1E-2 MM", "1e-2 mm", 0.01),
        ("0.0005 in", "0.0005 inch", 0.0127),
        ("10 \N{MICRO SIGN}m", "10 um", 0.01),
        ("30 arcsec", "30 arcsec", 30 / 3600),
        ("2m", "2 m", 2000),
    ],
)
def test_scaled_spellings(spelling, name, one):
    unit = parse_unit(spelling)
    assert unit.name == name
    assert unit.to_base(1.0) == one


@pytest.mark.parametrize(
    "text",
    [
        "", " ", "furlong", "mm2", "m m", "mm mm", "0 mm", "0.0 mm", "-1 mm", "+1 mm", "1",
        "0.01", "0,01 mm", "nan mm", "inf mm", "1/100 mm", ".5 mm", "1. mm", "1e mm", "1e100 mm",
        "1_0 mm", "0x1 mm", "١ mm", "٠.٠١ mm", "0.01 0.01 mm", "mm\x00", "[mm]",
    ],
)  # fmt: skip
def test_what_is_no_unit_is_refused(text):
    assert find_unit(text) is None
    with pytest.raises(UsageError, match="unknown unit") as refused:
        parse_unit(text)
    assert refused.value.exit_code == 2
    assert "0.01 mm" in refused.value.remedy


@given(st.text(max_size=20))
def test_any_text_is_a_unit_of_finite_size_or_none(text):
    unit = find_unit(text)
    assert unit is None or 0 < unit.to_base(1.0) < math.inf


@pytest.mark.parametrize("exponent", [-99, 99])
def test_the_largest_and_smallest_scales_stay_finite(exponent):
    unit = parse_unit(f"1e{exponent} mm")
    assert unit.to_base(1.0) == pytest.approx(10.0**exponent)


def test_rounding_uncertainty_is_the_deviation_of_a_division(rng):
    assert rounding_uncertainty(0.01) == pytest.approx(0.0028867513)
    rounded_off = rng.uniform(-0.005, 0.005, 100_000)
    assert rounded_off.std() == pytest.approx(rounding_uncertainty(0.01), rel=0.01)


@given(st.decimals("-9999", "9999", places=4), st.sampled_from(sorted(EXACT)))
def test_a_display_is_converted_with_one_rounding(shown, name):
    assert parse_unit(name).read(str(shown)) == float(Fraction(shown) * EXACT[name])


@given(st.decimals("-9999", "9999", places=4), *[st.sampled_from(sorted(EXACT))] * 2)
def test_a_size_is_given_in_another_unit_of_its_kind(size, own, wanted):
    kinds = {find_unit(name).dimension for name in (own, wanted)}
    exact = float(Fraction(size) * EXACT[own] / EXACT[wanted])
    expected = pytest.approx(exact, rel=1e-15) if len(kinds) == 1 else None
    assert size_in(f"{size}{own}", wanted) == expected


def test_a_display_in_inches_gives_the_millimetres_a_person_would_write():
    assert str(parse_unit("inch").read("0.5660")) == "14.3764"


@pytest.mark.parametrize(
    ("shown", "meant"),
    [
        ([359.9, 0.1], [-0.1, 0.1]), ([179.9, -179.9], [179.9, 180.1]), ([269, -89], [269, 271]),
        ([271, -88], [-89, -88]), ([290, 670], [-70, -50]), ([100, 480], [100, 120]),
    ],
)  # fmt: skip
def test_angles_lie_together_between_minus_90_and_270_degrees(shown, meant):
    assert unwrap(np.array(shown, dtype=float)).tolist() == pytest.approx(meant)
