"""Tables with one known effect each, for the selftest: python -m tests.oracles.effect_tables.

Plain Python, nothing of the program: what moves X is written out here once more.
"""

import math
import random
from pathlib import Path

FOLDER = Path(__file__).parents[2] / "scara_iso" / "commands" / "data" / "effects"
CYCLES = 31
SIGMA = 0.004  # [mm]


def moved(k):
    """Return degrees above 20 in a cycle: up and down, like no other effect."""
    return (0, 3, 1, 4, 1, 5, 2, 6, 5, 3, 5, 0, 4, 2, 6, 1)[k % 16]


def side(k):
    """Return the side from which a cycle arrives, in no order."""
    return (1, -1, -1, 1, 1, -1, 1, -1, 1, 1, -1, 1, -1, -1, -1, 1, -1)[k % 17]


COURSES = {
    "step": lambda k: 0.03 if k >= 16 else 0.0,
    "linear_drift": lambda k: 0.0012 * k,
    "warm_up": lambda k: 0.05 * (1 - math.exp(-k / 4)),
    "periodic": lambda k: 0.015 * math.sin(2 * math.pi * k / 7),
    "temperature": lambda k: 0.01 * moved(k),
    "lost_motion": lambda k: 0.01 * side(k),
}
COLUMNS = {
    "temperature": ("temperature_C", lambda k: 20.0 + moved(k)),
    "lost_motion": ("approach", side),
}


def table(effect, seed):
    """Return the text of a table with an effect in X [mm]."""
    rng = random.Random(seed)  # noqa: S311 - readings
    name, values = COLUMNS.get(effect, (None, None))
    rows = [["cycle", "X", *([name] if name else [])]]
    for k in range(1, CYCLES + 1):
        x = 0.5 + COURSES[effect](k) + rng.gauss(0, SIGMA)
        rows.append([str(k), f"{x:.3f}", *([f"{values(k):+g}"] if name else [])])
    return "\n".join(["# unit: mm", "# resolution: 0.001", *map(",".join, rows), ""])


def tables():
    """Return the text of each table by the name of its effect."""
    return {effect: table(effect, 100 + k) for k, effect in enumerate(COURSES)}


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for effect, text in tables().items():
        (FOLDER / f"{effect}.csv").write_text(text, encoding="utf-8")
