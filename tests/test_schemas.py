"""What every command writes with --json is what docs/schemas/ says."""

import json
import re
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError
from referencing import Registry, Resource

from scara_iso.cli import main
from scara_iso.recorder import (
    CycleDone,
    Done,
    Noted,
    Noticed,
    Paused,
    Problem,
    Refused,
    Started,
    Stored,
    Voided,
    Waiting,
    as_json,
)

ROOT = Path(__file__).parents[1]
SCHEMAS = {
    path.stem: json.loads(path.read_text(encoding="utf-8"))
    for path in sorted((ROOT / "docs" / "schemas").glob("*.json"))
}
REGISTRY = Registry().with_resources(
    (schema["$id"], Resource.from_contents(schema)) for schema in SCHEMAS.values()
)
TABLE_1 = "examples/fum_scara_table1.csv"
GEAR = "backlash --Im 2.65e-4 --IL 4.749 --arcmin 12"
COMMANDS = [
    ("analyze", f"analyze {TABLE_1}"),
    ("analyze", f"analyze {TABLE_1} --limit 0.02 --definitions"),
    ("analyze", "analyze OUT/stated.csv --cycles 31"),
    ("backlash", GEAR),
    ("backlash", f"{GEAR} --arm 0.7 --ratio 50 --actual {TABLE_1}"),
    ("backlash", f"{GEAR} --measured OUT/sweep.csv"),
    ("diagnose", "diagnose examples/warm_up.csv"),
    ("diagnose", "diagnose OUT/reversals.csv --model examples/fum_scara.toml"),
    ("diagnose-many", f"diagnose examples/scatter.csv {TABLE_1} OUT/none.csv"),
    ("design", "diagnose --design"),
    ("simulate", "simulate examples/fum_scara.toml --approach both --payload 0,2"),
    ("plan", "plan examples/fum_scara.toml"),
    ("ports", "ports"),
    ("dialects", "ports --dialects"),
    ("probe", "ports --probe sim:?pace=0 --ask opto-rs232"),
    ("probe", "ports --probe replay:tests/fixtures/streams/opto-rs232/readings.bin"),
    ("probe", "ports --probe replay:tests/fixtures/streams/opto-rs232/wrong-parity.bin"),
    ("demo", "demo"),
    ("compare", "compare examples/warm_up.csv examples/scatter.csv"),
    ("report", "report examples/warm_up.csv --model examples/fum_scara.toml"),
    ("explain", "explain"),
    ("explain", "explain warm_up"),
    ("record", "record OUT/rec.csv --gauge X=opto-rs232@sim:?pace=0 --trigger timer:0.1"),
]
SAID = (
    Started({"X": "a"}, 1, 31, "data"), Waiting(1, ("X",)), Stored(1, "X", 0.5, "0.5", "mm"),
    CycleDone(1, discarded=True), Refused("X", "0.5", "late"), Problem("X", "garbage", "?"),
    Noticed("X", "low battery"), Voided(1, ("X",), "bumped"), Noted("warm"), Paused(True),
    Done(31, 31, "a.csv", "a.raw.jsonl"),
)  # fmt: skip


def check(name, document):
    Draft202012Validator(SCHEMAS[name], registry=REGISTRY).validate(document)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with tables that are no examples."""
    path = tmp_path_factory.mktemp("schemas")
    warm = (ROOT / "examples" / "warm_up.csv").read_text(encoding="utf-8")
    (path / "stated.csv").write_text(f"# command_X: 0.1\n# theta_radius_mm: 99\n{warm}")
    rows = "\n".join(f"2.65e-4,{load},12,{-2e-3 / load:.3e}" for load in range(2, 9))
    (path / "sweep.csv").write_text(f"Im,IL,arcmin,deviation_rad\n{rows}\n")
    options = ["--approach", "both", "--payload", "0,2", "-o", str(path / "reversals.csv")]
    assert main(["simulate", "examples/fum_scara.toml", *options]) == 0
    return path


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_schema_is_one_and_closed(name):
    Draft202012Validator.check_schema(SCHEMAS[name])
    text = json.dumps(SCHEMAS[name])
    assert "https://json-schema.org/draft/2020-12/schema" in text
    assert text.count('"required"') <= text.count('"additionalProperties": false')


@pytest.mark.parametrize(("name", "command"), COMMANDS)
def test_a_command_writes_what_its_schema_says(name, command, folder, capsys):
    capsys.readouterr()
    main([word.replace("OUT", str(folder)) for word in [*command.split(), "--json"]])
    lines = capsys.readouterr().out.splitlines()
    assert lines
    for line in lines:
        check(name, json.loads(line))


@pytest.mark.parametrize("said", SAID, ids=lambda said: type(said).__name__)
def test_every_line_of_a_recording_is_in_its_schema(said):
    check("record", json.loads(json.dumps(as_json(said))))


def test_every_schema_that_the_code_names_has_its_file():
    written = "".join(p.read_text(encoding="utf-8") for p in (ROOT / "scara_iso").rglob("*.py"))
    named = set(re.findall(r'"schema": "scara-iso/([a-z-]+)/1"', written))
    assert named <= set(SCHEMAS)
    assert set(SCHEMAS) - named == {"record"}


@pytest.mark.parametrize("change", [{"new_key": 1}, {"unit": "inch"}, {"poses": None}])
def test_a_drift_is_seen(change, capsys):
    assert main(["analyze", str(ROOT / TABLE_1), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    check("analyze", document)
    with pytest.raises(ValidationError):
        check("analyze", document | change)
