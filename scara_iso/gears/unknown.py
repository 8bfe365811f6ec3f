"""A deviation that depends on the load's inertia otherwise than any known effect makes it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scara_iso.effects import GearEffect, Parameter, Sweep
from scara_iso.effects._effect import Sizes
from scara_iso.gears.fit import Family, Reversals, single_families

UNKNOWN = "unknown"


def unknown_families(data: Reversals) -> list[Family]:
    """Return a power law of the load's inertia at each joint: structure of no known effect."""
    shapes = [single_families(data, [effect]) for effect in (_LEVEL_OF_ANY, _POWER_OF_ANY)]
    return [(*level, *power) for level, power in zip(*shapes, strict=True)] if all(shapes) else []


def _at_level(sweep: Sweep, values: Sizes) -> Sweep:
    return replace(
        sweep, I_m=np.full_like(sweep.I_m, np.inf), gap=sweep.gap * np.exp(values["level"])
    )


def _at_power(sweep: Sweep, values: Sizes) -> Sweep:
    log = np.log(sweep.I_L)
    return replace(sweep, gap=sweep.gap * np.exp(values["power"] * (log - log.mean())))


_LEVEL_OF_ANY, _POWER_OF_ANY = (
    GearEffect(
        name=UNKNOWN,
        parameters=(Parameter(name, name, "", "of a deviation of unknown cause"),),
        cause="none known",
        confirm_by="measure at more inertias, several times at each",
        changed=changed,
        candidates=candidates,
    )
    for name, changed, candidates in (
        ("level", _at_level, lambda _: _tried("level", -14.0, 2.0)),
        ("power", _at_power, lambda s: _tried("power", -2.0, 2.0) if np.ptp(s.I_L) else ()),
    )
)


def _tried(name: str, low: float, high: float) -> tuple[Sizes, ...]:
    return tuple({name: float(value)} for value in np.linspace(low, high, 201))
