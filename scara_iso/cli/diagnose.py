"""``scara-iso diagnose``: what the model leaves unexplained, and which effect it lacks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scara_iso.cli.analyze import (
    AsJson,
    CyclesRun,
    DecimalMark,
    FirstDiscarded,
    ResolutionOfTable,
    Sheet,
    UnitOfTable,
)
from scara_iso.cli.output import write_json, write_report
from scara_iso.errors import UsageError

if TYPE_CHECKING:
    from scara_iso.diagnosis import Diagnosis

Tables = Annotated[
    list[str] | None,
    typer.Argument(metavar="TABLE...", help="Tables of readings; several give a summary."),
]


def diagnose_command(
    tables: Tables = None,
    *,
    model: Annotated[
        str | None,
        typer.Option("--model", metavar="MODEL", help="Model file; else a constant pose."),
    ] = None,
    hold_out: Annotated[
        str | None,
        typer.Option(metavar="TABLE", help="Second table for the error on unseen cycles."),
    ] = None,
    save_model: Annotated[
        Path | None, typer.Option(metavar="NEW", help="Write the model with the effects declared.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Before and after as .svg or .png.")
    ] = None,
    pose: Annotated[
        str | None, typer.Option(help="Which pose, where the table has several.")
    ] = None,
    design: Annotated[
        bool, typer.Option("--design", help="What a planned test will tell; needs no readings.")
    ] = False,
    sigma: Annotated[
        float | None, typer.Option(help="Scatter of the planned test [mm], else 0.005.")
    ] = None,
    columns: Annotated[
        str | None, typer.Option(help="Columns of the planned test: approach,temperature_C.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the shuffles.", min=0)] = 9283,
    unit: UnitOfTable = None,
    resolution: ResolutionOfTable = None,
    decimal: DecimalMark = None,
    sheet: Sheet = None,
    first_cycle_discarded: FirstDiscarded = False,
    cycles: CyclesRun = None,
    json: AsJson = False,
) -> None:
    """Close the loop: residual, the effect that explains it, error before and after.

    Example: scara-iso diagnose run.csv --model robot.toml --save-model new.toml
    """
    from scara_iso.closing import CyclesWanted, Reading, close_the_loop_on

    reading = Reading(unit, resolution, decimal, sheet)
    wanted = CyclesWanted(pose, first_cycle_discarded, cycles)
    if design:
        from scara_iso.cli.diagnose_design import show_design

        show_design(
            tables or (), reading, wanted, sigma=sigma, columns=columns, seed=seed, as_json=json
        )
        return
    if not tables:
        raise UsageError("no table is named", remedy="name one, or ask for --design")
    single = {"--hold-out": hold_out, "--save-model": save_model, "--plot": plot}
    asked = [option for option, value in single.items() if value is not None]
    if len(tables) > 1 and asked:
        raise UsageError(f"{asked[0]} is for one table", remedy="diagnose the tables one by one")
    if save_model is not None and model is None:
        raise UsageError("--save-model needs --model", remedy="name the one to add to")
    if len(tables) > 1:
        from scara_iso.cli.diagnose_many import diagnose_many

        diagnose_many(tables, model, reading, wanted, seed=seed, as_json=json)
        return
    diagnosis = close_the_loop_on(tables[0], model, reading, wanted, hold_out=hold_out, seed=seed)
    if plot is not None:
        from scara_iso.render.plots import plot_diagnosis

        plot_diagnosis(diagnosis, plot)
    if save_model is not None and model is not None:
        _save(diagnosis, model, save_model)
    _write(diagnosis, tables[0], as_json=json)


def _save(diagnosis: Diagnosis, model: str, to: Path) -> None:
    from scara_iso.closing import declared
    from scara_iso.model import declare

    declare(model, tuple(declared(found) for found in diagnosis.effects), to)


def _write(diagnosis: Diagnosis, title: str, *, as_json: bool) -> None:
    if as_json:
        from scara_iso.render.json_diagnosis import diagnosis_json

        write_json(diagnosis_json(diagnosis))
    else:
        from scara_iso.report.diagnosis import diagnosis_report

        write_report(diagnosis_report(diagnosis, title))
