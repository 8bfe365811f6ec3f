"""Write docs/reference/, docs/schemas/ and the picture of the layers from the code."""

from __future__ import annotations

import io
import json
import os
import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import redirect_stdout
from pathlib import Path
from unittest.mock import patch

from scara_iso.base.published import Json
from scara_iso.commands import PublishedRun, main
from scara_iso.commands.app import COMMANDS
from scara_iso.commands.diagnose_many import DiagnosedTables
from scara_iso.commands.evidence import Evidence
from scara_iso.commands.ports import PublishedDialects, PublishedPorts, PublishedProbe
from scara_iso.commands.program import KnownLanguages, RobotProgram
from scara_iso.commands.shared.output import as_options
from scara_iso.comparison import Comparison, RobotHistory
from scara_iso.diagnosis import (
    BacklashResult,
    Design,
    DesignOfPoses,
    Diagnosis,
    DiagnosisOfPoses,
    SeparatingPlan,
    Watched,
)
from scara_iso.fleets import FleetFigures, FleetSummary
from scara_iso.gauge import GaugeStudy
from scara_iso.iso9283 import (
    Analysis,
    FolderAnalysis,
    PosePlan,
    PushResult,
    StreamVisits,
)
from scara_iso.recorder.events import PUBLISHED as EVENTS
from scara_iso.recorder.indicators import Dialect, find_dialects
from scara_iso.reporting import (
    ConditionResults,
    Dossier,
    PublishedDemo,
    ResultsAndOtherTests,
    Validation,
)
from scara_iso.reporting.explain import WORDS, Page, PublishedPages, pages
from scara_iso.tables.write import PublishedTable
from scara_iso.testfolder.progress import PublishedStatus

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS))
from json_schema import schema  # noqa: E402 - neighbours of this script
from layers import layers, picture  # noqa: E402, F401

PUBLISHED = {
    "analyze": ("analyze TABLE --json", Analysis, FolderAnalysis),
    "dialects": ("ports --dialects --json", PublishedDialects),
    "evidence": ("evidence.json of report TABLE --archive", Evidence),
    "explain": ("explain --json", PublishedPages),
    "ports": ("ports --json", PublishedPorts),
    "probe": ("ports --probe PORT --json", PublishedProbe),
    "program": ("program LANGUAGE --json", RobotProgram),
    "program-languages": ("program --json", KnownLanguages),
    "push": ("push LOOP --json", PushResult),
    "record": ("one line of record --json", *EVENTS, Watched),
    "tables": ("tables TABLE --json", PublishedTable),
    "test-status": ("test status DIR --json", PublishedStatus),
    "visits": ("visits STREAM --json", StreamVisits),
    "compare": ("compare BEFORE AFTER --json", Comparison),
    "fleet": ("fleet SOURCE -o DIR --json", FleetSummary),
    "fleet-figures": ("fleet SOURCE -o DIR --figures --json", FleetFigures),
    "gauge-study": ("gauge-study TABLE --json", GaugeStudy),
    "history": ("history --json", RobotHistory),
    "plan": ("plan MODEL --json", PosePlan),
    "plan-separating": ("plan MODEL --separating --json", SeparatingPlan),
    "selftest": ("selftest --json", Validation),
    "simulate": ("simulate MODEL --json", PublishedRun),
    "backlash": (
        "backlash --json; with --measured, what a sweep leaves unexplained", BacklashResult,
    ),
    "diagnose": ("diagnose TABLE --json", Diagnosis, DiagnosisOfPoses),
    "design": ("diagnose --design --json", Design),
    "design-poses": ("diagnose --design --model MODEL --json", DesignOfPoses),
    "diagnose-many": ("diagnose of several unrelated tables, --json", DiagnosedTables),
    "demo": ("demo --json", PublishedDemo),
    "report": ("report TABLE --json", Dossier),
    "test-conditions": (
        "diagnose, compare and report of tests with several conditions, --json",
        ConditionResults, ResultsAndOtherTests,
    ),
}  # fmt: skip
"""Title and classes of the schemas that are made from classes."""
EVERYWHERE = ("--help", "--json")
SUBCOMMANDS = ("test new", "test status")
MADE = "<!-- Made by python docs/generate.py: do not edit. -->"
KEYS = {
    "analyze": (
        "Analysis", "PoseResult", "AxisResult", "LimitCheck",
    ),
    "diagnose": ("Diagnosis",),
    "record": ("Stored", "Refused", "Problem", "Done"),
}  # fmt: skip
"""The classes that the page of the JSON objects prints; the schemas describe all of them."""


