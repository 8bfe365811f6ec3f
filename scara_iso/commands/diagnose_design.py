"""`diagnose --design`: what a planned test will tell."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from scara_iso import diagnosis, iso9283, reporting
from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.quantities import Dimension
from scara_iso.commands.inputs import Reading, load_effects, read_run
from scara_iso.commands.options import Asked
from scara_iso.commands.output import Answer
from scara_iso.effects import Conditions, find_effects
from scara_iso.robot import Arm, Model, read_model
from scara_iso.run import FloatArray, Run

_FEWEST_POSES = 2
_SIGMA_MM, _RESOLUTION_MM = 0.005, 0.001


def design_of(asked: Asked[Any]) -> Answer:
    """Return what a test like that of a table, or of the options, will find.

    With a model it is one of several poses, and what it finds is in the joints.
    """
    tables, sigma, seed = asked["table"] or [], asked["sigma"], asked["seed"]
    if len(tables) > 1:
        raise UsageError("--design takes one table at most", remedy="name one of them")
    if sigma is not None and not 0 < sigma < math.inf:
        raise UsageError(
            f"--sigma {sigma:g}: not a positive, finite length",
            remedy="write it in mm, as --sigma 0.005",
        )
    effects = find_effects(load_effects(asked["own_effects"]))
    reading, wanted = asked.reading, diagnosis.CyclesWanted(asked["pose"], asked.counting)
    run = read_run(tables[0], reading) if tables else None
    if asked["model"] is not None:
        test = _of_poses(read_model(asked["model"]), run, reading, wanted, sigma)
        of_poses = diagnosis.design_of_poses(test, seed=seed, effects=effects)
        return Answer(of_poses, lambda: reporting.design_of_poses_report(of_poses))
    plan = _planned(reading, wanted, sigma) if run is None else _like(wanted.take(run), sigma)
    found = diagnosis.design(plan, seed=seed, effects=effects)
    return Answer(found, lambda: reporting.design_report(found))


def _of_poses(
    model: Model,
    run: Run | None,
    reading: Reading,
    wanted: diagnosis.CyclesWanted,
    sigma: float | None,
) -> diagnosis.PlannedPosesTest:
    """Return the test of a model's poses, like that of a table where one is named."""
    arm, poses = _arm_at(model, run)
    if run is None:
        dial = _planned(reading, wanted, sigma)
        variances = np.array([0.0, 0.0, dial.sigma**2, 0.0])
        steps = (dial.division, dial.division)
        return diagnosis.PlannedPosesTest(dial.conditions, arm, poses, variances, steps)
    used = wanted.used(run.unwrapped())
    rows = {str(pose): rows for pose, rows in zip(used.poses, used.rows, strict=True)}
    test = diagnosis.like_test(diagnosis.whole_cycles(run, rows), arm, poses)
    if sigma is None:
        return test
    return replace(test, variances=np.array([0.0, 0.0, sigma**2, 0.0]))


def _arm_at(model: Model, run: Run | None) -> tuple[Arm, dict[str, tuple[float, float]]]:
    """Return the arm, and its joints at each arrival of a table's cycle, or at a model's poses."""
    at = {pose: pose for pose in model.poses}
    if run is not None:
        at = {str(label): str(run.arrival_at(label)[0]) for label, _ in run.rows_by_pose()}
    known = {arrival: model.poses[pose] for arrival, pose in at.items() if pose in model.poses}
    if model.arm is None or len(set(at.values())) < _FEWEST_POSES or len(known) < len(at):
        raise UsageError(
            "--model does not go with --design but for a test of several poses",
            remedy="give links and [pose.P1] joint_deg at each of them, or leave it out",
        )
    return model.arm, known


def _like(run: Run, sigma: float | None) -> diagnosis.PlannedRun:
    """Return the test of a table: its columns, its dial, its scatter from cycle to cycle."""
    lengths = [axis for axis in run.axes.values() if axis.dimension is Dimension.LENGTH]
    if not lengths:
        raise DataError(
            "no axis in mm",
            where=run.origin.source,
            remedy="plan without the table: --sigma and --resolution, angles read as mm",
        )
    axis = max(lengths, key=lambda axis: _scatter(axis.readings))
    scatter = sigma or _scatter(axis.readings) or (axis.resolution or _RESOLUTION_MM)
    return diagnosis.PlannedRun(
        Conditions(run.cycle, run.covariates), scatter, axis.resolution or 0.0
    )


def _scatter(readings: FloatArray) -> float:
    """Return the standard deviation from successive differences, which a slow course leaves."""
    return float(np.sqrt((np.diff(readings) ** 2).mean() / 2)) if len(readings) > 1 else 0.0


def _planned(
    reading: Reading, wanted: diagnosis.CyclesWanted, sigma: float | None
) -> diagnosis.PlannedRun:
    """Return the cycles that are planned, with the columns that are named, and their dial."""
    cycle = np.arange(2, (wanted.counting.cycles or iso9283.CYCLES_RUN) + 1)
    known = diagnosis.planned_columns(cycle)
    names = [name.strip() for name in str(reading.get("columns") or "").split(",") if name.strip()]
    if unknown := [name for name in names if name not in known]:
        raise UsageError(
            f"--columns {unknown[0]}: no such column", remedy=f"known are {', '.join(known)}"
        )
    conditions = Conditions(cycle, {name: known[name] for name in names})
    division = reading.get("resolution")
    return diagnosis.PlannedRun(
        conditions, sigma or _SIGMA_MM, _RESOLUTION_MM if division is None else division
    )
