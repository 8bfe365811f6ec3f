"""`tables`: what is understood of a table, and the canonical table from it."""

from __future__ import annotations

from pathlib import Path
from typing import Unpack

from scara_iso import reporting, tables
from scara_iso.base.files import write_file
from scara_iso.commands.shared.inputs import ReadingOptions, read_run
from scara_iso.commands.shared.options import ExcelName, output_file, takes_options_of
from scara_iso.commands.shared.output import Answer, check_outputs


@takes_options_of(None, "json", output=output_file("Write the table in its canonical form."))
def tables_command(
    table: list[str],
    *,
    condition: str | None = None,
    output: Path | None = None,
    excel_locale: ExcelName | None = None,
    **reading: Unpack[ReadingOptions],
) -> Answer:
    """Show how a table is read, field by field, or why it is refused and what to do.

    Example: scara-iso tables examples/fum_scara_table1.csv -o run.csv
    """
    check_outputs([], table, tables=[output])
    run = read_run(table, reading, condition)
    if output is not None:
        text = tables.write_table(run, tables.find_locale(excel_locale))
        write_file(output, text.encode("utf-8", "backslashreplace"))
    return Answer(tables.published_table(run), lambda: reporting.table_report(run), output)
