"""The same loop on the gears: effects that change eq. 16 are the hypotheses on measured reversals.

A hypothesis is one effect at one joint, or two: its values lie on a grid and are equally likely
beforehand. With residuals r of standard deviations u the log likelihood is -sum (r / u)^2 / 2;
where u is not known it is integrated out under the prior 1 / u, -m/2 log sum (w r)^2, w the weights
of a scatter that grows with a power of the deviation, averaged over the powers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import cast

import numpy as np

from scara_iso.diagnosis.naming import Choice, posterior
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
from scara_iso.diagnosis.verdict import Verdict
from scara_iso.effects import GearEffect, Grid, Parameter, Sizes, Sweep, find_gear_effects
from scara_iso.run import FloatArray, IntArray

_RELATIVE_FLOOR = 1e-6
"""A reversal is not known better than this share of the largest one."""
_SMALLEST = 1e-3
_BREADTHS = (1000.0, 200.0, 50.0, 20.0, 9.0, 0.0)
"""Log likelihoods below the best within which each finer grid lies."""
_POINTS, _COARSE = {0: 1, 1: 401, 2: 41}, {0: 1, 1: 101, 2: 15}
"""Points of a grid along each coordinate, by the number of these; where the whole is tried."""
_EXACT = 1e-4
"""A fit this close, as a share of the largest deviation, leaves only digits and grid."""
_FLOOR = 1 / (1 + SWEEP_SIMULATIONS)
_MANY = 1e6


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

    def logs(self, readings: FloatArray, predictions: FloatArray) -> FloatArray:
        """Return log likelihoods (p, r, k) of readings (r, m) about predictions (k, m).

        One for each way in which a scatter that is not known may grow with the deviation.
        """
        if self.uncertainty is not None:
            weights = 1 / self.uncertainty[self.rows] + np.zeros_like(predictions)
            return -_squares(readings, predictions, weights)[np.newaxis] / 2
        floor = (_RELATIVE_FLOOR * np.abs(readings).max()) ** 2
        each = [
            _squares(readings, predictions, _even(predictions, power)) for power in SCATTER_POWERS
        ]
        return np.asarray(-readings.shape[1] / 2 * np.log(np.stack(each) + floor))

    def scatters(self, predicted: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return standard deviations (p, m) about a prediction (m,), and how likely each is."""
        if self.uncertainty is not None:
            return self.uncertainty[np.newaxis, self.rows], np.ones(1)
        left, m = self.seen - predicted, len(self.seen)
        weights = np.stack([_even(predicted[np.newaxis], power)[0] for power in SCATTER_POWERS])
        size = np.sqrt(((left * weights) ** 2).mean(axis=1)) + np.finfo(float).tiny
        likely = np.exp(-m * (np.log(size) - np.log(size.min())))
        return size[:, np.newaxis] / weights, likely / likely.sum()


def _even(predictions: FloatArray, power: float) -> FloatArray:
    """Return what makes scatter equal that grows with a power of the deviation; product 1."""
    size = np.abs(predictions)
    log = np.log(np.maximum(size, _SMALLEST * size.max(axis=1, keepdims=True)))
    return np.asarray(np.exp(-power * (log - log.mean(axis=1, keepdims=True))))


def _squares(readings: FloatArray, predictions: FloatArray, weights: FloatArray) -> FloatArray:
    """Return weighted sums of squares (r, k) of readings (r, m) about predictions (k, m)."""
    squared = weights**2
    if len(readings) == 1:  # exact where it matters: no cancellation
        return np.asarray((((readings - predictions) ** 2) * squared).sum(axis=1)[np.newaxis])
    cross, own = readings @ (predictions * squared).T, (readings**2) @ squared.T
    return np.asarray(np.maximum(own - 2 * cross + (predictions**2 * squared).sum(axis=1), 0))


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

    def at(self, place: FloatArray) -> dict[str, FloatArray]:
        """Return the values at places from 0, the first candidate, to 1, the last."""
        position = place * (len(self.candidates) - 1)
        if len(self.effect.parameters) != 1:
            position = np.round(position)
        index = np.arange(len(self.candidates))
        return {
            p.name: np.interp(position, index, [c[p.name] for c in self.candidates])
            for p in self.effect.parameters
        }


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
    box = np.tile([0.0, 1.0], (sum(term.free for term in family), 1))
    for breadth in _BREADTHS:
        places = _grid(box, _POINTS)
        values = _values(family, places)
        logs = data.logs(
            data.seen[np.newaxis], data.predict(list(zip(family, values, strict=True)))
        )
        log = np.logaddexp.reduce(logs[:, 0]) - np.log(len(logs))
        if not len(box) or not breadth:
            break
        box = _closer(box, places[:, log > log.max() - breadth])
    best, share = int(np.argmax(log)), np.exp(log - log.max())
    flat = [{name: np.ravel(v) for name, v in each.items()} for each in values]
    return Fitted(
        family=family,
        log_evidence=float(log.max() + np.log(share.mean() * np.prod(box[:, 1] - box[:, 0]))),
        log_best=float(log.max()),
        values=tuple({name: float(v[best]) for name, v in each.items()} for each in flat),
        spread=tuple(
            {name: _interval(v, share) for name, v in each.items()} if term.free else {}
            for term, each in zip(family, flat, strict=True)
        ),
    )


