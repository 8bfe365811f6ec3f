"""`test`: the whole test as a folder, and how far it is."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from scara_iso import reporting, testfolder
from scara_iso.base.errors import UsageError
from scara_iso.commands.app import Command
from scara_iso.commands.options import AsJson
from scara_iso.commands.output import write_report, write_result, write_text
from scara_iso.commands.plan import ElbowOption, PlaneOption, SolidOption
from scara_iso.iso9283 import DiagonalPlane, Solid

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of the test.")]
Model = Annotated[
    str | None, typer.Option("--model", metavar="MODEL", help="The robot's model file.")
]
Poses = Annotated[
    str | None, typer.Option(metavar="P1,P2,...", help="Without a model: the poses taught.")
]
Percents = Annotated[str, typer.Option(metavar="PERCENT,..", help="In per cent of the rated one.")]
Dwell = Annotated[float, typer.Option(help="Seconds at each pose before its reading.")]
test_app = typer.Typer(help="The whole test as a folder: make one, and see how far it is.")


@test_app.command("new", cls=Command)
def new_command(
    folder: Directory,
    *,
    model: Model = None,
    poses: Poses = None,
    velocities: Percents = "100",
    loads: Percents = "100",
    solid: SolidOption = Solid.CUBE,
    plane: PlaneOption = DiagonalPlane.C1_C2_C7_C8,
    elbow: ElbowOption = None,
    dwell: Dwell = 2.0,
    json: AsJson = False,
) -> None:
    """Write DIR/test.toml from the plan of a model, or for the poses that are taught.

    Example: scara-iso test new acceptance --model examples/fum_scara.toml --velocities 100,50
    """
    from scara_iso.commands.plan import new_test

    given = {
        "solid": solid.value,
        "plane": plane.value,
        "elbow": None if elbow is None else elbow.value,
    }
    usual = {"solid": Solid.CUBE.value, "plane": DiagonalPlane.C1_C2_C7_C8.value, "elbow": None}
    named = {name: one for name, one in given.items() if model or one != usual[name]}
    file = new_test(
        folder,
        model,
        poses=None if poses is None else [name.strip() for name in poses.split(",")],
        velocities=_percents("--velocities", velocities),
        loads=_percents("--loads", loads),
        dwell=dwell,
        **named,
    )
    if json:
        write_result(testfolder.published_status(testfolder.read_folder(folder)))
        return
    parts = len(testfolder.read_folder(folder).parts)
    write_text(
        f"{file}: {parts} parts; look at it, and state what it leaves open\n"
        f"Now: scara-iso record {folder} --gauge AXIS=DRIVER@PORT\n",
        None,
    )


@test_app.command("status", cls=Command)
def status_command(folder: Directory, *, json: AsJson = False) -> None:
    """Show what is recorded, missing, struck, out of its conditions, and what comes next.

    Example: scara-iso test status acceptance
    """
    found = testfolder.read_folder(folder)
    if json:
        write_result(testfolder.published_status(found))
    else:
        write_report(reporting.status_report(found, datetime.now().astimezone().date()))


def _percents(option: str, text: str) -> list[float]:
    from scara_iso.base.quantities import parse_number

    found = [parse_number(part.strip().removesuffix("%")) for part in text.split(",")]
    numbers = [number for number in found if number is not None]
    if len(numbers) < len(found):
        raise UsageError(f"{option} {text!r} is no list of numbers", remedy="write 100,50,10")
    return numbers
