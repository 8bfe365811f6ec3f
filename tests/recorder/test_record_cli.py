"""The commands record and ports, the keyboard and the live screen."""

import io
import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest
from rich.console import Console

import scara_iso
from scara_iso import read_table, recorder
from scara_iso.base.errors import NoInputError
from scara_iso.commands import main
from scara_iso.commands.operator import keyboard
from scara_iso.commands.operator.guide import Terminal
from scara_iso.commands.operator.keyboard import Keys, Lines, parse_line
from scara_iso.commands.operator.screen import Screen
from scara_iso.rawfile import History, encode, manifest_path, raw_path
from scara_iso.rawfile.history import AxisReadings
from scara_iso.rawfile.integrity import decode_record
from scara_iso.recorder import (
    CycleDone,
    Done,
    Note,
    Pause,
    Paused,
    Problem,
    Quit,
    Refused,
    Started,
    Stored,
    Take,
    Void,
    Voided,
    Waiting,
)
from scara_iso.render.live import LiveScreen, draw

FIXTURES = Path(__file__).parents[1] / "fixtures" / "recordings"
X = ["--gauge", "X=opto-rs232@sim:?pace=0"]
Y = ["--gauge", "Y=mitutoyo-mux@sim:?pace=0"]
TIMER = ["--trigger", "timer:0.1"]


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run the command in a folder of its own; return exit code, output and errors."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        code = main([*arguments])
        return code, *capsys.readouterr()

    return call


def events(out):
    return [json.loads(line) for line in out.splitlines()]


def test_two_simulated_gauges_make_a_table_that_analyze_takes(run, tmp_path):
    code, out, err = run("record", "run.csv", *X, *Y, *TIMER)
    assert (code, err) == (0, "")
    found = events(out)
    assert found[0]["event"] == "started"
    assert found[-1] == {
        "event": "done", "cycles": 31, "planned": 31, "table": "run.csv", "raw": "run.raw.jsonl",
    }  # fmt: skip
    stored = [e for e in found if e["event"] == "stored"]
    assert len(stored) == 62
    assert all(set(e) == {"event", "cycle", "axis", "value"} for e in stored)
    table = read_table(tmp_path / "run.csv")
    assert [e["value"] for e in stored if e["axis"] == "X"] == table.axes["X"].readings.tolist()
    assert table.metadata["simulated"] == "X Y"
    assert "mm as the simulation states" in table.metadata["indicator"]
    assert run("analyze", "run.csv", "--json")[0] == 0


def test_a_recorded_stream_gives_the_same_table_every_time(run, tmp_path):
    (tmp_path / "stream").write_bytes(b"".join(b"+000.%03dmm\r" % n for n in range(100, 131)))
    for name in ("a.csv", "b.csv"):
        replay = ["--gauge", "X=opto-rs232@replay:stream", "--trigger", "data"]
        assert run("record", name, *replay)[0] == 0
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    table = read_table(tmp_path / "a.csv")
    assert table.axes["X"].readings.tolist() == [n / 1000 for n in range(100, 131)]
    assert table.covariates["time_s"].tolist() == [float(n) for n in range(1, 32)]


@pytest.mark.parametrize("trigger", ["data", "timer:0.1", "timer:3"])
def test_a_recording_replayed_gives_the_readings_again(run, tmp_path, trigger):
    run("record", "run.csv", *X, *Y, *TIMER)
    gauges = [f"--gauge={axis}={key}@replay:run.raw.jsonl"
              for axis, key in (("X", "opto-rs232"), ("Y", "mitutoyo-mux"))]  # fmt: skip
    assert run("record", "again.csv", *gauges, "--trigger", trigger)[0] == 0
    before, after = read_table(tmp_path / "run.csv"), read_table(tmp_path / "again.csv")
    for axis in "XY":
        assert after.axes[axis].readings.tolist() == before.axes[axis].readings.tolist()
    assert after.metadata["simulated"] == "X Y"


