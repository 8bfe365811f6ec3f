"""The hypotheses about a recording that goes on: its pauses, and cycles that are yet to come.

What a pause does to a course nobody knows beforehand. It may go on meanwhile (creep, the room),
stand (wear), or begin anew (what had warmed has cooled): each is as likely.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis, hypotheses_of
from scara_iso.diagnosis.likelihood.hypothesis_set import HypothesisSet, build, constant
from scara_iso.diagnosis.tuning import PAUSE
from scara_iso.effects import Conditions, Process, Shape, Spread, find_effects
from scara_iso.run import IntArray


def named_over(cycles: IntArray, planned: int, pauses: Sequence[int] = ()) -> list[Hypothesis]:
    """Return the hypotheses with a name over the readings of ``cycles`` (n,), numbered in turn.

    Their courses are those of a test of ``planned`` readings. ``pauses`` are the numbers of
    readings before which the robot stood.
    """
    n = len(cycles)
    reached = max(planned, n + PAUSE * len(pauses))
    every = np.arange(cycles[0], cycles[0] + reached)
    members = hypotheses_of(find_effects(), Conditions(every, {}))
    named = [m for m in members if m.named and m.ordered and not m.hidden]
    return [one for member in named for one in _on_clocks(member, n, pauses)]


def _on_clocks(member: Hypothesis, n: int, pauses: Sequence[int]) -> Iterator[Hypothesis]:
    """Yield a hypothesis on each clock by which its course may run through the pauses."""
    rows = np.arange(n)
    if not pauses:
        yield _on(member, rows, 1.0)
        return
    behind = np.searchsorted(np.array(pauses), rows, side="right")
    clocks = [rows, rows + PAUSE * behind]
    if member.effect in _smooth() and isinstance(member.form, Shape):
        clocks.append(rows - np.array([0, *pauses])[behind])
    for clock in clocks:
        yield _on(member, clock, 1 / len(clocks))


def _smooth() -> set[str]:
    return {effect.name for effect in find_effects() if effect.smooth}


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
    whole, left = _weights(members), _weights(found.members)
    scaled = (replace(m, weight=m.weight * whole[m.effect] / left[m.effect]) for m in found.members)
    return replace(found, members=tuple(scaled))


def _weights(members: Sequence[Hypothesis]) -> dict[str, float]:
    total: dict[str, float] = {}
    for member in members:
        total[member.effect] = total.get(member.effect, 0.0) + member.weight
    return total
