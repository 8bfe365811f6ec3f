"""`record` that asks, remembers its bench, and finds the dialect of a port."""

import json
import os
import pty
import shlex
import subprocess
import sys
import time
from pathlib import Path

import pytest

from scara_iso import read_table
from scara_iso.base.errors import DataError, InstrumentError, UsageError
from scara_iso.commands import main
from scara_iso.commands.operator import guide
from scara_iso.commands.operator.guide import without_questions
from scara_iso.commands.operator.recording import RecordOptions
from scara_iso.commands.shared.output import say_in_words
from scara_iso.recorder import (
    Detected,
    Device,
    FirstReading,
    RememberedBench,
    detect,
    name_dialects,
    parse_gauges,
    read_bench,
    read_once,
    write_bench,
)
from scara_iso.recorder.ports.port import Port

BENCH = 'trigger = "timer:1"\n[gauges]\nX = "opto-rs232@sim:?pace=0"\n'


class Terminal:
    """The command on a pseudo-terminal, in another process."""

    def __init__(self, folder, *words):
        self._main, terminal = pty.openpty()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "scara_iso", *words], cwd=folder,
            stdin=terminal, stdout=terminal, stderr=terminal,
            env={**os.environ, "TERM": "xterm", "COLUMNS": "80", "LINES": "24",
                 "PYTHONPATH": str(Path(__file__).parents[2])},
        )  # fmt: skip
        os.close(terminal)
        self.seen = ""

    def until(self, text):
        while text not in self.seen:
            more = self._read()
            assert more, self.seen
            self.seen += more
        return self

    def answer(self, question, text=""):
        self.until(question)
        self.seen = self.seen.partition(question)[2]
        os.write(self._main, text.encode() + b"\n")

    def press(self, keys):
        os.write(self._main, keys.encode())

    def end(self):
        while more := self._read():
            self.seen += more
        os.close(self._main)
        return self.process.wait(), self.seen

    def _read(self):
        try:
            return os.read(self._main, 4096).decode("utf-8", "replace")
        except OSError:
            return ""


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def call(*words):
        code = main([*words])
        return code, *capsys.readouterr()

    return call


needs_terminals = pytest.mark.skipif(sys.platform == "win32", reason="needs pseudo-terminals")


@pytest.mark.slow
@needs_terminals
def test_four_questions_record_and_the_next_time_the_name_is_enough(tmp_path, run):
    terminal = Terminal(tmp_path, "record", "--cycles", "2")
    terminal.answer("Axis and port of each indicator", "X=sim:mitutoyo-mux?pace=0")
    terminal.answer("When is a reading taken", "timer:1")
    terminal.answer("File to write", "first")
    code, seen = terminal.end()
    assert code == 0
    assert "speaks mitutoyo-mux" in seen or (tmp_path / "bench.toml").exists()
    line = "scara-iso record first.csv --gauge 'X=mitutoyo-mux@sim:mitutoyo-mux?pace=0' "
    assert f"{line}--trigger timer:1 --cycles 2\n" in seen.replace("\r\n", "\n")
    assert len(read_table(tmp_path / "first.csv")) == 2
    assert read_bench(tmp_path / "bench.toml") == RememberedBench(
        ("X=mitutoyo-mux@sim:mitutoyo-mux?pace=0",), "timer:1"
    )
    code, _, err = run("record", "second.csv", "--cycles", "2")
    assert code == 0
    assert "bench.toml" in err
    assert len(read_table(tmp_path / "second.csv")) == 2


