"""What one search over all poses of a test says: a frozen result, in the units of its axes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scara_iso.base.display import Plotted
from scara_iso.diagnosis.result import Diagnosis, Error, Found
from scara_iso.diagnosis.verdict import Rival, Verdict
from scara_iso.run import FloatArray, make_frame

if TYPE_CHECKING:
    import pandas as pd

    from scara_iso.diagnosis.joint_scatter.result import FollowedInJoints, JointScatter


@dataclass(frozen=True, slots=True)
class Separation:
    """How well the poses of a test tell joint 1 from joint 2."""

    angle_deg: float
    """Between the movements of all axes, beside their scatter: 90 is best, 0 not at all."""
    observability_index: float
    """Smaller over larger singular value of the joints' movements (Nahvi and Hollerbach 1996)."""


@dataclass(frozen=True, eq=False, slots=True)
class DiagnosisOfPoses(Plotted):
    """What one search over all poses of a test found."""

    poses: Mapping[str, Diagnosis]
    """By name: what acts there, error, repeatability and series."""
    effects: tuple[Found, ...]
    """In the order in which they were found; sizes are by pose and axis."""
    verdict: Verdict
    """Of all poses together."""
    p_value: float
    """Chance of structure as strong anywhere in scatter alone."""
    p_value_at_floor: bool
    """No permutation was as far: the chance is at most the p-value."""
    candidates: tuple[Rival, ...]
    """Likeliest explanations of what the last stage still found."""
    error_before: Error
    """Of the model as it was, over all poses."""
    error_after: Error
    """Of the model with the effects found."""
    separation: Separation | None = None
    """None without the joints at every pose."""
    notes: tuple[str, ...] = ()
    """How the tables were read and what could not be searched, one line each."""
    courses: tuple[FloatArray, ...] = ()
    """Over the cycles, of each effect found, shape (n, k) for a known course, (n, 0) for none."""
    followed: tuple[FollowedInJoints, ...] = ()
    """What follows a recorded column, found or not, traced to the joints; likewise."""
    joint_scatter: JointScatter | None = None
    """Scatter of all poses traced to the joints; None without a model that says where they are."""

    @property
    def scatter(self) -> dict[str, float]:
        """Standard deviation of each axis beside effects and rounding: of all poses, in rms."""
        squares: dict[str, list[float]] = {}
        for one in self.poses.values():
            for axis, value in one.scatter.items():
                squares.setdefault(axis, []).append(value**2)
        return {axis: float(np.sqrt(np.mean(own))) for axis, own in squares.items()}

    def __getitem__(self, at: int | str) -> Diagnosis:
        """Return the diagnosis of a pose by its number or its name."""
        if not isinstance(at, str):
            return list(self.poses.values())[at]
        if at not in self.poses:
            raise KeyError(f"no pose {at!r}: there is {', '.join(self.poses)}")
        return self.poses[at]

    def __repr__(self) -> str:
        said = ", ".join(f"{pose} {one.verdict.value}" for pose, one in self.poses.items())
        return f"<DiagnosisOfPoses: {said}>"

    def to_frame(self) -> pd.DataFrame:
        """Return the series of every pose below each other, as `Diagnosis.to_frame`, by pose."""
        frames = [one.to_frame() for one in self.poses.values()]
        counts = [len(frame) for frame in frames]
        columns = {
            str(name): np.concatenate([frame[name].to_numpy() for frame in frames])
            for name in frames[0]
        }
        poses = np.repeat(np.array(list(self.poses)), counts)
        return make_frame({"pose": poses, **columns}, {"verdict": self.verdict.value})
