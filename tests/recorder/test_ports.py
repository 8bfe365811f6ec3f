"""Ports: recorded streams, simulations, identity, settings before opening, URLs, gauge options."""

import math
import socket
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import serial
from serial import rfc2217

from scara_iso.base.errors import DataError, InstrumentError, NoInputError, UsageError
from scara_iso.commands import main
from scara_iso.commands.shared.options import pairs_in, parse_pairs
from scara_iso.effects import Conditions
from scara_iso.rawfile import encode, read_records
from scara_iso.rawfile.integrity import decode_record
from scara_iso.recorder.indicators import (
    Decoder,
    LineSettings,
    Reading,
    find_dialect,
    find_dialects,
)
from scara_iso.recorder.plan import check_metadata, parse_gauge, parse_gauges
from scara_iso.recorder.ports import choose_clock, device as identity, open_port
from scara_iso.recorder.ports.device import DevicePort, refuse_same_device
from scara_iso.recorder.ports.port import Clock, StreamClock
from scara_iso.recorder.ports.replay import ReplayPort
from scara_iso.recorder.ports.simulated import MODEL_CYCLES, SimulatedPort
from scara_iso.robot.model_file import read_model
from scara_iso.robot.prediction import simulate

OPTO = find_dialect("opto-rs232")


def listen(port, clock, seconds):
    """Return what arrives, with its time."""
    heard = []
    while clock.now() < seconds:
        while data := port.read():
            heard.append((round(clock.now(), 6), data))
        clock.idle(seconds)
    return heard


def replay(path, clock, *, asked=False, dialect=OPTO, axis="X"):
    return ReplayPort(f"replay:{path}", dialect, axis=axis, clock=clock, asked=asked)


def test_a_file_of_bytes_comes_line_by_line(tmp_path):
    path = tmp_path / "stream"
    path.write_bytes(b"\x00+001.234\r+001.235\r\n\n-000.018\rhalf")
    clock = StreamClock(paced=False)
    port = replay(path, clock)
    heard = listen(port, clock, 10)
    assert b"".join(data for _, data in heard) == path.read_bytes()
    assert heard[0] == (1.0, b"\x00+001.234\r")
    assert port.ended


def test_a_file_of_bytes_answers_each_request_with_a_line(tmp_path):
    path = tmp_path / "stream"
    path.write_bytes(b"+001.234\r+001.235\r")
    clock = StreamClock(paced=False)
    port = replay(path, clock, asked=True)
    assert listen(port, clock, 1) == []
    port.write(b"?\r")
    port.write(b"SET?\r")
    assert listen(port, clock, 2) == [(1.02, b"+001.234\r")]
    assert not port.ended
    port.write(b"?\r")
    assert listen(port, clock, 3) == [(2.02, b"+001.235\r")]
    assert port.ended


SESSION = {
    "event": "session",
    "t": 0.0,
    "gauges": {
        "X": {"dialect": "opto-rs232", "unit": "mm", "simulated": True},
        "Y": {"dialect": "opto-rs232", "unit": None, "simulated": False},
    },
}


def tape(path, *records):
    path.write_bytes(b"".join(map(encode, [SESSION, *records])))
    return path


def reading(t, cycle, text, axis="X"):
    """Return the records of a reading: half a frame, the rest of it, and what is stored of it."""
    head, tail = f"+00{text}"[:5].encode(), f"+00{text}\r"[5:].encode()
    came = [{"event": "in", "t": t, "axis": axis, "hex": part.hex()} for part in (head, tail)]
    stored = {"event": "stored", "t": t, "cycle": cycle, "axis": axis, "text": text, "unit": "mm",
              "at": t}  # fmt: skip
    return [*came, stored]


def test_a_raw_file_gives_its_readings_at_their_times(tmp_path):
    path = tape(
        tmp_path / "r.raw.jsonl",
        *reading(0.6, 1, "1.234"), *reading(0.7, 1, "9.999", "Y"),
        {"event": "in", "t": 0.8, "axis": "X", "hex": b"+007.777\r".hex()},  # not taken
        SESSION, *reading(0.5, 2, "1.235"),
    )  # fmt: skip
    clock = StreamClock(paced=False)
    port = replay(path, clock)
    assert (port.unit, port.simulated) == ("mm", True)
    assert listen(port, clock, 5) == [(0.6, b"+001.234\r"), (1.3, b"+001.235\r")]
    assert port.ended


