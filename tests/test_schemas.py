"""docs/schemas/ describes what the commands write, and nothing that they do not."""

import copy
import io
import json
import math
import re
import zipfile
from contextlib import redirect_stdout
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from referencing import Registry, Resource

import scara_iso
from scara_iso.base.published import to_json
from scara_iso.commands import main
from scara_iso.diagnosis import Watched
from scara_iso.recorder import events
from scara_iso.recorder.ports.device import Device
from scara_iso.reporting import Installation, ReferenceCheck, Validation

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"
GAUGE = Path(__file__).parent / "fixtures" / "gauge"
MODEL = EXAMPLES / "fum_scara.toml"
FIVE_POSES = EXAMPLES / "five_poses.toml"
JOINT = ["backlash", "--Im", "2.65e-4", "--IL", "4.749", "--arcmin", "12"]
SCHEMAS = {
    path.stem: json.loads(path.read_text(encoding="utf-8"))
    for path in sorted((ROOT / "docs" / "schemas").glob("*.json"), key=lambda path: path.stem)
}
EVENTS = [
    events.Started({"X": "opto-rs232 on sim:"}, 1, 31, "data"),
    events.Waiting(1, ("X",)),
    events.Stored(1, "X", 0.123, "0.123", "mm"),
    events.Gross(9, "X", 5.8, 5.0, "X 5.800 mm of cycle 9 is 5 mm from the others; v strikes it"),
    events.CycleDone(1, discarded=True),
    events.Refused("X", "0.123", "too soon"),
    events.Problem("unsettled", "X", "three readings differ"),
    events.Problem("changed", "X", "0.0320 has 4 decimals, the reading before had 3"),
    events.Noticed("X", "battery is low"),
    events.Voided(1, ("X",), "knocked"),
    events.Noted("door opened"),
    events.Paused(on=True),
    events.Paused(on=True, reason="structure since cycle 12"),
    events.Started({"X": "opto-rs232 on sim:"}, 1, 31, "data", "P1", ("P1", "P2")),
    events.Waiting(1, ("X",), "P1"),
    events.Stored(1, "X", 0.123, "0.123", "mm", "P1"),
    events.Gross(9, "X", 5.8, 5.0, "X 5.800 mm of cycle 9 at P2 is 5 mm away", "P2"),
    events.CycleDone(1, discarded=True, pose="P2"),
    events.Voided(1, ("X",), "knocked", "P2"),
    Watched(13, 1.6, "nothing yet"),
    Watched(19, 46.2, "structure", "step", 12, 0.8, {"onset": 0.1}),
    events.Done(31, 31, "run.csv", "run.raw.jsonl"),
]


def validator(name, changed=None):
    schemas = SCHEMAS if changed is None else {**SCHEMAS, name: changed}
    registry = Registry().with_resources(
        (f"{stem}.json", Resource.from_contents(schema)) for stem, schema in schemas.items()
    )
    return Draft202012Validator({"$ref": f"{name}.json"}, registry=registry)


def written(*argv, code=0):
    """Return the JSON lines of a command."""
    out = io.StringIO()
    with redirect_stdout(out):
        assert main([str(word) for word in (*argv, "--json")]) == code
    return [json.loads(line) for line in out.getvalue().splitlines()]


def five_axes(path, *, size=1.0):
    """Write two poses with everything that a table can state."""
    rng = np.random.default_rng(4)
    rows = [
        f"{pose},{cycle},{x:.3f},{y:.3f},{z:.3f},{theta:.3f},{(-1) ** cycle}"
        for pose in ("P1", "P2")
        for cycle, (x, y, z, theta) in enumerate(rng.normal(0, 0.01 * size, (31, 4)), start=1)
    ]
    stated = ["unit: mm", "resolution: 0.001", "command_X: 0", "command_Y: 0", "command_Z: 0",
              "theta_radius_mm: 50", "robot: =1+1 <b>"]  # fmt: skip
    lines = [*(f"# {line}" for line in stated), "pose,cycle,X,Y,Z,theta,approach", *rows, ""]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def few_facts(path):
    """Write one pose of an angle without scatter, no resolution stated."""
    rows = [f"{cycle},0.5,{0.01 * (cycle % 3)}" for cycle in range(1, 32)]
    lines = ["# unit: mm", "# unit_theta: deg", "cycle,X,theta", *rows, ""]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def referred(path):
    """Write one pose of a calibrated dial whose zero is the command pose."""
    rows = [f"{cycle},{0.001 * (cycle * 7 % 11):.3f}" for cycle in range(1, 32)]
    stated = ["unit: mm", "dial_zero: command", "command_X: 0", "indicator_uncertainty: 0.001"]
    lines = [*(f"# {line}" for line in stated), "cycle,X", *rows, ""]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def evidence(table, packed):
    """Return what the evidence of a report says of itself."""
    scara_iso.report(table, cycles=4, first_cycle_discarded=True).archive(packed, name="out.json")
    with zipfile.ZipFile(packed) as files:
        return json.loads(files.read("evidence.json"))


