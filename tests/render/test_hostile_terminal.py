"""What a terminal and a pipe are sent: no control character, no markup, the same words."""

import io
import re
import shutil
import unicodedata

import pytest
from hostile import TEXTS, WORDS, model, sweep, table

from scara_iso import read_table
from scara_iso.commands import main
from scara_iso.rawfile import encode
from scara_iso.recorder.ports.device import Device
from scara_iso.reporting.shared.digits import printable

STYLE = re.compile(r"\x1b\[[0-9;]*m")
CURSOR = re.compile(r"\x1b\[(?:\d*[A-DK]|\?25[lh])|\r")
"""What the screen of a recording draws with."""
NAME = "\x1b[2J\x9b31m\u202e[red]x[\\red][link=http:e]$x$\udcff\r\n.csv"
WIRE = b"\x1b[2J\x9b31m\xe2\x80\xae[red]\x07\x00\r" + b"".join(
    b"+000.10%dmm\r[red]\x1b]0;t\x07\r" % n for n in range(4)
)
SIM = ["--gauge", "X=opto-rs232@sim:?pace=0", "--trigger", "timer:1", "--cycles", "2"]
BACKLASH = ["backlash", "--Im", "1e-3", "--IL", "4", "--arcmin", "12"]


class Terminal(io.StringIO):
    """A terminal in colour."""

    def isatty(self):
        return True


