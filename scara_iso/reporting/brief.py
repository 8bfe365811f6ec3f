"""What every short form is made of: a figure with its interval, cautions, what is left out.

A short form says the answer in three lines, then one table with the picture. A warning is never
left out of it: each stands in the line of cautions, by what it is about.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

from scara_iso.iso9283 import Finding, in_brief, option_in_brief
from scara_iso.origin import SIMULATED
from scara_iso.reporting.blocks import Block, Interval, NextStep, Number, Text
from scara_iso.reporting.digits import places, places_that_decide
from scara_iso.run import Run

_LINE = 74
_MOST_NAMED = 4

Ends = tuple[float, float] | None


def digits_of(value: float, ends: Ends, limit: float | None = None) -> int:
    """Return the decimal places that show two significant digits of the interval.

    Of a figure without one, three digits; more where a limit would seem to be on the other side.
    """
    width = ends[1] - ends[0] if ends else 0.1 * abs(value)
    found = places(width)
    if limit is None:
        return found
    return places_that_decide(limit, (value, *(ends or ())), found)


def figure_cells(
    value: float, ends: Ends, *, limit: float | None = None, mark: str = ""
) -> tuple[Number, Interval | str]:
    """Return a figure and its interval, to the same place."""
    spec = f".{digits_of(value, ends, limit)}f"
    between = Interval(*(Number(end, spec) for end in ends)) if ends else ""
    return Number(value, spec, mark=mark), between


def figure_said(
    name: str, value: float, ends: Ends, unit: str, *, limit: float | None = None, mark: str = ""
) -> str:
    """Return ``XY 0.014 mm [0.009, 0.022]``."""
    number, between = figure_cells(value, ends, limit=limit, mark=mark)
    said = f"{name} {number} {unit}"
    return f"{said} [{between.low}, {between.high}]" if isinstance(between, Interval) else said


def first_three(
    lines: Sequence[Block], following: NextStep, *, answer: int = 2
) -> tuple[Block, ...]:
    """Return the lines with what to do next behind the ``answer``: the third, or below its list."""
    behind = max(answer, 2)
    return (*lines[:behind], following, *lines[behind:])


def simulated(run: Run) -> Iterator[Text]:
    """Yield that no robot was measured, where the table says so."""
    if run.metadata.get("simulated"):
        yield Text(SIMULATED, "bad")


def cautions(findings: Sequence[Finding]) -> Iterator[Text]:
    """Yield every warning in one line, by what it is about."""
    grave = [finding for finding in findings if finding.severity != "info"]
    if not grave:
        return
    by_code: dict[str, list[Finding]] = {}
    for finding in grave:
        by_code.setdefault(finding.code, []).append(finding)
    said = "; ".join(_caution(code, found) for code, found in by_code.items())
    if len(said) > _LINE:
        names = ", ".join(map(_with_option, by_code))
        said = f"{len(by_code)} warnings: {names}" if len(by_code) > 1 else names
    yield Text(f"! {said}", "warn")


def _caution(code: str, found: Sequence[Finding]) -> str:
    subjects = _subjects(found)
    return f"{subjects}: {_with_option(code)}" if subjects else _with_option(code)


def _with_option(code: str) -> str:
    option = option_in_brief(code)
    return f"{in_brief(code)} (state it, as {option})" if option else in_brief(code)


def _subjects(found: Sequence[Finding]) -> str:
    named = [" ".join(part for part in (one.pose, one.axis) if part) for one in found]
    if len(named) <= _MOST_NAMED:
        return ", ".join(filter(None, named))
    by_axis = groupby(sorted(found, key=lambda one: one.axis or ""), key=lambda one: one.axis)
    return ", ".join(f"{axis or 'poses'} ({len(list(like))})" for axis, like in by_axis)


def left_behind(findings: Sequence[Finding]) -> str:
    """Return how much more there is to be read."""
    deviations = sum(bool(one.rule) for one in findings)
    warnings = sum(one.severity != "info" and not one.rule for one in findings)
    others = len(findings) - deviations - warnings
    counted = (
        (warnings, "warning", ""),
        (deviations, "deviation", " from ISO 9283"),
        (others, "remark", ""),
    )
    said = [f"{k} {name}{'s' if k > 1 else ''}{of}" for k, name, of in counted if k]
    return f"{', '.join(said) or 'every figure'}: `full=`"
