"""Type 2 and 3: parts read several times, by several operators or by one. R&R by ANOVA.

    y = mean + part + operator + part x operator + repeatability, all of them random

A negative estimate of a variance is 0. Where part x operator does not show itself (p above 0.25,
AIAG's), its squares count as repeatability.

R&R by average and range, as it was done by hand: for comparison with the ANOVA only.

The mean range of m Gaussian values is d2 sigma; over g subgroups the root of d2^2 + d3^2 / g,
d2*, takes its place (Duncan 1974, appendix D3). AIAG takes d2 for more than 15 subgroups.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Literal, TypeAlias

import numpy as np

from scara_iso.base.published import INTERNAL, Count, Interval
from scara_iso.gauge.budget import Budget, between, budget, drawn_variance, stated_parts
from scara_iso.gauge.table import GaugeReadings, numbered
from scara_iso.run import FloatArray, IntArray

_MANY = 15
_REACH, _STEPS = 8.0, 1200
STUDY = 6.0
"""Standard deviations that a study's variation is wide: 99.73 % of Gaussian scatter."""
CATEGORIES = 1.41
"""ndc = 1.41 PV / GRR (AIAG's rounding of the root of 2)."""


@dataclass(frozen=True, slots=True)
class ByRanges:
    """Standard deviations by ranges, in the readings' unit."""

    EV: float
    """Repeatability."""
    AV: float
    """Operators."""
    GRR: float
    """Both together."""
    PV: float
    """Parts."""
    TV: float
    """Total."""
    of_study: float
    """GRR / TV."""
    of_tolerance: float | None
    """6 GRR / T."""
    ndc: int | None
    """Number of distinct categories; null where nothing scatters."""


def by_ranges(cells: FloatArray, tolerance: float | None) -> ByRanges:
    """Return R&R of readings of shape (parts, operators or 1, trials) by average and range."""
    p, o, r = cells.shape
    EV = float(np.ptp(cells, axis=2).mean()) / d2_star(r, p * o)
    AV = 0.0
    if o > 1:
        apart = float(np.ptp(cells.mean(axis=(0, 2)))) / d2_star(o, 1)
        AV = math.sqrt(max(apart**2 - EV**2 / (p * r), 0.0))
    PV = float(np.ptp(cells.mean(axis=(1, 2)))) / d2_star(p, 1)
    GRR = math.hypot(EV, AV)
    TV = math.hypot(GRR, PV)
    return ByRanges(
        EV,
        AV,
        GRR,
        PV,
        TV,
        of_study=GRR / TV if TV > 0 else 0.0,
        of_tolerance=None if tolerance is None else STUDY * GRR / tolerance,
        ndc=whole_categories(CATEGORIES * PV / GRR) if GRR > 0 else None,
    )


def whole_categories(ndc: float) -> int:
    """Return ndc as AIAG states it: cut to a whole number, and at least 1."""
    return max(int(ndc), 1)


@cache
def d2_star(m: int, g: int) -> float:
    """Return what the mean range of ``g`` subgroups of ``m`` is divided by, for sigma."""
    x = np.linspace(-_REACH, _REACH, _STEPS)
    step = float(x[1] - x[0])
    below = np.array([0.5 * math.erfc(-value / math.sqrt(2)) for value in x])
    d2 = float((1 - below**m - (1 - below) ** m).sum()) * step
    if g > _MANY:
        return d2
    low, high = below[:, np.newaxis], below[np.newaxis, :]
    inside = 1 - high**m - (1 - low) ** m + np.maximum(high - low, 0.0) ** m
    squared = 2 * float(np.triu(inside, 1).sum()) * step**2 + float(np.trace(inside)) * step**2
    return math.sqrt(d2**2 + (squared - d2**2) / g)


POOLED_ABOVE = 0.25
ComponentName: TypeAlias = Literal["EV", "AV", "INT", "GRR", "PV", "TV"]


@dataclass(frozen=True, slots=True)
class Source:
    """A line of the ANOVA table."""

    source: str
    """`part`, `operator`, `part x operator`, `repeatability` or `total`."""
    squares: float
    """Sum of squares."""
    freedom: Count
    """Degrees of freedom."""
    mean_square: float
    """Squares over freedom."""
    F: float | None
    """Over the mean square that it is held against; null where nothing scatters, or none is."""
    p_value: float | None
    """Chance of such an F where the source makes nothing."""


