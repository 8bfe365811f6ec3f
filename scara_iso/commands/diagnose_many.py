"""`diagnose_many`: the diagnoses of several unrelated tables, side by side."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Unpack

from scara_iso.base.displayed import Displayed
from scara_iso.base.errors import ScaraIsoError
from scara_iso.base.published import MERGED
from scara_iso.commands.shared import inputs
from scara_iso.commands.shared.options import Asked
from scara_iso.commands.shared.output import Answer, with_progress
from scara_iso.diagnosis import SEED, CyclesWanted, Diagnosis, close_the_loop
from scara_iso.reporting import Failure, summary_report
from scara_iso.run import frame_of

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False, slots=True)
class Diagnoses(Displayed):
    """Several diagnoses, found by number or by name: ``found[0]``, ``found["P1"]``."""

    names: tuple[str, ...]
    """File of each table, or label of each pose."""
    found: tuple[Diagnosis | Failure, ...]
    """In that order; a `Failure` where a table could not be diagnosed."""

    def __len__(self) -> int:
        return len(self.found)

    def __iter__(self) -> Iterator[Diagnosis | Failure]:
        return iter(self.found)

    def __getitem__(self, at: int | str) -> Diagnosis | Failure:
        if not isinstance(at, str):
            return self.found[at]
        if at not in self.names:
            raise KeyError(f"no diagnosis of {at!r}: there is {', '.join(self.names)}")
        return self.found[self.names.index(at)]

    def __repr__(self) -> str:
        parts = (one.verdict.value if isinstance(one, Diagnosis) else "failed" for one in self)
        counts = ", ".join(f"{count} {word}" for word, count in Counter(parts).items())
        return f"<Diagnoses of {len(self)}: {counts}>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table, a row for each: name, verdict, effects, p_value, failure."""
        return frame_of([_row(*one) for one in zip(self.names, self.found, strict=True)], {})


def _row(name: str, found: Diagnosis | Failure) -> dict[str, Any]:
    row = {"name": name, "verdict": None, "effects": "", "p_value": float("nan"), "failure": None}
    if isinstance(found, Failure):
        return {**row, "failure": found.message}
    effects = ", ".join(effect.effect for effect in found.effects)
    return {**row, "verdict": found.verdict.value, "effects": effects, "p_value": found.p_value}


def diagnose_many(
    tables: str | Path | Sequence[str | Path],
    model: str | Path | None = None,
    *,
    seed: int = SEED,
    own_effects: str | Path | None = None,
    executor: Executor | None = None,
    **options: Unpack[inputs.TablesOptions],
) -> Diagnoses:
    """Return the diagnosis of each of several unrelated tables, by number or by file name.

    A folder is its tables. ``executor`` shares the work, any of `concurrent.futures` (a cluster's
    too), else as many processes as there are cores; the result is the same. A table that cannot be
    diagnosed gives a `Failure` with its message. Options are those of `diagnose`; ``own_effects``
    is a file.
    """
    reading, counting = inputs.reading_and_counting(diagnose_many, options)
    wanted = CyclesWanted(counting=counting)
    work = partial(_diagnose_one, (model, own_effects), reading, wanted, seed)
    return Diagnoses(
        tuple(map(str, inputs.tables_of(tables))), tuple(inputs.each_of(tables, work, executor))
    )


def _diagnose_one(
    files: tuple[str | Path | None, str | Path | None],
    reading: inputs.Reading,
    wanted: CyclesWanted,
    seed: int,
    table: str,
) -> Diagnosis | Failure:
    """Return the diagnosis of a table, in another process too; ``files``: model, effects."""
    model, effects = files
    try:
        own = inputs.load_effects(effects)
        known = None if model is None else inputs.load_model(model, own)
        return close_the_loop(inputs.read_run(table, reading), known, wanted, seed=seed, own=own)
    except ScaraIsoError as error:
        return Failure(error.headline, error.exit_code)


@dataclass(frozen=True, slots=True)
class RefusedTable:
    """A table that could not be diagnosed."""

    table: str
    """The file."""
    error: str
    """Why."""


@dataclass(frozen=True, eq=False, slots=True)
class DiagnosedTable:
    """``diagnose`` of one of several unrelated tables."""

    table: str
    """The file."""
    diagnosis: Diagnosis = field(metadata=MERGED)


@dataclass(frozen=True, eq=False, kw_only=True)
class DiagnosedTables:
    """``diagnose`` of several unrelated tables."""

    schema: Literal["scara-iso/diagnose-many/1"] = "scara-iso/diagnose-many/1"
    """Name and number of this schema."""
    tables: Annotated[tuple[DiagnosedTable | RefusedTable, ...], ("minItems", 1)]
    """As they were named."""


def answer_of_many(tables: Sequence[str], asked: Asked[Any]) -> Answer:
    """Diagnose every table, in as many processes as there are cores; return a summary.

    A table that cannot be diagnosed is said in its row; the exit code is then the first one's.
    """
    wanted = CyclesWanted(asked["pose"], asked.counting)
    files = asked["model"], asked["own_effects"]
    work = partial(_diagnose_one, files, asked.reading, wanted, asked["seed"])
    found = list(with_progress(inputs.each_of(tables, work), len(tables)))
    rows = (
        RefusedTable(table, one.message) if isinstance(one, Failure) else DiagnosedTable(table, one)
        for table, one in zip(tables, found, strict=True)
    )
    published = DiagnosedTables(tables=tuple(rows))
    code = next((one.exit_code for one in found if isinstance(one, Failure)), 0)
    return Answer(published, lambda: summary_report(tables, found), code=code)
