"""The same loop on the gears: effects that change eq. 16 are the hypotheses on measured reversals.

A hypothesis is one effect at one joint, or two: its values lie on a grid and are equally likely
beforehand. With residuals r of standard deviations u the log likelihood is -sum (r / u)^2 / 2;
where u is not known it is integrated out under the prior 1 / u, -m/2 log sum (w r)^2, w the weights
of a scatter that grows with a power of the deviation, averaged over the powers. Whether eq. 16
lacks an effect, or one effect a second, F tests over all that could be added say (Bonferroni).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import cast

import numpy as np

from scara_iso.diagnosis.sweeps import (
    GearDiagnosis,
    GearError,
    GearErrors,
    GearFound,
    Joint,
    SweepSeries,
    rms_of,
)
from scara_iso.diagnosis.tuning import (
    FURTHER_LEVEL,
    LEVEL,
    MISFIT_LEVEL,
    RIVAL,
    SCATTER_POWERS,
    SWEEP_SIMULATIONS,
    UNKNOWN,
)
from scara_iso.diagnosis.verdict import Rival, Verdict
from scara_iso.effects import GearEffect, Grid, Parameter, Sizes, Sweep, find_gear_effects
from scara_iso.run import FloatArray, IntArray

_RELATIVE_FLOOR = 1e-6
"""A reversal is not known better than this share of the largest one."""
_SMALLEST = 1e-3
_BREADTHS = (1000.0, 200.0, 50.0, 20.0, 9.0, 0.0)
"""Log likelihoods below the best within which each finer grid lies."""
_POINTS = {0: 1, 1: 401, 2: 41}
"""Points of a grid along each coordinate, by the number of these."""
_EXACT = 1e-4
"""A fit this close, as a share of the largest deviation, leaves only digits and grid."""
_MANY = 1e6
_MOST_CANDIDATES = 3


@dataclass(frozen=True, eq=False, slots=True)
class Reversals:
    """Measured reversals, shape (m,), and what eq. 16 needs to predict them.

    The prediction is the sum over the joints of lever times load deviation. Of ``uncertainty``
    (standard; None where the scatter is not known) ``degrees`` are the degrees of freedom. Rows
    of one ``group`` are left out together; ``rows`` are taken into account, all unless given.
    """

    measured: FloatArray
    sweeps: Mapping[Joint, Sweep]
    levers: Mapping[Joint, FloatArray]
    group: IntArray
    uncertainty: FloatArray | None = None
    degrees: float = np.inf
    rows: IntArray | slice = field(default_factory=lambda: slice(None))

    @property
    def seen(self) -> FloatArray:
        """The reversals that are taken into account."""
        return self.measured[self.rows]

    def predict(self, changes: Sequence[tuple[GearTerm, Sizes]] = ()) -> FloatArray:
        """Return the predictions, shape (k, m) where values are columns (k, 1), else (1, m)."""
        total = np.zeros((1, len(self.measured)))
        for joint, sweep in self.sweeps.items():
            for term, values in changes:
                if term.joint == joint:
                    sweep = term.effect.changed(sweep, **values)  # noqa: PLW2901 - one after another
            total = total + self.levers[joint] * sweep.deviation
        return np.asarray(total[:, self.rows])

    def weights(self, predictions: FloatArray) -> FloatArray:
        """Return what makes the scatter about predictions (k, m) even, (p, k, m).

        Where it is not known that is one of product 1 for each power of the deviation with which
        it may grow.
        """
        if self.uncertainty is not None:
            return 1 / self.uncertainty[self.rows] + np.zeros((1, *predictions.shape))
        size = np.abs(predictions)
        log = np.log(np.maximum(size, _SMALLEST * size.max(axis=1, keepdims=True)))
        about = log - log.mean(axis=1, keepdims=True)
        return np.stack([np.exp(-power * about) for power in SCATTER_POWERS])

    def log_likelihood(self, predictions: FloatArray) -> FloatArray:
        """Return the log likelihood (k,) of predictions (k, m)."""
        left = (self.seen - predictions) * self.weights(predictions)
        squares = (left**2).sum(axis=2)
        if self.uncertainty is not None:
            return np.asarray(-squares[0] / 2)
        floor = (_RELATIVE_FLOOR * np.abs(self.seen).max()) ** 2 + np.finfo(float).tiny
        logs = -len(self.seen) / 2 * np.log(squares + floor)
        return np.asarray(np.logaddexp.reduce(logs) - np.log(len(logs)))


@dataclass(frozen=True, eq=False, slots=True)
class GearTerm:
    """An effect at a joint, and the values to try."""

    effect: GearEffect
    joint: Joint
    candidates: tuple[Sizes, ...]

    @property
    def free(self) -> bool:
        """Whether there is something to fit."""
        return len(self.candidates) > 1

    def at(self, place: FloatArray) -> Sizes:
        """Return the values, columns (k, 1), at places (k,) from the first candidate, 0, to 1."""
        position = place * (len(self.candidates) - 1)
        if len(self.effect.parameters) != 1:
            position = np.round(position)
        index = np.arange(len(self.candidates))
        found = {
            p.name: np.interp(position, index, [c[p.name] for c in self.candidates])[:, np.newaxis]
            for p in self.effect.parameters
        }
        return cast(Sizes, found)  # an effect takes columns as it takes numbers


Family = tuple[GearTerm, ...]
"""Effects that act together."""


@dataclass(frozen=True, eq=False, slots=True)
class Fitted:
    """A family's evidence, its likeliest values, and their 95 % intervals, effect by effect."""

    family: Family
    log_evidence: float
    log_best: float
    values: tuple[Sizes, ...]
    spread: tuple[Mapping[str, tuple[float, float]], ...]

    @property
    def free(self) -> int:
        """How many of its effects have something to fit."""
        return sum(term.free for term in self.family)

    @property
    def changes(self) -> list[tuple[GearTerm, Sizes]]:
        """The effects with their likeliest values."""
        return list(zip(self.family, self.values, strict=True))

    @property
    def name(self) -> str:
        """The effects by name, such as ``gap+wind_up``, and their joints."""
        if self.family[0].effect.name == UNKNOWN:
            return UNKNOWN
        at = (f" at joint {term.joint}" if term.joint else "" for term in self.family)
        return "+".join(t.effect.name + where for t, where in zip(self.family, at, strict=True))


