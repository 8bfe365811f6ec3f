"""`compare`: two tables or more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias, Unpack

from scara_iso import comparison, iso9283
from scara_iso.base.errors import UsageError
from scara_iso.comparison import SEED, Comparison
from scara_iso.iso9283 import Analysis
from scara_iso.library.conditions import ConditionRun
from scara_iso.library.inputs import Tables, TablesOptions, every, parted
from scara_iso.library.sizes import sizes_of
from scara_iso.testfolder import is_test_folder

_Set: TypeAlias = Tables | Analysis


def compare(
    *tables: _Set | Sequence[_Set],
    condition: str | None = None,
    exchangeability: bool = False,
    limits: float | Mapping[str, float] | None = None,
    seed: int = SEED,
    **options: Unpack[TablesOptions],
) -> Comparison:
    """Return every table against the first: means, RP and +/- 3 s of angles, with intervals.

    ``compare(before, after)`` or ``compare([before, after, later])``; each may be the tables of
    several poses (a folder, or a sequence), which are compared pose by pose; of a test's folder
    those under ``condition``, which may be left out where it has one only. An `Analysis` is taken
    as it is. Options are those of `analyze`, for every table; ``seed`` is that of the permutations.
    With ``exchangeability`` the tables are of several robots (7.7), and ``limits`` may hold
    ``exchangeability``, in mm. The method is that of docs/compare.md. Raises one error with the
    faults of all tables, and `UsageError` for fewer than two.
    """
    reading, counting = parted(**options)

    def figures(table: _Set) -> Analysis:
        if isinstance(table, Analysis):
            return table
        named = condition if _is_test(table) else None
        if (measured := reading.measured(table, named)) is not None:
            return iso9283.analyze(measured.readings, measured.counted(counting))
        return iso9283.analyze(reading.read(table), counting)

    wanted = sizes_of("limits", limits)
    if not exchangeability:
        comparison.refuse_limits(wanted)
    sets = _sets(tables)
    if condition is not None and not any(map(_is_test, sets)):
        raise UsageError("`condition=` is for the folders of tests", remedy="leave it out")
    analyses = every(sets, figures, f"of {len(sets)} tables")
    found = comparison.compare(analyses, seed=seed)
    if not exchangeability:
        return found
    return replace(found, characteristics=comparison.exchangeability(analyses, wanted))


def _is_test(table: _Set) -> bool:
    return isinstance(table, ConditionRun) or is_test_folder(table)


def _sets(tables: Sequence[_Set | Sequence[_Set]]) -> list[_Set]:
    """Return the runs to compare: a single sequence holds them, else each argument is one."""
    one = tables[0] if len(tables) == 1 else None
    return list(one if isinstance(one, list | tuple) else tables)
