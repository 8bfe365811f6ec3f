"""Tables without any effect, and tables with one that is known, and what the diagnosis says."""

from __future__ import annotations

import random
from collections.abc import Iterator

from scara_iso.diagnosis import SEED, CyclesWanted, close_the_loop
from scara_iso.tables import read_table
from scara_iso.validation.references import with_ending
from scara_iso.validation.result import ReferenceCheck

_CYCLES = 31
_NULLS = 20
_MOST_ALARMS = 3
"""More than three of twenty have a chance of 1.6 % at the level of 5 %."""
_SIGMA = 0.004  # [mm]


def diagnosis_checks() -> Iterator[ReferenceCheck]:
    """Yield how many tables of mere scatter are taken for more, and each effect that is named."""
    alarms = sum(_verdict(_scatter(seed)) != "nothing-to-explain" for seed in range(_NULLS))
    name = f"alarms in {_NULLS} tables of scatter"
    said = "few enough" if alarms <= _MOST_ALARMS else f"{alarms}: more than {_MOST_ALARMS}"
    yield ReferenceCheck("diagnosis", name, "level 5 %, docs/diagnosis.md", "few enough", said)
    for file in with_ending("effects", ".csv"):
        effect = file.name.removesuffix(".csv")
        source = f"readings made with {effect} and scatter of {_SIGMA:g} mm"
        found = _verdict(file.read_bytes())
        yield ReferenceCheck("diagnosis", effect, source, f"explained by {effect}", found)


def _verdict(table: bytes) -> str:
    found = close_the_loop(read_table(table), None, CyclesWanted(), seed=SEED)
    named = [one.effect for one in found.effects]
    return " ".join([found.verdict.value, *(["by", ", ".join(named)] if named else [])])


def _scatter(seed: int) -> bytes:
    rng = random.Random(seed)  # noqa: S311 - readings
    rows = [f"{cycle},{0.5 + rng.gauss(0, _SIGMA):.3f}" for cycle in range(1, _CYCLES + 1)]
    return "\n".join(["# unit: mm", "# resolution: 0.001", "cycle,X", *rows, ""]).encode()
