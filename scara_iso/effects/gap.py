"""A gap that differs from the catalogue's: the same model with another 2D."""

from dataclasses import replace

import numpy as np

from scara_iso.effects import GearEffect, Grid, Parameter, Sweep


def _changed(sweep: Sweep, *, factor: float) -> Sweep:
    return replace(sweep, gap=factor * sweep.gap)


def _factors(_: Sweep) -> Grid:
    return Grid.exact(np.geomspace(0.2, 5.0, 1200))


EFFECT = GearEffect(
    name="gap",
    parameters=(
        Parameter("factor", "f", "", "true gap over the stated one", above=0, grid=_factors),
    ),
    cause="the gear's backlash is not the catalogue's: wear, assembly, or a wrong figure",
    confirm_by="hold the motor and measure the free play of the output directly",
    changed=_changed,
)
