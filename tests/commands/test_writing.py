"""Every command leaves the old file or the new one, and no file that is not its own to write."""

import contextlib
import os
import stat
from pathlib import Path

import pytest

from scara_iso.base.errors import CannotCreateError, WriteError
from scara_iso.base.files import Disk, write_file
from scara_iso.commands import main
from scara_iso.commands.evidence import REGISTER
from scara_iso.rawfile import manifest_path, raw_path

ROOT = Path(__file__).parents[2]
MODEL = str(ROOT / "examples" / "fum_scara.toml")
TABLE = str(ROOT / "examples" / "fum_scara_table1.csv")
AFTER = str(ROOT / "examples" / "after_repair.csv")
BEFORE = str(ROOT / "examples" / "before_repair.csv")
X = ["--gauge", "X=opto-rs232@sim:?pace=0", "--trigger", "timer:0.1"]

WRITERS = {
    **{
        f"report{kind}": (f"out{kind}", ["report", TABLE, "-o"])
        for kind in (".html", ".md", ".csv", ".xlsx", ".pdf", ".json")
    },
    "simulate": ("out.csv", ["simulate", MODEL, "-o"]),
    "plan": ("out.csv", ["plan", MODEL, "-o"]),
    "plan --picture": ("out.svg", ["plan", MODEL, "--picture"]),
    "compare --plot": ("out.png", ["compare", BEFORE, AFTER, "--plot"]),
    "diagnose --plot": ("out.svg", ["diagnose", TABLE, "--plot"]),
    "diagnose --save-model": ("out.toml", ["diagnose", TABLE, "--model", MODEL, "--save-model"]),
}
"""Each command that writes a file: the file's name, and the arguments in front of it."""

