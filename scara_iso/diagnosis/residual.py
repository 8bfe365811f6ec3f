"""What the model leaves: measured minus predicted readings, and what of them can be searched."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError
from scara_iso.diagnosis.tuning import FEWEST_CYCLES, MOST_CYCLES, NEIGHBOURS
from scara_iso.effects import Conditions
from scara_iso.run import FloatArray, Run, is_transient, seen_step

Predicted = Mapping[str, npt.ArrayLike]
"""Predicted readings (n,) by axis."""

_SAME = 0.9999
"""Correlation from which two columns count as copies of each other."""
_EXACT = 1e-6


@dataclass(frozen=True, eq=False, slots=True)
class Residual:
    """Measured minus predicted readings of one pose.

    ``values`` has shape (n, axes); ``division`` (axes,) is the dial's resolution, or the step on
    which all readings lie where none is stated, 0 where there is none. ``notes`` say what was left
    out of the search and why.
    """

    axes: tuple[str, ...]
    values: FloatArray
    division: FloatArray
    conditions: Conditions
    notes: tuple[str, ...] = ()
    moved: FloatArray | float = 0.0
    """By how much the prediction moves from its mean (n, axes): in the next test it does again."""

    def __len__(self) -> int:
        return len(self.values)


def neighbours(residual: Residual) -> npt.NDArray[np.bool_]:
    """Return which axes show at most three neighbouring divisions, shape (axes,).

    Rounding alone makes such readings look like two states, or like a changing scatter.
    """
    return np.asarray(np.ptp(residual.values, axis=0) < NEIGHBOURS * residual.division)


def residual_of(run: Run, predicted: Predicted | None) -> Residual:
    """Return what ``predicted`` (axis to n readings; None: a constant pose) leaves of ``run``.

    ``run`` holds one pose without the discarded cycle. Axes that never move, or that copy another
    axis, and covariates that are constant or copy the cycle number are left out with a note.
    Raises `DataError` for fewer than 8 cycles or more than 500, an axis of the prediction that was
    not measured, a wrong number of predicted readings, or when every axis is stuck.
    """
    if len(run) < FEWEST_CYCLES:
        raise DataError(
            f"{len(run)} usable cycles cannot tell structure from scatter",
            where=run.origin.source,
            remedy=f"measure at least {FEWEST_CYCLES} cycles, better 30",
        )
    if len(run) > MOST_CYCLES:
        raise DataError(
            f"{len(run)} cycles are more than a diagnosis compares in one piece",
            where=run.origin.source,
            remedy=f"diagnose blocks of at most {MOST_CYCLES} cycles",
        )
    model = _checked(run, predicted or {})
    values = {name: axis.readings - model.get(name, 0.0) for name, axis in run.axes.items()}
    division = {n: seen_step(a) for n, a in run.axes.items()}
    kept, notes = _moving(values, division)
    used = {name: division[name] for name in kept}
    notes += _about_steps(run, used)
    if not kept:
        raise DataError(
            "no axis moves: every reading is the same",
            where=run.origin.source,
            remedy="check the indicators, or use one with a finer resolution",
        )
    covariates, more = _informative(run)
    moved = np.stack([model.get(name, np.zeros(len(run))) for name in kept], axis=1)
    return Residual(
        axes=kept,
        values=np.stack([values[name] for name in kept], axis=1),
        division=np.array([division[name] for name in kept]),
        conditions=Conditions(run.cycle, covariates),
        notes=(*notes, *more),
        moved=moved - moved.mean(axis=0),
    )


def _about_steps(run: Run, division: Mapping[str, float]) -> Iterator[str]:
    steps = [f"{n} {d:g}" for n, d in division.items() if d and run.axes[n].resolution is None]
    if steps:
        yield (
            f"no resolution is stated: the steps on which readings lie ({', '.join(steps)}) stand "
            "for the dial's"
        )
    for name, step in division.items():
        stated, levels = run.axes[name].resolution, np.unique(run.axes[name].shown)
        if stated and step > stated:
            yield (
                f"{name}: readings lie on steps of {step:.3g}, coarser than the resolution stated, "
                f"{stated:g}: these steps stand for the dial's"
            )
        elif stated and len(levels) == 2 and np.ptp(levels) > 1.5 * stated:
            yield (
                f"{name}: two different readings, {np.ptp(levels):.3g} apart, and the resolution "
                f"stated is {stated:g}: if the dial moves in such steps, state them and diagnose "
                "anew; scatter then looks like two levels"
            )


def _checked(run: Run, predicted: Predicted) -> dict[str, FloatArray]:
    unknown = [name for name in predicted if name not in run.axes]
    if unknown:
        raise DataError(
            f"the model predicts {', '.join(unknown)}, which the table does not hold",
            where=run.origin.source,
            remedy="use the model of this robot and this set of indicators",
        )
    model = {name: np.asarray(values, dtype=np.float64) for name, values in predicted.items()}
    wrong = [name for name, values in model.items() if values.shape != run.cycle.shape]
    if wrong:
        raise DataError(f"{', '.join(wrong)}: not one prediction for each of {len(run)} cycles")
    return model


def _moving(
    values: Mapping[str, FloatArray], division: Mapping[str, float]
) -> tuple[tuple[str, ...], list[str]]:
    kept: list[str] = []
    notes: list[str] = []
    for name, series in values.items():
        copied = [k for k in kept if _copies(series, values[k], division[name])]
        if np.ptp(series) == 0:
            notes.append(f"{name} never moves: a stuck channel, or scatter below one division")
        elif copied:
            notes.append(f"{name} is an exact function of {copied[0]} and adds nothing to it")
        else:
            kept.append(name)
    return tuple(kept), notes


def _informative(run: Run) -> tuple[dict[str, FloatArray], list[str]]:
    kept: dict[str, FloatArray] = {}
    notes: list[str] = []
    for name, series in run.covariates.items():
        copied = [other for other in kept if other != "time_s" and _same(series, kept[other])]
        if is_transient(name):
            continue  # how an arrival ended moves no reading
        if name == "time_s":
            kept[name] = series
        elif np.ptp(series) == 0:
            notes.append(f"{name} is constant: it can explain nothing")
        elif _same(series, run.cycle.astype(np.float64)):
            notes.append(
                f"{name} only copies the cycle number: its effect would be a drift over the cycles"
            )
        else:
            kept[name] = series
            notes += [f"{name} and {c} are exact functions of each other" for c in copied]
    return kept, notes


def _same(a: FloatArray, b: FloatArray) -> bool:
    """Whether one is a linear function of the other; constant columns are nobody's copy."""
    a, b = a - a.mean(), b - b.mean()
    product = float(np.linalg.norm(a) * np.linalg.norm(b))
    return product > 0 and abs(float(a @ b)) > _SAME * product


def _copies(a: FloatArray, b: FloatArray, division: float) -> bool:
    """Whether ``a`` is a linear function of ``b`` but for its rounding.

    Two axes that a large effect moves together correlate as much, and differ by their scatter.
    """
    if not _same(a, b):
        return False
    a, b = a - a.mean(), b - b.mean()
    left = a - b * float(a @ b) / float(b @ b)
    return float(np.abs(left).max()) <= max(division, _EXACT * float(np.ptp(a)))
