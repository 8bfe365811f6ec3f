"""A planned test of poses: cube or box, diagonal plane, P1 to P5, and how they are visited.

What follows from the geometry of the arm is computed and checked; velocity, load, dwell and the
order of visits are the conditions of the test, carried along so that one table holds all that a
robot program needs. Sources: Mousavi et al., section II, eq. 1, Fig. 1 and 2; ISO 9283, 6.8, as
known in the trade.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias, get_args

import numpy as np

from scara_iso.base.displayed import Plotted
from scara_iso.base.errors import UsageError
from scara_iso.base.published import INTERNAL, Count, fill, publish, published
from scara_iso.iso9283.core.figures import Poses
from scara_iso.robot import SMALLEST_MM, Arm, Elbow, Rated, Rectangle, Workspace, largest_rectangle
from scara_iso.run import FloatArray, frame_of

if TYPE_CHECKING:
    import pandas as pd


UNRATED = Rated()

PoseName: TypeAlias = Literal["P1", "P2", "P3", "P4", "P5"]
POSES: tuple[str, ...] = get_args(PoseName)
Travel: TypeAlias = Literal["linear", "joint"]
Coordinate: TypeAlias = Annotated[float, ("unit", "mm")]
Degrees: TypeAlias = Annotated[float, ("unit", "deg")]
Kilograms: TypeAlias = Annotated[float, ("unit", "kg")]


class Solid(Enum):
    """What is laid into the workspace."""

    CUBE = "cube"
    """The largest cube. Where the stroke is its shortest side, the cube keeps the centre of the
    largest square that fits seen from above."""
    BOX = "box"
    """The largest rectangular area times the stroke, which may take the cube's place where one
    axis has a small range."""


class DiagonalPlane(Enum):
    """A diagonal plane by its corners, in their order around it.

    The numbering of the corners is background knowledge of ISO 9283's figure, not quoted from it:
    here C1 to C4 go counter-clockwise around the lower face from the corner of least x and y, seen
    from above, and C5 to C8 lie above them.
    """

    C1_C2_C7_C8 = "C1-C2-C7-C8"
    C2_C3_C8_C5 = "C2-C3-C8-C5"
    C3_C4_C5_C6 = "C3-C4-C5-C6"
    C4_C1_C6_C7 = "C4-C1-C6-C7"

    @property
    def corners(self) -> tuple[int, ...]:
        """Numbers of the four corners."""
        return tuple(int(name[1]) for name in self.value.split("-"))


@dataclass(frozen=True, slots=True)
class PoseTestConditions:
    """How the poses are visited. Raises `UsageError` for invalid values."""

    cycles: int = 31
    """Cycles run; the paper runs 31, of which the first only settles the contact side."""
    discarded: int = 1
    """Cycles at the beginning whose readings do not count."""
    velocity_percent: float = 100.0
    """Percent of the rated velocity."""
    load_percent: float = 100.0
    """Percent of the rated load."""
    dwell_s: float = 2.0
    """Time at each pose before the reading: at least the robot's stabilisation time. The default
    is a choice of this program."""
    order: tuple[str, ...] = ("P5", "P4", "P3", "P2", "P1")
    """Order of visits in each cycle, which begins at P1; background knowledge of ISO 9283."""

    def __post_init__(self) -> None:
        known = {
            "no cycle is left to be used": 0 <= self.discarded < self.cycles,
            f"velocity_percent is {self.velocity_percent:g}": 0 < self.velocity_percent <= 100,
            f"load_percent is {self.load_percent:g}": 0 <= self.load_percent <= 100,
            f"dwell_s is {self.dwell_s:g}": 0 <= self.dwell_s < math.inf,
            **{f"no pose {name!r}": name in POSES for name in self.order},
            "no pose is visited": bool(self.order),
        }
        if not all(known.values()):
            faults = [fault for fault, is_right in known.items() if not is_right]
            raise UsageError(
                f"not a valid test: {', '.join(faults)}",
                remedy="percentages go up to 100, times are not negative, poses are P1 to P5",
            )

    @property
    def used(self) -> int:
        """Cycles of which the readings count."""
        return self.cycles - self.discarded


@dataclass(frozen=True)
class Attained:
    """Where the tool is in the base frame, and the joints that bring it there."""

    x_mm: Coordinate
    """Of the tool in the base frame."""
    y_mm: Coordinate
    """Likewise."""
    z_mm: Coordinate
    """Likewise."""
    theta_deg: Degrees
    """About z, of the tool."""
    joint_1_deg: Degrees
    """Angle of joint 1."""
    joint_2_deg: Degrees
    """Angle of joint 2."""
    joint_3_mm: Coordinate
    """Vertical."""
    joint_4_deg: Degrees
    """Wrist."""
    singularity_deg: Degrees
    """By how much joint 2 misses straight or folded, where the arm is singular."""
    manipulability: float
    """|sin joint 2|: 1 where the arm moves equally well in all directions, 0 where singular."""


@dataclass(frozen=True)
class PlannedPose(Attained):
    """One pose; its ``name`` is ``P1`` to ``P5``."""

    name: str

    @property
    def label(self) -> str:
        """The name, as that of a measured pose."""
        return self.name


@dataclass(frozen=True)
class PoseOfVisit:
    """Which pose is visited."""

    visit: Count
    """From 1, in order."""
    pose: PoseName
    """Which is visited."""


@dataclass(frozen=True, kw_only=True)
class PlannedVisit(Attained, PoseOfVisit):
    """One visit of a cycle; what the model does not rate is null."""

    from_pose: PoseName
    """The pose visited before."""
    path: Travel
    """A line of the tool, or the joints turn."""
    velocity_percent: float
    """Per cent of the rated one."""
    velocity_mm_s: Annotated[float, ("unit", "mm/s")] | None
    """The same as a velocity."""
    load_percent: float
    """Per cent of the rated one."""
    load_kg: Kilograms | None
    """The same as a load."""
    dwell_s: Annotated[float, ("unit", "s")]
    """Time at the pose before the reading."""
    cycles: Count
    """Cycles run."""


@dataclass(frozen=True, slots=True)
class PlannedCycles:
    """How many cycles are planned."""

    run: Count
    """All of them."""
    used: Count
    """Those of which the readings count."""


def _planned_cycles(conditions: PoseTestConditions) -> PlannedCycles:
    return PlannedCycles(conditions.cycles, conditions.used)


CYCLES = published("cycles", by=_planned_cycles)
"""How a plan publishes its conditions."""
Length: TypeAlias = Annotated[float, ("unit", "mm"), ("minimum", 0)]
Corner: TypeAlias = tuple[Coordinate, Coordinate, Coordinate]


def _listed(corners: FloatArray) -> Annotated[tuple[Corner, ...], ("minItems", 8), ("maxItems", 8)]:
    return tuple((x, y, z) for x, y, z in corners.tolist())


@dataclass(frozen=True, eq=False, kw_only=True)
class PosePlan(Plotted):
    """``plan`` of the poses of ISO 9283. Lengths in mm, in the base frame; arrays read-only."""

    schema: Literal["scara-iso/plan/1"] = "scara-iso/plan/1"
    """Name and number of this schema."""
    unit: Literal["mm"] = "mm"
    """Of every length."""
    solid: Solid
    """What is laid into the workspace."""
    corners: FloatArray = field(metadata=published(by=_listed))
    """C1 to C8, shape (8, 3)."""
    size_mm: tuple[Length, Length, Length] = field(init=False)
    """Edges along x, y and z."""
    plane: DiagonalPlane
    """The diagonal plane that holds the poses."""
    elbow: Elbow
    """Side of the elbow at every pose."""
    poses: Poses[PlannedPose] = field(metadata=INTERNAL)
    """By number or name. P1 is the centre of the plane, P2 to P5 lie on its diagonals, next to its
    corners in their order."""
    diagonal_mm: Length
    """L of eq. 1. The paper takes the diagonal of the cube, ISO 9283 that of the plane: they are
    the same line, since a diagonal plane holds two space diagonals of its cube or box."""
    m_mm: Length
    """Distance of P2 to P5 from their corners, along the diagonal."""
    stroke_limits: bool
    """Whether a larger cube would fit if the stroke were longer."""
    conditions: PoseTestConditions = field(metadata=CYCLES)
    """Of each pose."""
    arm: Arm = field(metadata=INTERNAL)
    """The arm that it is planned for."""
    rated: Rated = UNRATED
    """Load and velocity."""
    visits: tuple[PlannedVisit, ...] = field(init=False)
    """One cycle, in order. It begins at P1, so every pose is always approached from the same one;
    the path from it is a line in the plane, as the paper's."""

    def __post_init__(self) -> None:
        self.corners.flags.writeable = False
        x, y, z = (self.corners[6] - self.corners[0]).tolist()
        visits = planned_visits(self.poses, self.conditions, self.rated, path="linear")
        fill(self, size_mm=(x, y, z), visits=visits)

    def __repr__(self) -> str:
        x, y, z = self.size_mm
        names = ", ".join(pose.name for pose in self.poses)
        return f"<PosePlan: {self.solid.value} of {x:.1f} x {y:.1f} x {z:.1f} mm, {names}>"

    @property
    def m_over_diagonal(self) -> float:
        """Share of m in L, which eq. 1 wants within 0.1 ± 0.02."""
        return self.m_mm / self.diagonal_mm

    def to_frame(self) -> pd.DataFrame:
        """Return one cycle as a pandas table: what `PlannedVisit` has, a row for each visit."""
        return frame_of(self.rows(), {})

    def rows(self) -> list[Mapping[str, str | int | float | None]]:
        """Return one cycle as a table, one row for each visit in order, for a robot program."""
        return [asdict(visit) for visit in self.visits]


