"""A model and effects of the user's own, as objects or as the files that define them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from scara_iso import robot
from scara_iso.effects import OwnEffect

if TYPE_CHECKING:
    from scara_iso.robot import Model

OwnEffects: TypeAlias = str | Path | Sequence[OwnEffect]
"""Effects of the user's own, or the file that defines them."""


def described(model: Model | str | Path, own_effects: OwnEffects = ()) -> Model:
    """Return a model, read where its file is named, with the user's effects.

    Errors as in `read_model` and `read_effects`.
    """
    own = defined(own_effects)
    if not isinstance(model, robot.Model):
        return robot.read_model(model, own)
    known = {one.name: one for one in (*own, *model.own)}
    return replace(model, own=tuple(known.values())) if own else model


def defined(own_effects: OwnEffects) -> tuple[OwnEffect, ...]:
    """Return effects, read where their file is named; errors as in `read_effects`."""
    if isinstance(own_effects, str | Path):
        return robot.read_effects(own_effects)
    return tuple(own_effects)