def reference() -> dict[str, str]:
    """Return the text of every page by its file name."""
    effects = [page for page in pages() if page.kind.startswith("effect")]
    findings = [page for page in pages() if page.kind == "finding"]
    characteristics = [page for page in pages() if page.kind == "characteristic"]
    made = {
        "commands.md": ("Commands", _commands()),
        "characteristics.md": ("Characteristics", _characteristics(characteristics)),
        "findings.md": ("Findings", _findings(findings)),
        "effects.md": ("Effects", _effects(effects)),
        "dialects.md": ("Drivers of indicators", _dialects()),
        "glossary.md": ("Glossary", _glossary()),
        "json.md": ("Keys of the JSON objects", _keys_of_json()),
    }
    return {
        name: "\n\n".join([f"# {title}", MADE, *blocks]) + "\n"
        for name, (title, blocks) in made.items()
    }


def _commands() -> Iterator[str]:
    helps = {command: help_text(command) for command in (*COMMANDS, *SUBCOMMANDS)}
    helps = {command: helps[command] for command in sorted(helps, key=_by_group)}
    uses = Counter(option for text in helps.values() for option in dict.fromkeys(options(text)))
    shared = {option for option, count in uses.items() if count > 2}
    yield "## Shared options"
    yield (
        "They mean the same wherever they occur. Before the command: `--debug` shows the traceback "
        "of an error, `--no-color` turns colour off, `--version` shows the version."
    )
    yield _options([option for option in uses if option in shared])
    for command, text in helps.items():
        yield f"## `scara-iso {command}`"
        yield from _command(text, shared)


def _by_group(command: str) -> tuple[int, str]:
    """Return the place of a command in the list of ``--help``; of a subcommand, behind its own."""
    return [*COMMANDS].index(command.partition(" ")[0]), command


def help_text(command: str) -> str:
    """Return a command's ``--help``, 100 columns wide."""
    told = io.StringIO()
    with patch.dict(os.environ, COLUMNS="100"), redirect_stdout(told):
        main([*command.split(), "--help"])
    text = "\n".join(line.rstrip() for line in told.getvalue().strip().splitlines())
    return text.removeprefix("Usage: ")


def options(text: str) -> list[tuple[str, str]]:
    """Return every option of a help text with what it means."""
    found = re.findall(r"^  (?:-\w, )?(--.*(?:\n {6,}\S.*)*)", text, flags=re.MULTILINE)
    return list(map(_named, found))


def _named(entry: str) -> tuple[str, str]:
    name, meaning = re.split(r"\n +| {2,}", entry, maxsplit=1)
    return name, " ".join(meaning.split())


def _command(text: str, shared: set[tuple[str, str]]) -> Iterator[str]:
    """Yield the help of a command; shared options stand by their names alone."""
    usage, *blocks = text.split("\n\n")
    yield _code(usage)
    own: list[tuple[str, str]] = []
    for block in blocks:
        title, _, rest = block.partition("\n")
        if not title.endswith(":"):
            yield re.sub("^Example: (.*)$", r"Example: `\1`", " ".join(block.split()))
        elif not options(block):
            entries = re.findall(r"^  (\S.*(?:\n {6,}\S.*)*)", rest, flags=re.MULTILINE)
            own += map(_named, entries)
    every = [one for one in options(text) if one[0] not in EVERYWHERE]
    own += [one for one in every if one not in shared]
    if own:
        yield _options(own)
    if names := [f"`{one[0].split()[0]}`" for one in every if one in shared]:
        yield f"Shared: {', '.join(names)}"


def _options(found: list[tuple[str, str]]) -> str:
    rows = ((f"`{name.replace('|', ' or ')}`", meaning) for name, meaning in found)
    return _table(("option", "meaning"), rows)


def _code(text: str) -> str:
    text = text.strip("\n")
    return f"```text\n{text}\n```"


def _findings(found: Iterable[Page]) -> Iterator[str]:
    yield (
        "What `analyze`, `compare` and the report print below their figures. "
        "`scara-iso explain CODE` shows the same text."
    )
    for page in found:
        yield f"## `{page.code}`"
        yield as_options(f"{page.title}. {page.text[0]}")


def _characteristics(found: Iterable[Page]) -> Iterator[str]:
    yield (
        "The figures of ISO 9283 that indicators give, and what each needs. "
        "`scara-iso explain CODE` says more; `explain beyond-dials` what none measures."
    )
    rows = (
        (f"`{one.code}`", one.title, as_options(_after("Needs", one)), _after("Defined in", one))
        for one in found
    )
    yield _table(("code", "what it is", "needs", "source"), rows)