def one_apart(path):
    """Write one axis with a reading that stands apart."""
    readings = np.random.default_rng(5).normal(0, 0.01, 31)
    readings[11] += 0.1
    rows = [f"{cycle},{reading:.3f}" for cycle, reading in enumerate(readings, start=1)]
    path.write_text("\n".join(["# unit: mm", "cycle,X", *rows, ""]), encoding="utf-8")
    return path


def drifting(path):
    """Write eight blocks of five visits that warm up."""
    rng = np.random.default_rng(6)
    rows = [
        f"{block},{visit},{900 * block + 10 * visit},{rng.normal(1 - 0.5**block, 0.01):.3f}"
        for block in range(8)
        for visit in range(1, 6)
    ]
    lines = ["# unit: mm", "block,cycle,time_s,X", *rows, ""]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def from_three_sides(path):
    """Write one pose approached from three directions."""
    rng = np.random.default_rng(7)
    rows = [
        f"{side},{cycle},{rng.normal(0, 0.01):.3f}"
        for cycle in range(1, 32)
        for side in ("+x", "+y", "+z")
    ]
    lines = ["# unit: mm", "approach,cycle,X", *rows, ""]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def two_poses(folder):
    """Write two tables, a pose each; at the second one a step."""
    rng, paths = np.random.default_rng(7), [folder / "P1.csv", folder / "P2.csv"]
    for path, step in zip(paths, (0.0, 0.05), strict=True):
        readings = rng.normal(0, 0.003, 31) + np.where(np.arange(31) < 15, 0, step)
        rows = [f"{cycle},{reading:.3f}" for cycle, reading in enumerate(readings, start=1)]
        path.write_text("\n".join(["# unit: mm", "cycle,X", *rows, ""]), encoding="utf-8")
    return paths


def joints_together(path):
    """Write three poses, from either side by turns, at which both joints scatter as one."""
    rng, model = np.random.default_rng(3), scara_iso.robot.read_model(FIVE_POSES)
    lines = ["# unit: mm", "# resolution: 0.001", "pose,cycle,X,Y,approach"]
    for pose in ("P1", "P2", "P3"):
        turned = rng.normal(size=(13, 1)) * [2e-5, -3e-5]
        places = turned @ model.arm.jacobian(model.poses[pose]).T
        lines += [
            f"{pose},{k},{x:.3f},{y:.3f},{(-1) ** k:+d}" for k, (x, y) in enumerate(places, start=1)
        ]
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    return path


def reversals(path):
    """Write reversals of a gap smaller than stated; friction that holds the load makes the same."""
    rng = np.random.default_rng(1)
    rows = [
        f"2.65e-4,{load},12,{-0.6 * math.radians(12 / 60) / (1 + load / 2.65e-4) * noise:.8e}"
        for load, noise in zip(
            (0.5, 1.0, 2.0, 3.0, 4.749, 8.0), rng.normal(1, 0.03, 6), strict=True
        )
    ]
    path.write_text("\n".join(["Im,IL,arcmin,deviation_rad", *rows, ""]), encoding="utf-8")
    return path


def few_robots(folder):
    """Write a robot that is there twice, and one that has too few cycles."""
    folder.mkdir()
    rows = [f"R1,{cycle},{0.001 * (cycle * 7 % 11):.3f}" for cycle in range(1, 32)]
    lines = ["# unit: mm", "robot,cycle,X", *rows, "R2,1,0.5", ""]
    for name, of_it in (("a", lines), ("b", lines[:-2])):
        (folder / f"{name}.csv").write_text("\n".join([*of_it, ""]), encoding="utf-8")
    return folder


