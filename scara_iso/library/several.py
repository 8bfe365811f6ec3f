"""`compare`: two tables or more."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from scara_iso import comparison, iso9283
from scara_iso.comparison import SEED, Comparison
from scara_iso.errors import DataError, Fault, NoInputError, ScaraIsoError
from scara_iso.iso9283 import Analysis
from scara_iso.library.inputs import Table, TableOptions


def compare(
    *tables: Table | Analysis | Sequence[Table | Analysis],
    unit: str | None = None,
    resolution: float | None = None,
    decimal: str | None = None,
    sheet: str | None = None,
    first_cycle_discarded: bool = False,
    cycles: int | None = None,
    all_count: bool = False,
    allow_gaps: bool = False,
    exchangeability: bool = False,
    limits: Mapping[str, float] | None = None,
    seed: int = SEED,
) -> Comparison:
    """Return every table against the first: means, RP and +/- 3 s of angles, with intervals.

    ``compare(before, after)`` or ``compare([before, after, later])``; an `Analysis` is taken as it
    is. Options are those of `analyze`, for every table; ``seed`` is that of the permutations. With
    ``exchangeability`` the tables are of several robots (7.7), and ``limits`` may hold
    ``exchangeability``, in mm. The method is that of docs/compare.md. Raises one error with the
    faults of all tables, and `UsageError` for fewer than two.
    """
    reading = TableOptions(unit, resolution, decimal, sheet)

    def figures(table: Table | Analysis) -> Analysis:
        if isinstance(table, Analysis):
            return table
        return iso9283.analyze(
            reading.read(table),
            first_cycle_discarded=first_cycle_discarded,
            cycles=cycles,
            all_count=all_count,
            allow_gaps=allow_gaps,
        )

    if not exchangeability:
        comparison.refuse_limits(limits)
    analyses = _every(_listed(tables), figures)
    found = comparison.compare(analyses, seed=seed)
    if not exchangeability:
        return found
    return replace(found, characteristics=comparison.exchangeability(analyses, limits or {}))


def _listed(
    tables: Sequence[Table | Analysis | Sequence[Table | Analysis]],
) -> list[Table | Analysis]:
    found: list[Table | Analysis] = []
    for table in tables:
        found += table if isinstance(table, list | tuple) else [table]  # type: ignore[list-item]
    return found


def _every(
    tables: Sequence[Table | Analysis], figures: Callable[[Table | Analysis], Analysis]
) -> list[Analysis]:
    """Return the analysis of every table, or one error with the faults of all."""
    found, errors = [], []
    for table in tables:
        try:
            found.append(figures(table))
        except ScaraIsoError as error:
            errors.append(error)
    if errors:
        raise errors[0] if len(errors) == 1 else _together(errors, len(tables))
    return found


def _together(errors: Sequence[ScaraIsoError], tables: int) -> ScaraIsoError:
    what = f"{len(errors)} of {tables} tables cannot be compared"
    remedies = dict.fromkeys(error.remedy for error in errors if error.remedy)
    if all(isinstance(error, NoInputError) for error in errors):
        said = "; ".join(error.headline for error in errors)
        return NoInputError(f"{what}: {said}", remedy="; ".join(remedies))
    faults = [fault for error in errors for fault in _faults(error)]
    return DataError(what, remedy="; ".join(remedies), faults=faults)


def _faults(error: ScaraIsoError) -> list[Fault]:
    of_it = error.faults if isinstance(error, DataError) else ()
    below = (Fault(f"{error.where}: {fault}") for fault in of_it if fault.message != error.what)
    return [Fault(error.headline), *below]
