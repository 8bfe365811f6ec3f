"""`backlash`: the paper's two-inertia model."""

from __future__ import annotations

from dataclasses import replace
from typing import Unpack

from scara_iso import diagnosis, reporting, robot
from scara_iso.base.errors import DataError
from scara_iso.commands.shared.options import Asked, option, takes_options_of
from scara_iso.commands.shared.output import write_report, write_result
from scara_iso.iso9283 import CountingOptions, PoseResult
from scara_iso.robot import Backlash


@takes_options_of(
    robot.backlash,
    Im=option("Inertia of motor and gear [kg m2].", "--Im"),
    IL=option("Inertia of the load [kg m2].", "--IL"),
    arcmin=option("Full gap at the output [arcmin]."),
    arm=option("Distance from joint to tool [m]."),
    ratio=option("Gear ratio N: adds the deviation with N^2 I_m."),
    actual=option("Table of readings to compare with the model.", metavar="TABLE"),
    measured=option("Table of reversals measured at several inertias.", metavar="SWEEP"),
)
def backlash_command(
    asked: Asked[Backlash],
    *,
    actual: str | None = None,
    measured: str | None = None,
    decimal: str | None = None,
    json: bool = False,
    **counting: Unpack[CountingOptions],
) -> None:
    """Compute the load's deviation through a gear's backlash, by the paper's model.

    Example: scara-iso backlash --Im 2.65e-4 --IL 4.749 --arcmin 12 --arm 0.7 --ratio 50
    """
    result = asked.result()
    pose = None if actual is None else _one_pose(actual, decimal, counting)
    closed = None
    if measured is not None:
        read = diagnosis.read_sweep(measured, decimal=decimal)
        closed = diagnosis.diagnose_sweep(read.sweep, read.deviation, uncertainty=read.uncertainty)
        closed = replace(closed, notes=(*read.notes, *closed.notes))
    if json:
        write_result(diagnosis.BacklashResult(result, pose, closed))
        return
    write_report(reporting.backlash_report(result, pose), full=True)
    if closed is not None:
        write_report(reporting.sweep_report(closed))


def _one_pose(table: str, decimal: str | None, counting: CountingOptions) -> PoseResult:
    from scara_iso import analyze

    poses = analyze(table, decimal=decimal, **counting).poses
    if len(poses) > 1 or poses[0].XY is None:
        raise DataError(
            "--actual takes a table of one pose with X and Y as lengths",
            where=table,
            remedy="leave the other poses out",
        )
    return poses[0]
