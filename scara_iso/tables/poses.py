"""What runs differ in; tables of one test, a pose or more each, to one run.

Nothing of two robots, dials or loads is mixed: the parts of a test state the same, or the merge is
refused with every fault of every part.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from scara_iso.base.errors import DataError, Fault
from scara_iso.run import Axis, Origin, Run, copies, joined_axis
from scara_iso.tables.vocabulary.names import pose_alone, pose_in
from scara_iso.tables.vocabulary.words import WORDS, listed, quoted


@dataclass(frozen=True, slots=True)
class Difference:
    """Something that is not the same in several runs; None for a run that has none of it."""

    of: Literal["axis", "unit", "resolution", "indicator_uncertainty", "statement"]
    name: str
    """Of the axis, or the key of the statement."""
    each: tuple[str | None, ...]
    """What each run has, in turn."""

    def in_words(self, names: Sequence[str]) -> str:
        """Return what runs of these names have: ``payload: '2 kg' in P1 and P2, '3 kg' in P3``."""
        by_text: dict[str | None, list[str]] = {}
        for text, name in zip(self.each, names, strict=True):
            by_text.setdefault(text, []).append(name)
        what = self.name if self.of in ("axis", "statement") else f"{self.of} of {self.name}"
        lacks = "not there" if self.of == "axis" else "not stated"
        return f"{what}: " + ", ".join(
            f"{(quoted(text) if self.of == 'statement' else text) if text else lacks} in "
            f"{_listed(who)}"
            for text, who in by_text.items()
        )


def differences(runs: Sequence[Run]) -> Iterator[Difference]:
    """Yield what is not the same in all runs: axes and their dials, then the statements."""
    for name in dict.fromkeys(name for run in runs for name in run.axes):
        axes = [run.axes.get(name) for run in runs]
        yield from _differ("axis", name, [None if axis is None else "measured" for axis in axes])
        units = [None if axis is None else axis.unit for axis in axes]
        one_unit = len({*units} - {None}) == 1
        if not one_unit:
            yield from _differ("unit", name, units)
        for key in ("resolution", "indicator_uncertainty") if one_unit else ():
            sizes = [None if axis is None else _size_text(axis, key) for axis in axes]
            if len({*sizes} - {None}) > 1:
                yield from _differ(key, name, sizes)
    for key in dict.fromkeys(key for run in runs for key in run.metadata):
        yield from _differ("statement", key, [run.metadata.get(key) for run in runs])


def _differ(of: Any, name: str, each: Sequence[str | None]) -> Iterator[Difference]:
    if len({*each}) > 1:
        yield Difference(of, name, tuple(each))


def _size_text(axis: Axis, key: str) -> str:
    of_certificate = axis.uncertainty if axis.displayed is None else axis.certified
    size = axis.resolution if key == "resolution" else of_certificate
    return "not stated" if size is None else f"{size:.6g} {axis.unit}"


def converted(runs: Mapping[str, Run]) -> Iterator[tuple[str, str]]:
    """Yield the name of each run in another unit, and what is said of it.

    All are in mm or degrees by now.
    """
    first, run = next(iter(runs.items()))
    for axis, unit in run.origin.units.items():
        for name, one in runs.items():
            other = one.origin.units.get(axis, unit)
            if other != unit:
                base = run.axes[axis].unit
                both = f"{axis} in {other}, and in {unit} in {first}"
                yield name, f"{name}: {both}; all is converted to {base}"


_OF_A_DIAL = ("indicator", "instrument", "gauge", "dial", "calibration")
_ROBOT = "robot serial model manufacturer type payload load velocity speed acceleration"
_OF_THE_ROBOT = (*_OF_A_DIAL, *_ROBOT.split())
"""How the keys begin that state what is tested, with what, and under which conditions."""
_OF_THE_FIGURES = frozenset({"theta_radius_mm", "dial_zero", "first_cycle", "covariates"})
"""Keys that figures depend on: a part that does not state one is not as the others."""
_TRUE_IS_STATED = "first_cycle_discarded"
_PORT = r"(?<= at )(?:[a-z0-9]+://|sim:|replay:|/dev/|com[0-9])[^ ;|]*"
_NAME_POSES = (
    "name each pose in a line '# pose: P1', a column 'pose', or the file's name, as P1.csv"
)
_OTHER_TESTS = (
    "tests of other days are for `scara-iso history`, a before and an after for `compare`"
)
_ALIKE = "let the tables of one test state the same, or give them one by one"
_MOST_NAMED = 6


class PosePart(NamedTuple):
    """A table of one test; ``name`` is what messages call it.

    ``pose`` is the one that is known for it; else its own statement counts, or ``title``, which may
    hold one. ``place`` says where pose or title are from, such as "the file's name".
    """

    run: Run
    name: str
    title: str = ""
    place: str = "the file's name"
    pose: str | None = None


def merge(parts: Sequence[PosePart], where: str, *, notes: Sequence[str] = ()) -> Run:
    """Return the run of all parts, each row with its pose; ``where`` names them together.

    Raises one `DataError` with what is wrong with any part: no pose or one that another part has,
    other axes, dials, robots, loads or velocities, other statements that figures depend on.
    """
    if len(parts) == 1 and parts[0].pose is None:
        return parts[0].run
    labelled = list(_with_all_axes([_labelled(part) for part in parts], where))
    if len(labelled) == 1 < len(parts):
        return labelled[0].run
    nameless = [part for part in labelled if not part.said]
    faults = (
        [Fault(f"{_listed([part.name for part in nameless])}: no pose stated")] if nameless else []
    )
    remedies = [_NAME_POSES] if nameless else []
    if len(nameless) == len(labelled):  # what else differs is of tests, not of poses
        raise _no_test(faults, where, [*remedies, _OTHER_TESTS])
    metadata, unlike, partly = _metadata(labelled)
    others = [fault for part in labelled for fault in part.faults]
    names, runs = [part.name for part in labelled], [part.run for part in labelled]
    same = (
        f"{a} holds the very readings of {b}: a copy?"
        for a, b in copies(zip(names, runs, strict=True))
    )
    dials = (one.in_words(names) for one in differences(runs) if one.of != "statement")
    others += [*_twice(labelled), *map(Fault, (*same, *dials, *unlike))]
    if faults or others:
        remedies += [_ALIKE] if others else []
        raise _no_test([*faults, *others], where, remedies)
    return _joined(labelled, metadata, where, [*partly, *notes])


def _with_all_axes(parts: Sequence[_Labelled], where: str) -> Iterator[_Labelled]:
    """Yield parts; those of the same rows that measure other axes are one, recorded separately."""
    alike: dict[tuple[str, ...], list[_Labelled]] = {}
    for part in parts:
        alike.setdefault(tuple(part.poses if part.said else ()), []).append(part)
    for group in alike.values():
        axes = [name for part in group for name in part.run.axes]
        if len(group) == 1 or len({*axes}) < len(axes):
            yield from group
            continue
        first, *others = (_visits(part.run) for part in group)
        if any(one != first for one in others):
            both = [(Counter(first), Counter(one)) for one in others]
            odd = [visit for a, b in both for visit in (a - b) | (b - a)]
            names = listed(part.name for part in group)
            what = [f"{names} measure other axes, and not at the same cycles", *odd[:1]]
            remedy = "give each axis the same cycles, or analyze each alone"
            raise _no_test([Fault(": ".join(what))], where, [remedy])
        yield _side_by_side(group, where)


def _visits(run: Run) -> list[str]:
    """Return what each row is of: its cycle, and its pose and direction of approach."""
    of = [run.cycle, *(labels for labels in (run.pose, run.direction) if labels is not None)]
    return [f"cycle {', '.join(map(str, row))}" for row in zip(*of, strict=True)]


def _side_by_side(parts: Sequence[_Labelled], where: str) -> _Labelled:
    """Return parts of other axes as one; a covariate that is not the same for all is of none."""
    metadata, unlike, notes = _metadata(parts, by_axis=True)
    if unlike:
        raise _no_test([*map(Fault, unlike)], where, [_ALIKE])
    first, *others = runs = [part.run for part in parts]
    covariates = {
        name: values
        for name, values in first.covariates.items()
        if all(np.array_equal(values, one.covariates.get(name, ())) for one in others)
    }
    left = dict.fromkeys(n for run in runs for n in run.covariates if n not in covariates)
    dropped = [f"column {name} is not the same in every table: not used" for name in left]
    understood = f"{len(runs)} tables of an axis or more each, paired by cycle"
    head = {"pose": first.metadata["pose"]} if "pose" in first.metadata else {}
    run = Run(
        cycle=first.cycle,
        axes={name: axis for run in runs for name, axis in run.axes.items()},
        pose=first.pose,
        direction=first.direction,
        covariates=covariates,
        metadata={**metadata, **head, "axes_recorded": "separately"},
        origin=Origin(
            source=where,
            understood=understood,
            notes=(*_said(parts), *notes, *dropped),
            remarks=_remarks(parts),
            units={axis: unit for run in runs for axis, unit in run.origin.units.items()},
        ),
    )
    return _Labelled(run, listed(part.name for part in parts), parts[0].said)


def _no_test(faults: Sequence[Fault], where: str, remedies: Sequence[str]) -> DataError:
    count = "1 fault" if len(faults) == 1 else f"{len(faults)} faults"
    what = f"cannot be taken as poses of one test: {count}"
    return DataError(what, where=where, remedy="; ".join(remedies), faults=faults)


class _Labelled(NamedTuple):
    """A part whose rows have poses, the line that says which, and what is wrong with that.

    No line says so where the part names no pose.
    """

    run: Run
    name: str
    said: str
    faults: tuple[Fault, ...] = ()

    @property
    def poses(self) -> list[str]:
        return [str(label) for label, _ in self.run.rows_by_pose()]

    @property
    def metadata(self) -> dict[str, str]:
        return {k: v for k, v in self.run.metadata.items() if k != "pose"}


def _labelled(part: PosePart) -> _Labelled:
    run, given = part.run, part.pose or pose_in(part.title)
    stated = [str(label) for label, _ in run.rows_by_pose() if label is not None]
    of_head = run.metadata.get("pose", "").strip()
    label = part.pose or of_head or given
    if stated:
        which = f"poses {', '.join(stated)}" if len(stated) > 1 else f"pose {stated[0]}"
        said = f"{which} from the column of {part.name}"
    elif label:
        run = replace(run, pose=np.full(len(run), label))
        source = f"'# pose:' of {part.name}" if label == of_head else f"{part.place} {part.title}"
        said = f"pose {label} from {source.strip()}"
        stated = [of_head] if of_head else []
    else:
        return _Labelled(run, part.name, "")
    if given is None or _is_of(part, given, stated):
        return _Labelled(run, part.name, said)
    what = f"{part.place} says pose {given}, the table itself {', '.join(stated)}"
    return _Labelled(run, part.name, said, (Fault(f"{part.name}: {what}"),))


def _is_of(part: PosePart, given: str, stated: Sequence[str]) -> bool:
    """Say whether a table's own poses are the given one; a title may mean something else by P1."""
    if part.pose is None and (len(stated) > 1 or not all(map(pose_alone, stated))):
        return True
    return all(own.casefold() == given.casefold() or pose_alone(own) == given for own in stated)


