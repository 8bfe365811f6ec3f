"""`demo`: the paper's robot, from its table to its backlash."""

from __future__ import annotations

import sys
import webbrowser
from pathlib import Path
from tempfile import mkdtemp

from scara_iso import diagnosis, reporting, robot
from scara_iso.commands.analyze import analyze
from scara_iso.commands.shared.options import option, takes_options_of
from scara_iso.commands.shared.output import write_report, write_result

NEXT_STEPS = (
    "scara-iso analyze YOUR_TABLE.csv --limit XY=0.02",
    "scara-iso backlash --Im 2.65e-4 --IL 4.749 --arcmin 12 --arm 0.7 --ratio 50",
    "scara-iso --help",
)


@takes_options_of(None, open_report=option("Open its report in the browser.", "--open"))
def demo_command(*, open_report: bool = False, full: bool = False, json: bool = False) -> None:
    """Walk through the paper's Table I: analysis, backlash, which printed figures follow.

    Example: scara-iso demo --open
    """
    analysis = analyze(robot.table_1())
    pose, gear = analysis.poses[0], robot.first_joint()
    if json:
        backlash = diagnosis.BacklashResult(gear, pose)
        write_result(reporting.PublishedDemo(analysis=analysis, backlash=backlash))
        return
    following = (
        reporting.NextStep("scara-iso record", "read your own indicators; it asks what it needs")
        if open_report
        else reporting.NextStep("scara-iso demo --open", "the report of it in the browser")
    )
    found = (
        *reporting.analysis_report(analysis, following),
        *reporting.backlash_report(gear, pose),
    )
    write_report(found, full=full)
    try_next = reporting.Section("try next", tuple(map(reporting.Text, NEXT_STEPS)))
    write_report((reporting.paper_section(pose, gear), try_next))
    if open_report:
        _open_report()


def _open_report() -> None:
    from scara_iso.commands.report import report

    page = Path(mkdtemp(prefix="scara-iso-")) / "fum_scara.html"
    report(robot.table_1(), to=page)
    opened = webbrowser.open(page.as_uri())
    sys.stdout.write(f"{page} is {'opened' if opened else 'written: open it in a browser'}\n")
