"""`test`: the whole test as a folder, and how far it is."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from scara_iso.base.errors import UsageError
from scara_iso.commands.options import AsJson
from scara_iso.commands.output import write_json, write_report, write_text
from scara_iso.commands.plan import ElbowOption, PlaneName, PlaneOption, SolidName, SolidOption
from scara_iso.commands.program import Command

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of the test.")]
Model = Annotated[str, typer.Option("--model", metavar="MODEL", help="The robot's model file.")]
Percents = Annotated[str, typer.Option(metavar="PERCENT,..", help="In per cent of the rated one.")]
Dwell = Annotated[float, typer.Option(help="Seconds at each pose before its reading.")]
test_app = typer.Typer(help="The whole test as a folder: make one, and see how far it is.")


@test_app.command("new", cls=Command)
def new_command(
    folder: Directory,
    *,
    model: Model,
    velocities: Percents = "100",
    loads: Percents = "100",
    solid: SolidOption = SolidName.CUBE,
    plane: PlaneOption = PlaneName.C1,
    elbow: ElbowOption = None,
    dwell: Dwell = 2.0,
    json: AsJson = False,
) -> None:
    """Write DIR/test.toml from the plan of a model: poses, velocities, loads, what to state.

    Example: scara-iso test new acceptance --model examples/fum_scara.toml --velocities 100,50
    """
    from scara_iso.commands.plan import new_test
    from scara_iso.testfolder import read_folder

    file = new_test(
        folder,
        model,
        velocities=_percents("--velocities", velocities),
        loads=_percents("--loads", loads),
        solid=solid.value,
        plane=plane.value,
        elbow=None if elbow is None else elbow.value,
        dwell=dwell,
    )
    if json:
        from scara_iso.base.published import to_json
        from scara_iso.testfolder import published_status

        write_json(to_json(published_status(read_folder(folder))))
        return
    parts = len(read_folder(folder).parts)
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
    from scara_iso.testfolder import read_folder

    found = read_folder(folder)
    if json:
        from scara_iso.base.published import to_json
        from scara_iso.testfolder import published_status

        write_json(to_json(published_status(found)))
    else:
        from scara_iso.reporting import status_report

        write_report(status_report(found, datetime.now().astimezone().date()))


def _percents(option: str, text: str) -> list[float]:
    from scara_iso.base.quantities import parse_number

    found = [parse_number(part.strip().removesuffix("%")) for part in text.split(",")]
    numbers = [number for number in found if number is not None]
    if len(numbers) < len(found):
        raise UsageError(f"{option} {text!r} is no list of numbers", remedy="write 100,50,10")
    return numbers
