"""What a model is made of: arm, poses, indicators, gears, and the effects that it declares.

Lengths in mm, joint angles in degrees, inertias in kg m2. A robot's model is a file, MODEL.toml
(`model_file`); what it says that a dial will read is in `prediction`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.files import read_toml
from scara_iso.base.published import ALWAYS
from scara_iso.base.quantities import Dimension
from scara_iso.base.toml_keys import KeyFaults, number_at, only, pair
from scara_iso.effects import Effect, OwnEffect, find_effects, find_gear_effects, own_effects
from scara_iso.robot.arm import Arm, Elbow
from scara_iso.robot.two_inertia import Backlash, backlash
from scara_iso.run import FloatArray, IntArray

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
    learned: tuple[DeclaredCourse, ...] = ()
    """Courses without a name, at most one for each axis."""

    def at(self, pose: str | None) -> Model:
        """Return the model at a named pose; it stays as it is where it names none.

        At one that is not among those it names, its joints are not known.
        """
        if pose is None or not self.poses:
            return self
        return replace(self, joints_deg=self.poses.get(pose))


Joints = tuple[float, float]
"""Joints 1 and 2 in degrees."""

_KEYS = ("joint_deg", "x_mm", "y_mm", "elbow")


def poses_of(
    section: Mapping[str, Any], arm: Arm | None, faults: KeyFaults
) -> tuple[Joints | None, dict[str, Joints]]:
    """Return the joints of the single pose, None where it is not given, and of each named one.

    What is wrong goes to ``faults``.
    """
    named = {name: entry for name, entry in section.items() if _is_pose(name, entry)}
    own = {key: value for key, value in section.items() if key not in named}
    found = {name: _joints(entry, f"pose.{name}", arm, faults) for name, entry in named.items()}
    poses = {name: joints for name, joints in found.items() if joints is not None}
    return (_joints(own, "pose", arm, faults) if own else None), poses


def _is_pose(name: str, entry: object) -> bool:
    return isinstance(entry, dict) and name not in _KEYS


def _joints(
    pose: Mapping[str, Any], where: str, arm: Arm | None, faults: KeyFaults
) -> Joints | None:
    only(pose, set(_KEYS), where, faults)
    if pose.get("elbow", "right") not in ("left", "right"):
        faults.add(f"{where}.elbow", f"{repr(pose['elbow'])[:40]}: right or left")
    if "joint_deg" in pose:
        if len(pose) > 1:
            faults.add(where, "give either joint_deg, or x_mm and y_mm")
        return _within(pair(pose, "joint_deg", where, faults), where, arm, faults)
    x, y = (number_at(pose, key, where, faults) for key in ("x_mm", "y_mm"))
    if x is None or y is None:
        faults.add(where, "give joint_deg, or x_mm and y_mm")
        return None
    if arm is None:
        faults.add(where, "x_mm and y_mm need the link lengths of robot")
        return None
    elbow = Elbow.LEFT if pose.get("elbow") == "left" else Elbow.RIGHT
    try:
        joints = arm.inverse([x, y], elbow=elbow)
    except UsageError as error:
        faults.add(where, error.what)
        return None
    return float(joints[0]), float(joints[1])


def _within(joints: Joints, where: str, arm: Arm | None, faults: KeyFaults) -> Joints:
    for k, over in enumerate([] if arm is None else arm.excess(joints).tolist(), 1):
        if over > 0:
            faults.add(f"{where}.joint_deg", f"joint {k} is {over:g} deg outside its limits")
    return joints


_KEY = "effect"


def read_effects(path: str | Path) -> tuple[OwnEffect, ...]:
    """Return the effects that a TOML file defines; docs/diagnosis.md gives its keys.

    Raises `NoInputError` for a file that cannot be read and `DataError` with every fault, each
    named by its key.
    """
    document = read_toml(path)
    faults = KeyFaults()
    only(document, {_KEY}, "file", faults)
    found = tuple(own_effects(document.get(_KEY, []), _KEY, _taken(), faults))
    if not document.get(_KEY):
        faults.add(_KEY, "missing: one [[effect]] for each, with name and formula")
    if faults:
        raise DataError(
            f"the effects cannot be read: {len(faults)} fault{'s' if len(faults) > 1 else ''}",
            where=str(path),
            remedy="give each [[effect]] a name, a formula and its parameters",
            faults=faults,
        )
    return found


def all_own(
    entries: object, given: Sequence[OwnEffect], faults: KeyFaults
) -> tuple[OwnEffect, ...]:
    """Return the effects ``given`` and those that the ``definition`` tables of a model define.

    One that stands in both must be the same.
    """
    defined = own_effects(entries, "definition", _taken(), faults)
    known: dict[str, OwnEffect] = {one.name: one for one in given}
    for one in defined:
        if one.name in known and dict(known[one.name].definition) != dict(one.definition):
            faults.add(f"definition {one.name}", "differs from the effect of that name beside it")
        known.setdefault(one.name, one)
    return tuple(known.values())


def _taken() -> set[str]:
    return {e.name for e in find_effects()} | {e.name for e in find_gear_effects()} | {"unknown"}


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
            remedy="give the joint_deg of the pose: [pose], or [pose.P1] and so on of a test",
        )
    names, rows = effect.linear.names, [ARM_PLACES.index(place) for place in places]
    each = [declared.on_axis(place) for place in places]
    at = [effect.linear.coefficients({n: float(one[n]) for n in names}) for one in each]
    sizes: dict[str, dict[str, float]] = {name: {} for name in names}
    for axis, moved in _movements(model, model.arm.movements(model.joints_deg)).items():
        for name, size in effect.linear.sizes(moved[rows] @ np.array(at)).items():
            sizes[name][axis] = size
    kept: dict[str, Value] = {k: v for k, v in declared.parameters.items() if k not in sizes}
    return replace(declared, parameters={**sizes, **kept})


def _movements(model: Model, plane: FloatArray) -> dict[str, FloatArray]:
    """Return how far each dial that the arm moves does so for unit sizes at `ARM_PLACES`."""
    turned = np.array([math.degrees(1), math.degrees(1), 0.0])
    every = {"X": plane[0], "Y": plane[1], "theta": turned}
    angle = model.indicators.get("theta", Indicator("")).dimension is Dimension.ANGLE
    return {a: every[a] for a in model.indicators if a in every and (a != "theta" or angle)}
