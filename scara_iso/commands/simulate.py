"""`simulate`: readings of a model, as a dial would have shown them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np

from scara_iso import robot, tables
from scara_iso.base.errors import UsageError
from scara_iso.base.published import Count, Size, Unit, publish
from scara_iso.commands.shared import options as opt
from scara_iso.commands.shared.inputs import OwnEffects, load_model, one_of
from scara_iso.commands.shared.output import check_outputs, say, write_result, write_text
from scara_iso.effects import Conditions as Procedure, find_effects
from scara_iso.iso9283 import CYCLES_RUN
from scara_iso.robot import Approach, DeclaredEffect, Model, parse_effect, rest_positions, sides
from scara_iso.run import AxisKey, FloatArray, Run


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
    ``drivetrain`` lets friction stop the load inside the gap; ``own_effects`` are the user's,
    or their file. Same arguments, same readings. Raises `UsageError` for invalid values, and as
    `read_model`.
    """
    known = load_model(model, own_effects)
    added = [effects] if isinstance(effects, str) else effects
    if cycles < 2:
        raise UsageError(f"{cycles} cycles make no test", remedy="simulate two or more")
    side = one_of(Approach, "approach", approach or "one")
    rng = np.random.default_rng(seed)
    covariates = _recorded(temperature, payload, interval, cycles)
    rests: Mapping[str, FloatArray] | None = None
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
    many = f"the model names {len(known.poses)} poses; this is one table, and of none of them"
    origin = replace(run.origin, notes=(many,) if known.poses else ())
    stated = {**run.metadata, "simulated": " ".join(run.axes)}
    return replace(run, metadata=stated, origin=origin)


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


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class SimulatedAxis:
    """The readings of one axis."""

    unit: Unit
    """Of readings and resolution."""
    resolution: Size | None
    """Smallest step of the dial; null where the model states none."""
    readings: FloatArray
    """One for each row."""


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class PublishedRun:
    """``simulate`` of a model."""

    schema: Literal["scara-iso/simulate/1"] = "scara-iso/simulate/1"
    """Name and number of this schema."""
    unit: Literal["mm"]
    """Of every length."""
    seed: Count
    """Of everything drawn."""
    metadata: Mapping[str, str]
    """What the table states."""
    cycle: tuple[int, ...]
    """Of each row."""
    axes: Mapping[AxisKey, SimulatedAxis]
    """By name."""
    covariates: Mapping[str, FloatArray]
    """Other columns, by name."""


def published_run(run: Run, *, seed: int) -> PublishedRun:
    """Return what ``simulate`` says."""
    axes = {name: publish(SimulatedAxis, axis) for name, axis in run.axes.items()}
    cycle = tuple(run.cycle.tolist())
    return publish(PublishedRun, run, unit="mm", seed=seed, cycle=cycle, axes=axes)


def _ends(text: str) -> tuple[float, ...]:
    ends = opt.read_numbers("--temperature", text, ":")
    if len(ends) != 2:
        raise UsageError(f"--temperature {text!r}: not FROM:TO", remedy="write --temperature 20:24")
    return tuple(ends)


@opt.takes_options_of(
    simulate,
    model=opt.MODEL_FILE,
    cycles=opt.option("Number of cycles, the discarded first included.", min=2, max=1_000_000),
    effects=opt.option(
        "Effect to add: warm_up:size=0.03,tau=8; may be repeated. The table does not name it.",
        "--effect",
        kind=list[str] | None,
        metavar="NAME[@AXES]:KEY=VALUE,...",
        autocompletion=lambda: [f"{one.name}:" for one in find_effects()],
    ),
    seed=opt.option("Seed of the scatter.", min=0),
    approach=opt.option("Side of the approach; adds a column approach.", kind=Approach | None),
    temperature=opt.option("Temperature ramp; adds temperature_C.", read=_ends, metavar="FROM:TO"),
    payload=opt.option(
        "Payloads in turn; adds payload_kg.",
        read=partial(opt.read_numbers, "--payload"),
        metavar="KG,KG,...",
    ),
    interval=opt.option("Time between cycles; adds time_s.", metavar="SECONDS"),
    drivetrain=opt.option("Let friction stop the load inside the gap."),
    output=opt.output_file("File to write [standard output]."),
)
def simulate_command(
    asked: opt.Asked[Run],
    *,
    output: Path | None = None,
    excel_locale: opt.ExcelName | None = None,
    json: bool = False,
) -> None:
    """Simulate readings of a model with scatter, effects and rounding, as a table.

    Example: scara-iso simulate examples/fum_scara.toml --effect warm_up:size=0.03,tau=8 -o run.csv
    """
    check_outputs([], [asked["model"], asked["own_effects"]], tables=[output])
    run = asked.result()
    for note in run.origin.notes:
        say(f"scara-iso: {note}")
    if output is not None or not json:
        write_text(tables.write_table(run, tables.find_locale(excel_locale)), output)
    if json:
        write_result(published_run(run, seed=asked["seed"]))
