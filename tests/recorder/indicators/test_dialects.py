"""One contract for every dialect found: what is composed is parsed, and nothing else is."""

import re
from decimal import Decimal

import pytest
from budget import examples
from hypothesis import given, strategies as st

from scara_iso.base.errors import UsageError
from scara_iso.recorder.indicators import (
    Decoder,
    Dialect,
    Garbage,
    LinePulse,
    LineSettings,
    Reading,
    find_dialect,
    find_dialects,
)

DIALECTS = list(find_dialects().values())
STRICT = re.compile(r"-?(0|[1-9][0-9]*)(\.[0-9]+)?", re.ASCII)

every_dialect = pytest.mark.parametrize("dialect", DIALECTS, ids=lambda dialect: dialect.key)


def shown(dialect: Dialect) -> st.SearchStrategy[str]:
    """What the instrument can show: all its digits, with any number of decimals it has.

    Whole nines are left out: several sources use them for "out of range".
    """

    def text(digits: int, places: int, minus: bool) -> str:
        whole, fraction = divmod(digits, 10**places)
        return f"{'-' * minus}{whole}" + (f".{fraction:0{places}}" if places else "")

    return st.builds(
        text,
        st.integers(0, 10 ** min(dialect.digits, 9) - 1).filter(lambda n: set(str(n)) != {"9"}),
        st.sampled_from(dialect.decimals),
        st.booleans(),
    )


def readings(dialect: Dialect, *chunks: bytes) -> list[Reading]:
    decoder = Decoder(dialect)
    events = [event for chunk in chunks for event in decoder.feed(chunk)]
    return [event for event in events if isinstance(event, Reading)]


@every_dialect
def test_a_display_has_numbers_of_decimals_that_differ_and_fit(dialect: Dialect) -> None:
    assert len(set(dialect.decimals)) == len(dialect.decimals)
    assert all(0 <= count <= dialect.digits for count in dialect.decimals)


@every_dialect
@examples(25)
@given(data=st.data())
def test_what_an_instrument_shows_is_read_back(dialect: Dialect, data: st.DataObject) -> None:
    text, unit = data.draw(shown(dialect)), data.draw(st.sampled_from(dialect.units))
    frame = dialect.compose(text, unit, dialect.channel)
    (reading,) = readings(dialect, frame)
    assert (reading.text, reading.unit) == (text, unit)
    assert STRICT.fullmatch(reading.text)
    assert reading.value == Decimal(text)
    assert reading.resolution == Decimal(1).scaleb(-reading.decimals)
    assert dialect.channel is None or reading.channel == dialect.channel
    assert frame == reading.raw + dialect.terminator
    assert len(reading.raw) <= dialect.longest_frame


@every_dialect
@examples(25)
@given(data=st.data())
def test_two_frames_read_alike_however_they_arrive(dialect: Dialect, data: st.DataObject) -> None:
    unit = dialect.units[0]
    texts = data.draw(st.lists(shown(dialect), min_size=2, max_size=2))
    first, second = (dialect.compose(text, unit, dialect.channel) for text in texts)
    both = first + second
    whole = readings(dialect, both)
    assert [reading.text for reading in whole] == texts
    for at in range(len(both)):
        assert readings(dialect, both[:at], both[at:]) == whole
    assert readings(dialect, *(both[at : at + 1] for at in range(len(both)))) == whole
    assert readings(dialect, b"\0\n" + first + b"\0\n" + second) == whole
    assert readings(dialect, b"x" * 500 + first + second) == whole[1:]
    assert readings(dialect, first.rstrip(b"\r\n") + second) == []


@every_dialect
@examples(25)
@given(data=st.data())
def test_no_part_of_a_frame_is_a_frame(dialect: Dialect, data: st.DataObject) -> None:
    text = data.draw(shown(dialect))
    line = dialect.compose(text, dialect.units[0], dialect.channel).rstrip(b"\r\n")
    for start in range(len(line) + 1):
        for end in range(start, len(line)):
            part = line[:start] + line[end:] if start else line[end + 1 :]
            for reading in readings(dialect, part + b"\r\n") if part != line else ():
                # Only an optional end, such as the unit, can be missing.
                assert reading.text == text


@every_dialect
@examples(25)
@given(data=st.data())
def test_a_byte_with_bit_8_is_never_read(dialect: Dialect, data: st.DataObject) -> None:
    line = bytearray(dialect.compose(data.draw(shown(dialect)), dialect.units[0], dialect.channel))
    at = data.draw(st.integers(0, len(line) - len(dialect.terminator)))
    line[at] |= 0x80
    accepted = readings(dialect, bytes(line))
    assert bool(accepted) is dialect.bit_8_undefined


