"""From analyses to a `Comparison`: every run against the first; several robots as one test.

And what two runs have in common, and what of their conditions is not the same.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.published import publish
from scara_iso.base.quantities import Dimension, same_turn
from scara_iso.comparison.chance import (
    FigureColumns,
    largest_bias,
    mean_error,
    permute,
    through_dial,
)
from scara_iso.comparison.decision import (
    Comparison,
    ComparisonTest,
    Distance,
    MeanContrast,
    Pair,
    PermutationTest,
    SpreadContrast,
    difference_interval,
    log_ratio,
    ratio_interval,
    smallest_ratio,
)
from scara_iso.iso9283 import (
    Analysis,
    Characteristic,
    Finding,
    Limit,
    Measured,
    PoseResult,
    check_limits,
    cycles_of_all_poses,
    find_characteristics,
    moment_of_test,
)
from scara_iso.run import AXES, Axis, FloatArray
from scara_iso.tables import Difference, differences

_OF_THE_TABLE = {
    "unit",
    "resolution",
    "first_cycle_discarded",
    "date",
    "time",
    "source",
    "started",
    "finished",
}
CONDITIONS = (
    *("robot", "serial", "payload", "load", "velocity", "speed", "acceleration", "pose"),
    *("indicator", "instrument", "dial", "tool"),
)
"""How the statements begin that change what a figure means."""
_MOST = 12

PAGES = {
    "other-axes": """Only one of the tables has this axis.

    It is not compared. Where the axis was measured both times, name its column alike.""",
    "other-pose": """The poses are not the same in both tables.

    RP depends on the pose: a difference between two poses says nothing about a repair. Poses that
    only one table has are not compared; where each table has one pose, they are compared, and
    both labels are named.""",
    "other-resolution": """The dial's resolution is not the same in both runs.

    A coarser dial moves RP by itself. Only where both resolutions are stated, what rounding can do
    to each is subtracted.""",
    "other-conditions": """A condition of the test is not the same in both runs.

    What differs in payload, velocity, temperature or setting may cause a difference that seems
    due to a repair. Run both tests under the same conditions, or say what else changed.""",
    "other-cycles": """The runs have other numbers of counted cycles.

    The smaller run limits what is shown. ``cycles=`` applies to the run that has so many. Of
    several poses, those of all are compared.""",
    "same-readings": """Every reading of an axis is the same in both runs.

    One is most likely a copy: compare the right tables.""",
}
"""The page of each finding of a comparison, by its code."""


def poses_in_common(before: Analysis, after: Analysis) -> list[tuple[PoseResult, PoseResult]]:
    """Return each pose of both; two runs of one pose each are compared whatever its label."""
    if len(before.poses) == len(after.poses) == 1:
        return [(before.poses[0], after.poses[0])]
    others = {pose.label: pose for pose in after.poses}
    found = [(pose, others[pose.label]) for pose in before.poses if pose.label in others]
    if not found:
        raise _nothing(before, after, "pose", remedy="name the poses alike in both tables")
    return found


def _whole_cycles(
    poses: Sequence[tuple[PoseResult, PoseResult]], run: int
) -> tuple[list[npt.NDArray[np.intp]], str]:
    return cycles_of_all_poses([pair[run].cycle for pair in poses], _FEWEST_CYCLES)


def axes_in_common(before: Analysis, after: Analysis) -> list[str]:
    """Return the axes of both that are lengths in both, or angles in both."""
    mine, others = before.run.axes, after.run.axes
    found = [n for n in mine if n in others and mine[n].dimension is others[n].dimension]
    if not found:
        raise _nothing(before, after, "axis", remedy=f"name the axes alike: {', '.join(AXES)}")
    return found


def unlike(before: Analysis, after: Analysis) -> Iterator[Finding]:
    """Yield what keeps two runs from being compared, in whole or in part."""
    found = list(differences([before.run, after.run]))
    yield from (finding for one in found for finding in _other_axis(one))
    yield from _other_poses(before, after)
    yield from (finding for one in found for finding in _other_dial(one))
    yield from _other_conditions(found, before, after)
    if before.cycles.used != after.cycles.used:
        counts = f"{before.cycles.used} cycles count before, {after.cycles.used} after"
        yield Finding("other-cycles", "info", counts)
    for run, when in enumerate(("before", "after")):
        _, left_out = _whole_cycles(poses_in_common(before, after), run)
        if left_out:
            yield Finding("other-cycles", "info", f"{when}: {left_out}")
    same = [n for n in axes_in_common(before, after) if _same_readings(before, after, n)]
    if same:
        said = "every reading is the same in both runs: is one a copy of the other?"
        yield Finding("same-readings", "warning", said, ", ".join(same))


def _same_readings(before: Analysis, after: Analysis, axis: str) -> bool:
    pairs = poses_in_common(before, after)
    readings = [(a.axes[axis].readings, b.axes[axis].readings) for a, b in pairs]
    return all(len(set(a.tolist())) > 1 and np.array_equal(a, b) for a, b in readings)


def _other_axis(found: Difference) -> Iterator[Finding]:
    before, after = found.each
    if found.of == "axis":
        words = f"only the {'first' if before else 'second'} table has it: not compared"
        yield Finding("other-axes", "warning", words, found.name)
    elif found.of == "unit":
        words = f"in {before} before and in {after} after: not compared"
        yield Finding("other-unit", "warning", words, found.name)


def _other_poses(before: Analysis, after: Analysis) -> Iterator[Finding]:
    common = poses_in_common(before, after)
    mine, other = (pose.label for pose in common[0])
    if mine != other:  # of one pose each
        if mine is not None and other is not None:
            said = f"pose {mine} before, {other} after: RP depends on the pose"
            yield Finding("other-pose", "warning", said)
        return
    used = {pose.label for pose, _ in common}
    for which, run in (("first", before), ("second", after)):
        left = [str(pose.label) for pose in run.poses if pose.label not in used]
        if left:
            said = f"only the {which} table has {', '.join(left[:_MOST])}: not compared"
            yield Finding("other-pose", "warning", said)


def _other_dial(found: Difference) -> Iterator[Finding]:
    before, after = found.each
    if found.of == "resolution":
        words = f"the dial's resolution is {before} before, {after} after"
        part = "; what rounding can do to each is subtracted from the difference"
        known = "not stated" not in found.each
        yield Finding("other-resolution", "warning", words + part * known, found.name)


def _other_conditions(
    differ: Sequence[Difference], before: Analysis, after: Analysis
) -> Iterator[Finding]:
    found = [finding for one in differ for finding in _other_statement(one)]
    found += _other_covariates(before, after)
    found += _other_order(before, after)
    found.sort(key=lambda finding: finding.severity != "warning")
    yield from found[:_MOST]
    if len(found) > _MOST:
        said = f"{len(found) - _MOST} more conditions differ"
        yield Finding("other-conditions", "info", said)


def _other_statement(found: Difference) -> Iterator[Finding]:
    key, (before, after) = found.name, found.each
    if found.of != "statement" or key.lower().startswith(tuple(_OF_THE_TABLE)):
        return
    grave = key.lower().startswith(CONDITIONS)
    if before is not None and after is not None:
        said = f"{key} is {before} before, {after} after"
        brief = f"{key.replace('_', ' ')} {before}, then {after}"
        yield Finding("other-conditions", "warning" if grave else "info", said, in_short=brief)
    elif grave:
        said = f"only the {'second' if before is None else 'first'} table states {key}"
        yield Finding("other-conditions", "info", said)


def _other_order(before: Analysis, after: Analysis) -> Iterator[Finding]:
    """Yield that the run which is called the first is the later one, by the dates of both."""
    first, second = moment_of_test(before.run), moment_of_test(after.run)
    if first is not None and second is not None and first > second:
        what = (
            f"the first table is of {first:%Y-%m-%d}, the second of {second:%Y-%m-%d}: exchanged?"
        )
        yield Finding("other-conditions", "warning", what, in_short="the second is the earlier")


def _other_covariates(before: Analysis, after: Analysis) -> Iterator[Finding]:
    mine, others = before.run.covariates, after.run.covariates
    for name in mine:
        if name not in others or name == "time_s":
            continue
        a, b = mine[name], others[name]
        if a.max() < b.min() or b.max() < a.min():
            said = f"{name} is {_range(a.min(), a.max())} before, {_range(b.min(), b.max())} after"
            yield Finding("other-conditions", "warning", said)


def _range(low: float, high: float) -> str:
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def _nothing(before: Analysis, after: Analysis, what: str, *, remedy: str) -> DataError:
    source = after.run.origin.source
    return DataError(
        f"no {what} in common with {before.run.origin.source}", where=source, remedy=remedy
    )


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
    "remarked-rows",
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
            what = f"{analysis.cycles.used} cycles count, and {_FEWEST_CYCLES} are needed"
            raise DataError(
                what, where=analysis.run.origin.source, remedy="repeat the test with more cycles"
            )
    first, *others = analyses
    shuffles = max(shuffles, _SHUFFLES_A_PAIR * len(others) - 1)
    pairs = tuple(
        _pair(first, other, np.random.default_rng([seed, k]), shuffles, len(others))
        for k, other in enumerate(others)
    )
    return Comparison(pairs=pairs, test=ComparisonTest(shuffles=shuffles, seed=seed))


def _pair(
    before: Analysis, after: Analysis, rng: np.random.Generator, shuffles: int, pairs: int
) -> Pair:
    columns = list(_columns(before, after))
    figures = list(_figures(columns))
    x, y = (np.stack([column.readings[run] for column in columns]) for run in (0, 1))
    chance = PermutationTest(permute(x, y, figures, rng, shuffles=shuffles), pairs)
    findings = (
        *unlike(before, after),
        *_doubtful(before, "before"),
        *_doubtful(after, "after"),
    )
    return Pair(
        before,
        after,
        means=tuple(_mean(column, chance, k, findings) for k, column in enumerate(columns)),
        spreads=tuple(
            _spread(figure.name, [columns[c] for c in figure.columns], chance, k, findings)
            for k, figure in enumerate(figures, len(columns))
        ),
        findings=findings,
    )


def _columns(before: Analysis, after: Analysis) -> Iterator[_Column]:
    poses, names = poses_in_common(before, after), axes_in_common(before, after)
    rows = (_whole_cycles(poses, run)[0] for run in (0, 1))
    for (mine, other), a, b in zip(poses, *rows, strict=True):
        label = mine.label if mine.label is not None else other.label
        for name in names:
            axis = before.run.axes[name]
            x, y = mine.axes[name].readings[a], other.axes[name].readings[b]
            y = same_turn(y, x) if axis.dimension is Dimension.ANGLE else y
            yield _Column(label, axis, after.run.axes[name], (x, y))


def _figures(columns: Sequence[_Column]) -> Iterator[FigureColumns]:
    for pose in dict.fromkeys(column.pose for column in columns):
        axes = {c.before.name: k for k, c in enumerate(columns) if c.pose == pose}
        lengths = {n for n, k in axes.items() if columns[k].before.dimension is Dimension.LENGTH}
        for name, k in axes.items():
            yield FigureColumns(name, (k,), angle=name not in lengths)
        for name in ("XY", "XYZ"):
            if set(name) <= lengths:
                yield FigureColumns(name, tuple(axes[axis] for axis in name))


def _doubtful(analysis: Analysis, when: str) -> Iterator[Finding]:
    for f in analysis.findings:
        if f.code in _DOUBTS:
            yield replace(f, message=f"{when}: {f.message}", rule="", voids_interval=False)


def _mean(
    column: _Column, chance: PermutationTest, k: int, findings: Sequence[Finding]
) -> MeanContrast:
    x, y = column.readings
    before = float(x.mean())
    observed = float((y - x[0]).mean() - (x - x[0]).mean())
    after = before + observed
    bias = largest_bias(x, column.before.resolution) + largest_bias(y, column.after.resolution)
    distance = Distance(observed, observed - bias, observed + bias, float(mean_error(x, y)))
    found = chance.decide(distance, k, cycles=(len(x), len(y)))
    reach = found.critical * distance.error
    return publish(
        MeanContrast,
        found,
        pose=column.pose,
        figure=column.before.name,
        unit=column.before.unit,
        before=before,
        after=after,
        difference=after - before,
        difference_interval=(distance.lower - reach, distance.upper + reach),
        smallest_shown=bias + distance.error * found.shown_errors,
        doubts=_doubts(findings, column.before.name, column.pose),
    )


def _spread(
    name: str, used: Sequence[_Column], chance: PermutationTest, k: int, findings: Sequence[Finding]
) -> SpreadContrast:
    angle = used[0].before.dimension is Dimension.ANGLE
    positions = [np.stack([column.readings[run] for column in used]) for run in (0, 1)]
    old = through_dial(positions[0], [column.before.resolution for column in used], angle=angle)
    new = through_dial(positions[1], [column.after.resolution for column in used], angle=angle)
    distance = log_ratio(old, new)
    found = chance.decide(distance, k, cycles=(positions[0].shape[1], positions[1].shape[1]))
    return publish(
        SpreadContrast,
        found,
        pose=used[0].pose,
        figure=name,
        quantity="three_sigma" if angle else "RP",
        unit=used[0].before.unit,
        before=old.read,
        after=new.read,
        difference=new.read - old.read,
        difference_interval=difference_interval(old, new, found),
        ratio=None if old.read == 0 else new.read / old.read,
        ratio_interval=ratio_interval(distance, found.critical),
        smallest_shown=smallest_ratio(distance, found.shown_errors),
        doubts=_doubts(findings, name, used[0].pose),
    )


def _doubts(findings: Sequence[Finding], figure: str, pose: str | None) -> tuple[str, ...]:
    axes = {figure, *(figure if figure in ("XY", "XYZ") else ())}
    of_it = (f.code for f in findings if f.axis in axes and f.pose in (None, pose))
    return tuple(dict.fromkeys(code for code in of_it if code in _DOUBTS))


_CODE = "exchangeability"


def exchangeability(
    analyses: Sequence[Analysis], limits: Mapping[str, Limit]
) -> tuple[Characteristic, ...]:
    """Return the exchangeability of the robots of several tests, held against ``limits``.

    Raises `DataError` where the dials' zeros are not said to be one, two tables state the same
    serial number, or no pose and axis is in common, and `UsageError` for a limit of another figure.
    """
    _check(analyses)
    first, *others = (publish(Measured, one) for one in analyses)
    test = replace(first, robots=tuple(others))
    own = (one for one in find_characteristics() if one.CODE == _CODE)
    found = [each for one in own for each in one.compute(test)]
    if not found:
        raise DataError(
            "exchangeability needs a pose with the same axes in all tables",
            remedy="name poses and axes alike",
        )
    units = {axis: unit for one in analyses for axis, unit in one.run.stated_units.items()}
    return check_limits(found, limits, units=units)


def _check(analyses: Sequence[Analysis]) -> None:
    metadata = [analysis.run.metadata for analysis in analyses]
    zeros = {stated.get("dial_zero", "").strip().lower() for stated in metadata}
    if len(zeros) > 1 or "" in zeros:
        raise DataError(
            "exchangeability needs dials that share one zero: the tables do not state it",
            remedy="write the same '# dial_zero: command' (or fixture) into each, if it is so",
        )
    serials = [s["serial_number"] for s in metadata if "serial_number" in s]
    if len(set(serials)) < len(serials):
        raise DataError(
            "two tables state the same serial_number: exchangeability is that of several robots",
            remedy="compare runs of one robot without `exchangeability=`",
        )
