"""The same loop on the gears: effects that change eq. 16 are the hypotheses on measured reversals.

A hypothesis is one effect at one joint, or two: its values lie on a grid and are equally likely
beforehand. With residuals r of standard deviations u the log likelihood is -sum (r / u)^2 / 2;
where u is not known it is integrated out under the prior 1 / u, -m/2 log sum (w r)^2, w the weights
of a scatter that grows with a power of the deviation, averaged over the powers. Whether eq. 16
lacks an effect, or one effect a second, F tests over all that could be added say (Bonferroni). In a
run a reversal is half the distance between the approaches, by payload.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import NamedTuple, cast

import numpy as np

from scara_iso.base.errors import DataError
from scara_iso.base.quantities import Dimension
from scara_iso.diagnosis.sweeps import (
    GearDiagnosis,
    GearError,
    GearErrors,
    GearFound,
    Halves,
    Joint,
    RunReversals,
    SweepSeries,
    halves_of,
    rms_of,
)
from scara_iso.diagnosis.verdict import FURTHER_LEVEL, LEVEL, SEED, Choice, Verdict, posterior
from scara_iso.effects import GearEffect, Sizes, Sweep, find_gear_effects
from scara_iso.robot import Model, lever_mm, sweep_of
from scara_iso.run import FloatArray, IntArray, Run

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

MISFIT_LEVEL = 0.01
"""Level at which what a fit leaves of reversals is more than their uncertainties (gear.py)."""

SWEEP_SIMULATIONS = 499
"""Simulations of scatter about eq. 16, and permutations of what a fit to a sweep leaves."""

SCATTER_POWERS = (0.0, 0.5, 1.0)
"""A scatter of reversals that is not known may grow with the deviation by any of these powers
(gear.py, false alarms)."""

_LISTED = 5
_FEWEST = 3


class GearTerm(NamedTuple):
    """An effect at a joint, and the values to try."""

    effect: GearEffect
    joint: Joint
    candidates: tuple[Sizes, ...]

    def at(self, place: FloatArray) -> Sizes:
        """Return the values, columns (k, 1), at places (k,) from the first candidate, 0, to 1."""
        position, index = place * (len(self.candidates) - 1), np.arange(len(self.candidates))
        if len(self.effect.parameters) > 1:
            position = np.round(position)
        found = {
            p.name: np.interp(position, index, [c[p.name] for c in self.candidates])[:, np.newaxis]
            for p in self.effect.parameters
        }
        return cast(Sizes, found)  # an effect takes columns as it takes numbers


Family = tuple[GearTerm, ...]
"""Effects that act together."""
Changes = Sequence[tuple[GearTerm, Sizes]]
"""Effects with their values."""


def free(family: Family) -> int:
    """Return how many effects of a family have something to fit."""
    return sum(len(term.candidates) > 1 for term in family)


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

    def predict(self, changes: Changes = ()) -> FloatArray:
        """Return the predictions, shape (k, m) where values are columns (k, 1), else (1, m)."""
        total = np.zeros((1, len(self.measured)))
        for joint, sweep in self.sweeps.items():
            for term, values in changes:
                if term.joint == joint:
                    sweep = term.effect.changed(sweep, **values)  # noqa: PLW2901 - one after another
            total = total + self.levers[joint] * sweep.deviation
        return np.asarray(total[:, self.rows])

    def even(self, predictions: FloatArray) -> FloatArray:
        """Return what predictions (k, m) leave, made even, for each scatter (p, k, m).

        Where that is not known there is one for each power of the deviation with which it may grow,
        by weights of product 1.
        """
        left = self.seen - predictions
        if self.uncertainty is not None:
            return (left / self.uncertainty[self.rows])[np.newaxis]
        size = np.abs(predictions)
        log = np.log(np.maximum(size, _SMALLEST * size.max(axis=1, keepdims=True)))
        about = log - log.mean(axis=1, keepdims=True)
        return np.stack([left * np.exp(-power * about) for power in SCATTER_POWERS])

    def log_likelihood(self, predictions: FloatArray) -> FloatArray:
        """Return the log likelihood (k,) of predictions (k, m)."""
        squares = (self.even(predictions) ** 2).sum(axis=2)
        if self.uncertainty is not None:
            return np.asarray(-squares[0] / 2)
        floor = (_RELATIVE_FLOOR * np.abs(self.seen).max()) ** 2 + np.finfo(float).tiny
        logs = -len(self.seen) / 2 * np.log(squares + floor)
        return np.asarray(np.logaddexp.reduce(logs) - np.log(len(logs)))


class Fitted(NamedTuple):
    """A family's evidence, its likeliest values, and their 95 % intervals, effect by effect."""

    family: Family
    log_evidence: float
    log_best: float
    values: tuple[Sizes, ...]
    spread: tuple[Mapping[str, tuple[float, float]], ...]

    @property
    def changes(self) -> Changes:
        """The effects with their likeliest values."""
        return list(zip(self.family, self.values, strict=True))

    @property
    def name(self) -> str:
        """The effects by name, such as ``gap+wind_up``, and their joints."""
        at = (f" at joint {term.joint}" if term.joint else "" for term in self.family)
        return "+".join(t.effect.name + where for t, where in zip(self.family, at, strict=True))


