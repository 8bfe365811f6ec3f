"""The analysis of a whole test: the poses under every condition, each called by its part."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scara_iso.base.errors import DataError
from scara_iso.iso9283 import Analysis, Characteristic, Finding, LimitCheck, Poses, not_recorded
from scara_iso.run import Axis, Origin, Run, joined_axis

_Labels = Mapping[str | None, str]
"""Of each pose of a condition: its label among those of all conditions."""


@dataclass(frozen=True, slots=True)
class UnderCondition:
    """The analysis of what was measured under one condition, called ``v50-l100`` or the like."""

    name: str
    analysis: Analysis


def joined_analysis(
    parts: Sequence[UnderCondition], missing: Sequence[str] = ()
) -> tuple[Analysis, list[_Labels]]:
    """Return one analysis of several conditions, and what it calls the poses of each of them.

    A pose is called by its part, ``P1-v50-l100``; ``missing`` are the parts under conditions of
    which none is recorded. Raises `DataError` where they have not the same axes.
    """
    _refuse_other_axes(parts)
    run = _run(parts)
    labels = list(_labels(parts, run))
    return _analysis(list(zip(parts, labels, strict=True)), run, missing), labels


def _refuse_other_axes(parts: Sequence[UnderCondition]) -> None:
    found = {
        one.name: ", ".join(f"{a.name} in {a.unit}" for a in one.analysis.run.axes.values())
        for one in parts
    }
    if len(set(found.values())) > 1:
        said = "; ".join(f"{name}: {axes}" for name, axes in found.items())
        raise DataError(
            f"the conditions have not the same axes: {said}",
            where=parts[0].analysis.run.origin.source,
            remedy=f"report each by itself: `condition={parts[0].name}`",
        )


def _labels(parts: Sequence[UnderCondition], run: Run) -> Iterator[_Labels]:
    """Yield for each condition what its poses are called in the run of all."""
    called = iter([str(label) for label, _ in run.rows_by_pose()])
    for one in parts:
        yield {label: next(called) for label, _ in one.analysis.run.rows_by_pose()}


def _run(parts: Sequence[UnderCondition]) -> Run:
    """Return the rows of all conditions below each other; columns that one lacks are left out."""
    runs = [one.analysis.run for one in parts]
    shared = [n for n in runs[0].covariates if all(n in run.covariates for run in runs)]
    directions = [run.direction for run in runs if run.direction is not None]
    poses = [
        np.array([_called(p, one.name) for p in _poses(run)])
        for one, run in zip(parts, runs, strict=True)
    ]
    return Run(
        cycle=np.concatenate([run.cycle for run in runs]),
        axes={name: _axis(name, parts) for name in runs[0].axes},
        pose=np.concatenate(poses),
        covariates={n: np.concatenate([run.covariates[n] for run in runs]) for n in shared},
        metadata=dict(_stated(parts)),
        origin=Origin(
            runs[0].origin.source,
            "; ".join(run.origin.understood for run in runs),
            tuple(dict.fromkeys(note for run in runs for note in run.origin.notes)),
        ),
        direction=np.concatenate(directions) if len(directions) == len(runs) else None,
    )


def _called(pose: str | None, condition: str) -> str:
    return f"{pose}-{condition}" if pose else condition


def _poses(run: Run) -> Sequence[str | None]:
    return [None] * len(run) if run.pose is None else run.pose.tolist()


def _axis(name: str, parts: Sequence[UnderCondition]) -> Axis:
    axes = [one.analysis.run.axes[name] for one in parts]
    command: dict[str, float] = {}
    for one, axis in zip(parts, axes, strict=True):
        command |= _commands(axis, one)
    return joined_axis(axes, command)


def _commands(axis: Axis, part: UnderCondition) -> Mapping[str, float]:
    by_pose = axis.command if isinstance(axis.command, Mapping) else {}
    return {_called(pose, part.name): value for pose, value in by_pose.items()}


def _stated(parts: Sequence[UnderCondition]) -> Iterator[tuple[str, str]]:
    """Yield what the conditions state: once where all say the same, else each by its name."""
    stated = {one.name: one.analysis.run.metadata for one in parts}
    for key in dict.fromkeys(key for found in stated.values() for key in found):
        by_text: dict[str, list[str]] = {}
        for name, found in stated.items():
            if key in found:
                by_text.setdefault(found[key], []).append(name)
        everywhere = sum(map(len, by_text.values())) == len(stated)
        if len(by_text) == 1 and everywhere:
            yield key, next(iter(by_text))
        else:
            yield key, "; ".join(f"{', '.join(at)}: {text}" for text, at in by_text.items())


def _analysis(
    pairs: Sequence[tuple[UnderCondition, _Labels]], run: Run, missing: Sequence[str]
) -> Analysis:
    analyses = [one.analysis for one, _ in pairs]
    starts = np.cumsum([0, *(len(found.run) for found in analyses)])
    poses = Poses(
        replace(pose, label=names[pose.label], rows=pose.rows + start)
        for (one, names), start in zip(pairs, starts[:-1].tolist(), strict=True)
        for pose in one.analysis.poses
    )
    return replace(
        analyses[0],
        run=run,
        cycles=min((found.cycles for found in analyses), key=lambda cycles: cycles.used),
        poses=poses,
        findings=tuple(_findings(pairs, missing)),
        limits=tuple(
            _limit(check, names, one) for one, names in pairs for check in one.analysis.limits
        ),
        characteristics=tuple(
            _characteristic(found, names, one)
            for one, names in pairs
            for found in one.analysis.characteristics
        ),
    )


def _findings(
    pairs: Sequence[tuple[UnderCondition, _Labels]], missing: Sequence[str]
) -> Iterator[Finding]:
    """Yield what was found: once, where every condition says it of the whole of itself."""
    every = [one.analysis.findings for one, _ in pairs]
    shared = [found for found in every[0] if all(found in findings for findings in every)]
    shared = [found for found in shared if found.pose is None]
    yield from shared
    for one, names in pairs:
        for found in one.analysis.findings:
            if found not in shared:
                yield replace(found, pose=names.get(found.pose, _called(found.pose, one.name)))
    if missing:
        yield not_recorded(", ".join(missing))


def _limit(check: LimitCheck, names: _Labels, part: UnderCondition) -> LimitCheck:
    return replace(check, pose=names.get(check.pose, _called(check.pose, part.name)))


def _characteristic(found: Characteristic, names: _Labels, part: UnderCondition) -> Characteristic:
    return replace(
        found,
        pose=names.get(found.pose, _called(found.pose, part.name)),
        between=tuple(names.get(pose, _called(pose, part.name)) for pose in found.between),
        limit=None if found.limit is None else _limit(found.limit, names, part),
    )
