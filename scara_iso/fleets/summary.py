"""What is found of a fleet as a whole, as it is published.

Which robots stand out, corrected for their number: of 10,000 healthy robots 500 would be alarms at
5 %. So the robots are judged together: the false discovery rate, the share of false ones among
those that are named, is held (Benjamini and Hochberg 1995). A robot's p-value is the smallest of
its tests times their number. Or, of the figures alone, which robots scatter most.

And what both have: how RP is distributed and moves, and names that leave open whose a table is.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from scara_iso.base.displayed import Displayed
from scara_iso.base.published import INTERNAL, Count, fill, published, row_of
from scara_iso.fleets.database import Query, results_in
from scara_iso.fleets.drift import QUANTILES, FleetDrift, fleet_drift, quantiles
from scara_iso.fleets.runs import FIGURES, RESULTS, Figure, FleetRun
from scara_iso.run import frame_of

if TYPE_CHECKING:
    import pandas as pd

LEVEL = 0.05
_WORST = 100


@dataclass(frozen=True, slots=True)
class TwiceThere:
    """A test of a robot that several tables claim to be."""

    robot: str
    """Its name."""
    test: str
    """Which of its tests."""
    parts: tuple[str, ...]
    """The files that hold it."""


@dataclass(frozen=True, slots=True)
class NameAlone:
    """A robot's name that stands with a serial number in some tables, and alone in others."""

    name: str
    """As it is stated."""
    serial_numbers: tuple[str, ...]
    """With which it stands: of one, the tables with the name alone are counted to it."""
    tables: int
    """How many have the name alone."""


@dataclass(frozen=True, slots=True)
class SeveralNames:
    """A robot whose serial number stands with several names, as where it is no number at all."""

    robot: str
    """Its serial number."""
    names: tuple[str, ...]
    """With which it stands: all are taken for one robot."""


@dataclass(frozen=True, slots=True)
class NamesAndNumbers:
    """Robots stated by name alone beside robots stated by serial number alone: each may be both."""

    names: Count
    """How many are stated by a name with which no serial number stands."""
    serial_numbers: Count
    """How many are stated by a serial number with which no name stands."""
    such_as: tuple[str, str]
    """One of these names and one of these serial numbers."""


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


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotResult:
    """What is found of one robot."""

    robot: str
    """Its name."""
    tables: Count
    """How many there are of it."""
    p_value: float
    """Smallest of its tests times their number, 1 at most."""
    p_value_at_floor: bool = field(metadata=INTERNAL)
    """Nothing drawn came as far as that table: the p-value is a bound."""
    q_value: float
    """Smallest false discovery rate at which it is named."""
    found: bool
    """Whether it is named at the level asked for."""
    effects: tuple[str, ...]
    """What its tables show, each once."""
    RP_XY: float | None
    """Largest of its tables [mm]; None without X and Y."""
    test: str
    """Which of its tests stands out most."""


@dataclass(frozen=True, slots=True)
class RobotFigures:
    """The figures of one robot."""

    robot: str
    """Its name."""
    tables: Annotated[int, ("minimum", 1)]
    """How many there are of it."""
    RP: Mapping[Figure, float | None]
    """By figure, the largest of a pose [mm, deg]; null where it has none."""


Five: TypeAlias = Annotated[tuple[float, ...], ("minItems", 5), ("maxItems", 5)]


def as_text(path: Path) -> str:
    """Return a path as it is written."""
    return str(path)


@dataclass(frozen=True, kw_only=True)
class FleetRemarks:
    """What of the tables is to be known."""

    twice: tuple[TwiceThere, ...]
    """Tests that are there more than once: each counts."""
    names_alone: tuple[NameAlone, ...]
    """Names that stand with a serial number and without."""
    several_names: tuple[SeveralNames, ...]
    """Serial numbers that stand with several names."""
    names_and_numbers: NamesAndNumbers | None
    """Names and serial numbers of which no table has both; null where it is one kind."""
    alike: tuple[tuple[str, ...], ...]
    """Names that differ in case, blanks and zeros in front only, of several robots."""
    failed: tuple[FailedTable, ...]
    """Tables of which there is nothing."""
    drift: FleetDrift | None
    """How RP moves over the dates of the tests; null where no robot has several."""