def fit_family(data: Reversals, family: Family) -> Fitted:
    """Return the fit of a family, on grids that close in on its likely values."""
    count = free(family)
    box, points = np.tile([0.0, 1.0], (count, 1)), _POINTS[count]
    for breadth in _BREADTHS:
        edges = np.meshgrid(*(np.linspace(low, high, points) for low, high in box))
        places = np.stack([edge.ravel() for edge in edges]) if count else np.zeros((0, 1))
        along, none = iter(places), np.zeros(places.shape[1])
        values = [term.at(next(along) if free((term,)) else none) for term in family]
        log = data.log_likelihood(data.predict(list(zip(family, values, strict=True))))
        if not count or not breadth:
            break
        likely, cell = places[:, log >= log.max() - breadth], np.diff(box)[:, 0] / (points - 1)
        ends = [likely.min(axis=1) - cell, likely.max(axis=1) + cell]  # a cell wider
        box = np.clip(np.stack(ends, axis=1), 0.0, 1.0)
    best, share = int(np.argmax(log)), np.exp(log - log.max())
    volume = float(np.prod(np.diff(box)))
    flat = [{name: np.ravel(value) for name, value in one.items()} for one in values]
    return Fitted(
        family=family,
        log_evidence=float(log.max() + np.log(share.mean() * volume)),
        log_best=float(log.max()),
        values=tuple({name: float(v[best]) for name, v in one.items()} for one in flat),
        spread=tuple(
            {name: _interval(v, share) for name, v in one.items()} if free((term,)) else {}
            for term, one in zip(family, flat, strict=True)
        ),
    )


def _interval(values: FloatArray, share: FloatArray) -> tuple[float, float]:
    order = np.argsort(values, kind="stable")
    risen = np.cumsum(share[order]) / share.sum()
    low, high = np.minimum(np.searchsorted(risen, [0.025, 0.975]), len(values) - 1).tolist()
    return float(values[order[low]]), float(values[order[high]])


def single_families(data: Reversals, effects: Sequence[GearEffect]) -> list[Family]:
    """Return each effect at each joint by itself, as far as the reversals let it be tried."""
    return [
        (GearTerm(effect, joint, candidates),)
        for joint, sweep in data.sweeps.items()
        for effect in effects
        if (candidates := effect.candidates(sweep))
    ]


def _pairs(data: Reversals, singles: Sequence[Family]) -> list[Family]:
    sweeps = data.sweeps.values()
    columns = [s.I_L / s.I_m for s in sweeps] + [s.torque for s in sweeps if s.torque is not None]
    conditions = len(np.unique(np.round(np.stack(columns, axis=1), 12), axis=0))
    most = min(conditions, len(data.measured) - 1)
    return [(*one, *two) for one, two in combinations(singles, 2) if free((*one, *two)) <= most]


