"""Robots and tests whose names leave open which they are: what was taken for what is said."""

from __future__ import annotations

from dataclasses import dataclass

from scara_iso.fleets.database import Query


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


def tables_twice(query: Query, row: str = "robot, test") -> tuple[TwiceThere, ...]:
    """Return the tests that are there more than once, where each ``row`` should be of its own."""
    rows = query(
        "WITH twice AS (SELECT DISTINCT robot, test FROM (SELECT robot, test FROM fleet "  # noqa: S608
        f"WHERE error IS NULL GROUP BY {row} HAVING count(*) > 1)) "
        "SELECT robot, test, string_agg(DISTINCT part, ',' ORDER BY part) FROM fleet "
        "SEMI JOIN twice USING (robot, test) WHERE error IS NULL GROUP BY robot, test "
        "ORDER BY robot, test"
    )
    return tuple(TwiceThere(robot, test, tuple(parts.split(","))) for robot, test, parts in rows)


def names_alone(query: Query) -> tuple[NameAlone, ...]:
    """Return the names that stand with a serial number in some tables, and alone in others."""
    rows = query(
        "WITH alone AS (SELECT name, count(DISTINCT (test, part)) AS tables FROM fleet "
        "SEMI JOIN named USING (name) WHERE as_read = name AND error IS NULL GROUP BY name) "
        "SELECT name, list(serial ORDER BY serial), any_value(tables) FROM named "
        "JOIN alone USING (name) GROUP BY name ORDER BY name"
    )
    return tuple(NameAlone(name, tuple(serials), tables) for name, serials, tables in rows)


def several_names(query: Query) -> tuple[SeveralNames, ...]:
    """Return the robots that go by several names."""
    rows = query(
        "WITH several AS (SELECT robot FROM fleet WHERE error IS NULL GROUP BY robot "
        "HAVING min(name) <> max(name)) SELECT robot, list(DISTINCT name ORDER BY name) FROM fleet "
        "SEMI JOIN several USING (robot) WHERE error IS NULL AND name IS NOT NULL "
        "GROUP BY robot ORDER BY robot"
    )
    return tuple(SeveralNames(robot, tuple(names)) for robot, names in rows)


def robots_alike(query: Query) -> tuple[tuple[str, ...], ...]:
    """Return names that differ in case, blanks and zeros in front only, of several robots.

    One of them is all that says which robot it is: a name beside a serial number may be of many.
    """
    alike = r"regexp_replace(regexp_replace(lower(said), '\s', '', 'g'), "
    alike += r"'(^|[^0-9])0+([0-9])', '\1\2', 'g')"
    query(
        "CREATE OR REPLACE TEMP TABLE every AS "  # noqa: S608
        f"SELECT robot, said, {alike} AS alike FROM (SELECT robot, robot AS said FROM fleet "
        "WHERE error IS NULL UNION ALL SELECT robot, name FROM fleet WHERE error IS NULL "
        "AND name <> robot) ORDER BY alike"  # what is sorted goes to the disk, groups do not
    )
    rows = query(
        "WITH several AS (SELECT DISTINCT alike FROM (SELECT alike, said, lag(alike) OVER () AS a, "
        "lag(said) OVER () AS b FROM every) WHERE alike = a AND said <> b) "
        "SELECT list(DISTINCT said ORDER BY said) FROM every SEMI JOIN several USING (alike) "
        "GROUP BY alike HAVING min(robot) <> max(robot) AND bool_or(said = robot) ORDER BY alike"
    )
    return tuple(tuple(names) for (names,) in rows)
