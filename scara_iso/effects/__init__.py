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
    Direction,
    Effect,
    GearEffect,
    KnownCourse,
    RandomCourse,
    ScatterChange,
    Sweep,
    TwoStates,
    as_column,
    proportional,
)
from scara_iso.effects._formula import Formula, FormulaError, parse_formula
from scara_iso.effects._own import OwnEffect, own_effects
from scara_iso.effects._parts import (
    AMPLITUDE_AND_PHASE,
    CLOCK,
    SIZE,
    Chain,
    Conditions,
    Form,
    Grid,
    Linear,
    Parameter,
    Process,
    Shape,
    Sizes,
    Spread,
    Values,
)

__all__ = [
    "AMPLITUDE_AND_PHASE",
    "CLOCK",
    "SIZE",
    "Chain",
    "Conditions",
    "Direction",
    "Effect",
    "Form",
    "Formula",
    "FormulaError",
    "GearEffect",
    "Grid",
    "KnownCourse",
    "Linear",
    "OwnEffect",
    "Parameter",
    "Process",
    "RandomCourse",
    "ScatterChange",
    "Shape",
    "Sizes",
    "Spread",
    "Sweep",
    "TwoStates",
    "Values",
    "as_column",
    "find_effects",
    "find_gear_effects",
    "own_effects",
    "parse_formula",
    "proportional",
]


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
