"""The paper's two-inertia model of a gear with backlash, eq. 7-22, in closed form.

Mousavi, Akbarzadeh, Shariatee, Alimardani: Repeatability Analysis of a SCARA Robot with
Planetary Gearbox. Motor and load turn freely on one axis, coupled through a gap 2D; impacts are
plastic and there is no friction, so the centre of mass moves as if no gap were there (eq. 11) and
crossing the gap moves each side about it in inverse proportion to its inertia (eq. 13).

The paper's own robot and figures: what it gives, and what it prints.

Mousavi, Akbarzadeh, Shariatee, Alimardani: Repeatability Analysis of a SCARA Robot with
Planetary Gearbox. The printed figures are here only to be set beside those that the data give.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from importlib.resources import files
from typing import TYPE_CHECKING

from scara_iso.base.display import Displayed
from scara_iso.base.errors import UsageError
from scara_iso.run import Run, frame_of, or_nan
from scara_iso.tables import read_table

if TYPE_CHECKING:
    import pandas as pd


_LONGEST_ARM = 10.0
"""In m, twice what the longest arms of industry have: a longer one was given in mm."""


@dataclass(frozen=True, slots=True)
class Crossing:
    """What the load does when the gear goes from right contact to left contact."""

    motor_inertia: float
    """Inertia on the motor's side, as the gap sees it [kg m2]."""
    load_inertia: float
    """Inertia on the load's side [kg m2]."""
    load_deviation_rad: float
    """Load's deviation from the centre of mass, right minus left contact, eq. 16 [rad]."""
    motor_deviation_rad: float
    """Motor's deviation likewise, from eq. 13 and 15 [rad]."""
    deviation_mm: float | None
    """Width of the reversal at the end of the arm, eq. 21 [mm]; None without an arm."""

    @property
    def inertia_ratio(self) -> float:
        """Gap over load deviation, eq. 20: 1 + I_L / I_m."""
        return 1 + self.load_inertia / self.motor_inertia


@dataclass(frozen=True, slots=True)
class Backlash(Displayed):
    """Eq. 16-22 for one gear, and the same with the rotor seen through the gearbox."""

    gap_rad: float
    """Full gap 2D at the gearbox's output, eq. 18 [rad]."""
    arm_m: float | None
    """Distance from the joint to the tool, the paper's L1 + L2 [m]."""
    free_play_mm: float | None
    """The whole gap at the end of the arm, eq. 22 [mm]; None without an arm."""
    as_given: Crossing
    """I_m taken as it is given, on the load's shaft (the paper's case)."""
    ratio: float | None
    """Gear ratio N; None where not given."""
    reflected: Crossing | None
    """N^2 I_m in place of I_m: the rotor as the output shaft sees it; None without a ratio."""

    def __repr__(self) -> str:
        deviation, share = self.as_given.load_deviation_rad, self.as_given.inertia_ratio
        return f"<Backlash: the load moves {deviation:.4g} rad, 1/{share:.6g} of the gap>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table: I_m as given, and in a second row through the gearbox.

        Columns: those of `Crossing` and inertia_ratio; ``attrs`` hold the gap [rad], the arm [m],
        the free play [mm] and the ratio. NaN without an arm.
        """
        names = (*Crossing.__slots__, "inertia_ratio")
        rows = [
            {name: or_nan(getattr(one, name)) for name in names}
            for one in (self.as_given, self.reflected)
            if one is not None
        ]
        stated = {"gap_rad": self.gap_rad, "arm_m": self.arm_m, "free_play_mm": self.free_play_mm}
        return frame_of(rows, {**stated, "ratio": self.ratio})


def backlash(
    *,
    Im: float,
    IL: float,
    arcmin: float,
    arm: float | None = None,
    ratio: float | None = None,
) -> Backlash:
    """Return the load's deviation through a gap of ``arcmin`` minutes of arc.

    ``Im`` and ``IL`` are the inertias of motor and load [kg m2], ``arm`` the distance to the tool
    [m], at most 10, ``ratio`` the gear's N. Raises `UsageError` unless every value is positive and
    finite.
    """
    given = {"Im": Im, "IL": IL, "arcmin": arcmin, "arm": arm, "ratio": ratio}
    _require_positive({name: value for name, value in given.items() if value is not None})
    if arm is not None and arm > _LONGEST_ARM:
        remedy = f"give it in metres: `arm={arm / 1000:g}` where it is {arm:g} mm"
        raise UsageError(f"`arm={arm:g}`: no robot has an arm of {arm:g} m", remedy=remedy)
    gap = math.radians(arcmin / 60)
    result = Backlash(
        gap_rad=gap,
        arm_m=arm,
        free_play_mm=None if arm is None else arm * gap * 1000,  # eq. 22
        as_given=_cross(Im, IL, gap, arm),
        ratio=ratio,
        # Not in the paper: the rotor turns N times as fast as the output, hence N^2.
        reflected=None if ratio is None else _cross(ratio * ratio * Im, IL, gap, arm),
    )
    _require_representable(result)
    return result


def _cross(I_m: float, I_L: float, gap: float, arm: float | None) -> Crossing:
    load = -gap * (I_m / (I_m + I_L))  # eq. 16; equals -2D / (1 + I_L / I_m)
    motor = gap * (I_L / (I_m + I_L))  # eq. 15 with eq. 13
    return Crossing(I_m, I_L, load, motor, None if arm is None else arm * abs(load) * 1000)


def _require_positive(values: dict[str, float]) -> None:
    wrong = [f"`{k}={v:g}`" for k, v in values.items() if not (math.isfinite(v) and v > 0)]
    if wrong:
        raise UsageError(
            f"{', '.join(wrong)}: not a positive, finite number",
            remedy="inertias in kg m2, the gap in minutes of arc, the arm in m",
        )


def _require_representable(result: Backlash) -> None:
    numbers = [result.gap_rad, result.free_play_mm]
    for c in (result.as_given, result.reflected):
        if c is not None:
            numbers += [c.load_deviation_rad, c.motor_deviation_rad, c.deviation_mm]
            numbers += [c.motor_inertia, c.inertia_ratio if c.motor_inertia else 0.0]
    if not all(x is None or (math.isfinite(x) and x != 0) for x in numbers):
        raise UsageError(
            "the values are too far apart to compute with",
            remedy="check the units: inertias in kg m2, the gap in minutes of arc, the arm in m",
        )


TABLE_1 = "fum_scara_table1.csv"

PRINTED_RP_MM = {"X": 0.013, "Y": 0.005, "Z": 0.023, "theta": 0.008}
"""Last row of Table I."""
PRINTED_L_BAR_MM = {"X": 0.00544}
"""Eq. 4."""
PRINTED_S_MM = {"X": 0.0025}
"""Eq. 5."""
PRINTED_XY_MM = 0.0139
"""Eq. 23."""
PRINTED_DEVIATION_MM = 1.37e-4
"""Eq. 21."""
PRINTED_FREE_PLAY_MM = 2.44
"""Eq. 22."""


def table_1() -> Run:
    """Return the paper's Table I: 30 rows, X Y Z theta, the first cycle discarded before."""
    run = read_table((files("scara_iso.robot") / "data" / TABLE_1).read_bytes())
    return replace(run, origin=replace(run.origin, source="the paper's Table I"))


def first_joint() -> Backlash:
    """Return the model of the paper's first joint, eq. 17-22, with its 50:1 gearbox."""
    return backlash(Im=2.65e-4, IL=4.749, arcmin=12, arm=0.7, ratio=50)
