"""``scara-iso gauge-study``: is the dial good enough for the tolerance."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from scara_iso import render
from scara_iso.base.published import to_json
from scara_iso.cli.options import (
    NOT_WITHIN_LIMITS,
    AsJson,
    DecimalMark,
    Full,
    ResolutionOfTable,
    UnitOfTable,
    parse_sizes,
)
from scara_iso.cli.output import (
    check_outputs,
    command_line,
    tell_written,
    write_json,
    write_picture,
    write_report,
)
from scara_iso.iso9283 import Conformity, DecisionRule

Tables = Annotated[
    list[str],
    typer.Argument(
        metavar="TABLE...",
        help="Readings, with part (or pose), operator, session or reference beside them as the "
        "study has them; - is standard input. Several of one study.",
    ),
]
Tolerance = Annotated[
    list[str] | None,
    typer.Option(
        metavar="[AXIS=]SIZE", help="Width of the tolerance, in the readings' unit: 0.06, X=0.06."
    ),
]
Reference = Annotated[
    list[str] | None,
    typer.Option(
        metavar="[AXIS=]SIZE", help="True value of the part that is read, in the readings' unit."
    ),
]
Rule = Annotated[
    DecisionRule,
    typer.Option(
        "--decision",
        help="simple: the figure against the guideline's limit, as the guidelines do; interval: "
        "all of its 95 % interval.",
    ),
]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--output",
        help=f"Also write it, by the ending: {' '.join(render.endings())}; .dfq is AQDEF.",
    ),
]
Plot = Annotated[Path | None, typer.Option("--plot", help="Also draw it: .svg or .png.")]


def gauge_study_command(
    table: Tables,
    *,
    tolerance: Tolerance = None,
    reference: Reference = None,
    decision: Rule = DecisionRule.SIMPLE,
    unit: UnitOfTable = None,
    resolution: ResolutionOfTable = None,
    decimal: DecimalMark = None,
    output: Output = None,
    plot: Plot = None,
    full: Full = False,
    json: AsJson = False,
) -> None:
    """Say whether a dial is good enough: type 1 (Cg, Cgk), R&R, linearity, stability.

    Example: scara-iso gauge-study examples/dial_type_1.csv --tolerance 0.03
    """
    from scara_iso.library import gauge_study

    check_outputs([output], table, pictures=[plot])
    found = gauge_study(
        table,
        tolerance=parse_sizes("--tolerance", tolerance or (), "write --tolerance 0.06"),
        reference=parse_sizes("--reference", reference or (), "write --reference 0.81"),
        unit=unit,
        resolution=resolution,
        decimal=decimal,
        decision=decision.value,
        to=output,
    )
    tell_written(output)
    write_picture(found, plot)
    if json:
        from scara_iso.gauge import published_gauge_study

        write_json(to_json(published_gauge_study(found)))
    else:
        from scara_iso.reporting import NextStep, gauge_study_brief, gauge_study_report

        proof = decision.value if decision is DecisionRule.INTERVAL else None
        given = {
            "tolerance": tolerance,
            "reference": reference,
            "decision": proof,
            "unit": unit,
            "resolution": resolution,
            "decimal": decimal,
        }
        again = command_line(table, given, full=True)
        following = NextStep(f"scara-iso gauge-study {again}", "every figure")
        write_report(gauge_study_report(found) if full else gauge_study_brief(found, following))
    if found.conformity not in (None, Conformity.PASS):
        raise typer.Exit(NOT_WITHIN_LIMITS)
