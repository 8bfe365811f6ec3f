"""Every output of every command is checked before anything is read, opened or computed."""

import errno
import importlib
import json
import os
from itertools import pairwise
from pathlib import Path

import pytest
import typer

import scara_iso
from scara_iso import commands
from scara_iso.base.errors import CannotCreateError, NoInputError
from scara_iso.base.files import Disk
from scara_iso.commands import build_app, main
from scara_iso.commands.evidence import REGISTER
from scara_iso.rawfile import raw_path

ROOT = Path(__file__).parents[2]
MODEL = str(ROOT / "examples" / "fum_scara.toml")
TABLE, OTHER = (str(ROOT / "examples" / name) for name in ("fum_scara_table1.csv", "warm_up.csv"))
POSES, POSES_MODEL, MONTHS = (
    str(ROOT / "examples" / name) for name in ("five_poses.csv", "five_poses.toml", "months")
)
STREAM = str(ROOT / "examples" / "stream.csv")
GAUGES = ["--gauge", "X=opto-rs232@sim:?pace=0", "--trigger", "timer:0.1", "--cycles", "2"]
GONE = "nowhere.csv"

READ = {
    ("program", "folder"),
    ("record", "bench"),
    ("record", "meta_file"),
    ("record", "rebuild"),
    ("report", "meta_file"),
    ("test status", "path"),
}
"""Paths among the parameters that are read: every other one is written."""

WRITERS = {
    ("compare", "plot"): ["compare", GONE, GONE, "--plot", "out.svg"],
    ("diagnose", "map_"): ["diagnose", GONE, "--model", "no.toml", "--map", "out.csv"],
    ("diagnose", "plot"): ["diagnose", GONE, "--plot", "out.svg"],
    ("diagnose", "save_model"): [
        "diagnose", GONE, "--model", "no.toml", "--save-model", "out.toml",
    ],
    ("fleet", "to"): ["fleet", "nowhere", "-o", "out"],
    ("gauge-study", "to"): ["gauge-study", GONE, "--tolerance", "1", "-o", "out.html"],
    ("gauge-study", "plot"): ["gauge-study", GONE, "--tolerance", "1", "--plot", "out.svg"],
    ("history", "output"): ["history", "nowhere", "-o", "out.html"],
    ("plan", "output"): ["plan", "no.toml", "-o", "out.csv"],
    ("plan", "picture"): ["plan", "no.toml", "--picture", "out.svg"],
    ("program", "output"): [
        "program", "rapid", "nowhere", "--line", "1.2.3.4:5", "--replace", "-o", "out.mod",
    ],
    ("record", "table"): ["record", "out.csv", *GAUGES],
    ("report", "archive"): ["report", GONE, "--archive", "out.zip"],
    ("report", "to"): ["report", GONE, "--meta-file", "no.toml", "-o", "out.html"],
    ("selftest", "to"): ["selftest", "--report", "out.html"],
    ("fleet", "page"): ["fleet", GONE, "-o", "out", "--page", "out.html"],
    ("simulate", "output"): ["simulate", "no.toml", "-o", "out.csv"],
    ("tables", "output"): ["tables", GONE, "-o", "out.csv"],
    ("test new", "folder"): ["test", "new", "out", "--model", "no.toml"],
    ("visits", "output"): ["visits", GONE, "-o", "out.csv"],
}  # fmt: skip
"""A call for each output: its input is not there, and that must not be found out."""

FOLDERS = {("fleet", "to"), ("test new", "folder")}


def paths_of(command, name=""):
    """Yield every parameter that is a path, with the command's name."""
    for sub, found in getattr(command, "commands", {}).items():
        yield from paths_of(found, f"{name} {sub}".strip())
    if not hasattr(command, "commands"):
        yield from ((name, one.name) for one in command.params if "Path" in type(one.type).__name__)


def test_every_output_of_the_command_line_is_tried_here():
    found = set(paths_of(typer.main.get_command(build_app())))
    assert found - READ == set(WRITERS)
    assert found >= READ


def loop(path):
    path.symlink_to(path.name)


def dangling(path):
    path.symlink_to("/nowhere/at/all")


def pipe(path):
    os.mkfifo(path)


def folder_in_its_place(path):
    path.mkdir()


def not_there(path):
    """Nothing is there, nor the folder it would be in."""
    return path.parent / "no" / path.name


def below_a_file(path):
    (path.parent / "file").write_text("x")
    return path.parent / "file" / path.name


def too_long(path):
    return path.with_name("a" * 300 + path.suffix)


def below_proc(path):
    if not Path("/proc/self").is_dir():
        pytest.skip("needs /proc")
    return Path("/proc") / path.name


