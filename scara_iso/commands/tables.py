"""`tables`: what is understood of a table, and the canonical table from it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from scara_iso import reporting, tables
from scara_iso.commands.inputs import TableOptions
from scara_iso.commands.options import AsJson, ConditionName, ExcelLocale, TableNames, takes_tables
from scara_iso.commands.output import check_outputs, write_report, write_result, write_text

Output = Annotated[
    Path | None, typer.Option("-o", "--output", help="Write the table in its canonical form.")
]


@takes_tables
def tables_command(
    table: TableNames,
    *,
    reading: TableOptions,
    output: Output = None,
    condition: ConditionName = None,
    excel_locale: ExcelLocale = None,
    json: AsJson = False,
) -> None:
    """Show what is understood of a table, field by field, or why it is refused and what to do.

    Example: scara-iso tables examples/fum_scara_table1.csv -o run.csv
    """
    check_outputs([output], table)
    run = reading.read(table, condition)
    if output is not None:
        write_text(tables.write_table(run, tables.find_locale(excel_locale)), output)
    if json:
        write_result(tables.published_table(run))
    else:
        write_report(reporting.table_report(run))
