"""The uncertainty of a measuring system or process by VDA 5 and ISO 22514-7, from its study.

    u_MS^2 = u_CAL^2 + max(u_RE, u_EVR)^2 + u_BI^2 + u_LIN^2        Q_MS = 2 U_MS / T, 15 % at most
    u_MP^2 = u_MS^2 with u_EVO beside u_EVR, + u_AV^2 + u_IA^2      Q_MP = 2 U_MP / T, 30 % at most

with U = 2 u. C_MS = 0.3 T / (6 u_MS) and C_MP = 0.3 T / (3 u_MP) say the same: 1.33 at
those limits. ISO 14253-1 takes U off both ends of the tolerance: only within is conformity proven.

95 % intervals of figures that are made of several variances and a mean.

A generalized pivotal quantity puts the variance of a chi-square and the mean of a Gaussian in the
place of each estimate, and the figure is computed of them as of the readings; the interval is that
of 95 % of such draws (Weerahandi 1993; Hamada and Weerahandi 2000 for studies of measuring
systems). How often they hold the true value: benchmarks/gauge_study.py.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import reduce
from typing import Annotated, Literal, TypeAlias

import numpy as np

from scara_iso.base.published import INTERNAL, Interval, fill, published
from scara_iso.base.quantities import rounding_uncertainty
from scara_iso.run import FloatArray

DRAWS = 20_000
CONFIDENCE = 0.95


def drawn_variance(variance: float, freedom: int, rng: np.random.Generator) -> FloatArray:
    """Return draws of what a variance estimated with ``freedom`` is of, shape (DRAWS,)."""
    return np.asarray(variance * freedom / rng.chisquare(freedom, DRAWS))


def drawn_mean(mean: float, variances: FloatArray, n: int, rng: np.random.Generator) -> FloatArray:
    """Return draws of what the mean of ``n`` readings is of, shape as ``variances``."""
    return np.asarray(mean + rng.standard_normal(len(variances)) * np.sqrt(variances / n))


def between(draws: FloatArray) -> Interval | None:
    """Return the 95 % interval of draws; None where nothing scatters, so that all are 0."""
    if not draws.any():
        return None
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(draws, [tail, 1 - tail])
    return float(low), float(high)


def interval_of_mean(mean: float, s: float, n: int) -> Interval | None:
    """Return Student's interval of a mean of ``n`` readings with deviation ``s``; None of 0."""
    from scipy.special import stdtrit  # noqa: PLC0415 - scipy for studies only

    if s == 0:
        return None
    half = float(stdtrit(n - 1, (1 + CONFIDENCE) / 2)) * s / math.sqrt(n)
    return mean - half, mean + half


def interval_of_s(s: float, freedom: int) -> Interval | None:
    """Return the chi-square interval of a standard deviation of that many freedoms; None of 0."""
    from scipy.special import chdtri  # noqa: PLC0415 - likewise

    if s == 0:
        return None
    tail = (1 - CONFIDENCE) / 2
    low, high = (s * math.sqrt(freedom / float(chdtri(freedom, q))) for q in (tail, 1 - tail))
    return low, high


def p_of_t(t: float, freedom: int) -> float:
    """Return the two-sided p-value of Student's t."""
    from scipy.special import stdtr  # noqa: PLC0415 - likewise

    return float(2 * stdtr(freedom, -abs(t)))


COVERAGE = 2.0
MOST_OF_SYSTEM, MOST_OF_PROCESS = 0.15, 0.30
_ONE_OF = ("RE", "EVR", "EVO")
"""Each of them is the scatter of repeated readings: the largest counts."""


Origin: TypeAlias = Annotated[
    str, ("enum", ("u_CAL", "u_RE", "u_EVR", "u_EVO", "u_BI", "u_LIN", "u_AV", "u_IA"))
]


def by_symbol(parts: Mapping[str, float]) -> Mapping[Origin, float]:
    """Return parts under VDA's symbols: ``u_CAL`` and so on."""
    return {f"u_{name}": part for name, part in parts.items()}


