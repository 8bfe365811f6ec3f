"""`gauge_study`: is the dial good enough for the tolerance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Unpack

from scara_iso import render, reporting
from scara_iso.base.errors import UsageError
from scara_iso.base.quantities import Dimension, size_in
from scara_iso.commands.shared import inputs, options as opt, output as out
from scara_iso.gauge import GaugeStudy, Remark, read_gauge_tables, study_gauge
from scara_iso.iso9283 import DecisionRule
from scara_iso.rawfile import check_manifest
from scara_iso.reporting import Document, gauge_study_report
from scara_iso.run import FARTHEST

SEED = 1


def gauge_study(
    table: inputs.Tables,
    *,
    tolerance: inputs.Sizes | None = None,
    reference: inputs.Sizes | None = None,
    decision: str = DecisionRule.SIMPLE.value,
    to: str | Path | None = None,
    seed: int = SEED,
    **dial: Unpack[inputs.DialOptions],
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
    inputs.refuse_unknown(gauge_study, dial)
    rule = inputs.one_of(DecisionRule, "decision", decision)
    paths = [path.resolve() for path in inputs.paths_of(table)]
    if twice := [path.name for k, path in enumerate(paths) if path in paths[:k]]:
        raise UsageError(
            f"{twice[0]} is named twice", remedy="name it once: its readings would count twice"
        )
    tolerances = inputs.sizes_of("tolerance", tolerance)
    _refuse_none(tolerances)
    if to is not None:
        render.find_format(Path(to).name, Path(to).suffix)
        out.check_outputs([Path(to)], [])
    read = read_gauge_tables(
        inputs.tables_of(table),  # type: ignore[arg-type]  # a Run or a frame is refused when read
        references=inputs.sizes_of("reference", reference),
        tolerances=tolerances,
        **dial,
    )
    found = study_gauge(read, decision=rule, seed=seed)
    changed = dict.fromkeys(
        line for path in inputs.paths_of(table) for line in check_manifest(path)
    )
    edited = (Remark("warning", "", line) for line in changed)
    found = replace(found, remarks=(*edited, *found.remarks))
    if to is not None:
        out.write_page(Document("Gauge study", gauge_study_report(found), found), Path(to))
    return found


def _refuse_none(tolerances: Mapping[str, float | str]) -> None:
    for given in tolerances.values():
        units = (unit.value for unit in Dimension)
        sizes = (size_in(given, unit) for unit in units) if isinstance(given, str) else (given,)
        if not any(size is not None and 0 < size < FARTHEST for size in sizes):
            raise UsageError(f"`tolerance={given}`: not a width", remedy="give one above zero")


@opt.takes_options_of(
    gauge_study,
    "full",
    "json",
    table=opt.argument(
        "Readings, with columns part (or pose), operator, session or reference; - is "
        "standard input. Several of one study.",
        "TABLE...",
        list[str],
    ),
    tolerance=opt.option(
        "Width of the tolerance, in mm or degrees, or with a unit: 0.06, X=60um.",
        read=partial(opt.parse_sizes, "--tolerance", remedy="write --tolerance 0.06, or 60um"),
        metavar="[AXIS=]SIZE",
    ),
    reference=opt.option(
        "True value of the part, in the readings' unit.",
        read=partial(opt.parse_sizes, "--reference", remedy="write --reference 0.81"),
        metavar="[AXIS=]SIZE",
    ),
    decision=opt.option(
        "Rule: simple (the figure decides, as in the guidelines) or interval (the whole 95 % "
        "interval decides).",
        kind=DecisionRule,
    ),
    to=opt.output_file(
        f"Report to write, by its ending: {' '.join(render.endings())}; .dfq is AQDEF."
    ),
    plot=opt.option("Picture, .svg or .png."),
)
def gauge_study_command(asked: opt.Asked[GaugeStudy], *, plot: Path | None = None) -> out.Answer:
    """Decide whether a dial is good enough: type 1, R&R, linearity, stability, VDA 5.

    Example: scara-iso gauge-study examples/dial_type_1.csv --tolerance 0.03
    """
    out.check_outputs([asked["to"]], asked["table"], pictures=[plot])
    found = asked.result()
    out.write_picture(found, plot)
    line = asked.line(*asked.parameters.keys() - {"to"}, full=True)
    following = reporting.NextStep(f"scara-iso gauge-study {line}", "every figure", in_full=True)
    report = partial(gauge_study_report, found, following)
    return out.Answer(found, report, asked["to"], verdicts=[found.conformity])
