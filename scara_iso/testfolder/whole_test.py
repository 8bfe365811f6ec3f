"""What a test is: robot, poses, velocities and loads, limits, instruments, people. Frozen.

One class for each section of a test.toml; the fields have the names of its keys, and their types
say what each has to be (`keys`).

What test.toml states of a part, as the head of its table says it, and whether a table agrees.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from datetime import date
from itertools import product
from typing import Annotated, Any

from scara_iso.iso9283 import CYCLES_RUN, CYCLES_USED, DecisionRule, Limit
from scara_iso.run import Correction, Run
from scara_iso.tables import stated_corrections
from scara_iso.testfolder import keys

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
    other_tests: str = ""
    """Name of a test beside the poses: ``drift``, ``push``, ``push-joint_1``."""

    @property
    def name(self) -> str:
        """``P3-v50-l100``, which its files are named by."""
        return self.other_tests or f"{self.pose}-{self.condition.name}"

    @property
    def is_push(self) -> bool:
        """Whether it is a table of forces, which is typed and not recorded."""
        return self.other_tests.startswith(PUSH)


@dataclass(frozen=True, slots=True)
class RobotTested:
    """What is tested; ``model`` is the path of its model file, from the folder."""

    name: str = ""
    serial_number: str = ""
    model: str = ""
    rated_payload_kg: keys.Positive | None = None
    rated_velocity_mm_s: keys.Positive | None = None


@dataclass(frozen=True, slots=True)
class Schedule:
    """What is measured, and how; velocities and loads in per cent of the rated ones."""

    characteristics: tuple[str, ...] = ()
    velocities: tuple[keys.Percent, ...] = (100.0,)
    loads: tuple[keys.Percent, ...] = (100.0,)
    cycles: int = CYCLES_RUN
    first_cycle: Annotated[str, keys.word_of(DISCARDED, COUNTS)] = DISCARDED
    dwell_s: keys.NotNegative | None = None
    stabilisation_time_s: keys.NotNegative | None = None
    approach: Annotated[str, keys.word_of(ONE_SIDE, BOTH_SIDES)] = ""
    warm_up_min: keys.NotNegative | None = None
    dial_zero: Annotated[str, keys.word_of("command")] = ""
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
    velocity: keys.Percent = 100.0
    load: keys.Percent = 100.0
    limits: keys.ByFigure = field(default_factory=dict)
    """By figure, such as dAP, in mm."""


@dataclass(frozen=True, slots=True)
class PushTest:
    """A joint pushed to and fro; ``arm_m`` from it to dial and force [m]."""

    arm_m: keys.Positive | None = None
    limits: keys.ByFigure = field(default_factory=dict)
    """By figure: lost_motion in arcmin of the joint, lost_motion_mm at the dial."""


@dataclass(frozen=True, slots=True)
class Cube:
    """Where the poses come from: the cube or box, its diagonal plane, the side of the elbow."""

    solid: str = ""
    size_mm: tuple[keys.Positive, ...] = ()
    plane: str = ""
    elbow: str = ""


@dataclass(frozen=True, slots=True)
class CommandPose:
    """One pose in the robot's base frame, and what the dials would read there, by axis."""

    x_mm: float | None = None
    y_mm: float | None = None
    z_mm: float | None = None
    theta_deg: float | None = None
    command: keys.ByAxis = field(default_factory=dict)

    @property
    def coordinates(self) -> str:
        """The pose in words, empty where it is not stated."""
        named = {name: getattr(self, name) for name in ("x_mm", "y_mm", "z_mm", "theta_deg")}
        stated = ((*name.split("_"), one) for name, one in named.items() if one is not None)
        return ", ".join(f"{name} {value:g} {unit}" for name, unit, value in stated)


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Temperature during the test, and within what it has to be."""

    temperature_C: float | None = None  # noqa: N815 - the unit as the columns have it
    temperature_limits_C: keys.Range = ()  # noqa: N815
    humidity_percent: keys.Percent | None = None


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
    uncertainty: keys.Positive | None = None
    correction: keys.Points = ()
    correction_zero: float | None = None
    correction_uncertainty: keys.Positive | None = None
    alignment_deg: keys.NotNegative | None = None
    alignment_u_deg: keys.Positive | None = None

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
    limits: Mapping[str, Limit] = field(default_factory=dict)
    """By figure, in mm or degrees; the empty name holds for every length."""
    instruments: Mapping[str, Instrument] = field(default_factory=dict)
    """By axis."""
    people: People = People()
    surroundings: Surroundings = Surroundings()
    drift: DriftTest | None = None
    pushes: Mapping[str, PushTest] = field(default_factory=dict)
    """By the name of the part: ``push``, or ``push-joint_1`` of several."""
    struck: tuple[Struck, ...] = ()

    @property
    def approaches_by_turns(self) -> bool:
        """Whether the poses are approached from both sides."""
        return self.schedule.approach == BOTH_SIDES

    def conditions(self) -> list[Condition]:
        """Return velocities and loads in the order given, the velocities first."""
        pairs = product(self.schedule.loads, self.schedule.velocities)
        return [Condition(velocity, load) for load, velocity in pairs]

    def visits_of(self, part: Part) -> int:
        """Return how many cycles of a part are planned: of a drift test, its visits."""
        if part.other_tests and self.drift is not None:
            return self.drift.blocks * self.drift.visits
        return self.schedule.cycles

    def parts(self) -> Iterator[Part]:
        """Yield what is to be recorded, in order: all poses of a condition, then the next one.

        The tests beside the poses come last; a push test is at rest and carries no load.
        """
        for condition in self.conditions():
            yield from (Part(pose, condition) for pose in self.poses)
        if (drift := self.drift) is not None:
            yield Part(drift.pose, Condition(drift.velocity, drift.load), DRIFT)
        yield from (Part("", Condition(0.0, 0.0), name) for name in self.pushes)


SECTIONS: Mapping[str, tuple[str, Callable[..., Any]]] = {
    "robot": ("robot", RobotTested),
    "test": ("schedule", Schedule),
    "cube": ("cube", Cube),
    "environment": ("surroundings", Surroundings),
    "people": ("people", People),
}
"""Field and class of each section of a test.toml."""
SECTIONS_OF: Mapping[str, tuple[str, Callable[..., Any]]] = {
    "pose": ("poses", CommandPose),
    "instrument": ("instruments", Instrument),
}
"""Likewise where it holds a section for each pose or axis."""
NOT_STATED = "not stated"
_SAME_PERCENT = 1.0
"""Of the rated one: a speed or a load that a person rounds is still the planned one."""


def metadata_of(part: Part, test: WholeTest, axes: Collection[str]) -> dict[str, str]:
    """Return the ``key: value`` lines of a part recorded on these axes."""
    found = dict(_lines(part, test))
    found |= lines_of(test.instruments, axes)
    commands = {axis: command_of(part, test, axis) for axis in axes}
    found |= {f"command_{axis}": _plain(v) for axis, v in commands.items() if v is not None}
    return {key: text for key, text in found.items() if text}


def lines_of(instruments: Mapping[str, Instrument], axes: Collection[str]) -> dict[str, str]:
    """Return the ``key: value`` lines of the instruments of these axes."""
    used = {axis: instruments[axis] for axis in axes if axis in instruments}
    return {key: text for key, text in _instruments(used) if text}


def command_of(part: Part, test: WholeTest, axis: str) -> float | None:
    """Return what a dial would read at the command pose: 0 where it was zeroed there."""
    zeroed = 0.0 if test.schedule.dial_zero else None
    return test.poses[part.pose].command.get(axis, zeroed)


def why_not_of(run: Run, part: Part, test: WholeTest) -> list[str]:
    """Return what a table's head states otherwise than the test: it is of another part or robot."""
    wanted = {
        "part": part.name,
        "pose": part.pose,
        "robot": test.robot.name,
        "serial_number": test.robot.serial_number,
    }
    labels = [label for label, _ in run.rows_by_pose() if label is not None]
    faults = [
        f"{key} is {run.metadata[key]!r}, and the test says {text!r}"
        for key, text in wanted.items()
        if text and run.metadata.get(key, text).strip() != text
    ]
    faults += _other_condition(run, part.condition, test)
    if labels and labels != [part.pose]:
        faults.append(f"its poses are {', '.join(labels[:5])}, and it is of {part.pose}")
    return faults


