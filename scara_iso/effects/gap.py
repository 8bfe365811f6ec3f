"""A gap that differs from the catalogue's: the same model with another 2D."""

from dataclasses import replace

import numpy as np

from scara_iso.effects._effect import GearEffect, Parameter, Sizes, Sweep


def _changed(sweep: Sweep, values: Sizes) -> Sweep:
    return replace(sweep, gap=values["factor"] * sweep.gap)


def _candidates(_: Sweep) -> tuple[Sizes, ...]:
    return tuple({"factor": float(factor)} for factor in np.geomspace(0.2, 5.0, 1200))


EFFECT = GearEffect(
    name="gap",
    parameters=(Parameter("factor", "f", "", "true gap over the stated one", above=0),),
    cause="the gear's backlash is not the catalogue's: wear, assembly, or a wrong figure",
    confirm_by="hold the motor and measure the free play of the output directly",
    changed=_changed,
    candidates=_candidates,
)