@pytest.mark.slow
@needs_terminals
def test_an_instrument_on_a_cable_is_named_and_a_wrong_answer_asked_again(tmp_path, instrument):
    device = instrument(r"01A+0000.812\r")
    terminal = Terminal(tmp_path, "record", "--cycles", "2")
    terminal.answer("Axis and port of each indicator", "Q=1")
    terminal.until("no axis 'Q'")
    terminal.answer("Axis and port of each indicator", "1")
    terminal.until("1 names no axis; write X=1")
    terminal.answer("Axis and port of each indicator", f"X={device}")
    terminal.until("speaks mitutoyo-mux")
    terminal.answer("Unit on the display of X", "furlong")
    terminal.answer("Unit on the display of X", "mm")
    terminal.answer("When is a reading taken", "mm")
    terminal.until("use enter, data")
    terminal.answer("When is a reading taken", "timer:0.1")
    terminal.answer("File to write")
    code, seen = terminal.end()
    assert code == 0
    assert f"--gauge 'X=mitutoyo-mux?unit=mm@{device}'" in seen
    assert read_table(tmp_path / "run.csv").axes["X"].readings.tolist() == [0.812, 0.812]


def test_usb_is_offered_first_and_a_silent_port_can_be_changed(run, monkeypatch, capsys):
    devices = (
        Device("/dev/ttyS0", "n/a", None, None, None),
        Device("/dev/ttyUSB0", "adapter", "067b:2303", None, "1-2"),
    )
    spoken = {"/dev/ttyUSB0": {}, "/dev/ttyS0": {"opto-rs232": b"+000.812mm\r"}}
    answers = iter(["", "", "X=4", "timer:1", ""])
    shown = FirstReading("0.812", "mm", answered=True)
    monkeypatch.setattr(guide.recorder, "read_once", lambda *_: shown)
    monkeypatch.setattr(guide.recorder, "list_devices", lambda: devices)
    monkeypatch.setattr(
        guide.recorder, "detect", lambda port: Detected(port, 23, spoken[port], None)
    )
    monkeypatch.setattr("builtins.input", lambda: next(answers))
    asked = guide.guide(RecordOptions(unit="mm"))
    assert asked.gauges == ("X=opto-rs232@/dev/ttyS0",)
    out = capsys.readouterr().out
    assert out.index("1  /dev/ttyUSB0") < out.index("2  sim:") < out.index("4  /dev/ttyS0")
    assert "Axis and port of each indicator [X=1]: " in out
    assert "Is the indicator on" in out
    assert "Driver of X, or another port [another port]: " in out


def test_a_port_that_cannot_be_opened_is_asked_for_again(run, monkeypatch, capsys):
    """The gauges are asked for anew, and nothing else that was answered is lost."""
    asked = iter([("X=auto@/dev/not-there",), ("X=opto-rs232?unit=mm@sim:?pace=0",)])
    monkeypatch.setattr(guide, "_ask_gauges", lambda: next(asked))
    gauges, answers = guide._proven(next(asked), None, known=False)
    assert (gauges, answers) == (("X=opto-rs232?unit=mm@sim:?pace=0",), True)
    assert "/dev/not-there: cannot be opened" in capsys.readouterr().out


def test_without_a_terminal_nothing_is_asked(run, tmp_path):
    code, out, err = run("record")
    assert (code, out) == (2, "")
    assert "--gauge" in err
    assert run("record", "run.csv")[0] == 2
    assert list(tmp_path.iterdir()) == []


def test_a_bench_beside_the_table_is_used_and_said(run, tmp_path):
    (tmp_path / "bench.toml").write_text(BENCH)
    code, out, err = run("record", "run.csv", "--cycles", "2")
    assert code == 0
    assert "gauges of bench.toml: X=opto-rs232@sim:?pace=0" in err
    assert all(json.loads(line) for line in out.splitlines())
    assert run("record", "b.csv", "--gauge", "Y=opto-rs232@sim:?pace=0", "--trigger", "timer:1",
               "--cycles", "2") [2] == ""  # fmt: skip
    assert set(read_table(tmp_path / "b.csv").axes) == {"Y"}


INSTRUMENT = """[instrument.X]  # as on its certificate
certificate = "K-17"
uncertainty = 0.0004
correction = [[0, 0], [1, 0.01]]
"""