def fit_family(data: Reversals, family: Family) -> Fitted:
    """Return the fit of a family, on grids that close in on its likely values."""
    free = sum(term.free for term in family)
    box, points = np.tile([0.0, 1.0], (free, 1)), _POINTS[free]
    for breadth in _BREADTHS:
        edges = np.meshgrid(*(np.linspace(low, high, points) for low, high in box))
        places = np.stack([edge.ravel() for edge in edges]) if free else np.zeros((0, 1))
        values = _values(family, places)
        log = data.log_likelihood(data.predict(list(zip(family, values, strict=True))))
        if not free or not breadth:
            break
        likely, cell = places[:, log >= log.max() - breadth], np.diff(box)[:, 0] / (points - 1)
        ends = [likely.min(axis=1) - cell, likely.max(axis=1) + cell]  # a cell wider
        box = np.clip(np.stack(ends, axis=1), 0.0, 1.0)
    best, share = int(np.argmax(log)), np.exp(log - log.max())
    volume = float(np.prod(np.diff(box)))
    return Fitted(
        family=family,
        log_evidence=float(log.max() + np.log(share.mean() * volume)),
        log_best=float(log.max()),
        values=tuple({name: float(np.ravel(v)[best]) for name, v in one.items()} for one in values),
        spread=tuple(
            {name: _interval(np.ravel(v), share) for name, v in one.items()} if term.free else {}
            for term, one in zip(family, values, strict=True)
        ),
    )


def _values(family: Family, places: FloatArray) -> list[Sizes]:
    """Return the values of each effect at places (coordinates, k)."""
    free, none = iter(places), np.zeros(places.shape[1])
    return [term.at(next(free) if term.free else none) for term in family]


def _interval(values: FloatArray, share: FloatArray) -> tuple[float, float]:
    order = np.argsort(values, kind="stable")
    risen = np.cumsum(share[order]) / share.sum()
    low, high = np.searchsorted(risen, [0.025, 0.975])
    return float(values[order[low]]), float(values[order[min(high, len(values) - 1)]])


def single_families(data: Reversals, effects: Sequence[GearEffect]) -> list[Family]:
    """Return each effect at each joint by itself, as far as the reversals let it be tried."""
    return [
        (GearTerm(effect, joint, candidates),)
        for joint, sweep in data.sweeps.items()
        for effect in effects
        if (candidates := effect.candidates(sweep))
    ]


def _pairs(data: Reversals, singles: Sequence[Family]) -> Iterator[Family]:
    """Yield pairs of effects, with parameters no more than conditions and fewer than rows."""
    rows, conditions = len(data.measured), _conditions(data)
    for (first,), (second,) in combinations(singles, 2):
        free = first.free + second.free
        if free <= conditions and free < rows:
            yield first, second
    if min(rows - 1, conditions) >= 2:
        yield from unknown_families(data)


def _conditions(data: Reversals) -> int:
    """Return how many distinct inertias (and torques) the reversals were measured at."""
    sweeps = data.sweeps.values()
    columns = [s.I_L / s.I_m for s in sweeps] + [s.torque for s in sweeps if s.torque is not None]
    return len(np.unique(np.round(np.stack(columns, axis=1), 12), axis=0))


