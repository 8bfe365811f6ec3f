"""What five poses tell of the joints: found, the right joint, false alarms, by simulation.

    python benchmarks/joints.py [--runs 12] [--seed 1] [--shuffles 199] [--only CELL] [--beside]
        [--separating]

Links of 250 and 200 mm, joint scatter of 10 and 15 microradians, 1.5 um of each dial's own, dials
of 1 um, 30 cycles. Sizes of joint effects are in that joint's scatter; a change comes after any
cycle from 8 to 22, a warm-up has a time constant of 3 to 10 cycles. Beside the search stand the
same test without the arm (all axes) and of each pose alone with Holm's rule. ``--separating`` takes
the poses that ``plan --separating`` proposes for this arm.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np

import scara_iso.diagnosis.engine.search as search_module
from scara_iso.diagnosis import (
    AllPoses,
    PlannedPosesTest,
    design_of_poses,
    separating_plan,
    whole_cycles,
)
from scara_iso.diagnosis.engine.fit import problem_of, problem_of_poses
from scara_iso.diagnosis.engine.order import order_test
from scara_iso.diagnosis.engine.search import chosen, find
from scara_iso.effects import Conditions, find_effects
from scara_iso.iso9283 import PoseTestConditions
from scara_iso.robot import Arm, Rated
from scara_iso.run import Axis, FloatArray, Run

ARM = Arm(250, 200)
JOINTS: dict[str, tuple[float, float]] = {
    "P1": (10, 80),
    "P2": (-30, 110),
    "P3": (45, 60),
    "P4": (-50, 60),
    "P5": (60, 110),
}
STRAIGHT = {pose: (q_1, 2) for pose, (q_1, _) in JOINTS.items()}
SCATTER = np.array([10e-6, 15e-6])
OWN, DIVISION, N = 0.0015, 0.001, 30
LEVEL = 0.05
Law = Callable[[np.random.Generator, tuple[int, ...]], FloatArray]


def normal(rng: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
    """Return Gaussian scatter of deviation 1."""
    return rng.normal(size=shape)


def t3(rng: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
    """Return Student's t with 3 degrees of freedom, scaled to deviation 1."""
    return rng.standard_t(3, size=shape) / 3**0.5


def course(kind: str, rng: np.random.Generator) -> FloatArray:
    """Return a course of unit size, shape (30,)."""
    k = np.arange(N)
    if kind == "step":
        return (k >= rng.integers(8, 23)) * 1.0
    return 1 - np.exp(-k / rng.uniform(3, 10)) if kind == "warm_up" else np.zeros(N)


def simulated(
    rng: np.random.Generator,
    *,
    kind: str = "",
    moved: FloatArray | None = None,
    joint: int = 0,
    size: float = 0.0,
    joints: dict[str, tuple[int, int]] = JOINTS,
    common: float = 0.0,
    law: Law = normal,
) -> AllPoses:
    """Return a test with a course in a ``joint``, or ``moved`` (5, 2) mm at the poses.

    ``common`` is the share of the joints' variance that all visits of a cycle have in common.
    """
    q = np.sqrt(1 - common) * law(rng, (5, N, 2)) + np.sqrt(common) * law(rng, (1, N, 2))
    c = course(kind, rng)
    if joint:
        q[:, :, joint - 1] += size * c
    jacobian = ARM.jacobian([*joints.values()])
    xy = np.einsum("pij,pnj->pni", jacobian, q * SCATTER) + OWN * law(rng, (5, N, 2))
    if moved is not None:
        xy += c[:, np.newaxis] * moved[:, np.newaxis]
    xy = np.round(xy / DIVISION) * DIVISION
    axes = {a: Axis(a, xy[:, :, i].ravel(), resolution=DIVISION) for i, a in enumerate("XY")}
    run = Run(np.tile(np.arange(2, N + 2), 5), axes, pose=np.repeat([*joints], N))
    return whole_cycles(run, {str(pose): rows for pose, rows in run.rows_by_pose()})


