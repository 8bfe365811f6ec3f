"""Effects that act in a joint or along the arm, as the dials at a pose show them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from scara_iso.effects import Effect
from scara_iso.errors import UsageError
from scara_iso.quantities import Dimension
from scara_iso.robot.model.parts import DeclaredEffect, Model, Value
from scara_iso.run import FloatArray

ARM_PLACES = ("joint 1", "joint 2", "along the arm")
"""Where in the arm an effect may be declared to act: sizes in rad; growth of the links in 1."""


def on_dials(declared: DeclaredEffect, effect: Effect, model: Model) -> DeclaredEffect:
    """Return an effect with its sizes by axis at the pose of ``model``, itself where it has them.

    Raises `UsageError` where it acts in the arm and the pose's joints are not known.
    """
    places = [name for name in declared.axes if name in ARM_PLACES]
    if not places:
        return declared
    if model.arm is None or model.joints_deg is None:
        raise UsageError(
            f"effect {declared.name} acts in the arm ({', '.join(places)}), and the model does not "
            "say where its joints stand",
            remedy="give the joint_deg of the pose: [pose], or [pose.P1] and so on of a test",
        )
    moved = {axis: _movement(model, axis) for axis in model.indicators}
    sizes: dict[str, dict[str, float]] = {name: {} for name in effect.linear.names}
    for axis, by_place in moved.items():
        if any(by_place.values()):
            at = {place: _coefficients(declared, effect, place) for place in places}
            whole = np.sum([at[place] * by_place[place] for place in places], axis=0)
            for name, size in effect.linear.sizes(whole).items():
                sizes[name][axis] = size
    kept: dict[str, Value] = {k: v for k, v in declared.parameters.items() if k not in sizes}
    return replace(declared, parameters={**sizes, **kept})


def _coefficients(declared: DeclaredEffect, effect: Effect, place: str) -> FloatArray:
    values = declared.on_axis(place)
    return effect.linear.coefficients({name: float(values[name]) for name in effect.linear.names})


def _movement(model: Model, axis: str) -> Mapping[str, float]:
    """Return how far a dial moves for each radian of a joint, and for the growth of the links."""
    assert model.arm is not None  # noqa: S101 - `on_dials` asks
    assert model.joints_deg is not None  # noqa: S101
    jacobian, place = model.arm.jacobian(model.joints_deg), model.arm.forward(model.joints_deg)
    if axis in ("X", "Y"):
        row = "XY".index(axis)
        moved = (*jacobian[row].tolist(), float(place[row]))
    elif axis == "theta" and model.indicators[axis].dimension is Dimension.ANGLE:
        moved = (math.degrees(1), math.degrees(1), 0.0)
    else:
        moved = (0.0, 0.0, 0.0)
    return dict(zip(ARM_PLACES, moved, strict=True))
