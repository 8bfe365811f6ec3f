"""Opto-RS232: what each maker's cable sends, as its manual says."""

import pytest

from scara_iso.base.errors import UsageError
from scara_iso.recorder.indicators import (
    DeviceNotice,
    InstrumentFault,
    LinePulse,
    LineSettings,
    Reading,
    find_dialect,
)

OPTO = find_dialect("opto-rs232")
CABLES = ["opto-rs232", "opto-rs232-simplex", "opto-rs232-tesa", "opto-rs232-trimos",
          "opto-rs232-ibr"]  # fmt: skip


@pytest.mark.parametrize("key", CABLES)
def test_every_cable_is_a_port_of_4800_7e2_fed_by_dtr(key: str) -> None:
    rts = key == "opto-rs232-simplex"
    assert find_dialect(key).line == LineSettings(4800, 7, "E", 2, dtr=True, rts=rts)
    assert find_dialect(key).longest_frame == 32


def test_how_each_cable_is_asked_and_ends_its_lines() -> None:
    """Only the makers whose manual has UNI? are asked for the unit of the display."""
    asked = {key: find_dialect(key) for key in CABLES}
    assert {k: (d.request, d.unit_request, d.terminator) for k, d in asked.items()} == {
        "opto-rs232": (b"?\r", b"UNI?\r", b"\r"),
        "opto-rs232-simplex": (None, None, b"\r"),
        "opto-rs232-tesa": (b"?\r", None, b"\r\n"),
        "opto-rs232-trimos": (b"?\r", None, b"\r"),
        "opto-rs232-ibr": (b"?\r", None, b"\r"),
    }
    pulses = {key: dialect.request_line for key, dialect in asked.items()}
    assert pulses.pop("opto-rs232-simplex") == LinePulse("dtr", level=False, seconds=0.15)
    assert set(pulses.values()) == {None}


def test_the_display_of_each_cable() -> None:
    shown = {key: find_dialect(key) for key in CABLES}
    assert {k: (d.digits, d.decimals, d.units, d.confidence) for k, d in shown.items()} == {
        "opto-rs232": (6, (3, 1, 2, 4, 5, 6), (None, "mm", "inch"), "high"),
        "opto-rs232-simplex": (6, (3, 1, 2, 4, 5, 6), (None, "mm", "inch"), "high"),
        "opto-rs232-tesa": (6, (3, 1, 2, 4, 5, 6), (None, "mm", "inch"), "high"),
        "opto-rs232-trimos": (8, (4, 1, 2, 3, 5, 6), (None,), "medium"),
        "opto-rs232-ibr": (7, (4, 1, 2, 3, 5, 6), (None, "mm", "inch"), "medium"),
    }


@pytest.mark.parametrize(
    ("key", "line", "text", "unit", "mode"),
    [
        ("opto-rs232", b"+001.234", "1.234", None, None),
        ("opto-rs232", b"-001.234mm", "-1.234", "mm", None),
        ("opto-rs232", b" 0.05000 IN", "0.05000", "inch", None),
        ("opto-rs232", b"+001.234in<", "1.234", "inch", "<"),
        ("opto-rs232", b"+001.234 MM=", "1.234", "mm", "="),
        ("opto-rs232", b"+.000123>", "0.000123", None, ">"),
        ("opto-rs232-ibr", b"+0001.234", "1.234", None, None),
        ("opto-rs232-trimos", b"    1.2340", "1.2340", None, None),
        ("opto-rs232-trimos", b"   -1.2340", "-1.2340", None, None),
        ("opto-rs232-trimos", b"  - 1.2340", "-1.2340", None, None),
    ],
)
def test_a_number_is_read_as_shown(
    key: str, line: bytes, text: str, unit: str | None, mode: str | None
) -> None:
    assert find_dialect(key).parse(line) == (Reading(text, unit, None, mode, line),)