def _twice(parts: Sequence[_Labelled]) -> Iterator[Fault]:
    seen: dict[str, str] = {}
    for part in parts:
        for pose in part.poses if part.said and not part.faults else []:
            before = seen.setdefault(pose.casefold(), part.name)
            if before != part.name:
                yield Fault(f"pose {pose} is in {before} and again in {part.name}")


def _metadata(
    parts: Sequence[_Labelled], *, by_axis: bool = False
) -> tuple[dict[str, str], list[str], list[str]]:
    """Return the statements of all parts together, what of them is at odds, and what is noted.

    Parts ``by_axis`` may have a dial each, and be recorded as often. What a report asks for, and
    some parts alone state, is of their poses (or axes): ``payload[P3]``.
    """
    keys = dict.fromkeys(key for part in parts for key in part.metadata)
    found: dict[str, str] = {}
    faults: list[str] = []
    notes: list[str] = []
    names = [part.name for part in parts]
    for key in keys:
        stated = [(part, part.metadata[key]) for part in parts if key in part.metadata]
        alike = len({_spelling(key, text) for _, text in stated}) == 1
        everywhere = len(stated) == len(parts)
        own_dial = by_axis and key.startswith(_OF_A_DIAL)
        if not own_dial and _must_agree(key, [text for _, text in stated], everywhere=everywhere):
            if not alike or (not everywhere and not _of_the_robot(key)):
                each = tuple(part.metadata.get(key) for part in parts)
                faults.append(Difference("statement", key, each).in_words(names))
            elif not everywhere:
                notes.append(f"{key}: stated in {_listed([p.name for p, _ in stated])} only")
        each_of = [(part.run.axes if by_axis else part.poses, text) for part, text in stated]
        if not alike or key.startswith("record"):
            found[key] = "; ".join(f"{', '.join(of)}: {text}" for of, text in each_of)
        elif everywhere or not (key in WORDS["head"] or _of_the_robot(key)):
            found[key] = stated[0][1]
        else:  # not the whole test's
            found |= {f"{key}[{one}]": text for of, text in each_of for one in of}
    return found, faults, notes


