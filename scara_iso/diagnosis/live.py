"""What the readings of a test say while it runs, cycle by cycle: evidence, alarm, likeliest cause.

Exactly one test governs a recording. All channels (axes at poses) count together.

Where a length is planned the readings so far are ranked at looks, and their order is tested by
permuting whole cycles, which is exact whatever the distribution. The levels of the looks together
are spent as O'Brien and Fleming (1979) do: little early, nearly all at the end.

Where none is planned it is a test martingale. The rank of each new reading among all before it is
uniform and independent of the earlier ranks wherever the readings are exchangeable, whatever their
distribution (Renyi 1962; Vovk, Gammerman and Shafer 2005). Bets on where the next reading will lie
make a martingale that starts at 1, and reaches 20 with a probability of at most 1/20 for ever
(Ville).

What a pause does to a course nobody knows beforehand. It may go on meanwhile (creep, the room),
stand (wear), or begin anew (what had warmed has cooled): each is as likely.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from statistics import NormalDist

import numpy as np

from scara_iso.diagnosis.evidence import views_of
from scara_iso.diagnosis.hypotheses import Hypothesis, HypothesisSet, build, constant, hypotheses_of
from scara_iso.diagnosis.naming import Choice, choose
from scara_iso.diagnosis.order import order_test
from scara_iso.diagnosis.rivals import NextCycles, right_after
from scara_iso.diagnosis.tuning import FEWEST_CYCLES, GROSS, PAUSE
from scara_iso.effects import Conditions, Form, Process, Shape, Spread, find_effects
from scara_iso.iso9283 import median
from scara_iso.run import FloatArray, IntArray

ALARM = 20.0
"""Evidence at which it is said that something acts: one over the level."""
_NORMAL = NormalDist()
_LEADS = np.array([_NORMAL.cdf(size / 2**0.5) - 0.5 for size in (1.0, 2.0, 4.0)])
"""By how much a reading behind a step of so many scatters leads one before it, as a probability
above 1/2 (benchmarks/watch.py, as all figures here)."""
_RISES, _ALTERNATIONS = np.array([1.2, 1.6, 2.5]), np.array([1.6, 2.4])
"""Exponents of the bets on a course that goes on rising, and on one that alternates."""
_WEIGHTS = {"step": 0.6, "rise": 0.25, "alternation": 0.15}
_EARLY = 20.0
"""Half of the weight of all steps is on the first so many readings."""
_SURE = 0.99
"""A bet keeps the rest back, so that no single reading loses everything."""
_LARGEST_LOG = 300.0


class EProcess:
    """The evidence of each of several channels; their mean is one too, however they hang together.

    `take` wants, reading by reading, each channel's rank p among its own readings as a number from
    0 to 1, uniform within the rank. A bet is the density a p^(a-1), or the same of 1 - p. On a step
    a rank has the mean m = 1/2 + lead (1 - share of the readings behind it), so a = m / (1 - m).
    """

    def __init__(self, channels: int) -> None:
        self._steps = np.zeros((2, channels, 0, len(_LEADS)))
        self._rises = np.zeros((2, channels, len(_RISES)))
        self._alternations = np.zeros((2, channels, len(_ALTERNATIONS)))

    def take(self, ranks: FloatArray) -> FloatArray:
        """Return the evidence (channels,) with the next reading's ``ranks`` (channels,)."""
        n = self._steps.shape[2]
        self._steps = np.pad(self._steps, ((0, 0), (0, 0), (0, 1), (0, 0)))
        if n:
            p = np.stack([ranks, 1.0 - ranks])
            before = np.arange(n + 1) / (n + 1)
            mean = 0.5 + before[:, np.newaxis] * _LEADS
            self._steps += log_bet(p[..., np.newaxis, np.newaxis], mean / (1 - mean))
            self._rises += log_bet(p[..., np.newaxis], _RISES)
            turned = p if n % 2 else p[::-1]
            self._alternations += log_bet(turned[..., np.newaxis], _ALTERNATIONS)
        begun = _EARLY / (_EARLY + np.arange(n + 1))
        by_step = _mean(self._steps, (0, 3)) @ np.append(0.0, begun[:-1] - begun[1:]) + begun[-1]
        return np.asarray(
            _WEIGHTS["step"] * by_step
            + _WEIGHTS["rise"] * _mean(self._rises, (0, 2))
            + _WEIGHTS["alternation"] * _mean(self._alternations, (0, 2))
        )


