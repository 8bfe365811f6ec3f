"""What is searched: the rows of a run that count, of one pose or all, less what a model predicts.

All poses of a test are one run: a row for each cycle and an axis for each indicator at each pose.
What is common to the visits of a cycle then stays together whatever is done with the cycles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt
from threadpoolctl import threadpool_limits

from scara_iso import robot
from scara_iso.base.errors import DataError
from scara_iso.diagnosis.verdict import FEWEST_CYCLES, MOST_CYCLES
from scara_iso.effects import Conditions, OwnEffect
from scara_iso.iso9283 import (
    AS_THE_TABLE_SAYS,
    Counting,
    UsedCycles,
    block_of_rows,
    cycles_of_all_poses,
    repeatability,
    used_cycles,
)
from scara_iso.run import (
    Axis,
    FloatArray,
    IntArray,
    Origin,
    Run,
    is_transient,
    no_such_pose,
    seen_step,
)

if TYPE_CHECKING:
    from scara_iso.robot import Model


Predicted = Mapping[str, npt.ArrayLike]
"""Predicted readings (n,) by axis."""

_SAME = 0.9999
"""Correlation from which two columns count as copies of each other."""
_EXACT = 1e-6
_PLANES = {"XY": ("X", "Y"), "XYZ": ("X", "Y", "Z")}

NEIGHBOURS = 2.5
"""Readings within fewer divisions than this are neighbours on the dial: no proof of two levels."""

TWO_DIVISIONS = 1.5
"""Readings within fewer divisions than this are one division and its neighbour."""

_Work = TypeVar("_Work", bound=Callable[..., object])
on_one_thread: Callable[[_Work], _Work] = threadpool_limits.wrap(limits=1, user_api="blas")
"""A second thread gains nothing on matrices of thirty readings, and waits in a loop."""

Joints: TypeAlias = tuple[float, float]
"""Joints 1 and 2 in degrees."""


@dataclass(frozen=True, slots=True)
class CyclesWanted:
    """Which rows of a table count, and which pose."""

    pose: str | None = None
    counting: Counting = AS_THE_TABLE_SAYS

    def used(self, run: Run) -> UsedCycles:
        """Return the rows of every pose that count; `DataError` for a drift test."""
        if block_of_rows(run) is not None:
            raise DataError(
                "a drift test is not diagnosed: its course over the hours is its figure",
                where=run.origin.source,
                remedy="see it with scara-iso analyze; for another test call the column 'block' "
                "otherwise, and number the cycles through",
            )
        return used_cycles(run, self.counting)

    def take(self, run: Run) -> Run:
        """Return the rows of one pose that count; `DataError` where several poses are there."""
        run = run.unwrapped()
        chosen = self.used(run)
        labels = list(chosen.poses)
        if self.pose is not None and self.pose not in labels:
            raise no_such_pose(self.pose, labels, run.origin.source)
        if self.pose is None and len(labels) > 1:
            raise DataError(
                f"{len(labels)} poses, of which one is diagnosed at a time",
                where=run.origin.source,
                remedy=f"name it: `pose={labels[0]}`",
            )
        return run.take(chosen.rows[0 if self.pose is None else labels.index(self.pose)])

    def all_poses(self, run: Run) -> AllPoses:
        """Return the rows of all poses that count, as one run."""
        run = run.unwrapped()
        used = self.used(run)
        poses = map(str, used.poses)
        return whole_cycles(run, dict(zip(poses, used.rows, strict=True)))


class PoseAxis(NamedTuple):
    """An indicator at a pose; ``unit`` is mm or deg."""

    pose: str
    axis: str
    unit: str


class AllPoses(NamedTuple):
    """A test as one ``run`` of all its poses; ``axes`` says which pose and indicator each is.

    ``parts`` are the rows of each pose alone, in the order of the run's cycles; ``visits`` the
    columns of which each pose has its own.
    """

    run: Run
    axes: Mapping[str, PoseAxis]
    parts: Mapping[str, Run]
    notes: tuple[str, ...]
    visits: tuple[str, ...] = ()

    def conditions(self, poses: Iterable[str]) -> Conditions:
        """Return the run's, and the visits of some poses."""
        own = {p: {n: self.parts[p].covariates[n] for n in self.visits} for p in poses}
        return Conditions(self.run.cycle, self.run.covariates, own)

    def planes(self) -> dict[str, tuple[str, ...]]:
        """Return the axes of each RP: every axis, and plane and space of each pose."""
        found: dict[str, tuple[str, ...]] = {name: (name,) for name in self.axes}
        for pose, part in self.parts.items():
            for name, own in groups_of(part.axes).items():
                found[axis_at(name, pose)] = tuple(axis_at(axis, pose) for axis in own)
        return found


def groups_of(axes: Iterable[str]) -> dict[str, tuple[str, ...]]:
    """Return the axes of each RP: every axis, and the plane and space where all theirs are."""
    named = tuple(axes)
    planes = {name: own for name, own in _PLANES.items() if set(own) <= set(named)}
    return {name: (name,) for name in named} | planes


