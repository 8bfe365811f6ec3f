"""The paper's two-inertia model of a gear with backlash, eq. 7-22, in closed form.

Mousavi, Akbarzadeh, Shariatee, Alimardani: Repeatability Analysis of a SCARA Robot with
Planetary Gearbox. Motor and load turn freely on one axis, coupled through a gap 2D; impacts are
plastic and there is no friction, so the centre of mass moves as if no gap were there (eq. 11) and
crossing the gap moves each side about it in inverse proportion to its inertia (eq. 13).
Its printed figures are here only to be set beside those that its data give.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from importlib.resources import files
from typing import TYPE_CHECKING, Literal

from scara_iso.base.displayed import Displayed
from scara_iso.base.errors import UsageError
from scara_iso.base.published import INTERNAL, Size, publish, published
from scara_iso.run import Run, frame_of
from scara_iso.tables import read_table

if TYPE_CHECKING:
    import pandas as pd


_LONGEST_ARM = 10.0
"""In m, twice what the longest arms of industry have: a longer one was given in mm."""


@dataclass(frozen=True, kw_only=True)
class LoadCrossing:
    """What the load does when the gear crosses the gap, from right contact to left contact."""

    load_deviation_rad: float
    """Eq. 16."""
    inertia_ratio: Size
    """Gap over load deviation, eq. 20."""
    deviation_mm: Size | None
    """At the end of the arm, eq. 21; null without an arm."""


@dataclass(frozen=True, kw_only=True)
class Crossing(LoadCrossing):
    """The same, with what it follows from."""

    ratio: float | None = field(default=None, compare=False)
    """Gear ratio N, where the rotor is seen through the gear."""
    motor_inertia: Size
    """I_m as the gap sees it, N² I_m through the gear, in kg m²."""
    load_inertia: float = field(metadata=INTERNAL)
    """Inertia on the load's side [kg m2]."""
    motor_deviation_rad: float = field(metadata=INTERNAL)
    """Motor's deviation, from eq. 13 and 15 [rad]."""


def _of_load(found: Crossing) -> LoadCrossing:
    return publish(LoadCrossing, found)


@dataclass(frozen=True, kw_only=True)
class Backlash(Displayed):
    """The paper's two-inertia model, the rotor as given."""

    schema: Literal["scara-iso/backlash/1"] = "scara-iso/backlash/1"
    """Name and number of this schema."""
    gap_rad: Size
    """The full gap 2D, eq. 18."""
    as_given: Crossing = field(metadata=published(by=_of_load, merged=True))
    """I_m taken as it is given, on the load's shaft (the paper's case)."""
    arm_m: Size | None
    """From the joint to the tool; null where not given."""
    free_play_mm: Size | None
    """The whole gap at the end of the arm, eq. 22; null without an arm."""
    ratio: float | None = field(metadata=INTERNAL)
    """Gear ratio N; None where not given."""
    reflected: Crossing | None
    """The rotor as the output shaft sees it; null without a gear ratio."""

    def __repr__(self) -> str:
        deviation, share = self.as_given.load_deviation_rad, self.as_given.inertia_ratio
        return f"<Backlash: the load moves {deviation:.4g} rad, 1/{share:.6g} of the gap>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table: I_m as given, and in a second row through the gearbox.

        Columns: those of `Crossing`; ``attrs`` hold the gap [rad], the arm [m],
        the free play [mm] and the ratio. NaN without an arm.
        """
        names = [one.name for one in fields(Crossing) if one.name != "ratio"]
        rows = [
            {name: math.nan if (x := getattr(one, name)) is None else x for name in names}
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
    stated = {name: value for name, value in given.items() if value is not None}
    wrong = [f"`{k}={v:g}`" for k, v in stated.items() if not (math.isfinite(v) and v > 0)]
    if wrong:
        raise UsageError(
            f"{', '.join(wrong)}: not a positive, finite number",
            remedy="inertias in kg m2, the gap in minutes of arc, the arm in m",
        )
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
        reflected=None if ratio is None else _cross(ratio * ratio * Im, IL, gap, arm, ratio),
    )
    parts = [one for one in (result, result.as_given, result.reflected) if one is not None]
    numbers = [getattr(part, field.name) for part in parts for field in fields(part)]
    if not all(math.isfinite(x) and x != 0 for x in numbers if isinstance(x, float)):
        raise UsageError(
            "the values are too far apart to compute with",
            remedy="check the units: inertias in kg m2, the gap in minutes of arc, the arm in m",
        )
    return result


def _cross(
    I_m: float, I_L: float, gap: float, arm: float | None, ratio: float | None = None
) -> Crossing:
    load = -gap * (I_m / (I_m + I_L))  # eq. 16; equals -2D / (1 + I_L / I_m)
    motor = gap * (I_L / (I_m + I_L))  # eq. 15 with eq. 13
    return Crossing(
        ratio=ratio,
        motor_inertia=I_m,
        load_inertia=I_L,
        load_deviation_rad=load,
        motor_deviation_rad=motor,
        inertia_ratio=1 + I_L / I_m if I_m else 0.0,
        deviation_mm=None if arm is None else arm * abs(load) * 1000,
    )


TABLE_1 = "fum_scara_table1.csv"

PRINTED_RP_MM = {"X": 0.013, "Y": 0.005, "Z": 0.023, "theta": 0.008}
"""Last row of Table I."""
PRINTED_MM = {"l_bar X": 0.00544, "S X": 0.0025, "XY": 0.0139, "deviation": 1.37e-4, "play": 2.44}
"""Eq. 4, 5, 23, 21 and 22."""


def table_1() -> Run:
    """Return the paper's Table I: 30 rows, X Y Z theta, the first cycle discarded before."""
    run = read_table((files("scara_iso.robot") / "data" / TABLE_1).read_bytes())
    return replace(run, origin=replace(run.origin, source="the paper's Table I"))


def first_joint() -> Backlash:
    """Return the model of the paper's first joint, eq. 17-22, with its 50:1 gearbox."""
    return backlash(Im=2.65e-4, IL=4.749, arcmin=12, arm=0.7, ratio=50)
