"""What a public function takes for a table of readings."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, TypeAlias, Union

from scara_iso.errors import UsageError
from scara_iso.frames import is_frame
from scara_iso.run import Run
from scara_iso.tables import Source, read_table

if TYPE_CHECKING:
    import pandas as pd

Table: TypeAlias = Union[Run, Source, "pd.DataFrame"]
"""A path, ``-`` for standard input, bytes, an open file, a `Run` or a pandas table."""


@dataclass(frozen=True, slots=True)
class TableOptions:
    """How tables are to be read, as in `read_table`; a pandas table needs its ``unit``."""

    unit: str | None = None
    resolution: float | None = None
    decimal: str | None = None
    sheet: str | None = None

    def read(self, table: Table) -> Run:
        """Return the run of a table.

        Errors as in `read_table` and `Run.from_frame`; `UsageError` for an option that the kind of
        table has no use for.
        """
        if isinstance(table, Run):
            self._refuse("a Run", ("unit", "resolution", "decimal", "sheet"))
            return table
        if is_frame(table):
            self._refuse("a data frame", ("decimal", "sheet"))
            return Run.from_frame(table, unit=self.unit, resolution=self.resolution)
        return read_table(table, **asdict(self))

    def _refuse(self, kind: str, options: tuple[str, ...]) -> None:
        given = [name for name in options if getattr(self, name) is not None]
        if given:
            raise UsageError(
                f"{', '.join(given)}: {kind} is not read from text", remedy="leave it out"
            )
