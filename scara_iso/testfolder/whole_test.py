"""What a test is: robot, poses, velocities and loads, limits, instruments, people. Frozen.

One class for each section of a test.toml; the fields have the names of its keys, and their types
say what each has to be.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import date, datetime
from itertools import product
from typing import Annotated, Any, TypeAlias, get_args, get_origin

from scara_iso.base.files import is_number
from scara_iso.base.quantities import is_size
from scara_iso.iso9283 import CYCLES_RUN, CYCLES_USED, DecisionRule, Limit
from scara_iso.run import AXES, Correction

Reader: TypeAlias = Callable[[Any], Any]
"""Returns a value as the field holds it; raises `ValueError` that says what it is not."""

POSE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,20}")
_LONGEST = 1000
_LARGEST = 1e9
_MOST_CYCLES = 10_000


def _checked(
    what: str, is_right: Callable[[Any], bool], read: Reader = lambda value: value
) -> Reader:
    def reader(value: Any) -> Any:
        if not is_right(value):
            raise ValueError(what)
        return read(value)

    return reader


def _number(what: str, is_right: Callable[[float], bool] = lambda _: True) -> Reader:
    return _checked(what, lambda value: is_number(value) and is_right(float(value)), float)


def _several(kind: Reader) -> Reader:
    return _checked(
        "no list", lambda value: isinstance(value, list), lambda value: tuple(map(kind, value))
    )


def _two(kind: Reader, what: str, is_right: Callable[[float, float], bool]) -> Reader:
    read = _checked(what, lambda ends: len(ends) == 2 and is_right(*ends))
    return lambda value: read(_several(kind)(value))


def word_of(*words: str) -> Reader:
    """Return the reader of one of some words."""
    return _checked(f"none of {', '.join(map(repr, words))}", words.__contains__)


def _day(value: object) -> date:
    if isinstance(value, datetime):
        return value.date()
    if isinstance(value, date):
        return value
    with suppress(ValueError):
        if isinstance(value, str):
            return date.fromisoformat(value)
    raise ValueError("not a date such as 2026-05-12")


_finite = _number("no finite number")
_positive = _number("not a number above zero", lambda size: 0 < size < _LARGEST)
_not_negative = _number("not a number of zero or more", lambda size: 0 <= size < _LARGEST)
_least_and_most = _two(
    _not_negative,
    "not a smallest and a largest value, such as [0.20, 0.24]",
    lambda least, most: least < most,
)
_by_axis = _checked(
    "not of axes, such as { X = 0.0 }",
    lambda value: isinstance(value, dict) and not set(value) - set(AXES),
    lambda value: {axis: _finite(one) for axis, one in value.items()},
)
_by_figure = _checked(
    "not by figure, such as { dAP = 0.02 }",
    lambda value: isinstance(value, dict),
    lambda value: {str(figure): limit_of(one) for figure, one in value.items()},
)
_pair = _two(
    _finite, "not pairs of nominal and error, such as [[0, 0], [2, 0.001]]", lambda *_: True
)


def limit_of(value: object) -> Limit:
    """Return a limit: a number or a text with a unit, or the smallest and the largest value."""
    if isinstance(value, str) and is_size(value):
        return value
    limit: Limit = (_least_and_most if isinstance(value, list) else _positive)(value)
    return limit


Positive: TypeAlias = Annotated[float, _positive]
NotNegative: TypeAlias = Annotated[float, _not_negative]
Percent: TypeAlias = Annotated[float, _number("not from 0 to 100", lambda part: 0 <= part <= 100)]
Range: TypeAlias = Annotated[
    tuple[float, ...],
    _two(_finite, "not a lowest and a highest temperature", lambda low, high: low <= high),
]
Points: TypeAlias = Annotated[tuple[tuple[float, float], ...], _several(_pair)]
ByFigure: TypeAlias = Annotated[Mapping[str, Limit], _by_figure]
ByAxis: TypeAlias = Annotated[Mapping[str, float], _by_axis]

_OF_TYPE: Mapping[Any, Reader] = {
    str: _checked(
        "not a line of text",
        lambda text: isinstance(text, str) and len(text) <= _LONGEST and text.isprintable(),
        str.strip,
    ),
    int: _checked(
        f"not a whole number from 2 to {_MOST_CYCLES}",
        lambda count: isinstance(count, int) and 2 <= count <= _MOST_CYCLES,
    ),
    float: _finite,
    date: _day,
}


def reader_of(hint: Any) -> Reader:
    """Return what reads a field of a type: as it is annotated, else a text, a number, a day."""
    types = get_args(hint)
    if get_origin(hint) is Annotated:
        reader: Reader = types[1]
        return reader
    if get_origin(hint) is tuple:
        return _several(reader_of(types[0]))
    return reader_of(types[0]) if types else _OF_TYPE[hint]


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
    rated_payload_kg: Positive | None = None
    rated_velocity_mm_s: Positive | None = None


@dataclass(frozen=True, slots=True)
class Schedule:
    """What is measured, and how; velocities and loads in per cent of the rated ones."""

    characteristics: tuple[str, ...] = ()
    velocities: tuple[Percent, ...] = (100.0,)
    loads: tuple[Percent, ...] = (100.0,)
    cycles: int = CYCLES_RUN
    first_cycle: Annotated[str, word_of(DISCARDED, COUNTS)] = DISCARDED
    dwell_s: NotNegative | None = None
    stabilisation_time_s: NotNegative | None = None
    approach: Annotated[str, word_of(ONE_SIDE, BOTH_SIDES)] = ""
    warm_up_min: NotNegative | None = None
    dial_zero: Annotated[str, word_of("command")] = ""
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
    velocity: Percent = 100.0
    load: Percent = 100.0
    limits: ByFigure = field(default_factory=dict)
    """By figure, such as dAP, in mm."""


@dataclass(frozen=True, slots=True)
class PushTest:
    """A joint pushed to and fro; ``arm_m`` from it to dial and force [m]."""

    arm_m: Positive | None = None
    limits: ByFigure = field(default_factory=dict)
    """By figure: lost_motion in arcmin of the joint, lost_motion_mm at the dial."""


@dataclass(frozen=True, slots=True)
class Cube:
    """Where the poses come from: the cube or box, its diagonal plane, the side of the elbow."""

    solid: str = ""
    size_mm: tuple[Positive, ...] = ()
    plane: str = ""
    elbow: str = ""


@dataclass(frozen=True, slots=True)
class CommandPose:
    """One pose in the robot's base frame, and what the dials would read there, by axis."""

    x_mm: float | None = None
    y_mm: float | None = None
    z_mm: float | None = None
    theta_deg: float | None = None
    command: ByAxis = field(default_factory=dict)

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
    temperature_limits_C: Range = ()  # noqa: N815
    humidity_percent: Percent | None = None


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
    uncertainty: Positive | None = None
    correction: Points = ()
    correction_zero: float | None = None
    correction_uncertainty: Positive | None = None
    alignment_deg: NotNegative | None = None
    alignment_u_deg: Positive | None = None

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