@dataclass(frozen=True, eq=False, kw_only=True)
class FleetSummary(FleetRemarks, Displayed):
    """The fleet: robots by how far they stand out, effects by how many robots show them."""

    schema: Literal["scara-iso/fleet/1"] = "scara-iso/fleet/1"
    """Name and number of this schema."""
    unit: Literal["mm"] = "mm"
    """Of every length."""
    folder: str = field(init=False)
    """Where the results stand."""
    run: FleetRun = field(metadata=published("parts"))
    """What became of them."""
    tables: Count
    """How many were diagnosed."""
    level: float = field(metadata=published("false_discovery_rate"))
    """At which robots are named."""
    too_coarse: bool = field(init=False, metadata=published("found_too_coarse"))
    """Whether a robot may be ill and too little was drawn to name it."""
    effects: Mapping[str, Count]
    """Robots that are named, by effect, the most frequent first."""
    RP_quantiles: Mapping[str, Five]
    """By figure, of the tables [mm, deg]."""
    quantiles: tuple[float, ...] = QUANTILES
    """Which these are."""
    robots: tuple[RobotResult, ...]
    """The worst first: by q-value, then by RP in XY."""

    def __post_init__(self) -> None:
        fill(self, folder=str(self.run.folder), too_coarse=bool(self.undecided))

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

    def __repr__(self) -> str:
        return f"<FleetSummary of {len(self.robots)} robots: {len(self.found)} found>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table, a row for each robot, the worst first."""
        return frame_of([*map(row_of, self.robots)], {})


@dataclass(frozen=True, eq=False, kw_only=True)
class FleetFigures(FleetRemarks, Displayed):
    """The figures of a fleet: those of every pose stand in the files of ``run``."""

    schema: Literal["scara-iso/fleet-figures/1"] = "scara-iso/fleet-figures/1"
    """Name and number of this schema."""
    unit: Literal["mm"] = "mm"
    """Of every length."""
    folder: str = field(init=False)
    """Where the results stand."""
    files: Path = field(init=False, metadata=published(by=as_text))
    """Folder of the figures of every pose, as Parquet."""
    run: FleetRun = field(metadata=published("parts"))
    """What became of them."""
    tables: Count
    """How many have figures."""
    robots: Count
    """How many there are of these."""
    RP_quantiles: Mapping[str, Five]
    """By figure, of the poses [mm, deg]."""
    quantiles: tuple[float, ...] = QUANTILES
    """Which these are."""
    worst: Annotated[tuple[RobotFigures, ...], ("maxItems", _WORST)]
    """By their largest RP: of XY, else of the first axis that is there."""

    def __post_init__(self) -> None:
        fill(self, folder=str(self.run.folder), files=self.run.folder / RESULTS)

    def __repr__(self) -> str:
        return f"<FleetFigures of {self.robots} robots: {self.tables} tables>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table, a row for each of the ``worst``."""
        return frame_of([*map(row_of, self.worst)], {})


# ---- from the results

_FAILED = (
    "SELECT part, robot, test, error FROM fleet WHERE error IS NOT NULL ORDER BY part, robot, test"
)
_NAMES_ALONE = (
    "WITH alone AS (SELECT name, count(DISTINCT (test, part)) AS tables FROM fleet "
    "SEMI JOIN named USING (name) WHERE as_read = name AND error IS NULL GROUP BY name) "
    "SELECT name, list(serial ORDER BY serial), any_value(tables) FROM named "
    "JOIN alone USING (name) GROUP BY name ORDER BY name"
)
_SEVERAL_NAMES = (
    "WITH several AS (SELECT robot FROM fleet WHERE error IS NULL GROUP BY robot "
    "HAVING min(name) <> max(name)) SELECT robot, list(DISTINCT name ORDER BY name) FROM fleet "
    "SEMI JOIN several USING (robot) WHERE error IS NULL AND name IS NOT NULL "
    "GROUP BY robot ORDER BY robot"
)
_NAMES_AND_NUMBERS = (
    "WITH alone AS (SELECT as_read, bool_or(name IS NULL) AS number FROM fleet "
    "WHERE error IS NULL AND coalesce(name, as_read) = as_read "
    "GROUP BY as_read HAVING bool_or(name IS NULL) = bool_and(name IS NULL)), "
    "apart AS (FROM alone WHERE as_read NOT IN "
    "(SELECT name FROM named UNION ALL SELECT serial FROM named)) "
    "SELECT count(*) FILTER (NOT number) AS names, count(*) FILTER (number) AS numbers, "
    "[min(as_read) FILTER (NOT number), min(as_read) FILTER (number)] FROM apart "
    "HAVING names > 0 AND numbers > 0"
)
_ALIKE = (
    "WITH every AS (SELECT DISTINCT robot, unnest([robot, name]) AS said FROM fleet "
    "WHERE error IS NULL) SELECT list(DISTINCT said ORDER BY said) AS names FROM every "
    r"WHERE said IS NOT NULL GROUP BY regexp_replace(regexp_replace(lower(said), '\s', '', 'g'), "
    r"'(^|[^0-9])0+([0-9])', '\1\2', 'g') HAVING len(names) > 1 "
    "AND min(robot) <> max(robot) AND bool_or(said = robot) ORDER BY names"
)
"""One of them is all that says which robot it is: a name beside a serial number may be of many."""


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
            **_common(query, level, "robot, test"),
        )