def searched(test: AllPoses, joints: dict[str, tuple[int, int]] = JOINTS) -> str | None:
    """Return the place of the first effect found, ``?`` where it is not sure, None for none."""
    problem = problem_of_poses(test, arm=ARM, joints_deg=joints)
    terms, stages = find(problem, np.random.default_rng(9283), level=LEVEL)
    if stages[0].choice is None:
        return None
    located = terms[0].located if terms else None
    return located.place.name if located is not None and located.is_sure else "?"


def on_axes(test: AllPoses) -> bool:
    """Return whether the same test finds structure without the arm."""
    stage, _ = chosen(problem_of_poses(test), (), np.random.default_rng(9283), 0.0)
    return stage.p_value <= LEVEL


def each_pose(test: AllPoses) -> bool:
    """Return whether any pose alone shows structure by Holm's rule."""
    known = tuple(find_effects())
    for part in test.parts.values():
        problem = problem_of(part, directions={}, effects=known)
        stage, _ = chosen(problem, (), np.random.default_rng(9283), 0.0)
        if stage.p_value <= LEVEL / len(test.parts):
            return True
    return False


def power(runs: int, seed: int, kind: str, size: float, *, beside: bool) -> Iterator[str]:
    """Yield the row of each joint: found and rightly named, and found by the others."""
    for joint in (1, 2):
        places, others = [], []
        for k in range(runs):
            test = simulated(np.random.default_rng([seed, k]), kind=kind, joint=joint, size=size)
            places.append(searched(test))
            if beside:
                others.append((each_pose(test), on_axes(test)))
        found = [place for place in places if place is not None]
        cells = [f"{100 * np.mean(one):.0f}" for one in zip(*others, strict=True)] or ["-", "-"]
        yield (
            f"| {kind} {size:g}, joint {joint} | {cells[0]} | {cells[1]} | "
            f"{100 * len(found) / runs:.0f} | {_named(found, f'joint {joint}')} |"
        )


def _named(found: list[str], right: str) -> str:
    """Return shares of the found: right place, no place, another joint, another place."""
    joint = [p for p in found if p.startswith("joint ") and p != right]
    unsure = found.count("?")
    other = len(found) - found.count(right) - unsure - len(joint)
    counts = (found.count(right), unsure, len(joint), other)
    return " | ".join(f"{100 * count / max(1, len(found)):.0f}" for count in counts)


def alarms(runs: int, seed: int) -> Iterator[str]:
    """Yield how often structure is found in scatter alone."""
    cells = {
        "Gaussian": {}, "half in common to a cycle": {"common": 0.5},
        "Student t3": {"law": t3}, "t3, half in common": {"law": t3, "common": 0.5},
    }  # fmt: skip
    for name, how in cells.items():
        tests = [simulated(np.random.default_rng([seed, k]), **how) for k in range(runs)]
        yield f"| {name} | {100 * np.mean([searched(test) is not None for test in tests]):.1f} |"


def elsewhere(runs: int, seed: int) -> Iterator[str]:
    """Yield where effects outside the joints are put."""
    slip = np.zeros((5, 2))
    slip[2] = 0.012, -0.006
    dial = np.tile([0.0, 0.004], (5, 1))
    growth = 12e-6 * ARM.forward([*JOINTS.values()])
    for name, right, kind, moved in (
        ("slip of 13 um at P3", "P3", "step", slip),
        ("4 um in Y everywhere", "Y everywhere", "step", dial),
        ("links grow by 12 um/m", "along the arm", "warm_up", growth),
    ):
        places = [
            searched(simulated(np.random.default_rng([seed, k]), kind=kind, moved=moved))
            for k in range(runs)
        ]
        found = [place for place in places if place is not None]
        joint = sum(place.startswith("joint") for place in found)
        yield (
            f"| {name} | {100 * len(found) / runs:.0f} | {_share(found, right)} | "
            f"{_share(found, '?')} | {100 * joint / max(1, len(found)):.0f} |"
        )
    tests = (
        simulated(np.random.default_rng([seed, k]), kind="step", joint=2, size=2, joints=STRAIGHT)
        for k in range(runs)
    )
    found = [place for test in tests if (place := searched(test, STRAIGHT)) is not None]
    joint = sum(place.startswith("joint") for place in found)
    yield (
        f"| step 2 in joint 2, arm straight | {100 * len(found) / runs:.0f} | - | "
        f"{_share(found, '?')} | {100 * joint / max(1, len(found)):.0f} |"
    )


