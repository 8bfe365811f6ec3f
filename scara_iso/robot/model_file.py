"""MODEL.toml: read with every fault named by its key, written back with its comments kept.

The effects that a model file declares, each checked against what the catalogue says of it.

Effects as a user types them: ``warm_up:size=0.03,tau=8``, ``step@X:size=0.02,at_cycle=15``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scara_iso.base.disk import write_file
from scara_iso.base.errors import DataError, Fault, UsageError
from scara_iso.base.files import read_file, read_toml
from scara_iso.base.quantities import Dimension
from scara_iso.base.toml_keys import KeyFaults, is_number, number_at, only, pair, section
from scara_iso.effects import (
    Effect,
    GearEffect,
    OwnEffect,
    Parameter,
    find_effects,
    find_gear_effects,
)
from scara_iso.robot.arm import Arm
from scara_iso.robot.model import (
    ARM_PLACES,
    DeclaredCourse,
    DeclaredEffect,
    Gearbox,
    Indicator,
    Model,
    Rated,
    Value,
    all_own,
    poses_of,
)
from scara_iso.run import AXES
from scara_iso.tables import parse_clean

if TYPE_CHECKING:
    from tomlkit.items import InlineTable


def declared_effects(
    entries: object,
    indicators: Mapping[str, Indicator],
    gearboxes: Mapping[int, Gearbox],
    own: Iterable[Effect],
    faults: KeyFaults,
) -> Iterator[DeclaredEffect]:
    """Yield the effects of the ``[[effect]]`` tables; what is wrong with one goes to ``faults``.

    ``own`` are those that may be declared beside the catalogue's.
    """
    if not isinstance(entries, list):
        faults.add("effect", "write each effect as [[effect]]")
        return
    known: dict[object, Effect | GearEffect] = {e.name: e for e in find_effects(own)}
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
        if p.in_seconds in values and (wrong := why_not(p, values[p.in_seconds])):
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
    if value is None:
        faults.add(key, "missing")
        return
    by_axis = value if isinstance(value, dict) else {}
    places = [name for name in by_axis if name in ARM_PLACES]
    for axis in by_axis:
        if axis not in indicators and axis not in places:
            faults.add(f"{key}.{axis}", f"no indicator {axis}")
    if places and len(places) < len(by_axis):
        faults.add(key, f"give it for axes, or for {', '.join(ARM_PLACES)}")
    if not by_axis and parameter.per_axis:
        faults.add(key, "give a value for each axis it acts on, such as { X = 0.03 }")
        return
    for place, part in ({f"{key}.{a}": v for a, v in by_axis.items()} or {key: value}).items():
        if wrong := why_not(parameter, part):
            faults.add(place, wrong)


def why_not(parameter: Parameter, value: object) -> str:
    """Return why ``value`` cannot be that of a parameter; empty where it can."""
    if parameter.text:
        return "" if isinstance(value, str) else f"{repr(value)[:40]} is not the name of a column"
    if not is_number(value):
        return f"{repr(value)[:40]} is not a finite number"
    if parameter.above < float(value) <= parameter.up_to:  # type: ignore[arg-type]
        return ""
    upper = "" if parameter.up_to == float("inf") else f" and at most {parameter.up_to:g}"
    return f"{value!r} must be above {parameter.above:g}{upper}"


_LARGEST = 1_000_000  # bytes
_ARM = ("link_1_mm", "link_2_mm", "joint_1_deg", "joint_2_deg", "quill_mm", "joint_4_deg")
_PAIRS = {"joint_1_deg", "joint_2_deg", "quill_mm", "joint_4_deg"}
_RATED = tuple(field.name for field in fields(Rated))
_SECTIONS = {"robot", "rated", "gearbox", "pose", "indicator", "effect", "definition", "learned"}
_KNOTS = ("cycle", "value", "u")


def read_model(path: str | Path, own: Sequence[OwnEffect] = ()) -> Model:
    """Return the model of a TOML file; docs/model-file.md gives its keys.

    ``own`` are a user's effects that it may declare, beside those that it defines itself.

    Raises `NoInputError` for a file that cannot be read and `DataError` with every fault, each
    named by its key.
    """
    document = read_toml(path)
    faults = KeyFaults()
    faults += [Fault(f"{key}: no such section") for key in document if key not in _SECTIONS]
    robot = section(document, "robot", faults)
    indicators = dict(_indicators(section(document, "indicator", faults), faults))
    gears = dict(_gearboxes(section(document, "gearbox", faults), faults))
    arm = _arm(robot, faults)
    joints_deg, poses = poses_of(section(document, "pose", faults), arm, faults)
    defined = all_own(document.get("definition", []), own, faults)
    model = Model(
        robot=str(robot.get("name", "")),
        indicators=indicators,
        arm=arm,
        joints_deg=joints_deg,
        poses=poses,
        gearboxes=gears,
        effects=tuple(
            declared_effects(document.get("effect", []), indicators, gears, defined, faults)
        ),
        rated=_rated(section(document, "rated", faults), faults),
        serial_number=str(robot.get("serial_number", "")),
        own=defined,
        learned=tuple(_learned(document.get("learned", []), indicators, faults)),
    )
    if faults:
        raise DataError(
            f"the model cannot be read: {len(faults)} fault{'s' if len(faults) > 1 else ''}",
            where=str(path),
            remedy="examples/fum_scara.toml holds every key",
            faults=faults,
        )
    return model


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

    document = tomlkit.parse(_text(Path(path)))
    tables = document.setdefault("effect", tomlkit.aot())
    for effect in effects:
        listed = isinstance(tables, tomlkit.items.Array)  # effect = [...] in place of [[effect]]
        table = tomlkit.inline_table() if listed else tomlkit.table()
        table["name"] = effect.name
        if effect.joint is not None:
            table["joint"] = effect.joint
        for name, value in effect.parameters.items():
            table[name] = _inline(value) if isinstance(value, Mapping) else _written(value)
        tables.append(table)
    _define(document, [one for one in own if one.name in {e.name for e in effects}])
    _add_learned(document, learned)
    for axis, value in (scatter or {}).items():
        document["indicator"][axis]["scatter"] = value
    write_file(Path(to), tomlkit.dumps(document).encode())


def _add_learned(document: Any, learned: Iterable[DeclaredCourse]) -> None:
    """Add learned courses; one that its axis already has is what they are beside."""
    import tomlkit  # noqa: PLC0415 - only where a model is written

    for course in learned:
        tables = document.setdefault("learned", tomlkit.aot())
        there = next((entry for entry in tables if entry.get("axis") == course.axis), None)
        value = course.value
        if there is None:
            there = tomlkit.table()
            there["axis"] = course.axis
            tables.append(there)
        else:
            value = value + np.interp(course.cycle, there["cycle"], there["value"])
        for name, numbers in zip(_KNOTS, (course.cycle, value, course.u), strict=True):
            there[name] = [float(f"{number:.6g}") for number in numbers.tolist()]


def _define(document: Any, own: Iterable[OwnEffect]) -> None:
    """Add the definitions of effects that are not in the document yet."""
    import tomlkit  # noqa: PLC0415 - only where a model is written

    there = {entry["name"] for entry in document.get("definition", [])}
    wanted = [one.definition for one in own if one.name not in there]
    if wanted:
        tables = document.setdefault("definition", tomlkit.aot())
        for definition in wanted:
            tables.append(tomlkit.item(dict(definition)))


def _learned(
    entries: object, indicators: Mapping[str, Indicator], faults: KeyFaults
) -> Iterator[DeclaredCourse]:
    """Yield the courses of the ``[[learned]]`` tables; what is wrong goes to ``faults``."""
    if not isinstance(entries, list):
        faults.add("learned", "write each course as [[learned]]")
        return
    seen: set[str] = set()
    for k, entry in enumerate(entries, 1):
        where = f"learned {k}"
        if not isinstance(entry, dict) or entry.get("axis") not in {*indicators} - seen:
            faults.add(f"{where}.axis", f"name one of {', '.join(indicators)}, each once")
            continue
        seen.add(entry["axis"])
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


def _inline(values: Mapping[str, float]) -> InlineTable:
    import tomlkit  # noqa: PLC0415 - only where a model is written

    table = tomlkit.inline_table()
    table.update({name: _written(value) for name, value in values.items()})
    return table


def _written(value: float | str) -> float | str:
    """Return a number with the digits in which all processors agree."""
    return float(f"{value:.12g}") if isinstance(value, float) else value


def _text(path: Path) -> str:
    data = read_file(path, _LARGEST)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataError("not UTF-8", where=str(path), remedy="save it as UTF-8 text") from error


def _checked(build: Callable[[], Any], where: str, faults: KeyFaults) -> Any:
    try:
        return build()
    except UsageError as error:
        faults.add(where, error.what)
        return None


def _rated(table: Mapping[str, Any], faults: KeyFaults) -> Rated:
    only(table, set(_RATED), "rated", faults)
    given = {name: number_at(table, name, "rated", faults) for name in _RATED}
    for name, value in given.items():
        if value is not None and value <= 0:
            faults.add(f"rated.{name}", "must be positive")
    return Rated(**given)


def _arm(robot: Mapping[str, Any], faults: KeyFaults) -> Arm | None:
    only(robot, {"name", "serial_number", *_RATED, *_ARM}, "robot", faults)
    if not any(key in robot for key in _ARM):
        return None
    missing = [key for key in ("link_1_mm", "link_2_mm") if key not in robot]
    for key in missing:
        faults.add(f"robot.{key}", "missing")
    given: dict[str, Any] = {
        key: (pair if key in _PAIRS else number_at)(robot, key, "robot", faults)
        for key in _ARM
        if key in robot
    }
    if missing or any(value is None for value in given.values()):
        return None
    arm: Arm | None = _checked(lambda: Arm(**given), "robot", faults)
    return arm


def _gearboxes(table: Mapping[str, Any], faults: KeyFaults) -> Iterator[tuple[int, Gearbox]]:
    known = {field.name for field in fields(Gearbox)}
    for key in table:
        where = f"gearbox.{key}"
        if key not in ("joint_1", "joint_2"):
            faults.add(where, "no such joint: joint_1 or joint_2")
            continue
        entry = section(table, key, faults)
        only(entry, known, where, faults)
        for name in ("Im", "IL", "arcmin"):
            if name not in entry:
                faults.add(f"{where}.{name}", "missing")
        given = {name: number_at(entry, name, where, faults) for name in known & set(entry)}
        faults += [
            Fault(f"{where}.{name}: must be positive")
            for name in ("stiffness", "friction", "payload_kg")
            if (given.get(name) or 0.0) < 0
        ]
        if {"Im", "IL", "arcmin"} <= {name for name, value in given.items() if value is not None}:
            gear = Gearbox(**given)  # type: ignore[arg-type]
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
        known = {"unit", "resolution", "uncertainty", "level", "scatter"}
        only(entry, known, where, faults)
        given = {key: number_at(entry, key, where, faults) for key in known - {"unit"}}
        unit = entry.get("unit", "mm")
        if unit not in ("mm", "deg"):
            faults.add(f"{where}.unit", f"{unit!r}: mm or deg")
            continue
        for key in ("resolution", "uncertainty", "scatter"):
            if (given[key] or 0.0) < 0 or (key == "resolution" and given[key] == 0):
                faults.add(f"{where}.{key}", "must be positive")
        stated = {key: value for key, value in given.items() if value is not None}
        yield axis, Indicator(axis, Dimension(unit), **stated)


def parse_effect(text: str, model: Model) -> DeclaredEffect:
    """Return the effect that ``text`` spells, ``NAME[@AXES]:PARAMETER=VALUE,...``.

    A parameter in the unit of a reading (its size) holds for each of the axes named, or for every
    indicator of a length. Raises `UsageError` naming what is unknown or missing.
    """
    head, _, tail = text.partition(":")
    name, _, axes = head.partition("@")
    every = find_effects(model.own)
    effect = next((e for e in every if e.name == name.strip()), None)
    if effect is None:
        known = ", ".join(sorted(e.name for e in every))
        raise UsageError(f"unknown effect {name!r}", remedy=f"use one of {known}")
    lengths = [i.axis for i in model.indicators.values() if i.dimension is Dimension.LENGTH]
    named = [axis.strip() for axis in axes.split(",")] if axes else lengths
    sizes = {p.name for p in effect.parameters if p.per_axis}
    given: dict[str, Value] = {
        key: dict.fromkeys(named, value) if key in sizes and isinstance(value, float) else value
        for key, value in _values(text, tail, effect).items()
    }
    return DeclaredEffect(effect.name, given)


def _values(text: str, tail: str, effect: Effect) -> dict[str, float | str]:
    seconds = {p.in_seconds: p for p in effect.parameters if p.timed}
    wanted = {p.name: p for p in effect.parameters} | seconds
    values: dict[str, float | str] = {}
    for part in filter(None, (part.strip() for part in tail.split(","))):
        key, _, value = (piece.strip() for piece in part.partition("="))
        if key not in wanted:
            raise UsageError(
                f"effect {text!r} has no parameter {key!r}",
                remedy=f"{effect.name} takes {', '.join(sorted(wanted))}",
            )
        if key in values:
            raise UsageError(f"effect {text!r}: {key} is given twice", remedy="give it once")
        values[key] = value if wanted[key].text else _value(text, wanted[key], value)
    given = {wanted[key].name for key in values}
    missing = sorted({p.name for p in effect.parameters} - given)
    if missing:
        raise UsageError(
            f"effect {text!r}: {', '.join(missing)} not given",
            remedy=f"write {effect.name}:{','.join(f'{p.name}=...' for p in effect.parameters)}",
        )
    return values


def _value(text: str, parameter: Parameter, spelled: str) -> float:
    found = parse_clean([spelled], ".")
    wrong = "no number" if found is None else why_not(parameter, float(found[0][0]))
    if found is None or wrong:
        raise UsageError(
            f"effect {text!r}: {parameter.name}={spelled}: {wrong}",
            remedy=f"write {parameter.name} as a number in its range",
        )
    return float(found[0][0])
