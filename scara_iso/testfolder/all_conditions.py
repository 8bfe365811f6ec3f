"""Runs below each other: the poses of a condition, and the analysis of all conditions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from scara_iso.base.errors import DataError, Fault
from scara_iso.iso9283 import Analysis, Finding, LimitCheck, Poses, not_recorded
from scara_iso.run import Origin, Run, joined_axis


def runs_below(
    runs: Mapping[str, Run], called: Callable[[str, str | None], str], metadata: Mapping[str, str]
) -> Run:
    """Return the rows of runs of the same axes, by name, below each other.

    ``called`` gives the pose of a run its label. A size that one run does not state is not stated,
    else the largest counts. Columns that a run lacks are left out.
    """
    each = list(runs.values())
    labels: list[str] = []
    commands: dict[str, dict[str, float]] = {axis: {} for axis in each[0].axes}
    for name, run in runs.items():
        poses = [None] * len(run) if run.pose is None else run.pose.tolist()
        labels += [called(name, pose) for pose in poses]
        for axis, pose in product(run.axes, dict.fromkeys(poses)):
            if (command := run.command_of(axis, pose)) is not None:
                commands[axis][called(name, pose)] = command
    shared = [name for name in each[0].covariates if all(name in run.covariates for run in each)]
    return Run(
        cycle=np.concatenate([run.cycle for run in each]),
        axes={n: joined_axis([run.axes[n] for run in each], commands[n]) for n in each[0].axes},
        pose=np.array(labels),
        covariates={n: np.concatenate([run.covariates[n] for run in each]) for n in shared},
        metadata=metadata,
    )


def refuse_other_axes(runs: Mapping[str, Run], what: str, where: str, remedy: str) -> None:
    """Raise `DataError` unless all runs, by name, have the same axes in the same units."""
    found = {
        name: ", ".join(f"{axis.name} in {axis.unit}" for axis in run.axes.values())
        for name, run in runs.items()
    }
    if len(set(found.values())) > 1:
        faults = [Fault(f"{name}: {axes}") for name, axes in found.items()]
        raise DataError(what, where=where, faults=faults, remedy=remedy)


def pose_under(condition: str, pose: str | None) -> str:
    """Return the name of a pose among those of all conditions: ``P1-v50-l100``."""
    return f"{pose}-{condition}" if pose else condition


def joined_analysis(parts: Mapping[str, Analysis], missing: Sequence[str] = ()) -> Analysis:
    """Return one analysis of several by the names of their conditions, a pose as in `pose_under`.

    ``missing`` are the parts under conditions of which none is recorded. Raises `DataError` where
    they have not the same axes.
    """
    starts = np.cumsum([0, *(len(found.run) for found in parts.values())]).tolist()
    return replace(
        next(iter(parts.values())),
        run=_run({name: found.run for name, found in parts.items()}),
        cycles=min((found.cycles for found in parts.values()), key=lambda cycles: cycles.used),
        poses=Poses(
            replace(pose, label=pose_under(name, pose.label), rows=pose.rows + start)
            for (name, found), start in zip(parts.items(), starts, strict=False)
            for pose in found.poses
        ),
        findings=tuple(_findings(parts, missing)),
        limits=tuple(_limit(name, one) for name, found in parts.items() for one in found.limits),
        characteristics=tuple(
            replace(
                one,
                pose=pose_under(name, one.pose),
                between=tuple(pose_under(name, pose) for pose in one.between),
                limit=None if one.limit is None else _limit(name, one.limit),
            )
            for name, found in parts.items()
            for one in found.characteristics
        ),
    )


def _limit(condition: str, check: LimitCheck) -> LimitCheck:
    return replace(check, pose=pose_under(condition, check.pose))


def _run(runs: Mapping[str, Run]) -> Run:
    name, first = next(iter(runs.items()))
    source, remedy = first.origin.source, f"report each by itself: `condition={name}`"
    refuse_other_axes(runs, "the conditions have not the same axes", source, remedy)
    origins = [run.origin for run in runs.values()]
    origin = Origin(
        source,
        "; ".join(one.understood for one in origins),
        tuple(dict.fromkeys(note for one in origins for note in one.notes)),
        tuple(dict.fromkeys(remark for one in origins for remark in one.remarks)),
    )
    return replace(runs_below(runs, pose_under, dict(_stated(runs))), origin=origin)


def _stated(runs: Mapping[str, Run]) -> Iterator[tuple[str, str]]:
    """Yield what the conditions state: once where all say the same, else each by its name."""
    for key in dict.fromkeys(key for run in runs.values() for key in run.metadata):
        by_text: dict[str, list[str]] = {}
        for name, run in runs.items():
            if key in run.metadata:
                by_text.setdefault(run.metadata[key], []).append(name)
        if list(map(len, by_text.values())) == [len(runs)]:
            yield key, next(iter(by_text))
        else:
            yield key, "; ".join(f"{', '.join(at)}: {text}" for text, at in by_text.items())


def _findings(parts: Mapping[str, Analysis], missing: Sequence[str]) -> Iterator[Finding]:
    """Yield what was found: once, where every condition says it of the whole of itself."""
    first, *others = (found.findings for found in parts.values())
    shared = [
        found for found in first if found.pose is None and all(found in one for one in others)
    ]
    yield from shared
    for name, analysis in parts.items():
        for found in analysis.findings:
            if found not in shared:
                yield replace(found, pose=pose_under(name, found.pose))
    if missing:
        yield not_recorded(", ".join(missing))