def planned_visits(
    poses: Poses[PlannedPose], how: PoseTestConditions, rated: Rated, *, path: Travel
) -> tuple[PlannedVisit, ...]:
    """Return one cycle, one visit after the other; ``path`` leads to each."""
    before = ("P1", *how.order)
    return tuple(
        publish(
            PlannedVisit,
            poses[name],
            visit=number,
            pose=name,
            from_pose=before[number - 1],
            path=path,
            velocity_percent=how.velocity_percent,
            velocity_mm_s=_share(how.velocity_percent, rated.velocity_mm_s),
            load_percent=how.load_percent,
            load_kg=_share(how.load_percent, rated.load_kg),
            dwell_s=how.dwell_s,
            cycles=how.cycles,
        )
        for number, name in enumerate(how.order, start=1)
    )


def _share(percent: float, rated: float | None) -> float | None:
    return None if rated is None else percent * rated / 100


_TOLERANCE = (0.08, 0.12)
"""m = (0.1 ± 0.02) L, eq. 1; ISO 9283 asks the same of the ends of the plane's diagonals."""


def make_plan(
    arm: Arm,
    *,
    solid: Solid = Solid.CUBE,
    plane: DiagonalPlane = DiagonalPlane.C1_C2_C7_C8,
    elbow: Elbow | None = None,
    m_over_diagonal: float = 0.1,
    conditions: PoseTestConditions | None = None,
    rated: Rated = UNRATED,
) -> PosePlan:
    """Return the test for ``arm``, every pose within reach and limits.

    With ``elbow`` the cube lies in what that elbow reaches; without, in what either reaches, and
    the elbow that keeps all poses furthest from singularities is taken. Raises `UsageError` for an
    m outside eq. 1, an arm without stroke or area, and poses that one elbow does not reach.
    """
    _check(arm, m_over_diagonal)
    elbows = tuple(Elbow) if elbow is None else (elbow,)
    workspace = Workspace.of(arm, elbows)
    area = largest_rectangle(workspace, square=solid is Solid.CUBE)
    corners = _corners(area, arm, solid)
    places, diagonal = _places(corners[[c - 1 for c in plane.corners]], m_over_diagonal)
    poses = np.column_stack([places, np.zeros(len(places))])
    side, joints = _reached(arm, poses, elbows)
    return PosePlan(
        solid=solid,
        corners=corners,
        plane=plane,
        elbow=side,
        poses=Poses(planned_poses(arm, poses, joints)),
        diagonal_mm=diagonal,
        m_mm=m_over_diagonal * diagonal,
        stroke_limits=solid is Solid.CUBE and area.width > arm.stroke_mm,
        conditions=PoseTestConditions() if conditions is None else conditions,
        arm=arm,
        rated=rated,
    )


