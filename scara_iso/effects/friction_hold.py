"""Friction holds the load inside the gap: only a share of the deviation takes place."""

from scara_iso.effects._effect import GearEffect, Parameter, Sizes, Sweep
from scara_iso.effects._gap import deviation
from scara_iso.run import FloatArray


def _deviation(sweep: Sweep, values: Sizes) -> FloatArray:
    """Return eq. 16's deviation, moved towards rest by the held share of the whole gap.

    The source gives no formula: the load stops ``held`` 2D before the flank, never beyond where
    it started.
    """
    free = deviation(sweep.I_m, sweep.I_L, sweep.gap)
    return (free + values["held"] * sweep.gap).clip(max=0.0)


EFFECT = GearEffect(
    name="friction_hold",
    parameters=(Parameter("held", "h", "", "share of the gap that friction keeps from crossing"),),
    cause="friction of seal, bearing or mesh holds the load inside the gap",
    confirm_by="vary the approach speed: a held load comes to rest elsewhere",
    deviation=_deviation,
    start=(0.1,),
    bounds=((0.0, 1.0),),
)
