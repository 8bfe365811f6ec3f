"""A deviation that depends on the load's inertia otherwise than any known effect makes it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scara_iso.diagnosis.reversals.fit import Family, Reversals, single_families
from scara_iso.diagnosis.tuning import UNKNOWN
from scara_iso.effects import GearEffect, Grid, Parameter, Sweep


def unknown_families(data: Reversals) -> list[Family]:
    """Return a power law of the load's inertia at each joint: structure of no known effect."""
    shapes = [single_families(data, [effect]) for effect in (_LEVEL_OF_ANY, _POWER_OF_ANY)]
    return [(*level, *power) for level, power in zip(*shapes, strict=True)] if all(shapes) else []


def _at_level(sweep: Sweep, *, level: float) -> Sweep:
    return replace(sweep, I_m=np.full_like(sweep.I_m, np.inf), gap=sweep.gap * np.exp(level))


def _at_power(sweep: Sweep, *, power: float) -> Sweep:
    log = np.log(sweep.I_L)
    return replace(sweep, gap=sweep.gap * np.exp(power * (log - log.mean())))


def _levels(_: Sweep) -> Grid:
    return Grid.exact(np.linspace(-14.0, 2.0, 201))


def _powers(sweep: Sweep) -> Grid:
    return Grid.exact(np.linspace(-2.0, 2.0, 201) if np.ptp(sweep.I_L) else [])


_LEVEL_OF_ANY, _POWER_OF_ANY = (
    GearEffect(
        name=UNKNOWN,
        parameters=(Parameter(name, name, "", "of a deviation of unknown cause", grid=grid),),
        cause="none known",
        confirm_by="measure at more inertias, several times at each",
        changed=changed,
    )
    for name, changed, grid in (("level", _at_level, _levels), ("power", _at_power, _powers))
)
