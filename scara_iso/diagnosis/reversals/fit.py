"""Effects on the gear and what each predicts of the reversals: how well it fits, and where."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Annotated, TypeAlias, cast

import numpy as np

from scara_iso.diagnosis.tuning import SCATTER_POWERS
from scara_iso.effects import GearEffect, Sizes, Sweep
from scara_iso.run import FloatArray, IntArray

Joint: TypeAlias = Annotated[int, ("enum", (1, 2))] | None
"""A joint's number; None for a sweep, which has one joint only."""

_RELATIVE_FLOOR = 1e-6
"""A reversal is not known better than this share of the largest one."""
_SMALLEST = 1e-3
_BREADTHS = (1000.0, 200.0, 50.0, 20.0, 9.0)
"""Log likelihoods below the best within which each finer grid lies."""
_POINTS = {0: 1, 1: 401, 2: 41}
"""Points of a grid along each of its coordinates, by the number of these."""
_COARSE = {0: 1, 1: 101, 2: 15}
"""The same where the whole range is tried."""


@dataclass(frozen=True, eq=False, slots=True)
class Reversals:
    """Measured reversals, shape (m,), and what eq. 16 needs to predict them.

    The prediction is the sum over the joints of lever times load deviation. Of ``uncertainty``
    (standard; None where the scatter is not known) ``degrees`` are the degrees of freedom. Rows
    of one ``group`` are left out together.
    """

    measured: FloatArray
    sweeps: Mapping[Joint, Sweep]
    levers: Mapping[Joint, FloatArray]
    group: IntArray
    uncertainty: FloatArray | None = None
    degrees: float = np.inf
    rows: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))

    def __post_init__(self) -> None:
        if not len(self.rows):
            object.__setattr__(self, "rows", np.arange(len(self.measured)))

    def predict(self, changes: Sequence[tuple[GearTerm, Sizes]] = ()) -> FloatArray:
        """Return the predictions, shape (m,), or (k, m) where the values are columns (k, 1)."""
        total = np.zeros(len(self.measured))
        for joint, sweep in self.sweeps.items():
            for term, values in changes:
                if term.joint == joint:
                    sweep = term.effect.changed(sweep, **values)  # noqa: PLW2901 - one after another
            total = total + self.levers[joint] * sweep.deviation
        return np.asarray(np.atleast_2d(total)[:, self.rows] if changes else total[self.rows])

    def without(self, group: int) -> Reversals:
        """Return the same with only the rows of other groups taken into account."""
        return replace(self, rows=np.flatnonzero(self.group != group))

    @property
    def scale(self) -> FloatArray:
        """Standard uncertainties of the rows taken into account; ones where not known."""
        if self.uncertainty is None:
            return np.ones(len(self.rows))
        return np.asarray(self.uncertainty[self.rows])

    def log_likelihood(self, predictions: FloatArray) -> FloatArray:
        """Return the log likelihoods (k,) of what was measured under predictions (k, m).

        A scatter that is not known is integrated out under the prior 1 / scatter, and averaged
        over the ways in which it may grow with the deviation.
        """
        measured = self.measured[self.rows][np.newaxis]
        logs = [self._log(measured, squares[0]) for squares in self._squares(measured, predictions)]
        return np.asarray(np.logaddexp.reduce(logs, axis=0) - np.log(len(logs)))

    def best_log_likelihood(self, readings: FloatArray, predictions: FloatArray) -> FloatArray:
        """Return what the best of predictions (k, m) gives to each of readings (r, m), (r,)."""
        smallest = (s.min(axis=1) for s in self._squares(readings, predictions))
        logs = [self._log(readings, squares) for squares in smallest]
        return np.asarray(np.logaddexp.reduce(logs, axis=0) - np.log(len(logs)))

    def _squares(self, readings: FloatArray, predictions: FloatArray) -> Iterator[FloatArray]:
        """Yield the misfits (r, k) for each way in which the scatter may grow."""
        if self.uncertainty is not None:
            yield _squares(readings, predictions, np.asarray(1 / self.scale))
            return
        for power in SCATTER_POWERS:
            yield _squares(readings, predictions, _weight(predictions, power))

    def _log(self, readings: FloatArray, squares: FloatArray) -> FloatArray:
        if self.uncertainty is not None:
            return -squares / 2
        floor = (_RELATIVE_FLOOR * np.abs(readings).max()) ** 2
        return np.asarray(-readings.shape[1] / 2 * np.log(squares + floor))

    def scatters(self, predicted: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return standard deviations (p, m) about a prediction, and how likely each is, (p,)."""
        if self.uncertainty is not None:
            return self.scale[np.newaxis], np.ones(1)
        left, m = self.measured[self.rows] - predicted, len(self.rows)
        weights = np.stack([_weight(predicted[np.newaxis], power)[0] for power in SCATTER_POWERS])
        size = np.sqrt(((left * weights) ** 2).mean(axis=1)) + np.finfo(float).tiny
        likely = np.exp(-m * (np.log(size) - np.log(size.min())))
        return size[:, np.newaxis] / weights, likely / likely.sum()


def _weight(predictions: FloatArray, power: float) -> FloatArray:
    """Return what makes scatter equal that grows with a power of the deviation; product 1."""
    size = np.abs(predictions)
    log = np.log(np.maximum(size, _SMALLEST * size.max(axis=1, keepdims=True)))
    return np.asarray(np.exp(-power * (log - log.mean(axis=1, keepdims=True))))


def _squares(readings: FloatArray, predictions: FloatArray, weight: FloatArray) -> FloatArray:
    """Return weighted sums of squares (r, k) of readings (r, m) about predictions (k, m)."""
    squared = np.broadcast_to(weight**2, predictions.shape)
    if len(readings) == 1:  # exact where it matters: no cancellation
        return np.asarray((((readings - predictions) ** 2) * squared).sum(axis=1)[np.newaxis])
    cross = readings @ (predictions * squared).T
    own = (readings**2) @ squared.T
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
    """A family's fit: its evidence, and the likelihood over the finest grid of its values."""

    family: Family
    log_evidence: float
    log_best: float
    values: tuple[Sizes, ...]
    """Most likely values, for each effect of the family."""
    spread: tuple[Mapping[str, tuple[float, float]], ...]
    """95 % intervals, likewise."""

    @property
    def name(self) -> str:
        """The effects by name, such as ``gap+wind_up``."""
        return "+".join(term.effect.name for term in self.family)

    @property
    def changes(self) -> list[tuple[GearTerm, Sizes]]:
        """The effects with their most likely values."""
        return list(zip(self.family, self.values, strict=True))


def fit_family(data: Reversals, family: Family) -> Fitted:
    """Return the fit of a family, on grids that close in on its likely values."""
    box = _whole(family)
    for breadth in (*_BREADTHS, 0.0):
        places = _grid(box, _POINTS)
        values = _values(family, places)
        predictions = data.predict(list(zip(family, values, strict=True)))
        log = data.log_likelihood(predictions)
        if not len(box) or not breadth:
            break
        box = _closer(box, places[:, log > log.max() - breadth])
    best, share = int(np.argmax(log)), np.exp(log - log.max())
    volume = np.prod(box[:, 1] - box[:, 0])
    flat = [{name: np.ravel(v) for name, v in each.items()} for each in values]
    chosen = tuple({name: float(v[best]) for name, v in each.items()} for each in flat)
    return Fitted(
        family=family,
        log_evidence=float(log.max() + np.log(share.mean() * volume)),
        log_best=float(log.max()),
        values=chosen,
        spread=tuple(
            {name: _interval(v, share) for name, v in each.items()} if term.free else {}
            for term, each in zip(family, flat, strict=True)
        ),
    )


def over_all(family: Family) -> list[tuple[GearTerm, Sizes]]:
    """Return a family with values all over their range, as columns (k, 1)."""
    values = _values(family, _grid(_whole(family), _COARSE))
    return list(zip(family, values, strict=True))


def _whole(family: Family) -> FloatArray:
    return np.tile([0.0, 1.0], (sum(term.free for term in family), 1))


def _values(family: Family, places: FloatArray) -> list[Sizes]:
    """Return the values of each effect at places (coordinates, k), as columns (k, 1)."""
    free = [term for term in family if term.free]
    return [
        {
            # an effect takes columns as it takes numbers
            name: cast(float, found[:, np.newaxis])
            for name, found in term.at(
                places[free.index(term)] if term.free else np.zeros(places.shape[1])
            ).items()
        }
        for term in family
    ]


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


def pair_families(singles: Sequence[Family], conditions: int, rows: int) -> Iterator[Family]:
    """Yield pairs of effects, with parameters no more than conditions and fewer than rows."""
    for (first,), (second,) in combinations(singles, 2):
        free = first.free + second.free
        if free <= conditions and free < rows:
            yield first, second
