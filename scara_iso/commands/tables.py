"""`tables`: what is understood of a table, and the canonical table from it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from scara_iso.commands.inputs import TableOptions
from scara_iso.commands.options import AsJson, ConditionName, ExcelLocale, TableNames, takes_tables
from scara_iso.commands.output import check_outputs, write_json, write_report, write_text

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
    from scara_iso.tables import find_locale, write_table

    check_outputs([output], table)
    run = reading.read(table, condition)
    if output is not None:
        write_text(write_table(run, find_locale(excel_locale)), output)
    if json:
        from scara_iso.base.published import to_json
        from scara_iso.tables import published_table

        write_json(to_json(published_table(run)))
    else:
        from scara_iso.reporting import table_report

        write_report(table_report(run))