def _other_condition(run: Run, condition: Condition, test: WholeTest) -> Iterator[str]:
    """Yield velocity or load where a table's head states another share of the rated one."""
    robot = test.robot
    for key, wanted, rated, unit in (
        ("velocity", condition.velocity, robot.rated_velocity_mm_s, "mm/s"),
        ("payload", condition.load, robot.rated_payload_kg, "kg"),
    ):
        text = run.metadata.get(key, "").strip()
        share = _share(text, rated, unit)
        if share is not None and abs(share - wanted) > _SAME_PERCENT:
            yield f"{key} is {text!r}, and the part is at {wanted:g} % of the rated one"


def _share(text: str, rated: float | None, unit: str) -> float | None:
    """Return per cent of the rated one; None where a text states neither that nor a size."""
    if found := re.search(r"([0-9]+(?:\.[0-9]+)?) ?%", text):
        return float(found[1])
    found = re.fullmatch(rf"([0-9]+(?:\.[0-9]+)?) ?{re.escape(unit)}", text)
    return 100 * float(found[1]) / rated if found and rated else None


def other_instruments(own: Mapping[str, str], of_test: Mapping[str, str]) -> str:
    """Return what a table's head states of its instruments otherwise than the test, or nothing."""
    return "; ".join(
        f"{key} is {own[key].strip()!r}, and the test says {of_test[key]!r}"
        for key in ("instrument", "indicator_serial_number", "calibration_certificate")
        if key in own and key in of_test and own[key].strip() != of_test[key]
    )


