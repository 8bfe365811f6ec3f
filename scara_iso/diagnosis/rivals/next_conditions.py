"""Which recorded column, taken at another value in the next cycles, would tell rivals apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from scara_iso.diagnosis.likelihood.hypotheses import Hypothesis, hypotheses_of
from scara_iso.diagnosis.naming.choice import Choice
from scara_iso.diagnosis.rivals.next_cycles import right_after
from scara_iso.diagnosis.tuning import SEED
from scara_iso.effects import CLOCK, Chain, Conditions, Effect, Form, Process
from scara_iso.run import FloatArray

_CHOSEN = ("approach", "payload_kg", "speed")
"""Columns of which an operator chooses the value."""
_CYCLES = 4
_WORTH = 0.05
"""Chance of a right name that is worth a line."""


def next_conditions(
    values: FloatArray, conditions: Conditions, choice: Choice[Form], effects: Sequence[Effect]
) -> str | None:
    """Return what to choose in the next cycles to tell rivals apart, None where nothing would.

    ``values`` (n, axes) are the residual readings taken under ``conditions``, ``choice`` what they
    say.
    """
    rivals = {choice.best, *(rival.effect for rival in choice.rivals)}
    ways = [*_ways(conditions)]
    if len(rivals) == 1 or not ways:
        return None
    found = []
    for way in [{}, *ways]:
        after = _longer(conditions, way)
        members = [_seen(m, after) for m in hypotheses_of(effects, after) if m.named]
        rng = np.random.default_rng(SEED)
        found.append(right_after(values, choice.probability, members, rng))
    before, *others = found
    best = int(np.argmax(others))
    if others[best] < before + _WORTH:
        return None
    ((name, value),) = ways[best].items()
    said = f"approach {value:+g}" if name == "approach" else f"{name} {value:g}"
    return (
        f"{said} in the next {_CYCLES} cycles would tell rivals apart: the likeliest name is then "
        f"right in {others[best]:.0%} ({before:.0%} with cycles as before)"
    )


def _seen(member: Hypothesis, conditions: Conditions) -> Hypothesis:
    """Return a hypothesis; hidden states as the process that keeps them as long (telegraph)."""
    if not isinstance(member.form, Chain):
        return member
    kept = 1 - member.form.leave_lower - member.form.leave_upper
    lag = np.abs(np.subtract.outer(conditions.elapsed, conditions.elapsed))
    return replace(member, form=Process(np.where(lag, kept**lag, 1.0)))


def _ways(conditions: Conditions) -> Iterator[Mapping[str, float]]:
    """Yield the columns that an operator can choose, at either end of what was recorded."""
    for name in _CHOSEN:
        column = conditions.covariates.get(name, np.zeros(1))
        if np.ptp(column):
            yield from ({name: float(value)} for value in (column.min(), column.max()))


def _longer(conditions: Conditions, chosen: Mapping[str, float]) -> Conditions:
    """Return conditions that go on for some cycles, with the columns that are ``chosen``.

    Others that are in the operator's hand go on as they went, the rest stay as they are.
    """
    more = np.arange(1, _CYCLES + 1)
    columns = {}
    for name, column in conditions.covariates.items():
        if name == CLOCK:
            after = column[-1] + more * (conditions.interval or 1.0)
        elif name in chosen:
            after = np.full(_CYCLES, chosen[name])
        else:
            after = column[-_CYCLES:] if name in _CHOSEN else np.full(_CYCLES, column[-1])
        columns[name] = np.append(column, after)
    return Conditions(np.append(conditions.cycle, conditions.cycle[-1] + more), columns)
