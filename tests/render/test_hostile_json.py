"""`--json` of every command that reads a table or a model: strict JSON, text as it was."""

import json
import math
import re
import shutil
from pathlib import Path

import pytest
from hostile import TEXTS, WORDS, model, sweep, table
from test_schemas import validator

from scara_iso import read_table
from scara_iso.base.published import to_text
from scara_iso.commands import main

HALF = re.compile("[\ud800-\udfff]")
STREAMS = Path(__file__).parents[1] / "fixtures" / "streams" / "opto-rs232"
NAMES = [text for text in TEXTS if not HALF.search(text)]
"""What TOML can hold."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with hostile tables of many poses and of one, a sweep and a model."""
    path = tmp_path_factory.mktemp("json")
    table(path / "poses.xlsx")
    table(path / "one.xlsx", poses=["[red]"], cycles=31)
    table(path / "few.xlsx", texts=TEXTS[16:17], poses=["[red]"], cycles=31)
    table(path / "two.xlsx", poses=["[red]"], cycles=31, shift=0.004)
    sweep(path / "sweep.csv")
    model(path / "model.toml", TEXTS[0])
    (path / "wire.bin").write_bytes(b"\x1b[2J\x9b31m\x00\xff\r+000.100mm\r[red]\r")
    return path


COMMANDS = (
    ("analyze", "analyze poses.xlsx --cycles 4 --limit 0.02 --definitions"),
    ("analyze", "analyze one.xlsx"),
    ("report", "report poses.xlsx --cycles 4"),
    ("report", "report one.xlsx --model model.toml"),
    ("diagnose", "diagnose one.xlsx --model model.toml"),
    ("diagnose-many", "diagnose one.xlsx nowhere.csv"),
    ("compare", "compare one.xlsx two.xlsx"),
    ("plan", "plan model.toml"),
    ("simulate", "simulate model.toml"),
    ("backlash", "backlash --Im 1e-3 --IL 4 --arcmin 12 --measured sweep.csv"),
    ("backlash", "backlash --Im 1e-3 --IL 4 --arcmin 12 --actual one.xlsx"),
    ("design", "diagnose few.xlsx --design"),
    ("probe", "ports --probe replay:wire.bin"),
    ("probe", f"ports --probe replay:{STREAMS / 'readings.bin'}"),
    ("probe", f"ports --probe replay:{STREAMS / 'wrong-parity.bin'}"),
    ("probe", "ports --probe sim:?pace=0 --ask opto-rs232"),
)


def strict(line):
    """Return the document of a line; no NaN, infinity, key twice or half a character."""

    def refuse(name):
        raise AssertionError(name)

    def once(pairs):
        assert len({key for key, _ in pairs}) == len(pairs)
        return dict(pairs)

    assert line.isascii()
    found = json.loads(line, parse_constant=refuse, object_pairs_hook=once)
    assert not HALF.search(json.dumps(found, ensure_ascii=False))
    assert all(math.isfinite(n) for n in numbers(found))
    return found


def numbers(found):
    match found:
        case float():
            yield found
        case dict():
            yield from (n for value in found.values() for n in numbers(value))
        case list():
            yield from (n for value in found for n in numbers(value))


LONG = (
    "diagnose few.xlsx --design",
    "diagnose one.xlsx nowhere.csv",
    "report poses.xlsx --cycles 4",
)


@pytest.mark.parametrize(
    ("schema", "command"),
    [pytest.param(*case, marks=[pytest.mark.slow] if case[1] in LONG else []) for case in COMMANDS],
    ids=lambda text: text,
)
def test_a_command_writes_strict_json(schema, command, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    main([*command.split(), "--json"])
    out, err = capsys.readouterr()
    assert out, err
    (line,) = out.splitlines()
    validator(schema).validate(strict(line))


@pytest.mark.parametrize("command", ["analyze", "report"])
def test_text_comes_back_as_it_was_read(command, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    assert main([command, "poses.xlsx", "--cycles", "4", "--json"]) == 0
    found = strict(capsys.readouterr().out)
    run = read_table("poses.xlsx")
    found = found.get("analysis", found)
    assert found["metadata"] == dict(run.metadata)
    assert [p["pose"] for p in found["poses"]] == list(dict.fromkeys(run.pose.tolist()))


@pytest.mark.parametrize("text", NAMES, ids=lambda text: ascii(text)[:24])
def test_text_of_a_model_comes_back(text, tmp_path, capsys):
    assert main(["simulate", str(model(tmp_path / "m.toml", text)), "--json"]) == 0
    assert strict(capsys.readouterr().out)["metadata"]["robot"] == text


@pytest.mark.parametrize("text", TEXTS, ids=lambda text: ascii(text)[:24])
def test_a_line_is_strict_whatever_its_text(text):
    found = strict(to_text({text: [text]}))
    whole = HALF.sub(lambda half: rf"\u{ord(half[0]):04x}", text)
    assert found == {whole: [whole]}


@pytest.mark.parametrize("command", ["analyze", "compare", "report", "diagnose"])
def test_a_name_that_is_no_text(command, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    name = "\udcff\x1b[2J.xlsx"
    shutil.copy("one.xlsx", name)
    more = ["two.xlsx"] if command == "compare" else []
    assert main([command, name, *more, "--json"]) == 0
    said = capsys.readouterr().out
    strict(said)
    assert command == "diagnose" or r"\\udcff" in said


def test_lines_of_a_recording(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    gauge = ["--gauge", "X=opto-rs232@sim:?pace=0", "--trigger", "timer:1", "--cycles", "2"]
    meta = [f"--meta=k{n}={text[:500]}" for n, text in enumerate(WORDS)]
    assert main(["record", "\udcff\x1b[2J.csv", *gauge, *meta, "--json"]) == 0
    for line in capsys.readouterr().out.splitlines():
        validator("record").validate(strict(line))
    (written,) = tmp_path.glob("*.csv")
    assert len(read_table(written)) == 2
