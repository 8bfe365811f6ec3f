"""Gear and shaft wind up under torque: torque / stiffness is added to the gap on either side."""

from dataclasses import replace

import numpy as np

from scara_iso.effects._effect import GearEffect, Parameter, Sizes, Sweep


def _changed(sweep: Sweep, values: Sizes) -> Sweep:
    torque = np.zeros_like(sweep.gap) if sweep.torque is None else np.abs(sweep.torque)
    return replace(sweep, gap=sweep.gap + 2 * torque * values["compliance"])


def _candidates(sweep: Sweep) -> tuple[Sizes, ...]:
    if sweep.torque is None or not np.any(sweep.torque):
        return ()
    return tuple({"compliance": float(c)} for c in np.geomspace(1e-8, 1e-1, 1200))


EFFECT = GearEffect(
    name="wind_up",
    parameters=(Parameter("compliance", "1/k", "rad/(N m)", "inverse of the stiffness", above=0),),
    cause="gear and shaft wind up under the torque of the reversal",
    confirm_by="ramp the torque both ways at standstill and record the angle",
    changed=_changed,
    candidates=_candidates,
)
