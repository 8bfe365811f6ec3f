"""What happens at the bench: a dial set to zero again, and a reading taken down by hand."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bench import run_session

from scara_iso.recorder.indicators import find_dialect
from scara_iso.recorder.ports.simulated import SimulatedPort
from scara_iso.tables import read_table
from undeclared.dial import CYCLES, SCATTER, on_dial


def zeroed_again(rng):
    """A simulated instrument is recorded; in between somebody presses its zero key on the master.

    Zeroing takes whatever the dial shows at that moment for zero: here the master, and what the
    dial has wandered from it since the morning.
    """
    attained = rng.uniform(0.3, 0.7) + rng.normal(0, SCATTER, CYCLES)
    pressed, wandered = int(rng.integers(7, 25)), rng.choice([-1, 1]) * rng.uniform(0.012, 0.03)

    def shows(k):
        return attained[min(k, CYCLES - 1)] - (wandered if k >= pressed else 0.0)

    def port(clock):
        dialect = find_dialect("opto-rs232")
        return SimulatedPort("sim:", dialect, axis="X", clock=clock, asked=True, source=shows)

    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        run_session(
            Path(folder), ["X=opto-rs232@sim:"], ports={"X": port}, cycles=CYCLES, monkeypatch=patch
        )
        return replace(read_table(Path(folder) / "run.csv"), metadata={})


def zeroed_each_time(rng):
    """Somebody presses the zero key after every reading: each is how far it is from the last."""
    attained = rng.normal(0, SCATTER, CYCLES + 1)
    return on_dial(rng, {"X": np.diff(attained)}, scatter=0.0)


def taught_again(rng):
    """The pose is taught again after every reading, by what it was off to 2 um; X and Z are."""
    courses = {}
    for name in "XZ":
        taught, shown = 0.0, []
        for scatter in rng.normal(0, 2 * SCATTER, CYCLES):
            shown.append(taught + scatter)
            taught -= 0.002 * np.round(shown[-1] / 0.002)
        courses[name] = np.array(shown)
    return on_dial(rng, courses, scatter=0.0)


def digit_slip(rng):
    """One reading written down with its second decimal wrong, or two digits exchanged."""
    run = on_dial(rng, {"X": np.zeros(CYCLES), "Z": np.zeros(CYCLES)})
    axis = run.axes["X"]
    k = int(rng.integers(3, CYCLES))
    texts = [f"{v:.3f}" for v in axis.readings]
    whole, tenth, hundredth, thousandth = texts[k][:-3], *texts[k][-3:]
    if abs(int(tenth) - int(hundredth)) >= 4 and rng.random() < 0.5:
        texts[k] = f"{whole}{hundredth}{tenth}{thousandth}"
    else:
        wrong = rng.choice([d for d in range(10) if abs(d - int(hundredth)) >= 5])
        texts[k] = f"{whole}{tenth}{wrong}{thousandth}"
    slipped = replace(axis, readings=np.array([float(text) for text in texts]))
    return replace(run, axes={**run.axes, "X": slipped})
