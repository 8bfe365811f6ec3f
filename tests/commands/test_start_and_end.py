"""How a command ends: a reader that leaves, Ctrl-C from the first moment on, a limit's reason."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from scara_iso.base.errors import UsageError
from scara_iso.commands import WELCOME, main
from scara_iso.commands.shared.options import parse_limits

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
TABLE = str(EXAMPLES / "fum_scara_table1.csv")
MODEL = str(EXAMPLES / "fum_scara.toml")
WARM_UP = str(EXAMPLES / "warm_up.csv")
FIRST_JOINT = ["--Im", "2.65e-4", "--IL", "4.749", "--arcmin", "12"]

SPEAKING = {
    "analyze": [TABLE],
    "analyze --limit": [TABLE, "--limit", "0.0001"],
    "diagnose": [TABLE],
    "report --limit": [TABLE, "-o", "out.md", "--limit", "0.0001"],
    "simulate": [MODEL],
    "plan": [MODEL],
    "compare": [str(EXAMPLES / "before_repair.csv"), str(EXAMPLES / "after_repair.csv")],
    "backlash": FIRST_JOINT,
    "ports": [],
    "demo": [],
    "explain": [],
    "--help": [],
    "--no-color": [],
    "--version": [],
}


def process(*arguments, **options):
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen([sys.executable, "-m", "scara_iso", *arguments], env=environment,
                            stderr=subprocess.PIPE, **options)  # fmt: skip


@pytest.fixture
def no_reader():
    """Return the writing end of a pipe whose reader has left."""
    reader, writer = os.pipe()
    os.close(reader)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    with os.fdopen(writer, "w", encoding="utf-8") as stream:
        yield stream
        os.dup2(nowhere, writer)  # what is left in it fails no more
    os.close(nowhere)


@pytest.mark.skipif(os.name == "nt", reason="a pipe that is closed has another error there")
@pytest.mark.parametrize("command", SPEAKING)
@pytest.mark.parametrize("json", [False, True])
def test_a_closed_pipe_is_an_output_that_cannot_be_written(
    tmp_path, monkeypatch, capsys, no_reader, command, json
):
    if json and command.startswith("--"):
        pytest.skip("no JSON")
    monkeypatch.chdir(tmp_path)
    name = command.split()[0]
    monkeypatch.setattr(sys, "stdout", no_reader)
    assert main([name, *SPEAKING[command], *(["--json"] if json else [])]) == 74
    sys.stdout.flush()  # what is left at the end of a process
    err = capsys.readouterr().err
    assert "Traceback" not in err
    assert "Exception" not in err


@pytest.mark.skipif(os.name == "nt", reason="a pipe that is closed has another error there")
@pytest.mark.parametrize("json", [False, True])
@pytest.mark.parametrize(
    "arguments",
    [
        ["analyze", TABLE],
        ["record", "run.csv", "--gauge", "X=opto-rs232@sim:?pace=0", "--trigger", "timer:1"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_a_process_whose_reader_leaves_ends_with_that_code(tmp_path, no_reader, arguments, json):
    words = [*arguments, *(["--json"] if json else [])]
    with process(*words, stdout=no_reader, cwd=tmp_path) as started:
        err = started.communicate()[1]
    assert started.returncode == 74
    assert b"Traceback" not in err
    assert b"Exception" not in err


@pytest.mark.skipif(os.name == "nt", reason="a pipe that is closed has another error there")
def test_an_error_that_nobody_hears_keeps_its_code(tmp_path, no_reader):
    done = subprocess.run(
        [sys.executable, "-m", "scara_iso", "analyze", "nowhere.csv"],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stderr=no_reader, stdout=subprocess.PIPE, check=False, cwd=tmp_path,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (66, b"")


INTERRUPT_AT = """
import os, signal, sys
from importlib.abc import MetaPathFinder

