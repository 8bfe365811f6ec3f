"""What is found of a fleet as a whole: which robots stand out, though all were looked at.

Of 10,000 healthy robots 500 would be alarms at 5 %. So the robots are judged together: the false
discovery rate, the share of false ones among those that are named, is held (Benjamini and Hochberg
1995). A robot's p-value is the smallest of its tests times their number.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scara_iso.display import Displayed
from scara_iso.fleets.database import Query, results_in
from scara_iso.fleets.drift import FleetDrift, fleet_drift, quantiles_of_rows
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
from scara_iso.fleets.work import FIGURES
from scara_iso.frames import frame_of
from scara_iso.published import Count

if TYPE_CHECKING:
    import pandas as pd

LEVEL = 0.05


@dataclass(frozen=True, slots=True)
class RobotFinding:
    """What is published of one robot."""

    robot: str
    """Its name."""
    tables: Count
    """How many there are of it."""
    p_value: float
    """Smallest of its tables times their number, 1 at most."""
    q_value: float
    """Smallest false discovery rate at which it is named."""
    found: bool
    """Whether it is named at the level asked for."""
    effects: tuple[str, ...]
    """What its tables show, each once."""
    RP_XY: float | None
    """Largest of its tables [mm]; null without X and Y."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotResult(RobotFinding):
    """What is found of one robot."""

    p_value_at_floor: bool
    """Nothing drawn came as far as that table: the p-value is a bound."""


@dataclass(frozen=True, slots=True)
class FailedTable:
    """A table of which there is nothing, and why."""

    part: str
    """The file that it stands in."""
    robot: str
    """Whose it is; empty where nothing says so."""
    test: str
    """Which of the robot's tests; empty where nothing says so."""
    error: str
    """Why."""


@dataclass(frozen=True, eq=False, slots=True)
class FleetSummary(Displayed):
    """The fleet: robots by how far they stand out, effects by how many robots show them."""

    run: FleetRun
    """What became of the parts."""
    level: float
    """False discovery rate."""
    tables: int
    """How many were diagnosed."""
    robots: tuple[RobotResult, ...]
    """The worst first: by q-value, then by RP in XY."""
    effects: Mapping[str, int]
    """Robots that are named, by effect, the most frequent first."""
    RP_quantiles: Mapping[str, tuple[float, ...]]
    """By figure, of its tables: 5, 25, 50, 75 and 95 % [mm, deg]."""
    failed: tuple[FailedTable, ...]
    """Tables of which there is nothing."""
    twice: tuple[TwiceThere, ...] = ()
    """Tests that are there more than once: each counts."""
    drift: FleetDrift | None = None
    """How RP moves over the dates of the tests; None where no robot has several."""
    names_alone: tuple[NameAlone, ...] = ()
    """Names that stand with a serial number and without."""
    several_names: tuple[SeveralNames, ...] = ()
    """Serial numbers that stand with several names."""
    alike: tuple[tuple[str, ...], ...] = ()
    """Names that differ in case, blanks and zeros in front only, of several robots."""

    @property
    def found(self) -> tuple[RobotResult, ...]:
        """The robots that are named."""
        return tuple(one for one in self.robots if one.found)

    @property
    def undecided(self) -> tuple[RobotResult, ...]:
        """Robots not named though nothing drawn came as far as they do: too little was drawn.

        `closer` draws more orders of the cycles, not more isolated readings or levels.
        """
        alone = (one for one in self.robots if one.p_value <= self.level and not one.found)
        return tuple(one for one in alone if one.p_value_at_floor)

    @property
    def too_coarse(self) -> bool:
        """Whether some robot may be ill and could not be named."""
        return bool(self.undecided)

    def __repr__(self) -> str:
        return f"<FleetSummary of {len(self.robots)} robots: {len(self.found)} found>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table, a row for each robot, the worst first."""
        rows = [
            {
                "robot": one.robot,
                "tables": one.tables,
                "p_value": one.p_value,
                "q_value": one.q_value,
                "found": one.found,
                "effects": ", ".join(one.effects),
                "RP_XY": one.RP_XY,
            }
            for one in self.robots
        ]
        return frame_of(rows, {})


def summarise(run: FleetRun, level: float = LEVEL) -> FleetSummary:
    """Return the summary of the results that a run has left in its folder."""
    with results_in(run.folder / RESULTS) as query:
        robots = _robots(query, level)
        return FleetSummary(
            run=run,
            level=level,
            tables=sum(row[0] for row in query("SELECT count(*) FROM fleet WHERE error IS NULL")),
            robots=robots,
            effects=_effects(robots),
            RP_quantiles=quantiles_of_RP(query),
            failed=failed_tables(query),
            twice=tables_twice(query),
            drift=fleet_drift(query, level),
            names_alone=names_alone(query),
            several_names=several_names(query),
            alike=robots_alike(query),
        )


def _robots(query: Query, level: float) -> tuple[RobotResult, ...]:
    rows = query(
        "SELECT robot, count(*), least(min(p_value) * count(*), 1.0), "
        "arg_min(at_floor, p_value), "
        "string_agg(effects, ',' ORDER BY p_value), max(RP_XY) "
        "FROM fleet WHERE p_value IS NOT NULL GROUP BY robot ORDER BY robot"
    )
    if not rows:
        return ()
    from scipy.stats import false_discovery_control  # noqa: PLC0415 - scipy for fleets only

    q_values = false_discovery_control([row[2] for row in rows], method="bh")
    found = [
        RobotResult(
            robot,
            tables,
            p,
            float(q),
            bool(q <= level),
            _names(effects),
            RP,
            p_value_at_floor=at_floor,
        )
        for (robot, tables, p, at_floor, effects, RP), q in zip(rows, q_values, strict=True)
    ]
    return tuple(sorted(found, key=lambda one: (one.q_value, -(one.RP_XY or 0.0), one.robot)))


def _names(effects: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for name in effects.split(",") if name))


def _effects(robots: tuple[RobotResult, ...]) -> dict[str, int]:
    counts: dict[str, int] = {}
    for name in (name for one in robots if one.found for name in one.effects or ("unknown",)):
        counts[name] = counts.get(name, 0) + 1
    return dict(sorted(counts.items(), key=lambda pair: (-pair[1], pair[0])))


def failed_tables(query: Query) -> tuple[FailedTable, ...]:
    """Return the tables of which there is nothing."""
    rows = query(
        "SELECT part, robot, test, error FROM fleet WHERE error IS NOT NULL "
        "ORDER BY part, robot, test"
    )
    return tuple(FailedTable(*row) for row in rows)


def quantiles_of_RP(query: Query) -> dict[str, tuple[float, ...]]:  # noqa: N802 - the symbol
    """Return 5, 25, 50, 75 and 95 % of each RP that is there; the values are sorted on the disk."""
    found: dict[str, tuple[float, ...]] = {}
    for name in FIGURES:
        query(
            f'CREATE OR REPLACE TEMP TABLE sorted AS SELECT "RP_{name}" AS RP FROM fleet '  # noqa: S608
            "WHERE isfinite(RP) ORDER BY RP"
        )
        count = sum(row[0] for row in query("SELECT count(*) FROM sorted"))
        if count:
            found[name] = quantiles_of_rows(query, 0, count)
    return found
