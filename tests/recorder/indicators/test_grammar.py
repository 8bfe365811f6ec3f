"""Numbers between display and text."""

import pytest

from scara_iso.base.errors import UsageError
from scara_iso.base.quantities import find_unit
from scara_iso.recorder.indicators._grammar import UNITS, decimal_text, show_digits


@pytest.mark.parametrize(
    ("sign", "digits", "text"),
    [
        (b"+", b"001.234", "1.234"), (b"-", b"001.230", "-1.230"), (b" ", b".000123", "0.000123"),
        (b"-", b"000.000", "-0.000"), (b"", b"  2.1380", "2.1380"), (b"+", b"000012.", "12"),
        (b"+", b"000000.", "0"), (b"-", b"0,812", "-0.812"),
    ],
)  # fmt: skip
def test_a_display_becomes_decimal_text(sign: bytes, digits: bytes, text: str) -> None:
    assert decimal_text(sign, digits) == text


def test_text_becomes_a_display() -> None:
    assert show_digits("-1.234", digits=6, decimals=(3,)) == ("-", "001.234")
    assert show_digits("0.0005", digits=7, decimals=(4,), fill=" ") == ("+", "  0.0005")
    assert show_digits("0.000123", digits=6, decimals=(6,)) == ("+", ".000123")


@pytest.mark.parametrize("text", ["1000.000", "1.2345", "1", "+1.000", "1.000 ", "²"])
def test_what_does_not_fit_is_refused(text: str) -> None:
    with pytest.raises(UsageError):
        show_digits(text, digits=6, decimals=(3,))


def test_units_on_the_wire_are_units_of_the_house() -> None:
    for spelt, name in UNITS.items():
        unit = find_unit(spelt.decode("ascii"))
        assert unit is not None
        assert unit.name == name
