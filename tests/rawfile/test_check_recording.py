"""A table with a raw file beside it is held against it, whatever its manifest says."""

import hashlib
import json
from io import BytesIO, StringIO
from types import SimpleNamespace

import pytest
from bench import Orders, run_session

import scara_iso
from scara_iso.commands import main
from scara_iso.rawfile import manifest_path, raw_path
from scara_iso.recorder import Quit, Take
from scara_iso.testfolder import read_folder

X = ["X=opto-rs232@sim:?pace=0"]
GREW = "run.raw.jsonl holds 19 cycles, run.csv 11"
LOST = "run.raw.jsonl and run.manifest.json are missing: nothing holds run.csv against what was"
OTHER = "the readings of run.csv are not those of run.raw.jsonl"


def take(folder, more, *, resume=False, table="run.csv"):
    orders = Orders(*[Take()] * more, Quit())
    run_session(folder, X, trigger="enter", cycles=31, operator=orders, resume=resume, table=table)


def kill(table):
    """Give a table the raw file of a session that went on to cycle 19 and was killed."""
    kept = {path: path.read_bytes() for path in (table, manifest_path(table))}
    take(table.parent, 8, resume=True, table=table.name)
    raw = raw_path(table)
    lines = raw.read_bytes().splitlines(keepends=True)
    raw.write_bytes(b"".join(lines[:-1]))
    for path, data in kept.items():
        path.write_bytes(data)


@pytest.fixture
def killed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    take(tmp_path, 11)
    kill(tmp_path / "run.csv")
    return tmp_path / "run.csv"


def found_in(table, code, **options):
    return [f.message for f in scara_iso.analyze(table, **options).findings if f.code == code]


def test_a_raw_file_that_has_outgrown_its_table_is_said_as_error_and_as_finding(killed, capsys):
    capsys.readouterr()
    assert main(["analyze", "run.csv"]) == 65
    error = capsys.readouterr().err
    assert GREW in error
    assert "--resume" in error
    assert "--rebuild" in error
    assert "--cycles 11" not in error
    (found,) = found_in("run.csv", "stopped-early", cycles=11)
    assert found.startswith(GREW)
    main(["report", "run.csv", "--cycles", "11", "-o", "run.md"])
    page = " ".join(killed.with_suffix(".md").read_text("utf-8").replace("\\", "").split())
    assert GREW in page
    assert "topped after" not in page


@pytest.mark.parametrize("go_on", ["resume", "rebuild"])
def test_both_advices_take_the_stored_readings_in(killed, go_on):
    if go_on == "resume":
        take(killed.parent, 0, resume=True)
    else:
        assert main(["record", "--rebuild", "run.raw.jsonl"]) == 0
    run = scara_iso.read_table(killed)
    assert len(run) == 19
    assert not any("holds" in one for one in found_in("run.csv", "stopped-early", cycles=19))
    assert found_in("run.csv", "edited", cycles=19) == []


def test_a_table_that_somebody_edited_is_not_written_over_by_a_rebuild(killed, capsys):
    killed.write_text(killed.read_text().replace("1,0.", "1,1.", 1))
    assert main(["record", "--rebuild", "run.raw.jsonl"]) == 73


@pytest.mark.parametrize("forged", [False, True])
def test_readings_that_the_raw_file_does_not_hold_are_said_whatever_the_manifest_says(
    killed, forged
):
    take(killed.parent, 0, resume=True)
    assert found_in("run.csv", "edited", cycles=19) == []
    text = killed.read_text().rstrip().rpartition("\n")
    killed.write_text(f"{text[0]}\n{text[2].replace(',0.', ',1.', 1)}\n")
    if forged:
        known = json.loads(manifest_path(killed).read_text())
        known["sha256"]["run.csv"] = hashlib.sha256(killed.read_bytes()).hexdigest()
        manifest_path(killed).write_text(json.dumps(known))
    else:
        manifest_path(killed).unlink()
    assert OTHER in found_in("run.csv", "edited", cycles=19)


def test_a_recording_without_raw_file_and_manifest_says_that_nothing_holds_it(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    take(tmp_path, 31)
    assert found_in("run.csv", "edited") == []
    for path in (raw_path(tmp_path / "run.csv"), manifest_path(tmp_path / "run.csv")):
        path.unlink()
    capsys.readouterr()
    assert main(["analyze", "run.csv", "--full"]) == 0
    assert LOST in " ".join(capsys.readouterr().out.split())


def test_a_table_that_was_not_recorded_is_held_against_nothing(tmp_path):
    table = tmp_path / "mine.csv"
    rows = "".join(f"{k},0.01{k % 7}\n" for k in range(1, 32))
    table.write_text(f"# unit: mm\n# indicator: X dial of Mitutoyo\ncycle,X\n{rows}")
    assert found_in(table, "edited") == []


def test_a_part_of_a_test_is_held_against_its_recording_too(tmp_path):
    folder = tmp_path / "test"
    main(["test", "new", str(folder), "--poses", "P1"])
    part = folder / "P1-v100-l100.csv"
    take(folder, 31, table=part.name)
    assert read_folder(folder).parts[0].state == "done"
    raw_path(part).unlink()
    manifest_path(part).unlink()
    assert ["edited"] == [f.code for f in read_folder(folder).parts[0].deviations]
    assert "nothing holds P1-v100-l100.csv" in found_in(folder, "edited")[0]


def test_a_part_whose_raw_file_has_outgrown_its_table_is_not_done(tmp_path):
    folder = tmp_path / "test"
    main(["test", "new", str(folder), "--poses", "P1"])
    part = folder / "P1-v100-l100.csv"
    take(folder, 11, table=part.name)
    kept = {path: path.read_bytes() for path in (part, manifest_path(part))}
    take(folder, 20, table=part.name, resume=True)
    for path, data in kept.items():
        path.write_bytes(data)
    assert read_folder(folder).parts[0].state == "unfinished"
    assert main(["record", str(folder), "--gauge", X[0], "--trigger", "timer:1"]) == 0
    assert read_folder(folder).parts[0].state == "done"


def test_an_angle_that_crosses_the_turn_is_the_same_in_table_and_raw_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    typed = "\n".join(f"{(359.9 + k * 0.01) % 360:.2f}" for k in range(31))
    monkeypatch.setattr("sys.stdin", StringIO(f"{typed}\n"))
    words = ["--gauge", "theta=keyboard?unit=deg@keyboard:", "--rearm", "0"]
    assert main(["record", "run.csv", *words]) == 0
    assert found_in("run.csv", "edited") == []


def test_a_reading_that_was_changed_is_said_also_where_the_last_rows_are_gone(killed):
    manifest_path(killed).unlink()
    *rows, last = killed.read_text("utf-8").splitlines(keepends=True)
    number, reading, *others = last.split(",")
    killed.write_text("".join([*rows, ",".join([number, f"{float(reading) + 1:.3f}", *others])]))
    assert OTHER in found_in("run.csv", "edited", cycles=11)


def test_standard_input_has_no_raw_file_to_be_held_against(killed, monkeypatch, capsys):
    monkeypatch.setattr("sys.stdin", SimpleNamespace(buffer=BytesIO(killed.read_bytes())))
    capsys.readouterr()
    assert main(["analyze", "-", "--cycles", "11", "--full"]) == 0
    assert "raw.jsonl" not in capsys.readouterr().out
