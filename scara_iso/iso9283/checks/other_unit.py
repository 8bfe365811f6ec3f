"""A part was read in another unit than the first.

Every length is converted to mm and every angle to degrees before anything is computed. But a dial
that was read in mm and stated in inches gives figures 25.4 times too large: correct its `# unit`
or repeat the part. A length and an angle are not compared.
"""

from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "other-unit"
BRIEF = "a part in another unit"


def check(measured: Measured) -> Findings:
    """Yield a warning for each part and axis in another unit than the first part's."""
    for said in measured.run.origin.other_units:
        yield Finding(CODE, "warning", said)