def log_bet(p: FloatArray, a: FloatArray) -> FloatArray:
    """Return the log of a bet on ranks ``p``, of which the mean over uniform ranks is 1."""
    return np.asarray(np.log(_SURE * a * p ** (a - 1) + 1 - _SURE))


def _mean(logs: FloatArray, over: tuple[int, ...]) -> FloatArray:
    return np.asarray(np.exp(np.minimum(logs, _LARGEST_LOG)).mean(axis=over))


MOST_PLANNED = 60
"""A test of more cycles is watched as one of open length: looks would wait a third of it."""
_FIRST, _EVERY = 10, 2
_BOUNDARY = 2.05
"""A look after a share t of the readings is an alarm from the normal quantile of p that is this
over the root of t. All looks together then reach it in 4.0 to 4.5 % of tests of 20 to 60 readings,
and with several channels in no more than 5 % (benchmarks/watch.py)."""
_PERMUTATIONS = 1999


def is_look(taken: int, planned: int) -> bool:
    """Say whether there is a look after ``taken`` of ``planned`` readings."""
    due = taken >= _FIRST and (taken - _FIRST) % _EVERY == 0
    return FEWEST_CYCLES <= taken <= planned and (due or taken == planned)


def look(values: FloatArray, noise: FloatArray, planned: int, rng: np.random.Generator) -> float:
    """Return the evidence of one look at the readings so far, ``values`` (n, channels).

    ``noise`` of the same shape breaks ties: each reading keeps its own at every look. The largest
    evidence of all looks reaches `ALARM` in at most 5 % of tests in which nothing acts.
    """
    n = len(values)
    hypotheses = _hypotheses(n)
    views = views_of(normal_scores(values, noise), hypotheses.basis)
    p = order_test(hypotheses, views, rng, permutations=_PERMUTATIONS).p_value
    return evidence_of(p, n / planned)


def evidence_of(p: float, share: float) -> float:
    """Return the evidence of a look's p-value after a ``share`` of the readings."""
    reached = -_NORMAL.inv_cdf(min(p, 0.5)) * share**0.5
    return ALARM * _NORMAL.cdf(-_BOUNDARY) / _NORMAL.cdf(-reached)


