"""Readings that are stored are not in the table.

The raw file beside the table holds more cycles: the recorder was killed before it made the table
anew. `resume=True` of record goes on and makes it, `rebuild=` makes it of what is stored.
"""

from scara_iso.iso9283.checks._stated import noted
from scara_iso.iso9283.cycles import TAKE_ALL
from scara_iso.iso9283.results import Finding, Findings, Measured
from scara_iso.rawfile import LEFT_OUT

CODE = "readings-left-out"
BRIEF = "stored readings are not in the table"


def check(measured: Measured) -> Findings:
    """Yield a warning where the raw file holds more than the table."""
    for line in noted(measured.run, LEFT_OUT):
        yield Finding(CODE, "warning", line, advice=TAKE_ALL)
