"""`plan` and `plan_separating`: where a test is made, and its test.toml."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer

from scara_iso import reporting, tables
from scara_iso.base.disk import check_folder, check_output, write_file
from scara_iso.base.errors import CannotCreateError, UsageError
from scara_iso.commands.inputs import described
from scara_iso.commands.options import AsJson, ExcelLocale, ModelFile
from scara_iso.commands.output import (
    check_outputs,
    tell_written,
    write_picture,
    write_report,
    write_result,
    write_text,
)
from scara_iso.diagnosis import GIVEN, STANDARD, SeparatingPlan, separating_plan
from scara_iso.iso9283 import (
    CYCLES_RUN,
    DiagonalPlane,
    PosePlan,
    PoseTestConditions,
    Solid,
    make_plan,
)
from scara_iso.robot import (
    Arm,
    Elbow,
    Model,
    read_model,
)
from scara_iso.testfolder import FILE, WholeTest, plan_test, taught_test, toml_of

_Word = TypeVar("_Word", Solid, DiagonalPlane, Elbow)


def plan(
    model: Model | str | Path,
    *,
    solid: str = Solid.CUBE.value,
    plane: str = DiagonalPlane.C1_C2_C7_C8.value,
    elbow: str | None = None,
    m: float = 0.1,
    cycles: int = CYCLES_RUN,
    velocity: float = 100.0,
    load: float = 100.0,
    dwell: float = 2.0,
) -> PosePlan:
    """Return the test of a model's arm: largest cube, diagonal plane, P1 to P5 with joint angles.

    ``solid`` is ``cube`` or ``box``; ``plane`` names its corners (``C1-C2-C7-C8``...); ``elbow`` is
    ``right`` or ``left``, else the better one; ``m`` is eq. 1's m over the diagonal L, 0.08 to
    0.12; ``velocity`` and ``load`` are percent of the rated ones, ``dwell`` seconds at each pose.
    Raises `UsageError` where a word is not known, the model holds no arm, or no cube fits.
    """
    known, arm = _with_arm(model)
    conditions = PoseTestConditions(
        cycles=cycles, velocity_percent=velocity, load_percent=load, dwell_s=dwell
    )
    return make_plan(
        arm,
        solid=_named(Solid, "solid", solid),
        plane=_named(DiagonalPlane, "plane", plane),
        elbow=None if elbow is None else _named(Elbow, "elbow", elbow),
        m_over_diagonal=m,
        conditions=conditions,
        rated=known.rated,
    )


def plan_separating(
    model: Model | str | Path,
    *,
    elbow: str | None = None,
    cycles: int = CYCLES_RUN,
    velocity: float = 100.0,
    load: float = 100.0,
    dwell: float = 2.0,
) -> SeparatingPlan:
    """Return five poses at which the joints of a model's arm are told apart best.

    They are no poses of ISO 9283. Beside them stand the model's own poses and those of `plan`, as
    far as there are any. Options as in `plan`. Raises `UsageError` where a word is not known, the
    model holds no arm, or its limits leave no room for such poses.
    """
    known, arm = _with_arm(model)
    conditions = PoseTestConditions(
        cycles=cycles, velocity_percent=velocity, load_percent=load, dwell_s=dwell
    )
    side = None if elbow is None else _named(Elbow, "elbow", elbow)
    given = {GIVEN: [*known.poses.values()], STANDARD: _standard(arm, side)}
    others = {name: poses for name, poses in given.items() if poses}
    return separating_plan(arm, others, elbow=side, conditions=conditions, rated=known.rated)


def _standard(arm: Arm, elbow: Elbow | None) -> list[tuple[float, float]]:
    """Return joints 1 and 2 of the standard's poses; none where no cube fits."""
    try:
        return [(one.joint_1_deg, one.joint_2_deg) for one in make_plan(arm, elbow=elbow).poses]
    except UsageError:
        return []


def _with_arm(model: Model | str | Path) -> tuple[Model, Arm]:
    known = described(model)
    if known.arm is None:
        named = "the model" if isinstance(model, Model) else str(model)
        raise UsageError(f"{named} holds no arm", remedy="give link lengths and limits in [robot]")
    return known, known.arm


def _named(kind: type[_Word], option: str, word: str) -> _Word:
    words = [one.value for one in kind]
    if word not in words:
        raise UsageError(f"{option} {word!r} is not known", remedy=f"use {', '.join(words)}")
    return kind(word)


