"""A part was read in another unit than the first.

Every length is converted to mm and every angle to degrees before anything is computed, so parts in
inches and in mm stand together. But a dial that was read in mm and stated in inches gives figures
25.4 times too large: look at the instrument of that part, and correct its `# unit` or repeat it.
"""

from scara_iso.iso9283.results import Finding, Findings, Measured

CODE = "other-unit"
BRIEF = "a part in another unit"


def check(measured: Measured) -> Findings:
    """Yield a warning for each part and axis in another unit than the first part's."""
    for said in measured.run.origin.other_units:
        yield Finding(CODE, "warning", said)