def sessions(path):
    rows = [f"d{k // 3},{0.001 * (k * 7 % 11):.3f}" for k in range(12)]
    path.write_text("\n".join(["# unit: mm", "day,X", *rows, ""]), encoding="utf-8")
    return path


def followed(folder):
    """Write six tests of two poses, an angle among them, and a table that cannot be read."""
    rng, paths = np.random.default_rng(8), [folder / "2026-00.csv"]
    paths[0].write_text("cycle,X\n1,a\n", encoding="utf-8")
    for month in range(1, 7):
        rows = [
            f"{pose},{cycle},{x:.3f},{y:.3f},{theta:.3f}"
            for pose in ("P1", "P2")
            for cycle, (x, y, theta) in enumerate(rng.normal(0, 0.01, (31, 3)), start=1)
        ]
        stated = [f"# date: 2026-0{month}-01", "# unit: mm", "# unit_theta: deg",
                  f"# payload: {1 + month // 6} kg"]  # fmt: skip
        paths.append(folder / f"2026-0{month}.csv")
        paths[-1].write_text("\n".join([*stated, "pose,cycle,X,Y,theta", *rows, ""]), "utf-8")
    return paths


def validated(*, passing):
    """Return what `selftest` writes of two references."""
    checks = (
        ReferenceCheck("units", "1 inch", "SI Brochure", 25.4, 25.4 if passing else 25.0, 1e-9),
        ReferenceCheck("streams", "opto-rs232", "manual", "reading 1.2", "reading 1.2"),
    )
    on = Installation("0.1.0", {"Python": "3.12"}, "Linux", {"program": "ab", "references": "cd"})
    return json.loads(json.dumps(to_json(Validation(checks=checks, installation=on))))


def with_push_test(folder):
    """Add a push test with a maker's limit on two sides to the folder of a test."""
    (folder / "push.csv").write_bytes((EXAMPLES / "push.csv").read_bytes())
    with (folder / "test.toml").open("a", encoding="utf-8") as file:
        file.write("\n[push]\narm_m = 0.25\nlimits = { deflection_mm = [0.01, 9] }\n")


