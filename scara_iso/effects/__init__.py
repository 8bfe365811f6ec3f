"""The catalogue: one file for each effect that readings or reversals may hold.

A file defines ``EFFECT``, an `Effect` of one of four kinds or a `GearEffect`. Third parties add
modules of that kind through the entry-point group ``scara_iso.effects``.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from functools import cache
from types import ModuleType

from scara_iso.base.plugins import find_modules
from scara_iso.effects._effect import (
    Effect as Effect,
    GearEffect as GearEffect,
    KnownCourse as KnownCourse,
    RandomCourse as RandomCourse,
    ScatterChange as ScatterChange,
    Sweep as Sweep,
    TwoStates as TwoStates,
    as_column as as_column,
    proportional as proportional,
)
from scara_iso.effects._own import OwnEffect as OwnEffect, own_effects as own_effects
from scara_iso.effects._parts import (
    AMPLITUDE_AND_PHASE as AMPLITUDE_AND_PHASE,
    CLOCK as CLOCK,
    SIZE as SIZE,
    Chain as Chain,
    Conditions as Conditions,
    Form as Form,
    Grid as Grid,
    Linear as Linear,
    Parameter as Parameter,
    Process as Process,
    Shape as Shape,
    Sizes as Sizes,
    Spread as Spread,
    Values as Values,
)


def find_effects(own: Iterable[Effect] = ()) -> tuple[Effect, ...]:
    """Return every effect on the readings of a test, by name of its module, and then ``own``."""
    return (*(effect for effect in _catalogue() if isinstance(effect, Effect)), *own)


def find_gear_effects() -> tuple[GearEffect, ...]:
    """Return every effect on the load deviation at a reversal."""
    return tuple(effect for effect in _catalogue() if isinstance(effect, GearEffect))


@cache
def _catalogue() -> tuple[Effect | GearEffect, ...]:
    modules = find_modules(sys.modules[__name__], "scara_iso.effects")
    return tuple(module.EFFECT for module in modules)


def check_shape(module: ModuleType) -> None:
    """Raise `AttributeError` or `TypeError` unless a module has an ``EFFECT``."""
    if not isinstance(module.EFFECT, Effect | GearEffect):
        raise TypeError("EFFECT is neither an Effect nor a GearEffect")