def _must_agree(key: str, texts: Sequence[str], *, everywhere: bool) -> bool:
    if key == _TRUE_IS_STATED:  # false is as good as nothing
        truths = {_spelling(key, text) for text in texts}
        return len(truths) > 1 or (not everywhere and truths != {"false"})
    return key in _OF_THE_FIGURES or _of_the_robot(key)


def _of_the_robot(key: str) -> bool:
    return key.startswith(_OF_THE_ROBOT) and key not in _OF_THE_FIGURES


def _spelling(key: str, text: str) -> str:
    text = " ".join(text.casefold().split())
    if key == _TRUE_IS_STATED:
        return {"yes": "true", "1": "true", "no": "false", "0": "false"}.get(text, text)
    return re.sub(_PORT, "a port", text) if key == "indicator" else text


def _listed(names: Sequence[str]) -> str:
    left = len(names) - _MOST_NAMED
    return listed([*names[:_MOST_NAMED], f"{left} more"] if left > 0 else names)


def _joined(
    parts: Sequence[_Labelled], metadata: Mapping[str, str], where: str, notes: Sequence[str]
) -> Run:
    runs, poses = [part.run for part in parts], [pose for part in parts for pose in part.poses]
    shared = set.intersection(*({*run.covariates} for run in runs))
    left = dict.fromkeys(name for run in runs for name in run.covariates if name not in shared)
    dropped = [f"column {name} is not in every table: not used" for name in left]
    lines = [run.lines for run in runs if run.lines is not None]
    units = tuple(said for _, said in converted({part.name: part.run for part in parts}))
    return Run(
        cycle=np.concatenate([run.cycle for run in runs]),
        axes={name: _axis(name, parts) for name in runs[0].axes},
        pose=np.concatenate([run.pose for run in runs if run.pose is not None]),
        covariates={
            n: np.concatenate([run.covariates[n] for run in runs])
            for n in runs[0].covariates
            if n in shared
        },
        metadata=metadata,
        lines=np.concatenate(lines) if len(lines) == len(runs) else None,
        origin=Origin(
            source=where,
            understood=f"{len(parts)} tables of one test, poses {', '.join(poses)}",
            notes=(*_said(parts), *units, *notes, *dropped),
            remarks=_remarks(parts),
            units=runs[0].origin.units,
            other_units=units,
            files={pose: part.name for part in parts for pose in part.poses},
        ),
    )


def _said(parts: Sequence[_Labelled]) -> Iterator[str]:
    for part in parts:
        yield f"{part.said or part.name}: {part.run.origin.understood}".rstrip(": ")
        yield from (f"{part.name}: {note}" for note in part.run.origin.notes)


def _remarks(parts: Sequence[_Labelled]) -> tuple[str, ...]:
    return tuple(f"{part.name}: {one}" for part in parts for one in part.run.origin.remarks)


def _axis(name: str, parts: Sequence[_Labelled]) -> Axis:
    axes = [part.run.axes[name] for part in parts]
    command: dict[str, float] = {}
    for part, axis in zip(parts, axes, strict=True):
        if isinstance(axis.command, Mapping):
            command |= axis.command
        elif axis.command is not None and len(part.poses) == 1:
            command[part.poses[0]] = axis.command
    return joined_axis(axes, command)
