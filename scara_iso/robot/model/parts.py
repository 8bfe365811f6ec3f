"""What a model is made of; lengths in mm, joint angles in degrees, inertias in kg m2."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from scara_iso.effects import OwnEffect
from scara_iso.quantities import Dimension
from scara_iso.robot.arm import Arm
from scara_iso.robot.two_inertia import Backlash, backlash

Value = float | str | Mapping[str, float]


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
    """What the maker rates the robot for, to which a test's percentages refer; None: not stated."""

    load_kg: float | None = None
    """Rated load; None where not stated."""
    velocity_mm_s: float | None = None
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


@dataclass(frozen=True, slots=True)
class Model:
    """A robot at its poses, seen by indicators, with the effects that are known."""

    robot: str
    indicators: Mapping[str, Indicator]
    arm: Arm | None = None
    joints_deg: tuple[float, float] | None = None
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
    poses: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Joints 1 and 2 at each named pose of a test."""

    def at(self, pose: str | None) -> Model:
        """Return the model at a named pose; it stays as it is where it names none.

        At one that is not among those it names, its joints are not known.
        """
        if pose is None or not self.poses:
            return self
        return replace(self, joints_deg=self.poses.get(pose))
