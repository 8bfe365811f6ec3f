"""The load is not the rated one.

ISO 9283 measures at 100 % of the rated load: a lighter arm repeats better. State ``# payload`` and
``# rated_payload`` in kg, or the payload in per cent of the rated one. A payload that changes from
cycle to cycle (column `payload_kg`) is an experiment on the gear, not a test at one load.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scara_iso.iso9283.checks._stated import MASS, PERCENT, Stated, first, stated
from scara_iso.iso9283.results import Finding, Measured
from scara_iso.run import Run

CODE = "other-load"
_LOAD = {"payload", "load", "payload_kg", "load_kg", "payload_percent", "load_percent"}
_RATED = {"rated_payload", "rated_load", "rated_payload_kg", "rated_load_kg"}
_COLUMNS = ("payload_kg", "load_kg")
_RULE = "ISO 9283 7.2: 100 % of the rated load"
_HELD = "ISO 9283 6.2, 6.3: conditions are held constant"
_EXACT = 1.0  # per cent: weights are stated in two digits


def check(measured: Measured) -> Iterator[Finding]:
    """Yield a warning for a load other than the rated one, and for one that changes."""
    run = measured.run
    rated = first(run, _RATED)
    full = None if rated is None else rated.value(MASS)
    unclear = [] if rated is None or full else [rated]
    for line in stated(run, _LOAD):
        share = _share(line, full)
        if share is None and line.value(MASS) is None:
            unclear.append(line)
        if share is not None and abs(share - 100) > _EXACT:
            yield _other(f"{line} is {share:.3g} % of the rated load")
    yield from _columns(run, full)
    for line in unclear:
        yield Finding(
            CODE, "info", f"{line}: no mass that can be compared", advice="write 2 kg, or 100 %"
        )


def _share(line: Stated, full: float | None) -> float | None:
    """Return the per cent of the rated load: from the mass where both are known."""
    mass = line.value(MASS)
    return line.value(PERCENT) if mass is None or not full else 100 * mass / full


def _columns(run: Run, full: float | None) -> Iterator[Finding]:
    for name in _COLUMNS:
        values = run.covariates.get(name)
        if values is None:
            continue
        if np.ptp(values) > 0:
            said = f"{name} goes from {values.min():g} to {values.max():g} during the test"
            yield Finding(CODE, "warning", said, rule=_HELD)
        elif full and abs(100 * values[0] / full - 100) > _EXACT:
            yield _other(
                f"{name} {values[0]:g} is {100 * values[0] / full:.3g} % of the rated load"
            )


def _other(said: str) -> Finding:
    return Finding(CODE, "warning", said, rule=_RULE)
