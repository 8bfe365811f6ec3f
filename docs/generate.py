"""Write docs/reference/ and the picture of the floors from the code; a test holds them to it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from scara_iso.base.published import Json, schema
from scara_iso.commands import PublishedRun
from scara_iso.commands.evidence import Evidence
from scara_iso.commands.program import COMMANDS
from scara_iso.comparison import PublishedComparison, PublishedHistory
from scara_iso.diagnosis import PublishedSeparatingPlan
from scara_iso.diagnosis.published import DiagnosedTables, PublishedDiagnosis
from scara_iso.diagnosis.published_designs import PublishedDesign, PublishedPosesDesign
from scara_iso.diagnosis.published_gears import PUBLISHED as BACKLASH
from scara_iso.diagnosis.published_poses import PosesDiagnosis, TracedPosesDiagnosis
from scara_iso.fleets import PublishedFleet, PublishedFleetFigures
from scara_iso.gauge import PublishedGaugeStudy
from scara_iso.iso9283 import PublishedPlan, PublishedVisits
from scara_iso.iso9283.published import PUBLISHED as ANALYZE
from scara_iso.iso9283.published_push import PublishedPush
from scara_iso.recorder.events import PUBLISHED as EVENTS
from scara_iso.recorder.indicators import Dialect, find_dialects
from scara_iso.reporting import (
    ConditionResults,
    PublishedDemo,
    PublishedReport,
    PublishedValidation,
    ResultsAndBeside,
)
from scara_iso.reporting.explain import Page, PublishedPages, pages
from scara_iso.reporting.published_ports import (
    PublishedDialects,
    PublishedPorts,
    PublishedProbe,
)
from scara_iso.tables.published import PublishedTable
from scara_iso.testfolder.published import PublishedStatus

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS))
from floors import floors, modules, picture, purpose  # noqa: E402 - a neighbour of this script

PUBLISHED = {
    "analyze": ("analyze TABLE --json", *ANALYZE),
    "dialects": ("ports --dialects --json", PublishedDialects),
    "evidence": ("evidence.json of report TABLE --archive", Evidence),
    "explain": ("explain --json", PublishedPages),
    "ports": ("ports --json", PublishedPorts),
    "probe": ("ports --probe PORT --json", PublishedProbe),
    "push": ("push LOOP --json", PublishedPush),
    "record": ("one line of record --json", *EVENTS),
    "tables": ("tables TABLE --json", PublishedTable),
    "test-status": ("test status DIR --json", PublishedStatus),
    "visits": ("visits STREAM --json", PublishedVisits),
    "compare": ("compare BEFORE AFTER --json", PublishedComparison),
    "fleet": ("fleet SOURCE -o DIR --json", PublishedFleet),
    "fleet-figures": ("fleet SOURCE -o DIR --figures --json", PublishedFleetFigures),
    "gauge-study": ("gauge-study TABLE --json", PublishedGaugeStudy),
    "history": ("history --json", PublishedHistory),
    "plan": ("plan MODEL --json", PublishedPlan),
    "plan-separating": ("plan MODEL --separating --json", PublishedSeparatingPlan),
    "selftest": ("selftest --json", PublishedValidation),
    "simulate": ("simulate MODEL --json", PublishedRun),
    "backlash": ("backlash --json; with --measured, what a sweep leaves unexplained", *BACKLASH),
    "diagnose": (
        "diagnose TABLE --json", PublishedDiagnosis, PosesDiagnosis, TracedPosesDiagnosis,
    ),
    "design": ("diagnose --design --json", PublishedDesign),
    "design-poses": ("diagnose --design --model MODEL --json", PublishedPosesDesign),
    "diagnose-many": ("diagnose of several unrelated tables, --json", DiagnosedTables),
    "demo": ("demo --json", PublishedDemo),
    "report": ("report TABLE --json", PublishedReport),
    "test-conditions": (
        "diagnose, compare and report of tests with several conditions, --json",
        ConditionResults, ResultsAndBeside,
    ),
}  # fmt: skip
"""Title and classes of the schemas that are made from classes."""
MADE = "Made by `python docs/generate.py` from the code; do not edit."


def reference() -> dict[str, str]:
    """Return the text of every page by its file name."""
    effects = [page for page in pages() if page.kind.startswith("effect")]
    findings = [page for page in pages() if page.kind == "finding"]
    characteristics = [page for page in pages() if page.kind == "characteristic"]
    made = {
        "commands.md": ("Commands", _commands()),
        "characteristics.md": ("Characteristics", _pages(characteristics)),
        "findings.md": ("Findings", _pages(findings)),
        "effects.md": ("Effects", _pages(effects)),
        "dialects.md": ("Dialects of indicators", _dialects()),
        "fields.md": ("Fields of the JSON objects", _fields()),
        "schemas.md": ("JSON schemas", _schemas()),
        "modules.md": ("Modules", _modules()),
    }
    return {
        name: "\n\n".join([f"# {title}", MADE, *blocks]) + "\n"
        for name, (title, blocks) in made.items()
    }


def _commands() -> Iterator[str]:
    for command in ("", *COMMANDS):
        call = ["-c", "import sys; from scara_iso.commands import main; sys.exit(main())"]
        environment = {
            **os.environ,
            "COLUMNS": "100",
            "PYTHONPATH": str(DOCS.parent),
            "PYTHONUTF8": "1",
        }
        words = [command] if command else []
        done = subprocess.run(  # noqa: S603 - this program
            [sys.executable, *call, *words, "--help"],
            capture_output=True, check=True, env=environment, encoding="utf-8",
        )  # fmt: skip
        text = "\n".join(line.rstrip() for line in done.stdout.strip().splitlines())
        yield f"## `scara-iso{' ' if command else ''}{command}`"
        yield f"```text\n{text}\n```"


def _pages(found: Iterable[Page]) -> Iterator[str]:
    yield "The same pages are shown by `scara-iso explain CODE`."
    for page in found:
        yield f"## `{page.code}`"
        yield f"{page.title}."
        yield from page.text
        if page.parameters:
            rows = ((one.name, one.unit, one.meaning) for one in page.parameters)
            yield _table(("parameter", "unit", "meaning"), rows)
        if page.kind.startswith("effect"):
            yield f"An {page.kind}."


def _dialects() -> Iterator[str]:
    yield (
        'How to connect an indicator: [indicators.md](../indicators.md). "Type" is what to write '
        'for axis X, with your port for PORT; "line" is baud, data bits, parity and stop bits; '
        '"asked by" is what is sent for one reading; "unit sent" says whether every frame states '
        "its unit. Where it does not, and the instrument does not answer when asked for it, you "
        "state it: nobody can tell 0.123 mm from 0.123 inch."
    )
    header = ("key", "instruments", "cable", "type", "line", "asked by", "unit sent", "source")
    yield _table(header, map(_row, find_dialects().values()))
    yield (
        "The last column rates the source: *high* is a maker's own document or two independent "
        "sources that agree, *medium* one good source, *low* one weak source."
    )
    for key, dialect in find_dialects().items():
        yield f"## `{key}`"
        yield f"{dialect.instruments}."
        yield _table(("on the wire", ""), _wire(dialect))
        yield f"Source: {dialect.source}.".replace("\\", r"\\").replace("<", r"\<")
        if dialect.unverified:
            yield "Not verified:"
            yield "\n".join(f"* {one}" for one in dialect.unverified)


def _row(dialect: Dialect) -> tuple[str, ...]:
    told = dialect.sends_unit or dialect.unit_request
    return (
        f"[`{dialect.key}`](#{dialect.key})",
        dialect.instruments,
        dialect.cable,
        f"`X={dialect.key}{'' if told else '?unit=mm'}@PORT`",
        str(dialect.line),
        _bytes(dialect.request) if dialect.request else _sent(dialect),
        "yes" if dialect.sends_unit else "no",
        dialect.confidence,
    )


def _sent(dialect: Dialect) -> str:
    pulse = dialect.request_line
    return f"pulse on {pulse.line.upper()}" if pulse else "sends by itself"


def _wire(dialect: Dialect) -> Iterator[tuple[str, str]]:
    sent = _sent(dialect)
    names = dialect.channels
    ends = f"`{names[0]}` to `{names[-1]}`, {len(names)}" if names else "none"
    yield "line", str(dialect.line)
    yield "request", _bytes(dialect.request_template) if dialect.request_template else sent
    yield "end of a line", _bytes(dialect.terminator)
    yield "unit", ", ".join(unit or "not stated" for unit in dialect.units)
    yield "digits", f"{dialect.digits}, behind the point {', '.join(map(str, dialect.decimals))}"
    yield "channels", ends


def _bytes(data: bytes) -> str:
    return f"`{data.decode('latin-1').encode('unicode_escape').decode('ascii')}`"


def _modules() -> Iterator[str]:
    yield "A room imports only from the floors below it: [architecture](../architecture.md)."
    rooms = [room for floor in floors() for room in floor]
    yield _table(("room", "purpose"), [(f"`{room}`", purpose(room)) for room in rooms])
    for room in rooms:
        _, *inner = modules(room)
        if inner:
            yield f"## `{room}`"
            yield _table(("module", "purpose"), [(f"`{name}`", purpose(name)) for name in inner])


def _schemas() -> Iterator[str]:
    yield (
        "JSON Schema, draft 2020-12; every object is closed, so that a drift is seen. What the "
        "keys mean: [json.md](../json.md). A reference such as `analyze.json#/$defs/pose` leads to "
        "the file beside."
    )
    paths = sorted((DOCS / "schemas").glob("*.json"))
    titles = [json.loads(path.read_text(encoding="utf-8"))["title"] for path in paths]
    links = [f"[{path.stem}](../schemas/{path.name})" for path in paths]
    yield _table(("schema", "written by"), zip(links, titles, strict=True))


def schemas() -> dict[str, str]:
    """Return the text of every schema that is made from classes, by its file name."""
    made = {name: schema(title, *kinds) for name, (title, *kinds) in PUBLISHED.items()}
    return {f"{name}.json": json.dumps(found, indent=2) + "\n" for name, found in made.items()}


def _fields() -> Iterator[str]:
    yield (
        "What the keys mean: from the classes of which the objects and their schemas are made. A "
        "key with `?` is not always there. A class that several hold is told once."
    )
    told: set[str] = set()
    for name, (title, *kinds) in PUBLISHED.items():
        found = schema(title, *kinds)["$defs"]
        yield f"## `{name}`"
        for kind in [one for one in found if one not in told]:
            yield f"### {kind}"
            yield found[kind]["description"].replace("``", "`").partition("\n\n")[0]
            if "properties" in found[kind]:
                yield _table(("key", "type", "unit", "meaning"), _keys(found[kind]))
            else:
                yield _type(found[kind])
        told |= set(found)


def _keys(kind: Json) -> Iterator[tuple[str, ...]]:
    for name, field in kind["properties"].items():
        always = "" if name in kind["required"] else " ?"
        yield f"`{name}`{always}", _type(field), _unit(field), field["description"]


def _unit(field: Json) -> str:
    """Return the unit of a key, or of what it holds."""
    held = [field, *field.get("anyOf", ()), field.get("items"), field.get("additionalProperties")]
    return next((one["unit"] for one in held if isinstance(one, dict) and "unit" in one), "")


def _type(field: Json) -> str:
    """Return the type of a key as a person reads it."""
    if "anyOf" in field:
        return " or ".join(map(_type, field["anyOf"]))
    if "$ref" in field:
        return f"[{(name := field['$ref'].rpartition('/')[2])}](#{name.lower()})"
    if "const" in field or "enum" in field:
        return ", ".join(f"`{one}`" for one in field.get("enum", [field.get("const")]))
    match field["type"]:
        case "array" if "prefixItems" in field:
            found = f"[{', '.join(map(_type, field['prefixItems']))}]"
        case "array":
            found = f"list of {_type(field['items'])}"
        case "object":
            found = f"{_type(field['additionalProperties'])} by name"
        case found:
            pass
    return str(found)


def _table(header: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [header, ("---",) * len(header), *rows]
    return "\n".join(f"| {' | '.join(c.replace('|', chr(92) + '|') for c in r)} |" for r in lines)


if __name__ == "__main__":
    (DOCS / "reference").mkdir(exist_ok=True)
    for name, text in schemas().items():
        (DOCS / "schemas" / name).write_text(text, encoding="utf-8", newline="")
    for name, text in reference().items():
        (DOCS / "reference" / name).write_text(text, encoding="utf-8", newline="")
    (DOCS / "figures" / "floors.svg").write_text(picture(), encoding="utf-8", newline="")