def test_every_stored_reading_stands_in_the_received_bytes(run, tmp_path):
    run("record", "run.csv", *X, *TIMER)
    lines = [json.loads(line) for line in raw_path(tmp_path / "run.csv").read_text().splitlines()]
    heard = b"".join(bytes.fromhex(line["hex"]) for line in lines if line["event"] == "in")
    stored = [line["text"] for line in lines if line["event"] == "stored"]
    assert [f"+{float(text):07.3f}mm".encode() for text in stored] == heard.split(b"\r")[:-1]


def test_analyze_says_that_a_table_was_edited(run, tmp_path):
    run("record", "run.csv", *X, *TIMER)
    assert edits(run) == []
    table = tmp_path / "run.csv"
    table.write_text(table.read_text().replace("\n31,0.", "\n31,1."))
    assert edits(run) == ["run.csv was changed after it was recorded"]
    assert "recording edited" in run("analyze", "run.csv")[1]


def edits(run):
    findings = json.loads(run("analyze", "run.csv", "--json")[1])["findings"]
    return [finding["message"] for finding in findings if finding["code"] == "edited"]


def test_a_stream_that_ends_early_says_so(run, tmp_path):
    (tmp_path / "stream").write_bytes(b"+000.100mm\r+000.101mm\r")
    code, out, _ = run(
        "record", "a.csv", "--gauge", "X=opto-rs232@replay:stream", "--trigger", "data"
    )
    assert code == 0
    assert events(out)[-1]["cycles"] == 2
    assert run("analyze", "a.csv")[0] == 65


def test_a_recorded_session_with_troubles_gives_what_its_whole_frames_say(run, tmp_path):
    path = FIXTURES / "opto-data-key.bin"
    frames = re.findall(rb"(?<=\r)\+(\d{3}\.\d{3})(?=\r)", path.read_bytes())
    gauge = ["--gauge", f"X=opto-rs232@replay:{path}", "--trigger", "data"]
    for name in ("a.csv", "b.csv"):
        code, out, _ = run("record", name, *gauge)
        assert code == 0
    found = [e["event"] for e in events(out)]
    assert (found.count("fault"), found.count("garbage")) == (1, 1)
    table = read_table(tmp_path / "a.csv")
    assert table.axes["X"].readings.tolist() == [float(frame) for frame in frames]
    assert len(table) == 31
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    assert run("analyze", "a.csv")[0] == 0


def test_a_stream_without_a_reading_is_an_error_and_leaves_nothing(run, tmp_path):
    (tmp_path / "stream").write_bytes(b"ERR3\r")
    code, _, err = run(
        "record", "a.csv", "--gauge", "X=opto-rs232@replay:stream", "--trigger", "data"
    )
    assert code == 69
    assert "no reading was recorded" in err
    assert [path.name for path in tmp_path.iterdir()] == ["stream"]


def test_a_unit_that_nobody_states_is_an_error_that_names_the_option(run, tmp_path):
    (tmp_path / "stream").write_bytes(b"01A+0000.123\r")
    gauge = ["--gauge", "X=mitutoyo-mux@replay:stream", "--trigger", "data"]
    code, _, err = run("record", "a.csv", *gauge)
    assert code == 2
    assert "--unit" in err
    assert run("record", "a.csv", *gauge, "--unit", "inch", "--cycles", "1")[0] == 0
    assert read_table(tmp_path / "a.csv").axes["X"].readings.tolist() == [3.1242]


