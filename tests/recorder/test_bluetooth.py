"""Bluetooth indicators against a simulated peer: no instrument and no radio is needed."""

import asyncio
import itertools
import json
import time
from types import SimpleNamespace

import pytest
from hypothesis import given, strategies as st

from scara_iso.base.errors import InstrumentError, UsageError
from scara_iso.commands import main
from scara_iso.recorder.indicators import Decoder, Reading, find_dialect
from scara_iso.recorder.indicators.generic import make_generic
from scara_iso.recorder.ports import bluetooth, open_port
from scara_iso.recorder.ports.bluetooth import COPY_S, SPOILT, Transfers
from scara_iso.recorder.ports.port import Clock, check_address

ADDRESS = "ble:C4:64:E3:00:00:01"
SYLVAC, NORDIC = bluetooth.SERVICES[:2]
OPTO = find_dialect("opto-rs232")


class Peer:
    """An instrument behind bleak's interface: it answers ``?``, splits its texts, and goes away.

    ``split`` is the longest transfer, ``copies`` how often each is handed on, and ``answers`` after
    how many the link is lost.
    """

    def __init__(self, service=SYLVAC, *, split=20, copies=1, answers=10_000, fails=None):
        self.service, self.split, self.copies, self.fails = service, split, copies, fails
        self.left = answers
        self.shown = itertools.count(1)
        self.asked = []
        self.connected = False

    def __call__(self, address, lost):
        assert address == "C4:64:E3:00:00:01"
        self.lost, self.heard = lost, {}
        return self

    @property
    def services(self):
        uuids = [] if self.service is None else [self.service.write, *self.service.notify]
        return [SimpleNamespace(characteristics=[SimpleNamespace(uuid=u.upper()) for u in uuids])]

    async def connect(self):
        if self.fails:
            raise self.fails
        self.connected = True

    async def disconnect(self):
        self.connected = False
        self.lost(self)

    async def start_notify(self, uuid, callback):
        self.heard[uuid] = callback
        self.loop = asyncio.get_running_loop()

    async def write_gatt_char(self, uuid, data, *, response):
        assert (uuid, response) == (self.service.write, False)
        self.asked.append(bytes(data))
        if data == b"UNI?\r":
            self.send(b"MM\r", self.service.notify[-1])
        elif self.left:
            self.left -= 1
            self.send(b"+000.%03d\r" % next(self.shown), self.service.notify[-1])
        else:
            self.lost(self)

    def send(self, text, uuid):
        for start in range(0, len(text), self.split):
            for _ in range(self.copies):
                self.heard[uuid](None, bytearray(text[start : start + self.split]))

    def press(self, text):
        """Send what the DATA key sends, from outside of the loop."""
        self.loop.call_soon_threadsafe(self.send, text, self.service.notify[0])


@pytest.fixture
def plugged(monkeypatch):
    """Return a function that puts a peer where bleak's client is made, and opens a port to it."""
    ports = []

    def open_to(peer, dialect=OPTO):
        monkeypatch.setattr(bluetooth, "bleak_client", peer)
        port = open_port(ADDRESS, dialect, axis="X", clock=Clock(), asked=True)
        ports.append(port)
        return port

    yield open_to
    for port in ports:
        port.close()


def heard(port, count):
    """Return the first bytes, as many, that arrive within five seconds."""
    data, until = b"", time.monotonic() + 5
    while len(data) < count and time.monotonic() < until:
        data += port.read()
        time.sleep(0.001)
    return data


@pytest.mark.parametrize("split", [20, 3, 1])
@pytest.mark.parametrize("service", [SYLVAC, NORDIC])
def test_a_request_is_answered_however_the_text_is_split(plugged, service, split):
    port = plugged(Peer(service, split=split))
    port.write(b"?\r")
    if split > 1:  # byte by byte, 000 may be copies of a transfer: garbage
        assert heard(port, 9) == b"+000.001\r"
    assert service.name in port.identity
    assert port.address == ADDRESS


def test_the_data_key_sends_a_reading(plugged):
    peer = Peer()
    port = plugged(peer)
    peer.press(b"+012.345\r")
    assert heard(port, 9) == b"+012.345\r"


