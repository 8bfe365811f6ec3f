"""Lost motion, compliance and growth of the joints: how often their intervals hold, and how wide.

Run: python -m benchmarks.joint_columns [SEEDS]. The robots are those of joint_scatter.py; approach
and payload come in random order, the temperature wanders. Each line has, for the lost motion, the
compliance and the growth, the coverage of both joints (of the growth also of the links), the mean
half width of their intervals, and how often a misfit is seen.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from benchmarks.joint_scatter import ARM, ROBOTS, Robot, readings
from scara_iso.diagnosis.joint_scatter import followed_in_joints
from scara_iso.effects import Conditions
from scara_iso.run import FloatArray

SEEDS = 60
SIZES = {
    "lost_motion": {"joint 1": 5e-6, "joint 2": 20e-6},
    "compliance": {"joint 1": 0.0, "joint 2": 10e-6},
    "temperature": {"joint 1": 0.0, "joint 2": 0.0, "along the arm": 12e-6},
}
STAND = 0.002
"""A dial's stand grows along Y by so much a degree [mm]."""
FINE = 1e-9
LINES = (
    "as assumed", "three poses", "15 cycles", "100 cycles", "0.7 divisions",
    "joints together, 0.5", "a third source, 4 um", "tails of t3",
)  # fmt: skip


def conditions(rng: np.random.Generator, n: int) -> Conditions:
    """Return what a test records beside its readings."""
    ways = np.where(np.arange(n) % 2, 1.0, -1.0)
    columns = {
        "approach": rng.permutation(ways),
        "payload_kg": rng.permutation(np.resize([0.0, 1.0, 2.0], n)),
        "temperature_C": 20 + rng.normal(0, 0.5, n).cumsum() / 3,
    }
    return Conditions(np.arange(2, n + 2), columns)


def moved(robot: Robot, recorded: Conditions, odd: float, rng: np.random.Generator) -> FloatArray:
    """Return what the columns do to X and Y (n, P, 2), each pose by a share ``odd`` otherwise."""
    columns = dict(recorded.covariates)
    approach, *others = columns.values()
    payload, temperature = (one - one.mean() for one in others)
    jacobian, places = ARM.jacobian(robot.poses), ARM.forward(robot.poses)
    turns = [
        course[:, np.newaxis] * np.array([SIZES[name]["joint 1"], SIZES[name]["joint 2"]])
        for name, course in (("lost_motion", approach), ("compliance", payload))
    ]
    in_joints = np.einsum("pij,nj->npi", jacobian, sum(turns))
    grown = places * SIZES["temperature"]["along the arm"] + np.array([0.0, STAND])
    shown = in_joints + temperature[:, np.newaxis, np.newaxis] * grown
    return np.asarray(shown * (1 + odd * rng.normal(size=(1, len(places), 1))))


def line(name: str, robot: Robot, seeds: int, odd: float = 0.0) -> str:
    """Return coverage and half width of each effect's sources, and how often a misfit is seen."""
    held: dict[tuple[str, str], list[bool]] = {}
    wide: dict[tuple[str, str], list[float]] = {}
    misfit = []
    division = np.full(2, robot.division)
    for seed in range(seeds):
        rng = np.random.default_rng([9283, seed])
        scatter = np.moveaxis(readings(replace(robot, division=FINE), rng, 1)[0, :-1], 0, 1)
        recorded = conditions(rng, robot.n)
        shown = scatter + moved(robot, recorded, odd, rng)
        shown = np.round(shown / robot.division) * robot.division
        found = followed_in_joints(shown, robot.poses, division, ARM, recorded)
        for one in found:
            misfit.append(one.misfit_p_value < 0.05)
            for source, true in SIZES[one.effect].items():
                size = one.sizes[source]
                held.setdefault((one.effect, source), []).append(
                    size.interval[0] <= true <= size.interval[1]
                )
                wide.setdefault((one.effect, source), []).append(
                    (size.interval[1] - size.interval[0]) / 2
                )
    cells = [_cell(effect, held, wide) for effect in SIZES]
    return f"| {name} | {' | '.join(cells)} | {np.mean(misfit):.0%} |"


def _cell(
    effect: str,
    held: Mapping[tuple[str, str], list[bool]],
    wide: Mapping[tuple[str, str], list[float]],
) -> str:
    return ", ".join(
        f"{np.mean(held[effect, source]):.1%} ±{1e6 * np.mean(wide[effect, source]):.1f}"
        for source in SIZES[effect]
    )


def main(seeds: int = SEEDS) -> None:
    """Print a table, a line for each robot."""
    print(f"{seeds} tests a line; one standard error of 95 % is {np.sqrt(0.0475 / seeds):.1%}")
    print(
        "| | lost motion [urad] | compliance [urad/kg] | growth: joints [urad/K], links [um/m/K] |"
    )
    for name in LINES:
        print(line(name, ROBOTS[name], seeds), flush=True)
    print(line("each pose by 20 % otherwise", Robot(), seeds, odd=0.2))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