@dataclass(frozen=True, slots=True)
class Component:
    """A standard deviation of the study."""

    sigma: float
    """In the readings' unit."""
    interval: Interval | None
    """95 %, of `sigma`; null where all readings are alike."""
    contribution: float
    """Share of the total variance."""
    of_study: float
    """Share of the total standard deviation."""
    of_study_interval: Interval | None
    """95 %."""
    of_tolerance: float | None
    """6 sigma / T; null without a tolerance."""
    of_tolerance_interval: Interval | None
    """95 %."""


@dataclass(frozen=True, eq=False, slots=True)
class Crossed:
    """Figures of a study of parts, in the readings' unit."""

    parts: tuple[str, ...]
    """Their names."""
    operators: tuple[str, ...]
    """Empty where one operator, or a machine, read all."""
    trials: Count
    """Readings of each part by each operator."""
    anova: tuple[Source, ...]
    """Lines of the ANOVA table."""
    interaction_pooled: bool
    """Whether part x operator counts as repeatability."""
    components: Mapping[ComponentName, Component]
    """Repeatability, operators, part x operator, R&R, parts, total."""
    ndc: int | None
    """Number of distinct categories: whole, and at least 1 (AIAG)."""
    ndc_raw: float | None
    """1.41 PV / GRR; null where nothing scatters."""
    ndc_interval: Interval | None
    """95 %, of `ndc_raw`."""
    by_ranges: ByRanges
    """The same by ranges, for comparison."""
    cells: FloatArray = field(metadata=INTERNAL)
    """Readings, shape (parts, operators or 1, trials)."""
    budget: Budget = field(metadata=INTERNAL)
    """The uncertainties by VDA 5."""


def crossed(readings: GaugeReadings, tolerance: float | None, rng: np.random.Generator) -> Crossed:
    """Return R&R of a study of parts; `DataError` where it is not balanced.

    AIAG MSA, 4th ed., chapter III B and appendix A. Every part at least twice by every operator.
    """
    parts, operators, cells = _cells(readings)
    p, o, r = cells.shape
    anova, pooled = _anova(cells)
    squares = {one.source: one.mean_square for one in anova}
    point = _variances(squares, (p, o, r), pooled=pooled)
    drawn = {
        one.source: drawn_variance(one.mean_square, one.freedom, rng)
        for one in anova
        if one.source != "total"
    }
    draws = _variances(drawn, (p, o, r), pooled=pooled)
    sigma = {name: math.sqrt(value) for name, value in point.items()}
    sigmas = {name: np.sqrt(value) for name, value in draws.items()}
    ndc = CATEGORIES * sigma["PV"] / sigma["GRR"] if sigma["GRR"] > 0 else None
    stated = stated_parts(readings.resolution, readings.uncertainty)
    named: dict[str, ComponentName] = {"EVO": "EV", "AV": "AV", "IA": "INT"}
    return Crossed(
        parts=parts,
        operators=operators,
        trials=r,
        anova=anova,
        interaction_pooled=pooled,
        components={name: _component(name, sigma, sigmas, tolerance) for name in point},
        ndc=None if ndc is None else whole_categories(ndc),
        ndc_raw=ndc,
        ndc_interval=None if ndc is None else between(CATEGORIES * sigmas["PV"] / sigmas["GRR"]),
        by_ranges=by_ranges(cells, tolerance),
        cells=cells,
        budget=budget(
            "MP",
            {**stated, **{to: sigma[of] for to, of in named.items() if of in sigma}},
            {to: sigmas[of] for to, of in named.items() if of in sigmas},
            tolerance,
            ("CAL", "RE", "BI", "LIN"),
        ),
    )


def _cells(readings: GaugeReadings) -> tuple[tuple[str, ...], tuple[str, ...], FloatArray]:
    """Return parts, operators and the readings by them, shape (parts, operators or 1, trials)."""
    labels = readings.part or ()
    parts, part = numbered(labels)
    operators, operator = numbered(readings.operator or [""] * len(labels))
    counts = np.zeros((len(parts), len(operators)), dtype=np.int64)
    np.add.at(counts, (part, operator), 1)
    if len(parts) < 2 or counts.min() < 2:
        raise readings.refuse(
            "two parts or more are needed, each read twice or more by every operator"
            + _fewest(counts, parts, operators),
            "ten parts, three operators, three readings each are usual",
        )
    if counts.min() != counts.max():
        raise readings.refuse(
            "not every part was read equally often by every operator"
            + _fewest(counts, parts, operators),
            "read what is missing, or remove the same surplus readings of each operator",
        )
    order = np.lexsort((np.arange(len(part)), operator, part))
    cells = readings.values[order].reshape(len(parts), len(operators), int(counts[0, 0]))
    return parts, operators if len(operators) > 1 else (), cells


