"""What ``diagnose`` takes and writes beside its tables, and what of it goes together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from scara_iso import render
from scara_iso.base.disk import check_output
from scara_iso.base.errors import UsageError
from scara_iso.cli.options import parse_limits

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
    limit: Sequence[str] | None
    sigma: float | None

    def under(self, condition: str) -> Files:
        """Return these for one condition of a test, each of which has a map of its own."""
        if self.map is None:
            return self
        named = self.map.with_name(f"{self.map.stem}-{condition}{self.map.suffix}")
        check_output(named)
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
        for option, value in {"--map": self.map, "--limit": self.limit}.items():
            if value is not None and self.model is None:
                raise UsageError(
                    f"{option} needs --model",
                    remedy="name one that gives links and [pose.P1] joint_deg",
                )
        self.limit_of_plane()
        if self.map is not None:
            render.check_map(self.map)

    def limit_of_plane(self) -> float | None:
        """Return the limit of RP in XY in mm; `UsageError` for another one."""
        given = parse_limits(self.limit or ())
        if set(given) - {"", "XY"}:
            raise UsageError(
                f"--limit {min(set(given) - {'', 'XY'})}: the map is of RP in XY",
                remedy="write --limit XY=0.02",
            )
        return next(iter(given.values()), None)

    def refuse_of_test(self) -> None:
        """Raise `UsageError` where something is wanted that unrelated tables do not give."""
        asked = {"--hold-out": self.hold_out, "--map": self.map, "--limit": self.limit}
        _refuse(asked, "is for one test", "name its tables by their poses, P1.csv P2.csv")

    def check_poses(self, run: Run) -> None:
        """Raise `UsageError` where what is held out is neither a pose of ``run`` nor a file."""
        from scara_iso.library import held_out_pose
        from scara_iso.run import no_such_pose

        second = self.hold_out is not None and held_out_pose(run, self.hold_out) is None
        if second and not Path(self.hold_out or "").exists():
            labels = (label for label, _ in run.rows_by_pose())
            raise no_such_pose(self.hold_out or "", labels, run.origin.source)


def _refuse(given: Mapping[str, object], what: str, remedy: str) -> None:
    for option, value in given.items():
        if value is not None:
            raise UsageError(f"{option} {what}", remedy=remedy)


def refuse_beside_design(files: Files) -> None:
    """Raise `UsageError` where something is wanted that needs readings."""
    given = {
        "--hold-out": files.hold_out,
        "--save-model": files.save_model,
        "--plot": files.plot,
        "--map": files.map,
        "--limit": files.limit,
    }
    _refuse(given, "does not go with --design", "leave it out")
