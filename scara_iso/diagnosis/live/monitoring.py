"""What the readings of a test say while it runs, cycle by cycle: evidence, alarm, likeliest cause.

Exactly one test governs a recording: looks at ranks where a length is planned (`looks`), else a
test martingale (`e_process`). All channels (axes at poses) count together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from scara_iso.diagnosis.likelihood.evidence import views_of
from scara_iso.diagnosis.live.e_process import EProcess
from scara_iso.diagnosis.live.going_on import begun, named_over
from scara_iso.diagnosis.live.looks import ALARM, MOST_PLANNED, is_look, look
from scara_iso.diagnosis.naming.choice import Choice, choose
from scara_iso.diagnosis.rivals.next_cycles import NextCycles, right_after
from scara_iso.diagnosis.tuning import GROSS
from scara_iso.effects import Form, Shape
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray

_NAMED_FROM = 100
"""The name is sought in so many of the last readings."""
_STILL = 0.02
"""Share of its travel up to which a course has not begun."""
_NOTHING = 1.0
WAYS_ON = ((True, 4), (False, 4), (False, 10))
"""Whether behind a pause, and so many cycles, by which rivals may be told apart."""


@dataclass(frozen=True, slots=True)
class Suspicion:
    """What is known after a cycle; alarm from evidence `ALARM` on, and for all cycles after it.

    ``effect`` is the likeliest one so far (or the unknown), ``since`` the cycle from which it acts,
    ``share`` its probability and ``rivals`` those of others at least a tenth as likely; there are
    none without alarm. ``next`` are ways to go on that may tell rivals apart, the best one first.
    """

    evidence: float
    alarm: bool = False
    effect: str | None = None
    since: int | None = None
    share: float | None = None
    rivals: Mapping[str, float] | None = None
    next: tuple[NextCycles, ...] = ()


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
        self._noise: list[FloatArray] = []
        self._evidence: list[float] = []
        self._pauses: set[int] = set()
        self._e_process: EProcess | None = None

    def take(self, values: Sequence[float]) -> None:
        """Take the next cycle's ``values``, one for each channel; those of cycle 1 count not."""
        noise = np.random.default_rng([self._seed, len(self._values)]).random((2, len(values)))
        self._values.append(values)
        self._noise.append(noise[0])
        if len(self._values) == 1:
            self._evidence.append(_NOTHING)
        else:
            self._evidence.append(max(self._evidence[-1], self._looked(noise[1])))

    def pause(self) -> None:
        """Note that the robot stood before the next cycle."""
        self._pauses.add(self.cycles)

    def strike(self, cycle: int) -> None:
        """Forget a cycle, from 1, and those behind it."""
        kept = self._values[: cycle - 1]
        self._pauses = {min(before, cycle - 1) for before in self._pauses}
        if self._planned is not None:
            self._values, self._noise = kept, self._noise[: cycle - 1]
            self._evidence = self._evidence[: cycle - 1]
            return
        self._values, self._noise, self._evidence, self._e_process = [], [], [], None
        for values in kept:
            self.take(values)

    @property
    def cycles(self) -> int:
        """How many cycles were taken."""
        return len(self._values)

    @property
    def evidence(self) -> float:
        """The largest evidence so far: an alarm from `ALARM` on."""
        return self._evidence[-1] if self._evidence else _NOTHING

    @property
    def suspicion(self) -> Suspicion:
        """What is known with the last cycle."""
        evidence = self.evidence
        if evidence < ALARM:
            return Suspicion(evidence)
        n = min(self.cycles - 1, _NAMED_FROM)
        cycles = np.arange(self.cycles - n, self.cycles) + 1
        pauses = [int(before - cycles[0]) + 1 for before in sorted(self._pauses)]
        pauses = [before for before in pauses if 0 < before < n]
        values, planned = drawn_in(np.array(self._values[-n:])), self._planned or 0
        choice = explained(values, cycles, planned, pauses)
        since = int(cycles[_begin(choice.forms[choice.best])])
        rivals = {one.effect: one.probability for one in choice.rivals}
        return Suspicion(
            evidence,
            True,
            choice.best,
            since,
            choice.probability[choice.best],
            rivals,
            ways_on(values, cycles, choice, planned, pauses) if rivals else (),
        )

    def _looked(self, within: FloatArray) -> float:
        """Return the evidence with the last cycle, which lies ``within`` its rank (0 to 1)."""
        values, noise = np.array(self._values[1:]), np.array(self._noise[1:])
        if self._planned is None:
            self._e_process = self._e_process or EProcess(values.shape[1])
            return float(self._e_process.take(_rank_of_last(values, noise, within)).mean())
        if self._evidence[-1] >= ALARM or not is_look(len(values), self._planned):
            return _NOTHING
        rng = np.random.default_rng([self._seed, 0, len(values)])
        return look(values, noise, self._planned, rng)


def _rank_of_last(values: FloatArray, noise: FloatArray, within: FloatArray) -> FloatArray:
    """Return the rank of the last row among all, from 0 to 1, ties broken by ``noise``."""
    before, last = values[:-1], values[-1]
    tied = (before == last) & (noise[:-1] < noise[-1])
    return np.asarray(((before < last).sum(axis=0) + tied.sum(axis=0) + within) / len(values))


def explained(
    values: FloatArray, cycles: IntArray, planned: int = 0, pauses: Sequence[int] = ()
) -> Choice[Form]:
    """Return how likely each effect is in readings (n, channels) of ``cycles``.

    The unknown is the likeliest where nothing known fits better. ``planned`` readings and
    ``pauses`` are those of `named_over`.
    """
    hypotheses = begun(named_over(cycles, planned, pauses), len(cycles))
    return choose(hypotheses, views_of(values, hypotheses.basis))


def ways_on(
    values: FloatArray, cycles: IntArray, choice: Choice[Form], planned: int, pauses: list[int]
) -> tuple[NextCycles, ...]:
    """Return ways to go on after ``cycles``, that which leaves the likeliest name surest first."""
    n, found = len(cycles), []
    for pause, more in WAYS_ON:
        members = named_over(
            np.arange(n + more) + cycles[0], planned, [*pauses, n] if pause else pauses
        )
        rng = np.random.default_rng(n)
        right = right_after(values, choice.probability, members, rng)
        found.append(NextCycles(pause, more, right))
    return tuple(sorted(found, key=lambda one: -one.right))


def drawn_in(values: FloatArray) -> FloatArray:
    """Return values with gross ones drawn in, so that no single reading gives the name."""
    middle = median(values, axis=0)
    robust = 1.4826 * median(np.abs(values - middle), axis=0)
    limit = np.where(robust > 0, GROSS * robust, np.inf)
    return np.clip(values, middle - limit, middle + limit)


def _begin(form: Form) -> int:
    """Return the row at which a course begins to move: 0 where it does from the first on."""
    if not isinstance(form, Shape) or not form.columns.size:
        return 0
    travel = np.abs(form.columns - form.columns[0]).max(axis=1)
    first = int(np.argmax(travel > _STILL * travel.max()))
    return first if first > 1 else 0
