"""A recording was changed, or it cannot be seen whether it was.

The manifest holds the hashes of table and raw file, each line of the raw file that of the line
before. One differs. To compare, make the table again with record ``rebuild=True``.
"""

from scara_iso.iso9283.checks._stated import noted
from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "edited"
BRIEF = "recording edited or not sealed"


def check(measured: Measured) -> Findings:
    """Yield a warning for each doubt that the recorder wrote into the table's head."""
    for line in noted(measured.run, "doubts"):
        yield Finding(CODE, "warning", line)
