"""The figures of a fleet as a whole: which robots scatter most, and how RP is distributed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from scara_iso.display import Displayed
from scara_iso.fleets.database import Query, results_in
from scara_iso.fleets.drift import FleetDrift, fleet_drift
from scara_iso.fleets.names import (
    NameAlone,
    SeveralNames,
    TwiceThere,
    names_alone,
    robots_alike,
    several_names,
    tables_twice,
)
from scara_iso.fleets.runs import RESULTS, FleetRun
from scara_iso.fleets.summary import (
    LEVEL,
    FailedTable,
    failed_tables,
    quantiles_of_RP,
)
from scara_iso.fleets.work import FIGURES
from scara_iso.frames import frame_of

if TYPE_CHECKING:
    import pandas as pd

_WORST = 100
SUMMARY_MEMORY = "100MB"
"""Less than a part takes: the more tables, the more is on the disk (benchmarks/fleet.py)."""


@dataclass(frozen=True, slots=True)
class RobotFigures:
    """The figures of one robot."""

    robot: str
    """Its name."""
    tables: int
    """How many there are of it."""
    RP: Mapping[str, float | None]
    """By figure, the largest of a pose [mm, deg]; None where it has none."""


@dataclass(frozen=True, eq=False, slots=True)
class FleetFigures(Displayed):
    """The figures of a fleet: those of every pose stand in the files of ``run``."""

    run: FleetRun
    """What became of the parts."""
    tables: int
    """How many have figures."""
    robots: int
    """How many there are of these."""
    worst: tuple[RobotFigures, ...]
    """100 robots at most, by their largest RP: of XY, else of the first axis that is there."""
    RP_quantiles: Mapping[str, tuple[float, ...]]
    """By figure, of the poses: 5, 25, 50, 75 and 95 % [mm, deg]."""
    failed: tuple[FailedTable, ...]
    """Tables of which there is nothing."""
    twice: tuple[TwiceThere, ...]
    """Tests that are there more than once: each counts."""
    drift: FleetDrift | None
    """How RP moves over the dates of the tests; None where no robot has several."""
    names_alone: tuple[NameAlone, ...] = ()
    """Names that stand with a serial number and without."""
    several_names: tuple[SeveralNames, ...] = ()
    """Serial numbers that stand with several names."""
    alike: tuple[tuple[str, ...], ...] = ()
    """Names that differ in case, blanks and zeros in front only, of several robots."""

    def __repr__(self) -> str:
        return f"<FleetFigures of {self.robots} robots: {self.tables} tables>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table, a row for each of the ``worst``."""
        rows = [
            {"robot": one.robot, "tables": one.tables}
            | {f"RP_{name}": one.RP[name] for name in FIGURES}
            for one in self.worst
        ]
        return frame_of(rows, {})

    @property
    def files(self) -> Path:
        """Folder of the figures of every pose, as Parquet."""
        return self.run.folder / RESULTS


def summarise_figures(run: FleetRun) -> FleetFigures:
    """Return the summary of the figures that a run has left in its folder."""
    with results_in(run.folder / RESULTS, SUMMARY_MEMORY) as query:
        robots = query(
            "SELECT count(*) FROM (SELECT DISTINCT robot FROM fleet WHERE error IS NULL)"
        )
        return FleetFigures(
            run=run,
            tables=run.tables,
            robots=robots[0][0] if robots else 0,
            worst=_worst(query),
            RP_quantiles=quantiles_of_RP(query),
            failed=failed_tables(query),
            twice=tables_twice(query, "robot, test, pose"),
            drift=fleet_drift(query, LEVEL),
            names_alone=names_alone(query),
            several_names=several_names(query),
            alike=robots_alike(query),
        )


def _worst(query: Query) -> tuple[RobotFigures, ...]:
    largest = ", ".join(f'max("RP_{name}") AS "RP_{name}"' for name in FIGURES)
    order = "ORDER BY coalesce(RP_XY, RP_X, RP_Y, RP_Z, RP_theta) DESC, robot"
    rows = query(  # a robot's tables are counted of these alone: there may be millions
        f"WITH largest AS (SELECT robot, {largest} FROM fleet WHERE error IS NULL GROUP BY robot), "  # noqa: S608
        f"worst AS (FROM largest {order} LIMIT {_WORST}), "
        "counts AS (SELECT robot, count(DISTINCT (test, part)) AS tables FROM fleet "
        "SEMI JOIN worst USING (robot) WHERE error IS NULL GROUP BY robot) "
        f"SELECT robot, tables, worst.* EXCLUDE robot FROM worst JOIN counts USING (robot) {order}"
    )
    return tuple(
        RobotFigures(robot, tables, dict(zip(FIGURES, RP, strict=True)))
        for robot, tables, *RP in rows
    )
