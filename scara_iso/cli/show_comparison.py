"""How a comparison is shown: its answer, or all of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from scara_iso import reporting
from scara_iso.cli.output import write_report

if TYPE_CHECKING:
    from scara_iso.comparison import Comparison


def show_comparison(comparison: Comparison, again: Sequence[str], *, full: bool) -> None:
    """Write a comparison; ``again`` are the command lines of its tables, without the command."""
    if full:
        write_report(reporting.comparison_report(comparison))
    else:
        write_report(reporting.comparison_brief(comparison, again))
