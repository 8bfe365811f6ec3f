"""What test.toml states of a part, as the head of its table says it, and whether a table agrees."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from datetime import date

from scara_iso.acceptance.whole_test import (
    COUNTS,
    DRIFT,
    Condition,
    Instrument,
    Part,
    WholeTest,
)
from scara_iso.run import Run
from scara_iso.tables import stated_corrections

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
    yield from _rated(part.condition, test)
    yield "dwell", _said(schedule.dwell_s, "s")
    yield "stabilisation_time", _said(schedule.stabilisation_time_s, "s")
    yield "approached_from", schedule.approach or NOT_STATED
    yield "dial_zero", schedule.dial_zero
    yield "date", _day(schedule.date)
    if test.drift is not None and part.beside:
        yield "test", DRIFT
        yield "visits_per_block", str(test.drift.visits)
    else:
        yield "warm_up", _said(schedule.warm_up_min, "min") or NOT_STATED
        if schedule.first_cycle == COUNTS:
            yield "first_cycle", COUNTS
    yield "temperature", _said(around.temperature_C, "C")
    if limits := around.temperature_limits_C:
        yield "temperature_limits", f"{limits[0]:g} .. {limits[1]:g} C"
    yield "humidity", _said(around.humidity_percent, "%")
    people = test.people
    for key in (
        "operator",
        "laboratory",
        "address",
        "location",
        "customer",
        "authorized_by",
        "report_number",
    ):
        yield key, getattr(people, key)


def _rated(condition: Condition, test: WholeTest) -> Iterator[tuple[str, str]]:
    """Yield velocity and load, in their units where the rated ones are stated."""
    velocity, load = test.robot.rated_velocity_mm_s, test.robot.rated_payload_kg
    yield "velocity", _of_rated(condition.velocity, velocity, "mm/s")
    yield "rated_velocity", _said(velocity, "mm/s") or NOT_STATED
    yield "payload", _of_rated(condition.load, load, "kg")
    yield "rated_payload", _said(load, "kg") or NOT_STATED


def _of_rated(percent: float, rated: float | None, unit: str) -> str:
    share = f"{percent:g} % of rated"
    return share if rated is None else f"{_plain(percent * rated / 100)} {unit} ({share})"


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


def _said(value: float | None, unit: str) -> str:
    return "" if value is None else f"{_plain(value)} {unit}"


def _plain(value: float) -> str:
    """Return a number without exponent, of at most 12 decimals."""
    return f"{value:.12f}".rstrip("0").rstrip(".")


def _day(day: date | None) -> str:
    return "" if day is None else day.isoformat()
