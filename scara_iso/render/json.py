"""Results as JSON objects: the stable schemas of docs/json.md."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

_HALF = re.compile("[\ud800-\udfff]")
"""Half a character, as a byte of a file's name that is no text; strict readers refuse it."""


def to_text(document: Mapping[str, Any]) -> str:
    r"""Return one line of JSON, all ASCII; NaN and infinity are a programming error.

    Half a character is spelt by its code, ``\udcff``, as wherever text is shown.
    """
    text = json.dumps(document, allow_nan=False)
    if "\\ud" in text:
        line = json.dumps(document, ensure_ascii=False)
        whole = _HALF.sub(lambda half: rf"\\u{ord(half[0]):04x}", line)
        text = json.dumps(json.loads(whole))
    return text
