"""What test.toml states: of the whole, as a `WholeTest`, and of a part, as the head of its table.

Each key that is not known, or not of its kind, is a fault; a table may not state otherwise.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import asdict
from datetime import date
from pathlib import Path
from shlex import quote
from typing import Any, TypeVar, get_type_hints

from scara_iso.base.errors import DataError, NoInputError
from scara_iso.base.files import KeyFaults, is_file, read_toml, section
from scara_iso.base.quantities import Dimension
from scara_iso.iso9283 import DecisionRule, find_characteristics
from scara_iso.run import AXES, Run
from scara_iso.tables import stated_corrections
from scara_iso.testfolder.place import FILE
from scara_iso.testfolder.whole_test import (
    COUNTS,
    DISCARDED,
    DRIFT,
    POSE_NAME,
    PUSH,
    SECTIONS,
    SECTIONS_OF,
    Condition,
    DriftTest,
    Instrument,
    Part,
    PushTest,
    Reader,
    Struck,
    WholeTest,
    limit_of,
    reader_of,
    word_of,
)

EVERY_LENGTH = "every_length"
_Section = TypeVar("_Section")
_LIMITS = {"decision": word_of(*(rule.value for rule in DecisionRule))}
_KNOWN = sorted({*SECTIONS, *SECTIONS_OF, "drift", "limits", "push", "struck"})


def read_test(folder: Path) -> WholeTest:
    """Return what the test.toml of a folder says.

    Raises `NoInputError` where there is none and `DataError` with every fault, each named by its
    key.
    """
    path = folder / FILE
    if not is_file(path):
        raise NoInputError(
            f"is not the folder of a test: it has no {FILE}",
            where=str(folder),
            remedy=f"make it one: scara-iso test new {quote(str(folder))} `model=MODEL.toml`",
        )
    faults = KeyFaults()
    found = parse_test(read_toml(path), faults)
    _check_figures(found, faults)
    _refuse(faults, path, f"is not a test: {len(faults)} fault{'s' if len(faults) > 1 else ''}")
    return found


def read_instruments(path: Path) -> dict[str, Instrument]:
    """Return the sections ``[instrument.X]`` of a TOML file by axis, none where it has none.

    Raises as `read_test`.
    """
    faults = KeyFaults()
    found = _named(Instrument, read_toml(path), "instrument", faults)
    _check_instruments(found, faults)
    _refuse(faults, path, "[instrument] cannot be taken")
    return found


def _refuse(faults: KeyFaults, path: Path, what: str) -> None:
    if faults:
        raise DataError(what, where=str(path), remedy="correct these keys", faults=faults)


def parse_test(document: Mapping[str, Any], faults: KeyFaults) -> WholeTest:
    """Return what a document says; what is wrong with it goes to ``faults``."""
    for key in sorted(document.keys() - set(_KNOWN)):
        faults.add(key, f"no such section; known are {', '.join(_KNOWN)}")
    values: dict[str, Any] = {
        field: _build(kind, section(document, key, faults), key, faults)
        for key, (field, kind) in SECTIONS.items()
    }
    for key, (field, kind) in SECTIONS_OF.items():
        values[field] = _named(kind, document, key, faults)
    if "drift" in document:
        values["drift"] = _build(DriftTest, section(document, "drift", faults), "drift", faults)
    limits = _read(
        section(document, "limits", faults),
        lambda key: _LIMITS.get(key, limit_of),
        "limits",
        faults,
    )
    if "decision" in limits:
        values["decision"] = limits.pop("decision")
    test = WholeTest(
        **values,
        limits={"" if key == EVERY_LENGTH else key: one for key, one in limits.items()},
        pushes=dict(_pushes(document, faults)),
        struck=tuple(_struck(document.get("struck", []), faults)),
    )
    _check_together(test, faults)
    return test


def _build(
    kind: Callable[..., _Section], table: Mapping[str, Any], where: str, faults: KeyFaults
) -> _Section:
    """Return a section of its dataclass; keys that are wrong keep their defaults."""
    hints = get_type_hints(kind, include_extras=True)
    for key in (key for key in table if key not in hints):
        faults.add(f"{where}.{key}", f"no such key; known are {', '.join(hints)}")
    known = {key: value for key, value in table.items() if key in hints}
    return kind(**_read(known, lambda key: reader_of(hints[key]), where, faults))


def _read(
    table: Mapping[str, Any], reader: Callable[[str], Reader], where: str, faults: KeyFaults
) -> dict[str, Any]:
    """Return what the keys of a section hold; one that is wrong is left out."""
    values = {}
    for key, value in table.items():
        try:
            values[key] = reader(key)(value)
        except ValueError as error:
            faults.add(f"{where}.{key}", f"{repr(value)[:40]} is {error}")
    return values


def _named(
    kind: Callable[..., _Section], document: Mapping[str, Any], key: str, faults: KeyFaults
) -> dict[str, _Section]:
    found = {}
    table = section(document, key, faults)
    for name in table:
        where = f"{key}.{name}"
        if key == "instrument" and name not in AXES:
            faults.add(where, f"no such axis: {', '.join(AXES)}")
        elif not POSE_NAME.fullmatch(name):
            faults.add(where, "is named by letters and digits, such as P1")
        else:
            found[name] = _build(kind, section(table, name, faults), where, faults)
    return found


def _pushes(document: Mapping[str, Any], faults: KeyFaults) -> Iterator[tuple[str, PushTest]]:
    """Yield the push tests by the names of their parts: of ``[push]``, or of ``[push.joint_1]``."""
    table = section(document, PUSH, faults)
    if table and all(isinstance(value, dict) for key, value in table.items() if key != "limits"):
        found = _named(PushTest, document, PUSH, faults)
        yield from ((f"{PUSH}-{name}", one) for name, one in found.items())
    elif PUSH in document:
        yield PUSH, _build(PushTest, table, PUSH, faults)


def _struck(entries: object, faults: KeyFaults) -> Iterator[Struck]:
    if not isinstance(entries, list):
        faults.add("struck", "write each one as [[struck]]")
        return
    for number, entry in enumerate(entries, 1):
        where = f"struck {number}"
        if not isinstance(entry, dict) or {"recording", "reason"} - set(entry):
            faults.add(where, "give recording and reason")
        else:
            yield _build(Struck, {"recording": "", "reason": "", **entry}, where, faults)


def _check_together(test: WholeTest, faults: KeyFaults) -> None:
    if not test.poses:
        faults.add("pose", "missing: one section for each pose, such as [pose.P1]")
    for where, values in (("velocities", test.schedule.velocities), ("loads", test.schedule.loads)):
        if not values or len(set(values)) < len(values):
            faults.add(f"test.{where}", "give one or more, each once")
    _check_instruments(test.instruments, faults)
    if test.drift is not None and test.drift.pose not in test.poses:
        faults.add("drift.pose", f"no such pose: {', '.join(test.poses)}")
    if test.schedule.first_cycle == DISCARDED and test.schedule.cycles < 3:
        faults.add("test.cycles", "two or more have to count beside the first")


def _check_figures(test: WholeTest, faults: KeyFaults) -> None:
    """Add what no analysis of the test could use; an angle has the code of its own, ``AP_a``."""
    codes = (f"{one.CODE}{end}" for one in find_characteristics() for end in ("", "_a"))
    known = ["", *AXES, "XY", "XYZ", "XY_eq23", *codes]
    for name in (name for name in test.limits if name.partition(":")[0] not in known):
        faults.add(f"limits.{name}", f"no such figure; known are {', '.join(known[1:])}")
    if 0 in test.schedule.velocities:
        faults.add("test.velocities", "at 0 per cent no robot moves")


def _check_instruments(instruments: Mapping[str, Instrument], faults: KeyFaults) -> None:
    for axis, instrument in instruments.items():
        for said in instrument.corrects.faults(Dimension.LENGTH):  # of theta: as it is read
            faults.add(f"instrument.{axis}", said)


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