BAD = [loop, dangling, folder_in_its_place, not_there, below_a_file, too_long, below_proc]
BAD += [pipe] if hasattr(os, "mkfifo") else []
FINE_FOR_FOLDERS = (folder_in_its_place, not_there)


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Return a folder; nothing may be opened or computed in it."""

    def no(*_, **__):
        raise AssertionError("begun")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("scara_iso.recorder.recording.open_port", no)
    monkeypatch.setattr("scara_iso.commands.selftest.validate", no)
    return tmp_path


def call(writer, path):
    """Return the arguments with this output."""
    return [str(path) if word.startswith("out") else word for word in WRITERS[writer]]


def output_of(writer):
    return Path(next(word for word in WRITERS[writer] if word.startswith("out")))


def names(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


@pytest.mark.parametrize("bad", BAD, ids=lambda bad: bad.__name__)
@pytest.mark.parametrize("writer", WRITERS, ids=" ".join)
def test_what_cannot_be_written_is_refused_before_anything_is_done(place, capsys, writer, bad):
    if writer in FOLDERS and bad in FINE_FOR_FOLDERS:
        pytest.skip("such a folder is made, or gone on with")
    path = place / output_of(writer)
    path = bad(path) or path
    before = names(place)
    assert main(call(writer, path)) == 73
    out, err = capsys.readouterr()
    assert out == ""
    assert path.name in err
    assert len(err.splitlines()) in (2, 3), "what, where, and what to do"
    assert names(place) == before


KNOWS_ITS_OWN = {("program", "output"), ("report", "to"), ("report", "archive")}
"""One has `--replace` in its call; a report knows whose it is once its table is read."""
READINGS = "# software: scara-iso\ncycle,X\n1,0.5\n2,0.501\n"


@pytest.mark.parametrize("writer", sorted(set(WRITERS) - FOLDERS - KNOWS_ITS_OWN), ids=" ".join)
def test_what_another_wrote_is_not_overwritten(place, capsys, writer):
    path = place / output_of(writer)
    path.write_text(READINGS)
    assert main(call(writer, path)) == CannotCreateError.exit_code
    assert str(path) in capsys.readouterr().err
    assert path.read_text() == READINGS


@pytest.mark.parametrize("ending", [".html", ".csv", ".md"])
def test_a_report_overwrites_no_readings(place, capsys, ending):
    path = place / f"out{ending}"
    path.write_text(READINGS)
    assert main(["report", TABLE, "-o", str(path)]) == CannotCreateError.exit_code
    assert main(["report", TABLE, "-o", str(path), "--replace"]) == CannotCreateError.exit_code
    assert capsys.readouterr().err.count("remove it yourself") == 2, "no `--replace` helps"
    assert path.read_text() == READINGS
    path.unlink()
    assert [main(["report", TABLE, "-o", str(path)]) for _ in range(2)] == [0, 0]


REPORTS = ["out.html", "out.md", "out.csv", "out.xlsx", "out.json", "out.dfq", "out.zip"]


@pytest.mark.parametrize("name", REPORTS)
def test_another_report_is_overwritten_on_request_alone(tmp_path, monkeypatch, capsys, name):
    """Its page as its archive, and neither where one of the two is another's."""
    monkeypatch.chdir(tmp_path)
    to = ["-o", "page.html", "--archive", name] if name == "out.zip" else ["-o", name]
    assert main(["report", TABLE, *to]) == 0
    (tmp_path / "page.html").unlink(missing_ok=True)
    before = (tmp_path / name).read_bytes()
    register = (tmp_path / REGISTER).read_bytes()
    for there in (False, True):
        (tmp_path / REGISTER).write_bytes(register if there else b"")
        assert main(["report", OTHER, *to]) == CannotCreateError.exit_code
        assert f"{name}: is" in capsys.readouterr().err
        assert (tmp_path / name).read_bytes() == before
        assert not (tmp_path / "page.html").exists()
    assert [main(["report", OTHER, *to, *more]) for more in (["--replace"], [])] == [0, 0]
    assert (tmp_path / name).read_bytes() != before


