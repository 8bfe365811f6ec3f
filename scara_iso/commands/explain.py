"""`explain`: what a finding, a characteristic or an effect means."""

from __future__ import annotations

from typing import Annotated

import typer

from scara_iso import reporting, robot
from scara_iso.commands.options import AsJson, OwnEffectsFile
from scara_iso.commands.output import write_report, write_result


def _codes() -> list[str]:

    return list(dict.fromkeys(page.code for page in reporting.pages()))


Code = Annotated[
    str | None,
    typer.Argument(
        metavar="CODE",
        help="A finding, characteristic or effect; none lists all.",
        autocompletion=_codes,
        show_default=False,
    ),
]


def explain_command(
    code: Code = None, *, effects: OwnEffectsFile = None, json: AsJson = False
) -> None:
    """Say what a finding, a characteristic or an effect means, and what to do.

    Example: scara-iso explain coarse-resolution
    """
    own = () if effects is None else robot.read_effects(effects)
    wanted = reporting.pages(own) if code is None else reporting.find_pages(code, own)
    if json:
        write_result(reporting.PublishedPages(schema="scara-iso/explain/1", pages=wanted))
    else:
        write_report(
            reporting.list_report(wanted) if code is None else reporting.pages_report(wanted)
        )
