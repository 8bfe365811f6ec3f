"""Gear and shaft wind up under torque: torque / stiffness is added to the gap on either side."""

from dataclasses import replace

import numpy as np

from scara_iso.effects import GearEffect, Grid, Parameter, Sweep


def _changed(sweep: Sweep, *, compliance: float) -> Sweep:
    torque = np.zeros_like(sweep.gap) if sweep.torque is None else np.abs(sweep.torque)
    return replace(sweep, gap=sweep.gap + 2 * torque * compliance)


def _compliances(sweep: Sweep) -> Grid:
    acts = sweep.torque is not None and np.any(sweep.torque)
    return Grid.exact(np.geomspace(1e-8, 1e-1, 1200) if acts else [])


EFFECT = GearEffect(
    name="wind_up",
    parameters=(
        Parameter(
            "compliance", "1/k", "rad/(N m)", "inverse of the stiffness", above=0, grid=_compliances
        ),
    ),
    cause="gear and shaft wind up under the torque of the reversal",
    confirm_by="ramp the torque both ways at standstill and record the angle",
    changed=_changed,
)
