"""``scara-iso plan``: the test cube, the poses P1 to P5 and how they are visited."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from scara_iso import library, render, reporting
from scara_iso.cli.options import AsJson, ExcelLocale, ModelFile
from scara_iso.cli.output import check_outputs, write_json, write_report, write_text
from scara_iso.errors import UsageError


class SolidName(StrEnum):
    """What is laid into the workspace."""

    CUBE = "cube"
    BOX = "box"


class PlaneName(StrEnum):
    """A diagonal plane by its corners."""

    C1 = "C1-C2-C7-C8"
    C2 = "C2-C3-C8-C5"
    C3 = "C3-C4-C5-C6"
    C4 = "C4-C1-C6-C7"


class ElbowName(StrEnum):
    """Side of the elbow, seen from above."""

    RIGHT = "right"
    LEFT = "left"


SolidOption = Annotated[
    SolidName, typer.Option(help="Largest cube, or largest box where the stroke is short.")
]
PlaneOption = Annotated[PlaneName, typer.Option(help="Diagonal plane.")]
ElbowOption = Annotated[
    ElbowName | None, typer.Option(help="Side of the elbow; else the better one.")
]
ShareOfDiagonal = Annotated[float, typer.Option("--m", help="m over the diagonal L: 0.08 to 0.12.")]
Cycles = Annotated[int, typer.Option(help="Cycles run, the first counted.", min=2)]
Velocity = Annotated[float, typer.Option(help="Percent of the rated velocity.")]
Load = Annotated[float, typer.Option(help="Percent of the rated load.")]
Dwell = Annotated[float, typer.Option(help="Seconds at each pose before its reading.")]
Picture = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Workspace and poses as .svg or .png.")
]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", help="Visits as CSV, for a robot program; FILE.toml: as a test.toml."
    ),
]


def plan_command(
    model: ModelFile,
    *,
    solid: SolidOption = SolidName.CUBE,
    plane: PlaneOption = PlaneName.C1,
    elbow: ElbowOption = None,
    m: ShareOfDiagonal = 0.1,
    cycles: Cycles = 31,
    velocity: Velocity = 100.0,
    load: Load = 100.0,
    dwell: Dwell = 2.0,
    picture: Picture = None,
    output: Output = None,
    excel_locale: ExcelLocale = None,
    json: AsJson = False,
) -> None:
    """Plan the test: largest cube in the workspace, diagonal plane, P1 to P5 with joint angles.

    Example: scara-iso plan examples/fum_scara.toml --picture plan.svg -o visits.csv
    """
    from scara_iso.robot import read_model
    from scara_iso.tables import find_locale

    check_outputs([picture, output], [model])
    locale = find_locale(excel_locale)
    as_test = output is not None and output.suffix.lower() == ".toml"
    if as_test and excel_locale is not None:
        raise UsageError("--excel-locale is for a .csv", remedy="let the name end in .csv")
    described = read_model(model)
    found = library.plan(
        model,
        solid=solid.value,
        plane=plane.value,
        elbow=None if elbow is None else elbow.value,
        m=m,
        cycles=cycles,
        velocity=velocity,
        load=load,
        dwell=dwell,
    )
    if picture is not None:
        render.save_figure(found.plot(), picture)
    if output is not None and as_test:
        library.write_planned_test(output, found, model)
    elif output is not None:
        write_text(reporting.visits_csv(found, locale), output)
    if json:
        write_json(render.plan_json(found))
    else:
        write_report(reporting.plan_report(found, described.robot))
