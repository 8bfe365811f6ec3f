"""Readings that are typed: what stands on the screen key by key, and what is taken."""

import pytest

from scara_iso.commands.keyboard import Keys


@pytest.mark.parametrize(
    ("keys", "shown", "taken"),
    [
        ("", "", b""),
        ("0", "Reading: 0", b""),
        ("-0.81", "Reading: -0.81", b""),
        ("0.81\x7f2", "Reading: 0.82", b""),
        ("0.81\x1b", "", b""),
        ("0,812\r", "", b"0,812\r"),
        ("0.812\t7", "", b"0.812\r"),  # the next waits its turn
        ("abc", "", b""),
    ],
)
def test_a_reading_is_shown_as_it_is_typed_and_taken_at_its_end(keys, shown, taken):
    heard = iter([keys])
    typist = Keys(lambda: next(heard, ""), takes_readings=True)
    assert typist.typed() == taken
    assert typist.prompt() == shown
    assert typist.typed() == b""
