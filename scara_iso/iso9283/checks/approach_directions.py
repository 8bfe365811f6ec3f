"""A pose is not approached from three perpendicular directions.

The variation of pose accuracy vAP (7.2.3) is that of 30 cycles from each of three perpendicular
directions, as a column `approach` of +x, +y and +z names them. Two directions give a vAP that the
third may exceed; one gives none. +x and -x are not perpendicular.
"""

from scara_iso.iso9283.core.results import Finding, Findings, Measured, arrivals_by_pose

CODE = "approach-directions"
_PERPENDICULAR = 3


def check(measured: Measured) -> Findings:
    """Yield a warning for a pose with a vAP of too few directions, a note where there is none."""
    if measured.run.direction is None:
        return
    for pose, arrived in arrivals_by_pose(measured.run, measured.poses).items():
        found = {str(measured.run.arrival_at(one.label)[1]) for one in arrived}
        said = ", ".join(sorted(found))
        if len(found) == 1:
            what = f"no vAP: every arrival is from {said}; 7.2.3 asks for three directions"
            yield Finding(CODE, "info", what, pose=pose)
        elif len({direction[1] for direction in found}) < _PERPENDICULAR:
            what = f"approached from {said}: vAP of three perpendicular directions may be larger"
            rule = "ISO 9283 7.2.3: three perpendicular directions"
            yield Finding(CODE, "warning", what, pose=pose, rule=rule)
