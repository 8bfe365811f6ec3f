"""A part of the test was struck and repeated.

The reason is recorded with it. The struck recording stays in the test's folder and counts for
nothing; a report names it with its reason, so that nobody chooses among repetitions in silence.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283.results import Finding, Measured
from scara_iso.run import SEPARATOR

CODE = "parts-struck"
_RULE = "good practice (no clause verified): what is left out is named with its reason"


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a note for each recording that was struck."""
    for line in measured.run.metadata.get("parts_struck", "").split(SEPARATOR):
        if line.strip():
            yield Finding(CODE, "info", f"struck: {line.strip()}", rule=_RULE)
