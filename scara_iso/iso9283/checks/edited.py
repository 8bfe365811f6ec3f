"""A recording was changed, or it cannot be seen whether it was.

The recorder writes a manifest with the hashes of the table and of the raw file, and each line of
the raw file names the one before it. One of these is not what it was. Recording with
``rebuild=True`` makes the table of the raw file again, to compare; the doubt stays in its
head, and in that of a recording that is resumed.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283.results import Finding, Measured
from scara_iso.run import SEPARATOR

CODE = "edited"
BRIEF = "recording edited or not sealed"


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for each doubt that the recorder wrote into the table's head."""
    for line in measured.run.metadata.get("doubts", "").split(SEPARATOR):
        if line.strip():
            yield Finding(CODE, "warning", line.strip())
