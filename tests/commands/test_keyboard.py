"""Readings that are typed: what stands on the screen key by key, and what is taken."""

import os

import pytest

from scara_iso.commands.operator.keyboard import Keys, open_keyboard


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
        ("0.8\x1b[D1", "Reading: 0.81", b""),  # an arrow is no key of a reading
    ],
)
def test_a_reading_is_shown_as_it_is_typed_and_taken_at_its_end(keys, shown, taken):
    heard = iter([keys])
    typist = Keys(lambda: next(heard, ""), takes_readings=True)
    assert typist.typed() == taken
    assert typist.prompt() == shown
    assert typist.typed() == b""


@pytest.mark.parametrize("keys", ["\x1bOP", "\x1bOQ", "\x1b[24~", "\x1b[1;5P", "\x1b[[A"])
def test_a_function_key_is_no_command(keys):
    heard = iter([keys])
    assert Keys(lambda: next(heard, "")).poll() is None


def test_a_terminal_that_was_closed_ends_the_session(monkeypatch):
    termios = pytest.importorskip("termios")
    pty = pytest.importorskip("pty")
    master, slave = pty.openpty()
    with os.fdopen(slave) as stream:
        monkeypatch.setattr("sys.stdin", stream)
        with open_keyboard() as read:
            os.write(master, b"v")
            assert read() == "v"
            monkeypatch.setattr("os.read", raises(OSError))
            os.write(master, b"v")
            with pytest.raises(KeyboardInterrupt):
                read()
            monkeypatch.setattr(termios, "tcsetattr", raises(termios.error))
    os.close(master)


def raises(error):
    def fail(*_):
        raise error

    return fail
