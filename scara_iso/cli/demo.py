"""``scara-iso demo``: the paper's robot, from its table to its backlash."""

from __future__ import annotations

from scara_iso.cli.output import write_report


def demo_command() -> None:
    """Walk through the paper's Table I: analysis, backlash, what of the print follows from it.

    Example: scara-iso demo
    """
    from scara_iso import analyze
    from scara_iso.paper import first_joint, table_1
    from scara_iso.report.analysis import analysis_report
    from scara_iso.report.backlash import backlash_report
    from scara_iso.report.paper import next_steps, paper_section

    analysis = analyze(table_1())
    pose, gear = analysis.poses[0], first_joint()
    write_report(analysis_report(analysis))
    write_report(backlash_report(gear, pose))
    write_report((paper_section(pose, gear), next_steps()))
