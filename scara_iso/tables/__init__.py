"""A technician's file to a `Run` and back.

`read_table` takes what is really sent (interface: "Table of readings") and gives the same numbers
or a `DataError` with every fault: never a number in silence that could be another. `write_table`
gives the canonical form.
"""

from scara_iso.tables.locale import PLAIN, Digits, SheetLocale, find_locale, write_rows
from scara_iso.tables.read import read_table
from scara_iso.tables.source import Source, read_bytes
from scara_iso.tables.write import write_table

__all__ = [
    "PLAIN",
    "Digits",
    "SheetLocale",
    "Source",
    "find_locale",
    "read_bytes",
    "read_table",
    "write_rows",
    "write_table",
]
