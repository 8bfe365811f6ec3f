"""All poses of a test as one run: a row for each cycle, an axis for each indicator at each pose.

What is common to the visits of a cycle then stays together whatever is done with the cycles.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from scara_iso.diagnosis.tuning import FEWEST_CYCLES
from scara_iso.run import Axis, FloatArray, IntArray, Origin, Run

_PLANES = {"XY": ("X", "Y"), "XYZ": ("X", "Y", "Z")}


@dataclass(frozen=True, eq=False, slots=True)
class PoseAxis:
    """An indicator at a pose; ``unit`` is mm or deg."""

    pose: str
    axis: str
    unit: str


@dataclass(frozen=True, eq=False, slots=True)
class AllPoses:
    """A test as one ``run`` of all its poses; ``axes`` says which pose and indicator each is.

    ``parts`` are the rows of each pose alone, in the order of the run's cycles.
    """

    run: Run
    axes: Mapping[str, PoseAxis]
    parts: Mapping[str, Run]
    notes: tuple[str, ...]

    def planes(self) -> dict[str, tuple[str, ...]]:
        """Return the axes of each RP: every axis, and plane and space of each pose."""
        found: dict[str, tuple[str, ...]] = {name: (name,) for name in self.axes}
        for pose, part in self.parts.items():
            for plane, own in _PLANES.items():
                if set(own) <= set(part.axes):
                    found[axis_at(plane, pose)] = tuple(axis_at(axis, pose) for axis in own)
        return found


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
    covariates, more = _of_cycles([*parts.values()])
    first = next(iter(parts.values()))
    origin = Origin(source=run.origin.source)
    whole = Run(first.cycle, axes, covariates=covariates, metadata=run.metadata, origin=origin)
    return AllPoses(whole, of, parts, (*notes, *more))


def _alike(parts: dict[str, Run]) -> tuple[dict[str, Run], list[str]]:
    """Return the poses with the same cycles, and what was left out for it."""
    shared = set.intersection(*(set(part.cycle.tolist()) for part in parts.values()))
    fewest = min(map(len, parts.values()))
    if len(shared) < min(FEWEST_CYCLES, fewest):
        said = "the poses do not share the numbers of their cycles: they are taken in turn"
        return {p: part.take(np.arange(fewest)) for p, part in parts.items()}, [said]
    gone = sorted({c for part in parts.values() for c in part.cycle.tolist()} - shared)
    kept = {
        pose: part.take(np.flatnonzero(np.isin(part.cycle, [*shared])))
        for pose, part in parts.items()
    }
    notes = (
        [f"cycle {', '.join(map(str, gone))}: not there at every pose, left out"] if gone else []
    )
    return kept, notes


def _of_cycles(parts: Sequence[Run]) -> tuple[dict[str, FloatArray], list[str]]:
    """Return the covariates of the cycles: the means of their visits, where these are alike."""
    kept, notes = {}, []
    for name in parts[0].covariates:
        if not all(name in part.covariates for part in parts):
            continue
        visits = np.stack([part.covariates[name] for part in parts])
        mean = visits.mean(axis=0)
        within = visits - mean - (visits - mean).mean(axis=1, keepdims=True)
        if within.var() <= mean.var() or not np.ptp(visits):
            kept[name] = mean
        else:
            notes.append(
                f"{name} differs between the visits of a cycle: it is left out of the search over "
                "all poses; `pose=` searches one with it"
            )
    return kept, notes
