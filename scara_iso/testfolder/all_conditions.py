"""Runs below each other: the poses of a condition, and the analysis of all conditions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.base.errors import DataError, Fault
from scara_iso.iso9283 import Analysis, Characteristic, Finding, LimitCheck, Poses, not_recorded
from scara_iso.run import Commanded, Origin, Run, joined_axis


def runs_below(
    runs: Sequence[Run],
    labels: Sequence[Sequence[str]],
    commands: Mapping[str, Commanded],
    metadata: Mapping[str, str],
) -> Run:
    """Return the rows of runs of the same axes below each other.

    ``labels`` of the poses, one for each row of each run; ``commands`` by axis. A size that one run
    does not state is not stated, else the largest counts. Columns that a run lacks are left out.
    """
    shared = [name for name in runs[0].covariates if all(name in run.covariates for run in runs)]
    return Run(
        cycle=np.concatenate([run.cycle for run in runs]),
        axes={n: joined_axis([run.axes[n] for run in runs], commands[n]) for n in runs[0].axes},
        pose=np.concatenate(labels),
        covariates={n: np.concatenate([run.covariates[n] for run in runs]) for n in shared},
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


@dataclass(frozen=True, slots=True)
class UnderCondition:
    """The analysis of what was measured under one condition, called ``v50-l100`` or the like."""

    name: str
    analysis: Analysis

    def called(self, pose: str | None) -> str:
        """Return the name of a pose among those of all conditions: ``P1-v50-l100``."""
        return f"{pose}-{self.name}" if pose else self.name

    def limit(self, check: LimitCheck) -> LimitCheck:
        """Return a comparison with its pose called so."""
        return replace(check, pose=self.called(check.pose))

    def characteristic(self, found: Characteristic) -> Characteristic:
        """Return a figure with its poses called so."""
        return replace(
            found,
            pose=self.called(found.pose),
            between=tuple(map(self.called, found.between)),
            limit=None if found.limit is None else self.limit(found.limit),
        )


def joined_analysis(parts: Sequence[UnderCondition], missing: Sequence[str] = ()) -> Analysis:
    """Return one analysis of several conditions, a pose called by its part: ``P1-v50-l100``.

    ``missing`` are the parts under conditions of which none is recorded. Raises `DataError` where
    they have not the same axes.
    """
    run = _run(parts)
    analyses = [one.analysis for one in parts]
    starts = np.cumsum([0, *(len(found.run) for found in analyses)]).tolist()
    return replace(
        analyses[0],
        run=run,
        cycles=min((found.cycles for found in analyses), key=lambda cycles: cycles.used),
        poses=Poses(
            replace(pose, label=one.called(pose.label), rows=pose.rows + start)
            for one, start in zip(parts, starts, strict=False)
            for pose in one.analysis.poses
        ),
        findings=tuple(_findings(parts, missing)),
        limits=tuple(one.limit(check) for one in parts for check in one.analysis.limits),
        characteristics=tuple(
            one.characteristic(found) for one in parts for found in one.analysis.characteristics
        ),
    )


def _run(parts: Sequence[UnderCondition]) -> Run:
    """Return the rows of all conditions below each other."""
    runs = {one.name: one.analysis.run for one in parts}
    first = parts[0].analysis.run.origin.source
    remedy = f"report each by itself: `condition={parts[0].name}`"
    refuse_other_axes(runs, "the conditions have not the same axes", first, remedy)
    labels, commands = [], {name: dict[str, float]() for name in parts[0].analysis.run.axes}
    for one in parts:
        run = one.analysis.run
        poses = [None] * len(run) if run.pose is None else run.pose.tolist()
        labels.append([one.called(pose) for pose in poses])
        for name, axis in run.axes.items():
            by_pose = axis.command if isinstance(axis.command, Mapping) else {}
            commands[name] |= {one.called(pose): value for pose, value in by_pose.items()}
    run = runs_below(list(runs.values()), labels, commands, dict(_stated(runs)))
    understood = "; ".join(one.origin.understood for one in runs.values())
    notes = tuple(dict.fromkeys(note for one in runs.values() for note in one.origin.notes))
    remarks = tuple(dict.fromkeys(one for run in runs.values() for one in run.origin.remarks))
    return replace(run, origin=Origin(first, understood, notes, remarks))


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


def _findings(parts: Sequence[UnderCondition], missing: Sequence[str]) -> Iterator[Finding]:
    """Yield what was found: once, where every condition says it of the whole of itself."""
    every = [one.analysis.findings for one in parts]
    shared = [found for found in every[0] if all(found in findings for findings in every)]
    shared = [found for found in shared if found.pose is None]
    yield from shared
    for one in parts:
        for found in one.analysis.findings:
            if found not in shared:
                yield replace(found, pose=one.called(found.pose))
    if missing:
        yield not_recorded(", ".join(missing))
