"""What a dialect states of port, request, unit and channel, and what a user may change of it."""

from decimal import Decimal
from itertools import pairwise

import pytest
from hypothesis import given, strategies as st

from scara_iso.base.errors import UsageError
from scara_iso.recorder.indicators import (
    Decoder,
    DeviceNotice,
    Dialect,
    Garbage,
    InstrumentFault,
    LinePulse,
    LineSettings,
    Reading,
    diagnose_parity,
    find_dialect,
)

MUX = find_dialect("mitutoyo-mux")
OPTO = find_dialect("opto-rs232")


@pytest.mark.parametrize(
    ("text", "decimals", "resolution"),
    [("-12.340", 3, "0.001"), ("7", 0, "1"), ("0.5", 1, "0.1"), ("0.000001", 6, "0.000001")],
)
def test_a_reading_is_as_fine_as_its_last_digit(text: str, decimals: int, resolution: str) -> None:
    reading = Reading(text, "mm", None, None, b"")
    assert reading.value == Decimal(text)
    assert reading.decimals == decimals
    assert reading.resolution == Decimal(resolution)


def test_a_line_that_states_nothing_more_is_no_unit_and_no_start() -> None:
    notice = DeviceNotice("BAT1", b"BAT1")
    assert (notice.unit, notice.switched_on) == (None, False)
    assert InstrumentFault("ERR1", "", b"").channel is None


def test_a_port_is_9600_8n1_unless_it_is_told() -> None:
    line = LineSettings()
    assert str(line) == "9600 8N1"
    assert (line.dtr, line.rts) == (None, None)
    assert str(LineSettings(4800, 7, "E", 2)) == "4800 7E2"


@pytest.mark.parametrize(
    "settings",
    [(50,), (4_000_000,), (9600, 7), (9600, 8, "O"), (9600, 8, "E"), (9600, 8, "N", 2)],
)
def test_settings_that_ports_have_are_taken(settings: tuple[object, ...]) -> None:
    LineSettings(*settings)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("settings", "wrong"),
    [
        ((49,), "baud"), ((4_000_001,), "baud"), ((9600, 6), "data bits"),
        ((9600, 9), "data bits"), ((9600, 8, "M"), "parity"), ((9600, 8, "N", 0), "stop bits"),
        ((9600, 8, "N", 3), "stop bits"),
        ((0, 5, "X", 9), "baud, data bits, parity, stop bits"),
    ],
)  # fmt: skip
def test_settings_that_no_port_has_are_refused_all_at_once(
    settings: tuple[object, ...], wrong: str
) -> None:
    with pytest.raises(UsageError) as refused:
        LineSettings(*settings)  # type: ignore[arg-type]
    assert refused.value.what == f"serial line: {wrong} out of range"


def test_a_request_names_the_channel_that_is_asked() -> None:
    assert MUX.configure(channel="2").request == b"2\r"
    assert OPTO.request == b"?\r"
    assert find_dialect("opto-rs232-simplex").request is None


def bare(**fields: object) -> Dialect:
    stated = {
        "key": "bare", "instruments": "", "line": LineSettings(), "parse": lambda line: (),
        "compose": lambda text, unit, channel: b"", "longest_frame": 9, "digits": 6,
        "decimals": (3,), "units": ("mm",), "source": "", "confidence": "low",
    } | fields  # fmt: skip
    return Dialect(**stated)  # type: ignore[arg-type]


def test_a_dialect_that_states_no_more_asks_nothing_and_sends_lines_that_end_in_cr() -> None:
    dialect = bare()
    assert dialect.terminator == b"\r"
    assert (dialect.request, dialect.request_line, dialect.unit_request) == (None, None, None)
    assert (dialect.channels, dialect.channel, dialect.unverified) == ((), None, ())
    assert dialect.answer_time_s == 1.0
    assert not dialect.bit_8_undefined
    assert dialect.fixed_decimals


def test_a_request_without_a_channel_leaves_its_place_empty() -> None:
    assert bare(request_template=b"D{channel}\r").request == b"D\r"
    assert bare(request_template=b"D{channel}\r", channel="07").request == b"D07\r"


@pytest.mark.parametrize(
    ("units", "sends"), [(("mm", "inch"), True), ((None,), False), (("mm", None), False)]
)
def test_the_user_states_the_unit_where_a_frame_may_be_without(
    units: tuple[str | None, ...], sends: bool
) -> None:
    assert bare(units=units).sends_unit is sends


def test_options_change_what_they_name_and_nothing_else() -> None:
    assert OPTO.configure() == OPTO
    changed = OPTO.configure(baud=9600, data_bits=8, parity="N", stop_bits=1)
    assert changed.line == LineSettings(9600, 8, "N", 1, dtr=True, rts=False)
    assert OPTO.configure(parity="O").line == LineSettings(4800, 7, "O", 2, dtr=True, rts=False)
    assert OPTO.configure(baud=300).key == "opto-rs232"
    with pytest.raises(UsageError, match="data bits"):
        OPTO.configure(data_bits=5)
    with pytest.raises(UsageError, match="baud"):
        OPTO.configure(baud=0)


def test_a_channel_stays_until_another_is_chosen() -> None:
    second = MUX.configure(channel="2")
    assert (MUX.channel, second.channel) != (second.channel, MUX.channel)
    assert second.configure(baud=4800).channel == "2"