class Interrupting(MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == {name!r}:
            os.kill(os.getpid(), signal.SIGINT)

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.meta_path.insert(0, Interrupting())
sys.argv = ["scara-iso", *{arguments!r}]
from scara_iso.__main__ import run
run()
"""


@pytest.mark.skipif(os.name == "nt", reason="needs signals")
@pytest.mark.parametrize(
    "name",
    ["scara_iso.commands.app", "typer", "inspect", "scara_iso.commands.analyze", "numpy"],
)
def test_ctrl_c_within_an_import_ends_with_130_and_no_traceback(tmp_path, name):
    script = INTERRUPT_AT.format(name=name, arguments=["analyze", TABLE])
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, check=False, cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert done.returncode == 130
    assert b"Traceback" not in done.stderr


AT_THE_END = """
import atexit, os, sys
atexit.register(lambda: print("numpy" in sys.modules, os.environ["OPENBLAS_NUM_THREADS"]))
sys.argv = ["scara-iso", "--help"]
from scara_iso.__main__ import run
run()
"""


def test_the_threads_of_small_matrices_are_set_before_numpy_is_imported():
    """With a thread a core `diagnose` takes ten times as long; the help needs no numpy at all."""
    environment = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
    environment["PYTHONPATH"] = str(ROOT)
    script = [sys.executable, "-c", AT_THE_END]
    assert subprocess.check_output(script, text=True, env=environment).endswith("\nFalse 1\n")


def test_the_readme_lists_every_exit_code():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    table = text[text.index("| exit code |") :].split("\n\n")[0]
    named = {int(word) for row in table.splitlines()[2:] for word in row.split("|")[1].split(", ")}
    assert named == {0, 1, 2, 65, 66, 69, 70, 73, 74, 130}


@pytest.mark.parametrize(
    ("text", "limits"),
    [
        ("XY=0,02", {"XY": 0.02}),
        ("xy=0.02", {"XY": 0.02}),
        ("x=,5", {"X": 0.5}),
        ("Theta = 0,050", {"theta": 0.05}),
        ("0,020", {"": 0.02}),
        ("1,5", {"": 1.5}),
        ("1,0000", {"": 1.0}),
    ],
)
def test_a_limit_is_understood_as_it_is_written(text, limits):
    assert parse_limits([text]) == limits


@pytest.mark.parametrize(
    ("texts", "word"),
    [
        (["x="], "not a length"),
        (["="], "names no figure"),
        (["=0.02"], "names no figure"),
        (["XY=0,02,5"], "not a length"),
        (["1,000"], "two ways"),
        (["X=12,345"], "two ways"),
        (["x=1", "X=2"], "already"),
        (["nan"], "not a length"),
    ],
)
def test_a_limit_that_is_none_is_refused(texts, word):
    with pytest.raises(UsageError, match=word):
        parse_limits(texts)


def test_the_remedy_of_a_wrong_limit_works(tmp_path, monkeypatch, capsys):
    assert main(["analyze", TABLE, "--limit", "x="]) == 2
    remedy = capsys.readouterr().err.splitlines()[-1]
    written = [word.rstrip(",") for word in remedy.split() if "0.02" in word]
    for limit in written:
        assert main(["analyze", TABLE, "--limit", limit]) in (0, 1)


def test_a_report_outside_its_limit_says_why_it_ends_with_1(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["report", WARM_UP, "--limit", "XY=0.02", "-o", "out.md"]) == 1
    out, err = capsys.readouterr()
    assert out == "out.md is written\n"
    assert err.startswith("scara-iso: FAIL: OUTSIDE the limit with the whole 95 % interval: XY")
    assert main(["report", WARM_UP, "--limit", "XY=9", "-o", "out.md"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("thread", [False, True])
def test_what_is_to_be_done_at_the_end_is_done(tmp_path, thread):
    """A process that ends at once still does what was left for its end."""
    script = (
        "import atexit, threading, time; from scara_iso.__main__ import run\n"
        "atexit.register(print, 'swept')\n"
        "work = threading.Thread(target=lambda: (time.sleep(0.5), print('waited')))\n"
        f"if {thread}: work.start()\n"
        "run()"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, check=True, cwd=tmp_path, text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    said = done.stdout.replace(WELCOME, "").split()
    assert said == (["waited"] if thread else []) + ["swept"]


@pytest.mark.parametrize("person", [False, True])
def test_a_person_is_told_what_was_written(tmp_path, monkeypatch, capsys, person):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: person)
    assert main(["simulate", MODEL, "-o", "run.csv"]) == 0
    assert main(["plan", MODEL, "-o", "new.toml", "--picture", "plan.svg", "--json"]) == 0
    names = ["run.csv", "new.toml", "plan.svg"] if person else []
    assert capsys.readouterr().err == "".join(f"{name} is written\n" for name in names)


@pytest.mark.parametrize(
    ("name", "meant"), [("rnu.csv", "is it {}?"), ("other.csv", "check its name and its folder")]
)
@pytest.mark.parametrize("command", ["analyze", "simulate"])
def test_a_name_that_is_nearly_one_is_said(tmp_path, capsys, command, name, meant):
    (tmp_path / "run.csv").write_text("", encoding="utf-8")
    assert main([command, str(tmp_path / name)]) == 66
    assert meant.format(tmp_path / "run.csv") in capsys.readouterr().err


def test_the_table_of_a_recording_that_was_killed_can_be_made(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    gauges = ["--gauge", "X=opto-rs232@sim:?pace=0", "--trigger", "timer:0.1", "--cycles", "2"]
    assert main(["record", "my run.csv", *gauges]) == 0
    Path("my run.csv").unlink()
    capsys.readouterr()
    assert main(["analyze", "my run.csv"]) == 66
    remedy = capsys.readouterr().err.splitlines()[1].partition(" makes it")[0]
    assert main(shlex.split(remedy)) == 0
    assert Path("my run.csv").is_file()


ENDING_WITH = """
import os, signal, sys
for name in ("SIGINT", "SIGTERM", "SIGHUP"):
    signal.signal(getattr(signal, name), signal.SIG_DFL)
signal.signal(signal.SIGINT, signal.default_int_handler)
from scara_iso.base import files
from scara_iso.__main__ import run
import scara_iso.commands.app
{moment}
sys.argv = ["scara-iso", *{arguments!r}]
run()
"""

WITHIN_A_WRITE = """
sync = files.Disk.sync
def hear_and_sync(self, file):
    os.kill(os.getpid(), signal.{name})
    sync(self, file)
files.Disk.sync = hear_and_sync
"""

WITHIN_A_FINALISER = """
class Loud:
    def {method}(self, *_):
        os.kill(os.getpid(), signal.{name})
import weakref
from scara_iso.iso9283 import analysis
whole = analysis.analyze
def analyze(*arguments, **options):
    loud = Loud()
    follow = weakref.ref(loud, lambda _: os.kill(os.getpid(), signal.{name}))
    del loud
    import time
    time.sleep(20)
    return whole(*arguments, **options)
import scara_iso.commands.analyze as figures
figures.iso9283 = type("m", (), {{"analyze": staticmethod(analyze)}})
import scara_iso.iso9283
scara_iso.iso9283.analyze = analyze
"""


def ended(tmp_path, moment, arguments):
    script = ENDING_WITH.format(moment=moment, arguments=arguments)
    return subprocess.run(
        [sys.executable, "-c", script], capture_output=True, check=False, cwd=tmp_path, text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, timeout=60,
    )  # fmt: skip


@pytest.mark.skipif(os.name == "nt", reason="needs signals")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_while_a_file_is_written_waits_until_it_is_whole(tmp_path, name):
    arguments = ["simulate", MODEL, "-o", "run.csv"]
    done = ended(tmp_path, WITHIN_A_WRITE.format(name=name), arguments)
    assert done.returncode == 130
    assert done.stderr in ("scara-iso: interrupted\n", ""), "nothing where it had ended already"
    assert [path.name for path in tmp_path.iterdir()] == ["run.csv"]
    assert (tmp_path / "run.csv").read_text().count("\n") > 31


@pytest.mark.skipif(os.name == "nt", reason="needs signals")
@pytest.mark.parametrize("method", ["__del__", "other"], ids=["finaliser", "weak reference"])
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_an_interrupt_that_python_swallows_comes_again(tmp_path, method, name):
    moment = WITHIN_A_FINALISER.format(method=method, name=name)
    done = ended(tmp_path, moment, ["analyze", TABLE])
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "scara-iso: interrupted\n")


@pytest.mark.skipif(os.name == "nt", reason="needs signals")
def test_a_signal_that_is_to_be_ignored_is(tmp_path):
    moment = "signal.signal(signal.SIGHUP, signal.SIG_IGN)" + WITHIN_A_WRITE.format(name="SIGHUP")
    done = ended(tmp_path, moment, ["simulate", MODEL, "-o", "run.csv"])
    assert (done.returncode, done.stderr) == (0, "")