def repeatabilities(
    readings: Mapping[str, FloatArray], groups: Mapping[str, tuple[str, ...]]
) -> dict[str, float]:
    """Return RP of each group of axes: of one axis eq. 6, of several radial (ISO 9283 7.2.2)."""
    return {
        name: float(repeatability(np.stack([readings[axis] for axis in axes])).RP)
        for name, axes in groups.items()
    }


def axis_at(axis: str, pose: str) -> str:
    """Return the name of an axis, or a plane, at a pose."""
    return f"{axis} at {pose}"


def whole_cycles(run: Run, rows: Mapping[str, IntArray]) -> AllPoses:
    """Return the ``rows`` of a run that count, by pose, as one run.

    Cycles that are not there at every pose are left out, with a note; where poses hardly share a
    number their cycles are taken in turn.
    """
    parts, notes = _alike({pose: run.take(own) for pose, own in rows.items()})
    axes, of = {}, {}
    for pose, part in parts.items():
        for name, axis in part.axes.items():
            own = axis_at(name, pose)
            of[own] = PoseAxis(pose, name, axis.unit)
            axes[own] = Axis(own, axis.readings, axis.dimension, axis.resolution, axis.uncertainty)
    covariates, visits, more = _of_cycles([*parts.values()])
    first = next(iter(parts.values()))
    origin = Origin(source=run.origin.source)
    whole = Run(first.cycle, axes, covariates=covariates, metadata=run.metadata, origin=origin)
    return AllPoses(whole, of, parts, (*notes, *more), visits)


def _alike(parts: dict[str, Run]) -> tuple[dict[str, Run], list[str]]:
    """Return the poses with the same cycles, and what was left out for it."""
    rows, note = cycles_of_all_poses([part.cycle for part in parts.values()], FEWEST_CYCLES)
    kept = {pose: part.take(own) for (pose, part), own in zip(parts.items(), rows, strict=True)}
    return kept, [note] if note else []


def _of_cycles(
    parts: Sequence[Run],
) -> tuple[dict[str, FloatArray], tuple[str, ...], list[str]]:
    """Return the covariates of the cycles: the means of their visits, where these are alike.

    Then the names of those that are not, and notes.
    """
    kept, own, notes = {}, [], []
    for name in parts[0].covariates:
        if not all(name in part.covariates for part in parts):
            continue
        visits = np.stack([part.covariates[name] for part in parts])
        mean = visits.mean(axis=0)
        within = visits - mean - (visits - mean).mean(axis=1, keepdims=True)
        if within.var() <= mean.var() or not np.ptp(visits):
            kept[name] = mean
        elif np.ptp(visits, axis=1).all() and not is_transient(name):
            own.append(name)
        else:
            notes.append(
                f"{name} differs between the visits of a cycle: it is left out of the search over "
                "all poses; `pose=` searches one with it"
            )
    return kept, tuple(own), notes


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


def all_own(own: Sequence[OwnEffect], model: Model | None) -> tuple[OwnEffect, ...]:
    """Return the user's effects and a model's, of two of a name the model's."""
    known = {one.name: one for one in (*own, *(() if model is None else model.own))}
    return tuple(known.values())


def not_looked_for(own: Iterable[OwnEffect], run: Run) -> Iterator[str]:
    """Yield which of the user's effects cannot show in a run, and why."""
    for one in own:
        missing = [name for name in one.needs if name not in run.covariates]
        forms = one.forms(Conditions(run.cycle, run.covariates))
        if missing:
            yield f"{one.name}: not looked for; the table has no column {', '.join(missing)}"
        elif not any(np.ptp(form.columns) > 0 for form in forms):
            yield f"{one.name}: not looked for; its formula moves nothing in these cycles"


def doubts(model: Model, run: Run) -> Iterator[str]:
    """Yield what makes it doubtful that a model is that of the run."""
    unknown = [axis for axis in run.axes if axis not in model.indicators]
    if unknown:
        yield f"the model has no indicator {', '.join(unknown)}: a constant pose is taken there"
    named = run.metadata.get("robot", "")
    if model.robot and named and model.robot.casefold() != named.casefold():
        yield f"the model is that of {model.robot}, the table is of {named}: is it the right one?"


def predicted_by(model: Model | None, run: Run) -> dict[str, np.ndarray] | None:
    """Return what a model predicts of a run's axes; `DataError` where it has none of them."""
    if model is None:
        return None
    unknown = [name for name in run.axes if name not in model.indicators]
    if len(unknown) == len(run.axes):
        raise DataError(
            f"the model has no indicator {', '.join(unknown)}",
            where=run.origin.source,
            remedy="take the model of this robot, or leave `model=` out",
        )
    for name, axis in run.axes.items():
        if name in model.indicators and model.indicators[name].dimension is not axis.dimension:
            raise DataError(
                f"{name} is in {axis.unit}, and in {model.indicators[name].dimension.value} in the "
                "model",
                where=run.origin.source,
                remedy=f"state the unit of [indicator.{name}], or take the model of this robot",
            )
    expected = robot.predict(model, Conditions(run.cycle, run.covariates))
    return {name: a.readings for name, a in expected.axes.items() if name in run.axes}
