"""Tables without any effect, and tables with one that is known, and what the diagnosis says."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator

from scara_iso.diagnosis import SEED, CyclesWanted, close_the_loop
from scara_iso.tables import read_table
from scara_iso.validation.result import ReferenceCheck

_CYCLES = 31
_NULLS = 20
_MOST_ALARMS = 3
"""More than three of twenty have a chance of 1.6 % at the level of 5 %."""
_SIGMA = 0.004  # [mm]

Course = Callable[[int], float]


def _moved(k: int) -> int:
    """Return degrees above 20 in a cycle: up and down, like no other effect."""
    return (0, 3, 1, 4, 1, 5, 2, 6, 5, 3, 5, 0, 4, 2, 6, 1)[k % 16]


def _side(k: int) -> int:
    """Return the side from which a cycle arrives, in no order."""
    return (1, -1, -1, 1, 1, -1, 1, -1, 1, 1, -1, 1, -1, -1, -1, 1, -1)[k % 17]


_COURSES: dict[str, Course] = {
    "step": lambda k: 0.03 if k >= 16 else 0.0,
    "linear_drift": lambda k: 0.0012 * k,
    "warm_up": lambda k: 0.05 * (1 - math.exp(-k / 4)),
    "periodic": lambda k: 0.015 * math.sin(2 * math.pi * k / 7),
    "temperature": lambda k: 0.01 * _moved(k),
    "lost_motion": lambda k: 0.01 * _side(k),
}
"""What moves X in cycle k [mm]."""
_COLUMNS: dict[str, tuple[str, Course]] = {
    "temperature": ("temperature_C", lambda k: 20.0 + _moved(k)),
    "lost_motion": ("approach", _side),
}
"""The column that an effect acts through, by name, and its value in cycle k."""


def diagnosis_checks() -> Iterator[ReferenceCheck]:
    """Yield how many tables of mere scatter are taken for more, and each effect that is named."""
    alarms = sum(_verdict(None, seed) != "nothing-to-explain" for seed in range(_NULLS))
    name = f"alarms in {_NULLS} tables of scatter"
    said = "few enough" if alarms <= _MOST_ALARMS else f"{alarms}: more than {_MOST_ALARMS}"
    yield ReferenceCheck("diagnosis", name, "level 5 %, docs/diagnosis.md", "few enough", said)
    for seed, effect in enumerate(_COURSES):
        source = f"readings made with {effect} and scatter of {_SIGMA:g} mm"
        found = _verdict(effect, 100 + seed)
        yield ReferenceCheck("diagnosis", effect, source, f"explained by {effect}", found)


def _verdict(effect: str | None, seed: int) -> str:
    run = read_table(_table(effect, random.Random(seed)))  # noqa: S311 - readings
    found = close_the_loop(run, None, CyclesWanted(), seed=SEED)
    named = [one.effect for one in found.effects]
    return " ".join([found.verdict.value, *(["by", ", ".join(named)] if named else [])])


def _table(effect: str | None, rng: random.Random) -> bytes:
    course = _COURSES.get(effect or "")
    column = _COLUMNS.get(effect or "")
    header = ["cycle", "X", *([column[0]] if column else [])]
    rows = [
        [
            str(cycle),
            f"{0.5 + (course(cycle) if course else 0.0) + rng.gauss(0, _SIGMA):.3f}",
            *([f"{column[1](cycle):+g}"] if column else []),
        ]
        for cycle in range(1, _CYCLES + 1)
    ]
    lines = ["# unit: mm", "# resolution: 0.001", *map(",".join, (header, *rows)), ""]
    return "\n".join(lines).encode()