def test_a_raw_file_answers_each_request_with_a_reading(tmp_path):
    path = tape(tmp_path / "r.raw.jsonl", *reading(1.0, 1, "1.234"), *reading(3.0, 2, "1.235"))
    clock = StreamClock(paced=False)
    port = replay(path, clock, asked=True)
    for text in (b"+001.234\r", b"+001.235\r"):
        start = clock.now()
        port.write(b"UNI?\r")
        port.write(b"?\r")
        assert listen(port, clock, start + 1) == [(start + 0.02, text)]
    assert port.ended


def test_a_gauge_that_was_not_recorded_is_refused(tmp_path):
    path = tape(tmp_path / "r.raw.jsonl", *reading(0.5, 1, "1.234"))
    with pytest.raises(UsageError, match="no gauge Z"):
        replay(path, StreamClock(paced=False), axis="Z")
    other = replay(f"{path}?gauge=X", StreamClock(paced=False), axis="Z")
    assert not other.ended


def test_an_empty_or_missing_stream_is_refused(tmp_path):
    (tmp_path / "empty").write_bytes(b"")
    with pytest.raises(DataError):
        replay(tmp_path / "empty", StreamClock(paced=False))
    with pytest.raises(NoInputError):
        replay(tmp_path / "missing", StreamClock(paced=False))


@pytest.mark.parametrize("key", sorted(find_dialects()))
def test_every_dialect_is_simulated_and_reads_back(key):
    dialect, clock = find_dialect(key), StreamClock(paced=False)
    asked = dialect.request is not None or dialect.request_line is not None
    port = SimulatedPort("sim:", dialect, axis="X", clock=clock, asked=asked)
    heard = b""
    for k in range(5):
        if dialect.request is not None:
            port.write(dialect.request)
        elif dialect.request_line is not None:
            port.pulse(dialect.request_line)
        heard += b"".join(data for _, data in listen(port, clock, 1.0 * (k + 1)))
    events = Decoder(dialect).feed(heard)
    values = [event.value for event in events if isinstance(event, Reading)]
    assert len(values) >= 4
    assert all(0.1 < value < 1.0 for value in values)
    assert not [event for event in events if type(event).__name__ == "Garbage"]


def simulated(address, axis="X", source=None):
    clock = StreamClock(paced=False)
    port = SimulatedPort(address, OPTO, axis=axis, clock=clock, asked=False, source=source)
    return b"".join(data for _, data in listen(port, clock, 10))


def test_a_simulation_is_the_same_every_time_and_differs_by_seed_and_axis():
    assert simulated("sim:") == simulated("sim:")
    assert len({simulated("sim:"), simulated("sim:?seed=1"), simulated("sim:", "Y")}) == 3


def test_a_simulation_shows_what_its_source_says():
    assert simulated("sim:", source=lambda k: k / 1000).startswith(b"+000.000mm\r+000.001mm\r")
    assert simulated("sim:?unit=inch", source=lambda k: 25.4).startswith(b"+001.000in\r")


def test_a_simulation_shows_what_a_model_predicts():
    model = Path(__file__).parents[2] / "examples" / "fum_scara.toml"
    heard = simulated(f"sim:?model={model}")
    values = [float(e.text) for e in Decoder(OPTO).feed(heard)]
    rng = np.random.default_rng(0)
    conditions = Conditions(np.arange(1, MODEL_CYCLES + 1), {})
    predicted = simulate(read_model(model), conditions, rng=rng).axes["X"].readings
    assert values == pytest.approx(predicted[: len(values)], abs=0.0005)
    with pytest.raises(UsageError, match="no axis X in deg"):
        simulated(f"sim:?unit=deg&model={model}")


