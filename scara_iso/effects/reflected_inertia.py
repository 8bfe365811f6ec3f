"""The rotor seen through the gearbox: N^2 I_m takes the place of I_m in eq. 16."""

from dataclasses import replace

import numpy as np

from scara_iso.effects import GearEffect, Grid, Parameter, Sweep

_KNOWN_WITHIN = 1.25
"""A stated ratio is tried up to this factor away, for what a catalogue's I_m leaves out."""


def _changed(sweep: Sweep, *, N: float) -> Sweep:
    """Return the sweep with N^2 I_m; where the rows state several ratios N is their median's.

    What is left of the ratio is then 1: the rotor is not reflected twice.
    """
    relative = np.ones_like(sweep.I_m) if sweep.ratio is None else sweep.ratio
    I_m = (N * relative / np.median(relative)) ** 2 * sweep.I_m
    return replace(sweep, I_m=I_m, ratio=np.ones_like(I_m))


def _ratios(sweep: Sweep) -> Grid:
    if sweep.ratio is None:
        return Grid.exact(np.geomspace(1.05, 1000.0, 1200))
    stated = float(np.median(sweep.ratio))
    return Grid.exact(np.geomspace(stated / _KNOWN_WITHIN, stated * _KNOWN_WITHIN, 201))


EFFECT = GearEffect(
    name="reflected_inertia",
    parameters=(
        Parameter("N", "N", "", "gear ratio through which the rotor acts", above=0, grid=_ratios),
    ),
    cause="the rotor's inertia acts on the load through the gearbox, as N² Im",
    confirm_by="vary the inertia of the payload: the deviation must follow 1 / (1 + IL / (N² Im))",
    changed=_changed,
)
