"""`plan` and `plan_separating`: where a test is made, and its test.toml."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from scara_iso import iso9283, reporting, tables
from scara_iso.base.errors import CannotCreateError, UsageError
from scara_iso.base.files import check_folder, write_file
from scara_iso.commands.shared import output as out
from scara_iso.commands.shared.inputs import load_model, one_of
from scara_iso.commands.shared.options import (
    MODEL_FILE,
    Asked,
    ExcelName,
    option,
    output_file,
    takes_options_of,
)
from scara_iso.diagnosis import GIVEN, STANDARD, SeparatingPlan, separating_plan
from scara_iso.robot import Arm, Elbow, Model, read_model
from scara_iso.testfolder import FILE, plan_test, taught_test, toml_of


def plan(
    model: Model | str | Path,
    *,
    solid: str = iso9283.Solid.CUBE.value,
    plane: str = iso9283.DiagonalPlane.C1_C2_C7_C8.value,
    elbow: str | None = None,
    m: float = 0.1,
    cycles: int = iso9283.CYCLES_RUN,
    velocity: float = 100.0,
    load: float = 100.0,
    dwell: float = 2.0,
) -> iso9283.PosePlan:
    """Return the test of a model's arm: largest cube, diagonal plane, P1 to P5 with joint angles.

    ``solid`` is ``cube`` or ``box``; ``plane`` names its corners (``C1-C2-C7-C8``...); ``elbow`` is
    ``right`` or ``left``, else the better one; ``m`` is eq. 1's m over the diagonal L, 0.08 to
    0.12; ``velocity`` and ``load`` are percent of the rated ones, ``dwell`` seconds at each pose.
    Raises `UsageError` where a word is not known, the model holds no arm, or no cube fits.
    """
    known, arm = _with_arm(model)
    return iso9283.make_plan(
        arm,
        solid=one_of(iso9283.Solid, "solid", solid),
        plane=one_of(iso9283.DiagonalPlane, "plane", plane),
        elbow=None if elbow is None else one_of(Elbow, "elbow", elbow),
        m_over_diagonal=m,
        conditions=iso9283.PoseTestConditions(
            cycles=cycles, velocity_percent=velocity, load_percent=load, dwell_s=dwell
        ),
        rated=known.rated,
    )


def plan_separating(
    model: Model | str | Path,
    *,
    elbow: str | None = None,
    cycles: int = iso9283.CYCLES_RUN,
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
    conditions = iso9283.PoseTestConditions(
        cycles=cycles, velocity_percent=velocity, load_percent=load, dwell_s=dwell
    )
    side = None if elbow is None else one_of(Elbow, "elbow", elbow)
    others = {GIVEN: [*known.poses.values()]} if known.poses else {}
    with suppress(UsageError):  # no cube fits
        poses = iso9283.make_plan(arm, elbow=side).poses
        others[STANDARD] = [(one.joint_1_deg, one.joint_2_deg) for one in poses]
    return separating_plan(arm, others, elbow=side, conditions=conditions, rated=known.rated)


def _with_arm(model: Model | str | Path) -> tuple[Model, Arm]:
    known = load_model(model)
    if known.arm is None:
        named = "the model" if isinstance(model, Model) else str(model)
        raise UsageError(f"{named} states no arm", remedy="give link lengths and limits in [robot]")
    return known, known.arm


def new_test(
    folder: str | Path,
    model: str | Path | None = None,
    *,
    poses: str | Sequence[str] | None = None,
    velocities: Sequence[float] = (100.0,),
    loads: Sequence[float] = (100.0,),
    solid: str | None = None,
    plane: str | None = None,
    elbow: str | None = None,
    dwell: float = 2.0,
    **planned: Any,
) -> Path:
    """Make the folder of a test with the test.toml that `plan` gives for a model; return that file.

    Without a model ``poses`` (``"P1,P2"``, or a sequence) names those that are taught on the robot:
    nothing else is known of them. ``velocities`` and ``loads`` are in per cent of the rated ones;
    the other options are those of `plan`, without a model ``dwell`` [s] alone. Raises as `plan`,
    and `CannotCreateError` where a test is there already.
    """
    folder = Path(folder)
    refuse_existing_test(folder / FILE)
    check_folder(folder)
    percents = _percents(velocities=velocities, loads=loads)
    stated = {"solid": solid, "plane": plane, "elbow": elbow, **planned}
    stated = {name: one for name, one in stated.items() if one is not None}
    if (model is None) == (poses is None):
        raise UsageError(
            "the poses come from a model, or are taught and named",
            remedy="give `model=MODEL.toml`, or `poses=P1,P2,P3,P4,P5`",
        )
    if model is not None:
        planned_poses = plan(model, dwell=dwell, **stated)
        test = plan_test(planned_poses, Path(model), folder=folder, **percents)
    elif stated:
        name = next(iter(stated))
        raise UsageError(
            f"{name} is of a model, and taught poses have none", remedy=f"leave `{name}=` out"
        )
    else:
        names = poses.split(",") if isinstance(poses, str) else poses or ()
        test = taught_test([name.strip() for name in names], dwell_s=dwell, **percents)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CannotCreateError(
            f"cannot be created ({error.strerror})", where=str(folder), remedy="name another folder"
        ) from error
    write_file(folder / FILE, toml_of(test).encode())
    return folder / FILE


def refuse_existing_test(file: Path) -> None:
    """Raise `CannotCreateError` where a test is there already: it is edited by hand."""
    if os.path.lexists(file):
        raise CannotCreateError(
            "is there already", where=str(file), remedy="edit it, or name another folder"
        )


def _percents(**given: Sequence[float]) -> dict[str, Sequence[float]]:
    for name, values in given.items():
        wrong = [v for v in values if not 0 <= v <= 100 or (v == 0 and name == "velocities")]
        if wrong or not values or len(set(values)) < len(values):
            raise UsageError(
                f"{name} {', '.join(f'{value:g}' for value in values)}: no such test",
                remedy=f"give per cent of the rated ones, each once: `{name}=100,50,10`",
            )
    return given


POSED = {
    "solid": option("Solid: largest cube, or box where the stroke is short.", kind=iso9283.Solid),
    "plane": option("Diagonal plane.", kind=iso9283.DiagonalPlane),
    "elbow": option("Side of the elbow [the better one].", kind=Elbow | None),
    "dwell": option("Rest at each pose before its reading [s]."),
}


@takes_options_of(
    plan,
    "json",
    model=MODEL_FILE,
    **POSED,
    m=option("Distance of the poses from the corners, 0.08 to 0.12 of the diagonal.", "--m"),
    cycles=option("Number of cycles, the discarded first included.", min=2),
    velocity=option("Velocity in per cent of the rated one."),
    load=option("Load in per cent of the rated one."),
    separating=option("Propose poses that tell the joints apart instead of those of ISO 9283."),
    picture=option("Picture of workspace and poses, .svg or .png."),
    output=output_file("Visits as CSV for a robot program, or FILE.toml as a test.toml."),
)
def plan_command(
    asked: Asked[iso9283.PosePlan],
    *,
    separating: bool = False,
    picture: Path | None = None,
    output: Path | None = None,
    excel_locale: ExcelName | None = None,
) -> out.Answer:
    """Plan the test: largest cube in the workspace, diagonal plane, P1 to P5 with joint angles.

    Example: scara-iso plan examples/fum_scara.toml --picture plan.svg -o visits.csv
    """
    model = asked["model"]
    out.check_outputs([output], [model], pictures=[picture])
    robot = read_model(model).robot
    as_test = output if output is not None and output.suffix.lower() == ".toml" else None
    if as_test is not None:
        refuse_existing_test(as_test)
        if separating or excel_locale is not None:
            what = "--separating" if separating else "--excel-locale"
            raise UsageError(f"{what} makes no test.toml", remedy="let the name end in .csv")
    found: iso9283.PosePlan | SeparatingPlan
    if separating:
        for name in asked.stated("solid", "plane", "m"):
            raise UsageError(
                f"--{name} shapes the cube of ISO 9283, and --separating has no cube",
                remedy="leave one of them out",
            )
        found = plan_separating(**asked.options("solid", "plane", "m"))
        report = reporting.separating_report(found, robot)
    else:
        found = asked.result()
        report = reporting.plan_report(found, robot)
        if as_test is not None:
            _write_test(found, model, as_test)
    out.write_picture(found, picture)
    if output is not None and as_test is None:
        out.write_text(reporting.visits_csv(found, tables.find_locale(excel_locale)), output)
    return out.Answer(found, lambda: report)


def _write_test(found: iso9283.PosePlan, model: str, file: Path) -> None:
    how = found.conditions
    percents = _percents(velocities=(how.velocity_percent,), loads=(how.load_percent,))
    test = plan_test(found, Path(model), folder=file.parent, **percents)
    write_file(file, toml_of(test).encode())
    out.tell_written(file)