@every_dialect
@examples(25)
@given(data=st.data())
def test_a_wrong_parity_is_told_and_never_read(dialect: Dialect, data: st.DataObject) -> None:
    if dialect.bit_8_undefined:
        pytest.skip("the source leaves bit 8 undefined: it is not looked at")
    frame = dialect.compose(data.draw(shown(dialect)), dialect.units[0], dialect.channel)
    events = Decoder(dialect).feed(bytes(b | (b.bit_count() % 2) << 7 for b in frame))
    assert events
    assert {type(event) for event in events} == {Garbage}
    assert "7E2 read as 8N1" in events[0].reason


HOSTILE = [
    b"911", b"912", b"ERR0", b"ERR3", b"OV", b"Error", b"  Error ", b"HELP", b"OL", b"--------",
    b"3", b"SY235.1", b"+EE.EEE", b"M0,+EE.EEE", b"E", b"nan", b"+inf", b"-1e5", b"1_0", b"0x1F",
    b"+001,234", b"01A+0000,123", b"GN01,+0016,2345", b"+  2,1380, MM", b"3 TO 999999.99 mm",
    b"6FFF001234541", b"7FFF801234541", b"FFFFFFFFFFFFF", b"GX01,+0016.2345", b"N2y:E3", b"?",
    b"# Error reading from instrument: -1", "+٠٠١.٢٣٤".encode(), "+001．234".encode(),
    "−001.234".encode(), "+001.234 µm".encode(), "+001.234\u2028".encode(), b"+-01.234",
    b"++01.234", b"+001.2.34", b"+001234", b".", b"+", b"+.", b" ", b"M1, 000.000",
]  # fmt: skip


@every_dialect
def test_a_fault_or_a_foreign_number_is_no_reading(dialect: Dialect) -> None:
    assert [line for line in HOSTILE if readings(dialect, line + b"\r\n")] == []


@every_dialect
@examples(25)
@given(data=st.binary(max_size=400), cut=st.integers(0, 400))
def test_any_bytes_give_events_and_no_exception(dialect: Dialect, data: bytes, cut: int) -> None:
    decoder = Decoder(dialect)
    events = [*decoder.feed(data[:cut]), *decoder.feed(data[cut:])]
    assert events == Decoder(dialect).feed(data)
    assert all(len(event.raw) <= dialect.longest_frame for event in events)


@every_dialect
@examples(25)
@given(data=st.data())
def test_a_line_of_the_grammars_own_bytes_gives_strict_numbers(
    dialect: Dialect, data: st.DataObject
) -> None:
    frame = dialect.compose(data.draw(shown(dialect)), dialect.units[0], dialect.channel)
    line = data.draw(st.lists(st.sampled_from(frame), max_size=2 * len(frame)).map(bytes))
    for reading in readings(dialect, line + b"\r"):
        assert STRICT.fullmatch(reading.text)


@every_dialect
def test_a_value_that_the_display_cannot_show_is_refused(dialect: Dialect) -> None:
    unit, channel = dialect.units[0], dialect.channel
    for text in ("", "+1.234", "1,234", "nan", "1e3", "١.٢٣٤", "1.234567890123", "9" * 20):
        with pytest.raises(UsageError):
            dialect.compose(text, unit, channel)
    with pytest.raises(UsageError):
        dialect.compose("1." + "0" * dialect.decimals[0], "furlong", channel)


@every_dialect
def test_a_dialect_says_where_it_comes_from(dialect: Dialect) -> None:
    assert dialect.source
    assert dialect.instruments
    assert dialect.answer_time_s > 0
    assert dialect.confidence == "high" or dialect.unverified
    assert dialect.channel is None or dialect.channel in dialect.channels


