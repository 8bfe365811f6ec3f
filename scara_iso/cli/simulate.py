"""``scara-iso simulate``: readings of a model, as a dial would have shown them."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from scara_iso.base.errors import UsageError
from scara_iso.base.published import to_json
from scara_iso.cli.options import AsJson, ExcelLocale, ModelFile, OwnEffectsFile
from scara_iso.cli.output import check_outputs, write_json, write_text


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
Interval = Annotated[
    float | None, typer.Option(metavar="SECONDS", help="From cycle to cycle; adds time_s.")
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
    interval: Interval = None,
    drivetrain: DriveTrainWanted = False,
    effects: OwnEffectsFile = None,
    output: Output = None,
    excel_locale: ExcelLocale = None,
    json: AsJson = False,
) -> None:
    """Write readings of a model with scatter, effects and rounding, as a table.

    Example: scara-iso simulate examples/fum_scara.toml --effect warm_up:size=0.03,tau=8 -o run.csv
    """
    from scara_iso.library import published_run, simulate
    from scara_iso.tables import find_locale, write_table

    check_outputs([output], [model, effects])
    run = simulate(
        model,
        cycles=cycles,
        effects=effect or (),
        seed=seed,
        approach=None if approach is None else approach.value,
        temperature=None if temperature is None else _ends(temperature),
        payload=None if payload is None else _numbers("--payload", payload, ","),
        interval=interval,
        drivetrain=drivetrain,
        own_effects=effects or (),
    )
    if output is not None or not json:
        write_text(write_table(run, find_locale(excel_locale)), output)
    if json:
        write_json(to_json(published_run(run, seed=seed)))


def _ends(text: str) -> tuple[float, float]:
    ends = _numbers("--temperature", text, ":")
    if len(ends) != 2:
        raise UsageError(f"--temperature {text!r}", remedy="write --temperature 20:24")
    return ends[0], ends[1]


def _numbers(option: str, text: str, separator: str) -> list[float]:
    from scara_iso.base.quantities import parse_number

    numbers = [n for part in text.split(separator) if (n := parse_number(part)) is not None]
    if len(numbers) <= text.count(separator):
        raise UsageError(
            f"{option} {text!r} is not made of numbers",
            remedy=f"write numbers with {separator!r} between them",
        )
    return numbers