@pytest.mark.parametrize(
    ("channels", "known"),
    [
        ((), "none"),
        (("a", "b"), "a, b"),
        (tuple("123456789"), "1, 2, 3, 4, 5, 6, 7, 8, 9"),
        (tuple("123456789x"), "1, 2, 3, 4, 5, 6, 7, 8, 9 ..."),
    ],
)
def test_a_channel_that_is_not_there_is_refused_with_those_that_are(
    channels: tuple[str, ...], known: str
) -> None:
    with pytest.raises(UsageError) as refused:
        bare(channels=channels).configure(channel="z")
    assert refused.value.what == "bare has no channel 'z'"
    assert refused.value.remedy == f"channels: {known}"


@pytest.mark.parametrize(
    "kind",
    [Reading, InstrumentFault, DeviceNotice, Garbage, LineSettings, LinePulse, Dialect],
)
def test_what_was_received_or_set_never_changes(kind: type) -> None:
    assert kind.__dataclass_params__.frozen  # type: ignore[attr-defined]
    assert "__slots__" in vars(kind)


def test_a_dialect_is_stated_by_name_and_shows_no_functions() -> None:
    stated = ("x", "", LineSettings(), OPTO.parse, OPTO.compose, 9, 6, (3,), ("mm",), "", "low")
    with pytest.raises(TypeError, match="positional"):
        Dialect(*stated)  # type: ignore[call-arg,misc]
    assert "<function" not in repr(OPTO)


FRAME = b"01A+0000.123\r"
READING = Reading("0.123", None, "1", None, FRAME[:-1])

pieces = st.lists(
    st.one_of(
        st.sampled_from([FRAME, b"911\r", b"\0", b"\r", b"\n", b"\x8d", b"\x8a", b"0", b"\r\n"]),
        st.binary(max_size=30),
    ),
    max_size=12,
).map(b"".join)


@given(data=pieces, cuts=st.lists(st.integers(0, 400), max_size=6))
def test_events_do_not_depend_on_the_cuts(data: bytes, cuts: list[int]) -> None:
    bounds = [0, *sorted(min(cut, len(data)) for cut in cuts), len(data)]
    one, many = Decoder(MUX), Decoder(MUX)
    whole = one.feed(data)
    parts = [many.feed(data[a:b]) for a, b in pairwise(bounds)]
    assert [event for part in parts for event in part] == whole
    assert one.drop_partial() == many.drop_partial()


def test_the_tail_of_a_line_too_long_is_no_frame() -> None:
    decoder = Decoder(MUX)
    assert decoder.feed(b"x" * 5000) == []
    (event, reading) = decoder.feed(FRAME + FRAME)
    assert event == Garbage("line of 5012 bytes, and no frame has more than 12", b"x" * 12)
    assert reading == READING


def test_a_line_without_end_is_counted_and_not_kept() -> None:
    decoder = Decoder(MUX)
    for _ in range(1000):
        assert decoder.feed(b"y" * 1000) == []
    dropped = decoder.drop_partial()
    assert dropped == Garbage("1000000 bytes of a line that never ended", b"y" * 12)
    assert decoder.feed(FRAME) == [READING]


def test_a_dropped_half_frame_is_not_joined_to_the_next_one() -> None:
    decoder = Decoder(OPTO)
    decoder.feed(b"+012.")
    assert decoder.drop_partial() == Garbage("5 bytes of a line that never ended", b"+012.")
    assert [type(event) for event in decoder.feed(b"345\r+001.234\r")] == [Garbage, Reading]


def test_another_channel_is_noticed_and_not_read() -> None:
    second = MUX.configure(channel="2")
    events = Decoder(second).feed(FRAME + b"911\r921\r02A-0000.001\r")
    assert [type(event) for event in events] == [
        DeviceNotice,
        DeviceNotice,
        InstrumentFault,
        Reading,
    ]
    assert events[0] == DeviceNotice("channel 1 speaks, but was not asked", FRAME[:-1])


# serial.md's table: what 7E2 frames become on an 8N1 port.
@pytest.mark.parametrize(
    "received",
    ["2b3030b12eb233b48d", "2d3030302e30b1b88d", "2b30b1b22e3330358d", "c5d2d2338d"],
)
def test_seven_even_read_as_eight_none_is_named(received: str) -> None:
    raw = bytes.fromhex(received)
    assert "7E2 read as 8N1" in str(diagnose_parity(raw))
    (event,) = Decoder(OPTO).feed(raw)
    assert isinstance(event, Garbage)
    assert event.reason == diagnose_parity(raw)
    assert event.raw == raw


def test_the_diagnosis_fits_or_is_not_made() -> None:
    odd = bytes(byte | (byte.bit_count() + 1) % 2 << 7 for byte in b"+001.234\r")
    assert "7O2 read as 8N1" in str(diagnose_parity(odd))
    assert diagnose_parity(b"+001.234\r") is None
    assert diagnose_parity(b"+001.234\xff\r") is None
    assert diagnose_parity(bytes.fromhex("2b3030b12eb233348d")) is None
    assert diagnose_parity(b"\x81\x82\x84\x88") is None


def test_a_wrong_parity_is_told_even_at_the_longest_frame() -> None:
    raw = bytes(byte | (byte.bit_count() % 2) << 7 for byte in FRAME)
    (event,) = Decoder(MUX).feed(raw)
    assert "7E2 read as 8N1" in getattr(event, "reason", "")