@pytest.mark.parametrize(
    ("key", "line"),
    [
        ("opto-rs232", b"+01.234"), ("opto-rs232", b"+0001.234"), ("opto-rs232", b"001.234"),
        ("opto-rs232", b"+001234"), ("opto-rs232", b"+0.1.234"), ("opto-rs232", b"+001.234m"),
        ("opto-rs232", b"+001.234  mm"), ("opto-rs232", b"+001.234<<"),
        ("opto-rs232-ibr", b"+001.234"), ("opto-rs232-trimos", b"   1.2340"),
        ("opto-rs232-trimos", b"     1.2340"), ("opto-rs232-trimos", b"  1.2340mm"),
        ("opto-rs232", b""), ("opto-rs232", b"ERR"), ("opto-rs232", b"ERR123"),
        ("opto-rs232", b"UNI"), ("opto-rs232", b"BAT2"), ("opto-rs232", b"SY" + b"x" * 30),
    ],
)  # fmt: skip
def test_what_lost_or_won_a_byte_is_nothing(key: str, line: bytes) -> None:
    assert find_dialect(key).parse(line) == ()


@pytest.mark.parametrize(
    ("line", "said", "unit", "switched_on"),
    [
        (b"MM", "MM", "mm", False),
        (b"in", "in", "inch", False),
        (b"MM RES2 REF1 KEY0 B1", "MM RES2 REF1 KEY0 B1", "mm", False),
        (b"MM B0", "MM B0: battery low", "mm", False),
        (b"IN RES3 B0", "IN RES3 B0: battery low", "inch", False),
        (b"BAT0", "BAT0: battery low", None, False),
        (b"bat0", "bat0: battery low", None, False),
        (b"BAT1", "BAT1", None, False),
        (b"SY233 S_Dial", "SY233 S_Dial", None, True),
        (b"sy1", "sy1", None, True),
        (b"UNI?", "UNI?", None, False),
        (b"?", "?", None, False),
    ],
)
def test_other_lines_are_notices(
    line: bytes, said: str, unit: str | None, switched_on: bool
) -> None:
    """The unit of a status line, a low battery, and a banner: the zero is gone."""
    assert OPTO.parse(line) == (DeviceNotice(said, line, unit, switched_on=switched_on),)


def test_errors_keep_the_line_as_it_came() -> None:
    assert OPTO.parse(b"ov") == ()
    assert OPTO.parse(b"OV") == (InstrumentFault("OV", "outside the range", b"OV"),)


@pytest.mark.parametrize(
    ("key", "text", "unit", "frame"),
    [
        ("opto-rs232", "-1.234", None, b"-001.234\r"),
        ("opto-rs232", "1.234", "mm", b"+001.234mm\r"),
        ("opto-rs232", "0.000123", "inch", b"+.000123in\r"),
        ("opto-rs232-simplex", "1.2", None, b"+00001.2\r"),
        ("opto-rs232-tesa", "1.234", None, b"+001.234\r\n"),
        ("opto-rs232-ibr", "1.234", None, b"+0001.234\r"),
        ("opto-rs232-trimos", "-1.2340", None, b"   -1.2340\r"),
        ("opto-rs232-trimos", "1.2340", None, b"    1.2340\r"),
        ("opto-rs232-trimos", "-12.3", None, b"     -12.3\r"),
        ("opto-rs232-trimos", "0.123456", None, b"  0.123456\r"),
    ],
)
def test_a_simulated_instrument_sends_what_the_manual_shows(
    key: str, text: str, unit: str | None, frame: bytes
) -> None:
    assert find_dialect(key).compose(text, unit, None) == frame


@pytest.mark.parametrize(
    ("key", "text", "unit"),
    [
        ("opto-rs232", "1234567.1", None), ("opto-rs232", "12", None),
        ("opto-rs232", "0.1234567", None), ("opto-rs232", "1.0", "deg"),
        ("opto-rs232-trimos", "12", None), ("opto-rs232-trimos", "1.0", "mm"),
        ("opto-rs232-trimos", "0.123456789", None), ("opto-rs232-trimos", "12345678.1", None),
    ],
)  # fmt: skip
def test_what_no_display_shows_is_not_sent(key: str, text: str, unit: str | None) -> None:
    with pytest.raises(UsageError):
        find_dialect(key).compose(text, unit, None)