@pytest.fixture(scope="session")
def documents(tmp_path_factory):
    """Return what every command writes, by the name of its schema."""
    folder = tmp_path_factory.mktemp("schemas")
    full, few = five_axes(folder / "full.csv"), few_facts(folder / "few.csv")
    wider = five_axes(folder / "wider.csv", size=2.0)
    short = folder / "short.csv"
    short.write_text("# unit: mm\ncycle,X\n2,1\n3,2\n4,1\n", encoding="utf-8")
    both_ways, loaded = folder / "both_ways.csv", folder / "loaded.toml"
    written("simulate", MODEL, "--approach", "random", "--payload", "0,2,4", "-o", both_ways,
            "--effect", "lost_motion@X,Y:size=0.02")  # fmt: skip
    described = MODEL.read_text(encoding="utf-8")
    loaded.write_text(described.replace("arcmin = 12 ", "payload_kg = 2\narcmin = 12 "), "utf-8")
    table_1 = EXAMPLES / "fum_scara_table1.csv"
    before, after = EXAMPLES / "before_repair.csv", EXAMPLES / "after_repair.csv"
    with pytest.MonkeyPatch.context() as patch:
        known = Device("COM4", "USB serial", "0403:6001", "A1", "1-1")
        patch.setattr("scara_iso.recorder.list_devices", lambda: (known,))
        ports = written("ports")
    one, two = folder / "one", folder / "two"
    status = written("test", "new", one, "--model", MODEL)
    status += written("test", "new", two, "--model", MODEL, "--velocities", "100,50")
    gauge = ("--gauge", "X=opto-rs232@sim:?pace=0", "--trigger", "timer:1")
    for _ in range(2):
        written("record", one, *gauge)
    for pose in ("P1", "P2"):
        written("record", two, *gauge, "--part", f"{pose}-v50-l100")
    written("record", one, *gauge, "--part", "P1-v100-l100", "--repeat", "knocked")
    written("record", one, *gauge, "--part", "P3-v100-l100", "--meta", "temperature=35 C")
    status += written("test", "status", one)
    poses_only = written("analyze", two)
    for of_it in (one, two):
        with_push_test(of_it)
    return {
        "analyze": [
            *written("analyze", table_1),
            *written("analyze", full, "--limit", "XY=0.09", "--definitions"),
            *written("analyze", full, "--limit", "XY=0.045", code=1),
            *written("analyze", few),
            *written("analyze", referred(folder / "referred.csv")),
            *written("analyze", drifting(folder / "drift.csv")),
            *written("analyze", from_three_sides(folder / "sides.csv"), "--limit", "vAP=1"),
            *written("analyze", one),
            *written("analyze", two),
            *poses_only,
        ],
        "backlash": [
            *written(*JOINT),
            *written(*JOINT, "--arm", "0.7", "--ratio", "50", "--actual", table_1),
            *written(*JOINT, "--actual", table_1, "--measured", reversals(folder / "sweep.csv")),
        ],
        "compare": [*written("compare", before, after, "--limit", "1"),
                    *written("compare", full, wider),
                    *written("compare", few, few),
                    *written("compare", folder / "referred.csv", referred(folder / "other.csv"),
                             "--exchangeability")],
        "demo": written("demo"),
        "design": written("diagnose", "--design", "--columns", "approach"),
        "design-poses": written("diagnose", "--design", "--model", FIVE_POSES, "--cycles", "9"),
        "diagnose": [
            *written("diagnose", one_apart(folder / "apart.csv")),
            *written("diagnose", EXAMPLES / "unexplained.csv"),
            *written("diagnose", both_ways, "--model", MODEL),
            *written("diagnose", both_ways, "--model", loaded),
            *written("diagnose", *two_poses(folder)),
            *written("diagnose", EXAMPLES / "five_poses.csv", "--model", FIVE_POSES,
                     "--hold-out", "P5", "--map", folder / "map.csv", "--limit", "XY=0.014"),
            *written("diagnose", joints_together(folder / "joints.csv"), "--model", FIVE_POSES,
                     "--cycles", "13"),
        ],
        "diagnose-many": [
            *written("diagnose", both_ways, folder / "none.csv", "--model", MODEL, code=66),
        ],
        "dialects": written("ports", "--dialects"),
        "fleet": written("fleet", few_robots(folder / "robots"), "-o", folder / "out", code=65),
        "fleet-figures": written(
            "fleet", folder / "robots", "-o", folder / "figures", "--figures", code=65
        ),
        "gauge-study": [
            *written("gauge-study", EXAMPLES / "dial_type_1.csv", "--tolerance", "0.04"),
            *written("gauge-study", EXAMPLES / "dial_crossed.csv"),
            *written("gauge-study", GAUGE / "aiag_linearity.csv"),
            *written("gauge-study", sessions(folder / "sessions.csv"), "--tolerance", "5"),
        ],
        "evidence": [evidence(short, folder / "evidence.zip")],
        "explain": [*written("explain"), *written("explain", "trend"),
                    *written("explain", "interval")],
        "plan": written("plan", MODEL),
        "plan-separating": [
            *written("plan", MODEL, "--separating", "--elbow", "left"),
            *written("plan", FIVE_POSES, "--separating"),
        ],
        "ports": ports,
        "program": written(
            "program", "urscript", "--poses", "P1,P2", "--line", "192.168.1.10:5000",
            "-o", folder / "paced.script",
        ),
        "program-languages": written("program"),
        "probe": written("ports", "--probe", "sim:", "--ask", "opto-rs232"),
        "push": [
            *written("push", EXAMPLES / "push.csv", "--arm", "0.25", "--limit", "1.2"),
            *written("push", EXAMPLES / "push.csv", "--limit", "deflection_mm=0.1", code=1),
            *written("push", EXAMPLES / "push.csv", "--limit", "deflection_mm=0.01..9"),
        ],
        "record": [
            *written("record", folder / "run.csv", "--gauge", "X=opto-rs232@sim:?pace=0",
                     "--trigger", "timer:0.1"),
            *(json.loads(json.dumps(to_json(said))) for said in EVENTS),
        ],
        "report": [
            *written("report", both_ways, "--model", MODEL),
            *written("report", short, "--cycles", "4", "--first-cycle-discarded"),
            *written("report", folder / "sides.csv"),
            *written(
                "report", short, "--cycles", "4", "--first-cycle-discarded", "--meta", "robot=A",
                "--meta", "report_number=2", "--supersedes", "1", "--reason", "a mistake",
            ),
        ],
        "history": [
            *written("history", EXAMPLES / "months", "--limit", "XY=0.02", code=1),
            *written("history", *followed(folder), "--limit", "theta=0.1", "--limit", "XY=1"),
            *written("history", EXAMPLES / "months" / "2024-01.csv"),
        ],
        "selftest": [validated(passing=True), validated(passing=False)],
        "visits": written("visits", EXAMPLES / "stream.csv", "--poses", "P1,-"),
        "tables": [*written("tables", full), *written("tables", *two_poses(folder))],
        "test-conditions": [*written("diagnose", two), *written("report", two)],
        "test-status": status,
        "simulate": written("simulate", MODEL, "--temperature", "20:24"),
    }  # fmt: skip


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_schema_is_one(name):
    Draft202012Validator.check_schema(SCHEMAS[name])


