"""What real readings once showed to be wrong, each on tables that show it: how often it still is.

    python benchmarks/mended.py [--tables 20] [--only LINE ...]

Every table goes through `diagnose --json`, so any version of the program can be asked: start this
file with that version first on PYTHONPATH. *right*: the likeliest effect, or the silence, is right;
*rival*: a right name stands among the rivals; *sure*: another name, stated with at least 90 %.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import io
import json
import tempfile
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from scara_iso.commands import main as scara_iso

if TYPE_CHECKING:
    from collections.abc import Callable

PROBE = Path(__file__).parents[1] / "tests" / "fixtures" / "probe_thermal" / "touches.csv"
SILENT = "nothing-to-explain"
DRIFT, N = {"linear_drift", "warm_up"}, 30
warnings.filterwarnings("ignore")


@dataclass(frozen=True)
class Line:
    """One failure: columns of divisions after the first cycle, and what would be right."""

    name: str
    table: Callable[[np.random.Generator], dict[str, np.ndarray]]
    right: set[str]


def noise(rng: np.random.Generator, n: int = N, sigma: float = 1.0) -> np.ndarray:
    """Return scatter."""
    return sigma * rng.normal(size=n)


def step(rng: np.random.Generator, size: float, n: int = N) -> np.ndarray:
    """Return a step in the middle half."""
    return size * (np.arange(n) >= rng.integers(n // 4, 3 * n // 4))


def slow(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return a drift over an edge of a coarse dial, whose scatter is a fifth of a division."""
    return {"Z": rng.uniform(-0.5, 0.5) + np.linspace(0, 1, N) + noise(rng, sigma=0.2)}


