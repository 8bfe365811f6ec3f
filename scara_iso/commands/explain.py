"""`explain`: what a finding, a characteristic or an effect means."""

from __future__ import annotations

from typing import Annotated

import typer

from scara_iso.commands.options import AsJson, OwnEffectsFile
from scara_iso.commands.output import write_json, write_report


def _codes() -> list[str]:
    from scara_iso.reporting import pages

    return list(dict.fromkeys(page.code for page in pages()))


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
    from scara_iso.base.published import to_json
    from scara_iso.reporting import PublishedPages, find_pages, list_report, pages, pages_report
    from scara_iso.robot import read_effects

    own = () if effects is None else read_effects(effects)
    wanted = pages(own) if code is None else find_pages(code, own)
    if json:
        write_json(to_json(PublishedPages(schema="scara-iso/explain/1", pages=wanted)))
    else:
        write_report(list_report(wanted) if code is None else pages_report(wanted))
