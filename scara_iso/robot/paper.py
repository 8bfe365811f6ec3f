"""The paper's own robot and figures: what it gives, and what it prints.

Mousavi, Akbarzadeh, Shariatee, Alimardani: Repeatability Analysis of a SCARA Robot with
Planetary Gearbox. The printed figures are here only to be set beside those that the data give.
"""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files

from scara_iso.robot.two_inertia import Backlash, backlash
from scara_iso.run import Run
from scara_iso.tables import read_table

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