@pytest.mark.parametrize(
    "address",
    [
        "sim:?speed=1",
        "sim:?seed=x",
        "sim:?scatter=-1",
        "sim:?every=nan",
        "sim:?every=1e-9",
        "sim:what",
        "sim:?",
    ],
)
def test_a_strange_simulation_is_refused(address):
    with pytest.raises(UsageError):
        simulated(address)


def test_a_simulated_display_shows_no_unit_that_its_make_lacks():
    with pytest.raises(UsageError, match="heidenhain-nd cannot show deg"):
        simulated("sim:heidenhain-nd?unit=deg")


@pytest.mark.parametrize(
    ("addresses", "kind"),
    [(["sim:", "replay:x"], StreamClock), (["sim:", "/dev/ttyUSB0"], Clock)],
)
def test_only_sessions_without_a_cable_have_a_time_of_their_own(addresses, kind):
    assert isinstance(choose_clock(addresses), kind)


class Fake(serial.Serial):
    """A port that notes its settings when it is opened."""

    def open(self):
        self.at_open = (
            self.baudrate, self.bytesize, self.parity, self.stopbits, self.dtr, self.rts,
            self.exclusive, self.timeout,
        )  # fmt: skip
        raise self.fail


@pytest.mark.parametrize(
    ("key", "expected"),
    [
        ("opto-rs232", (4800, 7, "E", 2, True, False, True, 0)),
        ("opto-rs232-simplex", (4800, 7, "E", 2, True, True, True, 0)),
        ("mitutoyo-mux", (9600, 8, "N", 1)),
        ("heidenhain-nd", (9600, 7, "E", 2)),
        ("starrett-spc", (1200, 8, "N", 2)),
    ],
)
def test_settings_and_modem_lines_are_set_before_opening(monkeypatch, key, expected):
    made = []

    def fake(address, do_not_open):
        assert do_not_open
        made.append(Fake())
        made[0].fail = serial.SerialException(2, "not there")
        return made[0]

    monkeypatch.setattr(serial, "serial_for_url", fake)
    with pytest.raises(InstrumentError) as caught:
        open_port("COM9", find_dialect(key), axis="X", clock=Clock(), asked=True)
    assert made[0].at_open[: len(expected)] == expected
    assert "scara-iso ports" in caught.value.remedy


@pytest.mark.parametrize(
    "error",
    [serial.SerialException("gone"), OSError(5, "I/O"), TypeError("NoneType"), "termios"],
)
@pytest.mark.parametrize("call", ["read", "write", "pulse"])
@pytest.mark.usefixtures("loop")
def test_every_kind_of_loss_is_an_instrument_error(monkeypatch, error, call):
    if error == "termios":
        error = pytest.importorskip("termios").error(5, "I/O")
    port = DevicePort("loop", LineSettings())

    def fail(*_):
        raise error

    class Lost:
        read = write = close = fail

        def __setattr__(self, name, value):
            fail()

    port._serial = Lost()
    calls = {
        "read": port.read,
        "write": lambda: port.write(b"?"),
        "pulse": lambda: port.pulse(find_dialect("opto-rs232-simplex").request_line),
    }
    with pytest.raises(InstrumentError) as caught:
        calls[call]()
    assert caught.value.exit_code == 69
    assert "another program" in caught.value.remedy
    port.close()


def test_hardware_that_cannot_do_the_settings_is_said(monkeypatch):
    termios = pytest.importorskip("termios")
    monkeypatch.setattr(serial.Serial, "open", lambda _: (_ for _ in ()).throw(
        termios.error(22, "Invalid argument")))  # fmt: skip
    with pytest.raises(InstrumentError) as caught:
        DevicePort("/dev/ttyS0", OPTO.line)
    assert "4800 7E2" in caught.value.remedy


def test_a_missing_device_and_a_strange_url_are_refused():
    with pytest.raises(InstrumentError):
        DevicePort("/dev/ttyNOTTHERE", OPTO.line)