def new_test(
    folder: str | Path,
    model: str | Path | None = None,
    *,
    poses: Sequence[str] | None = None,
    velocities: Sequence[float] = (100.0,),
    loads: Sequence[float] = (100.0,),
    **planned: Any,
) -> Path:
    """Make the folder of a test with the test.toml that `plan` gives for a model; return that file.

    Without a model ``poses`` names those that are taught on the robot: nothing else is known of
    them. ``velocities`` and ``loads`` are in per cent of the rated ones; ``planned`` are options of
    `plan`, without a model ``dwell`` [s] alone. Raises as `plan`, and `CannotCreateError` where a
    test is there already.
    """
    folder = Path(folder)
    file = folder / FILE
    refuse_existing_test(file)
    check_folder(folder)
    _check_percents({"velocities": velocities, "loads": loads})
    if (model is None) == (poses is None):
        raise UsageError(
            "the poses come from a model, or are taught and named",
            remedy="give `model=MODEL.toml`, or `poses=P1,P2,P3,P4,P5`",
        )
    percents = {"velocities": velocities, "loads": loads}
    if model is None:
        test = _taught(poses or (), planned, percents)
    else:
        described = read_model(Path(model))
        test = plan_test(
            plan(described, **planned), described, model_path=Path(model), folder=folder, **percents
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CannotCreateError(
            f"cannot be created ({error.strerror})", where=str(folder), remedy="name another folder"
        ) from error
    write_file(file, toml_of(test).encode())
    return file


def _taught(
    poses: Sequence[str], planned: Mapping[str, Any], percents: Mapping[str, Sequence[float]]
) -> WholeTest:
    if unknown := [name for name in planned if name != "dwell"]:
        raise UsageError(
            f"{unknown[0]} is of a model, and taught poses have none",
            remedy=f"leave `{unknown[0]}=` out",
        )
    return taught_test(poses, dwell_s=planned.get("dwell", 2.0), **percents)


def write_planned_test(file: str | Path, planned: PosePlan, model: str | Path) -> Path:
    """Write the test of a plan, as `new_test` does, for its one velocity and load; return ``file``.

    ``model`` is the file that the plan was made of. Raises `CannotCreateError` where ``file`` is
    there already: a test.toml is edited by hand.
    """
    file, model = Path(file), Path(model)
    refuse_existing_test(file)
    check_output(file)
    how = planned.conditions
    velocities, loads = (how.velocity_percent,), (how.load_percent,)
    _check_percents({"velocities": velocities, "loads": loads})
    test = plan_test(
        planned,
        read_model(model),
        model_path=model,
        folder=file.parent,
        velocities=velocities,
        loads=loads,
    )
    write_file(file, toml_of(test).encode())
    return file


def refuse_existing_test(file: Path) -> None:
    """Raise `CannotCreateError` where a test is there already: it is edited by hand."""
    if os.path.lexists(file):
        raise CannotCreateError(
            "is there already", where=str(file), remedy="edit it, or name another folder"
        )


def _check_percents(given: Mapping[str, Sequence[float]]) -> None:
    for name, values in given.items():
        wrong = [v for v in values if not 0 <= v <= 100 or (v == 0 and name == "velocities")]
        if wrong or not values or len(set(values)) < len(values):
            raise UsageError(
                f"{name} {', '.join(f'{value:g}' for value in values)}: no such test",
                remedy=f"give per cent of the rated ones, each once: `{name}=100,50,10`",
            )


_M = 0.1


SolidOption = Annotated[
    Solid, typer.Option(help="Largest cube, or largest box where the stroke is short.")
]
PlaneOption = Annotated[DiagonalPlane, typer.Option(help="Diagonal plane.")]
ElbowOption = Annotated[Elbow | None, typer.Option(help="Side of the elbow; else the better one.")]
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
    solid: SolidOption = Solid.CUBE,
    plane: PlaneOption = DiagonalPlane.C1_C2_C7_C8,
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
    how: dict[str, Any] = {
        "elbow": None if elbow is None else elbow.value,
        "cycles": cycles,
        "velocity": velocity,
        "load": load,
        "dwell": dwell,
    }
    files = _Files(picture, output, excel_locale)
    files.check(separating=separating)
    if separating:
        _refuse_with_separating(solid, plane, m)
        apart = plan_separating(model, **how)
        files.write(apart)
        if json:
            write_result(apart)
        else:
            write_report(reporting.separating_report(apart, robot))
        return
    found = plan(model, solid=solid.value, plane=plane.value, m=m, **how)
    files.write(found)
    if output is not None and files.as_test:
        write_planned_test(output, found, model)
        tell_written(output)
    if json:
        write_result(found)
    else:
        write_report(reporting.plan_report(found, robot))


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
            refuse_existing_test(self.output)
        if self.as_test and self.excel_locale is not None:
            raise UsageError("--excel-locale is for a .csv", remedy="let the name end in .csv")
        if self.as_test and separating:
            raise UsageError(
                "separating poses are no test of ISO 9283", remedy="let the name end in .csv"
            )

    def write(self, found: PosePlan | SeparatingPlan) -> None:
        """Write the picture, and the visits as CSV."""
        write_picture(found, self.picture)
        if self.output is not None and not self.as_test:
            write_text(
                reporting.visits_csv(found, tables.find_locale(self.excel_locale)), self.output
            )


def _refuse_with_separating(solid: Solid, plane: DiagonalPlane, m: float) -> None:
    """Raise `UsageError` where something is wanted that only the test of ISO 9283 has."""
    given = {
        "--solid": solid is not Solid.CUBE,
        "--plane": plane is not DiagonalPlane.C1_C2_C7_C8,
        "--m": m != _M,
    }
    for option, changed in given.items():
        if changed:
            raise UsageError(
                f"{option} is of the test of ISO 9283, and --separating lays no cube",
                remedy="leave one of them out",
            )