@pytest.mark.parametrize(
    ("arguments", "code", "word"),
    [
        (["record"], 2, "record run.csv --gauge X=opto-rs232@"),
        (["record", "a.csv", *TIMER], 2, "--gauge"),
        (["record", "a.csv", *X], 2, "--trigger"),
        (["record", "a.csv", *X, "--trigger", "sometimes"], 2, "timer:SECONDS"),
        (["record", "a.csv", *X, "--trigger", "timer:0"], 2, "timer:SECONDS"),
        (["record", "a.csv", *X, *TIMER, "--meta", "unit=inch"], 2, "recorder states"),
        (["record", "a.csv", *X, *TIMER, "--meta", "Einheit=inch"], 2, "recorder states"),
        (["record", "a.csv", *X, *TIMER, "--meta-file", "no.toml"], 66, "no.toml"),
        (["record", "a.csv", "--resume", *X, *TIMER], 66, "a.raw.jsonl"),
        (["record", "--rebuild", "a.raw.jsonl"], 66, "a.raw.jsonl"),
        (["record", "no/a.csv", *X, *TIMER], 73, "no/a.csv"),
        (["record", "a.csv", "--gauge", "X=opto-rs232@/dev/ttyNOTTHERE", *TIMER], 69, "NOTTHERE"),
        (["record", "a.csv", "--gauge", "X=opto-rs232@replay:none", *TIMER], 66, "none"),
        (["record", "a.csv", *X, "--trigger", "data", "--stable", "3"], 2, "--stable"),
        (["record", "a.csv", *X, *TIMER, "--unit", "inch"], 2, "sim:?unit="),
        (["ports", "--ask", "opto-rs232"], 2, "--probe"),
        (["ports", "--probe", "sim:", "--dialects"], 2, "--dialects"),
        (["ports", "--probe", "/dev/ttyNOTTHERE"], 69, "NOTTHERE"),
    ],
)
def test_errors_say_what_and_what_to_do(run, tmp_path, arguments, code, word):
    found, out, err = run(*arguments)
    assert found == code
    assert out == ""
    assert word in err
    assert len(err.splitlines()) <= 3
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("stated", "word"),
    [
        ("discarded=1", "not understood"),
        ("scale=25.4", "multiplied by no factor"),
        ("factor=10", "multiplied by no factor"),
        ("Erster Zyklus verworfen=true", "not understood"),
        ("correction_X=0 0, 2 0.1", "correction_x"),
        ("recorded=1999-01-01", "recorder states"),
        ("doubts=-", "recorder states"),
    ],
)
def test_a_head_that_the_table_could_not_be_read_with_is_refused_first(run, tmp_path, stated, word):
    code, out, err = run("record", "a.csv", *X, *TIMER, "--meta", stated)
    assert (code, out, list(tmp_path.iterdir())) == (2, "", [])
    assert word in err


def test_nothing_is_overwritten_and_resume_goes_on(run, tmp_path):
    assert run("record", "a.csv", *X, *TIMER, "--cycles", "3", "--meta", "robot=R")[0] == 0
    assert run("record", "a.csv", *X, *TIMER)[0] == 73
    code, out, _ = run("record", "--resume", "a.csv", *X, "--cycles", "5", "--meta", "Prüfer=Ö")
    assert code == 0
    assert [e["cycle"] for e in events(out) if e["event"] == "stored"] == [4, 5]
    table = read_table(tmp_path / "a.csv")
    assert len(table) == 5
    assert (table.metadata["robot"], table.metadata["operator"]) == ("R", "Ö")
    assert "cycles_planned" not in table.metadata
    (tmp_path / "a.csv").unlink()
    assert run("record", "--rebuild", "a.raw.jsonl")[0] == 0
    assert len(read_table(tmp_path / "a.csv")) == 5


@pytest.mark.parametrize("name", ["out.txt", "plain", "BIG.CSV"])
@pytest.mark.parametrize("known", [True, False])
def test_a_table_of_another_ending_is_rebuilt_in_its_place(run, tmp_path, name, known):
    assert run("record", name, *X, *TIMER, "--cycles", "2")[0] == 0
    raw, manifest = raw_path(tmp_path / name), manifest_path(tmp_path / name)
    made = read_table(tmp_path / name).axes["X"].readings.tolist()
    (tmp_path / name if known else manifest).unlink()
    assert run("record", "--rebuild", raw.name)[0] == 0
    assert read_table(tmp_path / name).axes["X"].readings.tolist() == made
    assert {path.name for path in tmp_path.iterdir()} == {name, raw.name, manifest.name}


def test_a_second_table_of_a_recording_leaves_the_manifest(run, tmp_path):
    assert run("record", "out.txt", *X, *TIMER, "--cycles", "2")[0] == 0
    manifest = (tmp_path / "out.txt.manifest.json").read_bytes()
    assert run("record", "--rebuild", "out.txt.raw.jsonl", "out.txt.csv")[0] == 0
    assert (tmp_path / "out.txt.manifest.json").read_bytes() == manifest


