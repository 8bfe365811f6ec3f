"""The test does not visit the standard's five poses.

ISO 9283 7.2 measures repeatability at P1 to P5 of the test cube; a figure from one pose holds for
that pose. `plan` computes the five for a robot.
"""

from scara_iso.iso9283.core.results import Finding, Findings, Measured, arrivals_by_pose

CODE = "poses"
_POSES = 5


def check(measured: Measured) -> Findings:
    """Yield a note for fewer than five poses."""
    found = len(arrivals_by_pose(measured.run, measured.poses))
    if measured.block is None and found < _POSES:
        what = f"{found} pose{'s' if found > 1 else ''} measured; the standard visits P1 to P5"
        yield Finding(CODE, "info", what, rule="ISO 9283 7.2: poses P1 to P5")
