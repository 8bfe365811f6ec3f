"""A part of the test was struck and repeated.

The recording that was struck stays in the folder and does not count; the report names it with its
reason.
"""

from scara_iso.iso9283.checks._stated import noted
from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "parts-struck"
_RULE = "good practice (no clause verified): what is left out is named with its reason"


def check(measured: Measured) -> Findings:
    """Yield a note for each recording that was struck."""
    for line in noted(measured.run, "parts_struck"):
        yield Finding(CODE, "info", f"struck: {line}", rule=_RULE)
