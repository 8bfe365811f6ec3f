"""The hypotheses about readings: forms of effects, and courses of no name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import compress

import numpy as np

from scara_iso.diagnosis.verdict import UNKNOWN
from scara_iso.effects import CLOCK, Conditions, Effect, Form, OwnEffect, Process, Shape, outlier
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray

_EVERY = "*"
_SAME = 0.9999
"""Cosine from which two courses are one."""

# the unknown (table *outside*)

SMOOTH_WEIGHT, SMOOTH_LENGTHS, SMOOTH_VARIANCES = 0.4, (1.5, 3.0, 6.0, 12.0), (0.5, 2.0, 8.0)
SMOOTH_CYCLES = 30
"""The run of which SMOOTH_LENGTHS are lengths in cycles; longer runs have longer ones."""

CHANGING_LENGTHS = ((3.0, 1.0), (1.0, 3.0))
"""Widths at the first and the last cycle."""
SWINGS = (
    (12.0, 3.0, 0.7),
    (10.0, 2.6, 0.7),
    (4.0, 10.0, 0.7),
    (8.0, 8.0, 0.7),
    (5.5, 5.5, 0.7),
    (4.2, 4.2, 2.0),
    (3.0, 3.0, 2.0),
)
"""Periods at the first and the last cycle, and how many a phase is kept for (ablation.py, chirp;
test_off_the_list.py, beat)."""
CHANGING_WEIGHT, CHANGING_VARIANCES = 0.5, (2.0, 8.0, 32.0)

RECURRING, RECURRING_WEIGHT, RECURRING_VARIANCES = (4, 5, 6, 7, 8), 0.01, (2.0, 8.0, 32.0)
"""Cycles after which a course recurs, as a tooth or an index comes round; with more weight a sine
of so many cycles is no longer sure (test_off_the_list.py). Of 2 and 3 it is the sides or a sine."""

ODD = outlier.EFFECT.name
"""Name of the effect of single readings."""
SIZE_AT = "size_at_cycle_"
"""How the size of one of several odd readings is named, its cycle behind it."""

FEWEST_MOVED = 3
"""A course that moves fewer readings than this is hardly rarer than any other order, and cannot be
told from as many gross readings."""

GAIN = 15.0
"""Prior variance of a coefficient over that of the scatter: the g-prior's (table *power*)."""


@dataclass(frozen=True, eq=False, slots=True)
class Hypothesis:
    """An effect (or UNKNOWN) in one of its forms.

    ``weight`` is its prior weight among all hypotheses, ``test_weight`` that in the test over it.
    ``ordered`` ones count in the test by permutation. A course that axes share is ``of`` a form.
    """

    effect: str
    form: Form
    weight: float
    test_weight: float = 1.0
    gain: float = GAIN
    ordered: bool = True
    of: Form | None = None