def _lines(part: Part, test: WholeTest) -> Iterator[tuple[str, str]]:
    robot, schedule, around = test.robot, test.schedule, test.surroundings
    yield "robot", robot.name
    yield "serial_number", robot.serial_number
    yield "part", part.name
    yield "pose", part.pose
    yield "commanded_pose", test.poses[part.pose].coordinates
    for key, percent, rated, unit in (
        ("velocity", part.condition.velocity, robot.rated_velocity_mm_s, "mm/s"),
        ("payload", part.condition.load, robot.rated_payload_kg, "kg"),
    ):
        share = f"{percent:g} % of rated"
        size = "" if rated is None else _in_words(percent * rated / 100, unit)
        yield key, f"{size} ({share})" if size else share
        yield f"rated_{key}", _in_words(rated, unit) or NOT_STATED
    yield "dwell", _in_words(schedule.dwell_s, "s")
    yield "stabilisation_time", _in_words(schedule.stabilisation_time_s, "s")
    yield "approached_from", schedule.approach or NOT_STATED
    yield "dial_zero", schedule.dial_zero
    yield "date", _day(schedule.date)
    if test.drift is not None and part.other_tests:
        yield "test", DRIFT
        yield "visits_per_block", str(test.drift.visits)
    else:
        yield "warm_up", _in_words(schedule.warm_up_min, "min") or NOT_STATED
        if schedule.first_cycle == COUNTS:
            yield "first_cycle", COUNTS
    yield "temperature", _in_words(around.temperature_C, "C")
    if limits := around.temperature_limits_C:
        yield "temperature_limits", f"{limits[0]:g} .. {limits[1]:g} C"
    yield "humidity", _in_words(around.humidity_percent, "%")
    yield from asdict(test.people).items()


def _instruments(used: dict[str, Instrument]) -> Iterator[tuple[str, str]]:
    """Yield what the certificates state: the earliest due, the latest calibration."""

    def each(key: str) -> str:
        said = {axis: getattr(one, key) for axis, one in used.items() if getattr(one, key)}
        return ", ".join(f"{axis} {text}" for axis, text in said.items())

    yield "instrument", each("name")
    yield "indicator_serial_number", each("serial_number")
    yield "calibration_certificate", each("certificate")
    done = [one.calibration_date for one in used.values() if one.calibration_date]
    due = [one.calibration_due for one in used.values() if one.calibration_due]
    yield "calibration_date", _day(max(done, default=None))
    yield "calibration_due", _day(min(due, default=None))
    for axis, one in used.items():
        if one.uncertainty is not None:
            yield f"indicator_uncertainty_{axis}", _plain(one.uncertainty)
        yield from stated_corrections(one.corrects, axis)


def _in_words(value: float | None, unit: str) -> str:
    return "" if value is None else f"{_plain(value)} {unit}"


def _plain(value: float) -> str:
    """Return a number without exponent, of at most 12 decimals."""
    return f"{value:.12f}".rstrip("0").rstrip(".")


def _day(day: date | None) -> str:
    return "" if day is None else day.isoformat()