def designed(runs: int, seed: int) -> Iterator[str]:
    """Yield how many effects are found of the size at which ``--design`` promises 80 %."""
    variances = np.array([*SCATTER**2, OWN**2, 0.0])
    cycles = Conditions(np.arange(2, N + 2), {})
    plan = PlannedPosesTest(cycles, ARM, JOINTS, variances, (DIVISION, DIVISION))
    for (joint, smallest), kind in product(design_of_poses(plan).smallest.items(), KINDS):
        number = int(joint[-1])
        size = (smallest[kind] or 0.0) / SCATTER[number - 1]
        tests = (
            simulated(np.random.default_rng([seed, k]), kind=kind, joint=number, size=size)
            for k in range(runs)
        )
        found = np.mean([searched(test) is not None for test in tests])
        yield f"| {kind} {size:.2f}, {joint} | {100 * found:.0f} |"


def _share(found: list[str], name: str) -> str:
    return f"{100 * found.count(name) / max(1, len(found)):.0f}"


def _separating_poses() -> dict[str, tuple[float, float]]:
    """Return the poses that are proposed for this arm."""
    arm = replace(ARM, joint_2_deg=(-145, 145))
    plan = separating_plan(arm, {}, conditions=PoseTestConditions(), rated=Rated())
    return {one.name: (one.joint_1_deg, one.joint_2_deg) for one in plan.poses}


def write_example(path: Path, seed: int) -> None:
    """Write the example: joint 2 is worn and gives way by 40 microradians."""
    test = simulated(np.random.default_rng(seed), kind="step", joint=2, size=40e-6 / SCATTER[1])
    head = [
        "# unit: mm", "# resolution: 0.001", "# robot: SCARA 450", "# first_cycle_discarded: true",
        f"# simulated: benchmarks/joints.py --example, seed {seed}", "pose,cycle,X,Y",
    ]  # fmt: skip
    rows = [
        f"{pose},{k + 2}," + ",".join(f"{part.axes[a].readings[k]:.3f}" for a in "XY")
        for k in range(N)
        for pose, part in test.parts.items()
    ]
    path.write_text("\n".join([*head, *rows, ""]), encoding="utf-8")


KINDS = ("step", "warm_up")
POWER = {"step1": ("step", 1.0), "step1.5": ("step", 1.5), "warm1.5": ("warm_up", 1.5),
         "warm2": ("warm_up", 2.0)}  # fmt: skip


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=12)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=[*POWER, "alarms", "elsewhere", "design"])
    parser.add_argument("--shuffles", type=int, default=199)
    parser.add_argument("--example", type=Path, help="write the table of docs/joints.md")
    parser.add_argument("--beside", action="store_true", help="the other two tests as well")
    parser.add_argument(
        "--separating", action="store_true", help="at the poses of plan --separating"
    )
    given = parser.parse_args()
    JOINTS.update(_separating_poses() if given.separating else {})
    if given.example:
        write_example(given.example, given.seed)
        return
    search_module.order_test = partial(
        order_test, permutations=given.shuffles
    )  # exact with any number
    for cell, (kind, size) in POWER.items():
        if given.only in (None, cell):
            for row in power(given.runs, given.seed, kind, size, beside=given.beside):
                print(row, flush=True)
    for cell, rows in {"alarms": alarms, "elsewhere": elsewhere, "design": designed}.items():
        if given.only in (None, cell):
            for row in rows(given.runs, given.seed):
                print(row, flush=True)


if __name__ == "__main__":
    main()
