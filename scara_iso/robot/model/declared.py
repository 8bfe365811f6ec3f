"""The effects that a model file declares, each checked against what the catalogue says of it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from scara_iso.effects import Effect, GearEffect, Parameter, find_effects, find_gear_effects
from scara_iso.robot.model.at_joint import ARM_PLACES
from scara_iso.robot.model.parts import DeclaredEffect, Gearbox, Indicator
from scara_iso.toml_keys import KeyFaults, is_number, only


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
        _check_axes(values, where, faults)
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
    seconds = {p.in_seconds: p for p in effect.parameters if p.timed}
    only(values, {p.name for p in effect.parameters} | {*seconds}, where, faults)
    for parameter in effect.parameters:
        if parameter.name in values or parameter.in_seconds not in values:
            _check(parameter, values, indicators, where, faults)
    for in_seconds, parameter in seconds.items():
        if in_seconds in values and (wrong := why_not(parameter, values[in_seconds])):
            faults.add(f"{where}.{in_seconds}", wrong)


def _check(
    parameter: Parameter,
    values: Mapping[str, object],
    indicators: Mapping[str, Indicator],
    where: str,
    faults: KeyFaults,
) -> None:
    key, value = f"{where}.{parameter.name}", values.get(parameter.name)
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
    parts = {f"{key}.{axis}": part for axis, part in by_axis.items()} or {key: value}
    for place, part in parts.items():
        if wrong := why_not(parameter, part):
            faults.add(place, wrong)


def _check_axes(values: Mapping[str, object], where: str, faults: KeyFaults) -> None:
    """Every parameter given by axis is given for the same axes."""
    axes = [set(value) for value in values.values() if isinstance(value, dict)]
    if any(other != axes[0] for other in axes):
        faults.add(where, "give every parameter for the same axes")


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