def symbols(origins: tuple[str, ...]) -> tuple[Origin, ...]:
    """Return VDA's symbols of origins."""
    return tuple(f"u_{name}" for name in origins)


@dataclass(frozen=True, slots=True)
class Budget:
    """The standard uncertainties by VDA 5, in the readings' unit."""

    of: Literal["MS", "MP"]
    """The measuring system, or the process of measuring, operators included."""
    parts: Mapping[str, float] = field(metadata=published(by=by_symbol))
    """Certificate, division, repeatability on the reference and on parts, bias, linearity,
    operators, part x operator."""
    missing: tuple[str, ...] = field(metadata=published(by=symbols))
    """What this study cannot tell, and nothing states."""
    u: float
    """Of all parts together."""
    U: float
    """2 u."""
    interval: Interval | None
    """95 %, of U: by the chance of the readings; None where they are alike."""
    tolerance: float | None = field(metadata=INTERNAL)
    """Its width; None where not stated."""
    limit: float = field(init=False, metadata=published("Q_limit"))
    """Largest Q that VDA 5 recommends."""
    Q: float | None = field(init=False)
    """Capability ratio 2 U / T; None without a tolerance."""
    Q_interval: Interval | None = field(init=False)
    """95 %."""
    C: float | None = field(init=False)
    """Capability index, 1.33 where Q is at its limit; None without a tolerance or scatter."""
    smallest_tolerance: float = field(init=False)
    """Tolerance for which Q is just at its limit."""
    zone: float | None = field(init=False, metadata=published("conformity_zone"))
    """T - 2 U: the width within which a reading proves conformity (ISO 14253-1), 0 for none; None
    without a tolerance."""

    def __post_init__(self) -> None:
        limit = MOST_OF_SYSTEM if self.of == "MS" else MOST_OF_PROCESS
        fill(self, limit=limit, smallest_tolerance=2 * self.U / limit)
        fill(self, Q=None, Q_interval=None, C=None, zone=None)
        if (T := self.tolerance) is None:
            return
        Q, ends = 2 * self.U / T, self.interval
        C = None if self.u == 0 else 4 / 3 * limit / Q
        Q_ends = None if ends is None else (2 * ends[0] / T, 2 * ends[1] / T)
        fill(self, Q=Q, Q_interval=Q_ends, C=C, zone=max(T - 2 * self.U, 0.0))

    @property
    def holds_scatter(self) -> bool:
        """Whether readings or division tell how far readings of the same scatter."""
        return any(self.parts.get(name) for name in _ONE_OF)


def budget(
    of: Literal["MS", "MP"],
    parts: Mapping[str, float],
    draws: Mapping[str, FloatArray],
    tolerance: float | None,
    wanted: tuple[str, ...],
) -> Budget:
    """Return the budget of ``parts``; ``draws`` stand in their place for the interval.

    Of what is ``wanted`` beside, the parts that are not there are missing.
    """
    missing = tuple(name for name in wanted if name not in parts)
    u = float(combined(parts))
    scatter = any(draws[name].any() for name in _ONE_OF if name in draws)
    ends = between(COVERAGE * combined({**parts, **draws})) if scatter else None
    return Budget(of, dict(parts), missing, u, COVERAGE * u, ends, tolerance)


def combined(parts: Mapping[str, float | FloatArray]) -> FloatArray:
    """Return the root of the sum of squares, of the repeatabilities the largest only."""
    repeated = [np.square(part) for name, part in parts.items() if name in _ONE_OF]
    others = [np.square(part) for name, part in parts.items() if name not in _ONE_OF]
    largest = reduce(np.maximum, repeated, np.zeros(()))
    return np.asarray(np.sqrt(sum(others, largest)))


def rectangular(half_width: float) -> float:
    """Return the standard uncertainty of what is anywhere within +/- ``half_width``."""
    return half_width / math.sqrt(3)


def stated_parts(resolution: float | None, uncertainty: float | None) -> dict[str, float]:
    """Return what the dial's division and its certificate bring, where they are stated."""
    parts = {} if uncertainty is None else {"CAL": uncertainty}
    return parts if resolution is None else {**parts, "RE": rounding_uncertainty(resolution)}
