"""The velocity is none of the standard's.

ISO 9283 measures at 100 %, 50 % and 10 % of the rated velocity: how the arm arrives decides how it
repeats. State ``# velocity`` in per cent of the rated one, or both ``# velocity`` and
``# rated_velocity`` in mm/s. A column `speed` that changes makes several tests of one table.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scara_iso.iso9283.checks._stated import PERCENT, SPEED, Stated, first, stated
from scara_iso.iso9283.results import Finding, Measured

CODE = "other-velocity"
_VELOCITY = {"velocity", "speed", "velocity_mm_s", "speed_mm_s", "velocity_percent"}
_RATED = {"rated_velocity", "rated_speed", "rated_velocity_mm_s", "rated_speed_mm_s"}
_COLUMNS = ("speed", "velocity", "velocity_percent", "speed_mm_s", "velocity_mm_s")
_SHARES = (100, 50, 10)
_EXACT = 1.0  # per cent of the rated velocity: controllers are set in whole ones
_RULE = "ISO 9283 7.2: 100, 50 or 10 % of the rated velocity"
_HELD = "ISO 9283 6.2, 6.3: conditions are held constant"


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for another velocity than the standard's, and for one that changes."""
    run = measured.run
    rated = first(run, _RATED)
    full = None if rated is None else rated.value(SPEED)
    unclear = [] if rated is None or full else [rated]
    for line in stated(run, _VELOCITY):
        share = _share(line, full)
        if share is None and line.value(SPEED) is None:
            unclear.append(line)
        if share is not None and all(abs(share - one) > _EXACT for one in _SHARES):
            said = f"{line} is {share:.3g} % of the rated velocity"
            yield Finding(CODE, "warning", said, rule=_RULE)
    for name in _COLUMNS:
        values = run.covariates.get(name)
        if values is not None and np.ptp(values) > 0:
            said = f"{name} goes from {values.min():g} to {values.max():g} during the test"
            yield Finding(CODE, "warning", said, rule=_HELD)
    for line in unclear:
        yield Finding(
            CODE,
            "info",
            f"{line}: no velocity that can be compared",
            advice="write 100 %, or 500 mm/s",
        )


def _share(line: Stated, full: float | None) -> float | None:
    """Return the per cent of the rated velocity: from the speed where both are known."""
    speed = line.value(SPEED)
    return line.value(PERCENT) if speed is None or not full else 100 * speed / full