@pytest.mark.parametrize(
    "address",
    [
        "spy://loop://?file=HERE", "spy:///dev/null?file=HERE", "alt://loop://?class=PosixPollSerial",
        "hwgrep://(((", "hwgrep://.", "loop://", "cp2110://0", "gopher://x", "", " ",
        "socket://127.0.0.1:1?logging=debug", "rfc2217://127.0.0.1:1?ign_set_control",
        "socket://127.0.0.1:99999", "socket://user@host:1", "socket://h:1/HERE", "socket://",
        "file:HERE", "/dev/tty\0S0", "/dev/tty\x1b[2J", "SPY://loop://?file=HERE",
    ],
)  # fmt: skip
def test_a_port_is_what_the_list_of_kinds_holds_and_nothing_else(tmp_path, monkeypatch, address):
    reached = []
    monkeypatch.setattr(serial, "serial_for_url", lambda *a, **k: reached.append((a, k)))
    with pytest.raises(UsageError, match="no such kind"):
        DevicePort(address.replace("HERE", str(tmp_path / "f")), OPTO.line)
    assert reached == []
    assert list(tmp_path.iterdir()) == []


def test_a_port_is_no_file(tmp_path):
    (tmp_path / "notes").write_text("mine")
    with pytest.raises(InstrumentError, match="not a serial device"):
        DevicePort(str(tmp_path / "notes"), OPTO.line)
    assert (tmp_path / "notes").read_text() == "mine"


@pytest.fixture
def loop(monkeypatch):
    """Let the next device be a line that gives back what is sent."""
    made = serial.serial_for_url("loop://", do_not_open=True)
    monkeypatch.setattr(serial, "serial_for_url", lambda *_, **__: made)


@pytest.mark.usefixtures("loop")
def test_loop_gives_back_what_is_sent():
    port = DevicePort("loop", LineSettings())
    assert port.read() == b""
    port.write(b"+001.234\r")
    assert port.read() == b"+001.234\r"
    port.close()


def test_socket_reads_and_sees_the_peer_go():
    server = socket.create_server(("127.0.0.1", 0))

    def serve():
        peer, _ = server.accept()
        peer.recv(16)
        peer.sendall(b"+001.234\r")
        peer.close()

    thread = threading.Thread(target=serve)
    thread.start()
    port = DevicePort(f"socket://127.0.0.1:{server.getsockname()[1]}", LineSettings())
    theirs = port._serial._socket  # which pyserial 3.5 leaves open where the peer went first
    port.write(b"?\r")
    heard = b""
    with pytest.raises(InstrumentError):  # noqa: PT012 - what came before the end counts
        for _ in range(1000):
            heard += port.read()
            Clock().idle(1)
    assert heard == b"+001.234\r"
    port.close()
    theirs.close()
    thread.join()
    server.close()


def test_a_wait_that_is_over_takes_no_time(monkeypatch):
    slept = []
    monkeypatch.setattr(time, "sleep", slept.append)
    Clock().idle(-math.inf)
    assert sum(slept) == 0


def serve_rfc2217(server, backend):
    """Give a port to one client, as a serial server does; end when it goes."""
    peer, _ = server.accept()
    peer.settimeout(0.01)
    manager = rfc2217.PortManager(backend, SimpleNamespace(write=peer.sendall))
    with peer:
        while True:
            if data := backend.read(backend.in_waiting):
                peer.sendall(b"".join(manager.escape(data)))
            try:
                heard = peer.recv(1024)
            except TimeoutError:
                continue
            if not heard:
                return
            backend.write(b"".join(manager.filter(heard)))


@pytest.mark.filterwarnings("ignore:set:DeprecationWarning")  # setDaemon, setName: pyserial 3.5
def test_settings_reach_a_serial_server():
    backend = serial.serial_for_url("loop://", timeout=0)
    server = socket.create_server(("127.0.0.1", 0))
    thread = threading.Thread(target=serve_rfc2217, args=(server, backend))
    thread.start()
    port = DevicePort(f"rfc2217://127.0.0.1:{server.getsockname()[1]}", OPTO.line)
    theirs = port._serial._socket
    settings = backend.get_settings()
    port.write(b"+001.234\r")
    heard, clock = b"", Clock()
    while len(heard) < 9 and clock.now() < 5:
        heard += port.read()
        clock.idle(5)
    port.close()
    theirs.close()
    thread.join()
    server.close()
    assert heard == b"+001.234\r"
    assert (settings["baudrate"], settings["bytesize"]) == (4800, 7)
    assert (settings["parity"], settings["stopbits"]) == ("E", 2)