def _fewest(counts: IntArray, parts: tuple[str, ...], operators: tuple[str, ...]) -> str:
    i, j = np.unravel_index(int(np.argmin(counts)), counts.shape)
    by = f" by {operators[j]}" if operators[j] else ""
    return f": part {parts[i]}{by} has {counts[i, j]}, another {counts.max()}"


def _anova(cells: FloatArray) -> tuple[tuple[Source, ...], bool]:
    """Return the lines of the table, and whether part x operator is counted as repeatability."""
    p, o, r = cells.shape
    shifted = cells - cells[0, 0, 0]  # keeps the digits of readings far from zero
    grand, by_cell = shifted.mean(), shifted.mean(axis=2)
    by_part, by_operator = by_cell.mean(axis=1), by_cell.mean(axis=0)
    left = by_cell - by_part[:, np.newaxis] - by_operator + grand
    squares = {
        "part": (o * r * ((by_part - grand) ** 2).sum(), p - 1),
        "operator": (p * r * ((by_operator - grand) ** 2).sum(), o - 1),
        "part x operator": (r * (left**2).sum(), (p - 1) * (o - 1)),
        "repeatability": (((shifted - by_cell[..., np.newaxis]) ** 2).sum(), p * o * (r - 1)),
    }
    rows = {name: (float(ss), df) for name, (ss, df) in squares.items() if df > 0}
    total = float(((shifted - grand) ** 2).sum())
    within, pooled = "repeatability", False
    if "part x operator" in rows:
        _, p_value = _f_test(rows["part x operator"], rows["repeatability"])
        pooled = p_value is not None and p_value > POOLED_ABOVE
        within = "repeatability" if pooled else "part x operator"
    if pooled:
        one, other = rows.pop("part x operator"), rows["repeatability"]
        rows["repeatability"] = (one[0] + other[0], one[1] + other[1])
    against = {"part": within, "operator": within, "part x operator": "repeatability"}
    lines = []
    for name, (ss, df) in rows.items():
        F, p_value = _f_test((ss, df), rows[against[name]]) if name in against else (None, None)
        lines.append(Source(name, ss, df, ss / df, F, p_value))
    return (
        *lines,
        Source("total", total, cells.size - 1, total / (cells.size - 1), None, None),
    ), pooled


def _f_test(one: tuple[float, int], other: tuple[float, int]) -> tuple[float | None, float | None]:
    from scipy.special import fdtrc  # noqa: PLC0415 - scipy for studies only

    if other[0] == 0:
        return None, None
    F = one[0] / one[1] / (other[0] / other[1])
    return F, float(fdtrc(one[1], other[1], F))


def _variances(
    squares: Mapping[str, float | FloatArray], sizes: tuple[int, int, int], *, pooled: bool
) -> dict[ComponentName, FloatArray]:
    """Return the variances that mean squares are made of (AIAG's estimators), none below 0."""
    p, o, r = sizes
    repeatability = np.asarray(squares["repeatability"])
    interaction = squares.get("part x operator")
    beside = repeatability if interaction is None else np.asarray(interaction)
    found: dict[ComponentName, FloatArray] = {"EV": repeatability}
    if "operator" in squares:
        found["AV"] = np.maximum((squares["operator"] - beside) / (p * r), 0.0)
        if not pooled:
            found["INT"] = np.maximum((beside - repeatability) / r, 0.0)
    found["GRR"] = np.asarray(sum(found.values()))
    found["PV"] = np.maximum((squares["part"] - beside) / (o * r), 0.0)
    return {**found, "TV": found["GRR"] + found["PV"]}


def _component(
    name: ComponentName,
    sigma: Mapping[ComponentName, float],
    sigmas: Mapping[ComponentName, FloatArray],
    tolerance: float | None,
) -> Component:
    total = sigma["TV"]
    share = sigma[name] / total if total > 0 else 0.0
    shares = sigmas[name] / sigmas["TV"] if total > 0 else np.zeros(1)
    width = None if tolerance is None else STUDY / tolerance
    return Component(
        sigma=sigma[name],
        interval=between(sigmas[name]),
        contribution=share**2,
        of_study=share,
        of_study_interval=between(shares),
        of_tolerance=None if width is None else width * sigma[name],
        of_tolerance_interval=None if width is None else between(width * sigmas[name]),
    )
