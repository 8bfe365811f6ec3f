"""``scara-iso selftest``: whether this program gives the references, on this machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from scara_iso import library, reporting
from scara_iso.base.published import to_json
from scara_iso.cli.options import NOT_WITHIN_LIMITS, AsJson, Full
from scara_iso.cli.output import check_outputs, say_written, write_json, write_report

Record = Annotated[
    Path | None,
    typer.Option(
        "--report",
        metavar="FILE",
        help="The record to sign, by its ending: .html .md .csv .xlsx .pdf.",
    ),
]


def selftest_command(*, report: Record = None, full: Full = False, json: AsJson = False) -> None:
    """Compare this installation with references: exit 0, or 1 naming what differs.

    For the record that ISO/IEC 17025 7.11.2 asks for before software is used.

    Example: scara-iso selftest --report validation.html
    """
    check_outputs([report], [])
    found = library.selftest(report)
    if json:
        from scara_iso.validation import published_validation

        write_json(to_json(published_validation(found)))
    else:
        show = reporting.validation_report if full else reporting.validation_brief
        write_report(show(found))
    say_written(report, aside=json)
    if found.verdict != "pass":
        raise typer.Exit(NOT_WITHIN_LIMITS)
