"""What a test is: robot, poses, velocities and loads, limits, instruments, people. Frozen.

One class for each section of a test.toml; the fields have the names of its keys.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from datetime import date
from itertools import product

from scara_iso.dial import Correction
from scara_iso.iso9283 import CYCLES_RUN, CYCLES_USED, DecisionRule, Limit

DISCARDED, COUNTS = "discarded", "counts"
DRIFT, PUSH = "drift", "push"
"""Names of the tests beside the poses, and how those of several push tests begin."""
ONE_SIDE, BOTH_SIDES = "one side", "both sides"


@dataclass(frozen=True, slots=True, order=True)
class Condition:
    """A velocity and a load, in per cent of the rated ones."""

    velocity: float
    load: float

    @property
    def name(self) -> str:
        """``v50-l100``."""
        return f"v{self.velocity:g}-l{self.load:g}"

    def __str__(self) -> str:
        return f"{self.velocity:g} % velocity, {self.load:g} % load"


@dataclass(frozen=True, slots=True)
class Part:
    """What one recording holds: a pose under a condition, or a test beside the poses."""

    pose: str
    """Empty for a push test."""
    condition: Condition
    beside: str = ""
    """Name of a test beside the poses: ``drift``, ``push``, ``push-joint_1``."""

    @property
    def name(self) -> str:
        """``P3-v50-l100``, which its files are named by."""
        return self.beside or f"{self.pose}-{self.condition.name}"

    @property
    def is_push(self) -> bool:
        """Whether it is a table of forces, which is typed and not recorded."""
        return self.beside.startswith(PUSH)


@dataclass(frozen=True, slots=True)
class RobotTested:
    """What is tested; ``model`` is the path of its model file, from the folder."""

    name: str = ""
    serial_number: str = ""
    model: str = ""
    rated_payload_kg: float | None = None
    rated_velocity_mm_s: float | None = None


@dataclass(frozen=True, slots=True)
class Schedule:
    """What is measured, and how; velocities and loads in per cent of the rated ones."""

    characteristics: tuple[str, ...] = ()
    velocities: tuple[float, ...] = (100.0,)
    loads: tuple[float, ...] = (100.0,)
    cycles: int = CYCLES_RUN
    first_cycle: str = DISCARDED
    dwell_s: float | None = None
    stabilisation_time_s: float | None = None
    approach: str = ""
    warm_up_min: float | None = None
    dial_zero: str = ""
    date: date | None = None

    @property
    def cycles_run(self) -> int | None:
        """The number for `iso9283.used_cycles`; None where the cycle rule knows it."""
        usual = CYCLES_USED if self.first_cycle == COUNTS else CYCLES_RUN
        return None if self.cycles == usual else self.cycles


@dataclass(frozen=True, slots=True)
class DriftTest:
    """The drift test (7.6): blocks of visits of a pose over hours, from a cold start."""

    pose: str = "P1"
    blocks: int = 33
    visits: int = 10
    velocity: float = 100.0
    load: float = 100.0
    limits: Mapping[str, float] = field(default_factory=dict)
    """By figure, such as dAP, in mm."""

    @property
    def part(self) -> Part:
        """What its recording is called and holds."""
        return Part(self.pose, Condition(self.velocity, self.load), DRIFT)


@dataclass(frozen=True, slots=True)
class PushTest:
    """A joint pushed to and fro; ``arm_m`` from it to dial and force [m]."""

    arm_m: float | None = None
    limits: Mapping[str, Limit] = field(default_factory=dict)
    """By figure: lost_motion in arcmin of the joint, lost_motion_mm at the dial."""


@dataclass(frozen=True, slots=True)
class Cube:
    """Where the poses come from: the cube or box, its diagonal plane, the side of the elbow."""

    solid: str = ""
    size_mm: tuple[float, ...] = ()
    plane: str = ""
    elbow: str = ""


@dataclass(frozen=True, slots=True)
class CommandPose:
    """One pose in the robot's base frame, and what the dials would read there, by axis."""

    x_mm: float | None = None
    y_mm: float | None = None
    z_mm: float | None = None
    theta_deg: float | None = None
    command: Mapping[str, float] = field(default_factory=dict)

    @property
    def coordinates(self) -> str:
        """The pose in words, empty where it is not stated."""
        named = (
            ("x", self.x_mm, "mm"),
            ("y", self.y_mm, "mm"),
            ("z", self.z_mm, "mm"),
            ("theta", self.theta_deg, "deg"),
        )
        return ", ".join(
            f"{name} {value:g} {unit}" for name, value, unit in named if value is not None
        )


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Temperature during the test, and within what it has to be."""

    temperature_C: float | None = None  # noqa: N815 - the unit as the columns have it
    temperature_limits_C: tuple[float, ...] = ()  # noqa: N815
    humidity_percent: float | None = None


@dataclass(frozen=True, slots=True)
class Instrument:
    """The indicator of an axis and its certificate; ``uncertainty`` is standard [mm or deg].

    ``correction`` is the curve, nominal and error, and ``correction_zero`` the place on it at which
    the display was zeroed; ``alignment_deg`` the angle between plunger and axis.
    """

    name: str = ""
    serial_number: str = ""
    certificate: str = ""
    calibration_date: date | None = None
    calibration_due: date | None = None
    uncertainty: float | None = None
    correction: tuple[tuple[float, float], ...] = ()
    correction_zero: float | None = None
    correction_uncertainty: float | None = None
    alignment_deg: float | None = None
    alignment_u_deg: float | None = None

    @property
    def corrects(self) -> Correction:
        """What of it is applied to readings."""
        return Correction(
            self.correction,
            self.correction_zero,
            self.correction_uncertainty,
            self.alignment_deg,
            self.alignment_u_deg,
        )


@dataclass(frozen=True, slots=True)
class People:
    """Who tests, where, for whom."""

    operator: str = ""
    laboratory: str = ""
    address: str = ""
    location: str = ""
    customer: str = ""
    authorized_by: str = ""
    report_number: str = ""


@dataclass(frozen=True, slots=True)
class Struck:
    """A recording that does not count, by its name without ending, and why."""

    recording: str
    """Its name."""
    reason: str
    """Why it does not count."""


@dataclass(frozen=True, slots=True)
class WholeTest:
    """A whole test.toml."""

    robot: RobotTested = RobotTested()
    schedule: Schedule = Schedule()
    cube: Cube = Cube()
    poses: Mapping[str, CommandPose] = field(default_factory=dict)
    decision: str = DecisionRule.INTERVAL.value
    limits: Mapping[str, float] = field(default_factory=dict)
    """By figure, in mm or degrees; the empty name holds for every length."""
    instruments: Mapping[str, Instrument] = field(default_factory=dict)
    """By axis."""
    people: People = People()
    surroundings: Surroundings = Surroundings()
    drift: DriftTest | None = None
    pushes: Mapping[str, PushTest] = field(default_factory=dict)
    """By the name of the part: ``push``, or ``push-joint_1`` of several."""
    struck: tuple[Struck, ...] = ()

    def conditions(self) -> list[Condition]:
        """Return velocities and loads in the order given, the velocities first."""
        pairs = product(self.schedule.loads, self.schedule.velocities)
        return [Condition(velocity, load) for load, velocity in pairs]

    def visits_of(self, part: Part) -> int:
        """Return how many cycles of a part are planned: of a drift test, its visits."""
        if part.beside and self.drift is not None:
            return self.drift.blocks * self.drift.visits
        return self.schedule.cycles

    def parts(self) -> Iterator[Part]:
        """Yield what is to be recorded, in order: all poses of a condition, then the next one.

        The tests beside the poses come last; a push test is at rest and carries no load.
        """
        for condition in self.conditions():
            yield from (Part(pose, condition) for pose in self.poses)
        if self.drift is not None:
            yield self.drift.part
        yield from (Part("", Condition(0.0, 0.0), name) for name in self.pushes)
