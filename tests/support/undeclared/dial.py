"""Courses in mm to readings on a dial, and that to a table and back."""

from __future__ import annotations

import numpy as np

from scara_iso.run import Axis, Run
from scara_iso.tables import read_table, write_table

CYCLES = 31
CYCLE = np.arange(1, CYCLES + 1)
SCATTER = 0.004
DIVISION = 0.001


def on_dial(rng, moved, *, scatter=SCATTER, recorded=None):
    """Return the run whose dials saw ``moved`` (axis to mm, shape (31,)) beside scatter in mm."""
    axes = {}
    for name, course in moved.items():
        seen = rng.uniform(0.2, 0.8) + course + rng.normal(0, 1, CYCLES) * scatter
        axes[name] = Axis(name, np.round(seen / DIVISION) * DIVISION, resolution=DIVISION)
    return Run(CYCLE, axes, covariates=recorded or {})


def through_a_file(run):
    """Return what is read of the table that ``run`` is written as."""
    return read_table(write_table(run).encode("utf-8"))
