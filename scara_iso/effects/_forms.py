"""How an effect may show in the readings: the forms that a search compares."""

from __future__ import annotations

from dataclasses import dataclass, field

from scara_iso.effects._parameter import Values
from scara_iso.run import FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Shape:
    """A known course: its columns (n, k) at unit size, and the parameters that give it.

    ``weight`` is its prior probability within the effect, up to a factor common to its forms; so
    it is for the other forms. A shape without columns (k = 0) moves no reading.
    """

    columns: FloatArray
    parameters: Values = field(default_factory=dict)
    weight: float = 1.0


@dataclass(frozen=True, eq=False, slots=True)
class Process:
    """A random course: covariance ``variance`` times ``unit`` (n, n), beside scatter of variance 1.

    ``scale`` is the standard deviation, in scatters, of what its size means (such as one step) at
    ``amplitude`` 1; the search tries larger amplitudes too. Forms that differ in their variance
    alone hold the same ``unit``, so that what belongs to it is computed once. ``stays`` is the
    share of its variance that is scatter still where its cause is cured.
    """

    unit: FloatArray
    parameters: Values = field(default_factory=dict)
    weight: float = 1.0
    scale: float = 1.0
    amplitude: float = 1.0
    variance: float = 1.0
    stays: float = 0.0

    @property
    def covariance(self) -> FloatArray:
        """The covariance (n, n)."""
        return self.variance * self.unit


@dataclass(frozen=True, eq=False, slots=True)
class Spread:
    """Scatter that is ``scale`` (n,) times as wide in each cycle as in the first; no mean moves."""

    scale: FloatArray
    parameters: Values = field(default_factory=dict)
    weight: float = 1.0


@dataclass(frozen=True, slots=True)
class Chain:
    """A two-state Markov chain: probabilities of leaving the lower and the upper state."""

    leave_lower: float
    leave_upper: float
    weight: float = 1.0


Form = Shape | Process | Spread | Chain