def _robots(query: Query, level: float) -> tuple[RobotResult, ...]:
    rows = query(
        "SELECT robot, count(*), least(min(p_value) * count(*), 1.0), "
        "arg_min(at_floor, p_value), "
        "string_agg(effects, ',' ORDER BY p_value), max(RP_XY), arg_min(test, p_value) "
        "FROM fleet WHERE p_value IS NOT NULL GROUP BY robot ORDER BY robot"
    )
    if not rows:
        return ()
    from scipy.stats import false_discovery_control  # noqa: PLC0415 - scipy for fleets only

    q_values = false_discovery_control([row[2] for row in rows], method="bh")
    found = [
        RobotResult(
            robot=robot,
            tables=tables,
            p_value=p,
            p_value_at_floor=at_floor,
            q_value=float(q),
            found=bool(q <= level),
            effects=tuple(dict.fromkeys(filter(None, effects.split(",")))),
            RP_XY=RP,
            test=test,
        )
        for (robot, tables, p, at_floor, effects, RP, test), q in zip(rows, q_values, strict=True)
    ]
    return tuple(sorted(found, key=lambda one: (one.q_value, -(one.RP_XY or 0.0), one.robot)))


def _effects(robots: tuple[RobotResult, ...]) -> dict[str, int]:
    counts = Counter(name for one in robots if one.found for name in one.effects or ("unknown",))
    return dict(sorted(counts.items(), key=lambda pair: (-pair[1], pair[0])))


def _common(query: Query, level: float, row: str) -> dict[str, Any]:
    """Return what both summaries have; each ``row`` should be of its own."""
    return {
        "RP_quantiles": _quantiles_of_RP(query),
        "failed": tuple(FailedTable(*one) for one in query(_FAILED)),
        "twice": _twice(query, row),
        "drift": fleet_drift(query, level),
        "names_alone": tuple(NameAlone(n, tuple(s), k) for n, s, k in query(_NAMES_ALONE)),
        "several_names": tuple(SeveralNames(r, tuple(n)) for r, n in query(_SEVERAL_NAMES)),
        "names_and_numbers": next(
            (NamesAndNumbers(n, k, tuple(both)) for n, k, both in query(_NAMES_AND_NUMBERS)), None
        ),
        "alike": tuple(tuple(names) for (names,) in query(_ALIKE)),
    }


def _quantiles_of_RP(query: Query) -> dict[str, tuple[float, ...]]:  # noqa: N802 - the symbol
    each = ", ".join(f"{quantiles(f'RP_{n}')} FILTER (isfinite(RP_{n}))" for n in FIGURES)
    rows = query(f"SELECT {each} FROM fleet")  # noqa: S608
    return {
        name: tuple(ends) for row in rows for name, ends in zip(FIGURES, row, strict=True) if ends
    }


def summarise_figures(run: FleetRun) -> FleetFigures:
    """Return the summary of the figures that a run has left in its folder."""
    with results_in(run.folder / RESULTS) as query:
        robots = query("SELECT count(DISTINCT robot) FROM fleet WHERE error IS NULL")
        return FleetFigures(
            run=run,
            tables=run.tables,
            robots=robots[0][0] if robots else 0,
            worst=_worst(query),
            **_common(query, LEVEL, "robot, test, pose"),
        )


def _worst(query: Query) -> tuple[RobotFigures, ...]:
    largest = ", ".join(f"max(RP_{name}) AS RP_{name}" for name in FIGURES)
    rows = query(
        f"SELECT robot, count(DISTINCT (test, part)), {largest} FROM fleet WHERE error IS NULL "  # noqa: S608
        "GROUP BY robot ORDER BY coalesce(max(RP_XY), max(RP_X), max(RP_Y), max(RP_Z), "
        f"max(RP_theta)) DESC, robot LIMIT {_WORST}"
    )
    return tuple(
        RobotFigures(robot, tables, dict(zip(FIGURES, RP, strict=True)))
        for robot, tables, *RP in rows
    )


def _twice(query: Query, row: str) -> tuple[TwiceThere, ...]:
    rows = query(
        "WITH twice AS (SELECT DISTINCT robot, test FROM (SELECT robot, test FROM fleet "  # noqa: S608
        f"WHERE error IS NULL GROUP BY {row} HAVING count(*) > 1)) "
        "SELECT robot, test, list(DISTINCT part ORDER BY part) FROM fleet "
        "SEMI JOIN twice USING (robot, test) WHERE error IS NULL GROUP BY robot, test "
        "ORDER BY robot, test"
    )
    return tuple(TwiceThere(robot, test, tuple(parts)) for robot, test, parts in rows)