@pytest.mark.parametrize(
    "arguments",
    [
        ["simulate", MODEL, "-o", "out.csv"],
        ["visits", STREAM, "--poses", "P1,-", "-o", "out.csv"],
        ["plan", MODEL, "-o", "out.csv"],
        ["plan", MODEL, "--picture", "out.svg"],
        ["plan", MODEL, "--picture", "out.png"],
        ["diagnose", TABLE, "--model", MODEL, "--save-model", "out.toml"],
        ["diagnose", POSES, "--model", POSES_MODEL, "--map", "out.csv"],
        ["history", MONTHS, "-o", "out.xlsx"],
        ["history", MONTHS, "-o", "out.csv"],
        ["report", TABLE, "--archive", "out.zip", "-o", "page.html"],
    ],
    ids=lambda arguments: f"{arguments[0]} {arguments[-1]}",
)
def test_what_the_program_wrote_is_written_anew(tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    (tmp_path / next(word for word in arguments if word.startswith("out"))).touch()
    assert [main(arguments) for _ in range(2)] == [0, 0]


@pytest.mark.parametrize(("number", "code"), [(errno.EROFS, 73), (errno.EACCES, 73),
                                              (errno.ENOSPC, 74), (errno.EDQUOT, 74)])  # fmt: skip
@pytest.mark.parametrize("operation", ["create", "write"])
@pytest.mark.parametrize("writer", WRITERS, ids=" ".join)
def test_a_disk_that_takes_nothing_is_found_first(
    place, capsys, monkeypatch, writer, operation, number, code
):
    def fail(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(Disk, operation, fail)
    assert main(call(writer, output_of(writer))) == code
    assert os.strerror(number) in capsys.readouterr().err
    assert names(place) == []


@pytest.mark.parametrize("writer", [one for one in WRITERS if one not in FOLDERS], ids=" ".join)
def test_a_file_that_is_protected_is_found_first(place, capsys, monkeypatch, writer):
    file = output_of(writer)
    file.write_text("mine")
    monkeypatch.setattr(
        os, "access", lambda path, mode: mode != os.W_OK or Path(path) != file.absolute()
    )
    assert main(call(writer, file)) == 73
    assert file.read_text() == "mine"
    assert names(place) == [str(file)]


@pytest.mark.skipif(os.name == "nt" or os.geteuid() != 0, reason="needs another user")
def test_a_folder_of_another_user_is_found_first(place, capsys):
    """Root may write anywhere: the command runs as nobody."""
    place.chmod(0o755)
    for above in place.parents:
        if above.stat().st_mode & 0o1 == 0:
            pytest.skip("another user does not come as far as here")
    child = os.fork()
    if child == 0:
        os.setuid(65534)
        os._exit(main(call(("simulate", "output"), "out.csv")))
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 73
    assert names(place) == []


def test_the_name_that_a_report_chooses_is_checked_too(place, capsys):
    (place / "nowhere.html").mkdir()
    assert main(["report", GONE]) == 73
    assert main(["report", GONE, "--json"]) == 66


@pytest.mark.parametrize("stem", ["a" * 246, "a" * 242])
def test_a_recording_needs_room_for_the_names_of_all_its_files(place, capsys, stem):
    """The raw file's name is longer than the table's, and the manifest's than that."""
    assert main(["record", f"{stem}.csv", *GAUGES]) == 73
    assert "name too long" in capsys.readouterr().err
    assert names(place) == []


def test_the_table_of_a_raw_file_is_checked_before_that_is_read(place, capsys):
    assert main(["record", "--rebuild", "no.raw.jsonl", "no/run.csv"]) == 73


@pytest.mark.parametrize("ending", [".csv", ".raw.jsonl", ".manifest.json"])
def test_no_recording_begins_where_a_link_leads_out_of_the_folder(place, capsys, ending):
    (place / f"out{ending}").symlink_to(place / "elsewhere")
    assert main(["record", "out.csv", *GAUGES]) == 73
    said = capsys.readouterr().err
    assert "exists already" in said
    assert ("--resume" in said) is False, "nothing was recorded"


LIBRARY = {
    "report": lambda to: scara_iso.report(GONE, to=to.with_suffix(".html")),
    "gauge_study": lambda to: scara_iso.gauge_study(GONE, tolerance=1, to=to.with_suffix(".html")),
    "selftest": lambda to: scara_iso.selftest(to.with_suffix(".html")),
    "fleet": lambda to: scara_iso.fleet("nowhere", to),
    "fleet_figures": lambda to: scara_iso.fleet_figures("nowhere", to),
    "new_test": lambda to: commands.new_test(to, "no.toml"),
    "record": lambda to: scara_iso.record(
        to.with_suffix(".csv"), ["X=opto-rs232@sim:"], trigger="timer:1"
    ),
}


@pytest.mark.parametrize("function", LIBRARY)
def test_the_library_checks_as_the_commands_do(place, function):
    (place / "file").write_text("x")
    with pytest.raises(CannotCreateError, match="Not a directory"):
        LIBRARY[function](place / "file" / "out")


@pytest.mark.parametrize(
    "arguments",
    [
        ["analyze", "LONG"], ["diagnose", "LONG"], ["report", "LONG", "--json"],
        ["compare", "LONG", "LONG"], ["tables", "LONG"], ["visits", "LONG"], ["push", "LONG"],
        ["gauge-study", "LONG", "--tolerance", "1"], ["history", "LONG"], ["plan", "LONG"],
        ["simulate", "LONG"], ["simulate", MODEL, "--effects", "LONG"],
        ["diagnose", TABLE, "--model", "LONG"], ["fleet", "LONG", "-o", "out"],
        ["test", "status", "LONG"], ["test", "new", "out", "--model", "LONG"],
        ["record", "--rebuild", "LONG.raw.jsonl", "run.csv"],
        ["backlash", "--Im", "1", "--IL", "1", "--arcmin", "1", "--measured", "LONG"],
        ["record", "run.csv", *GAUGES, "--meta-file", "LONG"],
        ["record", "run.csv", "--bench", "LONG"], ["explain", "--effects", "LONG"],
        ["report", "LONG", "-o", "out.html"],
    ],
    ids=" ".join,
)  # fmt: skip
@pytest.mark.parametrize("ending", [".csv", ""])
def test_an_input_with_too_long_a_name_is_none(tmp_path, monkeypatch, capsys, arguments, ending):
    monkeypatch.chdir(tmp_path)
    name = "b" * 300 + ending
    words = [word.replace("LONG", name) for word in arguments]
    assert main(words) == 66, capsys.readouterr().err
    assert len(capsys.readouterr().err.splitlines()) <= 3
    assert names(tmp_path) == []


READERS = {
    "analyze": scara_iso.analyze,
    "diagnose": scara_iso.diagnose,
    "model": lambda name: scara_iso.diagnose(TABLE, name),
    "hold out": lambda name: scara_iso.diagnose(TABLE, hold_out=name),
    "report": scara_iso.report,
    "compare": lambda name: scara_iso.compare(TABLE, name),
    "gauge_study": lambda name: scara_iso.gauge_study(name, tolerance=1),
    "history": scara_iso.history,
    "fleet": lambda name: scara_iso.fleet(name, "out"),
    "fleet_figures": lambda name: scara_iso.fleet_figures(name, "out"),
    "plan": scara_iso.plan,
    "simulate": scara_iso.simulate,
    "visits": scara_iso.visits,
    "push": scara_iso.push,
    "new_test": lambda name: commands.new_test("out", name),
    "read_conditions": commands.read_conditions,
}


@pytest.mark.parametrize("reader", READERS)
def test_too_long_a_name_is_no_input_of_the_library_either(tmp_path, monkeypatch, reader):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(NoInputError):
        READERS[reader]("b" * 300 + ".csv")


@pytest.mark.parametrize(
    "writer", [("compare", "plot"), ("diagnose", "plot"), ("gauge-study", "plot"),
               ("plan", "picture"), ("diagnose", "map_"), ("gauge-study", "to"),
               ("history", "output"), ("report", "to"), ("selftest", "to")],
    ids=" ".join,
)  # fmt: skip
def test_an_ending_that_no_writer_knows_is_refused_first(place, capsys, writer):
    assert main(call(writer, place / "out.doc")) == 2
    assert "let the name end in" in capsys.readouterr().err
    assert names(place) == []


def test_the_map_of_every_condition_is_checked_before_the_first_begins(place, capsys, monkeypatch):
    words = ["test", "new", "new", "--model", MODEL, "--velocities", "100,50"]
    assert main(words) == 0
    conditions = [one.condition.name for one in commands.read_conditions("new")]
    (place / f"m-{conditions[-1]}.csv").mkdir()
    assert main(["diagnose", "new", "--model", MODEL, "--map", "m.csv"]) == 73
    assert f"m-{conditions[-1]}.csv" in capsys.readouterr().err


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the benchmark forks")
def test_the_benchmark_of_kills_ends_every_writer(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    calls = [set(words) for _, words in importlib.import_module("kills").COMMANDS.values()]
    for (command, _), words in WRITERS.items():
        option = next(a for a, b in pairwise(words) if b.startswith("out"))
        assert any({*command.split(), option} <= call for call in calls), (command, option)


def test_resuming_is_advised_where_something_was_stored(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.csv").write_text("another's\n")
    assert main(["record", "run.csv", *GAUGES]) == 73
    assert "--resume" not in capsys.readouterr().err
    (tmp_path / "run.csv").unlink()
    raw_path(tmp_path / "run.csv").write_text("begun\n")
    assert main(["record", "run.csv", *GAUGES]) == 73
    assert "--resume" in capsys.readouterr().err


@pytest.mark.parametrize("words", [
    ["tables", "examples/fum_scara_table1.csv", "-o"],
    ["gauge-study", "examples/dial_type_1.csv", "--tolerance", "0.03", "-o"],
])  # fmt: skip
def test_what_is_written_is_said_beside_the_answer(words, tmp_path, capsys):
    path = tmp_path / "out.csv"
    assert main([*words, str(path)]) in (0, 1)
    assert f"{path} is written" in capsys.readouterr().out
    path.unlink()
    assert main([*words, str(path), "--json"]) in (0, 1)
    said = capsys.readouterr()
    assert json.loads(said.out)
    assert f"{path} is written" in said.err