def _check(arm: Arm, m_over_diagonal: float) -> None:
    low, high = _TOLERANCE
    if not low - 1e-12 <= m_over_diagonal <= high + 1e-12:
        raise UsageError(
            f"m = {m_over_diagonal:g} L is outside (0.1 ± 0.02) L",
            remedy=f"choose it from {low:g} to {high:g}",
        )
    if arm.stroke_mm < SMALLEST_MM:
        raise UsageError(
            f"a stroke of {arm.stroke_mm:g} mm leaves no room for a cube",
            remedy="give the model's quill its lowest and highest z: [robot] quill_mm = [0, 200]",
        )


def _corners(area: Rectangle, arm: Arm, solid: Solid) -> FloatArray:
    """Return C1 to C8 of the solid over ``area``, in the middle of the stroke, shape (8, 3).

    The centre is rounded to whole micrometres, as a controller takes them, and the edges give way.
    """
    x, y = (math.floor(side * 1000 - 1) / 1000 for side in (area.width, area.depth))
    z = arm.stroke_mm
    if solid is Solid.CUBE:
        x = y = z = min(x, y, z)
    middle = np.array([round(area.x, 3), round(area.y, 3), sum(arm.quill_mm) / 2]) + 0.0
    around = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    signs = [(*xy, up) for up in (-1, 1) for xy in around]
    return np.asarray(middle + np.array(signs) * (x, y, z) / 2)


