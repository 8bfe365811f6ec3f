"""Friction holds the load inside the gap: only a share of it is crossed.

At one speed this cannot be told from a smaller gap.
"""

from dataclasses import replace

import numpy as np

from scara_iso.effects import GearEffect, Grid, Parameter, Sweep


def _changed(sweep: Sweep, *, held: float) -> Sweep:
    """Return the sweep with the share of the gap that is crossed.

    The source gives no formula; a load that friction holds leaves ``held`` 2D uncrossed.
    """
    return replace(sweep, gap=(1 - held) * sweep.gap)


def _shares(_: Sweep) -> Grid:
    return Grid.exact(np.linspace(0.001, 0.999, 999))


EFFECT = GearEffect(
    name="friction_hold",
    parameters=(
        Parameter(
            "held",
            "h",
            "",
            "share of the gap that friction keeps from crossing",
            above=0,
            up_to=1,
            grid=_shares,
        ),
    ),
    cause="friction of seal, bearing or mesh holds the load inside the gap",
    confirm_by="vary the approach speed: a held load comes to rest elsewhere",
    changed=_changed,
)
