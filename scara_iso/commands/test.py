"""`test`: the whole test as a folder, and how far it is."""

from __future__ import annotations

import shlex
from datetime import datetime
from functools import partial
from pathlib import Path

import typer

from scara_iso import reporting, testfolder
from scara_iso.commands.app import Command
from scara_iso.commands.plan import POSED, new_test
from scara_iso.commands.shared.options import (
    Asked,
    argument,
    option,
    read_numbers,
    takes_options_of,
)
from scara_iso.commands.shared.output import Answer, write_result, write_text
from scara_iso.testfolder import Folder, read_folder

test_app = typer.Typer(help="Keep a whole test in a folder: make it, and see what is recorded.")

_PERCENT = "Per cent of the rated one, each of them tested [100]."
_DIRECTORY = argument("Folder of the test.", "DIR", Path)


@test_app.command("new", cls=Command)
@takes_options_of(
    new_test,
    folder=_DIRECTORY,
    model=option("Model file of the robot.", metavar="MODEL"),
    poses=option("Poses taught, where there is no model.", metavar="P1,P2,..."),
    velocities=option(_PERCENT, read=partial(read_numbers, "--velocities"), metavar="PERCENT,.."),
    loads=option(_PERCENT, read=partial(read_numbers, "--loads"), metavar="PERCENT,.."),
    **POSED,
)
def new_command(asked: Asked[Path], *, json: bool = False) -> None:
    """Write DIR/test.toml from the plan of a model, or for the poses that are taught.

    Example: scara-iso test new acceptance --model examples/fum_scara.toml --velocities 100,50
    """
    file, found = asked.result(), read_folder(asked["folder"])
    if json:
        write_result(testfolder.published_status(found))
        return
    write_text(
        f"{file}: {len(found.parts)} parts; look at it, and state what it leaves open\n"
        f"Now: scara-iso record {shlex.quote(str(found.path))} --gauge AXIS=DRIVER@PORT\n",
        None,
    )


@test_app.command("status", cls=Command)
@takes_options_of(read_folder, "json", path=_DIRECTORY)
def status_command(asked: Asked[Folder]) -> Answer:
    """Show what is recorded, missing, struck, out of its conditions, and what comes next.

    Example: scara-iso test status acceptance
    """
    found, today = asked.result(), datetime.now().astimezone().date()
    report = partial(reporting.status_report, found, today)
    return Answer(testfolder.published_status(found), report)
