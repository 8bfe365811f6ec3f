"""Undeclared effects made by other equations: what the diagnosis says of them, over many seeds.

``python -m benchmarks.undeclared`` prints the tables of benchmarks/results/undeclared.md, with
``--write`` it puts them there. OPENBLAS_NUM_THREADS=1 in the environment saves most of its time.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from functools import partial
from multiprocessing import Pool
from pathlib import Path

import numpy as np
from scipy.stats import kendalltau

from benchmarks import page
from scara_iso.diagnosis import Diagnosis
from scara_iso.diagnosis.closed_loop import close_the_loop
from scara_iso.diagnosis.engine.residual import CyclesWanted

sys.path.append(str(Path(__file__).parents[1] / "tests"))
sys.path.append(str(Path(__file__).parents[1] / "tests" / "support"))

from undeclared import FAMILIES, OUTCOMES, Family, outcome
from undeclared.probe import DIVISION, Window, windows

SEEDS = 300
PAGE = page.RESULTS / "undeclared.md"


def families() -> Iterator[str]:
    """Yield a row for each family: what the verdicts were, in percent."""
    yield f"| made by | right names | {' | '.join(OUTCOMES)} | held-out error, after / before |"
    yield f"|---|---|{'---|' * (len(OUTCOMES) + 1)}"
    for family in FAMILIES:
        with Pool(2) as pool:
            found = pool.map(partial(_diagnosed, family), range(SEEDS))
        counts = Counter(outcome(family, one) for one in found)
        shares = (f"{100 * counts[name] / SEEDS:.0f}" for name in OUTCOMES)
        names = ", ".join(sorted(family.names)) or ("nothing" if family.silent else "unexplained")
        yield f"| {family.name} | {names} | {' | '.join(shares)} | {_gain(found)} |"


def _diagnosed(family: Family, seed: int) -> Diagnosis:
    return close_the_loop(family.table(seed), None, CyclesWanted(), seed=seed)


def _gain(found: list[Diagnosis]) -> str:
    ratios = [
        one.error.after.held_out_rms[axis] / one.error.before.held_out_rms[axis]
        for one in found
        for effect in one.effects[:1]
        for axis in effect.axes
    ]
    return f"{np.median(ratios):.2f}" if ratios else ""


def probe() -> Iterator[str]:
    """Yield a row for each phase of the real probe."""
    yield (
        "| phase | windows | of them with a trend (Kendall) | verdicts | error on the next 31 "
        "touches before [um] | after |"
    )
    yield "|---|---|---|---|---|---|"
    every = [(w, _of_probe(w)) for w in windows() if np.ptp(w.run.axes["Z"].readings[1:])]
    for phase in dict.fromkeys(w.phase for w, _ in every):
        own = [(w, found) for w, found in every if w.phase == phase]
        said = Counter(
            found.effects[0].effect if found.effects else found.verdict.value for _, found in own
        )
        before, after = (
            np.median([1000 * getattr(found.error, name).held_out_rms["Z"] for _, found in own])
            for name in ("before", "after")
        )
        verdicts = ", ".join(f"{name} {count}" for name, count in said.most_common())
        moving = sum(trend(w) < 0.01 for w, _ in own)
        yield (f"| {phase} | {len(own)} | {moving} | {verdicts} | {before:.2f} | {after:.2f} |")
    yield ""
    yield f"One division of the probe is {1000 * DIVISION} um; medians over the windows."


def trend(window: Window) -> float:
    """Return the p-value of Kendall's rank correlation of reading and time."""
    z = window.run.axes["Z"].readings[1:]
    return float(kendalltau(np.arange(len(z)), z).pvalue)


def _of_probe(window: Window) -> Diagnosis:
    return close_the_loop(window.run, None, CyclesWanted(), hold_out=window.following, seed=1)


if __name__ == "__main__":
    page.run({"families": families, "probe": probe}, PAGE, __doc__)
