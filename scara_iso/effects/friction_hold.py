"""Friction holds the load inside the gap: only a share of it is crossed.

At one speed this cannot be told from a smaller gap.
"""

import numpy as np

from scara_iso.effects._effect import GearEffect, Parameter, Sizes, Sweep
from scara_iso.effects._gap import deviation
from scara_iso.run import FloatArray


def _deviation(sweep: Sweep, values: Sizes) -> FloatArray:
    """Return eq. 16 for the share of the gap that is crossed.

    The source gives no formula; a load that friction holds leaves ``held`` 2D uncrossed.
    """
    return deviation(sweep.I_m, sweep.I_L, (1 - values["held"]) * sweep.gap)


def _candidates(_: Sweep) -> tuple[Sizes, ...]:
    return tuple({"held": float(held)} for held in np.linspace(0.001, 0.999, 999))


EFFECT = GearEffect(
    name="friction_hold",
    parameters=(
        Parameter(
            "held", "h", "", "share of the gap that friction keeps from crossing", above=0, up_to=1
        ),
    ),
    cause="friction of seal, bearing or mesh holds the load inside the gap",
    confirm_by="vary the approach speed: a held load comes to rest elsewhere",
    deviation=_deviation,
    candidates=_candidates,
)
