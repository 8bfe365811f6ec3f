"""`simulate`, `plan` and `plan_separating`: what a model file makes of a test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from scara_iso import robot
from scara_iso.base.errors import UsageError
from scara_iso.diagnosis import GIVEN, STANDARD, SeparatingPlan, separating_plan
from scara_iso.effects import Conditions as Procedure
from scara_iso.iso9283 import (
    CYCLES_RUN,
    DiagonalPlane,
    PosePlan,
    PoseTestConditions,
    Solid,
    make_plan,
)
from scara_iso.library.model_files import OwnEffects, described
from scara_iso.robot import (
    Approach,
    Arm,
    DeclaredEffect,
    Elbow,
    Model,
    parse_effect,
    rest_positions,
    sides,
)
from scara_iso.run import FloatArray, Run

_Word = TypeVar("_Word", Solid, DiagonalPlane, Elbow)
_SIDES = {"one": Approach.ONE_SIDE, "both": Approach.BOTH_SIDES, "random": Approach.RANDOM}


def simulate(
    model: Model | str | Path,
    *,
    cycles: int = CYCLES_RUN,
    effects: str | Sequence[str | DeclaredEffect] = (),
    seed: int = 0,
    approach: str | None = None,
    temperature: tuple[float, float] | None = None,
    payload: Sequence[float] | None = None,
    interval: float | None = None,
    drivetrain: bool = False,
    own_effects: OwnEffects = (),
) -> Run:
    """Return readings of a model (or its file) as a dial would have shown them [mm, deg].

    ``cycles`` are all that are run, the first included. ``effects`` act beside those the model
    declares, such as ``"warm_up:size=0.03,tau=8"``; ``approach`` is ``one``, ``both`` or ``random``
    and adds that column; ``temperature`` ramps from one to another [degC]; ``payload`` are loads
    by turns [kg]; ``interval`` is the time from cycle to cycle [s] and adds ``time_s``;
    ``drivetrain`` takes rest positions from the gears through time; ``own_effects`` are the user's,
    or their file. Same arguments, same readings. Raises `UsageError` for invalid values, and as
    `read_model`.
    """
    known = described(model, own_effects)
    added = [effects] if isinstance(effects, str) else effects
    if cycles < 2:
        raise UsageError(f"{cycles} cycles make no test", remedy="simulate two or more")
    if approach is not None and approach not in _SIDES:
        raise UsageError(
            f"approach {approach!r} is not known", remedy=f"use one of {', '.join(_SIDES)}"
        )
    rng = np.random.default_rng(seed)
    covariates = _recorded(temperature, payload, interval, cycles)
    rests: Mapping[str, FloatArray] | None = None
    side = _SIDES[approach or "one"]
    if drivetrain:
        arrived, rests = rest_positions(known, side, count=cycles, rng=rng)
        covariates |= {"approach": arrived} if approach is not None else {}
    elif approach is not None:
        covariates["approach"] = sides(side, cycles, rng).astype(float)
    run = robot.simulate(
        known,
        Procedure(np.arange(1, cycles + 1), covariates),
        rng=rng,
        undeclared=[parse_effect(e, known) if isinstance(e, str) else e for e in added],
        displacement=rests,
    )
    return replace(run, metadata={**run.metadata, "simulated": " ".join(run.axes)})


def _recorded(
    temperature: tuple[float, float] | None,
    payload: Sequence[float] | None,
    interval: float | None,
    cycles: int,
) -> dict[str, FloatArray]:
    found: dict[str, FloatArray] = {}
    if interval is not None:
        if not 0 < interval < np.inf:
            raise UsageError(
                f"`interval={interval:g}`: not a positive time in seconds",
                remedy="write it in seconds, as `interval=20`",
            )
        found["time_s"] = interval * np.arange(cycles, dtype=float)
    if temperature is not None:
        found["temperature_C"] = np.linspace(*temperature, cycles).round(2)
    if payload is not None:
        if not len(payload):
            raise UsageError("no payload is named", remedy="name one payload or more, in kg")
        found["payload_kg"] = np.resize(np.asarray(payload, dtype=float), cycles)
    return found


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
