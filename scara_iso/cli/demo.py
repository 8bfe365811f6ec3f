"""``scara-iso demo``: the paper's robot, from its table to its backlash."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scara_iso.cli.options import AsJson
from scara_iso.cli.output import write_json, write_report

if TYPE_CHECKING:
    from scara_iso.reporting import Section

NEXT_STEPS = (
    "scara-iso analyze YOUR_TABLE.csv --limit XY=0.02",
    "scara-iso analyze YOUR_TABLE.csv --definitions",
    "scara-iso backlash --Im 2.65e-4 --IL 4.749 --arcmin 12 --arm 0.7 --ratio 50",
    "scara-iso --help",
)


def demo_command(*, json: AsJson = False) -> None:
    """Walk through the paper's Table I: analysis, backlash, what of the print follows from it.

    Example: scara-iso demo
    """
    from scara_iso import analyze
    from scara_iso.render import analysis_json, backlash_json
    from scara_iso.reporting import analysis_report, backlash_report, paper_section
    from scara_iso.robot import first_joint, printed, table_1

    analysis = analyze(table_1())
    pose, gear = analysis.poses[0], first_joint()
    if json:
        write_json(
            {
                "schema": "scara-iso/demo/1",
                "analysis": analysis_json(analysis),
                "backlash": backlash_json(gear, pose),
                "printed": printed(),
            }
        )
        return
    write_report(analysis_report(analysis))
    write_report(backlash_report(gear, pose))
    write_report((paper_section(pose, gear), _next_steps()))


def _next_steps() -> Section:
    from scara_iso.reporting import Section, Text

    return Section("try next", tuple(map(Text, NEXT_STEPS)))
