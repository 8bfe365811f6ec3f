"""A part was recorded with another instrument than the test names.

test.toml names the indicator of each axis with its certificate, and the table of a part states the
one that was used. Where they differ, one statement is wrong or the indicator was changed: state the
change, and repeat what was recorded without a valid certificate.
"""

from scara_iso.iso9283.checks._stated import stated
from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "other-instrument"
_RULE = "the test's own plan: the instruments that test.toml names"


def check(measured: Measured) -> Findings:
    """Yield a warning for what a table states of its instruments otherwise than the test does."""
    for line in stated(measured.run.metadata, {"instrument_of_the_test"}):
        pose = line.key.partition("[")[2].rstrip("]")
        where = f"at {pose}: " if pose else ""
        yield Finding(CODE, "warning", f"{where}{line.text}", rule=_RULE)
