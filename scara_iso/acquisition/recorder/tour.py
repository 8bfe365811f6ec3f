"""The poses that every cycle visits, in their order, and the numbers of the visits."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from scara_iso.errors import UsageError

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_ .+-]{0,30}")
_MOST = 100


@dataclass(frozen=True, slots=True)
class Tour:
    """``poses`` in the order in which every cycle visits them; none is one pose without a name.

    Visits are numbered from 1 through the whole test: those of cycle 1, of cycle 2, and so on.
    """

    poses: tuple[str, ...] = ()

    def __len__(self) -> int:
        return max(len(self.poses), 1)

    def place(self, visit: int) -> tuple[int, str | None]:
        """Return cycle (from 1) and pose of a visit."""
        turn, k = divmod(visit - 1, len(self))
        return turn + 1, self.poses[k] if self.poses else None

    def visit(self, cycle: int, pose: str | None) -> int:
        """Return the number of a visit; `ValueError` for a pose that is not visited."""
        poses: tuple[str | None, ...] = self.poses or (None,)
        if pose not in poses:
            raise ValueError(f"pose {pose} is none of {', '.join(map(str, poses))}")
        return (cycle - 1) * len(poses) + poses.index(pose) + 1

    def name(self, visit: int) -> str:
        """Return ``cycle 3`` or ``cycle 3 at P2``."""
        cycle, pose = self.place(visit)
        return f"cycle {cycle}" if pose is None else f"cycle {cycle} at {pose}"

    def state(self, visit: int) -> dict[str, int | str]:
        """Return cycle, and pose where poses have names, as a raw file states them."""
        cycle, pose = self.place(visit)
        return {"cycle": cycle} if pose is None else {"cycle": cycle, "pose": pose}


ONE_POSE = Tour()


def parse_poses(poses: str | Sequence[str]) -> tuple[str, ...]:
    """Return the poses of ``P1,P2,P3`` or of a sequence; `UsageError` for what is not a name."""
    names = [n.strip() for n in (poses.split(",") if isinstance(poses, str) else poses)]
    wrong = [name for name in names if not _NAME.fullmatch(name)]
    if wrong or len({name.casefold() for name in names}) < len(names):
        what = f"{wrong[0]!r} is no pose's name" if wrong else "a pose is named twice"
        raise UsageError(
            f"`pose={','.join(names)}`: {what}",
            remedy="name each pose of a cycle once, in their order: `pose=P1,P2,P3,P4,P5`",
        )
    if len(names) > _MOST:
        raise UsageError(f"{len(names)} poses, more than {_MOST}", remedy="record them in parts")
    return tuple(names)
