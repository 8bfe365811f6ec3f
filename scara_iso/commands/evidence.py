"""The evidence of a report: its bytes, what was stated with them, a ZIP of all, whose it is."""

from __future__ import annotations

import io
import json
import os
import platform
import re
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from difflib import get_close_matches
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Literal

from scara_iso import rawfile, recorder
from scara_iso.base.errors import CannotCreateError, UsageError
from scara_iso.base.files import read_file, target_of, write_file
from scara_iso.base.published import to_json
from scara_iso.commands.shared.output import refuse_foreign, text_of
from scara_iso.commands.shared.series import FileBytes
from scara_iso.reporting import FIELDS, Restated
from scara_iso.run import Run
from scara_iso.tables import in_english, is_of_axes, is_of_corrections

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The earliest time that a ZIP file can hold."""
_PACKAGES = ("numpy", "scipy", "matplotlib", "openpyxl")
_LARGEST = 1 << 30


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """``evidence.json`` in the file that ``report`` archives."""

    schema: Literal["scara-iso/evidence/1"] = field(default="scara-iso/evidence/1", init=False)
    """Name and number of this schema."""
    report: str
    """Its title."""
    program: str
    """The version of scara-iso."""
    command: str
    """What made the report."""
    versions: Mapping[str, str]
    """Of Python and packages."""
    sha256: Mapping[str, Annotated[str, ("pattern", "^[0-9a-f]{64}$")]]
    """Of every file in it, by its name."""


def archive(
    files: Mapping[str, bytes], report: tuple[str, bytes], about: Mapping[str, str]
) -> bytes:
    """Return a ZIP file of ``files`` by name, the report, versions, and the SHA-256 of each.

    ``evidence.json`` holds ``about``, versions and hashes; no time of day enters.
    """
    members = {f"data/{name}": data for name, data in files.items()}
    members[f"report/{report[0]}"] = report[1]
    versions = {name: version(name) for name in _PACKAGES} | {"python": platform.python_version()}
    document = Evidence(
        **about,
        versions=versions,
        sha256={name: sha256(data).hexdigest() for name, data in sorted(members.items())},
    )
    members["evidence.json"] = (json.dumps(to_json(document), indent=2) + "\n").encode("ascii")
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as packed:
        for name, data in sorted(members.items()):
            member = zipfile.ZipInfo(name, _EPOCH)
            member.compress_type = zipfile.ZIP_DEFLATED
            member.external_attr = 0o644 << 16
            packed.writestr(member, data)
    return file.getvalue()


def with_recording(table: Path) -> Iterator[tuple[str, bytes]]:
    """Yield the raw file and the manifest beside a table, where it was recorded."""
    for path in (rawfile.raw_path(table), rawfile.manifest_path(table)):
        if path.is_file():
            yield path.name, read_file(path, _LARGEST)


def by_file_name(files: Sequence[FileBytes]) -> dict[str, bytes]:
    """Return the bytes by file name; of two files with one name the second is numbered."""
    found: dict[str, bytes] = {}
    for k, (file, data) in enumerate(files, 1):
        name = Path(file.name).name or "table"
        found[f"{k}-{name}" if name in found else name] = data
    return found


_RECORDED = re.compile(
    r"first_cycle.*|corrected_.*|axes_recorded|simulated|cycles_planned|record_.*|recorded|doubts|pose"
)


_OF_ONE = re.compile(r"_(?:x|y|z|theta|[0-9]+)$")
_NEAR = 0.84
"""`customer` and `custommer` are 0.94 alike, `operator` and `operator_name` 0.8."""


def _ask_back(stated: Iterable[str], keys: Mapping[str, str], table: Iterable[str]) -> None:
    """Raise `UsageError` for a key that is nearly one of a field of the report."""
    field_of = {key: field[0] for field in FIELDS.values() for key in field}
    plain = {key.replace("_", ""): key for key in field_of}
    free = {*field_of, *(key.lower() for key in table)}
    for key in stated:
        if _OF_ONE.sub("", keys[key]) in free:
            continue
        bare = re.sub(r"[-_. ]", "", keys[key])
        for near in get_close_matches(bare, plain, n=1, cutoff=_NEAR):
            key_of, field = plain[near], field_of[plain[near]]
            of_it = f" ({field})" if field != key_of else ""
            raise UsageError(
                f"`metadata={key}=..`: did you mean {key_of}{of_it}?",
                remedy=f"write {plain[near]}, or choose a name that is less similar",
            )


def restate(run: Run, stated: Mapping[str, str]) -> tuple[Run, tuple[Restated, ...]]:
    """Return the run with ``stated`` in its metadata, and each statement with what it overrides.

    Raises `UsageError` for a key that is no word, that the readings were read with (``unit``), or
    that the recording itself says (``simulated``, what was struck).
    """
    plain = {key: key.strip().lower().replace(" ", "_") for key in stated}
    keys = {key: next(iter(in_english({name: None}))) for key, name in plain.items()}
    for key in stated:
        if not recorder.METADATA_KEY.fullmatch(key.strip()):
            raise UsageError(
                f"`metadata={key}=..`: not a key", remedy="`metadata=operator=A. Muster`"
            )
    for key, name in keys.items():
        if is_of_axes(name) or is_of_corrections(name) or _RECORDED.fullmatch(name):
            raise UsageError(
                f"`metadata={key}=..`: how the readings were made cannot be overridden",
                remedy="state it in the table, where it can be checked",
            )
    _ask_back(stated, keys, run.metadata)
    known = {key.lower(): key for key in run.metadata}
    metadata = dict(run.metadata)
    parts = []
    for key, text in stated.items():
        name = known.get(keys[key], keys[key])
        before = metadata.get(name)
        if before != text:
            parts.append(Restated(name, text, before))
        metadata[name] = text
    return replace(run, metadata=metadata), tuple(parts)


REGISTER = ".scara-iso-reports.json"
"""Beside reports: which table and number each is of, so that none is lost under another."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One report of a folder."""

    tables: Sequence[str]
    """Paths of its tables from the folder of the report, else their SHA-256."""
    number: str
    """As it is stated; empty where it is not."""

    def is_of(self, other: Entry) -> bool:
        """Say whether both are of one test."""
        return bool(set(self.tables) & set(other.tables))

    def may_become(self, other: Entry) -> bool:
        """Say whether nothing is lost: the tables of a test may have become more."""
        return set(self.tables) <= set(other.tables)


