"""MODEL.toml: read with every fault named by its key, written back with its comments kept."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scara_iso.arm import Arm, Elbow
from scara_iso.effects import Effect, GearEffect, find_effects, find_gear_effects
from scara_iso.errors import CannotCreateError, DataError, Fault, NoInputError, UsageError
from scara_iso.model.parts import DeclaredEffect, Gearbox, Indicator, Model
from scara_iso.quantities import Dimension
from scara_iso.run import AXES

if TYPE_CHECKING:
    from tomlkit.items import InlineTable

_LARGEST = 1_000_000  # bytes
_ARM = ("link_1_mm", "link_2_mm", "joint_1_deg", "joint_2_deg", "quill_mm", "joint_4_deg")
_PAIRS = {"joint_1_deg", "joint_2_deg", "quill_mm", "joint_4_deg"}
_SECTIONS = {"robot", "gearbox", "pose", "indicator", "effect"}


class _Faults(list[Fault]):
    """Faults of one file, each named by its key."""

    def add(self, key: str, message: str) -> None:
        self.append(Fault(f"{key}: {message}"))


def read_model(path: str | Path) -> Model:
    """Return the model of a TOML file; docs/model-file.md gives its keys.

    Raises `NoInputError` for a file that cannot be read and `DataError` with every fault, each
    named by its key.
    """
    document = _load(Path(path))
    faults = _Faults()
    faults += [Fault(f"{key}: no such section") for key in document if key not in _SECTIONS]
    robot = _table(document, "robot", faults)
    indicators = dict(_indicators(_table(document, "indicator", faults), faults))
    arm = _arm(robot, faults)
    model = Model(
        robot=str(robot.get("name", "")),
        indicators=indicators,
        arm=arm,
        joints_deg=_pose(_table(document, "pose", faults), arm, faults),
        gearboxes=dict(_gearboxes(_table(document, "gearbox", faults), faults)),
        effects=tuple(_effects(document.get("effect", []), indicators, faults)),
    )
    if faults:
        raise DataError(
            f"no model can be read: {len(faults)} fault{'s' if len(faults) > 1 else ''}",
            where=str(path),
            remedy="examples/fum_scara.toml holds every key",
            faults=faults,
        )
    return model


def declare(path: str | Path, effects: tuple[DeclaredEffect, ...], to: str | Path) -> None:
    """Write the model file ``path`` to ``to`` with ``effects`` added; comments are kept.

    Raises `CannotCreateError` where ``to`` cannot be written.
    """
    import tomlkit  # noqa: PLC0415 - only where a model is written

    document = tomlkit.parse(_text(Path(path)))
    tables = document.setdefault("effect", tomlkit.aot())
    for effect in effects:
        table = tomlkit.table()
        table["name"] = effect.name
        if effect.joint is not None:
            table["joint"] = effect.joint
        for name, value in effect.parameters.items():
            table[name] = _inline(value) if isinstance(value, Mapping) else value
        tables.append(table)
    try:
        Path(to).write_text(tomlkit.dumps(document), encoding="utf-8")
    except OSError as error:
        raise CannotCreateError(f"cannot be written: {error.strerror}", where=str(to)) from error


def _inline(values: Mapping[str, float]) -> InlineTable:
    import tomlkit  # noqa: PLC0415 - only where a model is written

    table = tomlkit.inline_table()
    table.update(values)
    return table


def _load(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(_text(path))
    except tomllib.TOMLDecodeError as error:
        raise DataError(f"no TOML: {error}", where=str(path)) from error


def _text(path: Path) -> str:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise NoInputError(error.strerror or "cannot be read", where=str(path)) from error
    if len(data) > _LARGEST:
        raise DataError("larger than any model", where=str(path))
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataError("not UTF-8", where=str(path)) from error


def _table(document: Mapping[str, Any], key: str, faults: _Faults) -> dict[str, Any]:
    found = document.get(key, {})
    if isinstance(found, dict):
        return found
    faults.add(key, "is no section")
    return {}


def _number(table: Mapping[str, Any], key: str, where: str, faults: _Faults) -> float | None:
    value = table.get(key)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        faults.add(f"{where}.{key}", f"{value!r} is not a finite number")
        return None
    return float(value)


def _pair(table: Mapping[str, Any], key: str, where: str, faults: _Faults) -> tuple[float, float]:
    value = table[key]
    if isinstance(value, list) and len(value) == 2:
        pair = [_number({key: part}, key, where, faults) for part in value]
        return (pair[0] or 0.0, pair[1] or 0.0)
    faults.add(f"{where}.{key}", f"{value!r} is not a pair of numbers")
    return (0.0, 0.0)


def _only(table: Mapping[str, Any], known: set[str], where: str, faults: _Faults) -> None:
    for key in table:
        if key not in known:
            faults.add(f"{where}.{key}", f"no such key; known are {', '.join(sorted(known))}")


def _checked(build: Callable[[], Any], where: str, faults: _Faults) -> Any:
    try:
        return build()
    except UsageError as error:
        faults.add(where, error.what)
        return None


def _arm(robot: Mapping[str, Any], faults: _Faults) -> Arm | None:
    _only(robot, {"name", *_ARM}, "robot", faults)
    if not any(key in robot for key in _ARM):
        return None
    missing = [key for key in ("link_1_mm", "link_2_mm") if key not in robot]
    for key in missing:
        faults.add(f"robot.{key}", "missing")
    given: dict[str, Any] = {
        key: (_pair if key in _PAIRS else _number)(robot, key, "robot", faults)
        for key in _ARM
        if key in robot
    }
    if missing or any(value is None for value in given.values()):
        return None
    arm: Arm | None = _checked(lambda: Arm(**given), "robot", faults)
    return arm


def _pose(pose: Mapping[str, Any], arm: Arm | None, faults: _Faults) -> tuple[float, float] | None:
    _only(pose, {"joint_deg", "x_mm", "y_mm", "elbow"}, "pose", faults)
    if "joint_deg" in pose:
        return _pair(pose, "joint_deg", "pose", faults)
    x, y = (_number(pose, key, "pose", faults) for key in ("x_mm", "y_mm"))
    if x is None or y is None:
        if pose:
            faults.add("pose", "give joint_deg, or x_mm and y_mm")
        return None
    if arm is None:
        faults.add("pose", "x_mm and y_mm need the link lengths of robot")
        return None
    elbow = Elbow.LEFT if pose.get("elbow") == "left" else Elbow.RIGHT
    joints = _checked(lambda: arm.inverse([x, y], elbow=elbow), "pose", faults)
    return None if joints is None else (float(joints[0]), float(joints[1]))


def _gearboxes(table: Mapping[str, Any], faults: _Faults) -> Iterator[tuple[int, Gearbox]]:
    known = {field.name for field in fields(Gearbox)}
    for key in table:
        where = f"gearbox.{key}"
        if key not in ("joint_1", "joint_2"):
            faults.add(where, "no such joint: joint_1 or joint_2")
            continue
        entry = _table(table, key, faults)
        _only(entry, known, where, faults)
        for name in ("Im", "IL", "arcmin"):
            if name not in entry:
                faults.add(f"{where}.{name}", "missing")
        given = {name: _number(entry, name, where, faults) for name in known & set(entry)}
        if {"Im", "IL", "arcmin"} <= {name for name, value in given.items() if value is not None}:
            gear = Gearbox(**given)  # type: ignore[arg-type]
            if _checked(gear.backlash, where, faults) is not None:
                yield int(key[-1]), gear


def _indicators(table: Mapping[str, Any], faults: _Faults) -> Iterator[tuple[str, Indicator]]:
    if not table:
        faults.add("indicator", "missing: one section for each axis, such as [indicator.X]")
    for axis in table:
        where = f"indicator.{axis}"
        if axis not in AXES:
            faults.add(where, f"no such axis: {', '.join(AXES)}")
            continue
        entry = _table(table, axis, faults)
        known = {"unit", "resolution", "uncertainty", "level", "scatter"}
        _only(entry, known, where, faults)
        given = {key: _number(entry, key, where, faults) for key in known - {"unit"}}
        unit = entry.get("unit", "mm")
        if unit not in ("mm", "deg"):
            faults.add(f"{where}.unit", f"{unit!r}: mm or deg")
            continue
        for key in ("resolution", "uncertainty", "scatter"):
            if (given[key] or 0.0) < 0 or (key == "resolution" and given[key] == 0):
                faults.add(f"{where}.{key}", "must be positive")
        yield axis, Indicator(axis, Dimension(unit), given["resolution"], given["uncertainty"],
                              given["level"] or 0.0, given["scatter"] or 0.0)  # fmt: skip


def _effects(
    entries: object, indicators: Mapping[str, Indicator], faults: _Faults
) -> Iterator[DeclaredEffect]:
    if not isinstance(entries, list):
        faults.add("effect", "write each effect as [[effect]]")
        return
    known: dict[str, Effect | GearEffect] = {e.name: e for e in find_effects()}
    known |= {e.name: e for e in find_gear_effects()}
    for k, entry in enumerate(entries, 1):
        where = f"effect {k}"
        if not isinstance(entry, dict) or entry.get("name") not in known:
            faults.add(where, f"name one of {', '.join(sorted(known))}")
            continue
        parameters = {key: entry[key] for key in entry if key not in ("name", "joint")}
        _only(parameters, {p.name for p in known[entry["name"]].parameters}, where, faults)
        for key, value in parameters.items():
            for axis, part in value.items() if isinstance(value, dict) else ():
                _number({key: part}, key, f"{where}.{axis}", faults)
                if axis not in indicators:
                    faults.add(f"{where}.{key}", f"no indicator {axis}")
            if not isinstance(value, dict | str):
                _number(parameters, key, where, faults)
        yield DeclaredEffect(entry["name"], parameters, entry.get("joint"))
