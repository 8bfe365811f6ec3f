"""The report on the characteristics that no pose's own tables show."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scara_iso.iso9283 import Analysis, Characteristic
from scara_iso.reporting.blocks import Cell, Number, Section, Table
from scara_iso.reporting.digits import U_of_scatter, interval, rounded

_OF_A_POSE = ("AP", "RP", "RP_a", "RP_rss")


def characteristics(analysis: Analysis, *, advice: bool = True) -> Iterator[Section]:
    """Yield one table of them, where there is one; ``advice`` names the command that explains."""
    found = [one for one in analysis.characteristics if one.code not in _OF_A_POSE]
    if found:
        yield Section("characteristics", (characteristics_table(found, advice=advice),))


def characteristics_table(found: Sequence[Characteristic], *, advice: bool = True) -> Table:
    """Return a table of characteristics."""
    header = ("characteristic", "pose", "of", "figure", "95 % interval", "n", "in")
    how = "scara-iso explain CODE says more about each" if advice else ""
    return Table(header, tuple(_row(one) for one in found), how)


def _row(found: Characteristic) -> tuple[Cell, ...]:
    estimate = found.estimate
    ends = estimate.interval
    U = U_of_scatter(estimate.value, estimate.n) if ends is None else (ends[1] - ends[0]) / 2
    return (
        f"{found.code} ({estimate.clause})",
        found.pose or "",
        found.of,
        rounded(estimate.value, U),
        interval(ends),
        Number(estimate.n),
        estimate.unit,
    )
