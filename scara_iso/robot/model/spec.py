"""Effects as a user types them: ``warm_up:size=0.03,tau=8``, ``step@X:size=0.02,at_cycle=15``."""

from __future__ import annotations

from collections.abc import Mapping

from scara_iso.effects import Effect, Parameter, find_effects
from scara_iso.errors import UsageError
from scara_iso.quantities import Dimension
from scara_iso.robot.model.declared import why_not
from scara_iso.robot.model.parts import DeclaredEffect, Model, Value
from scara_iso.tables import parse_clean


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
    values = _values(text, tail, effect)
    return DeclaredEffect(effect.name, _by_axis(values, effect, _axes(axes, model)))


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


def _axes(text: str, model: Model) -> list[str]:
    if text:
        return [axis.strip() for axis in text.split(",")]
    lengths = (i for i in model.indicators.values() if i.dimension is Dimension.LENGTH)
    return [indicator.axis for indicator in lengths]


def _by_axis(
    values: Mapping[str, float | str], effect: Effect, axes: list[str]
) -> dict[str, Value]:
    sizes = {p.name for p in effect.parameters if p.per_axis}
    return {
        key: dict.fromkeys(axes, value) if key in sizes and isinstance(value, float) else value
        for key, value in values.items()
    }
