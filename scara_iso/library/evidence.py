"""The evidence of a report: one ZIP file of all that it was made of."""

from __future__ import annotations

import io
import json
import platform
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Literal

from scara_iso.base.files import read_file
from scara_iso.base.published import to_json

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The earliest time that a ZIP file can hold."""
_PACKAGES = ("numpy", "scipy", "matplotlib", "openpyxl")
_LARGEST = 1 << 30


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """``evidence.json`` in the file that ``report`` archives."""

    schema: Literal["scara-iso/evidence/1"]
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
        schema="scara-iso/evidence/1",
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
    from scara_iso.rawfile import manifest_path, raw_path

    for beside in (raw_path(table), manifest_path(table)):
        if beside.is_file():
            yield beside.name, read_file(beside, _LARGEST)
