"""Which cycles count, as the procedure of ISO 9283 has it.

The paper runs 31 cycles and drops the first, so that the side of the gap on which the first
arrival happens to rest does not count. The standard (clause 6.9) knows 30 cycles, which all count.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypedDict

import numpy as np
import numpy.typing as npt

from scara_iso.base.errors import DataError, Fault, UsageError
from scara_iso.iso9283.core.slips import REPEATED_BY_CHANCE, repeats_in
from scara_iso.rawfile import LEFT_OUT
from scara_iso.run import IntArray, Run

CYCLES_RUN = 31
CYCLES_USED = 30
_FEWEST_RUN = 2
_MOST_REPEATED = 0.25  # of the rows: the interval is then too narrow by a seventh

_COUNTS = {"counts": True, "": False}
_TRUTHS = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}


class CountingOptions(TypedDict, total=False):
    """The fields of `Counting`, as a function takes them."""

    first_cycle_discarded: bool
    cycles: int | None
    all_count: bool
    allow_gaps: bool


@dataclass(frozen=True, slots=True)
class Counting:
    """What is stated of the cycles that count, beside what the table itself says."""

    first_cycle_discarded: bool = False
    """The first cycle is gone already."""
    cycles: int | None = None
    """How many were run where they are not 31, or 30 that all count."""
    all_count: bool = False
    """Every row counts, and none was discarded (``# first_cycle: counts`` in a table)."""
    allow_gaps: bool = False
    """Cycles that are there count where others are missing."""

    def __post_init__(self) -> None:
        """Raise `UsageError` for what cannot be meant."""
        if self.cycles is not None and self.cycles < _FEWEST_RUN:
            raise UsageError(
                f"{self.cycles} cycles are too few", remedy=f"state {_FEWEST_RUN} or more"
            )
        if self.all_count and self.first_cycle_discarded:
            raise UsageError(
                "every cycle counts, or the first is discarded", remedy="state one of them"
            )


AS_THE_TABLE_SAYS = Counting()


class UsedCycles(NamedTuple):
    """The rows that count; without gaps every pose has the same number of cycles."""

    poses: tuple[str | None, ...]
    rows: tuple[npt.NDArray[np.intp], ...]
    """Row numbers of the run by pose, shape (cycles used,) each."""
    read: int
    """Cycles of each pose in the table, of the one with the fewest."""
    discarded: tuple[int, ...]
    """Numbers of the cycles left out, as the table numbers them."""
    missing: tuple[tuple[tuple[int, int], ...], ...]
    """First and last number of each gap, by pose."""
    all_count: bool = False
    """Whether it is stated that every row counts, and that none was discarded before."""

    @property
    def used(self) -> int:
        """Cycles of each pose that the figures are computed from, of the one with the fewest."""
        return min(map(len, self.rows))


def cycles_of_all_poses(
    cycles: Sequence[IntArray], at_least: int
) -> tuple[list[npt.NDArray[np.intp]], str]:
    """Return at each pose the places of the cycles that every pose has, and what is left out.

    Where poses share fewer numbers than ``at_least`` their cycles are taken in turn.
    """
    shared = set.intersection(*(set(one.tolist()) for one in cycles))
    fewest = min(map(len, cycles))
    if len(shared) < min(at_least, fewest):
        note = "the poses do not share the numbers of their cycles: they are taken in turn"
        return [np.arange(fewest) for _ in cycles], note
    gone = sorted({c for one in cycles for c in one.tolist()} - shared)
    note = f"cycle {', '.join(map(str, gone))}: not there at every pose, left out" if gone else ""
    return [np.flatnonzero(np.isin(one, [*shared])) for one in cycles], note


class _Rule(NamedTuple):
    """How many cycles were run, what is said of the first of them, and whether any may lack."""

    cycles: int
    asked: bool
    first_gone: bool | None
    all_count: bool
    allow_gaps: bool

    def drops_first(self, numbers: IntArray) -> bool | None:
        """Return whether the first row is to be left out, None where that cannot be known."""
        start, last = int(numbers[0]), int(numbers[-1])
        if self.all_count:
            wanted = (self.cycles,) if self.asked else (CYCLES_USED, CYCLES_RUN)
            return False if start in (0, 1) and last - start + 1 in wanted else None
        if self.allow_gaps and start > 2 and last == self.cycles:
            start = 2  # counted from 1, and more than the first is missing
        match (last - start + 1 - self.cycles, start, self.first_gone):
            case (0, 0 | 1, None | False):
                return True
            case (-1, 2, None):
                return False
            case (-1, 0 | 1 | 2, True):
                return False
            case (0, 0 | 1 | 2, True) if self.asked:  # the user counts what the table holds
                return False
        return None

    def is_open(self, numbers: IntArray) -> bool:
        """Return whether the rows may or may not hold the first cycle: nothing states which."""
        return (
            int(numbers[-1]) - int(numbers[0]) + 1 == self.cycles - 1
            and int(numbers[0]) in (0, 1)
            and self.first_gone is None
            and not self.all_count
        )

    def gaps(self, numbers: IntArray) -> tuple[tuple[int, int], ...]:
        """Return first and last number of what is missing between the rows, and before them."""
        padded = np.array([1, *numbers])
        holes = np.flatnonzero(np.diff(padded) > 1)
        return tuple((int(padded[k]) + 1, int(padded[k + 1]) - 1) for k in holes)


def used_cycles(run: Run, counting: Counting = AS_THE_TABLE_SAYS) -> UsedCycles:
    """Return the rows of a run that count, by the cycle rule of docs/tables.md.

    Raises `DataError` with every fault of every pose: another number, a gap, a repeat, an order
    that goes back, or 30 cycles of which nobody says whether the first is among them; and where
    visits are written several times.
    """
    rule = _rule(run, counting)
    found = [_of_one_pose(run, rule, label, rows) for label, rows in run.rows_by_pose()]
    if faults := [fault for pose in found for fault in pose.faults]:
        raise DataError(
            "the table breaks the cycle rule",
            where=run.origin.source,
            remedy=_remedy(run, rule, found, " ".join(fault.message for fault in faults)),
            faults=faults,
        )
    lengths = {len(pose.rows) for pose in found if not pose.missing}
    if len({pose.discarded is None for pose in found}) > 1 or len(lengths) > 1:
        raise DataError(
            "some poses hold their first cycle and others do not",
            where=run.origin.source,
            remedy="give every pose the same cycles",
            faults=[Fault(_of_pose(run, pose.counted, pose.label)) for pose in found],
        )
    discarded = {pose.discarded for pose in found if pose.discarded is not None}
    return UsedCycles(
        poses=tuple(pose.label for pose in found),
        rows=tuple(pose.rows for pose in found),
        read=min(len(pose.rows) for pose in found) + bool(discarded),
        discarded=tuple(sorted(discarded)),
        missing=tuple(pose.missing for pose in found),
        all_count=rule.all_count,
    )


class _Pose(NamedTuple):
    """The rows of one pose that count, and what is wrong with them."""

    label: str | None
    rows: npt.NDArray[np.intp]
    discarded: int | None = None
    missing: tuple[tuple[int, int], ...] = ()
    faults: tuple[Fault, ...] = ()
    is_open: bool = False
    repeats: bool = False

    @property
    def counted(self) -> str:
        return f"{len(self.rows)} of {len(self.rows) + (self.discarded is not None)} cycles count"


def _of_one_pose(run: Run, rule: _Rule, label: str | None, rows: IntArray) -> _Pose:
    numbers = run.cycle[rows]
    faults = tuple(_number_faults(run, rule, label, rows))
    repeats = repeats_in(run, rows)
    if repeats.p_value < REPEATED_BY_CHANCE and repeats.repeated > _MOST_REPEATED * repeats.rows:
        what = _of_pose(run, f"{repeats.said}: they are copies, not new readings", label)
        return _Pose(label, rows, faults=(Fault(what), *faults), repeats=True)
    if faults:
        return _Pose(label, rows, faults=faults)
    drop = rule.drops_first(numbers)
    if drop is None:
        fault = _count_fault(run, rule, label, numbers)
        return _Pose(label, rows, faults=(fault,), is_open=rule.is_open(numbers))
    gaps = rule.gaps(numbers)
    if drop:
        return _Pose(label, rows[1:], int(numbers[0]), gaps)
    return _Pose(label, rows, missing=gaps)


def _rule(run: Run, given: Counting) -> _Rule:
    """Return the rule by the table's head and what the user gives; they must not contradict."""
    gone = _stated(run, "first_cycle_discarded", _TRUTHS, "write true or false")
    counts = _stated(run, "first_cycle", _COUNTS, "write counts, or leave the line out")
    all_count = bool(counts or given.all_count)
    what = "the table says first_cycle_discarded: false, the option says that it is discarded"
    if all_count and (gone or given.first_cycle_discarded):
        what = "two statements differ: every cycle counts, and the first is discarded"
    elif gone is not False or not given.first_cycle_discarded:
        what = ""
    if what:
        remedy = "correct the one that is wrong"
        raise DataError(what, where=run.origin.source, remedy=remedy)
    return _Rule(
        cycles=given.cycles or (CYCLES_USED if all_count else CYCLES_RUN),
        asked=given.cycles is not None,
        first_gone=gone if gone is not None else given.first_cycle_discarded or None,
        all_count=all_count,
        allow_gaps=given.allow_gaps,
    )


def _stated(run: Run, key: str, words: Mapping[str, bool], remedy: str) -> bool | None:
    """Return what a line of the head says by these words, None where it is not there."""
    text = run.metadata.get(key)
    if text is None:
        return None
    found = words.get(text.strip().lower())
    if found is None:
        raise DataError(f"{key} is {text!r}", where=run.origin.source, remedy=remedy)
    return found


def _number_faults(run: Run, rule: _Rule, label: str | None, rows: IntArray) -> Iterator[Fault]:
    numbers = run.cycle[rows]
    steps = np.diff(numbers)
    wrong = steps < 1 if rule.allow_gaps or _none_missing(numbers) else steps != 1
    back = np.flatnonzero(wrong & (steps < 0))
    many = len(back) if run.lines is None and len(back) > 1 else 0
    wrong[back[1:]] &= not many  # no lines tell them apart
    for k in np.flatnonzero(wrong) + 1:
        before, here = int(numbers[k - 1]), int(numbers[k])
        if here == before:
            what = f"cycle {here} is there twice"
        elif here < before:
            what = f"cycle {here} comes after cycle {before}: the order goes back"
            what += f" and the like ({many} times)" * bool(many)
        else:
            what = f"{name_gap(before + 1, here - 1)} missing"
        line = None if run.lines is None else int(run.lines[rows[k]])
        yield Fault(_of_pose(run, what, label), line=line, sheet=run.origin.sheet)


def _none_missing(numbers: IntArray) -> bool:
    """Say whether each cycle is there once, in any order."""
    return bool(np.all(np.diff(np.sort(numbers)) == 1))


def name_gap(first: int, last: int) -> str:
    """Return ``cycle 5 is`` or ``cycles 5 to 7 are``."""
    return f"cycle {first} is" if first == last else f"cycles {first} to {last} are"


def _count_fault(run: Run, rule: _Rule, label: str | None, numbers: IntArray) -> Fault:
    rows, first, last = len(numbers), int(numbers[0]), int(numbers[-1])
    what = f"{rows} cycles, numbered {first} to {last}"
    if rule.is_open(numbers):
        what += (
            f". Which applies? (a) the first of {rule.cycles} was already removed, (b) {rows} were "
            "run and all count, (c) the first of these is to be discarded"
        )
    elif rule.all_count:
        what += f", where {rule.cycles} from 1 are needed, of which all count"
    elif rule.first_gone:
        what += f", where {rule.cycles - 1} are needed because the first is stated as discarded"
    else:
        what += f", where {rule.cycles} from 1 are needed (the first of them is discarded)"
    return Fault(_of_pose(run, what, label))


_LATEST_FIRST = 2
"""Number of the first cycle that counts, where the first of all was removed."""
_SIDES = (
    "write +1 and -1 in the column approach where both sides are of one test; as +x and -x each "
    "side has all its cycles, or say `cycles=N`"
)

_APART = "save each run as a table of its own; poses are named in each row of a column pose"


def _remedy(run: Run, rule: _Rule, found: Sequence[_Pose], said: str) -> str:
    if " twice" in said or any(pose.repeats for pose in found):
        return "take one row a visit, and number the cycles from 1"
    if LEFT_OUT in run.metadata or "cycles_planned" in run.metadata:
        last = {int(run.cycle[pose.rows[-1]]) for pose in found}
        cut = f"the recording of {run.origin.source} was cut short: record with `resume=True` "
        fewer = f"; or say `cycles={max(last)}`, with `allow_gaps=True` where some are missing"
        more = fewer * (len(last) == 1 < max(last))
        return run.metadata.get(LEFT_OUT) or f"{cut}continues it{more}"
    later = min(int(run.cycle[pose.rows].min()) for pose in found) > _LATEST_FIRST
    apart = _APART if "cycle 1 comes after" in said else ""
    sides = _SIDES if run.direction is not None else "number the cycles from 1" if later else apart
    if opened := [pose.label or "" for pose in found if pose.is_open]:
        repeat = f"repeat {', '.join(opened)}, or save each pose as a table of its own"
        repeat += " and analyze these one by one, not as one test"
        return _which_applies(rule) if len(opened) == len(found) else sides or repeat
    if " missing" in said and "goes back" not in said:
        return (
            "repeat the missing cycles, or say `allow_gaps=True`: the rest counts, "
            "the gap is listed"
        )
    if "goes back" in said and all(_none_missing(run.cycle[pose.rows]) for pose in found):
        return "sort the rows by their cycle, if each has the number of its visit"
    return sides or _other_number({int(run.cycle[pose.rows[-1]]) for pose in found}, rule)


def _which_applies(rule: _Rule) -> str:
    return (
        "(a) `first_cycle_discarded=True`, or '# first_cycle_discarded: true' in the file; "
        "(b) `all_count=True`, or '# first_cycle: counts'; "
        f"(c) `cycles={rule.cycles - 1}`"
    )


def _other_number(counts: Collection[int], rule: _Rule) -> str:
    """Return what to do about poses of so many cycles, numbered from 1 without a gap."""
    if min(counts) < rule.cycles + rule.all_count:
        return "repeat the missing cycles, or say `cycles=N` for a test of another length"
    if rule.first_gone and max(counts) == rule.cycles:
        return (
            "leave out `first_cycle_discarded=True`, or that line of the table, where the first "
            "cycle is still in it, and say '# first_cycle_discarded: true' in each other table; "
            f"else say `cycles={rule.cycles + 1}`"
        )
    poses, left = divmod(max(counts), rule.cycles)
    named = f"if these are {poses} poses of {rule.cycles} cycles, name them in a column pose, "
    named += "if velocities, save each as a table of its own; else "
    many = f"say `cycles=N` for a test of another length, here N = {max(counts)}"
    return f"{named * (poses > 1 and not left)}{many}; else remove the rows that are not visits"


def _of_pose(run: Run, what: str, label: str | None) -> str:
    file = run.origin.files.get(label or "")
    return what if label is None else f"pose {label}{f' ({file})' if file else ''}: {what}"
