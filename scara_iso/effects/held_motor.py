"""The motor is held: I_m to infinity in eq. 16, the load crosses the whole gap."""

from dataclasses import replace

import numpy as np

from scara_iso.effects._effect import GearEffect, Sizes, Sweep


def _changed(sweep: Sweep, _: Sizes) -> Sweep:
    return replace(sweep, I_m=np.full_like(sweep.I_m, np.inf))


def _candidates(_: Sweep) -> tuple[Sizes, ...]:
    return ({},)


EFFECT = GearEffect(
    name="held_motor",
    parameters=(),
    cause="servo or brake holds the motor while the load is pushed across the whole gap",
    confirm_by="measure with the servo on and off",
    changed=_changed,
    candidates=_candidates,
)
