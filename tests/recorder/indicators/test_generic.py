"""The user's own pattern: whole lines, strict numbers, known units."""

from urllib.parse import quote

import pytest

from scara_iso.base.errors import UsageError
from scara_iso.recorder.indicators import (
    Decoder,
    Garbage,
    LineSettings,
    Reading,
    make_generic,
)
from scara_iso.recorder.plan import parse_gauge

BRIDGE = r"value=(?P<value>-?\d+\.\d+) (?P<unit>\S+)"


def decode(pattern: str, line: bytes) -> object:
    (event,) = Decoder(make_generic(pattern)).feed(line + b"\r\n")
    return event


def test_value_and_unit_are_the_named_groups() -> None:
    line = b"value=-12.340 mm"
    assert decode(BRIDGE, line) == Reading("-12.340", "mm", None, None, line)
    assert getattr(decode(BRIDGE, b"value=12.340 in"), "unit", "") == "inch"
    # github.com/apirek/digimatic: a number of fixed decimals, no unit, errors behind a '#'
    assert getattr(decode(r"(?P<value>-?\d+\.\d{6})", b"12.345000"), "text", "") == "12.345000"
    error = b"# Error reading from instrument: -1"
    assert isinstance(decode(r"(?P<value>-?\d+\.\d{6})", error), Garbage)


@pytest.mark.parametrize(
    "line",
    [b"value=1.5 furlong", b"value=1.5 mm ", b" value=1.5 mm", b"value=1,5 mm", b"value=1.5 \xb5m"],
)
def test_what_does_not_match_as_a_whole_is_garbage(line: bytes) -> None:
    assert isinstance(decode(BRIDGE, line), Garbage)


@pytest.mark.parametrize(
    "value", [b"1,5", b"1e5", b"nan", b"1_0", b"+-1", b"", b".", b"1.2.3", b"ERR3"]
)
def test_a_loose_pattern_still_takes_only_strict_numbers(value: bytes) -> None:
    assert isinstance(decode(r"v?(?P<value>.*)", b"v" + value), Garbage)


@pytest.mark.parametrize(
    ("value", "text"), [(b"+ 1.50", "1.50"), (b" -.5", "-0.5"), (b"007", "7"), (b"12.", "12")]
)
def test_signs_blanks_and_zeros_are_normalised(value: bytes, text: str) -> None:
    assert getattr(decode(r"v(?P<value>.*)", b"v" + value), "text", "") == text


def test_a_line_longer_than_any_reading_is_not_matched() -> None:
    assert isinstance(decode(r"(?P<value>\d*)", b"1" * 65), Garbage)
    assert isinstance(decode(r"(?P<value>\d*)", b"1" * 64), Reading)


@pytest.mark.parametrize(
    ("pattern", "said"),
    [
        (r"\d+", "no group named 'value'"),
        (r"(?P<value>\d+", "unterminated"),
        (r"(?P<value>µ)", "ascii"),
        (r"(?P<value>(\d+)+)x", "repeats a group"),
        (r"(?P<value>(?:\d|\d\d)*)x", "repeats a group"),
        (r"(?P<value>(?:\d+){2,9})x", "repeats a group"),
    ],
)
def test_a_pattern_that_cannot_work_is_refused(pattern: str, said: str) -> None:
    with pytest.raises(UsageError, match=said):
        make_generic(pattern)


def test_brackets_and_escapes_are_not_taken_for_groups() -> None:
    make_generic(r"[)]*\)+(?P<value>\d+)")


def test_the_user_sets_port_and_request() -> None:
    options = f"baud=19200&bits=7&parity=o&stop=1&request=r&pattern={quote(BRIDGE)}"
    dialect = parse_gauge(f"X=generic?{options}@sim:").dialect
    assert (dialect.line, dialect.request) == (LineSettings(19200, 7, "O", 1), b"r")
    assert dialect.terminator == b"\r\n"
    assert dialect.sends_unit
    assert not make_generic(r"(?P<value>.*)").sends_unit


def test_a_simulated_instrument_finds_a_form_that_the_pattern_takes() -> None:
    bare = make_generic(r"(?P<value>-?\d+\.\d{6})")
    assert bare.compose("-1.234500", None, None) == b"-1.234500\r\n"
    with pytest.raises(UsageError, match="no usual form"):
        make_generic(BRIDGE).compose("1.5", "mm", None)