def one_division(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return equal readings and one of the next division."""
    return {"X": np.arange(N) == rng.integers(N)}


def gross(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return two readings 25 scatters off."""
    y = noise(rng)
    y[rng.choice(np.arange(2, N - 2), 2, replace=False)] += 25
    return {"X": y}


def odd_beside_step(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return a step and one odd reading."""
    y = noise(rng, sigma=0.7) + step(rng, 4)
    y[rng.integers(2, N - 2)] += 12
    return {"X": y}


def approached(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return alternating approaches, and lost motion along them."""
    approach = np.resize([1, -1], N)
    return {"X": noise(rng) + 1.5 * approach, "approach": approach}


def growing_gap(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return lost motion that grows from visit to visit."""
    approach = rng.permutation(np.resize([1, -1], N))
    return {"X": noise(rng) + np.linspace(0, 4, N) * approach, "approach": approach}


def long_warm_up(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return 80 readings of a warm-up whose time constant is 25."""
    return {"Z": noise(rng, 80) + 8 * np.exp(-np.arange(80) / 25)}


def strong(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return a smooth course of 200 scatters that no exponential follows quite."""
    k = np.arange(N)
    return {"Z": 90 * (1 - np.exp(-((k / 5) ** 0.9))) + noise(rng, sigma=0.4)}


def two_times(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return a warm-up of 200 scatters with two time constants."""
    k = np.arange(N)
    return {"Z": noise(rng) + 120 * (1 - np.exp(-k / 2)) + 80 * (1 - np.exp(-k / 12))}


def lagging(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return heating, soak and cooling with a machine that lags behind its thermometer."""
    room = np.interp(np.arange(60), [0, 10, 40, 60], [22, 60, 60, 25])
    body = [22.0]
    for now in room[1:]:
        body.append(body[-1] + (now - body[-1]) / 12)
    return {"Z": 0.8 * np.array(body) + noise(rng, 60), "temperature_C": room.round(1)}


def heated(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return nothing, and from some cycle on a slope."""
    return {"Z": np.maximum(np.arange(N) - rng.integers(8, 20), 0) * 0.8 + noise(rng)}


def soak(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return thirty touches of the real probe, from the first fifteen minutes of its soak."""
    with PROBE.open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["phase"] == "soak"]
    run = rng.choice(sorted({row["run"] for row in rows}))
    own = [float(row["steps"]) for row in rows if row["run"] == run]
    start = rng.integers(0, 60)
    return {"Z": np.array(own[start : start + N])}


def remembering(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return scatter that remembers a third of the reading before."""
    y = [rng.normal()]
    for _ in range(N - 1):
        y.append(0.33 * y[-1] + np.sqrt(1 - 0.33**2) * rng.normal())
    return {"X": 2 * np.array(y)}


def pulse(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return something that comes and goes once."""
    return {"X": noise(rng) + 5 * np.exp(-(((np.arange(N) - rng.uniform(9, 21)) / 3) ** 2))}


def widening(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return scatter that doubles half way, on three axes."""
    wide = np.where(np.arange(N) < N // 2, 1.5, 3.0)
    return {axis: wide * rng.normal(size=N) for axis in "XYZ"}


def flat(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return uniform scatter."""
    return {"X": rng.uniform(-2, 2, 60)}


def narrow(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return readings of two neighbouring divisions in no order."""
    return {"X": rng.random(N) < 0.5, "Y": noise(rng)}


def eleven(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return eleven readings with a step."""
    return {"X": noise(rng, 11, 0.6) + 5 * (np.arange(11) >= rng.integers(4, 8))}


def step_and_drift(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return a step on X and a drift on Y."""
    return {"X": noise(rng) + step(rng, 4), "Y": noise(rng) + np.linspace(0, 5, N)}


LINES = (
    Line("drift on a coarse dial", slow, DRIFT),
    Line("one reading of the next division", one_division, {SILENT}),
    Line("two readings 25 scatters off", gross, {"outlier"}),
    Line("odd reading beside a step", odd_beside_step, {"step", "outlier"}),
    Line("alternating approach, recorded", approached, {"lost_motion"}),
    Line("a gap that grows", growing_gap, {"gap_growth"}),
    Line("80 readings of a warm-up", long_warm_up, {"warm_up"}),
    Line("smooth course of 200 scatters", strong, {"warm_up"}),
    Line("machine behind its thermometer", lagging, {"temperature_lagged"}),
    Line("a slope that begins later", heated, {"onset"}),
    Line("real probe, early soak", soak, {"warm_up", "linear_drift"}),
    Line("scatter with a memory of 0.33", remembering, {"autocorrelated", SILENT}),
    Line("a pulse", pulse, {"transient"}),
    Line("scatter doubles on three axes", widening, {"scatter_change"}),
    Line("uniform scatter, 60 readings", flat, {SILENT}),
    Line("two neighbouring divisions", narrow, {SILENT}),
    Line("eleven readings with a step", eleven, {"step"}),
    Line("step on X and drift on Y", step_and_drift, {"step", "linear_drift"}),
    Line("two time constants, 200 scatters", two_times, {"warm_up"}),
)


def written(columns: dict[str, np.ndarray], to: Path) -> int:
    """Write a table of whole divisions, whose first cycle is discarded; return its cycles."""
    recorded = {name: name in ("approach", "temperature_C") for name in columns}
    body = [
        values if recorded[name] else np.round(np.asarray(values, float)) / 100
        for name, values in columns.items()
    ]
    table = np.column_stack([np.arange(2, len(body[0]) + 2), *body])
    table = np.vstack([np.r_[1, table[0, 1:]], table])
    header = "# unit: mm\n# resolution: 0.01\n" + ",".join(["cycle", *columns])
    np.savetxt(to, table, delimiter=",", header=header, comments="", fmt="%.6g")
    return len(table)


def said(table: Path, cycles: int) -> dict[str, object] | str:
    """Return the program's answer about a table, or how it failed."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
        try:
            code = scara_iso(["diagnose", str(table), "--json", "--cycles", str(cycles)])
        except (SystemExit, ValueError, IndexError) as error:
            code = getattr(error, "code", 70)
    text = out.getvalue()
    return json.loads(text) if text.strip() else f"exit {code}"


def outcome(answer: dict[str, object] | str, right: set[str]) -> str:
    """Return right, rival, unsure, sure or how it failed."""
    if isinstance(answer, str):
        return answer
    if not answer["effects"]:
        return "right" if answer["verdict"] in right else str(answer["verdict"])
    best = answer["effects"][0]
    if best["effect"] in right:
        more = {effect["effect"] for effect in answer["effects"]} - right
        return "right, and a false second one" if more else "right"
    if right & {rival["effect"] for rival in best["rivals"]}:
        return "rival"
    return "sure" if best["probability"] >= 0.9 else "another, unsure"


def main() -> None:
    """Print one row a line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tables", type=int, default=20)
    parser.add_argument("--only", nargs="*")
    options = parser.parse_args()
    print("| tables | right | rival | sure and wrong | else |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for number, line in enumerate(LINES):
            if options.only and line.name not in options.only:
                continue
            every = []
            for seed in range(options.tables):
                table = Path(folder, f"{number}-{seed}.csv")
                cycles = written(line.table(np.random.default_rng([number, seed])), table)
                every.append(outcome(said(table, cycles), line.right))
            share = {o: round(100 * every.count(o) / len(every)) for o in sorted(set(every))}
            first = [share.pop(key, 0) for key in ("right", "rival", "sure")]
            rest = ", ".join(f"{text} {value}" for text, value in share.items())
            print(f"| {line.name} | {' | '.join(map(str, first))} | {rest} |", flush=True)


if __name__ == "__main__":
    main()
