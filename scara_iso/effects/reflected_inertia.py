"""The rotor seen through the gearbox: N^2 I_m takes the place of I_m in eq. 16."""

import numpy as np

from scara_iso.effects._effect import GearEffect, Parameter, Sizes, Sweep
from scara_iso.effects._gap import deviation
from scara_iso.run import FloatArray


def _deviation(sweep: Sweep, values: Sizes) -> FloatArray:
    return deviation(values["N"] ** 2 * sweep.I_m, sweep.I_L, sweep.gap)


def _candidates(_: Sweep) -> tuple[Sizes, ...]:
    return tuple({"N": float(N)} for N in np.geomspace(1.05, 1000.0, 1200))


EFFECT = GearEffect(
    name="reflected_inertia",
    parameters=(Parameter("N", "N", "", "gear ratio through which the rotor acts", above=0),),
    cause="the rotor's inertia acts on the load through the gearbox, as N² Im",
    confirm_by="vary the inertia of the payload: the deviation must follow 1 / (1 + IL / (N² Im))",
    deviation=_deviation,
    candidates=_candidates,
)
