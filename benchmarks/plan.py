"""Plan tests for several arms: how long it takes, and what benchmarks/results/model.md shows of it.

``python -m benchmarks.plan [--write]``.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from benchmarks.page import DOCS, RESULTS, run
from scara_iso.iso9283.poses import Solid, make_plan
from scara_iso.render.plots import save_figure
from scara_iso.robot.arm import Arm

# the paper gives link 1 + link 2 = 0.7 m (eq. 21); the split, limits and stroke are assumed
FUM = Arm(400, 300, (-130, 130), (-145, 145), (0, 200))
ARMS = {
    "FUM SCARA, split and limits assumed": FUM,
    "asymmetric limits": Arm(225, 375, (-60, 160), (-30, 150), (0, 150)),
    "big inner hole": Arm(500, 200, (-180, 180), (-120, 120), (0, 300)),
    "joint 2 beyond a half turn": Arm(400, 300, (-130, 130), (-225, 225), (-100, 100)),
}


def timings() -> Iterator[str]:
    """Yield size and time of the cube and the box of each arm."""
    yield "| arm | cube [mm] | box [mm] | processor time, cube [s] | box [s] |"
    yield "|---|---|---|---|---|"
    make_plan(FUM, solid=Solid.BOX)  # loads scipy
    for name, arm in ARMS.items():
        sizes, times = [], []
        for solid in Solid:
            begin = time.process_time()
            plan = make_plan(arm, solid=solid)
            times.append(f"{time.process_time() - begin:.2f}")
            sizes.append(" × ".join(f"{s:.3f}" for s in plan.size_mm))
        yield f"| {name} | {' | '.join(sizes + times)} |"


def poses() -> Iterator[str]:
    """Yield the poses of the paper's robot."""
    keys = ("x_mm", "y_mm", "z_mm", "joint_1_deg", "joint_2_deg", "joint_3_mm", "joint_4_deg",
            "singularity_deg")  # fmt: skip
    yield "| visit | pose | " + " | ".join(keys) + " |"
    yield "|---|---" + "|---" * len(keys) + "|"
    for row in make_plan(FUM).rows():
        numbers = " | ".join(f"{row[key]:.3f}" for key in keys)
        yield f"| {row['visit']} | {row['pose']} | {numbers} |"


def picture() -> Iterator[str]:
    """Draw the plan of the paper's robot and yield the line that shows it."""
    path = DOCS / "figures" / "plan_fum.svg"
    path.parent.mkdir(parents=True, exist_ok=True)
    save_figure(make_plan(FUM).plot(), path)
    yield "![Workspace, cube, plane and poses](../../docs/figures/plan_fum.svg)"


PARTS: dict[str, Callable[[], Iterator[str]]] = {
    "plan timings": timings,
    "plan poses": poses,
    "plan picture": picture,
}

if __name__ == "__main__":
    run(PARTS, RESULTS / "model.md", __doc__)
