"""Forces to and fro, and the readings at each: the turns, the loops, and the force that arrives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scara_iso.run import FloatArray, IntArray

FEWEST_LOOPS = 2
_FEWEST_READINGS = 12
_FAR = 0.8
"""Share of the largest force from which a turn is an end of the loop."""


@dataclass(frozen=True, eq=False, slots=True)
class ForceLoop:
    """Forces [N] and the readings at them [mm], shape (n,), in the order in which they were."""

    force: FloatArray
    """Force of each step [N], shape (steps,)."""
    reading: FloatArray
    """Reading at each step [mm], shape (steps,)."""
    resolution: float | None = None
    """The dial's division [mm]; None where not stated."""
    uncertainty: float | None = None
    """Standard uncertainty of the indicator."""
    source: str = ""
    """File that it was read from."""
    notes: tuple[str, ...] = ()
    """How it was read, one line each."""


def turns(force: FloatArray) -> IntArray:
    """Return where the force turns at an end of the loop: alternately high and low."""
    ends: list[int] = []
    for k in np.flatnonzero(np.abs(force) >= _FAR * _reach(force)).tolist():
        if ends and np.sign(force[k]) == np.sign(force[ends[-1]]):
            if abs(force[k]) > abs(force[ends[-1]]):
                ends[-1] = k
        else:
            ends.append(k)
    return np.array(ends, dtype=np.int64)


def _reach(force: FloatArray) -> float:
    return float(min(force.max(), -force.min()))


def is_loop(force: FloatArray) -> bool:
    """Return whether forces go to both sides in two loops or more."""
    if len(force) < _FEWEST_READINGS or _reach(force) <= 0:
        return False
    return len(turns(force)) >= 2 * FEWEST_LOOPS


def loop_numbers(force: FloatArray, first: int, ends: IntArray) -> IntArray:
    """Return the loop of each reading from ``first`` on, shape (n - first,), counted from 0.

    A loop begins at every second end; one that is left unfinished belongs to the one before.
    """
    begins = ends[::2]
    number = np.searchsorted(begins, np.arange(first, len(force)), side="right") - 1
    whole = max((len(ends) - 1) // 2, 1)
    return np.minimum(number, whole - 1)


def transmitted(force: FloatArray, friction: FloatArray) -> FloatArray:
    """Return what Coulomb friction lets through of a force, shape (frictions, n).

    The play operator: it follows the force at a distance of ``friction``, shape (frictions,), and
    stands still after a turn until the force has come back by twice that. ``force`` begins at an
    end of the loop, so that the state there is known.
    """
    through = np.empty((len(friction), len(force)))
    state = force[0] - np.sign(force[0]) * friction
    for k, value in enumerate(force.tolist()):
        state = np.minimum(np.maximum(state, value - friction), value + friction)
        through[:, k] = state
    return through


def flank(through: FloatArray) -> FloatArray:
    """Return the flank that is in contact, shape of ``through``: its sign, or the one before."""
    sign = np.sign(through)
    for k in range(1, sign.shape[-1]):
        rests = sign[..., k] == 0
        if np.any(rests):
            sign[..., k] = np.where(rests, sign[..., k - 1], sign[..., k])
    return sign
