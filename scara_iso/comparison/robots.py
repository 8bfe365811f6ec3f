"""Several robots with one program as one test, for its exchangeability (7.7)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from scara_iso.errors import DataError, UsageError
from scara_iso.iso9283 import Analysis, Characteristic, Measured, check_limits, find_characteristics

_CODE = "exchangeability"


def exchangeability(
    analyses: Sequence[Analysis], limits: Mapping[str, float]
) -> tuple[Characteristic, ...]:
    """Return the exchangeability of the robots of several tests, held against ``limits``.

    Raises `DataError` where the dials' zeros are not said to be one, two tables state the same
    serial number, or no pose and axis is in common, and `UsageError` for a limit of another figure.
    """
    _check(analyses)
    tests = [Measured(one.run, one.cycles, one.poses, one.block) for one in analyses]
    first, *others = tests
    test = Measured(first.run, first.cycles, first.poses, first.block, robots=tuple(others))
    found = [
        one for compute in find_characteristics() for one in compute(test) if one.code == _CODE
    ]
    if not found:
        raise DataError(
            "no pose with the same axes is in all tables: no exchangeability",
            remedy="name poses and axes alike",
        )
    return check_limits(found, limits)


def _check(analyses: Sequence[Analysis]) -> None:
    metadata = [analysis.run.metadata for analysis in analyses]
    zeros = {stated.get("dial_zero", "").strip().lower() for stated in metadata}
    if len(zeros) > 1 or "" in zeros:
        raise DataError(
            "the tables do not say that their dials share one zero: no exchangeability",
            remedy="write the same '# dial_zero: command' (or fixture) into each, if it is so",
        )
    serials = [s["serial_number"] for s in metadata if "serial_number" in s]
    if len(set(serials)) < len(serials):
        raise DataError(
            "two tables state the same serial_number: exchangeability is that of several robots",
            remedy="compare runs of one robot without `exchangeability=`",
        )


def refuse_limits(limits: Mapping[str, float] | None) -> None:
    """Raise `UsageError` for limits where no exchangeability is asked for."""
    if limits:
        raise UsageError(
            "a comparison has no figure to be limited", remedy="say `exchangeability=True` as well"
        )
