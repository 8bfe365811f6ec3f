"""A pose is not approached from three perpendicular directions.

The variation of pose accuracy vAP (7.2.3) is that of 30 cycles from each of three perpendicular
directions, as a column `approach` of +x, +y and +z names them. From two directions it is given, and
the third may lie farther away; from one there is none. +x and -x are two directions, and not
perpendicular.
"""

from __future__ import annotations

from collections.abc import Iterator

from scara_iso.iso9283.results import Finding, Measured

CODE = "approach-directions"
_PERPENDICULAR = 3


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for a pose with a vAP of too few directions, a note where there is none."""
    run = measured.run
    if run.direction is None:
        return
    by_pose: dict[str | None, set[str]] = {}
    poses = [None] * len(run) if run.pose is None else run.pose.tolist()
    for pose, direction in zip(poses, run.direction.tolist(), strict=True):
        by_pose.setdefault(pose, set()).add(direction)
    for pose, found in by_pose.items():
        said = ", ".join(sorted(found))
        if len(found) == 1:
            what = f"no vAP: every arrival is from {said}; 7.2.3 asks for three directions"
            yield Finding(CODE, "info", what, pose=pose)
        elif len({direction[1] for direction in found}) < _PERPENDICULAR:
            yield Finding(
                CODE,
                "warning",
                f"approached from {said}: vAP of three perpendicular directions may be larger",
                pose=pose,
                rule="ISO 9283 7.2.3: three perpendicular directions",
            )
