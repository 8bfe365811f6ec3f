"""The motor is held: I_m to infinity in eq. 16, the load crosses the whole gap."""

from dataclasses import replace

import numpy as np

from scara_iso.effects import GearEffect, Sweep


def _changed(sweep: Sweep) -> Sweep:
    return replace(sweep, I_m=np.full_like(sweep.I_m, np.inf))


EFFECT = GearEffect(
    name="held_motor",
    parameters=(),
    cause="servo or brake holds the motor while the load is pushed across the whole gap",
    confirm_by="measure with the servo on and off",
    changed=_changed,
)
