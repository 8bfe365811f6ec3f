"""What the intervals of a push test hold: joints of other equations, tests/support/push_rig.py.

Run: python benchmarks/push.py. Each line is a joint and a dial; the shares are of tests whose 95 %
interval holds the figure that the joint was made of.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))
import push_rig

from scara_iso.iso9283 import push_test
from scara_iso.signals import ForceLoop

RUNS = 200
JOINTS = {
    "plain": {"stiffness": 500.0, "half_play": 0.02, "friction": 6.0},
    "no play": {"stiffness": 500.0, "half_play": 0.0, "friction": 6.0},
    "no friction": {"stiffness": 500.0, "half_play": 0.02, "friction": 0.0},
    "stiff": {"stiffness": 5000.0, "half_play": 0.005, "friction": 10.0},
}
DIALS = {"0.001 mm, noise 1 um": (0.001, 0.001), "0.01 mm, noise 2 um": (0.01, 0.002)}


def main() -> None:
    """Print the coverage of each figure."""
    for joint, made_of in JOINTS.items():
        c = 1 / made_of["stiffness"]
        play, width = 2 * made_of["half_play"], 2 * c * made_of["friction"]
        truth = {
            "lost_motion": play, "friction_width": width, "hysteresis": play + width,
            "compliance": 100 * c,
        }  # fmt: skip
        for dial, (division, noise) in DIALS.items():
            inside, widths = dict.fromkeys(truth, 0), []
            for seed in range(RUNS):
                rng = np.random.default_rng(seed)
                loop = push_rig.readings(rng, noise=noise, division=division, **made_of)
                found = push_test(ForceLoop(*loop, resolution=division))
                for code, value in truth.items():
                    low, high = found.estimate(code, "reading").interval or (0.0, 0.0)
                    inside[code] += low <= value <= high
                widths.append(found.estimate("lost_motion", "reading").u or 0.0)
            said = ", ".join(f"{code} {n / RUNS:.0%}" for code, n in inside.items())
            u = 1000 * np.median(widths)
            print(f"{joint}, dial {dial}: {said}; u of lost motion {u:.2g} um")


if __name__ == "__main__":
    main()