def ports(monkeypatch, *found):
    monkeypatch.setattr(identity, "list_devices", lambda: found)


@pytest.mark.skipif(sys.platform == "win32", reason="device names of Linux")
def test_one_device_by_two_names_is_refused(monkeypatch, tmp_path):
    ports(monkeypatch)
    (tmp_path / "tty").write_bytes(b"")
    (tmp_path / "link").symlink_to(tmp_path / "tty")
    with pytest.raises(UsageError, match="X and Y are the same device"):
        refuse_same_device({"X": str(tmp_path / "tty"), "Y": str(tmp_path / "link")})
    with pytest.raises(UsageError):
        refuse_same_device({"X": "/dev/null", "Z": "/dev/../dev/null"})
    with pytest.raises(UsageError):
        refuse_same_device({"X": "socket://host:1", "Y": "socket://HOST:1"})
    refuse_same_device({"X": "/dev/null", "Y": "/dev/zero"})


def test_one_usb_place_under_two_names_is_refused(monkeypatch):
    made = [identity.Device(f"/dev/tty{n}", "CH340", "1a86:7523", None, "1-1.2") for n in "AB"]
    ports(monkeypatch, *made)
    with pytest.raises(UsageError, match="same device"):
        refuse_same_device({"X": "/dev/ttyA", "Y": "/dev/ttyB"})


def test_a_device_is_described_by_its_serial_number_and_place(monkeypatch):
    ports(monkeypatch, identity.Device("/dev/ttyA", "FT232", "0403:6001", "AL02", "1-1.2"))
    line = "/dev/ttyA (usb 0403:6001 serial AL02 location 1-1.2)"
    assert identity.describe("/dev/ttyA") == line


def test_gauge_options_reach_the_dialect():
    spec = parse_gauge(
        r"x=mitutoyo-mux?unit=mm&channel=2&baud=19200&bits=7&parity=e&stop=2&request=%02\r@COM3"
    )
    assert spec.axis == "X"
    assert str(spec.dialect.line) == "19200 7E2"
    assert spec.dialect.channel == "2"
    assert spec.dialect.request == b"\x02\r"
    assert (spec.unit, spec.address) == ("mm", "COM3")


def test_a_port_without_a_driver_may_have_it_found():
    with pytest.raises(UsageError) as refused:
        parse_gauge("y=/dev/ttyUSB0")
    for text, advice in (
        ("y=/dev/ttyUSB0", "write Y=auto@/dev/ttyUSB0 to have"),
        ("y=opto-rs232?unit=mm", "write Y=opto-rs232?unit=mm@PORT, as X=opto-rs232@/dev/ttyUSB0"),
    ):
        with pytest.raises(UsageError) as caught:
            parse_gauge(text)
        assert caught.value.remedy.startswith(advice)
    assert "write Y=auto@/dev/ttyUSB0" in refused.value.remedy


def test_a_unit_for_all_gauges_stays_with_the_gauge():
    spec = parse_gauge("Y=mitutoyo-mux@socket://h:1", unit="inches")
    assert spec.unit == "inch"
    assert parse_gauge(spec.text) == spec


def test_a_pattern_makes_a_dialect():
    spec = parse_gauge(r"Z=generic?pattern=(?P<value>[+-]\d\.\d+)&unit=mm@COM1")
    assert spec.dialect.parse(b"+1.25")[0].text == "1.25"
    assert parse_gauge(spec.text).dialect.source == spec.dialect.source
    scaled = parse_gauge("X=mitutoyo-mux@COM1", unit="0.01 mm")
    assert parse_gauge(scaled.text) == scaled