@pytest.mark.parametrize("name", ["out.xlsx", "/dev/stdout", os.devnull])
def test_a_table_is_rebuilt_into_a_file_of_a_tables_name(run, tmp_path, name):
    assert run("record", "a.csv", *X, *TIMER, "--cycles", "2")[0] == 0
    before = sorted(tmp_path.iterdir())
    words = [sys.executable, "-m", "scara_iso", "record", "--rebuild", "a.raw.jsonl", name]
    env = {**os.environ, "PYTHONPATH": str(Path(scara_iso.__file__).parents[1])}
    ended = subprocess.run(words, check=False, capture_output=True, timeout=60, env=env)
    assert (ended.returncode, sorted(tmp_path.iterdir())) == (2, before)


def test_a_table_for_excel_stays_one_on_resume_and_rebuild(run, tmp_path):
    assert run("record", "a.csv", *X, *TIMER, "--cycles", "3", "--excel-locale", "de")[0] == 0
    assert run("record", "--resume", "a.csv", *X, "--cycles", "5")[0] == 0
    text = (tmp_path / "a.csv").read_text(encoding="utf-8")
    assert text.startswith("\ufeff# unit: mm\n")
    assert "\ncycle;X;time_s\n" in text
    assert len(read_table(tmp_path / "a.csv")) == 5
    assert run("record", "--rebuild", "a.raw.jsonl")[0] == 0


@pytest.mark.parametrize(
    "words",
    [("--gauge", "X=nonsense"), ("--part", "zz"), ("--resume",), ("--bench", "b"), ("--no-watch",)],
)
def test_an_option_that_a_rebuild_cannot_heed_is_refused(run, tmp_path, words):
    assert run("record", "a.csv", *X, *TIMER, "--cycles", "2")[0] == 0
    code, _, err = run("record", "--rebuild", "a.raw.jsonl", "b.csv", *words)
    assert (code, (tmp_path / "b.csv").exists()) == (2, False)
    assert words[0].replace("no-", "") in err


def test_another_port_on_resume_is_recorded(run, tmp_path):
    run("record", "a.csv", *X, *TIMER, "--cycles", "3")
    other = ["--gauge", "X=opto-rs232@sim:?pace=0&value=0.8"]
    assert run("record", "--resume", "a.csv", *other, "--cycles", "4")[0] == 0
    indicator = read_table(tmp_path / "a.csv").metadata["indicator"]
    assert "sim:?pace=0 (simulated), then sim:?pace=0&value=0.8 (simulated)" in indicator


@pytest.mark.parametrize(
    "options", ["seed=5", "seed=5&pace=0", "pace=0&seed=5", "pace=0&seed=5&value=1"]
)
def test_a_seed_is_no_identity(run, tmp_path, options):
    gauge = ["--gauge", f"X=opto-rs232@sim:?{options}"]
    run("record", "a.csv", *gauge, "--trigger", "timer:0.05", "--rearm", "0", "--cycles", "2")
    indicator = read_table(tmp_path / "a.csv").metadata["indicator"]
    rest = "&".join(one for one in options.split("&") if "seed" not in one)
    assert f" at sim:{'?' if rest else ''}{rest} (simulated)" in indicator
    assert "seed=5" in (tmp_path / "a.raw.jsonl").read_text("utf-8")


def test_a_recorded_stream_is_not_gone_on_with(run, tmp_path):
    (tmp_path / "s").write_bytes(b"+000.100mm\r" * 9)
    gauge = ["--gauge", "X=opto-rs232@replay:s", "--trigger", "data"]
    assert run("record", "a.csv", *gauge, "--cycles", "2")[0] == 0
    assert run("record", "a.csv", "--resume", *gauge)[0] == 2


def test_text_that_is_no_text_does_not_cost_the_table(run, tmp_path):
    code, _, _ = run("record", "a.csv", *X, *TIMER, "--cycles", "2", "--meta", "robot=\udcff=1")
    assert code == 0
    assert len(read_table(tmp_path / "a.csv")) == 2


