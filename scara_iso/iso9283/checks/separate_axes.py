"""X, Y and Z come from separate runs.

The standard's radial figure is the scatter of one attained point. Where each axis has its own run
(``# axes_recorded: separately``), rows are paired by number only, and the radial figure is not of
one measurement. Record X and Y at once.
"""

from scara_iso.iso9283.core.results import Finding, Findings, Measured

CODE = "separate-axes"
_RULE = "ISO 9283 7.2.2: one attained position has all its coordinates"


def check(measured: Measured) -> Findings:
    """Yield a note where radial figures are made of axes from separate runs."""
    stated = measured.run.metadata.get("axes_recorded", "").strip().lower()
    radial = [name for name in ("XY", "XYZ") if name in measured.poses[0].figures]
    if stated.startswith("separate") and radial:
        what = (
            f"{' and '.join(radial)}: the axes come from separate runs and are paired by row "
            "number; this is not a joint measurement"
        )
        yield Finding(CODE, "info", what, rule=_RULE)
