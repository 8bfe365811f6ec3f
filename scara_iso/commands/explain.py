"""`explain`: what a finding, a characteristic or an effect means."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from scara_iso import reporting, robot
from scara_iso.commands.options import Asked, argument, takes_options_of
from scara_iso.commands.output import write_answer
from scara_iso.reporting import PublishedPages


def _pages(code: str | None = None, own_effects: str | Path | None = None) -> PublishedPages:
    own = () if own_effects is None else robot.read_effects(own_effects)
    found = reporting.pages(own) if code is None else reporting.find_pages(code, own)
    return PublishedPages(schema="scara-iso/explain/1", pages=found)


def _codes() -> Sequence[str]:
    return list(dict.fromkeys(page.code for page in reporting.pages()))


@takes_options_of(
    _pages,
    code=argument(
        "A finding, characteristic or effect; none lists all.",
        "CODE",
        autocompletion=_codes,
        show_default=False,
    ),
)
def explain_command(asked: Asked[PublishedPages], *, json: bool = False) -> None:
    """Say what a finding, a characteristic or an effect means, and what to do.

    Example: scara-iso explain coarse-resolution
    """
    found = asked.result()
    shown = reporting.list_report if asked["code"] is None else reporting.pages_report
    write_answer(found, lambda: shown(found.pages), json=json)
