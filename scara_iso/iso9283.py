"""The procedure of ISO 9283 as this tool holds a table to it: which cycles count.

The paper runs 31 cycles and drops the first, so that the side of the gap on which the first
arrival happens to rest does not count. The standard (clause 6.9) knows 30 cycles.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scara_iso.errors import DataError, Fault, UsageError
from scara_iso.run import IntArray, Run

CYCLES_RUN = 31
CYCLES_USED = 30
_FEWEST_RUN = 2

_TRUTHS = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}


@dataclass(frozen=True, eq=False, slots=True)
class UsedCycles:
    """The rows that count: every pose has the same number of cycles."""

    poses: tuple[str | None, ...]
    rows: npt.NDArray[np.intp]
    """Row numbers of the run, shape (poses, cycles used)."""
    read: int
    """Cycles of each pose in the table."""
    discarded: tuple[int, ...]
    """Numbers of the cycles left out, as the table numbers them."""

    @property
    def used(self) -> int:
        """Cycles of each pose that the figures are computed from."""
        return int(self.rows.shape[1])


@dataclass(frozen=True, slots=True)
class _Rule:
    """How many cycles were run, and whether the table lacks the first of them."""

    cycles: int
    asked: bool
    first_gone: bool | None

    def drops_first(self, numbers: IntArray) -> bool | None:
        """Return whether the first row is to be left out, None where that cannot be known."""
        rows, start = len(numbers), int(numbers[0])
        match (rows - self.cycles, start, self.first_gone):
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
        """Return whether the rows may or may not hold the first cycle: nobody says which."""
        return (
            len(numbers) == self.cycles - 1
            and int(numbers[0]) in (0, 1)
            and self.first_gone is None
        )


def used_cycles(
    run: Run, *, first_cycle_discarded: bool = False, cycles: int | None = None
) -> UsedCycles:
    """Return the rows of a run that count, by the cycle rule of docs/tables.md.

    ``first_cycle_discarded`` states what the table does not say: that its first cycle is gone
    already. ``cycles`` accepts another number than 31 (the first one counted). Raises `DataError`
    with every fault of every pose: another number, a gap, a repeat, an order that goes back, or
    30 cycles of which nobody says whether the first is among them.
    """
    if cycles is not None and cycles < _FEWEST_RUN:
        raise UsageError(f"{cycles} cycles", remedy=f"say how many were run, {_FEWEST_RUN} or more")
    rule = _Rule(cycles or CYCLES_RUN, cycles is not None, _first_gone(run, first_cycle_discarded))
    poses, rows, drops, faults = [], [], [], list[Fault]()
    discarded = set()
    undecided = False
    for label, pose_rows in run.rows_by_pose():
        numbers = run.cycle[pose_rows]
        found = list(_number_faults(run, label, pose_rows))
        drop = rule.drops_first(numbers) if not found else None
        if drop is None and not found:
            found.append(_count_fault(rule, label, numbers))
            undecided |= rule.is_open(numbers)
        faults += found
        poses.append(label)
        rows.append(pose_rows[1:] if drop else pose_rows)
        drops.append(bool(drop))
        discarded |= {int(numbers[0])} if drop else set()
    if faults:
        raise _broken(run, rule, faults, undecided=undecided)
    if len(set(drops)) > 1 or len({len(counted) for counted in rows}) > 1:
        what = "some poses hold their first cycle and others do not"
        raise DataError(what, where=run.origin.source, remedy="give every pose the same cycles")
    return UsedCycles(
        poses=tuple(poses),
        rows=np.stack(rows),
        read=len(rows[0]) + drops[0],
        discarded=tuple(sorted(discarded)),
    )


def _first_gone(run: Run, stated_by_user: bool) -> bool | None:
    text = run.metadata.get("first_cycle_discarded")
    if text is None:
        return stated_by_user or None
    truth = _TRUTHS.get(text.strip().lower())
    if truth is None:
        raise DataError(
            f"first_cycle_discarded is {text!r}", where=run.origin.source,
            remedy="write true or false",
        )  # fmt: skip
    if stated_by_user and not truth:
        raise DataError(
            "the table says first_cycle_discarded: false, the option says that it is discarded",
            where=run.origin.source,
            remedy="correct the one that is wrong",
        )
    return truth


def _number_faults(run: Run, label: str | None, rows: IntArray) -> Iterator[Fault]:
    numbers = run.cycle[rows]
    steps = np.diff(numbers)
    for k in np.flatnonzero(steps != 1) + 1:
        before, here = int(numbers[k - 1]), int(numbers[k])
        if here == before:
            what = f"cycle {here} is there twice"
        elif here < before:
            what = f"cycle {here} comes after cycle {before}: the order goes back"
        elif here == before + 2:
            what = f"cycle {before + 1} is missing"
        else:
            what = f"cycles {before + 1} to {here - 1} are missing"
        yield Fault(_of_pose(what, label), line=_line(run, rows[k]))


def _count_fault(rule: _Rule, label: str | None, numbers: IntArray) -> Fault:
    rows, first, last = len(numbers), int(numbers[0]), int(numbers[-1])
    what = f"{rows} cycles, numbered {first} to {last}"
    if rule.is_open(numbers):
        what += (
            f": either the first of {rule.cycles} was discarded before, and all {rows} count, "
            f"or it is still among them, and one is missing"
        )
    elif rule.first_gone:
        what += f", where {rule.cycles - 1} are wanted because the first is said to be discarded"
    else:
        what += f", where {rule.cycles} from 1 are wanted (the first of them is discarded)"
    return Fault(_of_pose(what, label))


def _broken(run: Run, rule: _Rule, faults: list[Fault], *, undecided: bool) -> DataError:
    if undecided:
        remedy = (
            "say --first-cycle-discarded (or '# first_cycle_discarded: true' in the file) if it "
            f"was; say --cycles {rule.cycles - 1} to discard the first of these all the same"
        )
    else:
        remedy = "repeat the missing cycles, or say --cycles N for a test of another length"
    what = "the table breaks the cycle rule"
    return DataError(what, where=run.origin.source, remedy=remedy, faults=faults)


def _of_pose(what: str, label: str | None) -> str:
    return what if label is None else f"pose {label}: {what}"


def _line(run: Run, row: int) -> int | None:
    return None if run.lines is None else int(run.lines[row])
