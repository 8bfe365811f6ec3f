"""`plan` and `plan_separating`: where a test is made, and its test.toml."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer

from scara_iso import reporting
from scara_iso.base.disk import check_folder, check_output, write_file
from scara_iso.base.errors import CannotCreateError, UsageError
from scara_iso.base.published import to_json
from scara_iso.commands.inputs import described
from scara_iso.commands.options import AsJson, ExcelLocale, ModelFile
from scara_iso.commands.output import (
    check_outputs,
    tell_written,
    write_json,
    write_picture,
    write_report,
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
from scara_iso.testfolder import FILE, plan_test, toml_of

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
    model: str | Path,
    *,
    velocities: Sequence[float] = (100.0,),
    loads: Sequence[float] = (100.0,),
    **planned: Any,
) -> Path:
    """Make the folder of a test with the test.toml that `plan` gives for a model; return that file.

    ``velocities`` and ``loads`` are in per cent of the rated ones; ``planned`` are options of
    `plan`. Raises as `plan`, and `CannotCreateError` where a test is there already.
    """
    folder, model = Path(folder), Path(model)
    file = folder / FILE
    refuse_existing_test(file)
    check_folder(folder)
    _check_percents({"velocities": velocities, "loads": loads})
    described = read_model(model)
    found = plan(described, **planned)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CannotCreateError(
            f"cannot be created ({error.strerror})", where=str(folder), remedy="name another folder"
        ) from error
    return _write(file, found, described, model, velocities, loads)


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
    return _write(file, planned, read_model(model), model, velocities, loads)


def refuse_existing_test(file: Path) -> None:
    """Raise `CannotCreateError` where a test is there already: it is edited by hand."""
    if os.path.lexists(file):
        raise CannotCreateError(
            "is there already", where=str(file), remedy="edit it, or name another folder"
        )


def _write(
    file: Path,
    planned: PosePlan,
    described: Model,
    model: Path,
    velocities: Sequence[float],
    loads: Sequence[float],
) -> Path:
    test = plan_test(
        planned,
        described,
        model_path=model,
        folder=file.parent,
        velocities=velocities,
        loads=loads,
    )
    write_file(file, toml_of(test).encode())
    return file


def _check_percents(given: Mapping[str, Sequence[float]]) -> None:
    for name, values in given.items():
        wrong = [v for v in values if not 0 <= v <= 100 or (v == 0 and name == "velocities")]
        if wrong or not values or len(set(values)) < len(values):
            raise UsageError(
                f"{name} {', '.join(f'{value:g}' for value in values)}: no such test",
                remedy=f"give per cent of the rated ones, each once: `{name}=100,50,10`",
            )


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
        apart = plan_separating(model, **asdict(how))
        files.write(apart)
        if json:
            from scara_iso.diagnosis import published_separating_plan

            write_json(to_json(published_separating_plan(apart)))
        else:
            write_report(reporting.separating_report(apart, robot))
        return
    found = plan(model, solid=solid.value, plane=plane.value, m=m, **asdict(how))
    files.write(found)
    if output is not None and files.as_test:
        write_planned_test(output, found, model)
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
            refuse_existing_test(self.output)
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