def unknown_families(data: Reversals) -> list[Family]:
    """Return a power law of the load's inertia at each joint: structure of no known effect."""
    levels, powers = (single_families(data, [effect]) for effect in (_LEVEL_OF_ANY, _POWER_OF_ANY))
    return [
        (*level, *power) for level in levels for power in powers if level[0].joint == power[0].joint
    ]


def _at_level(sweep: Sweep, *, level: float) -> Sweep:
    return replace(sweep, I_m=np.full_like(sweep.I_m, np.inf), gap=sweep.gap * np.exp(level))


def _at_power(sweep: Sweep, *, power: float) -> Sweep:
    log = np.log(sweep.I_L)
    return replace(sweep, gap=sweep.gap * np.exp(power * (log - log.mean())))


def _of_any(name: str, changed: Callable[..., Sweep], low: float, high: float) -> GearEffect:
    grid = Grid.exact(np.linspace(low, high, 201))
    parameter = Parameter(name, name, "", "of a deviation of unknown cause", grid=lambda _: grid)
    confirm_by = "measure at more inertias, several times at each"
    return GearEffect(
        name=UNKNOWN,
        parameters=(parameter,),
        cause="none known",
        confirm_by=confirm_by,
        changed=changed,
    )


_LEVEL_OF_ANY = _of_any("level", _at_level, -14.0, 2.0)
_POWER_OF_ANY = _of_any("power", _at_power, -2.0, 2.0)


@dataclass(frozen=True, eq=False, slots=True)
class _Choice:
    """Fits of competing families, the likeliest first, and how likely each name is."""

    fits: Sequence[Fitted]
    probability: Mapping[str, float]

    @property
    def rivals(self) -> tuple[Rival, ...]:
        """Other names at least a tenth as likely as the best, likeliest first."""
        (_, best), *others = self.probability.items()
        return tuple(Rival(name, p) for name, p in others if p >= RIVAL * best)


def _choice(fits: Sequence[Fitted]) -> _Choice:
    ranked = sorted(fits, key=lambda fit: -fit.log_evidence)
    likely = np.exp([fit.log_evidence - ranked[0].log_evidence for fit in ranked])
    whole: dict[str, float] = {}
    for fit, share in zip(ranked, (likely / likely.sum()).tolist(), strict=True):
        whole[fit.name] = whole.get(fit.name, 0.0) + share
    probability = dict(sorted(whole.items(), key=lambda one: -one[1]))
    best = next(iter(probability))
    return _Choice(sorted(ranked, key=lambda fit: fit.name != best), probability)


def diagnose_reversals(data: Reversals, *, seed: int, sides: int = 1) -> GearDiagnosis:
    """Return what eq. 16 leaves of reversals, and which effects it is; two at the most.

    ``sides`` is 2 where the sign of the reversals was chosen to suit the model.
    """
    singles = single_families(data, find_gear_effects())
    one, before = [fit_family(data, family) for family in singles], data.predict()[0]
    any_ = [*one, *(fit_family(data, family) for family in unknown_families(data))]
    chance = min(1.0, sides * _chance(data, [fit_family(data, ())], any_))
    rms, one_ratio = rms_of(data.measured - before), _one_ratio(data)
    nothing = GearDiagnosis(
        verdict=Verdict.NOTHING,
        p_value=chance,
        p_value_at_floor=False,
        effects=(),
        candidates=(),
        error=GearErrors(GearError(rms, rms), GearError(rms, rms)),
        series=SweepSeries(data.measured, before, before),
    )
    if chance > LEVEL:
        return replace(nothing, notes=(*one_ratio, *_uneven(data, rms, rms_of(before))))
    two = [fit_family(data, family) for family in _pairs(data, singles)]
    fits = two if two and _chance(data, one, two) <= FURTHER_LEVEL else one
    choice = _choice(fits)
    best = choice.fits[0]
    if best.name == UNKNOWN or _misfits(data, best) or _wanders(data, best, seed):
        near = [Rival(name, p) for name, p in choice.probability.items() if name != UNKNOWN]
        nearest = tuple(near[:_MOST_CANDIDATES])
        return replace(nothing, verdict=Verdict.UNEXPLAINED, candidates=nearest, notes=one_ratio)
    after = data.predict(best.changes)[0]
    unseen = _left_out(data, [fit.family for fit in fits])
    return replace(
        nothing,
        verdict=Verdict.EXPLAINED,
        effects=_found(choice, chance),
        error=replace(nothing.error, after=GearError(rms_of(data.measured - after), unseen)),
        series=replace(nothing.series, predicted_after=after),
        notes=(*one_ratio, *_settled_by(choice)),
    )


