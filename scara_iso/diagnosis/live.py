"""What the readings of a test say while it runs: evidence, alarm, likeliest cause.

The readings so far are looked at now and then, by the test of the order that `diagnose` makes:
permuting whole cycles is exact whatever the distribution, and all channels (axes at poses) count
together. Of a planned length the looks spend the level as O'Brien and Fleming (1979) do: little
early, nearly all at the end. An open length has a look with every tenth cycle more, and the share
of the level that is left falls with the logarithm of the cycles, so that it never ends.

What a pause does to a course nobody knows beforehand. It may go on meanwhile (creep, the room),
stand (wear), or begin anew (what had warmed has cooled): each is as likely.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from statistics import NormalDist

import numpy as np

from scara_iso.diagnosis.engine.evidence import HypothesisSet, build, constant, views_of
from scara_iso.diagnosis.engine.hypotheses import Hypothesis, hypotheses_of
from scara_iso.diagnosis.engine.naming import choose
from scara_iso.diagnosis.engine.order import drawn_in, order_test
from scara_iso.diagnosis.verdict import FEWEST_CYCLES, Choice, Watched
from scara_iso.effects import Conditions, Form, Process, Shape, Spread, find_effects
from scara_iso.run import FloatArray, IntArray

ALARM = 20.0
"""Evidence at which it is said that something acts: one over the level."""
MOST_PLANNED = 60
"""A test of more cycles is watched as one of open length: looks would wait a third of it."""
_FIRST, _EVERY = 10, 2
_BOUNDARY = 2.05
"""A look after a share t of the planned readings is an alarm from the normal quantile of p that is
this over the root of t. All looks together then reach it in 4.0 to 4.5 % of tests of 20 to 60
readings (benchmarks/watch.py, as all figures here)."""
_OPEN = 0.1
"""Sum of the levels of all looks of an open length, of which alarms come together: in 3.5 % of
recordings within 260 cycles, and hardly more afterwards."""
_FEWEST_ORDERS = 1999
_MOST_ROWS = 120
"""Of more readings the means of neighbours are tested: they are exchangeable too."""
_NAMED_FROM = 100
"""The name is sought in so many of the last readings."""
_STILL = 0.02
"""Share of its travel up to which a course has not begun."""
_NOTHING = 1.0
_DIGITS, _SHARE = 6, 3

PAUSE = 20
"""A pause is as long as so many cycles: ten minutes where one takes half a minute."""


def level_of(taken: int, planned: int | None) -> float:
    """Return the level of the look after ``taken`` of ``planned`` readings; 0 for no look."""
    if planned is not None:
        due = taken >= _FIRST and (taken - _FIRST) % _EVERY == 0
        if not (FEWEST_CYCLES <= taken <= planned and (due or taken == planned)):
            return 0.0
        return NormalDist().cdf(-_BOUNDARY * math.sqrt(planned / taken))
    before, look = 0, _FIRST
    while look < taken:
        before, look = look, look + max(_EVERY, look // 10)
    return _OPEN * (_left(before) - _left(look)) if look == taken else 0.0


def _left(taken: int) -> float:
    """Return the share of the level of an open length that is left after so many readings."""
    return 1 / (1 + math.log(max(1.0, 1.2 * taken / _FIRST)) / 2)


def look(values: FloatArray, level: float, rng: np.random.Generator) -> float:
    """Return the evidence of one look at the readings so far, ``values`` (n, channels).

    The largest evidence of all looks reaches `ALARM` in at most 5 % of tests in which nothing acts.
    """
    each = math.ceil(len(values) / _MOST_ROWS)
    whole = values[: len(values) // each * each]
    means = drawn_in(whole).reshape(-1, each, values.shape[1]).mean(axis=1)
    hypotheses = tested_after(len(means))
    views = views_of(means, hypotheses.basis)
    orders = max(_FEWEST_ORDERS, math.ceil(2 / level))  # so that p may come below the level
    return ALARM * level / order_test(hypotheses, views, rng, permutations=orders).p_value


@cache
def tested_after(n: int) -> HypothesisSet:
    """Return what the test compares after ``n`` readings."""
    rows: IntArray = np.arange(n)
    every = hypotheses_of(find_effects(), Conditions(rows + 1, {}))
    return build([m for m in every if m.test_weight and m.ordered], rows, constant(n))


def named_over(cycles: IntArray, pauses: Sequence[int] = ()) -> list[Hypothesis]:
    """Return the hypotheses with a name over the readings of ``cycles`` (n,), numbered in turn.

    ``pauses`` are the numbers of readings before which the robot stood; there is one on each clock
    by which its course may run through them.
    """
    rows = np.arange(len(cycles))
    behind = np.searchsorted(np.array(pauses), rows, side="right")
    clocks = [rows, rows + PAUSE * behind, rows - np.array([0, *pauses])[behind]]
    effects = find_effects()
    how_many = {one.name: 1 + bool(pauses) * (1 + one.smooth) for one in effects}
    every = np.arange(cycles[0], cycles[0] + len(cycles) + PAUSE * len(pauses))
    named = [m for m in hypotheses_of(effects, Conditions(every, {})) if m.ordered]
    counts = [how_many.get(m.effect, 2) if pauses else 1 for m in named]
    return [
        replace(m, form=_on(m.form, clock), weight=m.weight / count)
        for m, count in zip(named, counts, strict=True)
        for clock in clocks[:count]
    ]


def _on(form: Form, rows: IntArray) -> Form:
    match form:
        case Shape():
            return replace(form, columns=form.columns[rows])
        case Process():
            return replace(form, unit=form.unit[np.ix_(rows, rows)])
        case Spread():
            return replace(form, scale=form.scale[rows])
    return form


def explained(values: FloatArray, cycles: IntArray, pauses: Sequence[int] = ()) -> Choice:
    """Return how likely each effect is in readings (n, channels) of ``cycles``.

    The unknown is the likeliest where nothing known fits better; ``pauses`` as in `named_over`.
    """
    n = len(cycles)
    hypotheses = build(named_over(cycles, pauses), np.arange(n), constant(n))
    return choose(hypotheses, views_of(values, hypotheses.basis))


def _begin(form: Form) -> int:
    """Return the row at which a course begins to move: 0 where it does from the first on."""
    if not form.columns.size:
        return 0
    travel = np.abs(form.columns - form.columns[0]).max(axis=1)
    first = int(np.argmax(travel > _STILL * travel.max()))
    return first if first > 1 else 0


class Monitor:
    """Judges a test cycle by cycle. What it says depends on its cycles, pauses, plan and seed.

    ``planned`` cycles include the first, which has no part in the tests; None, or more than
    `MOST_PLANNED`, is an open length. Over the whole test an alarm comes in at most 5 % of tests in
    which the cycles are exchangeable, whatever the distribution of their readings.
    """

    def __init__(self, *, planned: int | None, seed: int) -> None:
        self._planned = planned - 1 if planned and planned <= MOST_PLANNED else None
        self._seed = seed
        self._values: list[Sequence[float]] = []
        self._evidence: list[float] = []
        self._pauses: set[int] = set()

    def take(self, values: Sequence[float]) -> None:
        """Take the next cycle's ``values``, one for each channel; those of cycle 1 count not."""
        self._values.append(values)
        n, found = len(self._values) - 1, self.evidence
        if found < ALARM and (level := level_of(n, self._planned)):
            rng = np.random.default_rng([self._seed, n])
            found = max(found, look(np.array(self._values[1:]), level, rng))
        self._evidence.append(found)

    def pause(self) -> None:
        """Note that the robot stood before the next cycle."""
        self._pauses.add(self.cycles)

    def strike(self, cycle: int) -> None:
        """Forget a cycle, from 1, and those behind it."""
        del self._values[cycle - 1 :], self._evidence[cycle - 1 :]
        self._pauses = {min(before, cycle - 1) for before in self._pauses}

    @property
    def cycles(self) -> int:
        """How many cycles were taken."""
        return len(self._values)

    @property
    def evidence(self) -> float:
        """The largest evidence so far: an alarm from `ALARM` on."""
        return self._evidence[-1] if self._evidence else _NOTHING

    def watched(self) -> Watched:
        """Return what is known with the last cycle."""
        evidence = float(f"{self.evidence:.{_DIGITS}g}")
        if self.evidence < ALARM:
            return Watched(self.cycles, evidence, "nothing yet")
        n = min(self.cycles - 1, _NAMED_FROM)
        cycles = np.arange(self.cycles - n, self.cycles) + 1
        stood = (int(before - cycles[0]) + 1 for before in sorted(self._pauses))
        pauses = [before for before in stood if 0 < before < n]
        values = drawn_in(np.array(self._values[-n:]))
        choice = explained(values, cycles, pauses)
        rivals = {one.effect: round(one.probability, _SHARE) for one in choice.rivals}
        return Watched(
            self.cycles,
            evidence,
            "structure",
            choice.best,
            int(cycles[_begin(choice.forms[choice.best])]),
            round(choice.probability[choice.best], _SHARE),
            rivals,
        )