@pytest.mark.parametrize(
    "text",
    [
        "", "X", "X=opto-rs232", "X@COM1", "W=opto-rs232@COM1", "X=unknown@COM1", "X=opto-rs232@",
        "X=opto-rs232?speed=1@COM1", "X=opto-rs232?baud=fast@COM1", "X=opto-rs232?parity=Q@COM1",
        "X=opto-rs232?unit=parsec@COM1", "X=opto-rs232?channel=7@COM1", "X=opto-rs232?baud=1@COM1",
        "X=opto-rs232?pattern=x@COM1", "X=generic?pattern=(@COM1", "X=opto-rs232?bits=²@COM1",
        r"X=opto-rs232?request=\xZZ@COM1", "X=opto-rs232?unit=mm&unit=inch@COM1",
    ],
)  # fmt: skip
def test_a_gauge_that_cannot_be_meant_is_refused(text):
    with pytest.raises(UsageError):
        parse_gauge(text)


def test_two_gauges_for_one_axis_or_none_are_refused():
    with pytest.raises(UsageError, match="two gauges for X"):
        parse_gauges(["X=opto-rs232@a", "x=opto-rs232@b"])
    with pytest.raises(UsageError, match="no indicator"):
        parse_gauges([])


def test_metadata_by_options_and_file(tmp_path):
    path = tmp_path / "m.toml"
    path.write_text('robot = "FUM SCARA"\npayload_kg = 2.5\nwarm = true\nday = 2026-11-21\n')
    assert pairs_in(path) == {
        "robot": "FUM SCARA", "payload_kg": "2.5", "warm": "true", "day": "2026-11-21",
    }  # fmt: skip
    assert parse_pairs(["operator = A=B "]) == {"operator": "A=B"}


@pytest.mark.parametrize(
    "text", ["robot", "unit=inch", "resolution_Y=1", "=x", "a:b=1", "\n=1", "robot=" + "x" * 60_000]
)
def test_metadata_that_would_change_the_table_is_refused(text):
    with pytest.raises(UsageError):
        check_metadata(parse_pairs([text]))


@pytest.mark.parametrize("text", [b"robot = ", b"[robot]\nname='x'", b"a=[1]", b"\xff"])
def test_a_file_that_is_no_metadata_is_refused(tmp_path, text):
    (tmp_path / "m.toml").write_bytes(text)
    with pytest.raises(DataError):
        pairs_in(tmp_path / "m.toml")


def test_a_line_proves_itself_whole(tmp_path):
    line = encode({"event": "in", "t": 1.5, "hex": "00"})
    assert decode_record(line) == {"event": "in", "t": 1.5, "hex": "00"}
    assert decode_record(line[:-1]) is not None
    for k in range(len(line) - 1):
        assert decode_record(line[:k]) is None
        for bit in range(8):
            damaged = line[:k] + bytes([line[k] ^ 1 << bit]) + line[k + 1 :]
            assert decode_record(damaged) is None, damaged


def test_a_line_without_end_takes_bounded_memory(tmp_path):
    path = tmp_path / "x.raw.jsonl"
    path.write_bytes(b"x" * (3 << 20))
    assert [record for _, record in read_records(path)] == [None, None, None]


def test_nan_never_enters_a_raw_file():
    with pytest.raises(ValueError, match="JSON"):
        encode({"event": "in", "t": float("nan")})


@pytest.mark.parametrize(
    ("sent", "said"),
    [(b"1 MW+003.4665 inch\r\n", "3.4665 inch (channel 1)"), (b"+003.4665\r", "3.4665 ")],
)
def test_a_probe_names_the_channel_where_a_frame_has_one(sent, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("stream").write_bytes(2 * sent)
    assert main(["ports", "--probe", "replay:stream"]) == 0
    out = capsys.readouterr().out
    assert said in out
    assert ("channel" in out) is ("channel" in said)


@pytest.mark.parametrize("scatter", ["-1", "1e10", "nan", "fast"])
def test_an_option_of_a_port_that_is_no_number_is_refused(scatter):
    with pytest.raises(UsageError, match=f"scatter={scatter} is not a number of zero or more"):
        open_port(
            f"sim:?scatter={scatter}", OPTO, axis="X", clock=StreamClock(paced=False), asked=False
        )
