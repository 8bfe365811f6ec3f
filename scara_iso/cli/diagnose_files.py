"""What ``diagnose`` takes and writes beside its tables, and what of it goes together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from scara_iso import render
from scara_iso.errors import UsageError
from scara_iso.frozen import dataclass

if TYPE_CHECKING:
    from scara_iso.run import Run


@dataclass(frozen=True, slots=True)
class Files:
    """What the diagnosis of one test takes and writes beside it."""

    model: str | None
    effects: str | None
    hold_out: str | None
    save_model: Path | None
    plot: Path | None
    map: Path | None
    sigma: float | None

    def under(self, condition: str) -> Files:
        """Return these for one condition of a test, each of which has a map of its own."""
        if self.map is None:
            return self
        named = self.map.with_name(f"{self.map.stem}-{condition}{self.map.suffix}")
        return replace(self, map=named)

    def check(self, tables: Sequence[str]) -> None:
        """Raise `UsageError` where this does not go with the tables that are named."""
        single = {"--save-model": self.save_model, "--plot": self.plot, "--sigma": self.sigma}
        if not tables:
            raise UsageError("no table is named", remedy="name one, or ask for --design")
        if len(tables) > 1:
            _refuse(single, "is for one table", "diagnose the tables one by one")
        if self.save_model is not None and self.model is None:
            raise UsageError("--save-model needs --model", remedy="name the one to add to")
        if self.map is not None and self.model is None:
            raise UsageError(
                "--map needs --model", remedy="name one that gives links and [pose.P1] joint_deg"
            )
        if self.map is not None:
            render.check_map(self.map)

    def refuse_of_test(self) -> None:
        """Raise `UsageError` where something is wanted that unrelated tables do not give."""
        asked = {"--hold-out": self.hold_out, "--map": self.map}
        _refuse(asked, "is for one test", "name its tables by their poses, P1.csv P2.csv")

    def check_poses(self, run: Run) -> None:
        """Raise `UsageError` where something goes with one pose and ``run`` holds several."""
        from scara_iso.library import held_out_pose

        labels = [label for label, _ in run.rows_by_pose()]
        second = self.hold_out is not None and held_out_pose(run, self.hold_out) is None
        if second and not Path(self.hold_out or "").exists():
            raise UsageError(
                f"no pose {self.hold_out!r} in {run.origin.source}",
                remedy=f"it has {', '.join(map(str, labels[:20]))}",
            )
        given = {"--hold-out": second or None, "--plot": self.plot, "--sigma": self.sigma}
        what = f"is for one pose, and there are {len(labels)}"
        _refuse(given, what, f"name it: --pose {labels[0]}")


def _refuse(given: Mapping[str, object], what: str, remedy: str) -> None:
    for option, value in given.items():
        if value is not None:
            raise UsageError(f"{option} {what}", remedy=remedy)


def refuse_beside_design(files: Files) -> None:
    """Raise `UsageError` where something is wanted that needs readings."""
    given = {
        "--model": files.model, "--hold-out": files.hold_out, "--save-model": files.save_model,
        "--plot": files.plot, "--map": files.map,
    }  # fmt: skip
    _refuse(given, "does not go with --design", "leave it out")