def normal_scores(values: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the normal scores of each channel's ranks, shape (n, channels)."""
    order = np.lexsort((noise, values), axis=0)
    return np.asarray(_scores(len(values))[np.argsort(order, axis=0)])


@cache
def _scores(n: int) -> FloatArray:
    return np.array([_NORMAL.inv_cdf((rank + 0.5) / n) for rank in range(n)])


@cache
def _hypotheses(n: int) -> HypothesisSet:
    """Return what the test compares after ``n`` readings."""
    rows: IntArray = np.arange(n)
    every = hypotheses_of(find_effects(), Conditions(rows + 1, {}))
    members = [member for member in every if member.test_weight]
    return build([m for m in members if m.ordered], rows, constant(n))


def named_over(cycles: IntArray, planned: int, pauses: Sequence[int] = ()) -> list[Hypothesis]:
    """Return the hypotheses with a name over the readings of ``cycles`` (n,), numbered in turn.

    Their courses are those of a test of ``planned`` readings. ``pauses`` are the numbers of
    readings before which the robot stood.
    """
    n = len(cycles)
    reached = max(planned, n + PAUSE * len(pauses))
    every = np.arange(cycles[0], cycles[0] + reached)
    members = hypotheses_of(find_effects(), Conditions(every, {}))
    named = [m for m in members if m.ordered and not m.hidden]
    return [one for member in named for one in _on_clocks(member, n, pauses)]


def _on_clocks(member: Hypothesis, n: int, pauses: Sequence[int]) -> Iterator[Hypothesis]:
    """Yield a hypothesis on each clock by which its course may run through the pauses."""
    rows = np.arange(n)
    behind = np.searchsorted(np.array(pauses), rows, side="right")
    clocks = [rows, rows + PAUSE * behind] if pauses else [rows]
    smooth = {effect.name for effect in find_effects() if effect.smooth}
    if pauses and member.effect in smooth and isinstance(member.form, Shape):
        clocks.append(rows - np.array([0, *pauses])[behind])
    for clock in clocks:
        yield _on(member, clock, 1 / len(clocks))


def _on(member: Hypothesis, rows: IntArray, share: float) -> Hypothesis:
    """Return a hypothesis on some of its rows, with a ``share`` of its weight."""
    form = member.form
    if isinstance(form, Shape):
        form = replace(form, columns=form.columns[rows])
    elif isinstance(form, Process):
        form = replace(form, unit=form.unit[np.ix_(rows, rows)])
    elif isinstance(form, Spread):
        form = replace(form, scale=form.scale[rows])
    return replace(member, form=form, weight=share * member.weight)


def begun(members: Sequence[Hypothesis], n: int) -> HypothesisSet:
    """Return the set of those ``members`` whose course has begun in the first ``n`` readings.

    Each effect has the whole of its weight: something acts, so it did not wait.
    """
    found = build(members, np.arange(n), constant(n))
    whole: dict[str, float] = defaultdict(float)
    left: dict[str, float] = defaultdict(float)
    for total, own in ((whole, members), (left, found.members)):
        for m in own:
            total[m.effect] += m.weight
    scaled = [replace(m, weight=m.weight * whole[m.effect] / left[m.effect]) for m in found.members]
    return build(scaled, np.arange(n), constant(n))


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
        """By which ties are broken, and where a reading lies within its rank: (2, channels)."""
        self._evidence: list[float] = []
        self._pauses: set[int] = set()
        self._e_process: EProcess | None = None

    def take(self, values: Sequence[float]) -> None:
        """Take the next cycle's ``values``, one for each channel; those of cycle 1 count not."""
        rng = np.random.default_rng([self._seed, len(self._values)])
        self._values.append(values)
        self._noise.append(rng.random((2, len(values))))
        first = len(self._values) == 1
        self._evidence.append(_NOTHING if first else max(self._evidence[-1], self._looked()))

    def pause(self) -> None:
        """Note that the robot stood before the next cycle."""
        self._pauses.add(self.cycles)

    def strike(self, cycle: int) -> None:
        """Forget a cycle, from 1, and those behind it."""
        for each in (self._values, self._noise, self._evidence):
            del each[cycle - 1 :]
        self._pauses = {min(before, cycle - 1) for before in self._pauses}
        self._e_process = None

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

    def _looked(self) -> float:
        """Return the evidence with the last cycle."""
        values, noise = np.array(self._values[1:]), np.array(self._noise[1:])
        n = len(values)
        if self._planned is not None:
            if self._evidence[-1] >= ALARM or not is_look(n, self._planned):
                return _NOTHING
            rng = np.random.default_rng([self._seed, 0, n])
            return look(values, noise[:, 0], self._planned, rng)
        new = range(n, n + 1) if self._e_process else range(1, n + 1)
        self._e_process = self._e_process or EProcess(values.shape[1])
        return [
            float(self._e_process.take(_rank_of_last(values[:k], noise[:k])).mean()) for k in new
        ][-1]


def _rank_of_last(values: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the rank of the last row among all, from 0 to 1, ties broken by ``noise``."""
    before, last = values[:-1], values[-1]
    tied = (before == last) & (noise[:-1, 0] < noise[-1, 0])
    return np.asarray(((before < last).sum(axis=0) + tied.sum(axis=0) + noise[-1, 1]) / len(values))


def explained(
    values: FloatArray, cycles: IntArray, planned: int = 0, pauses: Sequence[int] = ()
) -> Choice:
    """Return how likely each effect is in readings (n, channels) of ``cycles``.

    The unknown is the likeliest where nothing known fits better. ``planned`` readings and
    ``pauses`` are those of `named_over`.
    """
    hypotheses = begun(named_over(cycles, planned, pauses), len(cycles))
    return choose(hypotheses, views_of(values, hypotheses.basis))


def ways_on(
    values: FloatArray, cycles: IntArray, choice: Choice, planned: int, pauses: list[int]
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
