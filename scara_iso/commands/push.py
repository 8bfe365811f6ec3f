"""`push`: lost motion, friction and stiffness of a joint from a force loop."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Unpack

from scara_iso import reporting
from scara_iso.commands.shared.inputs import DialOptions, one_of, refuse_unknown, sizes_of
from scara_iso.commands.shared.options import (
    Asked,
    argument,
    option,
    parse_limits,
    takes_options_of,
)
from scara_iso.commands.shared.output import Answer
from scara_iso.iso9283 import DecisionRule, Limit, PushResult, push_test
from scara_iso.signals import loop_of, read_loop
from scara_iso.tables import Source, read_table


def push(
    table: Source,
    *,
    axis: str | None = None,
    arm: float | None = None,
    limits: Limit | Mapping[str, Limit] | None = None,
    decision: str = DecisionRule.INTERVAL.value,
    **dial: Unpack[DialOptions],
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
    refuse_unknown(push, dial)
    rule = one_of(DecisionRule, "decision", decision)
    wanted = sizes_of("limits", limits, pairs=True)
    loop = read_loop(table, **dial) if axis is None else loop_of(read_table(table, **dial), axis)
    return push_test(loop, arm_m=arm, limits=wanted, decision=rule)


def _limits(texts: Sequence[str]) -> dict[str, Limit]:
    """Return the limits by figure; ``0.20..0.24`` is a smallest and a largest value."""
    both = re.compile(r"(.*=)?([^=]*?)\.\.([^=]*)\Z", re.DOTALL)
    upper = parse_limits([both.sub(r"\1\3", text) for text in texts])
    lower = parse_limits([both.sub(r"\1\2", text) for text in texts if both.search(text)])
    return {name: (lower[name], one) if name in lower else one for name, one in upper.items()}


@takes_options_of(
    push,
    "full",
    "json",
    table=argument("Table with force_N and reading; - is standard input.", "LOOP", str),
    axis=option("Axis, where the table has readings of several.", metavar="X"),
    arm=option("Distance from the joint to dial and force [m]."),
    limits=option(
        "Limit of the lost motion [arcmin]; hysteresis=2 for another figure of the joint, "
        "deflection_mm=0.20..0.24 for both ends of a figure. Exit code 1 unless it is proven to be "
        "kept.",
        "--limit",
        read=_limits,
        metavar="[FIGURE=]SIZE",
    ),
)
def push_command(asked: Asked[PushResult]) -> Answer:
    """Compute lost motion, friction and stiffness of a joint from a force loop.

    Example: scara-iso push examples/push.csv --arm 0.25 --limit 1.5
    """
    found = asked.result()
    following = reporting.NextStep(
        f"scara-iso push {asked.line(full=True)}", "every figure", in_full=True
    )
    report = partial(reporting.push_report, found, following)
    return Answer(found, report, verdicts=[found.conformity])