def test_a_torn_raw_file_is_told(run, tmp_path):
    run("record", "a.csv", *X, *TIMER, "--cycles", "3")
    raw = raw_path(tmp_path / "a.csv")
    raw.write_bytes(raw.read_bytes()[:-20])
    code, _, err = run("record", "b.csv", "--rebuild", "a.raw.jsonl")
    assert code == 0
    assert "torn or damaged" in err


def test_lines_of_standard_input_trigger(run, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n\nv slipped\n\nn warm\nq\n"))
    code, out, _ = run("record", "a.csv", *X, "--trigger", "enter")
    assert code == 0
    kinds = [e["event"] for e in events(out) if e["event"] in ("stored", "voided", "note", "done")]
    assert kinds == ["stored", "stored", "voided", "stored", "note", "done"]
    assert len(read_table(tmp_path / "a.csv")) == 2


def test_streams_that_were_closed_cost_nothing(run, tmp_path, monkeypatch):
    for name in ("stdin", "stdout", "stderr"):
        monkeypatch.setattr(sys, name, None)
    assert main(["record", "a.csv", *X, *TIMER, "--cycles", "2"]) == 0
    assert main(["record", "b.csv", *X, "--trigger", "enter"]) == 69
    for stream in (sys.stdin, sys.stdout, sys.stderr):
        stream.close()
    assert len(read_table(tmp_path / "a.csv")) == 2


def test_bytes_that_are_no_text_do_not_stop_the_lines(run, tmp_path, monkeypatch):
    typed = io.TextIOWrapper(io.BytesIO(b"\n\xff\xfe\n\n"), encoding="utf-8", errors="strict")
    monkeypatch.setattr(sys, "stdin", typed)
    assert run("record", "a.csv", *X, "--trigger", "enter")[0] == 0
    assert len(read_table(tmp_path / "a.csv")) == 2


def test_a_reader_that_goes_away_ends_the_session(run, tmp_path, monkeypatch):
    class Closed(io.StringIO):
        def write(self, text):
            if '"cycle": 3' in text:
                raise BrokenPipeError(32, "Broken pipe")
            return super().write(text)

    monkeypatch.setattr(sys, "stdout", Closed())
    code = main(["record", "a.csv", *X, *TIMER])
    assert code == 74
    assert raw_path(tmp_path / "a.csv").exists()


def test_ports_lists_dialects_and_what_is_unverified(run):
    code, out, _ = run("ports", "--dialects", "--json")
    found = json.loads(out)["dialects"]
    assert code == 0
    assert found["opto-rs232"]["confidence"] == "high"
    assert found["mitutoyo-idh"]["unverified"]
    code, out, _ = run("ports", "--dialects")
    assert code == 0
    assert "unverified" in out


def test_ports_lists_devices(run):
    code, out, _ = run("ports", "--json")
    assert code == 0
    assert isinstance(json.loads(out)["ports"], list)
    assert run("ports")[0] == 0


def test_probe_says_what_it_hears(run, tmp_path):
    code, out, _ = run("ports", "--probe", "sim:cdi-starrett-iq?pace=0", "--json")
    found = json.loads(out)
    assert code == 0
    assert [r["unit"] for r in found["dialects"]["cdi-starrett-iq"]] == ["mm", "mm"]
    assert "cdi-starrett-iq" in run("ports", "--probe", "sim:cdi-starrett-iq?pace=0")[1]


def test_probe_finds_a_wrong_parity(run, tmp_path):
    (tmp_path / "s").write_bytes(bytes.fromhex("2b3030b12eb233b48d") * 2)
    code, out, _ = run("ports", "--probe", "replay:s", "--json")
    found = json.loads(out)
    assert code == 0
    assert found["dialects"] == {}
    assert "7E2" in found["diagnosis"]
    assert "7E2" in run("ports", "--probe", "replay:s")[1]


def typed(text):
    keys = Keys(iter([*text, *[""] * 50]).__next__)
    found = [keys.poll() for _ in range(len(text))]
    return [command for command in found if command is not None]


def test_keys():
    assert typed("\r\n x") == [Take(), Take(), Take()]
    assert typed("vslip\x7fpped\rq") == [Void("slipped"), Quit()]
    assert typed("nwarm\x1bp") == [Pause()]
    assert typed("n\rnok\r") == [Note("ok")]
    assert typed("v\r\r\x1bv\rslipped\r") == [Void("slipped")]


def test_keys_are_offered_where_they_do_something():
    for trigger, offered in (("enter", True), ("data", False), ("timer:2", False)):
        shown, text = screen(80, operator=Keys(lambda: ""))
        shown._take(Started({"X": "opto-rs232 at sim:"}, 1, 31, trigger))
        assert ("Enter take" in text(), "v void" in text()) == (offered, True)


def test_the_prompt_shows_what_is_typed():
    keys = Keys(iter(["v", "a", "b", *[""] * 9]).__next__)
    for _ in range(3):
        keys.poll()
    assert keys.prompt() == "Void the last reading, because: ab"


def test_a_reason_is_waited_for_and_how_to_leave_is_said():
    keys = Keys(iter(["v", "\r", *[""] * 9]).__next__)
    for _ in range(3):
        keys.poll()
    assert keys.prompt() == "Void the last reading, because: (Esc leaves it)"


@pytest.mark.parametrize(
    ("trigger", "asked"),
    [("enter", "Void cycle 2, X 0.808, Y 0.2, because:"), ("data", "Void the last reading,")],
)
def test_the_question_names_what_would_be_struck(trigger, asked):
    """A reading that was refused is none: the one before it would go."""
    keys = Keys(iter(["v", *[""] * 9]).__next__)
    shown, text = screen(80, operator=keys)
    keys.poll()
    for said in (
        Started({"X": "a", "Y": "b"}, 1, 31, trigger),
        Stored(2, "X", 0.808, "0.808", "mm"),
        Stored(2, "Y", 0.2, "0.2", "mm"),
        Refused("X", "x8", "no number"),
    ):
        shown._take(said)
    assert asked in text()
    shown._take(Voided(2, ("X", "Y"), "slip"))
    assert "Void the last reading, because:" in text()


@pytest.mark.parametrize(
    ("line", "command"),
    [("\n", Take()), ("v slipped\n", Void("slipped")), ("N warm", Note("warm")), ("p", Pause()),
     ("q", Quit()), ("v\n", None), ("hello\n", None), ("q now", None)],
)  # fmt: skip
def test_lines(line, command):
    assert parse_line(line) == command


def test_the_end_of_input_quits():
    lines = Lines(io.StringIO("\n"))
    for _ in range(100):
        if lines.poll() == Quit():
            return
        time.sleep(0.01)
    pytest.fail("no quit")


def test_input_that_is_closed_is_at_its_end():
    stream = io.StringIO()
    stream.close()
    lines = Lines(stream)
    lines._follower.join()
    assert lines.poll() == Quit()


def test_a_port_that_is_not_there_is_said_before_a_question(monkeypatch, run):
    monkeypatch.setattr(Terminal, "shown", True)
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True)
    monkeypatch.setattr("builtins.input", lambda _: pytest.fail("asked"))
    code, _, err = run("record", "run.csv", "--gauge", "X=opto-rs232@/dev/none", "--bench", "b")
    assert code == 69
    assert "/dev/none: cannot be opened (No such file or directory)" in err