def test_the_certificate_of_a_bench_corrects_what_is_recorded_with_it(run, tmp_path):
    (tmp_path / "bench.toml").write_text(BENCH + "\n" + INSTRUMENT)
    code, _, err = run("record", "run.csv", "--cycles", "3")
    assert (code, "certificates of bench.toml: X" in err) == (0, True)
    X = read_table(tmp_path / "run.csv").axes["X"]
    assert X.readings == pytest.approx(X.displayed - 0.01 * X.displayed, abs=1e-9)
    assert X.uncertainty == 0.0004
    # a certificate that is stated otherwise is another indicator's
    assert run("record", "b.csv", "--cycles", "3", "--meta", "calibration_certificate=K-9")[0] == 0
    assert read_table(tmp_path / "b.csv").axes["X"].displayed is None
    write_bench(tmp_path / "bench.toml", RememberedBench(("X=opto-rs232@sim:?pace=0&seed=2",)))
    assert (tmp_path / "bench.toml").read_text().endswith(INSTRUMENT)
    (tmp_path / "bench.toml").write_text(BENCH + "\n" + INSTRUMENT.replace("0.01]", "5]"))
    assert run("record", "c.csv", "--cycles", "3")[0] == 65


def test_the_command_without_questions_names_the_certificate_of_the_bench_and_the_answers():
    options = RecordOptions(
        table=Path("run.csv"), gauges=("X=auto@COM3",), trigger="data",
        certificates={"correction_X": "0 0; 1 0.01"}, metadata={"robot": "FUM SCARA"},
    )  # fmt: skip
    words = shlex.split(without_questions(options, {"pose": "P1"}))
    assert words[3:9] == ["--gauge", "X=auto@COM3", "--trigger", "data", "--pose", "P1"]
    assert words[-4:] == ["--meta", "correction_X=0 0; 1 0.01", "--meta", "robot=FUM SCARA"]


def test_a_named_bench_is_used_from_anywhere(run, tmp_path):
    (tmp_path / "mine.toml").write_text(BENCH)
    assert run("record", "run.csv", "--cycles", "2", "--bench", "mine.toml")[0] == 0
    assert run("record", "b.csv", "--bench", "none.toml")[0] == 66


@pytest.mark.parametrize(
    "text",
    [
        "[gauges]\n",
        "gauges = 3\n",
        '[gauges]\nX = "opto-rs232@replay:/etc/passwd"\n',
        '[gauges]\nX = "opto-rs232@spy:///dev/ttyUSB0?file=/tmp/x"\n',
        '[gauges]\nX = "opto-rs232@spy:///dev/ttyUSB0"\n',
        '[gauges]\nX = "opto-rs232@file:///etc/passwd"\n',
        '[gauges]\nX = "opto-rs232@sim:?model=/etc/passwd"\n',
        '[gauges]\nX = "opto-rs232@sim:?m%6fdel=/etc/passwd"\n',
        '[gauges]\nX = "opto-rs232@/dev/tty\\u001b[2J"\n',
        '[gauges]\nX = 1\n',
        '[gauges]\nQ = "opto-rs232@sim:"\n',
        'trigger = "line:spy:///dev/ttyUSB0"\n[gauges]\nX = "opto-rs232@sim:"\n',
        'trigger = 3\n[gauges]\nX = "opto-rs232@sim:"\n',
        'hook = "rm"\n[gauges]\nX = "opto-rs232@sim:"\n',
    ],
)  # fmt: skip
def test_a_bench_that_names_a_file_or_is_no_bench_is_refused(run, tmp_path, text):
    (tmp_path / "bench.toml").write_text(text)
    with pytest.raises(DataError):
        read_bench(tmp_path / "bench.toml")
    code, out, err = run("record", "run.csv", "--trigger", "timer:1")
    assert (code, out) == (65, "")
    assert "bench.toml" in err
    assert "\x1b" not in err


