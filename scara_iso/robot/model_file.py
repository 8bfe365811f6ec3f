"""MODEL.toml: read with every fault named by its key, written back with its comments kept.

Beside it what else states effects: a file of a user's own, and ``warm_up:size=0.03,tau=8`` or
``step@X:size=0.02,at_cycle=15`` as a user types them.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from scara_iso.base.errors import DataError, Fault, UsageError
from scara_iso.base.files import (
    KeyFaults,
    is_number,
    number_at,
    only,
    pair,
    read_file,
    read_toml,
    section,
    write_file,
)
from scara_iso.base.quantities import Dimension
from scara_iso.effects import (
    Effect,
    GearEffect,
    OwnEffect,
    Parameter,
    find_effects,
    find_gear_effects,
    own_effects,
)
from scara_iso.robot.arm import Arm, Elbow
from scara_iso.robot.model import (
    ARM_PLACES,
    DeclaredCourse,
    DeclaredEffect,
    Gearbox,
    Indicator,
    Joints,
    Model,
    Rated,
    Value,
)
from scara_iso.run import AXES
from scara_iso.tables import parse_clean

_SAVED = "# written by scara-iso"
_LARGEST = 1_000_000  # bytes
_SECTIONS = {"robot", "rated", "gearbox", "pose", "indicator", "effect", "definition", "learned"}
_LINKS = ("link_1_mm", "link_2_mm")
_LIMITS = ("joint_1_deg", "joint_2_deg", "quill_mm", "joint_4_deg")
_POSE = ("joint_deg", "x_mm", "y_mm", "elbow")
_KNOTS = ("cycle", "value", "u")
_GIVEN = ("Im", "IL", "arcmin")
"""What a gearbox must state; its model says which values cannot be."""
_ANY, _POSITIVE, _NOT_NEGATIVE = (
    lambda _: True,
    lambda value: value > 0,
    lambda value: value >= 0,
)
_Rules = Mapping[str, Callable[[float], bool]]
"""Keys with numbers, and which can be."""
_RATED: _Rules = {one.name: _POSITIVE for one in fields(Rated)}
_GEARBOX: _Rules = {
    one.name: _ANY if one.name in {*_GIVEN, "ratio"} else _NOT_NEGATIVE for one in fields(Gearbox)
}
_INDICATOR: _Rules = {
    "resolution": _POSITIVE, "uncertainty": _NOT_NEGATIVE, "level": _ANY, "scatter": _NOT_NEGATIVE,
}  # fmt: skip


def read_model(path: str | Path, own: Sequence[OwnEffect] = ()) -> Model:
    """Return the model of a TOML file; docs/model-file.md gives its keys.

    ``own`` are a user's effects that it may declare, beside those that it defines itself.

    Raises `NoInputError` for a file that cannot be read and `DataError` with every fault, each
    named by its key.
    """
    document = read_toml(path)
    faults = KeyFaults()
    faults += [Fault(f"{key}: no such section") for key in document if key not in _SECTIONS]
    robot, pose = section(document, "robot", faults), section(document, "pose", faults)
    indicators = dict(_indicators(section(document, "indicator", faults), faults))
    gears = dict(_gearboxes(section(document, "gearbox", faults), faults))
    arm = _arm(robot, faults)
    named = {key: v for key, v in pose.items() if isinstance(v, dict) and key not in _POSE}
    single = {key: value for key, value in pose.items() if key not in named}
    found = {name: _joints(entry, f"pose.{name}", arm, faults) for name, entry in named.items()}
    defined = _all_own(document.get("definition", []), own, faults)
    model = Model(
        robot=str(robot.get("name", "")),
        indicators=indicators,
        arm=arm,
        joints_deg=_joints(single, "pose", arm, faults) if single else None,
        poses={name: joints for name, joints in found.items() if joints is not None},
        gearboxes=gears,
        effects=tuple(
            _effects(document.get("effect", []), indicators, gears, find_effects(defined), faults)
        ),
        rated=Rated(**_numbers(section(document, "rated", faults), _RATED, "rated", faults)),
        serial_number=str(robot.get("serial_number", "")),
        own=defined,
        learned=tuple(_learned(document.get("learned", []), indicators, faults)),
    )
    _refuse("model", path, faults, "examples/fum_scara.toml holds every key")
    return model


def read_effects(path: str | Path) -> tuple[OwnEffect, ...]:
    """Return the effects that a TOML file defines; docs/diagnosis.md gives its keys.

    Errors as in `read_model`.
    """
    document, key = read_toml(path), "effect"
    faults = KeyFaults()
    only(document, {key}, "file", faults)
    found = tuple(own_effects(document.get(key, []), key, _taken(), faults))
    if not document.get(key):
        faults.add(key, "missing: one [[effect]] for each, with name and formula")
    _refuse("effects", path, faults, "give each [[effect]] a name, a formula and its parameters")
    return found


def _refuse(what: str, path: str | Path, faults: KeyFaults, remedy: str) -> None:
    if faults:
        raise DataError(
            f"the {what} cannot be read: {len(faults)} fault{'s' if len(faults) > 1 else ''}",
            where=str(path),
            remedy=remedy,
            faults=faults,
        )


def _all_own(
    entries: object, given: Sequence[OwnEffect], faults: KeyFaults
) -> tuple[OwnEffect, ...]:
    """Return the effects ``given`` and those that the ``definition`` tables of a model define.

    One that stands in both must be the same.
    """
    known: dict[str, OwnEffect] = {one.name: one for one in given}
    for one in own_effects(entries, "definition", _taken(), faults):
        if one.name in known and dict(known[one.name].definition) != dict(one.definition):
            faults.add(f"definition {one.name}", "differs from the effect of that name beside it")
        known.setdefault(one.name, one)
    return tuple(known.values())


def _taken() -> set[str]:
    return {"unknown", *(e.name for e in find_effects()), *(e.name for e in find_gear_effects())}


def _numbers(
    table: Mapping[str, Any], rules: _Rules, where: str, faults: KeyFaults, *others: str
) -> dict[str, float]:
    """Return the numbers of a section by key; ``others`` are keys that it may have beside them."""
    only(table, {*rules, *others}, where, faults)
    given = {name: number_at(table, name, where, faults) for name in rules}
    found = {name: value for name, value in given.items() if value is not None}
    for name, value in found.items():
        if not rules[name](value):
            faults.add(f"{where}.{name}", "must be positive")
    return found


def _checked(build: Callable[[], Any], where: str, faults: KeyFaults) -> Any:
    """Return what ``build`` makes; None where it cannot, which goes to ``faults``."""
    try:
        return build()
    except UsageError as error:
        faults.add(where, error.what)
        return None


def _missing(table: Mapping[str, Any], keys: Iterable[str], where: str, faults: KeyFaults) -> bool:
    missing = [key for key in keys if key not in table]
    for key in missing:
        faults.add(f"{where}.{key}", "missing")
    return bool(missing)


def _arm(robot: Mapping[str, Any], faults: KeyFaults) -> Arm | None:
    only(robot, {"name", "serial_number", *_LINKS, *_LIMITS}, "robot", faults)
    stated = [key for key in (*_LINKS, *_LIMITS) if key in robot]
    given: dict[str, Any] = {
        key: (pair if key in _LIMITS else number_at)(robot, key, "robot", faults) for key in stated
    }
    if not given or _missing(robot, _LINKS, "robot", faults) or None in given.values():
        return None
    arm: Arm | None = _checked(lambda: Arm(**given), "robot", faults)
    return arm


def _gearboxes(table: Mapping[str, Any], faults: KeyFaults) -> Iterator[tuple[int, Gearbox]]:
    for key in table:
        where = f"gearbox.{key}"
        if key not in ("joint_1", "joint_2"):
            faults.add(where, "no such joint: joint_1 or joint_2")
            continue
        entry = section(table, key, faults)
        given = _numbers(entry, _GEARBOX, where, faults)
        if not _missing(entry, _GIVEN, where, faults) and given.keys() >= {*_GIVEN}:
            gear = Gearbox(**given)
            if _checked(gear.backlash, where, faults) is not None:
                yield int(key[-1]), gear


def _indicators(table: Mapping[str, Any], faults: KeyFaults) -> Iterator[tuple[str, Indicator]]:
    if not table:
        faults.add("indicator", "missing: one section for each axis, such as [indicator.X]")
    for axis in table:
        where = f"indicator.{axis}"
        if axis not in AXES:
            faults.add(where, f"no such axis: {', '.join(AXES)}")
            continue
        entry = section(table, axis, faults)
        given, unit = _numbers(entry, _INDICATOR, where, faults, "unit"), entry.get("unit", "mm")
        if unit in ("mm", "deg"):
            yield axis, Indicator(axis, Dimension(unit), **given)
        else:
            faults.add(f"{where}.unit", f"{unit!r}: mm or deg")


def _joints(
    pose: Mapping[str, Any], where: str, arm: Arm | None, faults: KeyFaults
) -> Joints | None:
    only(pose, {*_POSE}, where, faults)
    side = pose.get("elbow", "right")
    if side not in ("left", "right"):
        faults.add(f"{where}.elbow", f"{repr(side)[:40]}: right or left")
    if "joint_deg" in pose:
        if len(pose) > 1:
            faults.add(where, "give either joint_deg, or x_mm and y_mm")
        joints = pair(pose, "joint_deg", where, faults)
        for k, over in enumerate([] if arm is None else arm.excess(joints).tolist(), 1):
            if over > 0:
                faults.add(f"{where}.joint_deg", f"joint {k} is {over:g} deg outside its limits")
        return joints
    x, y = (number_at(pose, key, where, faults) for key in ("x_mm", "y_mm"))
    if x is None or y is None:
        faults.add(where, "give joint_deg, or x_mm and y_mm")
    elif arm is None:
        faults.add(where, "x_mm and y_mm need the link lengths of robot")
    else:
        elbow = Elbow.LEFT if side == "left" else Elbow.RIGHT
        found = _checked(lambda: arm.inverse([x, y], elbow=elbow).tolist(), where, faults)
        return None if found is None else (found[0], found[1])
    return None


def _effects(
    entries: object,
    indicators: Mapping[str, Indicator],
    gearboxes: Mapping[int, Gearbox],
    effects: Iterable[Effect],
    faults: KeyFaults,
) -> Iterator[DeclaredEffect]:
    """Yield the effects of the ``[[effect]]`` tables, which are among ``effects`` or on a gear."""
    if not isinstance(entries, list):
        faults.add("effect", "write each effect as [[effect]]")
        return
    known: dict[object, Effect | GearEffect] = {e.name: e for e in effects}
    known |= {e.name: e for e in find_gear_effects()}
    for k, entry in enumerate(entries, 1):
        where = f"effect {k}"
        name = entry.get("name") if isinstance(entry, dict) else None
        if not isinstance(name, str) or name not in known:
            faults.add(where, f"name one of {', '.join(sorted(map(str, known)))}")
            continue
        effect, joint = known[name], entry.get("joint")
        values = {key: entry[key] for key in entry if key not in ("name", "joint")}
        _check_parameters(effect, values, indicators, where, faults)
        if isinstance(effect, GearEffect) and joint not in [*gearboxes]:
            faults.add(f"{where}.joint", "give the number of a joint that has a gearbox")
        elif joint is not None and (joint not in (1, 2) or isinstance(joint, bool)):
            faults.add(f"{where}.joint", "1 or 2")
        yield DeclaredEffect(name, values, joint)


def _check_parameters(
    effect: Effect | GearEffect,
    values: Mapping[str, object],
    indicators: Mapping[str, Indicator],
    where: str,
    faults: KeyFaults,
) -> None:
    seconds = {p.in_seconds for p in effect.parameters if p.timed}
    only(values, {p.name for p in effect.parameters} | seconds, where, faults)
    for p in effect.parameters:
        if p.in_seconds in values and (wrong := _why_not(p, values[p.in_seconds])):
            faults.add(f"{where}.{p.in_seconds}", wrong)
        if p.name in values or p.in_seconds not in values:
            _check(p, values.get(p.name), indicators, f"{where}.{p.name}", faults)
    axes = [set(value) for value in values.values() if isinstance(value, dict)]
    if any(other != axes[0] for other in axes):
        faults.add(where, "give every parameter for the same axes")


def _check(
    parameter: Parameter,
    value: object,
    indicators: Mapping[str, Indicator],
    key: str,
    faults: KeyFaults,
) -> None:
    by_axis = value if isinstance(value, dict) else {}
    places = [name for name in by_axis if name in ARM_PLACES]
    for axis in (name for name in by_axis if name not in {*places, *indicators}):
        faults.add(f"{key}.{axis}", f"no indicator {axis}")
    if places and len(places) < len(by_axis):
        faults.add(key, f"give it for axes, or for {', '.join(ARM_PLACES)}")
    if value is None:
        faults.add(key, "missing")
    elif not by_axis and parameter.per_axis:
        faults.add(key, "give a value for each axis it acts on, such as { X = 0.03 }")
    else:
        for at, part in ({f"{key}.{a}": v for a, v in by_axis.items()} or {key: value}).items():
            if wrong := _why_not(parameter, part):
                faults.add(at, wrong)


def _why_not(parameter: Parameter, value: object) -> str:
    """Return why ``value`` cannot be that of a parameter; empty where it can."""
    if parameter.text:
        return "" if isinstance(value, str) else f"{repr(value)[:40]} is not the name of a column"
    if not is_number(value):
        return f"{repr(value)[:40]} is not a finite number"
    if parameter.above < float(value) <= parameter.up_to:  # type: ignore[arg-type]
        return ""
    upper = "" if parameter.up_to == float("inf") else f" and at most {parameter.up_to:g}"
    return f"{value!r} must be above {parameter.above:g}{upper}"


def _learned(
    entries: object, indicators: Mapping[str, Indicator], faults: KeyFaults
) -> Iterator[DeclaredCourse]:
    if not isinstance(entries, list):
        faults.add("learned", "write each course as [[learned]]")
        return
    left = [*indicators]
    for k, entry in enumerate(entries, 1):
        where = f"learned {k}"
        if not isinstance(entry, dict) or entry.get("axis") not in left:
            faults.add(f"{where}.axis", f"name one of {', '.join(indicators)}, each once")
            continue
        left.remove(entry["axis"])
        only(entry, {"axis", *_KNOTS}, where, faults)
        columns = [entry.get(name) for name in _KNOTS]
        if wrong := _why_no_knots(columns):
            faults.add(where, wrong)
            continue
        yield DeclaredCourse(entry["axis"], *(np.array(column, dtype=float) for column in columns))


def _why_no_knots(columns: Sequence[object]) -> str:
    """Return why cycle, value and u are not those of knots; empty where they are."""
    lists = [column for column in columns if isinstance(column, list)]
    if len(lists) < len(columns) or not lists[0] or len({len(column) for column in lists}) > 1:
        return "give cycle, value and u as lists of one length"
    if not all(is_number(number) for column in lists for number in column):
        return "every cycle, value and u is a finite number"
    if any(later <= earlier for earlier, later in pairwise(lists[0])):
        return "the cycles must increase"
    return "" if min(lists[2]) >= 0 else "no u is negative"


def declare(
    path: str | Path,
    effects: tuple[DeclaredEffect, ...],
    to: str | Path,
    scatter: Mapping[str, float] | None = None,
    own: Iterable[OwnEffect] = (),
    learned: Iterable[DeclaredCourse] = (),
) -> None:
    """Write the model file ``path`` to ``to`` with ``effects`` added; comments are kept.

    ``scatter`` is that of some of its indicators, by axis; of ``own`` effects those declared are
    defined too, so that the file stands alone. ``learned`` courses are added to those of the same
    axes that the file has, at its own knots. ``to`` may be ``path`` itself. Raises as
    `write_file`.
    """
    import tomlkit  # noqa: PLC0415 - only where a model is written

    try:
        document: Any = tomlkit.parse(read_file(Path(path), _LARGEST).decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise DataError("not UTF-8", where=str(path), remedy="save it as UTF-8 text") from error
    tables: Any = document.setdefault("effect", tomlkit.aot()) if effects else None
    for effect in effects:
        listed = isinstance(tables, tomlkit.items.Array)  # effect = [...] in place of [[effect]]
        table = tomlkit.inline_table() if listed else tomlkit.table()
        joint = {} if effect.joint is None else {"joint": effect.joint}
        for name, value in {"name": effect.name, **joint, **effect.parameters}.items():
            table[name] = _written(value)
        tables.append(table)
    there = {entry["name"] for entry in document.get("definition", [])}
    for one in own:
        if one.name in {effect.name for effect in effects} - there:
            definitions = document.setdefault("definition", tomlkit.aot())
            definitions.append(tomlkit.item(dict(one.definition)))
    for course in learned:
        _add_learned(document, course)
    for axis, size in (scatter or {}).items():
        document["indicator"][axis]["scatter"] = size
        document["indicator"][axis].value.item("scatter").comment("of the readings diagnosed")
    text = tomlkit.dumps(document)
    head = "" if text.startswith(_SAVED) else f"{_SAVED}\n"
    write_file(Path(to), f"{head}{text}".encode())


def _add_learned(document: Any, course: DeclaredCourse) -> None:
    """Add a learned course; one that its axis already has is what it is beside."""
    import tomlkit  # noqa: PLC0415 - only where a model is written

    tables, value = document.setdefault("learned", tomlkit.aot()), course.value
    there = next((entry for entry in tables if entry.get("axis") == course.axis), None)
    if there is None:
        there = tomlkit.table()
        there["axis"] = course.axis
        tables.append(there)
    else:
        value = value + np.interp(course.cycle, there["cycle"], there["value"])
    for name, numbers in zip(_KNOTS, (course.cycle, value, course.u), strict=True):
        there[name] = [float(f"{number:.6g}") for number in numbers.tolist()]


def _written(value: Value) -> Any:
    """Return a value with the digits in which all processors agree."""
    import tomlkit  # noqa: PLC0415 - only where a model is written

    if isinstance(value, Mapping):
        table = tomlkit.inline_table()
        table.update({name: _written(part) for name, part in value.items()})
        return table
    return float(f"{value:.12g}") if isinstance(value, float) else value


def parse_effect(text: str, model: Model) -> DeclaredEffect:
    """Return the effect that ``text`` spells, ``NAME[@AXES]:PARAMETER=VALUE,...``.

    A parameter in the unit of a reading (its size) holds for each of the axes named, or for every
    indicator of a length. Raises `UsageError` naming what is unknown or missing.
    """
    head, _, tail = text.partition(":")
    name, _, axes = head.partition("@")
    effects = {effect.name: effect for effect in find_effects(model.own)}
    effect = effects.get(name.strip())
    if effect is None:
        known = ", ".join(sorted(effects))
        raise UsageError(f"unknown effect {name!r}", remedy=f"use one of {known}")
    lengths = [i.axis for i in model.indicators.values() if i.dimension is Dimension.LENGTH]
    named = [axis.strip() for axis in axes.split(",")] if axes else lengths
    kinds, faults = {p.name: p for p in effect.parameters}, KeyFaults()
    values: dict[str, Any] = {}
    for part in filter(None, (part.strip() for part in tail.split(","))):
        key, _, spelled = (piece.strip() for piece in part.partition("="))
        if key in values:
            faults.add(key, "given twice")
        is_text = key in kinds and kinds[key].text
        number = None if is_text else parse_clean([spelled], ".")
        value = spelled if number is None else float(number[0][0])
        values[key] = dict.fromkeys(named, value) if key in kinds and kinds[key].per_axis else value
    _check_parameters(effect, values, model.indicators, effect.name, faults)
    if faults:
        raise UsageError(
            f"effect {text!r}: {'; '.join(fault.message for fault in faults)}",
            remedy=f"write {head.strip()}:{','.join(f'{name}=...' for name in kinds)}",
        )
    return DeclaredEffect(effect.name, values)
