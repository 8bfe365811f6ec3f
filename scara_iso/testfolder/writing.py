"""A `WholeTest` to test.toml, with a word on each section; a strike into the file that is there.

A plan of the poses and a model file, or the names of taught poses, to a `WholeTest`.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.items import Array

from scara_iso.base.errors import UsageError
from scara_iso.base.files import read_file, write_file
from scara_iso.iso9283 import PosePlan
from scara_iso.robot import read_model
from scara_iso.testfolder.place import FILE
from scara_iso.testfolder.statements import EVERY_LENGTH
from scara_iso.testfolder.whole_test import (
    POSE_NAME,
    PUSH,
    SECTIONS,
    SECTIONS_OF,
    CommandPose,
    Cube,
    RobotTested,
    Schedule,
    Struck,
    WholeTest,
)

CHARACTERISTICS = ("RP", "AP")
"""What thirty cycles at five poses give."""


def plan_test(
    plan: PosePlan,
    model_file: Path,
    *,
    folder: Path,
    velocities: Sequence[float],
    loads: Sequence[float],
) -> WholeTest:
    """Return the test of a plan; the model file is named as seen from ``folder``.

    Poses in the order P1 to P5. What the model does not rate is left open. Errors as `read_model`.
    """
    model = read_model(model_file)
    return WholeTest(
        robot=RobotTested(
            model.robot,
            model.serial_number,
            _relative(model_file, folder),
            model.rated.load_kg,
            model.rated.velocity_mm_s,
        ),
        schedule=Schedule(
            CHARACTERISTICS,
            tuple(velocities),
            tuple(loads),
            plan.conditions.cycles,
            dwell_s=plan.conditions.dwell_s,
        ),
        cube=Cube(plan.solid.value, plan.size_mm, plan.plane.value, plan.elbow.value),
        poses={
            pose.name: CommandPose(pose.x_mm, pose.y_mm, pose.z_mm, pose.theta_deg)
            for pose in plan.poses
        },
    )


def taught_test(
    poses: Sequence[str],
    *,
    velocities: Sequence[float],
    loads: Sequence[float],
    dwell_s: float,
) -> WholeTest:
    """Return the test of poses that are taught on the robot and known by their names alone.

    AP is not planned: no command pose is known. Raises `UsageError` for what is no pose's name.
    """
    wrong = [name for name in poses if not POSE_NAME.fullmatch(name)]
    if wrong or not poses or len({name.casefold() for name in poses}) < len(poses):
        raise UsageError(
            f"{wrong[0]!r} is not a name of a pose" if wrong else "each pose is named once",
            remedy="give letters and digits: `poses=P1,P2,P3,P4,P5`",
        )
    schedule = Schedule(CHARACTERISTICS[:1], tuple(velocities), tuple(loads), dwell_s=dwell_s)
    return WholeTest(schedule=schedule, poses={name: CommandPose() for name in poses})


def _relative(path: Path, folder: Path) -> str:
    """Return the path from the folder, with slashes; whole where no relative one leads there."""
    try:
        return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
    except ValueError:  # another drive of Windows
        return path.resolve().as_posix()


_LARGEST = 1_000_000
_HEAD = (
    "A test of ISO 9283: the recordings in this folder are its parts.",
    "Edit it freely; a line that begins with # says nothing.",
)
_SAID = {
    "robot": "what is tested; what is not stated is a deviation in the report",
    "test": "velocities and loads in per cent of the rated ones, in the order of recording",
    "cube": "where the poses come from, as plan computed it",
    "pose": "command coordinates in the robot's base frame; command = { X = 0.0 }: on the dials",
    "limits": "RP has to be at most this, in mm; the rule that decides: interval or simple",
    "instrument": "the indicator of each axis and its certificate; uncertainty is standard, in mm",
    "drift": "the drift test (7.6): blocks of visits over 8 h, from a cold start; drift.csv",
    "push": "a joint pushed to and fro: forces and readings in push.csv; several: [push.joint_1]",
    "environment": "where no limits are stated, (20 ± 2) °C are taken",
    "people": "for the report",
}
_WITHOUT_HEAD = ("pose", "instrument", "drift", "push")
"""Sections that hold sections, or that a test may be without."""
_OPEN: Mapping[str, tuple[str, ...]] = {
    "robot": ('serial_number = "0123"', "rated_payload_kg = 5", "rated_velocity_mm_s = 2000"),
    "test": (
        "stabilisation_time_s = 0.8",
        'approach = "one side"',
        "warm_up_min = 30",
        'dial_zero = "command"   # the dials were zeroed at the command pose: gives AP',
        "date = 2026-05-12",
    ),
    "limits": ("XY = 0.02", f"{EVERY_LENGTH} = 0.02"),
    "instrument": (
        "[instrument.X]",
        'name = "dial indicator"',
        'serial_number = "4711"',
        'certificate = "K-2026-17"',
        "calibration_date = 2026-01-10",
        "calibration_due = 2027-01-10",
        "uncertainty = 0.0005",
    ),
    "environment": ("temperature_C = 20.5", "temperature_limits_C = [18, 22]"),
    "drift": ("[drift]", 'pose = "P1"', "blocks = 33", "visits = 10", "limits = { dAP = 0.03 }"),
    "push": ("[push]", "arm_m = 0.25", "limits = { lost_motion = 1.2 }"),
    "people": ('operator = "A. Name"', 'laboratory = "Name, town"', 'customer = "Name, town"'),
}
"""What may be stated beside what is, as comments; a key that is stated is left out."""


def toml_of(test: WholeTest) -> str:
    """Return the file of a test; `parse_test` reads it back to the same test."""
    document = tomlkit.document()
    for line in _HEAD:
        document.add(tomlkit.comment(line))
    stated = _sections(test)
    for name, said in _SAID.items():
        values = stated[name]
        document.add(tomlkit.nl())
        if name in _WITHOUT_HEAD:
            document.add(tomlkit.comment(said))
        if values or name not in _WITHOUT_HEAD:
            holds_sections = bool(values) and all(isinstance(v, dict) for v in values.values())
            table = tomlkit.table(is_super_table=holds_sections)
            table.update(values)
            if name not in _WITHOUT_HEAD:
                table.comment(said)
            document.add(name, table)
        still_open = () if values and name in _WITHOUT_HEAD else _OPEN.get(name, ())
        for line in (one for one in still_open if one.partition(" =")[0] not in values):
            document.add(tomlkit.comment(line))
    for struck in test.struck:
        _add(document, struck)
    return tomlkit.dumps(document)


def _sections(test: WholeTest) -> dict[str, dict[str, Any]]:
    limits = {name or EVERY_LENGTH: limit for name, limit in test.limits.items()}
    found: dict[str, dict[str, Any]] = {
        "limits": {"decision": test.decision, **limits},
        "drift": {} if test.drift is None else _plain(test.drift),
        "push": _pushes(test),
    }
    found |= {key: _plain(getattr(test, field)) for key, (field, _) in SECTIONS.items()}
    for key, (field, _) in SECTIONS_OF.items():
        found[key] = {name: _plain(one) for name, one in getattr(test, field).items()}
    return found


def _pushes(test: WholeTest) -> dict[str, Any]:
    found = {name: _plain(one) for name, one in test.pushes.items()}
    if PUSH in found:
        return found[PUSH]
    return {name.removeprefix(f"{PUSH}-"): one for name, one in found.items()}


def strike(folder: Path, *struck: Struck) -> None:
    """Add strikes to the test.toml of a folder, all else kept as it is; raises as `write_file`."""
    path = folder / FILE
    document = tomlkit.parse(read_file(path, _LARGEST).decode("utf-8-sig"))
    for one in struck:
        _add(document, one)
    write_file(path, tomlkit.dumps(document).encode())


def _add(document: tomlkit.TOMLDocument, struck: Struck) -> None:
    tables = document.setdefault("struck", tomlkit.aot())
    listed = isinstance(tables, Array)  # struck = [...] in place of [[struck]]
    table: Any = tomlkit.inline_table() if listed else tomlkit.table()
    table["recording"], table["reason"] = struck.recording, struck.reason
    tables.append(table)


def _plain(section: Any) -> dict[str, Any]:
    """Return what a section states: what is empty is not stated."""
    found = {one.name: _toml(getattr(section, one.name)) for one in fields(section)}
    return {key: value for key, value in found.items() if value not in (None, "", [], {})}


def _toml(value: Any) -> Any:
    """Return a value as TOML has it, a whole number without its point, for the reader's eye."""
    if isinstance(value, Mapping):
        inline = tomlkit.inline_table()
        inline.update({key: _toml(one) for key, one in value.items()})
        return inline
    if isinstance(value, tuple):
        return [_toml(one) for one in value]
    whole = isinstance(value, float) and value.is_integer() and abs(value) < _LARGEST
    return int(value) if whole else value
