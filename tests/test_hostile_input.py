"""What is read cannot harm: bounded in time, memory and reach, and no input is a defect."""

import ast
import importlib
import io
import json
import os
import pkgutil
import re
import subprocess
import sys
import warnings
import zlib
from pathlib import Path

import pytest
from source import nodes_of

import scara_iso
from scara_iso import effects, read_table
from scara_iso.base.errors import DataError, NoInputError, ScaraIsoError
from scara_iso.base.plugins import find_modules
from scara_iso.commands import main
from scara_iso.commands.operator.keyboard import Lines
from scara_iso.commands.shared import inputs
from scara_iso.effects import find_effects
from scara_iso.iso9283 import checks
from scara_iso.rawfile.integrity import decode_record
from scara_iso.recorder import Quit, Take, indicators

ROOT = Path(__file__).parents[1]
HEAD = "# unit: mm\n# resolution: 0.001\ncycle,X,Y\n"
UNBOUNDED = 100


def read_or_refuse(text):
    try:
        return read_table(text.encode())
    except ScaraIsoError as error:
        return error


LONG = """
from scara_iso.diagnosis import read_sweep
from scara_iso.base.errors import ScaraIsoError
from scara_iso.base.quantities import find_unit
from scara_iso.tables import read_table
lines = ["-" * 60 + "a", "-" * 90_000 + "a", "--- " * 20_000 + "a", "x" + " " * 90_000 + "y",
         "x" + " _" * 40_000 + "axis", "(" * 90_000, "1" * 90_000 + "e", "#" * 90_000,
         "=" * 99 + ":", "axis " * 16_000 + "!", "x axis," * 12_000, "1e" + "9" * 90_000,
         '"' * 90_000]
for line in lines:
    for text in (f"# unit: mm\\ncycle,X,Y\\n{line}\\n1,0.1,0.2\\n",
                 f"{line}\\ncycle,X,Y\\n1,0.1,0.2\\n",
                 f"# unit: {line}\\ncycle,X,Y\\n1,0.1,0.2\\n", f"cycle,X {line},Y\\n1,0.1,0.2\\n",
                 f"# unit: mm\\ncycle,X,Y\\n1,0.1,{line}\\n"):
        for read in (read_table, read_sweep):
            try:
                read(text.encode())
            except ScaraIsoError:
                pass
    find_unit(line + "\\n")
    find_unit("1" + " " * 90_000 + "\\n")
"""


@pytest.mark.slow
def test_lines_made_to_keep_a_pattern_busy_are_answered():
    """The limit is for a machine under load: the slowest line alone took 2 ** 20 years before."""
    done = subprocess.run([sys.executable, "-c", LONG], cwd=ROOT, timeout=300, check=False)
    assert done.returncode == 0


def unbounded_in_unbounded(pattern):  # noqa: C901 - a tree is walked
    """Return whether a pattern repeats without bound what itself repeats without bound."""
    parser = re._parser

    def walk(items, inside):
        for op, argument in items:
            if str(op) in ("MAX_REPEAT", "MIN_REPEAT", "POSSESSIVE_REPEAT"):
                _, most, body = argument
                endless = most >= UNBOUNDED
                if (endless and inside) or walk(body, inside or endless):
                    return True
            elif any(walk(part, inside) for part in parts(argument)):
                return True
        return False

    def parts(argument):
        if isinstance(argument, parser.SubPattern):
            yield argument
        elif isinstance(argument, tuple | list):
            for part in argument:
                yield from parts(part)

    return walk(parser.parse(pattern), inside=False)


def patterns():
    """Yield the regular expressions of the package: those of modules, and those in calls."""
    for module in pkgutil.walk_packages(scara_iso.__path__, "scara_iso."):
        if module.name.endswith("__main__"):
            continue
        loaded = importlib.import_module(module.name)
        held = list(vars(loaded).values())
        for value in held:
            values = value.values() if isinstance(value, dict) else value
            held += values if isinstance(value, dict | tuple) else []
            if isinstance(value, re.Pattern):
                yield value.pattern
        for node in nodes_of(Path(loaded.__file__)):
            match node:
                case ast.Call(
                    func=ast.Attribute(value=ast.Name(id="re")),
                    args=[ast.Constant(value=str() | bytes() as text), *_],
                ):
                    yield text


def test_no_pattern_of_the_package_repeats_a_repeated_part():
    assert unbounded_in_unbounded(r"[-=]{3,}(?:[, ]*[-=]{3,})*")
    found = set(patterns())
    assert len(found) > 60
    assert [pattern for pattern in found if unbounded_in_unbounded(pattern)] == []


JUNK = ("-------", "Mean,1,2", "# said", "Inspector: A", "1,x,2", ",,", "--- ---a", '1,"2')


