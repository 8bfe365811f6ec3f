"""`tables`: what is understood of a table, and the canonical table from it."""

from __future__ import annotations

from pathlib import Path
from typing import Unpack

from scara_iso import reporting, tables
from scara_iso.commands.inputs import ReadingOptions, TableOptions, Tables
from scara_iso.commands.options import Asked, ExcelName, option, takes_options_of
from scara_iso.commands.output import check_outputs, write_answer, write_text
from scara_iso.run import Run


def _read(table: Tables, *, condition: str | None = None, **reading: Unpack[ReadingOptions]) -> Run:
    return TableOptions(**reading).read(table, condition)


@takes_options_of(_read, output=option("Write the table in its canonical form.", "-o", "--output"))
def tables_command(
    asked: Asked[Run],
    *,
    output: Path | None = None,
    excel_locale: ExcelName | None = None,
    json: bool = False,
) -> None:
    """Show what is understood of a table, field by field, or why it is refused and what to do.

    Example: scara-iso tables examples/fum_scara_table1.csv -o run.csv
    """
    check_outputs([output], asked["table"])
    run = asked.result()
    if output is not None:
        write_text(tables.write_table(run, tables.find_locale(excel_locale)), output)
    found = tables.published_table(run) if json else run
    write_answer(found, lambda: reporting.table_report(run), json=json)