def screen(width, encoding="utf-8", operator=None, earlier=None):
    """Return a screen and a function that draws its view as text."""
    file = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    console = Console(file=file, width=width, force_terminal=True, color_system=None)
    shown = Screen(LiveScreen(console), operator or Keys(lambda: ""), title="record run.csv",
                   earlier=earlier or {})  # fmt: skip

    def text():
        with console.capture() as capture:
            console.print(draw(shown._view(), console))
        return capture.get()

    return shown, text


STORY = [
    Started({"X": "a", "Y": "b"}, 1, 31, "enter"),
    Waiting(1, ("X", "Y")),
    *[
        said
        for k in range(1, 9)
        for said in (
            Stored(k, "X", 0.1 + k / 1000, f"0.10{k}", "mm"),
            Stored(k, "Y", 2.54 + 0.0254 * k, f"0.10{k}", "inch"),
            CycleDone(k, discarded=k == 1),
            Waiting(k + 1, ("X", "Y")),
        )
    ],
]


def test_the_first_frame_of_a_recording_that_is_resumed_names_its_cycle():
    shown, text = screen(80)
    shown.tell(Started({"X": "a"}, 7, 31, "enter"))
    assert "Cycle 7:" in text()


def test_what_was_recorded_before_is_shown_as_the_indicator_showed_it():
    history = History("run.raw.jsonl")
    history.columns = {"X": AxisReadings()}
    for visit in range(1, 103):
        history.columns["X"].put(visit, f"0.{visit:04}", "inch")
    before = history.columns["X"].shown
    assert before[1] == (0.00254, "0.0001", "inch")
    shown, text = screen(80, earlier={"X": before})
    shown._take(Started({"X": "a"}, 1, 200, "enter"))
    assert "0.0102 inch" in text()