def test_a_lost_link_gives_what_came_before_and_then_says_so(plugged):
    port = plugged(Peer(answers=1))
    port.write(b"?\r")
    assert heard(port, 9) == b"+000.001\r"
    port.write(b"?\r")
    with pytest.raises(InstrumentError, match="link is lost"):
        heard(port, 9)


def test_closing_ends_the_link(plugged):
    peer = Peer()
    plugged(peer).close()
    assert not peer.connected


@pytest.mark.parametrize(
    ("peer", "said"),
    [(Peer(None), "no service of text"), (Peer(fails=OSError("no adapter")), "no adapter")],
)
def test_an_instrument_that_cannot_be_used_is_refused(plugged, peer, said):
    with pytest.raises(InstrumentError, match=said) as caught:
        plugged(peer)
    assert caught.value.remedy


def test_a_cable_that_asks_by_a_line_is_refused(plugged):
    port = plugged(Peer())
    with pytest.raises(UsageError, match="no line dtr"):
        port.pulse(find_dialect("opto-rs232-simplex").request_line)


@pytest.mark.parametrize("address", ["ble:", "ble:12", "ble:C4:64:E3:00:00", "ble:../x", "BLE"])
def test_what_is_no_bluetooth_address(address):
    if address != "BLE":
        with pytest.raises(UsageError):
            check_address(address)
    check_address("ble:0a1b2c3d-0000-1111-2222-333344445555")
    check_address(ADDRESS.lower())


PLAIN = make_generic(r"(?P<value>[+-]?[0-9]+[.][0-9]+)")
TEXT = st.from_regex(rb"[+-]?[0-9]{1,4}\.[0-9]{1,4}\r", fullmatch=True)
SPLITS = st.lists(st.integers(1, 6), min_size=1, max_size=5)


def sent(texts, splits, copies):
    """Return what a decoder reads of texts half a second apart, each in parts of these sizes."""
    transfers, decoder = Transfers(), Decoder(PLAIN)
    found = []
    for k, text in enumerate(texts):
        rest, sizes = text, itertools.cycle(splits)
        while rest:
            size = next(sizes)
            part, rest = rest[:size], rest[size:]
            for _ in range(copies):
                found += decoder.feed(transfers.feed(part, 0.5 * k))
    return [event.raw + b"\r" for event in found if isinstance(event, Reading)]


@given(st.lists(TEXT, min_size=1, max_size=4), SPLITS, st.integers(1, 2))
def test_no_split_and_no_copy_makes_another_reading(texts, splits, copies):
    left = iter(texts)
    assert all(reading in left for reading in sent(texts, splits, copies))


@given(st.lists(TEXT, min_size=1, max_size=4), st.integers(1, 2))
def test_whole_texts_are_read_once_each(texts, copies):
    assert sent(texts, [99], copies) == texts


def test_the_same_reading_later_is_no_copy():
    transfers = Transfers()
    times = [0.0, COPY_S / 2, 1.0]
    assert [transfers.feed(b"+000.001\r", t) for t in times] == [b"+000.001\r", b"", b"+000.001\r"]


def test_a_repeated_transfer_with_an_end_inside_is_garbage():
    transfers = Transfers()
    assert transfers.feed(b"5.0\r1", 0.0) == b"5.0\r1"
    assert transfers.feed(b"5.0\r1", 0.0).startswith(SPOILT)


def test_a_test_goes_on_after_the_link_was_lost(tmp_path, monkeypatch, capsys):
    table = tmp_path / "run.csv"
    words = ["record", str(table), "--gauge", f"X=opto-rs232?unit=mm@{ADDRESS}", "--trigger",
             "timer:0.01", "--cycles", "6", "--json"]  # fmt: skip
    first, second = Peer(answers=3), Peer(copies=2)
    second.shown = itertools.count(4)
    monkeypatch.setattr(bluetooth, "bleak_client", first)
    assert main(words) == 69
    monkeypatch.setattr(bluetooth, "bleak_client", second)
    assert main([*words, "--resume"]) == 0
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    values = [event["value"] for event in events if event["event"] == "stored"]
    assert values == [0.001, 0.002, 0.003, 0.004, 0.005, 0.006]
    assert not first.connected
    assert not second.connected
