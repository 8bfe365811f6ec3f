"""How RP of a fleet moves over its test dates, and which robots' RP grows.

Each robot is compared with itself, so robots that were tested later or oftener bend nothing: its
growth is the slope of ln RP over the days. The fleet's is that of its median robot, with the
interval of a sign test, which no few wild robots can move. Whether one robot grows is asked by a
t-test of its slope, whose scatter is learnt from the other robots too (`moderated`), and of all
that are named the false discovery rate is held.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from scara_iso.base.published import Count, Interval
from scara_iso.fleets.database import Query
from scara_iso.run import FloatArray

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
MONTH = 365.25 / 12
"""Days."""
_LEAST = 1e-12
"""Variance of ln RP that rounding may leave."""
_FEWEST = 3
"""Dates of a robot: two have no scatter about their slope."""
_PERIODS = {"%Y-%m-%d": 24, "%Y-%m": 24, "%Y": 10_000}
"""How a date is cut to a period, and how many of these are few enough to be read."""
_WHEN = (
    "coalesce(try_cast(date AS TIMESTAMP), CASE WHEN regexp_full_match(test, "
    r"'\d{4}-\d{2}(-\d{2}([ T].*)?)?') "
    "THEN coalesce(try_cast(test AS TIMESTAMP), try_cast(test || '-01' AS TIMESTAMP)) END)"
)
"""What the table states, else the name of the test where that is a date or a month."""


@dataclass(frozen=True, slots=True)
class DriftPeriod:
    """The tests of a day, a month or a year."""

    period: str
    """``2026-05-12``, ``2026-05`` or ``2026``."""
    robots: Count
    """That were tested in it."""
    RP_quantiles: tuple[float, ...]
    """5, 25, 50, 75 and 95 % of RP of the tests [mm, deg]."""
    compared: Count
    """Tests of robots that have one before."""
    worse: Count
    """Of these, how many have a larger RP than the one before."""


@dataclass(frozen=True, slots=True)
class RobotGrowth:
    """How RP of one robot grows."""

    robot: str
    """Its name."""
    dates: Count
    """On which it was tested."""
    per_month: float
    """Growth of RP, as a share."""
    p_value: float
    """Of the slope, one-sided."""
    q_value: float
    """Smallest false discovery rate at which it is named."""


@dataclass(frozen=True, slots=True)
class FleetDrift:
    """How RP of a fleet moves; of each robot and date the largest."""

    figure: str
    """``XY``, else the first axis that is there."""
    robots: Count
    """That were tested on several dates."""
    per_month: float
    """Growth of RP of the median robot, as a share."""
    interval: Interval | None
    """95 %; null for fewer than six robots."""
    periods: tuple[DriftPeriod, ...]
    """In order of time."""
    asked: Count
    """Robots with three dates or more, of which it is asked whether they grow."""
    growing: tuple[RobotGrowth, ...]
    """Robots that are named, the surest first."""


def fleet_drift(query: Query, level: float) -> FleetDrift | None:
    """Return how RP moves over the dates; None where no robot was tested on several."""
    figure = _figure(query)
    if figure is None:
        return None
    query(
        f"CREATE OR REPLACE TEMP TABLE dated AS SELECT robot, {_WHEN} AS moment, "  # noqa: S608
        f"max(\"RP_{figure}\") AS RP FROM fleet WHERE moment BETWEEN '1950-01-01' "
        f"AND '2150-01-01' AND \"RP_{figure}\" > 0 GROUP BY robot, moment"
    )
    rows = query(
        "SELECT robot, count(*), regr_slope(ln(RP), day), regr_sxx(ln(RP), day), "
        "regr_syy(ln(RP), day) * (1 - regr_r2(ln(RP), day)) "
        "FROM (SELECT *, epoch(moment) / 86400 AS day FROM dated) GROUP BY robot "
        "HAVING count(*) > 1 ORDER BY robot"
    )
    if not rows:
        return None
    slopes = np.array([row[2] for row in rows]) * MONTH
    asked = [row for row in rows if row[1] >= _FEWEST]
    return FleetDrift(
        figure=figure,
        robots=len(rows),
        per_month=math.expm1(float(np.median(slopes))),
        interval=_of_median(slopes),
        periods=_periods(query),
        asked=len(asked),
        growing=tuple(_growing(asked, level)) if asked else (),
    )


def _figure(query: Query) -> str | None:
    names = ("XY", "X", "Y", "Z", "theta")
    counts = query(f"SELECT {', '.join(f'count(RP_{name})' for name in names)} FROM fleet")  # noqa: S608
    return next((name for row in counts for name, n in zip(names, row, strict=True) if n), None)


def _periods(query: Query) -> tuple[DriftPeriod, ...]:
    cut = next(
        cut
        for cut, most in _PERIODS.items()
        if query("SELECT count(DISTINCT strftime(moment, ?)) FROM dated", cut)[0][0] <= most
    )
    rows = query(
        f"SELECT strftime(moment, ?) AS period, count(DISTINCT robot), {quantiles('RP')}, "  # noqa: S608
        "count(before), count(*) FILTER (RP > before) FROM (SELECT *, lag(RP) OVER "
        "(PARTITION BY robot ORDER BY moment) AS before FROM dated) GROUP BY period ORDER BY 1",
        cut,
    )
    return tuple(DriftPeriod(row[0], row[1], tuple(row[2]), *row[3:]) for row in rows)


def quantiles(column: str) -> str:
    """Return the SQL of 5, 25, 50, 75 and 95 % of a column."""
    return f"quantile_cont({column}, {list(QUANTILES)})"


def _of_median(slopes: FloatArray) -> tuple[float, float] | None:
    """Return 95 % of the median's growth: the sign test's, of independent robots."""
    from scipy.stats import binom  # noqa: PLC0415 - scipy for fleets only

    outside = int(binom.ppf(0.025, len(slopes), 0.5))
    if not outside:
        return None
    ordered = np.expm1(np.sort(slopes))
    return float(ordered[outside - 1]), float(ordered[-outside])


def _growing(
    asked: Sequence[tuple[str, int, float, float, float]], level: float
) -> Iterator[RobotGrowth]:
    from scipy.stats import false_discovery_control, t  # noqa: PLC0415 - scipy for fleets only

    robots, dates, slopes, spans, misfits = map(np.array, zip(*asked, strict=True))
    variances, freedom = moderated(misfits / (dates - 2), dates - 2.0)
    p_values = np.asarray(t.sf(slopes * np.sqrt(spans / variances), freedom))
    q_values = np.asarray(false_discovery_control(p_values, method="bh"))
    for k in np.lexsort((robots, p_values)):
        if q_values[k] <= level:
            growth = math.expm1(slopes[k] * MONTH)
            yield RobotGrowth(
                str(robots[k]), int(dates[k]), growth, float(p_values[k]), float(q_values[k])
            )


def moderated(variances: FloatArray, freedom: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return variances of shape (robots,) drawn to those of the others, and their freedom.

    Of ``freedom`` degrees before. How far follows from how much more they differ than by chance
    (Smyth 2004, Stat. Appl. Genet. Mol. Biol. 3:3): few dates of a robot tell little of its own.
    """
    from scipy.optimize import brentq  # noqa: PLC0415 - scipy for fleets only
    from scipy.special import digamma, polygamma  # noqa: PLC0415

    variances = np.maximum(variances, _LEAST)
    if len(variances) == 1:
        return variances, freedom
    logs = np.log(variances) - digamma(freedom / 2) + np.log(freedom / 2)
    own = float(logs.var(ddof=1) - polygamma(1, freedom / 2).mean())
    most = float(freedom.sum())
    if own <= polygamma(1, most / 2):
        return np.full(len(logs), np.exp(logs.mean())), np.full(len(logs), most)
    half = brentq(lambda half: float(polygamma(1, half)) - own, 1e-6, most)
    centre = np.exp(logs.mean() + digamma(half) - np.log(half))
    total = 2 * half + freedom
    return (2 * half * centre + freedom * variances) / total, np.minimum(total, most)