def test_a_recording_that_is_not_there_is_said_with_what_to_do(run, tmp_path):
    code, out, err = run("record", "none.csv", "--resume", *X, *TIMER)
    assert (code, out) == (66, "")
    assert "none.raw.jsonl: is not there: nothing was recorded for none.csv" in err
    assert "leave --resume out" in err
    with pytest.raises(NoInputError, match="nothing was recorded"):
        scara_iso.record("none.csv", [X[1]], trigger="timer:1", resume=True)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("width", [40, 80, 200])
@pytest.mark.parametrize("encoding", ["utf-8", "cp1252", "ascii"])
def test_the_screen_fits_and_says_what_counts(width, encoding):
    shown, text = screen(width, encoding)
    for said in STORY:
        shown._take(said)
    found = text()
    found.encode(encoding)
    assert all(len(line) <= width for line in found.splitlines())
    assert "8 of 31" in found
    assert "cycle 8 STORED" in found
    assert "n 7" in found
    assert "RP 0.0" in found
    assert "0.108 mm" in found
    assert "Cycle 9" in found


def test_the_screen_shows_troubles_void_pause_and_end():
    shown, text = screen(80)
    for said in STORY:
        shown._take(said)
    shown._take(Problem("garbage", "X", "[red]\x1b[2Jboo"))
    shown._take(Refused("X", "1.0", "not asked for"))
    found = text()
    assert "1 garbage, 1 refused" in found
    assert "\x1b[2J" not in found
    shown._take(Voided(8, ("X", "Y"), "slipped"))
    assert "7 of 31" in text()
    assert "0.107 mm" in text()
    shown._take(Paused(True))
    assert "press p" in text()
    shown._take(Done(7, 31, "run.csv", "run.raw.jsonl"))
    assert "scara-iso record --resume run.csv" in text()


@pytest.mark.parametrize("record", [{"event": "session"}, {"event": "session", "t": 0.0}])
def test_a_raw_file_that_lacks_its_fields_is_no_defect(run, tmp_path, record):
    raw = tmp_path / "odd.raw.jsonl"
    raw.write_bytes(encode(record))
    assert run("record", "--rebuild", "odd.raw.jsonl")[0] == 65
    replayed = ("record", "a.csv", "--gauge", "X=opto-rs232@replay:odd.raw.jsonl")
    assert run(*replayed, "--trigger", "data")[0] in (2, 65)


def forged(tmp_path, port):
    """Return the raw file of a recording, changed to name another port."""
    raw = raw_path(tmp_path / "a.csv")
    lines = [decode_record(line) for line in raw.read_bytes().splitlines(keepends=True)]
    for record in lines:
        for gauge in record.get("gauges", {}).values():
            gauge["spec"] = f"X=opto-rs232@{port}"
    raw.write_bytes(b"".join(encode({k: v for k, v in r.items() if k != "crc"}) for r in lines))
    (tmp_path / "a.csv").unlink()
    (tmp_path / "a.manifest.json").unlink()
    return raw