def _values(family: Family, places: FloatArray) -> list[Sizes]:
    """Return the values of each effect at places (coordinates, k), as columns (k, 1)."""
    free, none = iter(places), np.zeros(places.shape[1])
    found = [term.at(next(free) if term.free else none) for term in family]
    # an effect takes columns as it takes numbers
    return [{name: cast(float, v[:, np.newaxis]) for name, v in each.items()} for each in found]


def _grid(box: FloatArray, points: Mapping[int, int]) -> FloatArray:
    """Return places (coordinates, k) on a grid over a box (coordinates, 2)."""
    edges = [np.linspace(low, high, points[len(box)]) for low, high in box]
    return np.stack([g.ravel() for g in np.meshgrid(*edges)]) if edges else np.zeros((0, 1))


def _closer(box: FloatArray, likely: FloatArray) -> FloatArray:
    """Return the box about likely places (coordinates, k), a cell wider on either side."""
    cell = (box[:, 1] - box[:, 0]) / (_POINTS[len(box)] - 1)
    low = np.maximum(likely.min(axis=1) - cell, 0.0)
    return np.stack([low, np.minimum(likely.max(axis=1) + cell, 1.0)], axis=1)


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
    conditions, rows = _conditions(data), len(data.measured)
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
    said = "measure at more inertias, several times at each"
    return GearEffect(
        name=UNKNOWN, parameters=(parameter,), cause="none known", confirm_by=said, changed=changed
    )


_LEVEL_OF_ANY = _of_any("level", _at_level, -14.0, 2.0)
_POWER_OF_ANY = _of_any("power", _at_power, -2.0, 2.0)


def diagnose_reversals(data: Reversals, *, seed: int, sides: int = 1) -> GearDiagnosis:
    """Return what eq. 16 leaves of reversals, and which effects it is; two at the most.

    ``sides`` is 2 where the sign of the reversals was chosen to suit the model.
    """
    singles = single_families(data, find_gear_effects())
    before, rng = data.predict()[0], np.random.default_rng(seed)
    chance = _chance_of_scatter(data, before, [*singles, *unknown_families(data)], rng)
    at_floor, chance = chance <= _FLOOR, min(1.0, sides * chance)
    rms, one_ratio = rms_of(data.measured - before), _one_ratio(data)
    nothing = GearDiagnosis(
        verdict=Verdict.NOTHING,
        p_value=chance,
        p_value_at_floor=at_floor,
        effects=(),
        candidates=(),
        error=GearErrors(GearError(rms, rms), GearError(rms, rms)),
        series=SweepSeries(data.measured, before, before),
    )
    if chance > LEVEL:
        return replace(nothing, notes=(*one_ratio, *_uneven(data, rms, rms_of(before))))
    families, choice = _chosen(data, singles)
    best = choice.forms[choice.best]
    if choice.best == UNKNOWN or _misfits(data, best) or _wanders(data, best, rng):
        near = tuple(rival for rival in choice.ranked if rival.effect != UNKNOWN)[:3]
        return replace(nothing, verdict=Verdict.UNEXPLAINED, candidates=near, notes=one_ratio)
    after = data.predict(best.changes)[0]
    return replace(
        nothing,
        verdict=Verdict.EXPLAINED,
        effects=_found(best, choice, chance),
        error=replace(
            nothing.error, after=GearError(rms_of(data.measured - after), _left_out(data, families))
        ),
        series=replace(nothing.series, predicted_after=after),
        notes=(*one_ratio, *_settled_by(choice)),
    )