every_writer = pytest.mark.parametrize("writer", WRITERS)
writes = pytest.mark.parametrize(
    "writer",
    [pytest.param(name, marks=[pytest.mark.slow] if "pdf" in name else []) for name in WRITERS],
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@contextlib.contextmanager
def room_for(size):
    """Let no file grow larger than ``size`` bytes: what a full disk does."""
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@every_writer
@pytest.mark.parametrize("name", ["", ".", "/", ".."])
def test_a_name_of_no_file_is_no_defect(folder, capsys, writer, name):
    assert main([*WRITERS[writer][1], name]) in (2, 73)


@every_writer
def test_a_name_that_no_disk_takes_is_refused(folder, capsys, writer):
    out, arguments = WRITERS[writer]
    assert main([*arguments, "a" * 300 + Path(out).suffix]) == 73
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("name", ["", ".", "/", "..", "./"])
@pytest.mark.parametrize("more", [[], ["--resume"]])
def test_a_recording_of_no_name_is_no_defect(folder, capsys, name, more):
    assert main(["record", name, *X, *more]) in (66, 73)
    assert list(folder.iterdir()) == []


# openpyxl's temporary file would meet the limit first
@pytest.mark.parametrize("writer", [name for name in WRITERS if name != "report.xlsx"])
def test_a_full_disk_leaves_the_old_file_and_nothing_else(folder, capsys, writer):
    name, arguments = WRITERS[writer]
    (folder / name).write_text("the old one")
    with room_for(100):
        assert main([*arguments, name]) == 74
    assert (folder / name).read_text() == "the old one"
    assert [path.name for path in folder.iterdir()] == [name]
    assert len(capsys.readouterr().err.splitlines()) <= 3


OLD = "<!-- scara-iso fum_scara_table1.csv scatter.csv warm_up.csv -->"
"""What the program would have written itself."""


@writes
def test_another_name_of_what_is_there_is_written_anew(folder, capsys, writer):
    name, arguments = WRITERS[writer]
    old = folder / name
    old.write_text(OLD)
    old.chmod(0o640)
    os.link(old, folder / "kept")
    (folder / f"{name}.part").write_text("mine")
    assert main([*arguments, name]) == 0, capsys.readouterr().err
    assert len(old.read_bytes()) > 100
    assert stat.S_IMODE(old.stat().st_mode) == 0o640
    assert (folder / "kept").read_text() == OLD
    assert (folder / f"{name}.part").read_text() == "mine"
    assert len(list(folder.iterdir())) == 3 + (folder / REGISTER).exists()  # of a report


@every_writer
def test_no_recording_is_written_over(folder, capsys, writer):
    name, arguments = WRITERS[writer]
    recorded = "run.csv" if name.endswith(".csv") else name
    assert main(["record", "run.csv", *X, "--cycles", "2"]) == 0
    for place in (Path, raw_path, manifest_path):  # somebody gave it another name
        place(Path("run.csv")).rename(place(Path(recorded)))
    before = contents(folder)
    (folder / f"link{Path(name).suffix}").symlink_to(recorded)
    for target in (recorded, f"link{Path(name).suffix}"):
        assert main([*arguments, target]) == 73
        assert "holds a recording" in capsys.readouterr().err
        assert contents(folder) == before


def contents(folder):
    return {path: path.read_bytes() for path in folder.iterdir() if not path.is_symlink()}


@pytest.mark.parametrize("name", ["run.raw.jsonl", "run.manifest.json", "other.jsonl", "gone.csv"])
def test_nor_is_its_raw_file_or_manifest_by_any_name(folder, capsys, name):
    main(["record", "run.csv", *X, "--cycles", "2"])
    (folder / "other.jsonl").write_bytes((folder / "run.raw.jsonl").read_bytes())
    (folder / "gone.raw.jsonl").write_bytes((folder / "run.raw.jsonl").read_bytes())
    before = contents(folder)
    assert main(["simulate", MODEL, "-o", name]) == 73
    assert contents(folder) == before


@pytest.mark.parametrize(
    "arguments",
    [
        ["simulate", "own.toml", "-o"],
        ["plan", "own.toml", "-o"],
        ["plan", "own.toml", "--picture"],
        ["report", TABLE, "--model", "own.toml", "-o"],
        ["report", "own.csv", "-o"],
        ["compare", "own.csv", TABLE, "--plot"],
        ["diagnose", "own.csv", "--plot"],
        ["diagnose", TABLE, "--hold-out", "own.csv", "--plot"],
        ["diagnose", TABLE, "--model", "own.toml", "--plot"],
        ["diagnose", TABLE, "--model", "own.toml", "--save-model"],
    ],
)
def test_no_command_writes_over_what_it_reads(folder, capsys, arguments):
    (folder / "own.toml").write_bytes(Path(MODEL).read_bytes())
    (folder / "own.csv").write_bytes(Path(TABLE).read_bytes())
    own = next(word for word in arguments if word.startswith("own."))
    before = contents(folder)
    ending = ".html" if arguments[0] == "report" else ".svg"
    os.link(folder / own, folder / f"hard{ending}")
    (folder / f"soft{ending}").symlink_to(folder / own)
    for target in (f"hard{ending}", f"soft{ending}"):
        assert main([*arguments, target]) == 73
        assert "an input of this command" in capsys.readouterr().err
        assert {path: path.read_bytes() for path in before} == before


def test_one_file_is_not_named_twice(folder, capsys):
    assert main(["plan", MODEL, "--picture", "a.svg", "-o", "./a.svg"]) == 2
    assert "named for two outputs" in capsys.readouterr().err
    assert list(folder.iterdir()) == []


@pytest.mark.skipif(os.name == "nt", reason="needs a mask")
def test_a_new_file_has_the_permissions_that_the_mask_leaves(folder):
    before = os.umask(0o027)
    try:
        write_file(folder / "new", b"x")
    finally:
        os.umask(before)
    assert stat.S_IMODE((folder / "new").stat().st_mode) == 0o640


def test_a_link_goes_on_pointing_to_what_it_names(folder):
    (folder / "there").mkdir()
    (folder / "link").symlink_to("there/file")
    for data in (b"first", b"second"):
        write_file(folder / "link", data)
        assert (folder / "link").is_symlink()
        assert (folder / "there" / "file").read_bytes() == data


@pytest.mark.skipif(not Path("/dev/null").exists(), reason="needs devices")
def test_devices_stay_devices(folder):
    write_file(Path(os.devnull), b"x")
    assert stat.S_ISCHR(Path(os.devnull).stat().st_mode)
    if Path("/dev/full").exists():
        with pytest.raises(WriteError, match="No space left"):
            write_file(Path("/dev/full"), b"x")


@pytest.mark.skipif(not Path("/dev/stdout").exists(), reason="needs /dev/stdout")
@pytest.mark.parametrize("append", [False, True])
def test_standard_output_by_its_name_goes_on_where_it_is(folder, append):
    (folder / "log").write_text("before\n")
    flags = os.O_WRONLY | (os.O_APPEND if append else os.O_TRUNC)
    kept, log = os.dup(1), os.open(folder / "log", flags)
    try:
        os.dup2(log, 1)
        write_file(Path("/dev/stdout"), b"one\n")
        os.write(1, b"two\n")
    finally:
        os.dup2(kept, 1)
    assert (folder / "log").read_text() == ("before\n" if append else "") + "one\ntwo\n"


@pytest.mark.parametrize("path", ["nowhere/file", "file/below", "folder"])
def test_a_place_where_nothing_can_be_is_named(folder, path):
    (folder / "file").write_text("x")
    (folder / "folder").mkdir()
    with pytest.raises(CannotCreateError, match="cannot be written"):
        write_file(folder / path, b"x")


def test_a_file_that_is_protected_is_not_replaced(folder, monkeypatch):
    (folder / "file").write_text("mine")
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).name != "file")
    with pytest.raises(CannotCreateError, match="Permission denied"):
        write_file(folder / "file", b"x")
    assert (folder / "file").read_text() == "mine"