@pytest.fixture
def sent(monkeypatch, capsys):
    """Return a function: exit code, and what one stream for both gets from a command."""

    def call(*arguments, terminal, width=5000):
        stream = Terminal() if terminal else io.StringIO()
        monkeypatch.setenv("COLUMNS", str(width))
        monkeypatch.setenv("TERM", "xterm-256color")
        monkeypatch.delenv("NO_COLOR", raising=False)
        with monkeypatch.context() as patch:
            patch.setattr("sys.stdout", stream)
            patch.setattr("sys.stderr", stream)
            code = main([*arguments])
        assert capsys.readouterr() == ("", "")
        return code, stream.getvalue()

    return call


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder of hostile files under hostile names."""
    path = tmp_path_factory.mktemp("terminal")
    table(path / "poses.xlsx", texts=[text for text in TEXTS if len(text) < 100])
    table(path / "one.xlsx", texts=TEXTS[14:18], poses=["[red]"], cycles=31)
    shutil.copy(path / "one.xlsx", path / NAME)
    sweep(path / "sweep.csv")
    model(path / f"{NAME}.toml", "\x1b[2J[red]\u202e")
    (path / f"{NAME}.wire").write_bytes(WIRE)
    return path


def unsafe(text):
    """Return the characters that a terminal or a reader could obey."""
    return {c for c in text if c != "\n" and unicodedata.category(c) in ("Cc", "Cf", "Zl", "Zp")}


def check(sent, *arguments, width=5000):
    """Check terminal and pipe, and return the exit code and what the pipe got."""
    code, piped = sent(*arguments, terminal=False, width=width)
    assert unsafe(piped) == set()
    again, shown = sent(*arguments, terminal=True, width=width)
    assert again == code
    plain = STYLE.sub("", shown)
    assert unsafe(plain) == set()
    assert answer(plain) == answer(piped)
    return code, piped


def answer(text):
    """Return a text without what a terminal is told of the files that were written."""
    return re.sub(r"^.* is written\n", "", text, flags=re.MULTILINE)


@pytest.mark.parametrize("text", TEXTS, ids=lambda text: ascii(text)[:24])
def test_analyze_shows_a_text_as_it_is(text, sent, tmp_path):
    source = table(tmp_path / "t.xlsx", texts=[text], poses=[f"p{text[:30]}", "P2"])
    code, said = check(
        sent, "analyze", str(source), "--cycles", "4", "--limit", "9", "--decision", "simple"
    )
    assert code == 0
    run = read_table(source)
    assert printable(run.metadata.get("robot", ""))[:80].strip() in said
    assert printable(run.pose[0]) in said


COMMANDS = (
    ["analyze", "poses.xlsx", "--cycles", "4"],
    ["analyze", NAME],
    ["diagnose", NAME],
    ["compare", NAME, "one.xlsx", "--plot", f"{NAME}.svg"],
    ["report", NAME, "-o", f"{NAME}.md"],
    ["plan", f"{NAME}.toml"],
    [*BACKLASH, "--measured", "sweep.csv"],
    [*BACKLASH, "--actual", NAME],
    ["ports", "--probe", f"replay:{NAME}.wire"],
    ["ports", "--probe", f"replay:{NAME}.wire", "--json"],
)


@pytest.mark.parametrize("width", [80, pytest.param(5000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("command", COMMANDS, ids=lambda words: ascii(" ".join(words))[:50])
def test_a_command(command, width, sent, folder, monkeypatch):
    monkeypatch.chdir(folder)
    code, said = check(sent, *command, width=width)
    assert said
    assert code not in (70, 74)


@pytest.mark.slow
def test_a_progress_bar_and_a_summary(sent, folder, monkeypatch):
    monkeypatch.chdir(folder)
    _, piped = sent("diagnose", NAME, f"no{NAME}", terminal=False)
    _, shown = sent("diagnose", NAME, f"no{NAME}", terminal=True)
    shown = CURSOR.sub("", STYLE.sub("", shown))
    assert unsafe(piped) == unsafe(shown) == set()
    assert shown.endswith(piped)


WRONG = (
    ["analyze", f"no{NAME}"],
    ["--debug", "analyze", f"no{NAME}"],
    ["analyze", "one.xlsx", "--limit", NAME],
    ["analyze", "one.xlsx", "--unit", NAME],
    ["analyze", "one.xlsx", "--sheet", NAME],
    ["analyze", "one.xlsx", f"--{NAME}"],
    ["diagnose", "one.xlsx", "--pose", NAME],
    ["diagnose", "--design", "--columns", NAME],
    ["report", "one.xlsx", "--model", NAME],
    ["report", "one.xlsx", "-o", f"{NAME}x"],
    ["report", NAME, "-o", f"{NAME}.toml"],
    ["plan", NAME],
    [*BACKLASH, "--measured", NAME],
    ["compare", f"no{NAME}", f"no{NAME}"],
    ["ports", "--probe", NAME],
    ["ports", "--probe", "sim:", "--ask", NAME],
    ["record", f"no{NAME}", "--gauge", NAME, "--trigger", "data"],
    ["record", f"no{NAME}", "--gauge", f"{NAME}=opto-rs232@sim:", "--trigger", "data"],
    ["record", f"no{NAME}", "--gauge", f"X=opto-rs232@{NAME}", "--trigger", "data"],
    ["record", f"no{NAME}", "--gauge", f"X=opto-rs232?{NAME}=1@sim:", "--trigger", "data"],
    ["record", f"no{NAME}", "--gauge", "X=opto-rs232@sim:", "--trigger", NAME],
    ["record", f"no{NAME}", *SIM, "--meta", NAME],
    ["record", f"no{NAME}", *SIM, "--meta", f"{NAME}=1"],
    ["record", f"no{NAME}", *SIM, "--meta-file", NAME],
    ["record", "--rebuild", NAME],
    [NAME],
)


@pytest.mark.parametrize("command", WRONG, ids=lambda words: ascii(" ".join(words))[:50])
def test_an_error(command, sent, folder, monkeypatch):
    monkeypatch.chdir(folder)
    code, said = check(sent, *command)
    assert code in (2, 65, 66, 69, 73)
    assert "scara-iso: " in said


def test_a_simulated_table(sent, folder, monkeypatch):
    monkeypatch.chdir(folder)
    _, piped = sent("simulate", f"{NAME}.toml", terminal=False)
    _, shown = sent("simulate", f"{NAME}.toml", terminal=True)
    assert unsafe(shown) == set()
    assert shown == piped.replace("\u202e", r"\u202e")
    assert "\u202e" in piped


def test_ports_of_this_machine(sent, monkeypatch):
    device = Device(NAME, f"[red]{NAME}", "067b:2303", NAME, "1-2")
    monkeypatch.setattr("scara_iso.recorder.list_devices", lambda: [device])
    _, said = check(sent, "ports")
    assert r"[red]\x1b[2J" in said


@pytest.mark.parametrize(
    ("gauge", "code", "end"),
    [("opto-rs232", 0, "2 of 2 cycles"), ("generic", 69, "no file is kept")],
)
def test_the_screen_of_a_recording(gauge, code, end, sent, folder, monkeypatch):
    monkeypatch.chdir(folder)
    monkeypatch.setattr("scara_iso.commands.operator.screen.REDRAW_S", -1)
    wire = f"X={gauge}?unit=mm@replay:{NAME}.wire"
    words = ["--gauge", wire, "--trigger", "data", "--cycles", "2", "--rearm", "0", "--quiet"]
    meta = [f"--meta=k{n}={text[:500]}" for n, text in enumerate(WORDS)]
    found, shown = sent("record", f"{gauge}{NAME}", *words, *meta, terminal=True, width=90)
    shown = CURSOR.sub("", STYLE.sub("", shown))
    assert found == code
    assert unsafe(shown) == set()
    assert r"[red]\x1b]0;t" in shown
    assert end in shown


def test_a_damaged_recording_made_into_a_table(sent, folder, monkeypatch):
    monkeypatch.chdir(folder)
    assert sent("record", f"a{NAME}", *SIM, terminal=False)[0] == 0
    (raw,) = folder.glob("a*.raw.jsonl")
    with raw.open("ab") as file:
        file.write(encode({"event": "note", "text": "x"})[:-9] + b"\n")
    code, shown = sent("record", "--rebuild", str(raw), f"b{NAME}", terminal=True)
    assert code == 0
    assert "torn or damaged" in shown
    assert "2 of 2 cycles" in shown
    assert unsafe(shown) == set()
