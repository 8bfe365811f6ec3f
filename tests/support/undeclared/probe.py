"""Touches of one point by a real probe while its machine warms up, cut into tests of 31.

Data: tests/fixtures/probe_thermal. Phases: nothing heated yet (cold), bed on its way to 70 °C
(heating), bed held there while the probe follows (soak), heat off (cooling).
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from scara_iso.run import Axis, Run
from undeclared.dial import CYCLES, through_a_file

DIVISION = 0.00125
_TOUCHES = Path(__file__).parents[2] / "fixtures" / "probe_thermal" / "touches.csv"


@dataclass(frozen=True, slots=True)
class Window:
    """One test of 31 touches, and the 31 touches after it."""

    probe: str
    phase: str
    run: Run
    following: Run


@cache
def windows():
    """Return every window of both probes in the order of time, the phase being its own."""
    with _TOUCHES.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    found = []
    for probe in dict.fromkeys(row["run"] for row in rows):
        own = [row for row in rows if row["run"] == probe]
        cuts = [own[k : k + CYCLES] for k in _starts(own)]
        found += [
            Window(probe, cut[0]["phase"], _run(cut), _run(own[k + CYCLES : k + 2 * CYCLES]))
            for k, cut in zip(_starts(own), cuts, strict=True)
            if k + 2 * CYCLES <= len(own)
        ]
    return found


def _starts(rows):
    """Return where windows begin: one after the other within each phase."""
    phases = [row["phase"] for row in rows]
    return [
        k
        for phase in dict.fromkeys(phases)
        for k in range(phases.index(phase), phases.index(phase) + phases.count(phase), CYCLES)
        if phases[k : k + CYCLES] == [phase] * CYCLES
    ]


def _run(rows):
    z = DIVISION * np.array([int(row["steps"]) for row in rows])
    seconds = np.array([float(row["time_s"]) for row in rows])
    cycle = np.arange(1, CYCLES + 1)
    axis = Axis("Z", z, resolution=DIVISION)
    return through_a_file(Run(cycle, {"Z": axis}, covariates={"time_s": seconds}))