def refuse_another(path: Path, entry: Entry, *, replace: bool) -> None:
    """Raise `CannotCreateError` where ``path`` holds no report; or another, or one has its number.

    With ``replace`` only where it is no report.
    """
    target = target_of(path)
    known = {} if target is None else _entries(target.parent)
    if replace:
        if target is not None and target.name not in known:
            refuse_foreign(target)
        return
    numbered = [name for name, one in known.items() if one.number and one.number == entry.number]
    there = known.get(path.resolve().name, entry)
    remedy = "name another file or number, or say `replace=True`"
    if target is not None and target.name not in known and not _may_become(target, entry):
        refuse_foreign(target)
        what = "is not a report of this table"
    elif others := [name for name in numbered if not known[name].is_of(entry)]:
        what = f"number {entry.number} is that of {others[0]}, of another table"
        remedy = "state another, as report_number, or say `replace=True`"
    elif not there.may_become(entry):
        more = "more tables" if there.is_of(entry) else "another table"
        what = f"is the report of {more}, {', '.join(there.tables)}"
    elif there.number != entry.number:
        what = f"is report {there.number}" if there.number else "is a report without a number"
    else:
        return
    raise CannotCreateError(what, where=str(path), remedy=remedy)


def _may_become(file: Path, entry: Entry) -> bool:
    """Say whether there is none, nothing in it, or a report that names one of these tables."""
    text = text_of(file).replace(b"\\", b"") if file.is_file() else b""  # Markdown's escapes
    names = [os.fsencode(Path(table).name) for table in entry.tables]
    return not text.strip() or (b"scara-iso" in text and any(name in text for name in names))


def register(path: Path, entry: Entry) -> None:
    """Note in the folder of a report whose it is; a stream has none."""
    target = target_of(path)
    if target is not None:
        known = _entries(target.parent) | {target.name: entry}
        lines = {name: asdict(one) for name, one in known.items()}
        text = json.dumps(lines, indent=1, sort_keys=True)
        write_file(target.parent / REGISTER, f"{text}\n".encode("ascii"))


def _entries(folder: Path) -> dict[str, Entry]:
    """Return the entries of the reports that are still there, by the names of their files."""
    try:
        lines = json.loads((folder / REGISTER).read_bytes())
        return {
            name: Entry([str(one) for one in lines[name]["tables"]], str(lines[name]["number"]))
            for name in lines
            if (folder / name).is_file()
        }
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return {}