@pytest.mark.parametrize(
    "gauge",
    [
        "opto-rs232@socket://192.0.2.1:4001",
        r"generic?request=MOVE\r@/dev/ttyUSB1",
        "auto@/dev/ttyUSB1",
    ],
)
def test_a_bench_that_was_not_named_reaches_no_further_than_the_cable(run, tmp_path, gauge):
    (tmp_path / "bench.toml").write_text(f"[gauges]\nX = '{gauge}'\n")
    code, out, err = run("record", "run.csv", "--trigger", "timer:1")
    assert (code, out) == (2, "")
    assert "--bench bench.toml" in err


def test_a_bench_written_is_the_bench_read(tmp_path):
    bench = RememberedBench(
        (r"X=generic?request=\"?\r&pattern=(?P<value>.*)@/dev/tty 'a'", "Y=auto@COM3")
    )
    write_bench(tmp_path / "bench.toml", bench)
    assert read_bench(tmp_path / "bench.toml") == bench
    with pytest.raises(UsageError):
        write_bench(
            tmp_path / "bench.toml", RememberedBench(("X=opto-rs232@replay:run.raw.jsonl",))
        )


class Wire(Port):
    """A port whose instrument answers each request by one text, and the time that passes on it."""

    settle_s = 0.15

    def __init__(self, answer, unit_answer=b"MM\r"):
        self._answer, self._unit_answer = answer, unit_answer
        self._arrived, self._now = b"", 0.0

    def read(self):
        arrived, self._arrived = self._arrived, b""
        return arrived

    def write(self, data):
        self._arrived += self._unit_answer if data == b"UNI?\r" else self._answer

    def now(self):
        return self._now

    def idle(self, until):
        self._now = until


class Loopback(Wire):
    """A plug that joins RX and TX."""

    def write(self, data):
        self._arrived += data


class WholeLines(Wire):
    """An ID-H at address 1, which takes all up to a line end for one command."""

    _heard = b""

    def write(self, data):
        *lines, self._heard = (self._heard + data.replace(b"\n", b"\r")).split(b"\r")
        self._arrived += self._answer * lines.count(b"GA01")


def on(wire):
    return lambda _address, _dialect: (wire, wire)


def test_a_request_that_is_left_open_is_ended_and_takes_none_with_it():
    found = detect("COM3", opened=lambda *_: (wire := WholeLines(b"GN01,+0016.2345\r\n"), wire))
    assert list(found.fits) == ["mitutoyo-idh"]


def test_a_loopback_plug_is_named():
    opened = lambda *_: (wire := Loopback(b""), wire)  # noqa: E731
    assert "loopback" in str(detect("COM3", opened=opened))
    with pytest.raises(InstrumentError, match="loopback"):
        name_dialects(["X=auto@COM3"], print, opened=opened)
    (spec,) = parse_gauges(["X=opto-rs232@COM3"])
    with pytest.raises(InstrumentError, match="loopback"):
        read_once(spec, opened=opened)


@pytest.mark.parametrize(
    ("wire", "unit"),
    [
        (Wire(b"+000.812\r"), "mm"),
        (Wire(b"+000.812\r", b"ERR1\r"), None),
        (Wire(b"+000.812in\r"), "inch"),
    ],
)
def test_a_gauge_is_tried_by_one_reading_and_asked_its_unit(wire, unit):
    (spec,) = parse_gauges(["X=opto-rs232@COM3"])
    assert read_once(spec, opened=on(wire)) == FirstReading("0.812", unit, answered=True)


def test_a_gauge_that_does_not_answer_is_waited_for_at_its_key():
    (spec,) = parse_gauges(["X=opto-rs232@COM3"])
    wire = Wire(b"")
    found = read_once(spec, lambda: setattr(wire, "_arrived", b"+000.812\r"), opened=on(wire))
    assert found == FirstReading("0.812", "mm", answered=False)
    for silent, said in ((Wire(b""), "nothing"), (Wire(b"hello\r"), "hello")):
        with pytest.raises(InstrumentError, match=said):
            read_once(spec, lambda: None, opened=on(silent))


