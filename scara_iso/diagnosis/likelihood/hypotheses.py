"""The hypotheses about readings: every form of every effect, and courses that carry no name."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np

from scara_iso.diagnosis.tuning import (
    CHANGING_LENGTHS,
    CHANGING_VARIANCES,
    CHANGING_WEIGHT,
    FEWEST_MOVED,
    GAIN,
    LEVELS_WEIGHT,
    ROUGH_LENGTHS,
    ROUGH_VARIANCES,
    ROUGH_WEIGHT,
    SMOOTH_CYCLES,
    SMOOTH_LENGTHS,
    SMOOTH_VARIANCES,
    SMOOTH_WEIGHT,
    SWING_LENGTH,
    SWING_PERIODS,
    UNKNOWN,
)
from scara_iso.effects import CLOCK, Chain, Conditions, Effect, Form, OwnEffect, Process, Shape
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray

_EVERY = "*"
_SAME = 0.9999
"""Cosine from which two courses are one."""


@dataclass(frozen=True, eq=False, slots=True)
class Hypothesis:
    """An effect (or UNKNOWN) in one of its forms.

    ``weight`` is its prior weight among all hypotheses, ``test_weight`` that in the test over it.
    ``ordered`` ones count in the test by permutation, ``named`` ones in the choice of a name.
    """

    effect: str
    form: Form
    weight: float
    test_weight: float = 1.0
    gain: float = GAIN
    ordered: bool = True
    named: bool = True

    @property
    def hidden(self) -> bool:
        """Whether its course is hidden and must be inferred from the readings."""
        return isinstance(self.form, Chain)


def hypotheses_of(effects: Sequence[Effect], conditions: Conditions) -> tuple[Hypothesis, ...]:
    """Return every hypothesis about readings taken under ``conditions``, the unknown included.

    An effect of any column takes those through which no other effect acts. What a user wrote takes
    no other hypothesis away.
    """
    catalogue = [effect for effect in effects if not isinstance(effect, OwnEffect)]
    others = [effect for effect in catalogue if _EVERY not in effect.needs]
    free = conditions.without(
        {name for name in conditions.covariates if any(effect.takes(name) for effect in others)}
    )
    known = [
        hypothesis
        for effect in effects
        for hypothesis in _shared(effect, free if _EVERY in effect.needs else conditions)
    ]
    recorded = {effect.name for effect in catalogue if effect.needs}
    cycle = np.asarray(conditions.cycle, dtype=np.int64).tobytes()
    return (*_not_recorded(known, recorded), *_of_no_name(cycle))


def _shared(effect: Effect, conditions: Conditions) -> tuple[Hypothesis, ...]:
    """Return `_of_effect`; tables of the same cycles and clock share it where no column counts."""
    if effect.needs or effect.hidden_by:
        return _of_effect(effect, conditions)
    cycle = np.asarray(conditions.cycle, dtype=np.int64).tobytes()
    clock = np.asarray(conditions.covariates.get(CLOCK, ()), dtype=np.float64).tobytes()
    return _of_clock(effect, cycle, clock)


@lru_cache(maxsize=64)
def _of_clock(effect: Effect, cycle: bytes, clock: bytes) -> tuple[Hypothesis, ...]:
    seconds = {CLOCK: np.frombuffer(clock)} if clock else {}
    return _of_effect(effect, Conditions(np.frombuffer(cycle, dtype=np.int64), seconds))


@lru_cache(maxsize=4)
def _of_no_name(cycle: bytes) -> tuple[Hypothesis, ...]:
    """Return the hypotheses that carry no name; tables of the same cycles share them."""
    conditions = Conditions(np.frombuffer(cycle, dtype=np.int64))
    return (*_unknown(conditions), *_levels(conditions))


def _not_recorded(members: Sequence[Hypothesis], recorded: Set[str]) -> list[Hypothesis]:
    """Return the members without those shapes that a recorded column has too.

    The column takes their place; ``recorded`` are the effects through columns.
    """
    of_columns = [_turned(m.form) for m in members if m.effect in recorded]
    same = np.array([column for column in of_columns if column is not None])
    if not len(same):
        return list(members)

    def stays(member: Hypothesis) -> bool:
        course = None if member.effect in recorded else _turned(member.form)
        return course is None or float(np.abs(same @ course).max()) < _SAME

    return [member for member in members if stays(member)]


def _turned(form: Form) -> FloatArray | None:
    """Return the course of a shape of one column, centred and of unit length."""
    if not isinstance(form, Shape) or form.columns.shape[1] != 1:
        return None
    centred = form.columns[:, 0] - form.columns[:, 0].mean()
    return np.asarray(centred / np.linalg.norm(centred))


def _of_effect(effect: Effect, conditions: Conditions) -> tuple[Hypothesis, ...]:
    """Return the forms of an effect; those that have an order share its weight, if any has."""
    forms = [form for form in effect.forms(conditions) if not _still(form)]
    ordered = [_has_order(effect, form) for form in forms]
    total = sum(form.weight for form, use in zip(forms, ordered, strict=True) if use)
    total = total or sum(form.weight for form in forms)
    return tuple(
        Hypothesis(
            effect.name,
            form,
            effect.weight * form.weight / total,
            effect.test_weight,
            effect.gain,
            use,
        )
        for form, use in zip(forms, ordered, strict=True)
    )


def _has_order(effect: Effect, form: Form) -> bool:
    """Return whether the test of the order counts a form.

    A shape of the catalogue that moves one or two readings is hardly rarer than any other order.
    """
    if effect.needs or isinstance(effect, OwnEffect) or not isinstance(form, Shape):
        return True
    moved = form.columns != median(form.columns, axis=0)
    return int(moved.any(axis=1).sum()) >= FEWEST_MOVED


def _still(form: Form) -> bool:
    """Return whether a shape moves nothing beside the pose."""
    return isinstance(form, Shape) and not np.ptp(form.columns, axis=0).all()


def _unknown(conditions: Conditions) -> list[Hypothesis]:
    """Return Gaussian processes over the cycles: smooth, of changing width, swinging, rough.

    Smooth ones are squared exponentials; a swing keeps its phase for some cycles.
    """
    lag = np.abs(np.subtract.outer(conditions.elapsed, conditions.elapsed))
    unit = len(conditions) / SMOOTH_CYCLES
    smooth = [np.exp(-0.5 * (lag / (unit * length)) ** 2) for length in SMOOTH_LENGTHS]
    changing = [gibbs(conditions.elapsed, unit * np.array(ends)) for ends in CHANGING_LENGTHS]
    kept = np.exp(-0.5 * (lag / (unit * SWING_LENGTH)) ** 2)
    swinging = [kept * np.cos(2 * np.pi * lag / period) for period in SWING_PERIODS]
    rough = [np.exp(-lag / length) for length in ROUGH_LENGTHS]
    return [
        *_processes(smooth, SMOOTH_VARIANCES, SMOOTH_WEIGHT),
        *_processes([*changing, *swinging], CHANGING_VARIANCES, CHANGING_WEIGHT, test_weight=0.0),
        *_processes(rough, ROUGH_VARIANCES, ROUGH_WEIGHT),
    ]


def gibbs(elapsed: FloatArray, ends: FloatArray) -> FloatArray:
    """Return the correlation (n, n) of a course whose width goes from ``ends[0]`` to ``ends[1]``.

    k(i, j) = sqrt(2 l_i l_j / (l_i^2 + l_j^2)) exp(-(t_i - t_j)^2 / (l_i^2 + l_j^2)), l linear in
    time (Gibbs 1997, eq. 3.40).
    """
    width = np.interp(elapsed, elapsed[[0, -1]], ends)
    squares = width[:, np.newaxis] ** 2 + width**2
    lag = np.subtract.outer(elapsed, elapsed)
    return np.asarray(np.sqrt(2 * np.outer(width, width) / squares) * np.exp(-(lag**2) / squares))


def _processes(
    correlations: Sequence[FloatArray],
    variances: Sequence[float],
    weight: float,
    test_weight: float = 1.0,
) -> list[Hypothesis]:
    each = weight / (len(correlations) * len(variances))
    forms = [Process(c, variance=v) for c in correlations for v in variances]
    return [Hypothesis(UNKNOWN, form, each, test_weight) for form in forms]


def _levels(conditions: Conditions) -> list[Hypothesis]:
    """Return courses of three and four levels: more than any one named effect has."""
    n = len(conditions)
    members = []
    for levels, weight in LEVELS_WEIGHT.items():
        stride = max(levels - 1, (levels - 1) * n // 30)
        changes = list(combinations(range(levels - 1, n - levels + 2, stride), levels - 1))
        shapes = [levels_of(n, at) for at in changes]
        members += [Hypothesis(UNKNOWN, s, weight / len(shapes), ordered=False) for s in shapes]
    return members


def levels_of(n: int, changes: Sequence[int]) -> Shape:
    """Return the course of n cycles whose level changes in these rows, numbers that choose it."""
    columns = np.where(np.arange(n)[:, np.newaxis] >= changes, 1.0, 0.0)
    return Shape(columns, {f"change_{i}": float(row) for i, row in enumerate(changes, start=1)})