# Port, request and modem lines as the manuals give them: serial settings cannot be tried on a
# pseudo-terminal, so they are held here.
SETTINGS = {
    "cdi-starrett-iq": ("9600 8N1", b"R\r"),
    "digimatic-hex": ("9600 8N1", None),
    "generic": ("9600 8N1", None),
    "heidenhain-nd": ("9600 7E2", b"\x02"),
    "keyence-dlrs1a": ("9600 8N1", b"SR,00,002\r\n"),
    "keyence-dlrs1a-gt70a": ("9600 8N1", b"SR,00,002\r\n"),
    "magnescale": ("9600 8N1", b"R\r\n"),
    "magnescale-lt20a": ("9600 8N1", b"R\r\n"),
    "magnescale-mg80": ("9600 8N1", None),
    "maxum": ("9600 8N1", None),
    "metro-mux": ("9600 8N1", b"1"),
    "millimar": ("9600 7E2", b"M1?\r"),
    "millimar-c1240": ("4800 7E2", b"?\r"),
    "mitutoyo-idh": ("9600 8N1", b"GA01\r\n"),
    "mitutoyo-mux": ("9600 8N1", b"1\r"),
    "mitutoyo-uwave": ("57600 8N1", None),
    "mux24": ("9600 8N1", b"1"),
    "opto-rs232": ("4800 7E2", b"?\r"),
    "opto-rs232-ibr": ("4800 7E2", b"?\r"),
    "opto-rs232-simplex": ("4800 7E2", None),
    "opto-rs232-tesa": ("4800 7E2", b"?\r"),
    "opto-rs232-trimos": ("4800 7E2", b"?\r"),
    "starrett-spc": ("1200 8N2", None),
    "stream-4800": ("4800 8N1", None),
}


def test_settings_and_requests_are_those_of_the_manuals() -> None:
    assert {d.key: (str(d.line), d.request) for d in DIALECTS} == SETTINGS


def test_the_opto_cables_are_powered_as_their_manuals_say() -> None:
    duplex, simplex = find_dialect("opto-rs232"), find_dialect("opto-rs232-simplex")
    assert (duplex.line.dtr, duplex.line.rts) == (True, False)
    assert duplex.request_line is None
    assert (simplex.line.dtr, simplex.line.rts) == (True, True)
    assert isinstance(simplex.request_line, LinePulse)
    assert (simplex.request_line.line, simplex.request_line.level) == ("dtr", False)
    assert 0.11 <= simplex.request_line.seconds < 0.5
    assert find_dialect("mux24").line.dtr is True


def test_units_are_stated_only_where_every_frame_states_them() -> None:
    stating = {dialect.key for dialect in DIALECTS if dialect.sends_unit}
    assert stating >= {
        "cdi-starrett-iq", "digimatic-hex", "generic", "heidenhain-nd", "maxum", "metro-mux",
        "millimar", "millimar-c1240", "mux24", "starrett-spc",
    }  # fmt: skip
    assert stating.isdisjoint({"opto-rs232", "mitutoyo-mux", "keyence-dlrs1a", "stream-4800"})
    assert find_dialect("opto-rs232").unit_request == b"UNI?\r"


def test_a_low_battery_is_said() -> None:
    events = Decoder(find_dialect("opto-rs232")).feed(b"BAT1\rBAT0\rMM RES2 REF1 KEY1 B0\r")
    assert [getattr(event, "message", "").endswith("battery low") for event in events] == [
        False,
        True,
        True,
    ]


def test_options_of_a_gauge_replace_settings_and_channel() -> None:
    idh = find_dialect("mitutoyo-idh").configure(
        baud=4800, data_bits=7, parity="O", stop_bits=2, channel="07"
    )
    assert idh.line == LineSettings(4800, 7, "O", 2)
    assert idh.request == b"GA07\r\n"
    assert [r.channel for r in readings(idh, b"GN01,+0016.2345\r\nGN07,+0016.2345\r\n")] == ["07"]
    assert find_dialect("mitutoyo-idh").configure() == find_dialect("mitutoyo-idh")


@pytest.mark.parametrize(
    ("key", "options", "named"),
    [
        ("mitutoyo-mux", {"channel": "12"}, "1, 2, 3"),
        ("mitutoyo-uwave", {"channel": "1"}, "0000, 0001"),
        ("cdi-starrett-iq", {"channel": "1"}, "none"),
        ("cdi-starrett-iq", {"baud": 0}, "baud"),
        ("cdi-starrett-iq", {"data_bits": 9}, "data bits"),
        ("cdi-starrett-iq", {"parity": "M"}, "parity"),
        ("cdi-starrett-iq", {"stop_bits": 3}, "stop bits"),
    ],
)
def test_an_impossible_option_is_refused(key: str, options: dict[str, object], named: str) -> None:
    with pytest.raises(UsageError) as caught:
        find_dialect(key).configure(**options)  # type: ignore[arg-type]
    assert named in f"{caught.value.what} {caught.value.remedy}"
    assert len(caught.value.remedy) < 200


def test_an_unknown_key_is_answered_with_the_known_ones() -> None:
    with pytest.raises(UsageError) as caught:
        find_dialect("opto-rs323")
    assert "did you mean opto-rs232?" in caught.value.remedy
    assert all(dialect.key in caught.value.remedy for dialect in DIALECTS)
