"""`push`: what a force loop says of a joint."""

from __future__ import annotations

from collections.abc import Mapping

from scara_iso.base.errors import UsageError
from scara_iso.iso9283 import DecisionRule, Limit, PushResult, push_test
from scara_iso.library.sizes import sizes_of
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
    limits: float | Mapping[str, Limit] | None = None,
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
