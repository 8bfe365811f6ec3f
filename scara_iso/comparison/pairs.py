"""From analyses to a `Comparison`: every run against the first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from scara_iso.comparison.decision import (
    Distance,
    PermutationTest,
    difference_interval,
    log_ratio,
    ratio_interval,
    smallest_ratio,
)
from scara_iso.comparison.dial import largest_bias, through_dial
from scara_iso.comparison.matching import axes_in_common, poses_in_common, unlike
from scara_iso.comparison.permutation import FigureColumns, mean_error, permute
from scara_iso.comparison.result import Comparison, Contrast, FigureName, Pair
from scara_iso.errors import DataError, UsageError
from scara_iso.iso9283 import Analysis, Finding, PoseResult
from scara_iso.published import Unit
from scara_iso.quantities import Dimension, same_turn
from scara_iso.run import Axis, FloatArray

SEED = 9283
SHUFFLES = 1999
_SHUFFLES_A_PAIR = 400
_FEWEST_CYCLES = 5
_DOUBTS = (
    "trend",
    "gross-reading",
    "stuck-channel",
    "no-scatter",
    "separate-axes",
    "resolution-not-stated",
    "same-readings",
)


@dataclass(frozen=True, eq=False, slots=True)
class _Column:
    """One axis at one pose in both runs; readings of shape (n,) and (m,)."""

    pose: str | None
    before: Axis
    after: Axis
    readings: tuple[FloatArray, FloatArray]


def compare(
    analyses: Sequence[Analysis], *, seed: int = SEED, shuffles: int = SHUFFLES
) -> Comparison:
    """Return every run against the first: means, RP and +/- 3 s of angles, with intervals.

    The method is that of docs/compare.md. Raises `UsageError` for fewer than two runs and
    `DataError` where a run has no axis or pose in common with the first, or fewer than five cycles.
    """
    if len(analyses) < 2:
        raise UsageError("a comparison needs two runs", remedy="name two tables or more")
    for analysis in analyses:
        if analysis.cycles.used < _FEWEST_CYCLES:
            what = f"{analysis.cycles.used} cycles count: {_FEWEST_CYCLES} are the fewest"
            raise DataError(
                what, where=analysis.run.origin.source, remedy="repeat the test with more cycles"
            )
    first, *others = analyses
    shuffles = max(shuffles, _SHUFFLES_A_PAIR * len(others) - 1)
    pairs = tuple(
        _pair(first, other, np.random.default_rng([seed, k]), shuffles, len(others))
        for k, other in enumerate(others)
    )
    return Comparison(pairs, shuffles, seed)


def _pair(
    before: Analysis, after: Analysis, rng: np.random.Generator, shuffles: int, pairs: int
) -> Pair:
    columns = list(_columns(before, after))
    figures = _figures(columns)
    permuted = permute(
        np.stack([column.readings[0] for column in columns]),
        np.stack([column.readings[1] for column in columns]),
        [figure for _, figure in figures],
        rng,
        shuffles=shuffles,
    )
    means, spreads = (
        PermutationTest(permuted.means, pairs),
        PermutationTest(permuted.spreads, pairs),
    )
    findings = (
        *unlike(before, after),
        *_doubtful(before, "before"),
        *_doubtful(after, "after"),
    )
    return Pair(
        before,
        after,
        means=tuple(_mean(column, means, k, findings) for k, column in enumerate(columns)),
        spreads=tuple(
            _spread(name, [columns[c] for c in figure.columns], spreads, k, findings)
            for k, (name, figure) in enumerate(figures)
        ),
        findings=findings,
    )


def _columns(before: Analysis, after: Analysis) -> Iterator[_Column]:
    names = axes_in_common(before, after)
    for mine, other in poses_in_common(before, after):
        for name in names:
            axis, x, y = before.run.axes[name], mine.axes[name].readings, other.axes[name].readings
            y = same_turn(y, x) if axis.dimension is Dimension.ANGLE else y
            yield _Column(_label(mine, other), axis, after.run.axes[name], (x, y))


def _label(mine: PoseResult, other: PoseResult) -> str | None:
    return mine.label if mine.label is not None else other.label


def _figures(columns: Sequence[_Column]) -> list[tuple[str, FigureColumns]]:
    """Return the axes of each pose, then XY and XYZ where they are lengths, by name."""
    found = []
    for pose in dict.fromkeys(column.pose for column in columns):
        axes = {c.before.name: k for k, c in enumerate(columns) if c.pose == pose}
        lengths = {n for n, k in axes.items() if columns[k].before.dimension is Dimension.LENGTH}
        found += [
            (name, FigureColumns((k,), angle=name not in lengths)) for name, k in axes.items()
        ]
        found += [
            (name, FigureColumns(tuple(axes[axis] for axis in name)))
            for name in ("XY", "XYZ")
            if set(name) <= lengths
        ]
    return found


def _doubtful(analysis: Analysis, when: str) -> Iterator[Finding]:
    for f in analysis.findings:
        if f.code in _DOUBTS:
            yield Finding(
                f.code, f.severity, f"{when}: {f.message}", f.axis, f.pose, advice=f.advice
            )


def _mean(
    column: _Column, chance: PermutationTest, k: int, findings: Sequence[Finding]
) -> Contrast:
    x, y = column.readings
    before = float(x.mean())
    observed = float((y - x[0]).mean() - (x - x[0]).mean())
    after = before + observed
    bias = largest_bias(x, column.before.resolution) + largest_bias(y, column.after.resolution)
    distance = Distance(observed, observed - bias, observed + bias, float(mean_error(x, y)))
    found = chance.decide(distance, k, cycles=(len(x), len(y)))
    reach = found.critical * distance.error
    return Contrast(
        pose=column.pose,
        figure=cast(FigureName, column.before.name),
        quantity="mean",
        unit=cast(Unit, column.before.unit),
        before=before,
        after=after,
        difference=after - before,
        difference_interval=(distance.lower - reach, distance.upper + reach),
        ratio=None,
        ratio_interval=None,
        p_value=found.p_value,
        p_value_at_floor=found.p_value_at_floor,
        p_value_alone=found.p_value_alone,
        verdict=found.verdict,
        cycles_needed=found.cycles_needed,
        smallest_shown=bias + distance.error * found.shown_errors,
        doubts=_doubts(findings, column.before.name, column.pose),
    )


def _spread(
    name: str, used: Sequence[_Column], chance: PermutationTest, k: int, findings: Sequence[Finding]
) -> Contrast:
    angle = used[0].before.dimension is Dimension.ANGLE
    positions = [np.stack([column.readings[run] for column in used]) for run in (0, 1)]
    old = through_dial(positions[0], [column.before.resolution for column in used], angle=angle)
    new = through_dial(positions[1], [column.after.resolution for column in used], angle=angle)
    distance = log_ratio(old, new)
    found = chance.decide(distance, k, cycles=(positions[0].shape[1], positions[1].shape[1]))
    return Contrast(
        pose=used[0].pose,
        figure=cast(FigureName, name),
        quantity="three_sigma" if angle else "RP",
        unit=cast(Unit, used[0].before.unit),
        before=old.read,
        after=new.read,
        difference=new.read - old.read,
        difference_interval=difference_interval(old, new, found),
        ratio=None if old.read == 0 else new.read / old.read,
        ratio_interval=ratio_interval(distance, found.critical),
        p_value=found.p_value,
        p_value_at_floor=found.p_value_at_floor,
        p_value_alone=found.p_value_alone,
        verdict=found.verdict,
        cycles_needed=found.cycles_needed,
        smallest_shown=smallest_ratio(distance, found.shown_errors),
        doubts=_doubts(findings, name, used[0].pose),
    )


def _doubts(findings: Sequence[Finding], figure: str, pose: str | None) -> tuple[str, ...]:
    """Return the codes that concern a figure, or an axis of it."""
    axes = {figure, *(figure if figure in ("XY", "XYZ") else ())}
    of_it = (f.code for f in findings if f.axis in axes and f.pose in (None, pose))
    return tuple(dict.fromkeys(code for code in of_it if code in _DOUBTS))