def test_a_unit_other_than_the_option_is_no_proof():
    (spec,) = parse_gauges(["X=opto-rs232?unit=inch@COM3"])
    with pytest.raises(InstrumentError, match="shows mm"):
        read_once(spec, opened=on(Wire(b"+000.812\r")))


OPTIONS = RecordOptions()


def guided(monkeypatch, answers, first, options=OPTIONS):
    """Return what is recorded after the answers, where gauges show ``first`` in turn."""
    left, shown = iter(answers), iter(first)

    def read(_spec, _press):
        found = next(shown)
        if isinstance(found, Exception):
            raise found
        return found

    monkeypatch.setattr(guide.recorder, "list_devices", lambda: ())
    monkeypatch.setattr(guide.recorder, "read_once", read)
    monkeypatch.setattr("builtins.input", lambda: next(left))
    return guide.guide(options)


SILENT = InstrumentError("no reading came", where="COM3", remedy="check the cable")


def test_the_unit_is_asked_where_the_gauge_does_not_say_it(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    first = [SILENT, FirstReading("0.812", None, answered=True)]
    options = RecordOptions(gauges=("X=opto-rs232@COM3",))
    monkeypatch.setattr(
        guide.recorder, "detect", lambda port: Detected(port, 23, {"opto-rs232": b""}, None)
    )
    asked = guided(monkeypatch, ["X=COM4", "inch", "", "run"], first, options)
    assert asked.gauges == ("X=opto-rs232?unit=inch@COM4",)
    assert asked.trigger == "enter"
    assert read_bench(tmp_path / "bench.toml").gauges == asked.gauges
    out = capsys.readouterr().out
    assert "COM3: no reading came; check the cable" in out
    assert "X reads 0.812: compare with its display" in out


def test_a_gauge_that_only_sends_by_its_key_is_taken_by_its_key(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    options = RecordOptions(gauges=("X=opto-rs232@COM3",))
    first = [FirstReading("0.812", "mm", answered=False)]
    assert guided(monkeypatch, ["", ""], first, options).trigger == "data"


def test_no_bench_is_written_of_a_gauge_that_shows_nothing(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    options = RecordOptions(gauges=("X=opto-rs232@COM3",))
    with pytest.raises(StopIteration):  # asked for another port, and nobody answers
        guided(monkeypatch, [], [SILENT], options)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "given", [{"resume": True}, {"part": "P3-v50-l100"}, {"repeat": "the plunger stuck"}]
)
def test_what_is_gone_on_with_is_named_before_anything_is_asked(monkeypatch, tmp_path, given):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UsageError, match="table or the folder"):
        guided(monkeypatch, [], [], RecordOptions(**given))


def test_a_name_that_is_taken_is_asked_again_in_words_that_can_be_typed(
    monkeypatch, tmp_path, capsys
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bench.toml").write_text(BENCH)
    (tmp_path / "run.raw.jsonl").touch()
    guided(monkeypatch, ["run", "other"], [FirstReading("0.8", "mm", answered=True)])
    assert "use another name, or --resume to continue it" in capsys.readouterr().out


def test_a_bench_that_was_not_read_is_never_written_over(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    there = tmp_path / "acc" / "bench.toml"
    there.parent.mkdir()
    there.write_text("# the other bench\n" + BENCH)
    options = RecordOptions(gauges=("X=opto-rs232@COM3",))
    guided(monkeypatch, ["", "acc/run"], [FirstReading("0.8", "mm", answered=True)], options)
    assert there.read_text() == "# the other bench\n" + BENCH
    assert f"{Path('acc/bench.toml')} is there and stays as it is" in capsys.readouterr().out


def test_what_is_named_anew_beside_a_bench_goes_into_that_bench(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "acc").mkdir()
    (tmp_path / "bench.toml").write_text("# ours\n" + BENCH.replace("rs232", "rs232?unit=mm"))
    first = [SILENT, FirstReading("0.8", "mm", answered=True)]
    monkeypatch.setattr(
        guide.recorder, "detect", lambda port: Detected(port, 23, {"opto-rs232": b""}, None)
    )
    asked = guided(monkeypatch, ["X=COM4", "acc/run"], first)
    assert (tmp_path / "bench.toml").read_text().startswith("# ours\n")
    assert read_bench(tmp_path / "bench.toml").gauges == asked.gauges
    assert list((tmp_path / "acc").iterdir()) == []


def test_beside_a_bench_only_the_name_is_asked(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bench.toml").write_text(BENCH)
    asked = guided(monkeypatch, ["mine"], [FirstReading("0.8", "mm", answered=True)])
    assert (str(asked.table), asked.trigger) == ("mine.csv", "timer:1")
    assert capsys.readouterr().out.count("]: ") == 1
    assert (tmp_path / "bench.toml").read_text() == BENCH


def on_each(answer):
    def opened(address, dialect):
        wire = Wire(answer)
        return wire, wire

    return opened


@pytest.mark.parametrize(
    ("answer", "dialect"),
    [
        (b"+000.101\r", "opto-rs232"),
        (b"+000.101\r\n", "opto-rs232-tesa"),
        (b"01A+0000.501\r", "mitutoyo-mux"),
        (b"A+00.501\r\n", "magnescale"),
    ],
)
def test_a_dialect_is_found_by_what_comes(answer, dialect):
    told = []
    named = name_dialects(
        ["X=auto?unit=mm@COM3", "Y=maxum@COM4"], told.append, opened=on_each(answer)
    )
    assert named == (f"X={dialect}?unit=mm@COM3", "Y=maxum@COM4")
    assert [line.startswith(f"X: COM3 speaks {dialect} (") for line in told] == [True]


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (b"+000.101mm\r\n", ("more than one", "millimar-c1240", "opto-rs232-tesa")),
        (b"ERR\r", ("speaks none",)),
        (b"", ("speaks none",)),
    ],
)
def test_where_two_dialects_fit_or_none_no_gauge_is_named(answer, words):
    with pytest.raises(InstrumentError) as found:
        name_dialects(["X=auto@COM3"], print, opened=on_each(answer))
    assert all(word in str(found.value) for word in words)


@pytest.mark.slow
@needs_terminals
def test_the_dialect_of_a_real_port_is_found_and_recorded(run, tmp_path, instrument):
    device = instrument(r"A+00.501\r\n")
    code, _, err = run("record", "run.csv", "--gauge", f"X=auto?unit=mm@{device}",
                       "--trigger", "timer:0.01", "--cycles", "2")  # fmt: skip
    assert code == 0
    assert f"X: {device} speaks magnescale (" in err
    assert "magnescale" in read_table(tmp_path / "run.csv").metadata["indicator"]


@pytest.mark.slow
@needs_terminals
def test_where_none_fits_nothing_is_recorded(run, tmp_path, instrument):
    silent = instrument("ERR\\r")
    code, out, err = run("record", "run.csv", "--gauge", f"X=auto@{silent}",
                         "--trigger", "timer:0.01", "--cycles", "2")  # fmt: skip
    assert (code, out) == (69, "")
    assert "speaks none" in err
    assert list(tmp_path.iterdir()) == []


def test_a_simulated_indicator_is_found_too():
    for key in ("mitutoyo-mux", "heidenhain-nd", "maxum"):
        assert list(detect(f"sim:{key}?pace=0").fits) == [key]
    with pytest.raises(InstrumentError):
        detect("/dev/not-there")


def test_dialects_are_shown_by_maker(run):
    code, out, _ = run("ports", "--dialects", "MAHR", "--json")
    assert code == 0
    assert set(json.loads(out)["dialects"]) == {"maxum", "millimar", "millimar-c1240"}
    assert run("ports", "--dialects", "nobody")[0] == 2
    assert run("ports", "mahr")[0] == 2


def test_typed_lines_are_readings_and_commands(run, tmp_path, monkeypatch):
    typed = "0.812\n0,9\n0.813\nv slipped\n0,814\n\n+00.8150\nx\n0.815\n"
    code, out, _ = _typed(run, monkeypatch, typed, "--unit", "mm")
    assert code == 0
    events = [json.loads(line) for line in out.splitlines()]
    kinds = [e["event"] for e in events if e["event"] in ("stored", "garbage", "voided", "changed")]
    assert kinds == ["stored", "changed", "stored", "voided", "stored", "changed", "garbage",
                     "stored"]  # fmt: skip
    assert read_table(tmp_path / "run.csv").axes["X"].readings.tolist() == [0.812, 0.814, 0.815]


def test_a_struck_reading_leaves_no_resolution_behind(run, tmp_path, monkeypatch):
    code, _, _ = _typed(run, monkeypatch, "0.5\nv short\n0.500\n0.503\n0.501\n", "--unit", "mm")
    axis = read_table(tmp_path / "run.csv").axes["X"]
    assert (code, axis.resolution, axis.readings.tolist()) == (0, 0.001, [0.5, 0.503, 0.501])


def test_readings_typed_with_other_decimals_are_answered_with_what_helps(run, monkeypatch):
    code, _, err = _typed(run, monkeypatch, "0.5\n0.51\n0.51\n", "--unit", "mm")
    assert code == 69
    assert "type all decimals in every reading, as 0.500" in err


def test_a_doubled_line_is_refused_within_rearm(run, tmp_path, monkeypatch):
    code, out, _ = _typed(run, monkeypatch, "0.812\n0.812\n", "--unit", "mm", "--rearm", "5")
    assert code == 0
    assert '"refused"' in out
    assert len(read_table(tmp_path / "run.csv")) == 1


@pytest.mark.parametrize(
    "options",
    [
        (),
        ("--unit", "mm", "--trigger", "enter"),
        ("--unit", "mm", "--gauge", "Y=keyboard@keyboard:"),
    ],
)
def test_a_keyboard_needs_its_unit_has_its_own_trigger_and_is_one(
    run, tmp_path, monkeypatch, options
):
    code, _, err = _typed(run, monkeypatch, "0.812\n", *options)
    assert code == 2
    assert err
    assert list(tmp_path.iterdir()) == []


def test_the_keyboard_has_its_own_driver(run):
    assert run("record", "a.csv", "--gauge", "X=opto-rs232@keyboard:")[0] == 2
    assert run("record", "a.csv", "--gauge", "X=keyboard@/dev/ttyUSB0")[0] == 2
    assert run("record", "a.csv", "--gauge", "X=auto@keyboard:")[0] == 2


def _typed(run, monkeypatch, text, *options):
    read, write = os.pipe()
    os.write(write, text.encode())
    os.close(write)
    with os.fdopen(read) as stream:
        monkeypatch.setattr(sys, "stdin", stream)
        return run(
            "record", "run.csv", "--gauge", "X=keyboard@keyboard:", "--cycles", "3", *options
        )


@pytest.mark.slow
@needs_terminals
@pytest.mark.parametrize("words", [(), ("mine.csv",)])
def test_beside_a_bench_the_head_of_the_table_is_not_asked_for(tmp_path, words):
    (tmp_path / "bench.toml").write_text(BENCH.replace("timer:1", "enter"))
    terminal = Terminal(tmp_path, "record", *words, "--cycles", "2")
    if not words:
        terminal.answer("File to write", "mine")
    assert "head" not in terminal.until("Cycle 1").seen
    terminal.press("q")
    terminal.end()


@pytest.mark.slow
@needs_terminals
def test_a_wedge_types_on_the_screen_and_letters_stay_commands(tmp_path):
    gauge = ("--gauge", "X=keyboard?unit=mm@keyboard:", "--cycles", "3", "--meta", "robot=r")
    terminal = Terminal(tmp_path, "record", "run.csv", *gauge, "--rearm", "0.3")
    terminal.until("Cycle 1")
    terminal.press("0.812\n0.812\n")
    terminal.until("not taken")
    time.sleep(0.4)
    terminal.press("9.9\x1b-0.81x\x7f3\t")
    terminal.until("cycle 2 STORED")
    terminal.press("vslipped\n")
    terminal.until("voided")
    terminal.press("q")
    code, seen = terminal.end()
    assert code == 0
    assert "Reading: " in seen or "STORED" in seen
    assert read_table(tmp_path / "run.csv").axes["X"].readings.tolist() == [0.812]


def test_no_simulated_dial_is_taken_by_enter_and_one_that_is_named_says_so(monkeypatch, capsys):
    answers = iter(["", "X=1"])
    monkeypatch.setattr(guide.recorder, "list_devices", lambda: ())
    monkeypatch.setattr("builtins.input", lambda: next(answers))
    assert guide._ask_gauges() == ("X=opto-rs232@sim:",)
    gauges, _ = guide._proven(("X=opto-rs232@sim:?pace=0",), None, known=False)
    out = capsys.readouterr().out
    assert "no indicator is named; write X=1, with the number of its port" in out
    assert "SIMULATED, no dial is read" in out
    assert len(gauges) == 1


def test_the_question_says_how_two_indicators_are_named(monkeypatch, capsys):
    answers = iter(["X", "X=1 Y=1"])
    monkeypatch.setattr(guide.recorder, "list_devices", lambda: ())
    monkeypatch.setattr("builtins.input", lambda: next(answers))
    assert guide._ask_gauges() == ("X=opto-rs232@sim:", "Y=opto-rs232@sim:")
    out = capsys.readouterr().out
    assert "Name all indicators in one line: X=1 Y=2" in out
    assert "X names no port; write X=1" in out
    assert "X=X" not in out


@pytest.mark.parametrize(
    ("lines", "unit", "readings", "resolution"),
    [
        ("412\n414\n40\n", "um", [0.412, 0.414, 0.04], 0.001),
        ("412.0\n414.0\n413.0\n", "um", [0.412, 0.414, 0.413], None),
        ("412.0\n414.5\n413.0\n", "um", [0.412, 0.4145, 0.413], 0.0001),
        ("0.410\n0.411\n0.420\n", "mm", [0.41, 0.411, 0.42], 0.001),
    ],
)
def test_the_division_is_what_was_typed_over_the_run(
    run, tmp_path, monkeypatch, lines, unit, readings, resolution
):
    code, _, _ = _typed(run, monkeypatch, lines, "--unit", unit)
    axis = read_table(tmp_path / "run.csv").axes["X"]
    assert (code, axis.resolution) == (0, resolution)
    assert axis.readings.tolist() == pytest.approx(readings)


@pytest.mark.parametrize(("unit", "typed"), [("um", "abc"), ("mm", "412"), ("mm", "abc")])
def test_what_is_typed_and_no_reading_is_answered_without_internals(run, monkeypatch, unit, typed):
    _, out, _ = _typed(run, monkeypatch, f"{typed}\n", "--unit", unit)
    said = [e["message"] for e in map(json.loads, out.splitlines()) if e["event"] == "garbage"]
    assert said == [f"not a reading; type all decimals in every reading, as 0.500: '{typed}'"]


def test_the_search_of_a_driver_is_said_before_it_begins(run, tmp_path):
    _, _, err = run("record", "run.csv", "--gauge", "X=auto@/dev/not-there", "--trigger", "timer:1")
    trying, _, failed = err.partition("\n")
    assert trying.startswith("scara-iso: trying every driver")
    assert "/dev/not-there" in failed


@needs_terminals
def test_what_is_said_aside_is_broken_between_words_on_a_terminal(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "40")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    text = "scara-iso: X: /dev/ttyUSB0 speaks opto-rs232 (+000.812) of 23 drivers tried"
    say_in_words(text)
    lines = capsys.readouterr().err.splitlines()
    assert all(len(line) < 40 for line in lines)
    assert " ".join(map(str.strip, lines)) == text
