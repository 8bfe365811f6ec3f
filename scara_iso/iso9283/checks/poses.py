"""The test does not visit the standard's five poses.

ISO 9283 7.2 measures repeatability at P1 to P5 of the test cube; a figure from one pose holds for
that pose. `plan` computes the five for a robot.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283.results import Finding, Measured

CODE = "poses"
_POSES = 5


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a note for fewer than five poses."""
    found = len({measured.run.arrival_at(pose.label)[0] for pose in measured.poses})
    if measured.block is None and found < _POSES:
        yield Finding(
            CODE,
            "info",
            f"{found} pose{'s' if found > 1 else ''} measured; the standard visits P1 to P5",
            rule="ISO 9283 7.2: poses P1 to P5",
        )
