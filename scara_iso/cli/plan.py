"""``scara-iso plan``: the test cube, P1 to P5 and how they are visited; or separating poses."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scara_iso import library, reporting
from scara_iso.base.errors import UsageError
from scara_iso.base.published import to_json
from scara_iso.cli.options import AsJson, ExcelLocale, ModelFile
from scara_iso.cli.output import (
    check_outputs,
    tell_written,
    write_json,
    write_picture,
    write_report,
    write_text,
)

if TYPE_CHECKING:
    from scara_iso.diagnosis import SeparatingPlan
    from scara_iso.iso9283 import PosePlan

_M = 0.1


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
Separating = Annotated[
    bool, typer.Option("--separating", help="Poses that tell the joints apart, not ISO 9283's.")
]
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
    separating: Separating = False,
    elbow: ElbowOption = None,
    m: ShareOfDiagonal = _M,
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

    check_outputs([output], [model], pictures=[picture])
    robot = read_model(model).robot
    how = _How(None if elbow is None else elbow.value, cycles, velocity, load, dwell)
    files = _Files(picture, output, excel_locale)
    files.check(separating=separating)
    if separating:
        _refuse_beside_separating(solid, plane, m)
        apart = library.plan_separating(model, **asdict(how))
        files.write(apart)
        if json:
            from scara_iso.diagnosis import published_separating_plan

            write_json(to_json(published_separating_plan(apart)))
        else:
            write_report(reporting.separating_report(apart, robot))
        return
    found = library.plan(model, solid=solid.value, plane=plane.value, m=m, **asdict(how))
    files.write(found)
    if output is not None and files.as_test:
        library.write_planned_test(output, found, model)
        tell_written(output)
    if json:
        from scara_iso.iso9283 import published_plan

        write_json(to_json(published_plan(found)))
    else:
        write_report(reporting.plan_report(found, robot))


@dataclass(frozen=True, slots=True)
class _How:
    """What every plan takes, as the library names it."""

    elbow: str | None
    cycles: int
    velocity: float
    load: float
    dwell: float


@dataclass(frozen=True, slots=True)
class _Files:
    """Where a plan is written beside the report."""

    picture: Path | None
    output: Path | None
    excel_locale: str | None

    @property
    def as_test(self) -> bool:
        """Whether the plan is written as a test.toml."""
        return self.output is not None and self.output.suffix.lower() == ".toml"

    def check(self, *, separating: bool) -> None:
        """Raise `UsageError` for a test.toml of what is none, or with a locale.

        `CannotCreateError` for one that is there already.
        """
        if self.output is not None and self.as_test:
            library.refuse_existing_test(self.output)
        if self.as_test and self.excel_locale is not None:
            raise UsageError("--excel-locale is for a .csv", remedy="let the name end in .csv")
        if self.as_test and separating:
            raise UsageError(
                "separating poses are no test of ISO 9283", remedy="let the name end in .csv"
            )

    def write(self, found: PosePlan | SeparatingPlan) -> None:
        """Write the picture, and the visits as CSV."""
        from scara_iso.tables import find_locale

        write_picture(found, self.picture)
        if self.output is not None and not self.as_test:
            write_text(reporting.visits_csv(found, find_locale(self.excel_locale)), self.output)


def _refuse_beside_separating(solid: SolidName, plane: PlaneName, m: float) -> None:
    """Raise `UsageError` where something is wanted that only the test of ISO 9283 has."""
    given = {
        "--solid": solid is not SolidName.CUBE,
        "--plane": plane is not PlaneName.C1,
        "--m": m != _M,
    }
    for option, changed in given.items():
        if changed:
            raise UsageError(
                f"{option} is of the test of ISO 9283, and --separating lays no cube",
                remedy="leave one of them out",
            )
