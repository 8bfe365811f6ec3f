"""Faults of one file: counted up to a bound at which reading ends, the first thousand kept."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from scara_iso.base.errors import DataError, Fault, NoInputError, ScaraIsoError
from scara_iso.tables.words import Subject

KEPT = 1000
"""Faults that a `DataError` lists; more are counted."""
_MOST = 10_000
"""Faults after which a file is not read on."""
_SHOWN = 30
REMARK = 60
"""Characters of a line that is not used: enough to see whether it matters."""
_REMEDIES = 3
"""Kinds of faults whose remedies are said: those of the first may mend the rest."""


class Faults:
    """Collect what is wrong with the file ``where``, wanted as ``what``, in the order found.

    ``sheet`` is the one of a workbook; empty for text.
    """

    def __init__(self, where: str, what: str = "a table of readings", *, sheet: str = "") -> None:
        self.where = where
        self.sheet = sheet
        self.row = "row" if sheet else "line"
        """What a line of the file is called."""
        self.what = what
        self.total = 0
        self._kept: list[Fault] = []
        self._remedies: dict[str, None] = {}
        self.first_remedy = ""
        """Stands in place of those of the faults."""

    def add(
        self, message: str, line: int | None = None, column: int | None = None, *, remedy: str
    ) -> None:
        """Note one fault and what to do about it; the error says what to do about each kind.

        Raises `DataError` where there are so many that reading on would be of no use.
        """
        self.total += 1
        self._remedies.setdefault(remedy)
        if len(self._kept) < KEPT:
            self._kept.append(
                Fault(message, line or None, column, self.sheet)
            )  # a log has no header
        if self.total == _MOST:
            self.check()

    def place(self, line: int) -> str:
        """Return what a message calls a line; 0 is one outside of the sheet."""
        return f"{self.row} {line}" if line else "another sheet or a page header"

    def check(self) -> None:
        """Raise `DataError` if a fault was noted."""
        if not self.total:
            return
        faults = sorted(self._kept, key=lambda fault: (fault.line or 0, fault.column or 0))
        count = "1 fault" if self.total == 1 else f"{self.total} faults"
        more = f", the first {KEPT} listed" if self.total > KEPT else ""
        more += "; the rest was not read" if self.total == _MOST else ""
        raise DataError(
            f"cannot be read as {self.what}: {count}{more}",
            where=self.where,
            remedy=self.first_remedy or "; ".join([*self._remedies][:_REMEDIES]),
            faults=faults,
        )


def refuse(where: str, message: str, *, remedy: str) -> DataError:
    """Return the `DataError` of a file that is refused as a whole."""
    return DataError(message, where=where, remedy=remedy, faults=(Fault(message),))


def together(errors: Sequence[ScaraIsoError], where: str, what: str = "") -> ScaraIsoError:
    """Return one error with the faults of several files, each named; the only one as it is."""
    if len(errors) == 1:
        return errors[0]
    what = what or f"{len(errors)} tables cannot be read"
    remedies = list(dict.fromkeys(error.remedy for error in errors if error.remedy))
    each = len(remedies) > _REMEDIES
    remedy = "follow the advice below each table" if each else "; ".join(remedies)
    if all(isinstance(error, NoInputError) for error in errors):
        said = "; ".join(error.headline for error in errors)
        return NoInputError(f"{what}: {said}", where=where, remedy=remedy)
    faults = [fault for error in errors for fault in _named(error, remedy=each)]
    return DataError(what, where=where, remedy=remedy, faults=faults)


def _named(error: ScaraIsoError, *, remedy: bool) -> list[Fault]:
    lines = list(error.fault_lines()) if isinstance(error, DataError) else []
    lines += [error.remedy] if remedy and error.remedy else []
    below = (Fault(f"{error.where}: {line.strip()}") for line in lines)
    return [Fault(error.headline), *below]


def quoted(text: str, most: int = _SHOWN) -> str:
    """Return ``text`` quoted, escaped and cut for a message."""
    return repr(text if len(text) <= most else text[:most] + "…")


def listed(items: Iterable[str]) -> str:
    """Return ``a, b and c``."""
    *head, last = items
    return f"{', '.join(head)} and {last}" if head else last


NAME_CONDITION = "; a condition of the test is named in '# covariates: {}' above the header"
LEAVE_ROWS_OUT = "remove the rows that do not count"
LEAVE_OUT = f"{LEAVE_ROWS_OUT} (`allow_gaps=`), and the"
OF_COLUMNS = {
    Subject.ZERO: "subtract the zero from the readings, and remove the column",
    Subject.SIDE: "call it approach where it is the side that the pose is approached from (+1, -1)"
    + NAME_CONDITION,
    Subject.EXCLUDED: f"{LEAVE_OUT} column" + NAME_CONDITION,
    Subject.UNCERTAINTY: "write the standard uncertainty above the header, as "
    "'# indicator_uncertainty: 0.002 mm', and remove the column",
    Subject.SCALE: "multiply the readings by it, and remove the column" + NAME_CONDITION,
    Subject.UNIT: "write the unit above the header, as '# unit: mm', and remove the column; "
    "readings in several units want a table each" + NAME_CONDITION,
}
"""What to do about a column whose heading speaks of it, called {}."""
NUMBER_CYCLES = (
    "write the cycle's number, 1 and up, in each row of a visit; remove a mean, a limit or a total"
)
STRUCK = " (struck through)"
"""Behind a workbook's cell that is struck through."""