def diagnose_reversals(data: Reversals, *, seed: int, sides: int = 1) -> GearDiagnosis:
    """Return what eq. 16 leaves of reversals, and which effects it is; two at the most.

    ``sides`` is 2 where the sign of the reversals was chosen to suit the model.
    """
    singles = single_families(data, find_gear_effects())
    one, before = [fit_family(data, family) for family in singles], data.predict()[0]
    eq_16 = fit_family(data, ())
    chances = _chance(data, [eq_16], one), _chance_of_rest(data, eq_16, seed)
    chance = min(1.0, sides * len(chances) * min(chances))
    rms = rms_of(data.measured - before)
    nothing = GearDiagnosis(
        verdict=Verdict.NOTHING,
        p_value=chance,
        p_value_at_floor=False,
        effects=(),
        candidates=(),
        error=GearErrors(GearError(rms, rms), GearError(rms, rms)),
        series=SweepSeries(data.measured, before, before),
        notes=tuple(_one_ratio(data)),
    )
    if chance > LEVEL:
        return replace(nothing, notes=(*nothing.notes, *_uneven(data, rms, rms_of(before))))
    two = [fit_family(data, family) for family in _pairs(data, singles)]
    fits = two if two and _chance(data, one, two) <= FURTHER_LEVEL else one
    choice = Choice(posterior({fit.name: fit.log_evidence for fit in fits}), {})
    best = next(fit for fit in fits if fit.name == choice.best)
    if _chance_of_rest(data, best, seed) < MISFIT_LEVEL:
        nearest = choice.ranked[:_MOST_CANDIDATES]
        return replace(nothing, verdict=Verdict.UNEXPLAINED, candidates=nearest)
    after = data.predict(best.changes)[0]
    unseen = _left_out(data, [fit.family for fit in fits])
    return replace(
        nothing,
        verdict=Verdict.EXPLAINED,
        effects=_found(best, choice, chance),
        error=replace(nothing.error, after=GearError(rms_of(data.measured - after), unseen)),
        series=replace(nothing.series, predicted_after=after),
    )


def _chance(data: Reversals, simpler: Sequence[Fitted], richer: Sequence[Fitted]) -> float:
    """Return the chance that some richer fit is as much better than every simpler one (F tests)."""
    from scipy.special import fdtrc  # noqa: PLC0415 - heavy

    best, m = max(simpler, key=lambda fit: fit.log_best), len(data.seen)
    chances = []
    for fit in richer:
        more, left = max(1, free(fit.family) - free(best.family)), m - free(fit.family)
        gain = fit.log_best - best.log_best
        ratio, freedom = 2 * gain, min(data.degrees, _MANY)
        if data.uncertainty is None:
            ratio, freedom = np.expm1(2 * max(gain, 0.0) / m) * left, left
        chances.append(float(fdtrc(more, freedom, max(ratio, 0.0) / more)))
    return min(1.0, len(chances) * min(chances))


def _chance_of_rest(data: Reversals, fit: Fitted, seed: int) -> float:
    """Return the chance of as much as a fit leaves in scatter alone.

    Known uncertainties say how much that is; else what is left may follow the inertia: neighbours
    in the order of I_L then differ less than they do when permuted (von Neumann 1941).
    """
    from scipy.special import fdtrc  # noqa: PLC0415 - heavy

    predicted, count = data.predict(fit.changes), len(data.seen) - free(fit.family)
    if data.uncertainty is not None:
        ratio = -2 * fit.log_best / max(count, 1)
        return float(fdtrc(count, min(data.degrees, _MANY), ratio)) if count > 0 else 1.0
    if np.abs(data.seen - predicted).max() < _EXACT * np.abs(predicted).max():
        return 1.0
    (sweep,) = data.sweeps.values()
    course = min(data.even(predicted)[:, 0], key=lambda one: float(one @ one))
    course = course[np.argsort(sweep.I_L, kind="stable")]
    rng = np.random.default_rng(seed)
    permuted = rng.permuted(np.tile(course, (SWEEP_SIMULATIONS, 1)), axis=1)
    steps = (np.diff(np.vstack([course, permuted]), axis=1) ** 2).sum(axis=1)
    return float((steps <= steps[0]).mean())


def _found(best: Fitted, choice: Choice, p_value: float) -> tuple[GearFound, ...]:
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


def _uneven(data: Reversals, left: float, size: float) -> Iterator[str]:
    if data.uncertainty is None and left >= size:
        yield (
            f"eq. 16 leaves {left / size:.2g} times its own prediction, too unevenly to be told "
            "from scatter: give u_rad, or measure each reversal several times"
        )


def _one_ratio(data: Reversals) -> Iterator[str]:
    if not any(np.ptp(np.round(sweep.I_L / sweep.I_m, 12)) for sweep in data.sweeps.values()):
        yield (
            "one ratio of inertias only: effects that scale the deviation cannot be told apart; "
            "vary the inertia of the payload"
        )


