"""Heat through lumped nodes, integrated in time: a motor and the link it heats; a room's air."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from undeclared.dial import CYCLES, on_dial

_SECONDS = 30.0 * np.arange(CYCLES)


def warming_up(rng):
    """Motor and link from cold, two nodes with each its time constant; the dial sees both grow."""
    motor, link, _ = _two_nodes(rng)
    share, direction = rng.uniform(0.6, 1.0), rng.uniform(0.2, 1.3)
    grown = share * motor / motor[-1] + (1 - share) * link / link[-1]
    grown *= rng.choice([-1, 1]) * rng.uniform(0.020, 0.035)
    return on_dial(rng, {"X": np.cos(direction) * grown, "Y": np.sin(direction) * grown})


def warming_up_with_a_thermometer(rng):
    """The same, with a thermometer on the motor's housing that shows tenths."""
    motor, link, ambient = _two_nodes(rng)
    grown = rng.uniform(0.020, 0.035) * (0.7 * motor / motor[-1] + 0.3 * link / link[-1])
    shown = np.round(ambient + motor + rng.normal(0, 0.1, CYCLES), 1)
    return on_dial(rng, {"X": grown, "Y": 0 * grown}, recorded={"temperature_C": shown})


def thermostat(rng):
    """A room cooled on and off between two temperatures; the stand follows its air, late."""
    period = rng.uniform(4.0, 10.0) * 30.0
    on, late = rng.uniform(0.35, 0.65), rng.uniform(0.1, 0.3) * period
    seconds = np.arange(-5 * 600, _SECONDS[-1] + 1)
    slope = np.where((seconds + rng.uniform(0, period)) % period < on * period, 1 - on, -on)
    air = np.cumsum(slope)
    air -= air.mean()
    stand = np.empty_like(air)
    stand[0] = air[0]
    for k in range(1, len(air)):
        stand[k] = stand[k - 1] + (air[k] - stand[k - 1]) / late
    seen = np.interp(_SECONDS, seconds, stand)
    moved = rng.uniform(0.018, 0.028) * seen / np.ptp(seen)
    return on_dial(rng, {"X": moved, "Y": 0.5 * moved})


def _two_nodes(rng):
    """Return the rise of motor and link over room temperature, shape (31,), and that."""
    heat, to_link, to_air = rng.uniform(40, 90), rng.uniform(3, 6), rng.uniform(1, 3)
    motor_capacity = rng.uniform(400, 1500)
    link_capacity = 4 * motor_capacity

    def flow(_t, y):
        across = to_link * (y[0] - y[1])
        return [(heat - across - y[0]) / motor_capacity, (across - to_air * y[1]) / link_capacity]

    ends = (0.0, float(_SECONDS[-1]))
    motor, link = solve_ivp(flow, ends, [0.0, 0.0], t_eval=_SECONDS, rtol=1e-8).y
    return motor, link, rng.uniform(19, 23)
