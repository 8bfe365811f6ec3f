"""`gauge_study`: is the dial good enough for the tolerance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from scara_iso import render, reporting
from scara_iso.base.disk import check_output, write_file
from scara_iso.base.errors import UsageError
from scara_iso.base.quantities import Dimension, size_in
from scara_iso.commands.inputs import Sizes, Tables, paths_of, sizes_of, tables_of
from scara_iso.commands.options import (
    AsJson,
    DecimalMark,
    Full,
    ResolutionOfTable,
    UnitOfTable,
    parse_sizes,
)
from scara_iso.commands.output import (
    check_outputs,
    command_line,
    exit_by,
    tell_written,
    write_picture,
    write_report,
    write_result,
)
from scara_iso.gauge import GaugeStudy, Remark, read_gauge_tables, study_gauge
from scara_iso.iso9283 import DecisionRule
from scara_iso.render import find_format
from scara_iso.reporting import Document, gauge_study_report
from scara_iso.run import FARTHEST

SEED = 1


def gauge_study(
    table: Tables,
    *,
    tolerance: Sizes | None = None,
    reference: Sizes | None = None,
    unit: str | None = None,
    resolution: float | None = None,
    decimal: str | None = None,
    decision: str = DecisionRule.SIMPLE.value,
    to: str | Path | None = None,
    seed: int = SEED,
) -> GaugeStudy:
    """Return whether a dial is good enough: type 1, R&R, linearity or stability.

    ``table`` is a path, ``-``, bytes or an open file, or several of one study; which study it is
    is told by what the readings name: ``part`` (a recording's ``pose``), ``operator``, ``session``,
    ``reference``. ``tolerance`` (its width, in mm or degrees, or with a unit: ``"30um"``) and
    ``reference`` (the true value, in the unit of the readings) are one for all or by axis.
    ``unit``, ``resolution`` (in it) and ``decimal`` as in `read_table`. ``decision`` is ``simple``
    (the figure against the guideline's limit, as the guidelines do) or ``interval`` (all of its
    95 % interval). ``to`` also writes it: .dfq (AQDEF) or a form of the report. ``seed`` is of the
    draws for intervals of several variances.
    Raises `DataError` for a table that cannot be read or makes no study, `UsageError` for options
    that make no sense.
    """
    words = [rule.value for rule in DecisionRule]
    if decision not in words:
        raise UsageError(f"decision {decision!r}", remedy=f"use {' or '.join(words)}")
    _refuse_twice(table)
    tolerances = sizes_of("tolerance", tolerance)
    _refuse_none(tolerances)
    write = None if to is None else find_format(Path(to).name, Path(to).suffix)
    if to is not None:
        check_output(Path(to))
    read = read_gauge_tables(
        tables_of(table),  # type: ignore[arg-type]  # a Run or a frame is refused when read
        unit=unit,
        resolution=resolution,
        decimal=decimal,
        references=sizes_of("reference", reference),
        tolerances=tolerances,
    )
    found = study_gauge(read, decision=DecisionRule(decision), seed=seed)
    found = replace(found, remarks=(*_changed(table), *found.remarks))
    if to is not None and write is not None:
        write_file(Path(to), write(Document("Gauge study", gauge_study_report(found), found)))
    return found


def _refuse_twice(table: Tables) -> None:
    paths = [Path(path).resolve() for path in paths_of(table)]
    twice = [path for k, path in enumerate(paths) if path in paths[:k]]
    if twice:
        raise UsageError(
            f"{twice[0].name} is named twice", remedy="name it once: its readings would count twice"
        )


def _refuse_none(tolerances: Mapping[str, float | str]) -> None:
    """Raise `UsageError` for a width that is none."""
    for given in tolerances.values():
        units = (unit.value for unit in Dimension)
        sizes = (size_in(given, unit) for unit in units) if isinstance(given, str) else (given,)
        if not any(size is not None and 0 < size < FARTHEST for size in sizes):
            raise UsageError(f"`tolerance={given}`", remedy="give its width, above zero")


def _changed(table: Tables) -> tuple[Remark, ...]:
    """Return a remark for each file that changed since it was recorded."""
    from scara_iso.rawfile import check_manifest

    found = dict.fromkeys(line for path in paths_of(table) for line in check_manifest(path))
    return tuple(Remark("warning", "", line) for line in found)


StudyTables = Annotated[
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
        metavar="[AXIS=]SIZE",
        help="Width of the tolerance, in mm or degrees, or with a unit: 0.06, X=60um.",
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
    table: StudyTables,
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
    check_outputs([output], table, pictures=[plot])
    found = gauge_study(
        table,
        tolerance=parse_sizes("--tolerance", tolerance or (), "write --tolerance 0.06, or 60um"),
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
        write_result(found)
    else:
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
        following = reporting.NextStep(f"scara-iso gauge-study {again}", "every figure")
        write_report(reporting.gauge_study_report(found, following), full=full)
    exit_by([found.conformity])
