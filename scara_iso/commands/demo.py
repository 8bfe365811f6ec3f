"""`demo`: the paper's robot, from its table to its backlash."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from scara_iso.base.published import to_json
from scara_iso.commands.options import AsJson, Full
from scara_iso.commands.output import write_json, write_report

if TYPE_CHECKING:
    from scara_iso.reporting import Section

NEXT_STEPS = (
    "scara-iso analyze YOUR_TABLE.csv --limit XY=0.02",
    "scara-iso backlash --Im 2.65e-4 --IL 4.749 --arcmin 12 --arm 0.7 --ratio 50",
    "scara-iso --help",
)
Open = Annotated[bool, typer.Option("--open", help="Show the report of it in the browser.")]


def demo_command(*, open_report: Open = False, full: Full = False, json: AsJson = False) -> None:
    """Walk through the paper's Table I: analysis, backlash, what of the print follows from it.

    Example: scara-iso demo --open
    """
    from scara_iso import analyze
    from scara_iso.reporting import (
        NextStep,
        analysis_report,
        backlash_report,
        paper_section,
        published_demo,
    )
    from scara_iso.robot import first_joint, table_1

    analysis = analyze(table_1())
    pose, gear = analysis.poses[0], first_joint()
    if json:
        write_json(to_json(published_demo(analysis, gear)))
        return
    following = (
        NextStep("scara-iso record", "read your own indicators; it asks what it needs")
        if open_report
        else NextStep("scara-iso demo --open", "the report of it in the browser")
    )
    found = (*analysis_report(analysis, following), *backlash_report(gear, pose))
    write_report(found, full=full)
    write_report((paper_section(pose, gear), _next_steps()))
    if open_report:
        _open_report()


def _open_report() -> None:
    import webbrowser
    from pathlib import Path
    from tempfile import mkdtemp

    from scara_iso.commands.report import report
    from scara_iso.robot import table_1

    page = Path(mkdtemp(prefix="scara-iso-")) / "fum_scara.html"
    report(table_1(), to=page)
    opened = webbrowser.open(page.as_uri())
    typer.echo(f"{page} is {'opened' if opened else 'written: open it in a browser'}")


def _next_steps() -> Section:
    from scara_iso.reporting import Section, Text

    return Section("try next", tuple(map(Text, NEXT_STEPS)))
