"""`push`: lost motion, friction and stiffness of a joint from a force loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

import typer

from scara_iso import reporting
from scara_iso.base.errors import UsageError
from scara_iso.commands.inputs import sizes_of
from scara_iso.commands.options import (
    AsJson,
    DecimalMark,
    Full,
    LimitRule,
    ResolutionOfTable,
    UnitOfTable,
    parse_limits,
)
from scara_iso.commands.output import command_line, exit_by, write_report, write_result
from scara_iso.iso9283 import DecisionRule, Limit, PushResult, push_test
from scara_iso.signals import loop_of, read_loop
from scara_iso.tables import Source, read_table


def push(
    table: Source,
    *,
    axis: str | None = None,
    arm: float | None = None,
    unit: str | None = None,
    resolution: float | None = None,
    decimal: str | None = None,
    limits: Limit | Mapping[str, Limit] | None = None,
    decision: str = DecisionRule.INTERVAL.value,
) -> PushResult:
    """Return lost motion, friction, stiffness and compliance of a joint that was pushed to and fro.

    ``table`` is a path, ``-``, bytes or an open file with the columns force_N and reading (a
    length), its steps in the order in which they were done. ``axis`` takes that column of a table
    of readings in place of reading. ``arm`` is the distance from the joint to dial and force [m];
    without it there are figures of the reading only. ``unit``, ``resolution`` (in it) and
    ``decimal`` are as in `read_table`. ``limits`` are of the lost motion, or by code
    (``lost_motion``, ``friction_width``, ``hysteresis``, ``deflection``) in arcmin of the joint,
    with ``_mm`` behind in mm; a pair is the smallest and the largest value.
    ``decision`` as in `analyze`. Raises `DataError` for a table that cannot be read or is no loop,
    `UsageError` for values that make no sense.
    """
    words = [rule.value for rule in DecisionRule]
    if decision not in words:
        raise UsageError(f"decision {decision!r}", remedy=f"use {' or '.join(words)}")
    wanted = sizes_of("limits", limits, pairs=True)
    if axis is None:
        loop = read_loop(table, unit=unit, resolution=resolution, decimal=decimal)
    else:
        read = read_table(table, unit=unit, resolution=resolution, decimal=decimal)
        loop = loop_of(read, axis)
    return push_test(loop, arm_m=arm, limits=wanted, decision=DecisionRule(decision))


Loop = Annotated[
    str, typer.Argument(metavar="LOOP", help="Table with force_N and reading; - is standard input.")
]
Arm = Annotated[float | None, typer.Option(help="From the joint to dial and force [m].")]
AxisOfTable = Annotated[
    str | None, typer.Option(metavar="X", help="Take this column of a table of readings.")
]
Limits = Annotated[
    list[str] | None,
    typer.Option(
        metavar="[FIGURE=]SIZE",
        help="Exit with 1 where the lost motion is not proven to be at most this [arcmin]; "
        "hysteresis=2 for another figure of the joint, deflection_mm=0.20..0.24 for one of the "
        "reading, with a smallest value too.",
    ),
]


def push_command(
    loop: Loop,
    *,
    axis: AxisOfTable = None,
    arm: Arm = None,
    limit: Limits = None,
    decision: LimitRule = DecisionRule.INTERVAL,
    unit: UnitOfTable = None,
    resolution: ResolutionOfTable = None,
    decimal: DecimalMark = None,
    full: Full = False,
    json: AsJson = False,
) -> None:
    """Take lost motion, friction and stiffness of a joint from a force loop and a dial.

    Example: scara-iso push examples/push.csv --arm 0.25 --limit 1.5
    """
    found = push(
        loop,
        axis=axis,
        arm=arm,
        unit=unit,
        resolution=resolution,
        decimal=decimal,
        limits=_limits(limit or ()),
        decision=decision.value,
    )
    if json:
        write_result(found)
    else:
        simple = decision is DecisionRule.SIMPLE
        checks = {"limit": limit, "decision": decision.value if simple else None}
        read = {
            "axis": axis,
            "arm": arm,
            "unit": unit,
            "resolution": resolution,
            "decimal": decimal,
        }
        again = command_line([loop], checks | read, full=True)
        following = reporting.NextStep(f"scara-iso push {again}", "every figure")
        write_report(reporting.push_report(found, following), full=full)
    exit_by([found.conformity])


def _limits(texts: Sequence[str]) -> dict[str, Limit]:
    """Return the limits by figure; ``0.20..0.24`` is a smallest and a largest value."""
    split = ((figure, size.partition("..")) for figure, size in map(_apart, texts))
    parts = [(figure, least, dots, most) for figure, (least, dots, most) in split]
    upper = parse_limits(
        [figure + (most if dots else least) for figure, least, dots, most in parts]
    )
    lower = parse_limits([figure + least for figure, least, dots, _ in parts if dots])
    return {name: (lower[name], one) if name in lower else one for name, one in upper.items()}


def _apart(text: str) -> tuple[str, str]:
    figure, equals, size = text.rpartition("=")
    return figure + equals, size
