"""What is stated of a posterior: no name for sure beside a near rival, and as often as right."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from scara_iso.diagnosis.tuning import (
    RIGHT_OF_STATED,
    RIVAL,
    UNDECIDED,
    UNKNOWN,
    UNNAMED_AHEAD,
    UNSURE,
)
from scara_iso.diagnosis.verdict import Rival

_SAID = 1.001 * RIVAL
"""Share that no rounding of numbers takes below RIVAL."""


Near = Callable[[str], Mapping[str, float]]
"""Effects near the named one in BIC, and by how much they are behind."""


def as_stated(posterior: Mapping[str, float], near: Near) -> dict[str, float]:
    """Return what is stated of a posterior: the likeliest effect stays that."""
    probability = as_often_right(posterior)
    best = max(probability, key=probability.__getitem__)
    if probability[best] <= UNDECIDED:
        return probability
    return beside_near_rivals(probability, near(best))


def beside_near_rivals(
    probability: Mapping[str, float], near: Mapping[str, float]
) -> dict[str, float]:
    """Return probabilities of which none is above UNSURE while another effect is near in BIC.

    Nor above UNDECIDED while a course of no name is ahead. The nearest becomes a rival, at least
    RIVAL times as likely as the best; those farther, by the differences ``near``,
    exp(-difference / 2) times that; what is ahead and has no name, UNNAMED_AHEAD times.
    """
    best = max(probability, key=probability.__getitem__)
    ahead = near.get(UNKNOWN, 0.0) < 0
    most = UNDECIDED if ahead else UNSURE
    if probability[best] <= most or not near:
        return dict(probability)
    nearest = min(near.values())
    least = {name: _SAID * float(np.exp((nearest - d) / 2)) for name, d in near.items()}
    if ahead:
        least[UNKNOWN] = UNNAMED_AHEAD
    others = {
        name: max(probability.get(name, 0.0), least.get(name, 0.0) * probability[best])
        for name in {**probability, **least}
        if name != best
    }
    whole = sum(others.values())
    sure = min(most, probability[best] / (probability[best] + whole))
    return {best: sure, **{name: p * (1 - sure) / whole for name, p in others.items()}}


def unsure(probability: float, rivals: tuple[Rival, ...]) -> tuple[float, tuple[Rival, ...]]:
    """Return a probability of at most UNSURE, and rivals of which the unknown takes the rest."""
    if probability <= UNSURE:
        return probability, rivals
    known = tuple(rival for rival in rivals if rival.effect != UNKNOWN)
    rest = max(1 - UNSURE - sum(rival.probability for rival in known), probability - UNSURE)
    every = (*known, Rival(UNKNOWN, rest))
    return UNSURE, tuple(sorted(every, key=lambda rival: -rival.probability))


def as_often_right(probability: Mapping[str, float]) -> dict[str, float]:
    """Return probabilities of which the largest is as large as it has been right: RIGHT_OF_STATED.

    The others share what is left as before.
    """
    best = max(probability, key=probability.__getitem__)
    p = probability[best]
    right = float(np.interp(p, *np.transpose(RIGHT_OF_STATED)))
    left = (1 - right) / (1 - p) if p < 1 else 1.0
    return {name: right if name == best else left * q for name, q in probability.items()}
