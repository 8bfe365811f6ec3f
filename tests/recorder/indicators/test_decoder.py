"""Bytes in, events out: bounded memory, no tail of a long line, no half frame."""

from itertools import pairwise

import pytest
from hypothesis import given, strategies as st

from scara_iso.recorder.indicators import (
    Decoder,
    DeviceNotice,
    Garbage,
    InstrumentFault,
    Reading,
    diagnose_parity,
    find_dialect,
)

MUX = find_dialect("mitutoyo-mux")
OPTO = find_dialect("opto-rs232")
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
