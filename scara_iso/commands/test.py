"""`test`: the whole test as a folder, and how far it is."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from pathlib import Path

import typer

from scara_iso import reporting, testfolder
from scara_iso.base.errors import UsageError
from scara_iso.base.quantities import parse_number
from scara_iso.commands.app import Command
from scara_iso.commands.options import Asked, argument, option, takes_options_of
from scara_iso.commands.output import write_answer, write_result, write_text
from scara_iso.commands.plan import DWELL, ELBOW, PLANE, SOLID, new_test
from scara_iso.iso9283 import DiagonalPlane, Solid
from scara_iso.robot import Elbow
from scara_iso.testfolder import Folder, read_folder

test_app = typer.Typer(help="The whole test as a folder: make one, and see how far it is.")


def _percents(name: str) -> Callable[[str], list[float]]:
    def read(text: str) -> list[float]:
        found = [parse_number(part.strip().removesuffix("%")) for part in text.split(",")]
        numbers = [number for number in found if number is not None]
        if len(numbers) < len(found):
            raise UsageError(f"{name} {text!r} is no list of numbers", remedy="write 100,50,10")
        return numbers

    return read


_DIRECTORY = argument("Folder of the test.", "DIR", Path)


@test_app.command("new", cls=Command)
@takes_options_of(
    new_test,
    folder=_DIRECTORY,
    model=option("The robot's model file.", metavar="MODEL"),
    poses=option(
        "Without a model: the poses taught.",
        read=lambda text: [name.strip() for name in text.split(",")],
        metavar="P1,P2,...",
    ),
    velocities=option(
        "In per cent of the rated one [100].",
        read=_percents("--velocities"),
        metavar="PERCENT,..",
    ),
    loads=option(
        "In per cent of the rated one [100].",
        read=_percents("--loads"),
        metavar="PERCENT,..",
    ),
    solid=SOLID,
    plane=PLANE,
    elbow=ELBOW,
    dwell=DWELL,
)
def new_command(
    asked: Asked[Path],
    *,
    solid: Solid = Solid.CUBE,
    plane: DiagonalPlane = DiagonalPlane.C1_C2_C7_C8,
    elbow: Elbow | None = None,
    dwell: float = 2.0,
    json: bool = False,
) -> None:
    """Write DIR/test.toml from the plan of a model, or for the poses that are taught.

    Example: scara-iso test new acceptance --model examples/fum_scara.toml --velocities 100,50
    """
    given: dict[str, object] = {"solid": solid, "plane": plane, "elbow": elbow}
    usual = {"solid": Solid.CUBE.value, "plane": DiagonalPlane.C1_C2_C7_C8.value, "elbow": None}
    planned = {name: one for name, one in given.items() if asked["model"] or one != usual[name]}
    file = asked.result(dwell=dwell, **planned)
    found = read_folder(asked["folder"])
    if json:
        write_result(testfolder.published_status(found))
        return
    write_text(
        f"{file}: {len(found.parts)} parts; look at it, and state what it leaves open\n"
        f"Now: scara-iso record {found.path} --gauge AXIS=DRIVER@PORT\n",
        None,
    )


@test_app.command("status", cls=Command)
@takes_options_of(read_folder, path=_DIRECTORY)
def status_command(asked: Asked[Folder], *, json: bool = False) -> None:
    """Show what is recorded, missing, struck, out of its conditions, and what comes next.

    Example: scara-iso test status acceptance
    """
    found, today = asked.result(), datetime.now().astimezone().date()
    write_answer(
        testfolder.published_status(found) if json else found,
        lambda: reporting.status_report(found, today),
        json=json,
    )
