"""`explain`: what a finding, a characteristic or an effect means."""

from __future__ import annotations

from scara_iso import reporting
from scara_iso.commands.shared.inputs import load_effects
from scara_iso.commands.shared.options import argument, takes_options_of
from scara_iso.commands.shared.output import Answer
from scara_iso.reporting import PublishedPages


@takes_options_of(
    None,
    "json",
    code=argument(
        "Finding, characteristic, effect or term of a screen; without it all are listed.",
        "TERM",
        list[str] | None,
        autocompletion=lambda: list(dict.fromkeys(page.code for page in reporting.pages())),
        show_default=False,
    ),
)
def explain_command(code: list[str] | None = None, *, own_effects: str | None = None) -> Answer:
    """Explain a finding, a characteristic, an effect or a term, and what to do.

    Example: scara-iso explain coarse-resolution
    """
    own = load_effects(own_effects)
    pages = reporting.find_pages(" ".join(code), own) if code else reporting.pages(own)
    show = reporting.pages_report if code else reporting.list_report
    published = PublishedPages(schema="scara-iso/explain/1", pages=pages)
    return Answer(published, lambda: show(pages))
