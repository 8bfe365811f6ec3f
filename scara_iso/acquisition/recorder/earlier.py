"""What was recorded before: read, and refused where going on would lose or mix something."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path

from scara_iso.acquisition.manifest import find_doubts, manifest_path, raw_path
from scara_iso.acquisition.recorder.events import Noticed
from scara_iso.acquisition.recorder.history import History, read_history
from scara_iso.acquisition.recorder.journal import Journal
from scara_iso.acquisition.recorder.plan import Job
from scara_iso.acquisition.recorder.table import doubts_beside, table_of
from scara_iso.disk import check_output
from scara_iso.errors import CannotCreateError, DataError, NoInputError, UsageError
from scara_iso.files import is_folder

_CUT_SHORT = "the cycle was cut short"


def check_files(table: Path, *, resume: bool) -> None:
    """Raise, before any port is opened, where a recording cannot be kept beside its table.

    As `check_output`, `CannotCreateError` where one of its files is there already, and
    `NoInputError` where there is nothing to ``resume``.
    """
    (refuse_missing if resume else refuse_existing)(table)
    check_output(table, raw_path(table), manifest_path(table))


def refuse_existing(table: Path) -> None:
    """Raise `CannotCreateError` where a table, its raw file or its manifest is there already."""
    if is_folder(table):
        raise CannotCreateError(
            "is a folder, and not that of a test",
            where=str(table),
            remedy=f"name a table in it, or make it one: scara-iso test new {table} "
            "`model=MODEL.toml`",
        )
    for path in (table, raw_path(table), manifest_path(table)):
        if os.path.lexists(path):
            begun = raw_path(table).is_file()
            raise CannotCreateError(
                "exists already",
                where=str(path),
                remedy="use another name" + ", or `resume=True` to go on with it" * begun,
            )


def refuse_missing(table: Path) -> None:
    """Raise `NoInputError` where nothing was recorded for a table."""
    raw = raw_path(table)
    if not raw.exists():
        raise NoInputError(
            f"is not there: nothing was recorded for {table.name}",
            where=str(raw),
            remedy="check the name, or leave `resume=True` out and begin",
        )


def earlier_of(table: Path) -> History:
    """Return what was recorded for a table; raises as `refuse_missing`."""
    refuse_missing(table)
    return read_history(raw_path(table))


def read_earlier(job: Job) -> History:
    """Return what the raw file of a job holds, nothing where it does not go on with one.

    Raises `UsageError` for other gauges than before, `CannotCreateError` for a table that is not
    made of the raw file, and `DataError` for a raw file that cannot be gone on with.
    """
    raw = raw_path(job.table)
    if not job.resume:
        return History(str(raw))
    history = read_history(raw)
    if history.header or history.faults:
        history.check()
        _refuse_other_gauges(job, history)
        _refuse_other_poses(job, history)
    _refuse_changed_table(job.table, history)
    history.inherit(doubts_beside(raw, history))
    _refuse_gaps(history)
    return history


def strike_cut_short(earlier: History, journal: Journal) -> Iterator[Noticed]:
    """Strike out half a visit, and say so: what comes now is of another."""
    visit = earlier.visit
    if cut := earlier.cut_short():
        stated = earlier.tour.state(visit)
        journal.append("void", **stated, axes=cut, reason=_CUT_SHORT)
        earlier.strike(visit, cut)
        half = f"{', '.join(cut)} of {earlier.tour.name(visit)}"
        yield Noticed("", f"{half} struck out: {_CUT_SHORT}")


def _refuse_other_gauges(job: Job, history: History) -> None:
    recorded = {axis: gauge["dialect"] for axis, gauge in history.header["gauges"].items()}
    given = {gauge.axis: gauge.dialect.key for gauge in job.gauges}
    if recorded != given:
        raise UsageError(
            f"recorded with {_listed(recorded)}, and now {_listed(given)}",
            where=history.source,
            remedy="give the same `gauge=` options, or none",
        )


def _refuse_other_poses(job: Job, history: History) -> None:
    recorded, given = (",".join(tour.poses) for tour in (history.tour, job.plan.tour))
    if recorded != given:
        raise UsageError(
            f"recorded at {recorded or 'one pose without a name'}, and now at {given or 'one'}",
            where=history.source,
            remedy=f"give `pose={recorded}`" if recorded else "leave `pose=` out",
        )


def _listed(gauges: Mapping[str, str]) -> str:
    return ", ".join(f"{axis}={key}" for axis, key in gauges.items())


def _refuse_changed_table(table: Path, history: History) -> None:
    if table.exists() and find_doubts(table).table and not _is_made_of(history, table):
        raise CannotCreateError(
            "was changed after it was recorded",
            where=str(table),
            remedy="move it away: it would be written anew from the raw file",
        )


def _is_made_of(history: History, table: Path) -> bool:
    try:
        return table.read_bytes() == table_of(history)
    except DataError:  # no cycle is complete
        return False


def _refuse_gaps(history: History) -> None:
    visit = history.visit
    if any(history.present(later) for later in range(visit + 1, len(history.times) + 1)):
        raise DataError(
            f"{history.tour.name(visit)} is missing and later ones are there",
            where=history.source,
            remedy="make the table of what is there with `rebuild=True`, and repeat the test",
        )