def _chance_of_scatter(
    data: Reversals, before: FloatArray, families: Sequence[Family], rng: np.random.Generator
) -> float:
    """Return how often eq. 16 with scatter alone fits some effect as much better.

    Of the ways in which the scatter may grow, the one that does so most often counts.
    """
    grids = ((family, _grid(np.tile([0.0, 1.0], (sum(t.free for t in family), 1)), _COARSE))
             for family in families)  # fmt: skip
    tried = np.concatenate(
        [data.predict(list(zip(own, _values(own, at), strict=True))) for own, at in grids]
    )

    def gain(readings: FloatArray) -> FloatArray:
        best = (data.logs(readings, p).max(axis=2) for p in (tried, before[np.newaxis]))
        with_any, alone = (np.logaddexp.reduce(one) for one in best)
        return np.asarray(with_any - alone)

    observed, chances = gain(data.measured[np.newaxis])[0], []
    scatters, likely = data.scatters(before)
    for scatter in scatters[likely > RIVAL * likely.max()]:
        noise = rng.normal(size=(SWEEP_SIMULATIONS, len(before))) * scatter
        if np.isfinite(data.degrees):
            drawn = rng.chisquare(data.degrees, size=(SWEEP_SIMULATIONS, 1)) / data.degrees
            noise /= np.sqrt(drawn)
        gains = np.concatenate([gain(piece) for piece in np.array_split(before + noise, 10)])
        chances.append((1 + (gains >= observed).sum()) / (1 + SWEEP_SIMULATIONS))
    return float(max(chances))


def _chosen(data: Reversals, singles: Sequence[Family]) -> tuple[list[Family], Choice[Fitted]]:
    """Return the families that compete, one effect or two, and the choice among their fits."""
    one, pairs = [fit_family(data, family) for family in singles], list(_pairs(data, singles))
    two = [fit_family(data, family) for family in pairs]
    if two and _second_p_value(data, one, two) <= FURTHER_LEVEL:
        return pairs, _choice(two)
    return list(singles), _choice(one)


def _second_p_value(data: Reversals, one: Sequence[Fitted], two: Sequence[Fitted]) -> float:
    """Return the chance that some pair fits as much better than every single effect (F test)."""
    from scipy.special import fdtrc  # noqa: PLC0415 - heavy

    single, m = max(one, key=lambda fit: fit.log_best), len(data.seen)
    chances = []
    for pair in two:
        more, left = max(1, pair.free - single.free), m - pair.free
        gain = pair.log_best - single.log_best
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


def _wanders(data: Reversals, fit: Fitted, rng: np.random.Generator) -> bool:
    """Return whether what a fit leaves follows the inertia, where the scatter is not known.

    Neighbours in the order of I_L differ less than they do when permuted (von Neumann 1941).
    """
    predicted = data.predict(fit.changes)[0]
    left = data.seen - predicted
    if data.uncertainty is not None or np.abs(left).max() < _EXACT * np.abs(predicted).max():
        return False
    scatters, likely = data.scatters(predicted)
    (sweep,) = data.sweeps.values()
    order = np.argsort(sweep.I_L[data.rows], kind="stable")
    left = (left / scatters[int(np.argmax(likely))])[order]
    permuted = rng.permuted(np.tile(left, (SWEEP_SIMULATIONS, 1)), axis=1)
    steps = (np.diff(np.vstack([left, permuted]), axis=1) ** 2).sum(axis=1)
    return bool((1 + (steps[1:] <= steps[0]).sum()) * _FLOOR < MISFIT_LEVEL)


def _choice(fits: Sequence[Fitted]) -> Choice[Fitted]:
    ranked = sorted(fits, key=lambda fit: -fit.log_evidence)
    forms: dict[str, Fitted] = {}
    evidence: dict[str, float] = {}
    for fit in ranked:
        forms.setdefault(fit.name, fit)
        before = evidence.get(fit.name, -np.inf)
        evidence[fit.name] = float(np.logaddexp(before, fit.log_evidence))
    return Choice(posterior(evidence), forms)


def _found(best: Fitted, choice: Choice[Fitted], p_value: float) -> tuple[GearFound, ...]:
    return tuple(
        GearFound(
            effect=term.effect.name,
            joint=term.joint,
            parameters=values,
            intervals=spread,
            p_value=p_value,
            probability=choice.probability[choice.best],
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


def _settled_by(choice: Choice[Fitted]) -> Iterator[str]:
    """Yield one line for each rival: what would tell it from the effects found."""
    best = choice.forms[choice.best].family
    own = {term.effect.name for term in best}
    for rival in choice.rivals:
        family = choice.forms[rival.effect].family
        ways = [t.effect.confirm_by for t in family if t.effect.name not in own]
        ways = ways or [term.effect.confirm_by for term in best]
        yield f"{choice.best} or {rival.effect}: {'; '.join(dict.fromkeys(ways))}"


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
