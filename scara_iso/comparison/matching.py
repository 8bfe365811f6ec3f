"""What two runs have in common, and what of their conditions is not the same."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scara_iso.errors import DataError
from scara_iso.iso9283 import Analysis, Finding, PoseResult
from scara_iso.run import AXES

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
_CONDITIONS = ("robot", "serial", "payload", "load", "velocity", "speed", "acceleration", "pose")
_MOST = 12

PAGES = {
    "other-axes": """Only one of the tables has this axis.

    It is not compared. Where the axis was measured both times, name its column alike.""",
    "other-unit": """The axis is a length in one table and an angle in the other.

    It is not compared. Measure it in the same way both times.""",
    "other-pose": """The poses are not the same in both tables.

    RP depends on the pose: a difference between two poses says nothing about a repair. Poses that
    only one table has are not compared; where each table has one pose, they are compared as they
    are and both labels are said.""",
    "other-resolution": """The dial's resolution is not the same in both runs.

    A coarser dial moves RP by itself. Where both resolutions are stated, what rounding can do
    to each is subtracted from the difference; where one is not, this cannot be done.""",
    "other-conditions": """A condition of the test is not the same in both runs.

    What differs in payload, velocity, temperature or setting may cause a difference that seems
    due to a repair. Run both tests under the same conditions, or say what else changed.""",
    "other-cycles": """The runs do not have the same number of cycles that count.

    They are compared all the same; the smaller run limits what can be shown.""",
    "same-readings": """Every reading of an axis is the same in both runs.

    Two runs do not agree to the last digit by chance: one table is most likely a copy of the
    other.""",
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


def axes_in_common(before: Analysis, after: Analysis) -> list[str]:
    """Return the axes of both that are lengths in both, or angles in both."""
    mine, others = before.run.axes, after.run.axes
    found = [n for n in mine if n in others and mine[n].dimension is others[n].dimension]
    if not found:
        raise _nothing(before, after, "axis", remedy=f"name the axes alike: {', '.join(AXES)}")
    return found


def unlike(before: Analysis, after: Analysis) -> Iterator[Finding]:
    """Yield what keeps two runs from being compared, in whole or in part."""
    yield from _other_axes(before, after)
    yield from _other_poses(before, after)
    yield from _other_dials(before, after)
    yield from _other_conditions(before, after)
    if before.cycles.used != after.cycles.used:
        counts = f"{before.cycles.used} cycles count before, {after.cycles.used} after"
        yield Finding("other-cycles", "info", counts)
    same = [n for n in axes_in_common(before, after) if _same_readings(before, after, n)]
    if same:
        said = "every reading is the same in both runs: is one a copy of the other?"
        yield Finding("same-readings", "warning", said, ", ".join(same))


def _same_readings(before: Analysis, after: Analysis, axis: str) -> bool:
    pairs = poses_in_common(before, after)
    readings = [(a.axes[axis].readings, b.axes[axis].readings) for a, b in pairs]
    return all(len(set(a.tolist())) > 1 and np.array_equal(a, b) for a, b in readings)


def _other_axes(before: Analysis, after: Analysis) -> Iterator[Finding]:
    mine, others = before.run.axes, after.run.axes
    for name in AXES:
        if (name in mine) != (name in others):
            which = "first" if name in mine else "second"
            said = f"only the {which} table has it: not compared"
            yield Finding("other-axes", "warning", said, name)
        elif name in mine and mine[name].dimension is not others[name].dimension:
            units = f"in {mine[name].unit} before and in {others[name].unit} after: not compared"
            yield Finding("other-unit", "warning", units, name)


def _other_poses(before: Analysis, after: Analysis) -> Iterator[Finding]:
    common = poses_in_common(before, after)
    if len(before.poses) == len(after.poses) == 1:
        labels = [pose.label for pose in common[0]]
        if None not in labels and labels[0] != labels[1]:
            said = f"pose {labels[0]} before, {labels[1]} after: RP depends on the pose"
            yield Finding("other-pose", "warning", said)
        return
    used = {pose.label for pose, _ in common}
    for which, run in (("first", before), ("second", after)):
        left = [str(pose.label) for pose in run.poses if pose.label not in used]
        if left:
            said = f"only the {which} table has {', '.join(left[:_MOST])}: not compared"
            yield Finding("other-pose", "warning", said)


def _other_dials(before: Analysis, after: Analysis) -> Iterator[Finding]:
    for name in axes_in_common(before, after):
        a, b = before.run.axes[name], after.run.axes[name]
        if a.resolution != b.resolution:
            sizes = [f"{x.resolution:g} {x.unit}" if x.resolution else "not stated" for x in (a, b)]
            said = f"the dial's resolution is {sizes[0]} before, {sizes[1]} after"
            part = "; what rounding can do to each is subtracted from the difference"
            known = a.resolution and b.resolution
            yield Finding("other-resolution", "warning", said + (part if known else ""), name)


def _other_conditions(before: Analysis, after: Analysis) -> Iterator[Finding]:
    found = [*_other_metadata(before, after), *_other_covariates(before, after)]
    found.sort(key=lambda finding: finding.severity != "warning")
    yield from found[:_MOST]
    if len(found) > _MOST:
        said = f"{len(found) - _MOST} more conditions differ"
        yield Finding("other-conditions", "info", said)


def _other_metadata(before: Analysis, after: Analysis) -> Iterator[Finding]:
    mine, others = before.run.metadata, after.run.metadata
    for key in [*mine, *(key for key in others if key not in mine)]:
        if key.lower().startswith(tuple(_OF_THE_TABLE)) or mine.get(key) == others.get(key):
            continue
        grave = key.lower().startswith(_CONDITIONS)
        if key in mine and key in others:
            said = f"{key} is {mine[key]} before, {others[key]} after"
        elif grave:
            said = f"only the {'first' if key in mine else 'second'} table states {key}"
        else:
            continue
        severe = grave and key in mine and key in others
        yield Finding("other-conditions", "warning" if severe else "info", said)


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