def hypotheses_of(
    effects: Sequence[Effect], conditions: Conditions, of: IntArray | None = None
) -> tuple[Hypothesis, ...]:
    """Return every hypothesis about readings taken under ``conditions``, the unknown included.

    An effect of any column takes those through which no other effect acts. A recorded column takes
    the place of a shape of the same course; what a user wrote takes none away. ``of`` is that of
    `of_visits`.
    """
    catalogue = [effect for effect in effects if not isinstance(effect, OwnEffect)]
    others = [effect for effect in catalogue if _EVERY not in effect.needs]

    def left(columns: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        return {n: c for n, c in columns.items() if not any(one.takes(n) for one in others)}

    visits = {pose: left(columns) for pose, columns in conditions.visits.items()}
    free = Conditions(conditions.cycle, left(conditions.covariates), visits)
    plain = tuple(effect for effect in effects if not effect.needs and not effect.hidden_by)
    clock = np.asarray(conditions.covariates.get(CLOCK, ()), dtype=np.float64).tobytes()
    cycle = np.asarray(conditions.cycle, dtype=np.int64).tobytes()
    shared, unknown = _of_cycles(plain, cycle, clock)
    known = [
        hypothesis
        for effect in effects
        for hypothesis in shared.get(effect)
        or _of_effect(effect, free if _EVERY in effect.needs else conditions, of)
    ]
    by_column = {effect.name for effect in catalogue if effect.needs}
    return (*_not_recorded(known, by_column), *unknown)


@lru_cache(maxsize=8)
def _of_cycles(
    plain: tuple[Effect, ...], cycle: bytes, clock: bytes
) -> tuple[dict[Effect, tuple[Hypothesis, ...]], tuple[Hypothesis, ...]]:
    """Return the forms of effects without columns, and the unknown; tables alike share them."""
    seconds = {CLOCK: np.frombuffer(clock)} if clock else {}
    conditions = Conditions(np.frombuffer(cycle, dtype=np.int64), seconds)
    return {effect: _of_effect(effect, conditions) for effect in plain}, _unknown(conditions)


def _not_recorded(members: Sequence[Hypothesis], recorded: Set[str]) -> list[Hypothesis]:
    of_columns = [_turned(m.form) for m in members if m.effect in recorded]
    same = np.array([column for column in of_columns if column is not None])
    if not len(same):
        return list(members)

    def stays(member: Hypothesis) -> bool:
        course = None if member.effect in recorded else _turned(member.form)
        return course is None or float(np.abs(same @ course).max()) < _SAME

    return [member for member in members if stays(member)]


def of_visits(
    forms: Callable[[Conditions], Sequence[Form]], conditions: Conditions, of: IntArray
) -> tuple[Shape, ...]:
    """Return the shapes among ``forms`` that take columns of which each pose has its own.

    ``of`` (views,) says which pose each view shows; -1 is the mean of all.
    """
    at_poses = (forms(conditions.at(pose)) for pose in conditions.visits)
    each = ([form for form in found if isinstance(form, Shape)] for found in at_poses)
    found = []
    for same in zip(*each, strict=False):
        columns = np.hstack([one.columns for one in same])
        alike = all(one.parameters == same[0].parameters for one in same)
        if alike and columns.shape[1] == len(same) and np.ptp(columns, axis=1).any():
            columns = np.column_stack([columns, columns.mean(axis=1)])
            found.append(replace(same[0], columns=columns, of=of))
    return tuple(found)


def on_axes(form: Form, axes: IntArray) -> Form:
    """Return a form as some of the axes have it."""
    return form if form.of is None else replace(form, of=form.of[axes])


def _turned(form: Form) -> FloatArray | None:
    if form.columns.shape[1] != 1:
        return None
    centred = form.columns[:, 0] - form.columns[:, 0].mean()
    return np.asarray(centred / np.linalg.norm(centred))


def _of_effect(
    effect: Effect, conditions: Conditions, of: IntArray | None = None
) -> tuple[Hypothesis, ...]:
    """Return the forms of an effect; those that have an order share its weight, if any has."""
    own = () if of is None or not effect.needs else of_visits(effect.forms, conditions, of)
    forms = [f for f in (*effect.forms(conditions), *own) if np.ptp(f.columns, axis=0).all()]
    ordered = [_has_order(effect, form) for form in forms]
    total = sum(compress((form.weight for form in forms), ordered))
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


def _unknown(conditions: Conditions) -> tuple[Hypothesis, ...]:
    """Return Gaussian processes over the cycles: smooth, of changing width, swinging, recurring.

    Smooth ones are squared exponentials; any course may recur after so many cycles.
    """
    lag = np.abs(np.subtract.outer(conditions.elapsed, conditions.elapsed))
    unit = len(conditions) / SMOOTH_CYCLES
    smooth = [np.exp(-0.5 * (lag / (unit * length)) ** 2) for length in SMOOTH_LENGTHS]
    changing = [gibbs(conditions.elapsed, unit * np.array(ends)) for ends in CHANGING_LENGTHS]
    swinging = [swing(conditions.elapsed, unit * np.array(e), keeps) for *e, keeps in SWINGS]
    recurring = [
        (lag % period == 0).astype(np.float64) for period in RECURRING if 3 * period <= len(lag)
    ]
    kinds = (
        (smooth, SMOOTH_VARIANCES, SMOOTH_WEIGHT),
        ([*changing, *swinging], CHANGING_VARIANCES, CHANGING_WEIGHT),
        (recurring, RECURRING_VARIANCES, RECURRING_WEIGHT),
    )
    return tuple(
        Hypothesis(UNKNOWN, Process(c, variance=v), weight / (len(courses) * len(variances)))
        for courses, variances, weight in kinds
        for c in courses
        for v in variances
    )


def gibbs(elapsed: FloatArray, ends: FloatArray) -> FloatArray:
    """Return the correlation (n, n) of a course whose width goes from ``ends[0]`` to ``ends[1]``.

    k(i, j) = sqrt(2 l_i l_j / (l_i^2 + l_j^2)) exp(-(t_i - t_j)^2 / (l_i^2 + l_j^2)), l linear in
    time (Gibbs 1997, eq. 3.40).
    """
    width = np.interp(elapsed, elapsed[[0, -1]], ends)
    squares = width[:, np.newaxis] ** 2 + width**2
    lag = np.subtract.outer(elapsed, elapsed)
    return np.asarray(np.sqrt(2 * np.outer(width, width) / squares) * np.exp(-(lag**2) / squares))


def swing(elapsed: FloatArray, ends: FloatArray, keeps: float) -> FloatArray:
    """Return the correlation (n, n) of a swing whose period goes from ``ends[0]`` to ``ends[1]``.

    k(i, j) = cos(2 pi d) exp(-(d / c)^2 / 2), d the periods between i and j, of which the phase is
    kept for c = ``keeps``.
    """
    frequency = 1 / np.interp(elapsed, elapsed[[0, -1]], ends)
    between = np.diff(elapsed) * (frequency[1:] + frequency[:-1]) / 2
    periods = np.append(0.0, np.cumsum(between))
    apart = np.subtract.outer(periods, periods)
    return np.asarray(np.cos(2 * np.pi * apart) * np.exp(-0.5 * (apart / keeps) ** 2))
