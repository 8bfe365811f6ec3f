"""Parity that the line carries, on ports that can tell, and pseudo-terminals, which cannot."""

import os
import sys

import pytest

from scara_iso.recorder.indicators import (
    Decoder,
    Garbage,
    LineSettings,
    Reading,
    find_dialect,
)
from scara_iso.recorder.ports import device
from scara_iso.recorder.ports.device import DevicePort

termios = pytest.importorskip("termios")
OPTO = find_dialect("opto-rs232")


@pytest.fixture
def terminal():
    """Return the name of a pseudo-terminal in raw mode."""
    tty = pytest.importorskip("tty")
    main_end, other = os.openpty()
    tty.setraw(other)
    yield os.ttyname(other)
    os.close(main_end)
    os.close(other)


class Line(device.serial.Serial):
    """A device with a parity; its settings are a list, as those of termios."""

    def open(self):
        pass

    def fileno(self):
        return 99


@pytest.mark.parametrize(("parity", "on"), [("E", True), ("O", True), ("N", False)])
def test_parity_is_checked_where_the_line_has_one(monkeypatch, parity, on):
    cleared = termios.ISTRIP | termios.IGNPAR
    settings = [cleared, 0, termios.PARENB, 0, 0, 0, []]
    monkeypatch.setattr(termios, "tcgetattr", lambda _: settings.copy())
    monkeypatch.setattr(termios, "tcsetattr", lambda _, when, new: settings.__setitem__(0, new[0]))
    monkeypatch.setattr(device, "ioctl", lambda *_: None)
    monkeypatch.setattr(device.serial, "serial_for_url", lambda *a, **k: Line())
    port = DevicePort("/dev/ttyS99", LineSettings(4800, 7 if on else 8, parity, 2))
    wanted = termios.INPCK | termios.PARMRK | termios.IGNBRK
    assert settings[0] == (wanted if on else cleared)
    assert "parity" not in port.identity


@pytest.mark.parametrize("at", range(9))
def test_a_byte_that_the_driver_marked_makes_its_line_garbage(at):
    frame = b"+000.812\r"
    marked = frame[:at] + b"\xff\x00" + bytes([frame[at] ^ 1]) + frame[at + 1 :]
    events = Decoder(OPTO).feed(marked + b"\r" + frame)
    assert [type(event) for event in events] == [Garbage, Reading]


@pytest.mark.skipif(sys.platform != "linux", reason="pseudo-terminals of Linux")
def test_a_pseudo_terminal_opened_again_falls_back_and_says_so(terminal):
    said = []
    for _ in range(3):
        port = DevicePort(terminal, OPTO.line)
        port.close()
        said.append(port.identity)
    assert all("a pseudo-terminal: 4800 7E2 is not set" in identity for identity in said)


def test_hardware_that_cannot_is_still_an_error(monkeypatch):
    class Cannot:
        def __setattr__(self, name, value):
            pass

        def open(self):
            raise termios.error(22, "Invalid argument")

        def close(self):
            pass

    monkeypatch.setattr(device.serial, "serial_for_url", lambda *a, **k: Cannot())
    with pytest.raises(Exception, match="cannot be opened") as caught:
        DevicePort("/dev/ttyS99", OPTO.line)
    assert "another adapter" in caught.value.remedy
