"""Several poses: each is diagnosed alone, at one family-wise level for all (Holm 1979)."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from scara_iso.diagnosis.result import Diagnosis
from scara_iso.diagnosis.tuning import LEVEL
from scara_iso.run import Run

Pose = str | None


def holm(p_values: Mapping[Pose, float], level: float = LEVEL) -> frozenset[Pose]:
    """Return the poses whose structure counts at the family-wise ``level`` (Holm 1979)."""
    ranked = sorted(p_values, key=p_values.__getitem__)
    admitted = []
    for k, pose in enumerate(ranked):
        if p_values[pose] > level / (len(ranked) - k):
            break
        admitted.append(pose)
    return frozenset(admitted)


def diagnose_poses(
    run: Run, diagnose: Callable[[Run, float], Diagnosis], *, level: float = LEVEL
) -> dict[Pose, Diagnosis]:
    """Return the diagnosis of every pose of a run, structure found at one level for all.

    ``diagnose(run of one pose, level)`` gives a single one; a pose that `holm` does not admit is
    diagnosed again at level 0, which finds nothing.
    """
    runs = {pose: run.take(rows) for pose, rows in run.rows_by_pose()}
    first = {pose: diagnose(single, level) for pose, single in runs.items()}
    admitted = holm({pose: result.p_value for pose, result in first.items()}, level)
    return {
        pose: result if pose in admitted else diagnose(runs[pose], 0.0)
        for pose, result in first.items()
    }