@pytest.mark.parametrize(
    "row", ["junk", *(pytest.param(row, marks=pytest.mark.slow) for row in JUNK)]
)
def test_junk_is_not_read_to_its_end(row):
    error = read_or_refuse(HEAD + f"{row}\n" * 200_000)
    assert isinstance(error, DataError)
    said = " ".join([error.what, *(fault.message for fault in error.faults)])
    assert "the rest was not read" in said or "more than 30000 cells" in said


@pytest.mark.parametrize("cell", ["0.8", "0.81", "0.", "0"])
def test_a_file_cut_inside_its_last_reading_is_refused(cell):
    rows = "".join(f"{k},0.112,0.8{k % 9}2\n" for k in range(1, 31))
    error = read_or_refuse(f"{HEAD}{rows}31,0.112,{cell}")
    assert isinstance(error, DataError)
    assert (error.faults[0].line, error.faults[0].column) == (34, 3)
    assert "cut" in error.faults[0].message
    assert "end its last line" in error.remedy
    assert len(read_or_refuse(f"{HEAD}{rows}31,0.112,{cell}\n")) == 31
    assert len(read_or_refuse(f"{HEAD}{rows}31,0.112,0.812")) == 31


def test_a_cut_last_number_without_a_resolution_is_noted():
    rows = "".join(f"{k},0.112,0.8{k % 9}2\n" for k in range(1, 31))
    run = read_or_refuse(f"# unit: mm\ncycle,X,Y\n{rows}31,0.112,0.8")
    assert any("is the file cut?" in note for note in run.origin.notes)
    assert any("is the file cut?" in remark for remark in run.origin.remarks)


@pytest.fixture
def odd_files(tmp_path):
    """Return names of what is no file: a pipe, a folder, a device, nothing."""
    if not hasattr(os, "mkfifo"):
        pytest.skip("no named pipes here")
    os.mkfifo(tmp_path / "pipe")
    return [str(tmp_path / "pipe"), str(tmp_path), "/dev/zero", "", ".", "/", "a\x00b", "a.\ud800"]


