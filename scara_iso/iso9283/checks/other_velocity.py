"""The velocity is not one of the standard's.

ISO 9283 measures at 100 %, 50 % and 10 % of the rated velocity: how the arm arrives decides how it
repeats. State ``# velocity`` in per cent of the rated one, or both ``# velocity`` and
``# rated_velocity`` in mm/s. A column `speed` that changes makes several tests of one table.
"""

from scara_iso.iso9283.checks._stated import SPEED, VELOCITY, ShareOfRated
from scara_iso.iso9283.core.results import Findings, Measured

CODE = "other-velocity"
_VELOCITY = ShareOfRated(
    CODE,
    "velocity",
    keys=VELOCITY,
    rated={"rated_velocity", "rated_speed", "rated_velocity_mm_s", "rated_speed_mm_s"},
    columns=("speed", "velocity", "velocity_percent", "speed_mm_s", "velocity_mm_s"),
    units=SPEED,
    shares=(100, 50, 10),
    rule="ISO 9283 7.2: 100, 50 or 10 % of the rated velocity",
    is_no="velocity",
    example="100 %, or 500 mm/s",
)


def check(measured: Measured) -> Findings:
    """Yield a warning for another velocity than the standard's, and for one that changes."""
    yield from _VELOCITY.findings(measured.run)
