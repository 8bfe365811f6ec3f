"""What of a diagnosis the model declares already."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from scara_iso import robot
from scara_iso.diagnosis.result import Diagnosis, Found
from scara_iso.effects import Values, find_effects

if TYPE_CHECKING:
    from scara_iso.robot import Model

_ALIKE = 2.0
"""Sizes of random courses within this factor may be of one cause: 30 cycles show them no better."""


def as_declared(found: Diagnosis, model: Model) -> Iterator[str]:
    """Yield which effects the model declares already: chance draws them anew in every test."""
    effects = {effect.name: effect for effect in find_effects(model.own)}
    for again in found.effects:
        declared = {
            axis: one.on_axis(axis)
            for one in model.effects
            if one.name == again.effect
            for axis in one.axes
            if robot.is_random(effects[one.name], one, axis)
        }
        if declared.keys().isdisjoint(again.axes):
            continue
        yield (
            f"{again.effect}: as declared; the model holds it, and chance draws it anew in every "
            f"test{_unlike(again, declared)}"
        )


def _unlike(again: Found, declared: Mapping[str, Values]) -> str:
    """Return what of an effect found again is not as the model declares it for an axis."""
    said = [f"new on {axis}" for axis in again.axes if axis not in declared]
    sizes = again.parameters.get("size")
    for axis, values in declared.items():
        size = sizes.get(axis) if isinstance(sizes, Mapping) else None
        if size and not 1 / _ALIKE < abs(size / float(values.get("size", size))) < _ALIKE:
            said.append(f"size {axis} {size:.2g}, declared {values['size']:.2g}")
    return "".join(f"; {one}" for one in said)
