"""A gap that differs from the catalogue's: the same model with another 2D."""

import numpy as np

from scara_iso.effects._effect import GearEffect, Parameter, Sizes, Sweep
from scara_iso.effects._gap import deviation
from scara_iso.run import FloatArray


def _deviation(sweep: Sweep, values: Sizes) -> FloatArray:
    return deviation(sweep.I_m, sweep.I_L, values["factor"] * sweep.gap)


def _candidates(_: Sweep) -> tuple[Sizes, ...]:
    return tuple({"factor": float(factor)} for factor in np.geomspace(0.2, 5.0, 1200))


EFFECT = GearEffect(
    name="gap",
    parameters=(Parameter("factor", "f", "", "true gap over the stated one", above=0),),
    cause="the gear's backlash is not the catalogue's: wear, assembly, or a wrong figure",
    confirm_by="hold the motor and measure the free play of the output directly",
    deviation=_deviation,
    candidates=_candidates,
)
