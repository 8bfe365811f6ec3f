"""What a model is made of: arm, poses, indicators, gears, and the effects that it declares.

Lengths in mm, joint angles in degrees, inertias in kg m2. A robot's model is a file, MODEL.toml
(`model_file`); what it says that a dial will read is in `prediction`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np

from scara_iso.base.errors import UsageError
from scara_iso.base.published import ALWAYS
from scara_iso.base.quantities import Dimension
from scara_iso.effects import Effect, OwnEffect
from scara_iso.robot.arm import Arm
from scara_iso.robot.two_inertia import Backlash, backlash
from scara_iso.run import FloatArray, IntArray

Value = float | str | Mapping[str, float]
Joints = tuple[float, float]
"""Joints 1 and 2 in degrees."""


@dataclass(frozen=True, slots=True)
class Gearbox:
    """One joint's drive, as its catalogue gives it."""

    Im: float
    """Inertia of motor and gear, on its own shaft [kg m2]."""
    IL: float
    """Inertia of the load [kg m2]."""
    arcmin: float
    """Full gap at the output [arcmin]."""
    ratio: float | None = None
    """Gear ratio N; None where not given."""
    stiffness: float | None = None
    """Of gear and shaft, at the output [N m/rad]."""
    friction: float | None = None
    """Coulomb friction on the load [N m]."""
    payload_kg: float | None = None
    """Payload that ``IL`` includes [kg]; the reversal then follows a ``payload_kg`` column."""

    def backlash(self, arm: float | None = None) -> Backlash:
        """Return the two-inertia model of this gear, eq. 16; ``arm``: joint to tool [m]."""
        return backlash(Im=self.Im, IL=self.IL, arcmin=self.arcmin, arm=arm, ratio=self.ratio)


@dataclass(frozen=True, slots=True)
class Indicator:
    """One dial: what it shows at the pose, its smallest step and its certificate."""

    axis: str
    dimension: Dimension = Dimension.LENGTH
    resolution: float | None = None
    uncertainty: float | None = None
    level: float = 0.0
    """Reading at the pose without any effect."""
    scatter: float = 0.0
    """Standard deviation of the arrivals that no effect explains; used to simulate."""


@dataclass(frozen=True, slots=True)
class Rated:
    """What a test's percentages are of, as the maker rates the robot; null where not stated."""

    load_kg: Annotated[float, ("unit", "kg")] | None = field(default=None, metadata=ALWAYS)
    """Rated load."""
    velocity_mm_s: Annotated[float, ("unit", "mm/s")] | None = field(default=None, metadata=ALWAYS)
    """Of the tool along a line."""


@dataclass(frozen=True, slots=True)
class DeclaredEffect:
    """An effect that the model knows of.

    ``parameters`` are those of the effect; a mapping gives one value for each axis it acts on,
    and an effect acts on the axes of its first such mapping (``size``). A gear effect names its
    ``joint``.
    """

    name: str
    parameters: Mapping[str, Value] = field(default_factory=dict)
    joint: int | None = None

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes on which the effect acts, in the order of the file."""
        maps = (value for value in self.parameters.values() if isinstance(value, Mapping))
        return tuple(next(maps, {}))

    def on_axis(self, axis: str) -> dict[str, float | str]:
        """Return the parameters that hold for one axis."""
        return {
            name: value[axis] if isinstance(value, Mapping) else value
            for name, value in self.parameters.items()
        }


@dataclass(frozen=True, eq=False, slots=True)
class DeclaredCourse:
    """A course without a name, learned of one table: knots at cycles, with their uncertainties."""

    axis: str
    cycle: FloatArray
    """Cycle numbers that increase, shape (n,)."""
    value: FloatArray
    """Displacement at the knots, shape (n,) [mm, deg]."""
    u: FloatArray
    """Standard uncertainty of the values, shape (n,) [mm, deg]."""

    def at(self, cycle: IntArray) -> FloatArray:
        """Return the displacement at some cycles, linear between knots and constant beyond."""
        return np.interp(cycle, self.cycle, self.value)


@dataclass(frozen=True, slots=True)
class Model:
    """A robot at its poses, seen by indicators, with the effects that are known."""

    robot: str
    indicators: Mapping[str, Indicator]
    arm: Arm | None = None
    joints_deg: Joints | None = None
    """Joints 1 and 2 at the pose of a table of one; None where it is not given."""
    gearboxes: Mapping[int, Gearbox] = field(default_factory=dict)
    """By the number of the joint."""
    effects: tuple[DeclaredEffect, ...] = ()
    rated: Rated = Rated()
    """What percentages of load and velocity are of."""
    serial_number: str = ""
    """As the file states it."""
    own: tuple[OwnEffect, ...] = ()
    """Effects of a user's own, which stand in the file or beside it."""
    poses: Mapping[str, Joints] = field(default_factory=dict)
    """Joints 1 and 2 at each named pose of a test."""
    learned: tuple[DeclaredCourse, ...] = ()
    """Courses without a name, at most one for each axis."""

    def at(self, pose: str | None) -> Model:
        """Return the model at a named pose; it stays as it is where it names none.

        At one that is not among those it names, its joints are not known.
        """
        if pose is None or not self.poses:
            return self
        return replace(self, joints_deg=self.poses.get(pose))


ARM_PLACES = ("joint 1", "joint 2", "along the arm")
"""Where in the arm an effect may be declared to act: sizes in rad; growth of the links in 1."""


def on_dials(declared: DeclaredEffect, effect: Effect, model: Model) -> DeclaredEffect:
    """Return an effect with its sizes by axis at the pose of ``model``, itself where it has them.

    Raises `UsageError` where it acts in the arm and the pose's joints are not known.
    """
    places = [name for name in declared.axes if name in ARM_PLACES]
    if not places:
        return declared
    if model.arm is None or model.joints_deg is None:
        raise UsageError(
            f"effect {declared.name} acts in the arm ({', '.join(places)}), and the model does not "
            "say where its joints stand",
            remedy="give the joint_deg of the pose: [pose], or [pose.P1] and so on of a test"
            if not model.poses
            else "one table is of one pose: give its joint_deg in [pose] beside those of the test",
        )
    names, rows = effect.linear.names, [ARM_PLACES.index(place) for place in places]
    each = [declared.on_axis(place) for place in places]
    at = np.array([effect.linear.coefficients({n: float(one[n]) for n in names}) for one in each])
    x, y = model.arm.movements(model.joints_deg)
    moves = {"X": x, "Y": y}
    if "theta" in model.indicators and model.indicators["theta"].dimension is Dimension.ANGLE:
        moves["theta"] = np.array([math.degrees(1), math.degrees(1), 0.0])
    sizes: dict[str, dict[str, float]] = {name: {} for name in names}
    for axis in (one for one in model.indicators if one in moves):
        for name, size in effect.linear.sizes(moves[axis][rows] @ at).items():
            sizes[name][axis] = size
    kept: dict[str, Value] = {k: v for k, v in declared.parameters.items() if k not in sizes}
    return replace(declared, parameters={**sizes, **kept})
