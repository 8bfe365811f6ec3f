"""How often `diagnose_sweep` alarms on scatter alone, and what it finds.

benchmarks/results/diagnosis.md, section 5.

    python benchmarks/gear.py [--runs 200]

Measured deviations do not come from the fitted formula but from the drive train through time.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from scara_iso.diagnosis import Verdict, gears
from scara_iso.diagnosis.gears import diagnose_sweep
from scara_iso.effects import Sweep

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from oracles.drivetrain import DriveTrain, Move, arrivals
from undeclared.gearbox import GAP, MOTOR, free_motor

SEED = 1
LOADS = {m: np.geomspace(0.5, 12.0, m) for m in (4, 6, 12)}
POWERS = gears.SCATTER_POWERS
KINDS = ("equal", "root", "proportional", "proportional, t3")


def sweep_of(loads):
    """Return the sweep of the paper's first joint with other loads."""
    return Sweep(np.full(len(loads), MOTOR), loads, np.full(len(loads), GAP))


def held_motor(load):
    """Return what lies between the rests after either approach, with friction and a held motor."""
    train = DriveTrain(MOTOR, float(load), GAP, coulomb=300.0)
    side = np.array([1, -1])
    rests = arrivals(train, Move(0.2, 10.0), side, count=2, rng=np.random.default_rng(0))
    return float(rests.load_angle[0] - rests.load_angle[1])


TRUTHS = {
    "rotor through N = 50": ({"reflected_inertia"}, lambda load: free_motor(load, ratio=50)),
    "the same, gap of 18 arcmin": (
        {"reflected_inertia", "gap"},
        lambda load: free_motor(load, ratio=50, gap=1.5 * GAP),
    ),
    "motor held, friction": ({"held_motor"}, held_motor),
    "gap of 18 arcmin": ({"gap"}, lambda load: free_motor(load, gap=1.5 * GAP)),
    "grows as the root of I_L": (set(), lambda load: -1e-4 * load**0.5),
    "largest at a middle I_L": (set(), lambda load: -2e-4 * np.exp(-(np.log(load / 2.4) ** 2))),
}


def spread(true, kind):
    """Return the standard deviations of a scatter of size 1, in root mean squares, or in shares."""
    rms = np.sqrt((true**2).mean())
    match kind:
        case "equal":
            return np.full(len(true), rms)
        case "root":
            return np.sqrt(np.abs(true) * rms)
        case _:
            return np.abs(true)


def scattered(true, kind, size, rng):
    """Return deviations with scatter of a size and a kind."""
    noise = rng.normal(size=len(true))
    if kind.endswith("t3"):
        noise = rng.standard_t(3, size=len(true)) / np.sqrt(3)
    return true + size * spread(true, kind) * noise


def alarms(loads, kind, size, runs):
    """Return how many percent of sweeps of nothing but eq. 16 and scatter are not silent."""
    rng, sweep = np.random.default_rng(SEED), sweep_of(loads)
    found = (
        diagnose_sweep(sweep, scattered(sweep.deviation, kind, size, rng)) for _ in range(runs)
    )
    return 100 * np.mean([one.verdict is not Verdict.NOTHING for one in found])


def print_false_alarms(runs):
    """Print false alarms with the scatter's growth unknown, and with none taken for granted."""
    print(f"False alarms [%], {runs} runs a cell, seed {SEED}: reversals 4 / 6 / 12\n")
    print("| scatter | size | as shipped | equal scatter taken for granted |\n|---|---|---|---|")
    for kind in KINDS:
        for size in (0.05, 0.2):
            cells = []
            for gears.SCATTER_POWERS in (POWERS, (0.0,)):
                counts = [alarms(loads, kind, size, runs) for loads in LOADS.values()]
                cells.append(" / ".join(f"{count:.1f}" for count in counts))
            print(f"| {kind} | {size:.0%} | {cells[0]} | {cells[1]} |", flush=True)
    gears.SCATTER_POWERS = POWERS


def hits(true, expected, loads, *, known, runs):
    """Return percents: found; of these named right, or with a rival, and unexplained."""
    rng, sweep = np.random.default_rng(SEED), sweep_of(loads)
    u = 0.03 * spread(true, "proportional") if known else None
    found = [
        diagnose_sweep(sweep, scattered(true, "proportional", 0.03, rng), uncertainty=u)
        for _ in range(runs)
    ]
    found = [one for one in found if one.verdict is not Verdict.NOTHING]
    named = [
        [{e.effect for e in one.effects}]
        + [set(rival.effect.split("+")) for e in one.effects[:1] for rival in e.rivals]
        for one in found
    ]
    n = max(1, len(found))
    right, among = (sum(expected in names[:k] for names in named) / n for k in (1, None))
    unexplained = sum(one.verdict is Verdict.UNEXPLAINED for one in found) / n
    return [100 * x for x in (len(found) / runs, right, among, unexplained)]


def print_hits(runs):
    """Print what is found of structure that the motion itself gives, and of none known."""
    print(f"\nScatter 3 % of each deviation, {runs} runs a cell, seed {SEED} [%]\n")
    print("| true | reversals | u_rad | found | named right | or as a rival | unexplained |")
    print("|---|---|---|---|---|---|---|")
    for name, (expected, deviation) in TRUTHS.items():
        for m in (6, 12):
            true = np.array([deviation(load) for load in LOADS[m]])
            for known in (True, False):
                cells = hits(true, expected, LOADS[m], known=known, runs=runs)
                said = " | ".join(f"{cell:.0f}" for cell in cells)
                said = said if expected else f"{cells[0]:.0f} | - | - | {cells[3]:.0f}"
                print(f"| {name} | {m} | {'yes' if known else 'no'} | {said} |", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=200)
    args = parser.parse_args()
    began = time.process_time()
    print_hits(max(1, args.runs // 4))
    print_false_alarms(args.runs)
    print(f"\n{time.process_time() - began:.0f} s of one core")