def diagnose_sweep(
    sweep: Sweep, measured: FloatArray, *, uncertainty: FloatArray | None = None, seed: int = SEED
) -> GearDiagnosis:
    """Return what eq. 16 leaves of measured load deviations (m,) in rad, and which effect it is.

    Deviations follow eq. 16's sign (negative); ``uncertainty`` (m,) are standard uncertainties.
    Without them the scatter is unknown and may grow with the deviation. Raises `DataError` for
    fewer than 3 reversals.
    """
    m = len(measured)
    if m < _FEWEST:
        raise DataError(
            f"{m} reversals cannot be told from chance",
            remedy=f"measure at least {_FEWEST}, at different inertias",
        )
    data = Reversals(measured, {None: sweep}, {None: np.ones(m)}, np.arange(m), uncertainty)
    found = diagnose_reversals(data, seed=seed)
    without = "no torque_Nm column: wind-up was not tried"
    return replace(found, notes=(*found.notes, without)) if sweep.torque is None else found


def diagnose_run_reversals(run: Run, model: Model, *, seed: int) -> RunReversals | None:
    """Return the reversals of a run by payload against the model's gears.

    None without the columns ``approach`` and ``payload_kg`` or an axis of the plane.
    """
    names = [n for n in "XY" if n in run.axes and run.axes[n].dimension is Dimension.LENGTH]
    if not {"approach", "payload_kg"} <= run.covariates.keys() or not names:
        return None
    halves = halves_of(run, model, names)
    left_out = sorted(set(run.covariates["payload_kg"].tolist()) - set(halves.payload.tolist()))
    listed = ", ".join(f"{p:g}" for p in left_out[:_LISTED]) + ", .." * (len(left_out) > _LISTED)
    notes = [f"payload {listed} kg: approached from one side only, left out"] if left_out else []
    missing = tuple(_missing(model, len(halves.payload)))
    too_few = halves.degrees <= len(names)  # their covariance is all but singular
    if too_few:
        notes.append("no scatter can be told: approach each payload several times from both sides")
    if missing or too_few:
        return RunReversals(halves.reversals(), None, missing, notes=tuple(notes))
    return _compared(halves, model, notes, seed=seed)


def _missing(model: Model, payloads: int) -> Iterator[str]:
    if model.arm is None:
        yield from ("robot.link_1_mm", "robot.link_2_mm")
    if model.joints_deg is None:
        yield "pose.joint_deg"
    if not model.gearboxes:
        yield "gearbox.joint_1"
    for joint, gear in model.gearboxes.items():
        if payloads > 1 and gear.payload_kg is None:
            yield f"gearbox.joint_{joint}.payload_kg"


def _compared(halves: Halves, model: Model, notes: list[str], *, seed: int) -> RunReversals:
    """Return the reversals against eq. 16, along directions in which the scatter is uncorrelated.

    A dial's scatter that comes from a joint is common to X and Y.
    """
    turned, payloads = np.linalg.eigh(halves.covariance)[1].T, len(halves.payload)
    levers = {
        joint: turned @ [lever_mm(model, joint)[name] / 2 for name in halves.names]
        for joint in model.gearboxes
    }
    each = np.tile(halves.payload, len(turned))
    data = Reversals(
        measured=(turned @ halves.half).ravel(),
        sweeps={joint: sweep_of(model, joint, each) for joint in levers},
        levers={joint: np.repeat(lever, payloads) for joint, lever in levers.items()},
        group=np.tile(np.arange(payloads), len(turned)),
        uncertainty=halves.uncertainty(turned).ravel(),
        degrees=halves.degrees,
    )
    before = data.predict()[0]
    mirrored = float(data.measured @ before) < 0
    sign = -1.0 if mirrored else 1.0
    gear = diagnose_reversals(replace(data, measured=sign * data.measured), seed=seed, sides=2)
    after = gear.series.predicted_after
    after = sign * after if gear.verdict is Verdict.EXPLAINED else after
    if mirrored and gear.verdict is not Verdict.NOTHING:
        notes.append(
            "the load rests on the other side of the pose than in the model, ahead of it: "
            "the sizes of the reversals are compared"
        )
    notes += [
        f"wind-up at joint {joint} was not tried: the model lacks gearbox.joint_{joint}.friction, "
        "the torque that holds the gear wound up"
        for joint, box in model.gearboxes.items()
        if box.friction is None
    ]
    by_axis = [turned.T @ values.reshape(len(turned), -1) for values in (before, after)]
    return RunReversals(halves.reversals(*by_axis), gear, (), mirrored, (*notes, *gear.notes))