def _chance(data: Reversals, simpler: Sequence[Fitted], richer: Sequence[Fitted]) -> float:
    """Return the chance that some richer fit is as much better than every simpler one (F tests)."""
    from scipy.special import fdtrc  # noqa: PLC0415 - heavy

    best, m = max(simpler, key=lambda fit: fit.log_best), len(data.seen)
    chances = []
    for fit in richer:
        more, left = max(1, fit.free - best.free), m - fit.free
        gain = fit.log_best - best.log_best
        ratio, freedom = 2 * gain, min(data.degrees, _MANY)
        if data.uncertainty is None:
            ratio, freedom = np.expm1(2 * max(gain, 0.0) / m) * left, left
        chances.append(float(fdtrc(more, freedom, max(ratio, 0.0) / more)))
    return min(1.0, len(chances) * min(chances))


def _misfits(data: Reversals, fit: Fitted) -> bool:
    """Return whether known uncertainties do not account for what a fit leaves."""
    from scipy.special import fdtrc  # noqa: PLC0415 - heavy

    left = len(data.seen) - fit.free
    if data.uncertainty is None or left < 1:
        return False
    return bool(fdtrc(left, min(data.degrees, _MANY), -2 * fit.log_best / left) < MISFIT_LEVEL)


def _wanders(data: Reversals, fit: Fitted, seed: int) -> bool:
    """Return whether what a fit leaves follows the inertia, where the scatter is not known.

    Neighbours in the order of I_L differ less than they do when permuted (von Neumann 1941).
    """
    predicted = data.predict(fit.changes)
    left = (data.seen - predicted)[0]
    if data.uncertainty is not None or np.abs(left).max() < _EXACT * np.abs(predicted).max():
        return False
    even = left * data.weights(predicted)[:, 0]
    (sweep,) = data.sweeps.values()
    order = np.argsort(sweep.I_L[data.rows], kind="stable")
    course = min(even, key=lambda one: float(one @ one))[order]
    rng = np.random.default_rng(seed)
    permuted = rng.permuted(np.tile(course, (SWEEP_SIMULATIONS, 1)), axis=1)
    steps = (np.diff(np.vstack([course, permuted]), axis=1) ** 2).sum(axis=1)
    fewer = 1 + np.count_nonzero(steps[1:] <= steps[0])
    return bool(fewer < MISFIT_LEVEL * (1 + SWEEP_SIMULATIONS))


def _found(choice: _Choice, p_value: float) -> tuple[GearFound, ...]:
    best = choice.fits[0]
    return tuple(
        GearFound(
            effect=term.effect.name,
            joint=term.joint,
            parameters=values,
            intervals=spread,
            p_value=p_value,
            probability=choice.probability[best.name],
            rivals=choice.rivals,
            cause=term.effect.cause,
            confirm_by=term.effect.confirm_by,
        )
        for term, values, spread in zip(best.family, best.values, best.spread, strict=True)
    )


def _left_out(data: Reversals, families: Sequence[Family]) -> float | None:
    """Return the root mean square error at each group, effect and values chosen without it."""
    groups = np.unique(data.group)
    if len(groups) < 2:
        return None
    errors = []
    for out in (data.group == group for group in groups):
        seen = replace(data, rows=np.flatnonzero(~out))
        best = max((fit_family(seen, f) for f in families), key=lambda fit: fit.log_evidence)
        errors.append((data.measured - data.predict(best.changes)[0])[out])
    return rms_of(np.concatenate(errors))


def _settled_by(choice: _Choice) -> Iterator[str]:
    """Yield one line for each rival: what would tell it from the effects found."""
    best = choice.fits[0]
    own = {term.effect.name for term in best.family}
    for rival in choice.rivals:
        family = next(fit.family for fit in choice.fits if fit.name == rival.effect)
        ways = [t.effect.confirm_by for t in family if t.effect.name not in own]
        ways = ways or [term.effect.confirm_by for term in best.family]
        yield f"{best.name} or {rival.effect}: {'; '.join(dict.fromkeys(ways))}"


def _uneven(data: Reversals, left: float, size: float) -> Iterator[str]:
    """Yield a line where a scatter that is not known may hide what eq. 16 lacks."""
    if data.uncertainty is None and left >= size:
        yield (
            f"eq. 16 leaves {left / size:.2g} times its own prediction, too unevenly to be told "
            "from scatter: give u_rad, or measure each reversal several times"
        )


def _one_ratio(data: Reversals) -> tuple[str, ...]:
    line = (
        "one ratio of inertias only: effects that scale the deviation cannot be told apart; "
        "vary the inertia of the payload"
    )
    ratios = (np.round(sweep.I_L / sweep.I_m, 12) for sweep in data.sweeps.values())
    return () if any(np.ptp(one) for one in ratios) else (line,)
