"""What the scatter of several poses comes from, and what it says of the others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from scara_iso.run import FloatArray

_ALIKE = 9
"""Decimal places [mm] from which places of a ring about the base do not differ."""
_WIDTH = 3.92
"""Standard deviations in a 95 % interval."""


@dataclass(frozen=True, slots=True)
class SourceOfScatter:
    """A standard deviation with its 95 % interval: of a joint [rad], or at the tool [mm]."""

    value: float
    """0 where the poses need none of it."""
    unit: str
    """``rad`` of a joint, else ``mm``."""
    low: float
    """Lower end; 0 where nothing speaks against none."""
    high: float
    """Upper end."""
    share: float | None = None
    """Of the variance of X and Y, over the poses, what joints do together halved between them; None
    of ``neither``."""


@dataclass(frozen=True, slots=True)
class JointCorrelation:
    """How the joints scatter together, with its 95 % interval."""

    value: float
    """Between -1 and 1."""
    low: float
    """Lower end."""
    high: float
    """Upper end."""
    p_value: float
    """Chance of as much in joints that scatter apart."""


@dataclass(frozen=True, slots=True)
class PredictedRP:
    """RP that scatter and dial give a test of 30 cycles at a pose nobody measured, in XY (7.2.2).

    The interval, 95 %, is that of the RP which a test there would measure.
    """

    value: float
    """Expected [mm]."""
    low: float
    """Lower end."""
    high: float
    """Upper end."""


@dataclass(frozen=True, slots=True)
class PoseLeftOut:
    """A measured pose beside what the others foretell of it, for as many cycles."""

    measured: float
    """RP in XY, 7.2.2 [mm]."""
    effects_removed: float
    """The same without the effects found, which the prediction does not hold."""
    predicted: PredictedRP
    """From the other poses."""
    rms_before: Mapping[str, float]
    """Of X and Y about their means [mm]."""
    rms_after: Mapping[str, float]
    """Without the effects; of a pose held out, those of joints and dials found at the others."""

    @property
    def error(self) -> float | None:
        """Predicted RP over that without the effects, less 1; None where nothing moved."""
        removed = self.effects_removed
        return self.predicted.value / removed - 1 if removed else None

    @property
    def inside(self) -> bool:
        """Whether RP without the effects lies within the interval."""
        return self.predicted.low <= self.effects_removed <= self.predicted.high


@dataclass(frozen=True, eq=False, slots=True)
class ReachMap:
    """Predicted RP over the reach: a square of cells, nan where the arm does not come [mm]."""

    x: FloatArray
    """Middle of the columns, shape (m,)."""
    y: FloatArray
    """Middle of the rows, shape (k,)."""
    RP: FloatArray
    """Expected, shape (k, m)."""
    low: FloatArray
    """Lower end, likewise."""
    high: FloatArray
    """Upper end, likewise."""
    poses: Mapping[str, tuple[float, float]]
    """Where the poses are from which it is made: x, y."""
    limit: float | None = None
    """RP that is wanted, in mm; None: nobody said."""

    @property
    def kept(self) -> FloatArray:
        """Where the limit is kept: 1 where the upper end is at most that, else 0, nan outside."""
        limit = np.nan if self.limit is None else self.limit
        return np.asarray(np.where(np.isnan(self.high), np.nan, self.high <= limit))

    @property
    def share_kept(self) -> float:
        """Share of the reach at which the limit is kept, seen from above."""
        return float(np.nanmean(self.kept))

    @property
    def best(self) -> tuple[float, float, float]:
        """Return x, y and RP where it is least [mm]."""
        return self._at(int(np.nanargmin(self.RP.round(_ALIKE))))

    @property
    def worst(self) -> tuple[float, float, float]:
        """Return x, y and RP where it is largest [mm]."""
        return self._at(int(np.nanargmax(self.RP.round(_ALIKE))))

    def _at(self, cell: int) -> tuple[float, float, float]:
        row, column = divmod(cell, len(self.x))
        return float(self.x[column]), float(self.y[row]), float(self.RP[row, column])


@dataclass(frozen=True, slots=True)
class SizeInJoint:
    """How much one source follows a recorded column, with its 95 % interval."""

    value: float
    """In ``unit``."""
    unit: str
    """``rad`` of a joint, 1 of the growth of the links, ``mm`` of a dial; over that of the column,
    such as ``rad/kg``."""
    low: float
    """Lower end."""
    high: float
    """Upper end."""


@dataclass(frozen=True, eq=False, slots=True)
class FollowedInJoints:
    """What follows a recorded column at all poses, traced to joints, links and dials."""

    effect: str
    """``lost_motion`` (half of the distance of the approaches), ``compliance``, ``temperature``."""
    column: str
    """The recorded column."""
    sizes: Mapping[str, SizeInJoint]
    """``joint 1``, ``joint 2``, ``along the arm`` of a temperature, ``X everywhere`` and ``Y
    everywhere``: its dial or datum."""
    misfit_p_value: float
    """Chance of poses that disagree as much where these sources are all."""


@dataclass(frozen=True, eq=False, slots=True)
class JointScatter:
    """Scatter of all poses traced to the joints and the dial, and RP at other poses from it."""

    sources: Mapping[str, SourceOfScatter]
    """``joint 1``, ``joint 2``, ``dial`` (its own, the same in every direction, rounding aside) and
    ``neither``: what acts in one direction at single poses."""
    predicted_RP: Mapping[str, PredictedRP]  # noqa: N815 - the standard's symbol
    """At the poses of the model that were not measured, or were held out."""
    left_out: Mapping[str, PoseLeftOut]
    """Each measured pose, foretold by the others."""
    held_out: Mapping[str, PoseLeftOut]
    """The pose that was held out from the beginning, if any."""
    together: JointCorrelation | None
    """None where chance makes it: the joints are then taken to scatter apart."""
    misfit: float
    """Scatter of the poses about the fit over that of sampling, as a variance: 1 by chance."""
    misfit_p_value: float
    """Chance of as much where joints and dial are all that scatters."""
    notes: tuple[str, ...] = ()
    """What could not be told, one line each."""
    reach: ReachMap | None = None
    """The map, where it was asked for."""

    @property
    def left_out_rms(self) -> float | None:
        """Root mean square of the errors of the poses left out by turns; None without any."""
        errors = [one.error for one in self.left_out.values() if one.error is not None]
        return float(np.sqrt(np.mean(np.square(errors)))) if errors else None

    @property
    def left_out_chance(self) -> float:
        """What the intervals say of that error: mostly the chance of the cycles at the pose."""
        widths = [
            (one.predicted.high - one.predicted.low) / one.predicted.value
            for one in self.left_out.values()
        ]
        return float(np.sqrt(np.mean(np.square(widths)))) / _WIDTH
