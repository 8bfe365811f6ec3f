"""``scara-iso simulate``: readings of a model, as a dial would have shown them."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scara_iso.cli.options import AsJson, ExcelLocale, ModelFile
from scara_iso.cli.output import check_outputs, write_json, write_text
from scara_iso.errors import UsageError

if TYPE_CHECKING:
    import numpy as np

    from scara_iso.robot import Model
    from scara_iso.run import FloatArray, Run


class Side(StrEnum):
    """From which side the pose is approached."""

    ONE = "one"
    BOTH = "both"
    RANDOM = "random"


Cycles = Annotated[int, typer.Option(help="Cycles, the first counted.", min=2, max=1_000_000)]
Effects = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME[@AXES]:KEY=VALUE,...",
        help="An effect that the file will not declare: warm_up:size=0.03,tau=8. May be repeated.",
    ),
]
Seed = Annotated[int, typer.Option(help="Seed of the scatter.", min=0)]
ApproachSide = Annotated[
    Side | None, typer.Option(help="Side of the approach; adds the column approach.")
]
Temperature = Annotated[
    str | None, typer.Option(metavar="FROM:TO", help="A ramp; adds temperature_C.")
]
Payload = Annotated[
    str | None, typer.Option(metavar="KG,KG,...", help="Loads by turns; adds payload_kg.")
]
DriveTrainWanted = Annotated[
    bool, typer.Option("--drivetrain", help="Rest positions from the gears through time.")
]
Output = Annotated[Path | None, typer.Option("-o", "--output", help="File; else standard output.")]


def simulate_command(
    model: ModelFile,
    *,
    cycles: Cycles = 31,
    effect: Effects = None,
    seed: Seed = 0,
    approach: ApproachSide = None,
    temperature: Temperature = None,
    payload: Payload = None,
    drivetrain: DriveTrainWanted = False,
    output: Output = None,
    excel_locale: ExcelLocale = None,
    json: AsJson = False,
) -> None:
    """Write readings of a model with scatter, effects and rounding, as a table.

    Example: scara-iso simulate examples/fum_scara.toml --effect warm_up:size=0.03,tau=8 -o run.csv
    """
    from scara_iso.render import run_json
    from scara_iso.robot import read_model
    from scara_iso.tables import find_locale, write_table

    check_outputs([output], [model])
    covariates = _recorded(temperature, payload, cycles)
    run = _simulated(
        read_model(model), effect or (), covariates, cycles, approach, moving=drivetrain, seed=seed
    )
    if output is not None or not json:
        write_text(write_table(run, find_locale(excel_locale)), output)
    if json:
        write_json(run_json(run, seed=seed))


def _simulated(
    model: Model,
    effects: Sequence[str],
    covariates: dict[str, FloatArray],
    cycles: int,
    approach: Side | None,
    *,
    moving: bool,
    seed: int,
) -> Run:
    import numpy as np

    from scara_iso.effects import Conditions
    from scara_iso.robot import parse_effect, simulate

    rng = np.random.default_rng(seed)
    rests = None
    if approach is not None or moving:
        sides, rests = _arrivals(model, approach or Side.ONE, cycles, rng, moving=moving)
        covariates = covariates | ({"approach": sides} if approach is not None else {})
    return simulate(
        model,
        Conditions(np.arange(1, cycles + 1), covariates),
        rng=rng,
        undeclared=[parse_effect(text, model) for text in effects],
        displacement=rests,
    )


def _arrivals(
    model: Model, side: Side, count: int, rng: np.random.Generator, *, moving: bool
) -> tuple[FloatArray, dict[str, FloatArray] | None]:
    """Return the side of each approach and, with the drive train, what the dials read of it."""
    from scara_iso.robot import Approach, rest_positions, sides

    chosen = {
        Side.ONE: Approach.ONE_SIDE,
        Side.BOTH: Approach.BOTH_SIDES,
        Side.RANDOM: Approach.RANDOM,
    }[side]
    if moving:
        return rest_positions(model, chosen, count=count, rng=rng)
    return sides(chosen, count, rng).astype(float), None


def _recorded(temperature: str | None, payload: str | None, cycles: int) -> dict[str, FloatArray]:
    import numpy as np

    found: dict[str, FloatArray] = {}
    if temperature is not None:
        ends = _numbers("--temperature", temperature, ":")
        if len(ends) != 2:
            raise UsageError(f"--temperature {temperature!r}", remedy="write --temperature 20:24")
        found["temperature_C"] = np.linspace(ends[0], ends[1], cycles).round(2)
    if payload is not None:
        found["payload_kg"] = np.resize(_numbers("--payload", payload, ","), cycles)
    return found


def _numbers(option: str, text: str, separator: str) -> list[float]:
    from scara_iso.quantities import parse_number

    numbers = [n for part in text.split(separator) if (n := parse_number(part)) is not None]
    if len(numbers) <= text.count(separator):
        raise UsageError(f"{option} {text!r} is not made of numbers")
    return numbers