@pytest.mark.parametrize("operation", ["create", "write", "sync", "replace"])
def test_whatever_fails_the_old_file_is_there_alone(folder, operation):
    class Failing(Disk):
        pass

    def fail(*_):
        raise OSError(5, "injected")

    setattr(Failing, operation, fail)
    (folder / "file").write_text("old")
    with pytest.raises(WriteError, match="injected"):
        write_file(folder / "file", b"new", Failing())
    assert contents(folder) == {folder / "file": b"old"}


def test_an_interrupt_leaves_the_old_file_alone(folder):
    class Interrupted(Disk):
        def sync(self, file):
            raise KeyboardInterrupt

    (folder / "file").write_text("old")
    with pytest.raises(KeyboardInterrupt):
        write_file(folder / "file", b"new", Interrupted())
    assert contents(folder) == {folder / "file": b"old"}


def test_what_was_made_while_an_interrupt_was_swallowed_is_not_written(folder, monkeypatch):
    """A library that catches everything leaves something out, and goes on."""
    (folder / "file").write_text("old")
    monkeypatch.setattr("scara_iso.base.process._heard", [2])
    with pytest.raises(KeyboardInterrupt):
        write_file(folder / "file", b"new")
    assert contents(folder) == {folder / "file": b"old"}


@pytest.mark.parametrize("name", ["run.xlsx", "run.json", "run.PDF"])
@pytest.mark.parametrize(
    "command",
    [
        ["record", "--gauge", "X=opto-rs232@sim:", "--trigger", "timer:1", "--cycles", "2"],
        ["tables", "examples/fum_scara_table1.csv", "-o"],
        ["simulate", "examples/fum_scara.toml", "-o"],
    ],
)
def test_a_table_is_not_written_under_another_kind_of_name(tmp_path, capsys, command, name):
    command = [str(ROOT / word) if word.startswith("examples") else word for word in command]
    assert main([*command, str(tmp_path / name)]) == 2
    assert "name it run.csv" in capsys.readouterr().err
    assert [*tmp_path.iterdir()] == []


def test_a_raw_file_is_no_table(tmp_path, capsys):
    table = tmp_path / "run.csv"
    gauge = ["--gauge", "X=opto-rs232@sim:?pace=0"]
    assert main(["record", str(table), *gauge, "--trigger", "timer:1", "--cycles", "2"]) == 0
    capsys.readouterr()
    assert main(["analyze", str(tmp_path / "run.raw.jsonl")]) == 65
    assert "record --rebuild" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("tables", "name"), [(["P1.csv"], "P1"), (["P1.csv", "P2.csv"], "report"), (["."], "report")]
)
def test_a_page_has_the_name_of_its_table_where_it_is_of_one(
    tables, name, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    for pose in (1, 2):
        rows = "".join(f"{k},0.{pose}{k % (6 + pose)}\n" for k in range(1, 32))
        Path(f"P{pose}.csv").write_text(f"# unit: mm\ncycle,X\n{rows}")
    Path(f"{name}.html").write_text("mine")
    assert main(["report", *tables]) == 73
    assert f"{name}.html" in capsys.readouterr().err
    assert Path(f"{name}.html").read_text() == "mine"