COMMANDS = [
    ["analyze", "FILE"], ["diagnose", "FILE"], ["report", "FILE"], ["compare", "FILE", "FILE"],
    ["simulate", "FILE"], ["plan", "FILE"], ["record", "--rebuild", "FILE"],
    ["record", "a.csv", "--gauge", "X=opto-rs232@sim:", "--trigger", "data", "--meta-file", "FILE"],
    ["record", "a.csv", "--gauge", "X=opto-rs232@replay:FILE", "--trigger", "data"],
    ["record", "a.csv", "--gauge", "X=opto-rs232@sim:?model=FILE", "--trigger", "data"],
    ["backlash", "--Im", "1", "--IL", "2", "--arcmin", "3", "--measured", "FILE"],
    ["diagnose", str(ROOT / "examples" / "fum_scara_table1.csv"), "--model", "FILE"],
]  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS, ids=lambda c: " ".join(c)[:40])
def test_what_is_no_file_is_refused_and_not_waited_for(command, odd_files, tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    for name in odd_files:
        assert main([word.replace("FILE", name) for word in command]) in (2, 65, 66), name


@pytest.mark.parametrize("number", ["1" * 5000, "-" + "9" * 5000, "0x" + "f" * 5000, "1e999"])
def test_a_number_of_any_length_in_a_model_is_no_defect(number, tmp_path, capsys):
    model = tmp_path / "m.toml"
    model.write_text(f"[indicator.X]\nlevel = {number}\n")
    assert main(["simulate", str(model)]) == 65
    assert main(["record", "a.csv", "--gauge", "X=opto-rs232@sim:", "--trigger", "data",
                 "--meta-file", str(model)]) == 65  # fmt: skip
    assert "defect" not in capsys.readouterr().err


def declare(folder, monkeypatch, text, name="theirs"):
    """Install a distribution that has these bytes for its entry points."""
    declared = folder / f"{name}-1.0.dist-info"
    declared.mkdir()
    (declared / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (declared / "entry_points.txt").write_bytes(text)
    monkeypatch.syspath_prepend(folder)


BROKEN = {
    "exits": "raise SystemExit(3)",
    "fails": "import no_such_module_at_all",
    "leaves": "raise BaseException('gone')",
    "has_nothing": "x = 1",
    "has_another_shape": "DIALECT = CODE = EFFECT = check = 5",
    "is_no_python": "def",
}


@pytest.mark.parametrize("package", [checks, effects, indicators], ids=lambda p: p.__name__)
@pytest.mark.parametrize("kind", sorted(BROKEN))
def test_a_broken_plugin_is_named_and_left_out(tmp_path, monkeypatch, package, kind):
    group = package.__name__
    before = find_modules(package, group)
    name = f"plugin_{kind}_{group.rpartition('.')[2]}"
    (tmp_path / f"{name}.py").write_text(BROKEN[kind])
    declare(tmp_path, monkeypatch, f"[{group}]\nbad = {name}\n".encode())
    with pytest.warns(UserWarning, match=f"plugin bad .{name}. of {group} is left out"):
        assert find_modules(package, group) == before


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize(
    "content", [b"\xff\xfe[scara_iso.effects]\n", b"[scara_iso.effects]\nnothing\n",
                b"[scara_iso.effects]\n\xff = x\n", b"[scara_iso.effects\n= =\n"]
)  # fmt: skip
def test_entry_points_that_cannot_be_read_are_left_out(tmp_path, monkeypatch, capsys, content):
    declare(tmp_path, monkeypatch, content)
    effects._catalogue.cache_clear()
    try:
        assert main(["explain"]) == 0
        assert "defect" not in capsys.readouterr().err
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            assert len(find_effects()) > 10
    finally:
        effects._catalogue.cache_clear()


def test_an_endless_line_is_read_in_pieces_and_makes_no_command():
    class Endless(io.TextIOBase):
        sizes: list[int] = []  # noqa: RUF012 - one test's

        def readline(self, size=-1):
            self.sizes.append(size)
            return "x" * size if len(self.sizes) < 2000 else ""

    lines = Lines(Endless())
    lines._follower.join()
    assert set(Endless.sizes) == {1000}
    assert lines._lines.qsize() == 2


def test_more_lines_than_are_taken_wait_for_their_turn():
    class Many(io.TextIOBase):
        given = 0

        def readline(self, _size=-1):
            self.given += 1
            return "\n" if self.given <= 2500 else ""

    many = Many()
    lines = Lines(many)
    found = []
    while Quit() not in found:
        assert many.given <= len(found) + 1002
        command = lines.poll()
        found += [command] if command else []
    assert found.count(Take()) == 2500


def test_a_pipe_of_a_model_is_no_file(odd_files):
    with pytest.raises(NoInputError, match="regular file"):
        read_table(odd_files[0])


@pytest.mark.parametrize(
    ("event", "key", "value"),
    [("stored", "text", 0.5), ("stored", "unit", []), ("stored", "at", "x"),
     ("session", "gauges", 5), ("session", "wall", 7), ("session", "metadata", 3),
     ("session", "cycles", 1e400)],
)  # fmt: skip
def test_a_raw_file_with_values_of_another_kind_is_no_defect(
    tmp_path, monkeypatch, capsys, event, key, value
):
    monkeypatch.chdir(tmp_path)
    gauge = ["--gauge", "X=opto-rs232@sim:?pace=0", "--trigger", "timer:0.01", "--cycles", "2"]
    assert main(["record", "a.csv", *gauge]) == 0
    raw = tmp_path / "a.raw.jsonl"
    records = [decode_record(line) for line in raw.read_bytes().splitlines(keepends=True)]
    for record in records:
        if record["event"] == event:
            record[key] = value
    raw.write_bytes(b"".join(line_of(record) for record in records))
    replayed = ["b.csv", "--gauge", "X=opto-rs232@replay:a.raw.jsonl", "--trigger", "data"]
    for command in (["--rebuild", "a.raw.jsonl", "c.csv"], replayed, ["a.csv", "--resume", *gauge]):
        assert main(["record", *command]) in (0, 2, 65, 69, 73)
    assert "defect" not in capsys.readouterr().err


def line_of(record):
    """Return the line of a record, not finite numbers too: ``1e400`` is read as one."""
    body = json.dumps(record, separators=(",", ":")).encode("ascii")
    return b'%b,"crc":"%08x"}\n' % (body[:-1], zlib.crc32(body))


@pytest.mark.parametrize("ratio", ["1e-320", "1e300"])
def test_a_sweep_beyond_any_drive_is_refused(tmp_path, capsys, ratio):
    rows = "".join(f"{k}e-4,4.7,12,-{k}e-4,{ratio}\n" for k in range(1, 9))
    (tmp_path / "s.csv").write_text(f"Im,IL,arcmin,deviation_rad,ratio\n{rows}")
    command = ["backlash", "--Im", "1", "--IL", "2", "--arcmin", "3", "--measured"]
    assert main([*command, str(tmp_path / "s.csv")]) == 65
    assert "beyond any drive" in capsys.readouterr().err


def test_a_folder_that_is_gone_while_it_is_looked_through(tmp_path, monkeypatch, capsys):
    """Such as those of processes in /proc: there is no table, and nothing was to be written."""

    def gone(folder):
        raise FileNotFoundError(2, "No such file or directory", str(folder / "gone"))

    monkeypatch.setattr(inputs, "folders_below", gone)
    assert main(["diagnose", str(tmp_path)]) == 66
    assert "no table is there" in capsys.readouterr().err