def _effects(found: Iterable[Page]) -> Iterator[str]:
    yield "What `diagnose` weighs against each other. `scara-iso explain CODE` says more."
    rows = (
        (
            f"`{one.code}`", one.title, _after("Cause:", one), _after("To confirm:", one),
            ", ".join(f"`{given.name}`" for given in one.parameters),
        )
        for one in found
    )  # fmt: skip
    yield _table(("effect", "what it does", "cause", "to confirm", "parameters"), rows)


def _after(word: str, page: Page) -> str:
    """Return what stands behind a word at the beginning of a paragraph of a page."""
    found = (text for text in page.text if text.startswith(word))
    return next(found, word).removeprefix(word).strip()


def _glossary() -> Iterator[str]:
    yield "The terms of the screens; `scara-iso explain TERM` prints the same text."
    for names, (title, text) in sorted(WORDS.items(), key=lambda one: one[0][0].lower()):
        yield as_options(f"**{', '.join(names)}**: {title.rstrip('.')}. {text}")


def _dialects() -> Iterator[str]:
    yield (
        'How to connect an indicator: [guide](../indicators.md). "Type" is what to write for '
        'axis X, with your port for PORT; "line" is baud, data bits, parity and stop bits; "asked '
        'by" is what is sent for one reading. Where the unit is in the type, the instrument does '
        'not send it and you state it. "Source" rates the documents: *high* is a maker\'s own or '
        "two independent ones that agree, *medium* one good source, *low* one weak source. None "
        "was tried on an instrument."
    )
    header = ("driver", "instruments", "cable", "type", "line", "asked by", "source")
    yield _table(header, map(_row, find_dialects().values()))
    yield "Not verified, by driver (`scara-iso ports --dialects` names the sources too):"
    yield "\n".join(
        f"* `{key}`: {'; '.join(dialect.unverified)}"
        for key, dialect in find_dialects().items() if dialect.unverified
    )  # fmt: skip


def _row(dialect: Dialect) -> tuple[str, ...]:
    stated = dialect.sends_unit or dialect.unit_request
    return (
        f"`{dialect.key}`",
        dialect.instruments,
        dialect.cable,
        f"`X={dialect.key}{'' if stated else '?unit=mm'}@PORT`",
        str(dialect.line),
        _bytes(dialect.request) if dialect.request else _sent(dialect),
        dialect.confidence,
    )


def _sent(dialect: Dialect) -> str:
    pulse = dialect.request_line
    return f"pulse on {pulse.line.upper()}" if pulse else "sends by itself"


def _bytes(data: bytes) -> str:
    return f"`{data.decode('latin-1').encode('unicode_escape').decode('ascii')}`"


def _keys_of_json() -> Iterator[str]:
    yield (
        "The objects of `--json` and their schemas (JSON Schema, draft 2020-12, closed), in which "
        "every key has a description. Conventions: [JSON objects](../json.md)."
    )
    yield ", ".join(f"[{name}](../schemas/{name}.json)" for name in sorted(PUBLISHED)) + "."
    yield "The keys that most readers need follow. A key with `?` is not always there."
    for name, shown in KEYS.items():
        title, *kinds = PUBLISHED[name]
        found = schema(title, *kinds)["$defs"]
        yield f"## `{name}`"
        for kind in shown:
            yield f"**{kind}**: {_first(found[kind])}"
            yield _table(("key", "type", "unit", "meaning"), _keys(found[kind]))


def schemas() -> dict[str, str]:
    """Return the text of every schema that is made from classes, by its file name."""
    made = {name: schema(title, *kinds) for name, (title, *kinds) in PUBLISHED.items()}
    return {f"{name}.json": json.dumps(found, indent=2) + "\n" for name, found in made.items()}


def _keys(kind: Json) -> Iterator[tuple[str, ...]]:
    for name, field in kind["properties"].items():
        always = "" if name in kind["required"] else " ?"
        yield f"`{name}`{always}", _type(field), _unit(field), _first(field)


def _first(described: Json) -> str:
    """Return the first sentence of a description."""
    text = described["description"].replace("``", "`").partition("\n\n")[0]
    return re.split(r"(?<!eq)\. (?=[A-Z])", text)[0].removesuffix(".")


def _unit(field: Json) -> str:
    """Return the unit of a key, or of what it holds."""
    held = [field, *field.get("anyOf", ()), field.get("items"), field.get("additionalProperties")]
    return next((one["unit"] for one in held if isinstance(one, dict) and "unit" in one), "")


def _type(field: Json) -> str:
    """Return the type of a key as a person reads it."""
    if "anyOf" in field:
        return " or ".join(map(_type, field["anyOf"]))
    if "$ref" in field:
        return str(field["$ref"].rpartition("/")[2])
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
    (DOCS / "figures" / "layers.svg").write_text(picture(), encoding="utf-8", newline="")
