"""A drift test (7.6) is run in blocks of visits over hours: which row belongs to which block."""

from collections.abc import Iterator

import numpy as np

from scara_iso.base.errors import DataError, Fault, UsageError
from scara_iso.base.quantities import parse_number
from scara_iso.iso9283.cycles import UsedCycles
from scara_iso.run import FloatArray, IntArray, Run

VISITS = "visits_per_block"
_LONG = 3.0  # times the usual step of time: a warm-up motion between two blocks takes longer
_FEWEST = 2  # blocks, and visits in each


def block_of_rows(run: Run) -> IntArray | None:
    """Return the block of each row, from 0, shape (rows,); None unless the run is a drift test.

    It is one where it has a column ``block`` of numbers that come in order, beside its times, or
    says ``# test: drift``; without the column ``# visits_per_block: 10`` then parts the blocks,
    else a gap in time of more than three usual steps. Raises `DataError` where a stated drift test
    has no such blocks.
    """
    stated = run.metadata.get("test", "").strip().lower() == "drift"
    block, time = run.covariates.get("block"), run.covariates.get("time_s")
    if not stated and (block is None or time is None):
        return None
    if block is None and VISITS in run.metadata:
        block = _from_count(run)
    elif block is None and time is not None:
        block = blocks_from_gaps(time)
    fault = _fault(run, block)
    if fault is None and block is not None:
        return np.asarray(np.unique(block, return_inverse=True)[1])
    if stated:
        raise DataError(
            f"is stated as a drift test, and {fault}",
            where=run.origin.source,
            remedy="number the blocks of visits in a column 'block', and state each row's time_s",
        )
    return None


def every_visit(run: Run, block: IntArray, *, asked: bool) -> UsedCycles:
    """Return all rows of a drift test; each block may count its visits anew.

    ``asked`` tells whether the user wants a first cycle left out, or another number: `UsageError`.
    `DataError` where the visits of a block are not counted one by one.
    """
    if asked:
        raise UsageError(
            "every visit of a drift test counts: none is discarded, and their number is free",
            remedy="leave `first_cycle_discarded=` and `cycles=` out",
        )
    poses = list(run.rows_by_pose())
    faults = [fault for _, rows in poses for fault in _count_faults(run, block, rows)]
    if faults:
        raise DataError(
            "the blocks of the drift test do not count their visits one by one",
            where=run.origin.source,
            remedy="number the visits 1, 2, 3 .. in each block, or through all of them",
            faults=faults,
        )
    return UsedCycles(
        poses=tuple(label for label, _ in poses),
        rows=tuple(rows for _, rows in poses),
        read=min(len(rows) for _, rows in poses),
        discarded=(),
        missing=tuple(() for _ in poses),
        all_count=True,
    )


def _count_faults(run: Run, block: IntArray, rows: IntArray) -> Iterator[Fault]:
    same, steps = np.diff(block[rows]) == 0, np.diff(run.cycle[rows])
    for k in np.flatnonzero(same & (steps != 1)):
        line = None if run.lines is None else int(run.lines[rows[k + 1]])
        before, here = run.cycle[rows[k]], run.cycle[rows[k + 1]]
        what = f"visit {here} comes after visit {before} of the same block"
        yield Fault(what, line=line, sheet=run.origin.sheet)


def visits_of_blocks(block: IntArray, rows: IntArray) -> list[IntArray]:
    """Return which of ``rows`` each block holds, in order, as places in ``rows``."""
    mine = block[rows]
    return [np.flatnonzero(mine == one) for one in np.unique(mine)]


def blocks_from_gaps(time: FloatArray) -> FloatArray:
    """Return the number of gaps in time before each row, shape (rows,)."""
    steps = np.diff(time)
    return np.concatenate([[0.0], np.cumsum(steps > _LONG * np.median(steps))])


def _from_count(run: Run) -> FloatArray | None:
    visits = parse_number(run.metadata[VISITS])
    if visits is None or visits < 1 or visits != int(visits):
        return None
    block = np.empty(len(run))
    for _, rows in run.rows_by_pose():
        block[rows] = np.arange(len(rows)) // int(visits)
    return block


def _fault(run: Run, block: FloatArray | None) -> str | None:
    if block is None:
        return f"neither a column 'block', nor '# {VISITS}: 10', nor times tell its blocks"
    if np.any(block != np.round(block)) or np.any(np.diff(block) < 0):
        return "its blocks are not numbered in order"
    if np.any(np.diff(run.covariates.get("time_s", block)) < 0):
        return "its times go back"
    sizes = [np.unique(block[rows], return_counts=True)[1] for _, rows in run.rows_by_pose()]
    if any(len(counts) < _FEWEST or counts.min() < _FEWEST for counts in sizes):
        return f"it has fewer than {_FEWEST} blocks of {_FEWEST} visits"
    return None
