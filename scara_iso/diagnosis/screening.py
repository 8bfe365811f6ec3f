"""One table among many: whether anything acts, and which effects, without what it all amounts to.

The search is that of a diagnosis, so p-value, verdict and names are the same; errors, shares and
predictions are not computed. Where many tables are judged together (`fleets`), the p-value that
PERMUTATIONS orders can give may be too coarse: `finer` looks at more of the same orders.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from scara_iso.diagnosis.closed_loop import CyclesWanted
from scara_iso.diagnosis.order import order_test
from scara_iso.diagnosis.places import groups_of, repeatabilities
from scara_iso.diagnosis.poses import problem_of_poses
from scara_iso.diagnosis.readings import verdict_of
from scara_iso.diagnosis.search import SearchProblem, find, in_order, problem_of, remainder
from scara_iso.diagnosis.tuning import ORDER_SHARE, PERMUTATIONS
from scara_iso.diagnosis.verdict import Verdict
from scara_iso.effects import find_effects
from scara_iso.run import Run


@dataclass(frozen=True, slots=True)
class Screened:
    """What is found of one table, of all its poses together."""

    cycles: int
    """That count, at each pose."""
    poses: int
    """How many there are."""
    verdict: Verdict
    """As that of `close_the_loop`."""
    p_value: float
    """Smallest of the tests, each over its share of the level."""
    at_floor: bool
    """Nothing drawn came as far: the p-value is a bound."""
    effects: tuple[str, ...]
    """Names, each once."""
    RP: Mapping[str, float]
    """By figure, the largest of a pose [mm, deg]."""


def screen(run: Run, wanted: CyclesWanted, *, seed: int) -> Screened:
    """Return what is found in the rows of a table that count, all poses together.

    Raises `DataError` as `close_the_loop` and `close_the_loop_at_poses`.
    """
    problem, poses = _searched(run, wanted)
    terms, stages = find(problem, np.random.default_rng(seed))
    return Screened(
        cycles=len(poses[0]),
        poses=len(poses),
        verdict=verdict_of(terms, stages),
        p_value=stages[0].p_value,
        at_floor=stages[0].p_value_at_floor,
        effects=tuple(dict.fromkeys(term.effect for term in terms)),
        RP=_largest_RP(poses),
    )


def floor_of(orders: int) -> float:
    """Return the p-value of a table which none of so many orders of its cycles came as far as."""
    return 1 / (orders + 1) / ORDER_SHARE


def finer(run: Run, wanted: CyclesWanted, orders: int, *, seed: int) -> tuple[float, bool]:
    """Return the p-value of a table by more ``orders``, and whether none of them came as far.

    For a table which none of the first PERMUTATIONS came as far as; those are the first of these.
    It is at most what they gave: else such a table would have the larger of two p-values, and one
    that was not compared again the smaller.
    """
    problem, _ = _searched(run, wanted)
    hypotheses, views, emissions = in_order(problem, (), remainder(problem, (), problem.rows))
    rng = np.random.default_rng(seed)
    found = order_test(hypotheses, views, rng, emissions=emissions, permutations=orders)
    return min(found.p_value / ORDER_SHARE, floor_of(PERMUTATIONS)), found.at_floor


def _searched(run: Run, wanted: CyclesWanted) -> tuple[SearchProblem, tuple[Run, ...]]:
    """Return the search that a table is, and its poses."""
    if len(list(run.rows_by_pose())) == 1:
        used = wanted.take(run)
        return problem_of(used, directions={}, effects=find_effects()), (used,)
    test = wanted.all_poses(run)
    return problem_of_poses(test), tuple(test.parts.values())


def _largest_RP(poses: tuple[Run, ...]) -> dict[str, float]:  # noqa: N802 - the field's symbol
    found: dict[str, float] = {}
    for pose in poses:
        readings = {name: axis.readings for name, axis in pose.axes.items()}
        for name, value in repeatabilities(readings, groups_of(pose.axes)).items():
            found[name] = max(value, found.get(name, 0.0))
    return found