def _places(corners: FloatArray, m_over_diagonal: float) -> tuple[FloatArray, float]:
    """Return P1 to P5, shape (5, 3), in the plane of four corners, and the plane's diagonal."""
    centre = corners.mean(axis=0)
    diagonal = float(np.linalg.norm(corners[2] - corners[0]))
    inner = corners + 2 * m_over_diagonal * (centre - corners)
    return np.round(np.vstack([centre, inner]), 3), diagonal


def _reached(arm: Arm, poses: FloatArray, elbows: tuple[Elbow, ...]) -> tuple[Elbow, FloatArray]:
    """Return the elbow that reaches all poses furthest from singularities, and the joints."""
    found: list[tuple[float, Elbow, FloatArray]] = []
    faults = []
    for elbow in elbows:
        try:
            joints = arm.inverse(poses, elbow=elbow)
            found.append((float(arm.singularity_deg(joints).min()), elbow, joints))
        except UsageError as error:
            faults.append(str(error))
    if not found:
        raise UsageError(
            f"no elbow reaches all poses: {'; '.join(faults)}",
            remedy="name an elbow: the cube is then laid into what that elbow reaches",
        )
    # rounding must not choose between mirrored elbows
    _, elbow, joints = max(found, key=lambda f: round(f[0], 6))
    return elbow, joints


def planned_poses(arm: Arm, poses: FloatArray, joints: FloatArray) -> tuple[PlannedPose, ...]:
    """Return P1 and so on at ``poses`` (n, 4), reached by ``joints`` (n, 4), in mm and degrees."""
    apart, turn = arm.singularity_deg(joints), np.abs(np.sin(np.radians(joints[:, 1])))
    table = np.column_stack([poses, joints, apart, turn]).tolist()
    return tuple(PlannedPose(*[*row, name]) for name, row in zip(POSES, table, strict=True))
