"""test.toml to a `WholeTest`; each key that is not known, or not of its kind, is a fault.

What each key of a test.toml has to be, and how it is read.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields
from datetime import date, datetime
from pathlib import Path
from typing import Any, TypeVar

from scara_iso.base.errors import DataError, NoInputError
from scara_iso.base.files import is_file, read_toml
from scara_iso.base.quantities import Dimension, is_size
from scara_iso.base.toml_keys import KeyFaults, is_number, section
from scara_iso.iso9283 import DecisionRule, Limit
from scara_iso.run import AXES
from scara_iso.testfolder.place import FILE
from scara_iso.testfolder.whole_test import (
    BOTH_SIDES,
    COUNTS,
    DISCARDED,
    ONE_SIDE,
    PUSH,
    CommandPose,
    Cube,
    DriftTest,
    Instrument,
    People,
    PushTest,
    RobotTested,
    Schedule,
    Struck,
    Surroundings,
    WholeTest,
)

_LONGEST = 1000
_LARGEST = 1e9
_MOST_CYCLES = 10_000


def _text(value: object) -> str:
    if not isinstance(value, str) or len(value) > _LONGEST or not value.isprintable():
        raise ValueError("not a line of text")
    return value.strip()


def _number(value: object) -> float:
    if not is_number(value):
        raise ValueError("no finite number")
    return float(value)  # type: ignore[arg-type]


def _positive(value: object) -> float:
    if not is_number(value) or not 0 < float(value) < _LARGEST:  # type: ignore[arg-type]
        raise ValueError("not a number above zero")
    return float(value)  # type: ignore[arg-type]


def _not_negative(value: object) -> float:
    if not is_number(value) or not 0 <= float(value) < _LARGEST:  # type: ignore[arg-type]
        raise ValueError("not a number of zero or more")
    return float(value)  # type: ignore[arg-type]


def _whole(value: object) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 2 <= value <= _MOST_CYCLES:
        raise ValueError(f"not a whole number from 2 to {_MOST_CYCLES}")
    return value


def _several(kind: Callable[[object], Any]) -> Callable[[object], tuple[Any, ...]]:
    def read(value: object) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise ValueError("no list")
        return tuple(kind(one) for one in value)

    return read


def _percent(value: object) -> float:
    if not is_number(value) or not 0 <= float(value) <= 100:  # type: ignore[arg-type]
        raise ValueError("not from 0 to 100")
    return float(value)  # type: ignore[arg-type]


def _limits_of_temperature(value: object) -> tuple[float, ...]:
    ends = _several(_number)(value)
    if len(ends) != 2 or ends[0] > ends[1]:
        raise ValueError("not a lowest and a highest temperature")
    return ends


def _one_of(*words: str) -> Callable[[object], str]:
    def read(value: object) -> str:
        if value not in words:
            raise ValueError(f"none of {', '.join(map(repr, words))}")
        return str(value)

    return read


def _day(value: object) -> date:
    if isinstance(value, str):
        try:
            value = date.fromisoformat(value)
        except ValueError:
            raise ValueError("not a date such as 2026-05-12") from None
    if isinstance(value, datetime):
        return value.date()
    if not isinstance(value, date):
        raise ValueError("not a date such as 2026-05-12")
    return value


def _points(value: object) -> tuple[tuple[float, ...], ...]:
    pairs = _several(_several(_number))(value)
    if any(len(pair) != 2 for pair in pairs):
        raise ValueError("not pairs of nominal and error, such as [[0, 0], [2, 0.001]]")
    return pairs


def _by_figure(value: object) -> dict[str, Limit]:
    if not isinstance(value, dict):
        raise ValueError("not by figure, such as { dAP = 0.02 }")
    return {str(figure): _limit(one) for figure, one in value.items()}


def _limit(value: object) -> Limit:
    if not isinstance(value, list):
        return value if isinstance(value, str) and is_size(value) else _positive(value)
    ends = _several(_not_negative)(value)
    if len(ends) != 2 or ends[0] >= ends[1]:
        raise ValueError("not a smallest and a largest value, such as [0.20, 0.24]")
    return ends


def _by_axis(value: object) -> dict[str, float]:
    if not isinstance(value, dict) or set(value) - set(AXES):
        raise ValueError("not of axes, such as { X = 0.0 }")
    return {axis: _number(one) for axis, one in value.items()}


KINDS: Mapping[str, Callable[[Any], Any]] = {
    **dict.fromkeys(
        (
            "name",
            "serial_number",
            "model",
            "solid",
            "plane",
            "elbow",
            "certificate",
            "operator",
            "laboratory",
            "address",
            "location",
            "customer",
            "authorized_by",
            "report_number",
            "recording",
            "reason",
            "pose",
        ),
        _text,
    ),
    **dict.fromkeys(
        (
            "rated_payload_kg",
            "rated_velocity_mm_s",
            "uncertainty",
            "arm_m",
            "correction_uncertainty",
            "alignment_u_deg",
        ),
        _positive,
    ),
    **dict.fromkeys(
        ("dwell_s", "stabilisation_time_s", "warm_up_min", "alignment_deg"), _not_negative
    ),
    **dict.fromkeys(
        ("x_mm", "y_mm", "z_mm", "theta_deg", "temperature_C", "correction_zero"), _number
    ),
    **dict.fromkeys(("calibration_date", "calibration_due", "date"), _day),
    "size_mm": _several(_positive),
    "characteristics": _several(_text),
    "velocities": _several(_percent),
    "loads": _several(_percent),
    **dict.fromkeys(("humidity_percent", "velocity", "load"), _percent),
    **dict.fromkeys(("cycles", "blocks", "visits"), _whole),
    "limits": _by_figure,
    "correction": _points,
    "first_cycle": _one_of(DISCARDED, COUNTS),
    "approach": _one_of(ONE_SIDE, BOTH_SIDES),
    "dial_zero": _one_of("command"),
    "temperature_limits_C": _limits_of_temperature,
    "command": _by_axis,
}
"""What each key has to be, in whichever section."""


EVERY_LENGTH = "every_length"
_Section = TypeVar("_Section")
POSE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,20}")
_SECTIONS = {
    "robot",
    "test",
    "cube",
    "pose",
    "limits",
    "instrument",
    "people",
    "environment",
    "struck",
    "drift",
    "push",
}


def read_test(folder: Path) -> WholeTest:
    """Return what the test.toml of a folder says.

    Raises `NoInputError` where there is none and `DataError` with every fault, each named by its
    key.
    """
    path = folder / FILE
    if not is_file(path):
        raise NoInputError(
            f"is no folder of a test: it has no {FILE}",
            where=str(folder),
            remedy=f"make it one: scara-iso test new {folder} `model=MODEL.toml`",
        )
    faults = KeyFaults()
    found = parse_test(read_toml(path, "docs/test-folder.md"), faults)
    if faults:
        raise DataError(
            f"is no test: {len(faults)} fault{'s' if len(faults) > 1 else ''}",
            where=str(path),
            remedy="correct these keys; docs/test-folder.md lists them all",
            faults=faults,
        )
    return found


def read_instruments(path: Path) -> dict[str, Instrument]:
    """Return the sections ``[instrument.X]`` of a TOML file by axis, none where it has none.

    Raises as `read_test`.
    """
    faults = KeyFaults()
    found = _named(Instrument, read_toml(path, "docs/test-folder.md"), "instrument", faults)
    _check_instruments(found, faults)
    if faults:
        raise DataError(
            "[instrument] cannot be taken",
            where=str(path),
            faults=faults,
            remedy="correct these keys; docs/test-folder.md lists them all",
        )
    return found


def parse_test(document: Mapping[str, Any], faults: KeyFaults) -> WholeTest:
    """Return what a document says; what is wrong with it goes to ``faults``."""
    for key in document:
        if key not in _SECTIONS:
            faults.add(key, f"no such section; known are {', '.join(sorted(_SECTIONS))}")
    limits = section(document, "limits", faults)
    test = WholeTest(
        robot=_build(RobotTested, section(document, "robot", faults), "robot", faults),
        schedule=_build(Schedule, section(document, "test", faults), "test", faults),
        cube=_build(Cube, section(document, "cube", faults), "cube", faults),
        poses=_named(CommandPose, document, "pose", faults),
        limits=_limits({k: v for k, v in limits.items() if k != "decision"}, faults),
        **_decision(limits, faults),
        instruments=_named(Instrument, document, "instrument", faults),
        people=_build(People, section(document, "people", faults), "people", faults),
        surroundings=_build(
            Surroundings, section(document, "environment", faults), "environment", faults
        ),
        drift=_build(DriftTest, section(document, "drift", faults), "drift", faults)
        if "drift" in document
        else None,
        pushes=dict(_pushes(document, faults)),
        struck=_struck(document.get("struck", []), faults),
    )
    _check_together(test, faults)
    return test


def _build(
    kind: Callable[..., _Section], table: Mapping[str, Any], where: str, faults: KeyFaults
) -> _Section:
    """Return a section of its dataclass; keys that are wrong keep their defaults."""
    known = [one.name for one in fields(kind)]  # type: ignore[arg-type]
    values = {}
    for key, value in table.items():
        if key not in known:
            faults.add(f"{where}.{key}", f"no such key; known are {', '.join(known)}")
            continue
        try:
            values[key] = KINDS[key](value)
        except ValueError as error:
            faults.add(f"{where}.{key}", f"{repr(value)[:40]} is {error}")
    return kind(**values)


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


def _limits(table: Mapping[str, Any], faults: KeyFaults) -> dict[str, Limit]:
    found: dict[str, Limit] = {}
    for key, value in table.items():
        try:
            found["" if key == EVERY_LENGTH else key] = _limit(value)
        except ValueError:
            faults.add(f"limits.{key}", f"{repr(value)[:40]} is no length above zero")
    return found


def _decision(table: Mapping[str, Any], faults: KeyFaults) -> dict[str, str]:
    rule = table.get("decision", DecisionRule.INTERVAL.value)
    words = [one.value for one in DecisionRule]
    if rule not in words:
        faults.add("limits.decision", f"{repr(rule)[:40]} is none of {', '.join(words)}")
        return {}
    return {"decision": rule}


def _struck(entries: object, faults: KeyFaults) -> tuple[Struck, ...]:
    if not isinstance(entries, list):
        faults.add("struck", "write each one as [[struck]]")
        return ()
    found = []
    for number, entry in enumerate(entries, 1):
        where = f"struck {number}"
        if not isinstance(entry, dict) or {"recording", "reason"} - set(entry):
            faults.add(where, "give recording and reason")
            continue
        found.append(_build(Struck, {"recording": "", "reason": "", **entry}, where, faults))
    return tuple(found)


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


def _check_instruments(instruments: Mapping[str, Instrument], faults: KeyFaults) -> None:
    for axis, instrument in instruments.items():
        for said in instrument.corrects.faults(Dimension.LENGTH):  # of theta: as it is read
            faults.add(f"instrument.{axis}", said)
