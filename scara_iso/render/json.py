"""Results as JSON objects: the stable schemas of docs/json.md."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from enum import Enum
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from scara_iso.iso9283 import published_analysis
from scara_iso.published import Json, to_json

if TYPE_CHECKING:
    from scara_iso.iso9283 import Analysis
    from scara_iso.reporting import Page

_HALF = re.compile("[\ud800-\udfff]")
"""Half a character, as a byte of a file's name that is no text; strict readers refuse it."""
APART = "angle_deg observability_index smallest_angle_deg between uncertainty"


def to_text(document: Mapping[str, Any]) -> str:
    r"""Return one line of JSON, all ASCII; NaN and infinity are a programming error.

    Half a character is spelt by its code, ``\udcff``, as wherever text is shown.
    """
    text = json.dumps(document, allow_nan=False)
    if "\\ud" in text:
        said = json.dumps(document, ensure_ascii=False)
        whole = _HALF.sub(lambda half: rf"\\u{ord(half[0]):04x}", said)
        text = json.dumps(json.loads(whole))
    return text


def plain(value: Any) -> Any:
    """Return a value as JSON has it: enums by their value, arrays and tuples as lists."""
    if isinstance(value, Mapping):
        return {key: plain(one) for key, one in value.items()}
    if isinstance(value, tuple | list):
        return [plain(one) for one in value]
    if isinstance(value, Enum):
        return value.value
    return value.tolist() if hasattr(value, "tolist") else value


def picked(found: object, keys: str) -> Json:
    """Return attributes of a result in the order of ``keys``, one ``key`` or ``key=attribute``."""
    pairs = (key.partition("=") for key in keys.split())
    return {key: plain(attrgetter(path or key)(found)) for key, _, path in pairs}


def each(found: Iterable[object], keys: str) -> list[Json]:
    """Return what is `picked` of each result."""
    return [picked(one, keys) for one in found]


def analysis_json(analysis: Analysis) -> Json:
    """Return the JSON object of ``analyze``, schema ``scara-iso/analyze/2``."""
    found: Json = to_json(published_analysis(analysis))
    return found


def explain_json(pages: Iterable[Page]) -> Json:
    """Return the JSON object of ``explain``, schema ``scara-iso/explain/1``."""
    names = ("name", "unit", "meaning")
    return {
        "schema": "scara-iso/explain/1",
        "pages": [
            {
                **picked(page, "code kind title text"),
                "parameters": [dict(zip(names, row, strict=True)) for row in page.parameters],
            }
            for page in pages
        ],
    }