def test_a_raw_file_does_not_choose_a_port_unasked(run, tmp_path):
    run("record", "a.csv", *X, *TIMER, "--cycles", "3")
    mine = tmp_path / "mine"
    mine.write_text("precious")
    raw = forged(tmp_path, f"spy://loop://?file={mine}")
    before = raw.read_bytes()
    code, out, err = run("record", "--resume", "a.csv", "--cycles", "5")
    assert (code, out) == (2, "")
    assert f"--gauge 'X=opto-rs232@spy://loop://?file={mine}'" in err
    assert (
        run("record", "--resume", "a.csv", "--gauge", f"X=opto-rs232@spy://loop://?file={mine}")[0]
        == 2
    )
    assert mine.read_text() == "precious"
    assert raw.read_bytes() == before
    assert run("record", "--resume", "a.csv", *X, "--cycles", "5")[0] == 0


def test_a_bench_of_another_dial_goes_on_with_no_recording(run, tmp_path):
    run("record", "a.csv", *X, *TIMER, "--cycles", "3")
    (tmp_path / "bench.toml").write_text('[gauges]\nX = "opto-rs232@sim:?pace=0&value=0.8"\n')
    before = raw_path(tmp_path / "a.csv").read_bytes()
    code, out, err = run("record", "--resume", "a.csv", "--cycles", "5")
    assert (code, out) == (2, "")
    assert "--gauge 'X=opto-rs232@sim:?pace=0'" in err
    assert raw_path(tmp_path / "a.csv").read_bytes() == before
    (tmp_path / "bench.toml").write_text('[gauges]\nX = "opto-rs232@sim:?pace=0"\n')
    assert run("record", "--resume", "a.csv", "--cycles", "5")[0] == 0


@pytest.mark.parametrize("beside", ["", '[gauges]\nX = "opto-rs232@sim:?pace=0&value=0.8"\n'])
@pytest.mark.parametrize(("answer", "code"), [("y\n", 0), ("n\n", 2), ("", 2)])
def test_the_ports_of_a_raw_file_are_shown_and_confirmed(
    run, tmp_path, monkeypatch, capsys, answer, code, beside
):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    run("record", "a.csv", *X, *TIMER, "--cycles", "3")
    if beside:
        (tmp_path / "bench.toml").write_text(beside)
    asked = []
    monkeypatch.setattr(recorder, "record", lambda job, **_: asked.append(job.gauges[0].address))
    monkeypatch.setattr(sys, "stdin", Terminal(answer))
    monkeypatch.setattr(sys, "stdout", shown := Terminal())
    monkeypatch.setattr(keyboard, "choose_operator", lambda *_, **__: None)
    assert main(["record", "--resume", "a.csv", "--cycles", "5"]) == code
    stopped = answer == "n\n"
    remark = (
        "scara-iso: gauges of bench.toml: X=opto-rs232@sim:?pace=0&value=0.8\n" if beside else ""
    )
    said = f"{remark}scara-iso: stopped; nothing was changed\n"
    assert (capsys.readouterr().err == said) == stopped
    assert "made with\n  X=opto-rs232@sim:?pace=0\n" in shown.getvalue()
    assert "The recording continues with the gauges that it" in shown.getvalue()
    assert asked == ["sim:?pace=0"] * (code == 0)


@pytest.mark.parametrize(
    ("poses", "said"),
    [(None, "run.csv: 3 of 31 cycles"), (("P1", "P2"), "run.csv: 3 of 62 visits")],
)
def test_the_end_counts_what_the_screen_counts(poses, said):
    shown, text = screen(80)
    shown._take(Started({"X": "a"}, 1, 31, "enter", poses and "P1", poses))
    for k in range(3):
        cycle, pose = (k // 2 + 1, poses[k % 2]) if poses else (k + 1, None)
        shown._take(CycleDone(cycle, discarded=False, pose=pose))
    shown._take(Done(1 if poses else 3, 31, "run.csv", "run.raw.jsonl"))
    assert said in text()


def test_a_pause_that_nobody_ends_is_refused(run, tmp_path):
    code, _, err = run("record", "a.csv", *X, *TIMER, "--cycles", "3", "--pause-on-alarm")
    assert code == 2
    assert "leave --pause-on-alarm out" in err
    assert not list(tmp_path.iterdir())
