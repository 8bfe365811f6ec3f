"""Whether an axis at rest on a coarse dial hides what another axis shows.

    python benchmarks/beside_quiet.py [--runs 100]

31 cycles. X moves, Y and Z only scatter; all dials of 0.01 mm, or X's alone of 0.001 mm. *Before*:
each axis speaks in full, however few readings it shows.
"""

from __future__ import annotations

import argparse
from unittest.mock import patch

import numpy as np

from scara_iso.diagnosis import Verdict
from scara_iso.diagnosis.engine import order
from scara_iso.diagnosis.readings import diagnose_readings
from scara_iso.run import Axis, FloatArray, Run

CYCLE = np.arange(31)
SCATTER, DIVISION = 0.004, 0.01
COURSES: dict[str, FloatArray] = {
    "nothing": 0.0 * CYCLE,
    "drift 0.024": 0.0008 * CYCLE,
    "step 0.015": np.where(CYCLE > 15, 0.015, 0.0),
    "every third 0.016": np.where(CYCLE % 3 == 2, 0.016, 0.0),
    "kink": np.where(CYCLE > 18, (CYCLE - 18) * 0.0018, 0.0),
    "sine 0.01": 0.01 * np.sin(0.9 * CYCLE),
}


def is_found(rng: np.random.Generator, course: FloatArray, fine: float, beside: str) -> bool:
    """Return whether anything is found where X moves by ``course`` beside other axes at rest."""
    axes = {}
    for name in f"X{beside}":
        division = fine if name == "X" else DIVISION
        at = 0.5 + (course if name == "X" else 0.0) + SCATTER * rng.normal(size=len(CYCLE))
        axes[name] = Axis(name, np.rint(at / division) * division, resolution=division)
    return diagnose_readings(Run(CYCLE + 1, axes)).verdict is not Verdict.NOTHING


def share(runs: int, course: FloatArray, fine: float, beside: str) -> str:
    """Return the share of tables [%] in which anything is found."""
    rngs = (np.random.default_rng([7, run]) for run in range(runs))
    return f"{100 * sum(is_found(rng, course, fine, beside) for rng in rngs) / runs:.0f}"


def main() -> None:
    """Print a table for each dial of X."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=100)
    runs = parser.parse_args().runs
    for fine in (DIVISION, 0.001):
        print(f"\n| X of {fine:g} mm, found [%] | alone | + Y | + Y, Z | before: + Y | + Y, Z |")
        print("|---|---|---|---|---|---|")
        for name, course in COURSES.items():
            cells = [share(runs, course, fine, beside) for beside in ("", "Y", "YZ")]
            with patch.object(order, "_temper", lambda *_: None):
                cells += [share(runs, course, fine, beside) for beside in ("Y", "YZ")]
            print(f"| {name} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