@pytest.mark.slow
def test_every_output_has_a_schema(documents):
    assert set(documents) == set(SCHEMAS)
    written = "".join(path.read_text("utf-8") for path in (ROOT / "scara_iso").rglob("*.py"))
    named = set(re.findall(r'Literal\["scara-iso/([a-z-]+)/[12]"\]', written))
    assert set(SCHEMAS) == named | {"record"}


@pytest.mark.slow
@pytest.mark.parametrize("name", SCHEMAS)
def test_outputs_are_as_the_schema_says(documents, name):
    for document in documents[name]:
        errors = [
            f"{e.json_path}: {e.message[:300]}" for e in validator(name).iter_errors(document)
        ]
        assert errors == []


@pytest.mark.slow
@pytest.mark.parametrize("name", SCHEMAS)
def test_one_key_more_or_less_is_refused(documents, name):
    first = documents[name][0]
    assert not validator(name).is_valid({**first, "something_new": 1})
    for key in first:
        assert not validator(name).is_valid({k: v for k, v in first.items() if k != key}), key


def properties(schema, path=()):
    """Yield where each property stands in a schema: the way to its parent, and its name."""
    if isinstance(schema, dict):
        for key, below in schema.items():
            if key == "properties":
                yield from ((*path, key, name) for name in below)
            yield from properties(below, (*path, key))
    elif isinstance(schema, list):
        for k, below in enumerate(schema):
            yield from properties(below, (*path, k))


def of_another(name, path):
    """Return whether a property is of a class that an earlier schema holds, and is tested there."""
    kind = SCHEMAS[name]["$defs"][path[1]] if path[0] == "$defs" else None
    first = next(n for n in SCHEMAS if SCHEMAS[n].get("$defs", {}).get(path[1]) == kind)
    return kind is not None and first != name


def without(schema, path):
    changed = copy.deepcopy(schema)
    parent = changed
    for step in path[:-1]:
        parent = parent[step]
    del parent[path[-1]]
    return changed


def shortened(document):
    """Return the document with two numbers of each long list, which says as much of its keys."""
    if isinstance(document, dict):
        return {key: shortened(below) for key, below in document.items()}
    if isinstance(document, list):
        numbers = all(isinstance(one, int | float) for one in document)
        return document[:2] if numbers else [shortened(one) for one in document]
    return document


@pytest.mark.slow
@pytest.mark.parametrize("name", SCHEMAS)
def test_a_schema_names_nothing_that_no_output_has(documents, name):
    """Each property is needed: without it a real output has a key that is refused."""
    idle, short = [], [shortened(document) for document in documents[name]]
    for path in properties(SCHEMAS[name]):
        if of_another(name, path):
            continue
        reduced = validator(name, without(SCHEMAS[name], path))
        if all(reduced.is_valid(document) for document in short):
            idle.append("/".join(map(str, path)))
    assert idle == []


@pytest.mark.parametrize("name", SCHEMAS)
def test_every_key_is_described_and_every_object_on_the_page(name):
    page = (ROOT / "docs" / "json.md").read_text(encoding="utf-8")
    named = re.search(r'"const": "(scara-iso/[^"]+)"', json.dumps(SCHEMAS[name]))
    assert named is None or f"`{named[1]}`" in page
    kinds = SCHEMAS[name]["$defs"].items()
    assert [
        f"{kind}.{key}"
        for kind, made in kinds
        for key, field in made.get("properties", {}).items()
        if not field.get("description")
    ] == []
