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
    Table,
    UnitOfTable,
)
from scara_iso.cli.output import write_json, write_report
from scara_iso.errors import UsageError

if TYPE_CHECKING:
    from scara_iso.diagnosis import Diagnosis


def diagnose_command(
    table: Table,
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
    from scara_iso import read_table
    from scara_iso.closing import CyclesWanted, close_the_loop
    from scara_iso.model import read_model

    if save_model is not None and model is None:
        raise UsageError("--save-model needs --model", remedy="name the one to add to")
    run = read_table(table, unit=unit, resolution=resolution, decimal=decimal, sheet=sheet)
    diagnosis = close_the_loop(
        run,
        None if model is None else read_model(model),
        CyclesWanted(pose, first_cycle_discarded, cycles),
        hold_out=None if hold_out is None else read_table(hold_out, unit=unit, decimal=decimal),
        seed=seed,
    )
    if plot is not None:
        from scara_iso.render.plots import plot_diagnosis

        plot_diagnosis(diagnosis, plot)
    if save_model is not None and model is not None:
        _save(diagnosis, model, save_model)
    _write(diagnosis, run.origin.source, as_json=json)


def _save(diagnosis: Diagnosis, model: str, to: Path) -> None:
    from scara_iso.closing import declared
    from scara_iso.model import declare

    declare(model, tuple(declared(found, diagnosis) for found in diagnosis.effects), to)


def _write(diagnosis: Diagnosis, title: str, *, as_json: bool) -> None:
    if as_json:
        from scara_iso.render.json import diagnosis_json

        write_json(diagnosis_json(diagnosis))
    else:
        from scara_iso.report.diagnosis import diagnosis_report

        write_report(diagnosis_report(diagnosis, title))
