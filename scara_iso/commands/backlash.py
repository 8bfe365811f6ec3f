"""`backlash`: the paper's two-inertia model."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from scara_iso import diagnosis, reporting
from scara_iso.base.errors import DataError
from scara_iso.commands.options import AsJson, DecimalMark, takes_tables
from scara_iso.commands.output import write_report, write_result
from scara_iso.iso9283 import Counting

if TYPE_CHECKING:
    from scara_iso.diagnosis import GearDiagnosis
    from scara_iso.iso9283 import PoseResult

MotorInertia = Annotated[float, typer.Option("--Im", help="Inertia of motor and gear [kg m2].")]
LoadInertia = Annotated[float, typer.Option("--IL", help="Inertia of the load [kg m2].")]
Gap = Annotated[float, typer.Option("--arcmin", help="Full gap at the output [arcmin].")]
ArmLength = Annotated[float | None, typer.Option("--arm", help="Joint to tool [m].")]
Ratio = Annotated[float | None, typer.Option("--ratio", help="Gear ratio N: also with N^2 I_m.")]
Actual = Annotated[
    str | None,
    typer.Option("--actual", metavar="TABLE", help="A table of readings to set beside it."),
]
MeasurementSeries = Annotated[
    str | None,
    typer.Option("--measured", metavar="SWEEP", help="Reversals measured at several inertias."),
]


@takes_tables
def backlash_command(
    *,
    Im: MotorInertia,
    IL: LoadInertia,
    arcmin: Gap,
    arm: ArmLength = None,
    ratio: Ratio = None,
    actual: Actual = None,
    measured: MeasurementSeries = None,
    decimal: DecimalMark = None,
    counting: Counting,
    json: AsJson = False,
) -> None:
    """Deviation of the load through a gear's backlash, by the paper's model.

    Example: scara-iso backlash --Im 2.65e-4 --IL 4.749 --arcmin 12 --arm 0.7 --ratio 50
    """
    from scara_iso import backlash

    result = backlash(Im=Im, IL=IL, arcmin=arcmin, arm=arm, ratio=ratio)
    pose = None
    if actual is not None:
        pose = _one_pose(actual, decimal, counting)
    closed = None if measured is None else _closed(measured, decimal)
    if json:
        write_result(diagnosis.BacklashResult(result, pose, closed))
    else:
        write_report(reporting.backlash_report(result, pose), full=True)
        if closed is not None:
            write_report(reporting.sweep_report(closed))


def _closed(sweep: str, decimal: str | None) -> GearDiagnosis:
    """Return what eq. 16 leaves of a measured sweep, and which effect on the gear it is."""
    from dataclasses import replace

    found = diagnosis.read_sweep(sweep, decimal=decimal)
    closed = diagnosis.diagnose_sweep(found.sweep, found.deviation, uncertainty=found.uncertainty)
    return replace(closed, notes=(*found.notes, *closed.notes))


def _one_pose(table: str, decimal: str | None, counting: Counting) -> PoseResult:
    """Return the figures of a table of one pose."""
    from scara_iso import analyze, read_table

    poses = analyze(read_table(table, decimal=decimal), **asdict(counting)).poses
    if len(poses) > 1 or poses[0].XY is None:
        raise DataError(
            "--actual takes a table of one pose with X and Y as lengths",
            where=table,
            remedy="leave the other poses out",
        )
    return poses[0]
