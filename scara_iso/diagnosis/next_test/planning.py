"""What a planned test will be able to tell, before the robot moves."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import combinations
from typing import Literal, TypeAlias

import numpy as np

from scara_iso.base.errors import DataError
from scara_iso.base.published import INTERNAL, MERGED, Count, Size, fill, published
from scara_iso.diagnosis.likelihood.evidence import evidence_of_runs
from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis, hypotheses_of
from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet, build, constant, extended
from scara_iso.diagnosis.tuning import ALIKE, FEWEST_CYCLES, LEVEL, POWER, SEED
from scara_iso.effects import Conditions, Effect, Shape, find_effects
from scara_iso.run import FloatArray, IntArray

_TRAVELS = np.geomspace(0.6, 12.0, 14)
_RUNS = 150
_NULL_RUNS = 1000
_MORE_CYCLES = 50
_WORTH_RECORDING = {
    "approach": "the approach alternated in random order",
    "temperature_C": "the temperature logged",
}


Travels: TypeAlias = Mapping[str, Size | None]
"""Lowest to highest reading, by effect; None where not even twelve sigma, with more than 50 cycles
fewer, are found in 80 % of tests."""


@dataclass(frozen=True, slots=True)
class PlannedRun:
    """A test that is planned: its conditions, scatter and dial."""

    conditions: Conditions = field(metadata=INTERNAL)
    sigma: Size
    """Standard deviation of the readings."""
    division: Size = field(metadata=published("resolution"))
    """Of the dial; 0 for none."""
    moved: int = field(default=1, metadata=INTERNAL)
    """How many axes an effect moves, by the same travel."""
    cycles: Count = field(init=False)
    """That count."""
    columns: tuple[str, ...] = field(init=False)
    """That are recorded."""

    def __post_init__(self) -> None:
        fill(self, cycles=len(self.conditions), columns=tuple(self.conditions.covariates))


@dataclass(frozen=True, slots=True)
class Alike:
    """Two effects that can have one course."""

    effects: tuple[str, str]
    """Which."""
    cosine: float
    """The largest of their centred courses: 1 where they are one."""


@dataclass(frozen=True, slots=True)
class Change:
    """Another plan."""

    change: str
    """What is changed."""
    smallest: Travels
    """Travel that it finds in 80 % of tests, by effect, in mm."""


@dataclass(frozen=True, kw_only=True)
class Design:
    """What a planned test of one pose will be able to tell."""

    schema: Literal["scara-iso/design/1"] = "scara-iso/design/1"
    """Name and number of this schema."""
    unit: Literal["mm"] = "mm"
    """Of every length."""
    plan: PlannedRun = field(metadata=MERGED)
    smallest: Travels
    """Travel, lowest to highest reading, found in 80 % of tests, by effect; null: none is."""
    alike: tuple[Alike, ...]
    """What it cannot tell apart."""
    changes: tuple[Change, ...]
    """What would find more."""


def design(
    plan: PlannedRun, *, seed: int = SEED, effects: Sequence[Effect] | None = None
) -> Design:
    """Return what ``plan`` will be able to tell, by simulated runs under the test by order.

    Two levels in no order are not found by it: one pair 4 to 5 sigma apart is found without a
    covariate, by their distribution. Raises `DataError` for fewer than 8 cycles, which no
    diagnosis takes.
    """
    enough(plan.conditions)
    catalogue = tuple(find_effects() if effects is None else effects)
    members = hypotheses_of(catalogue, plan.conditions)
    return Design(
        plan=plan,
        smallest=smallest_effects(plan, catalogue, np.random.default_rng(seed)),
        alike=collinear(members, plan.conditions),
        changes=tuple(
            Change(words, smallest_effects(other, catalogue, np.random.default_rng(seed)))
            for words, other in _changes(plan)
        ),
    )


def enough(conditions: Conditions) -> None:
    """Raise `DataError` for fewer cycles than any diagnosis takes."""
    if len(conditions) < FEWEST_CYCLES:
        raise DataError(
            f"{len(conditions)} usable cycles cannot tell structure from scatter",
            remedy=f"plan at least {FEWEST_CYCLES} beside a discarded one, better 30",
        )


def smallest_effects(
    plan: PlannedRun, effects: Sequence[Effect], rng: np.random.Generator
) -> dict[str, float | None]:
    """Return the smallest travel found in 80 % of runs for every effect with a known course."""
    members = hypotheses_of(effects, plan.conditions)
    travels = _TRAVELS * min(1.0, math.sqrt(50 / len(plan.conditions)))
    ordered = [m for m in members if m.ordered and not m.hidden]
    n = len(plan.conditions)
    hypotheses = build(ordered, np.arange(n), constant(n))
    null = _statistics(hypotheses, [_readings(plan, None, 0.0, rng) for _ in range(_NULL_RUNS)])
    critical = float(np.quantile(null, 1 - LEVEL))
    found = {}
    for name in dict.fromkeys(m.effect for m in ordered if m.named):
        shapes = [m for m in ordered if m.effect == name and isinstance(m.form, Shape)]
        if shapes:
            power = partial(_power, hypotheses, plan, shapes, critical, rng)
            found[name] = _crossing(power, travels, plan.sigma)
    return found


def collinear(members: Sequence[Hypothesis], conditions: Conditions) -> tuple[Alike, ...]:
    """Return pairs of effects with shapes of a cosine of at least 0.9, the largest first."""
    pose = constant(len(conditions))
    bases: dict[str, list[FloatArray]] = {}
    for m in members:
        if isinstance(m.form, Shape) and m.named and m.ordered:
            bases.setdefault(m.effect, []).append(extended(pose, m.form.columns)[:, 1:])
    pairs = [
        Alike((a, b), max(float(np.linalg.norm(u.T @ v, 2)) for u in bases[a] for v in bases[b]))
        for a, b in combinations(bases, 2)
    ]
    return tuple(sorted((p for p in pairs if p.cosine >= ALIKE), key=lambda p: -p.cosine))


def planned_columns(cycle: IntArray) -> dict[str, FloatArray]:
    """Return the columns that a test may record beside its readings, as they might come out."""
    n, ways = len(cycle), np.random.default_rng(0)
    return {
        "approach": ways.permutation(np.where(cycle % 2, 1.0, -1.0)),
        "temperature_C": 20 + ways.normal(0, 0.5, n).cumsum() / 3,
        "payload_kg": ways.permutation(np.resize([0.0, 1.0, 2.0], n)),
        "speed": ways.permutation(np.resize([10.0, 50.0, 100.0], n)),
    }


def _changes(plan: PlannedRun) -> list[tuple[str, PlannedRun]]:
    changes = [("three axes that move together", replace(plan, moved=3))]
    if plan.division > plan.sigma / 3:
        changes.append(("a dial ten times as fine", replace(plan, division=plan.division / 10)))
    others = other_conditions(plan.conditions)
    return [*changes, *((words, replace(plan, conditions=other)) for words, other in others)]


def other_conditions(conditions: Conditions) -> Iterator[tuple[str, Conditions]]:
    """Yield other ways to take as many cycles or more, in words: longer, or with more recorded."""
    if len(conditions) < _MORE_CYCLES:
        yield f"{_MORE_CYCLES} cycles", _longer(conditions)
    planned = planned_columns(conditions.cycle)
    for name, words in _WORTH_RECORDING.items():
        if name not in conditions.covariates:
            covariates = {**conditions.covariates, name: planned[name]}
            yield words, Conditions(conditions.cycle, covariates)


def _longer(conditions: Conditions) -> Conditions:
    """Return more cycles, over which every column takes the course that it took over fewer."""
    at = np.linspace(0, len(conditions) - 1, _MORE_CYCLES).round().astype(np.int64)
    stretched = {name: column[at] for name, column in conditions.covariates.items()}
    return Conditions(np.arange(_MORE_CYCLES) + conditions.cycle[0], stretched)


def _power(
    hypotheses: HypothesisSet,
    plan: PlannedRun,
    shapes: Sequence[Hypothesis],
    critical: float,
    rng: np.random.Generator,
    travel: float,
) -> float:
    weights = np.array([m.weight for m in shapes])
    drawn = rng.choice(len(shapes), _RUNS, p=weights / weights.sum())
    runs = [_readings(plan, shapes[k], travel, rng) for k in drawn]
    return float(np.mean(_statistics(hypotheses, runs) > critical))


def _readings(
    plan: PlannedRun, member: Hypothesis | None, travel: float, rng: np.random.Generator
) -> FloatArray:
    """Return one simulated run (n, axes), in sigmas."""
    n = len(plan.conditions)
    readings = rng.normal(size=(n, plan.moved))
    if member is not None and isinstance(member.form, Shape):
        columns = member.form.columns
        course = columns @ rng.normal(size=columns.shape[1])
        readings += (travel / np.ptp(course) * course)[:, np.newaxis]
    if not plan.division:
        return readings
    division = plan.division / plan.sigma
    return np.asarray(np.round(readings / division + rng.uniform(-0.5, 0.5)) * division)


def _statistics(hypotheses: HypothesisSet, runs: Sequence[FloatArray]) -> FloatArray:
    """Return the log of the mean Bayes factor of each run, shape (runs,)."""
    return np.asarray(np.log(hypotheses.test_weights @ evidence_of_runs(hypotheses, runs)))


def _crossing(power: Callable[[float], float], travels: FloatArray, sigma: float) -> float | None:
    """Return the travel at which the power passes 80 %, bisected, interpolated; times sigma."""
    low, high = -1, len(travels) - 1
    seen = {high: power(travels[high])}
    if seen[high] < POWER:
        return None
    while high - low > 1:
        middle = (low + high) // 2
        seen[middle] = power(travels[middle])
        low, high = (low, middle) if seen[middle] >= POWER else (middle, high)
    if low < 0:
        return float(travels[0] * sigma)
    share = (POWER - seen[low]) / (seen[high] - seen[low])
    return float((travels[low] + share * (travels[high] - travels[low])) * sigma)
