"""The picture of a comparison: readings about their means, changes with their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from scara_iso.comparison import Comparison, Contrast, ContrastVerdict, Pair
from scara_iso.render.drawing import new_figure, own_style
from scara_iso.render.plots import ARM, EDGE, PLANE
from scara_iso.reporting import printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_PAIRS = 8
_LONGEST_NAME = 28  # letters, its end: two stand above a picture
_RATIOS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5, 10, 20, 50, 100)


@own_style()
def plot_comparison(comparison: Comparison) -> Figure:
    """Return for each pair the readings about their means, ratios of spread, and changes of mean.

    Full marks are differences that are shown; an arrow is an interval without end.
    """
    heights = [0.9 + 0.34 * len(pair.spreads) for pair in comparison.pairs[:_MOST_PAIRS]]
    figure = new_figure(12, sum(heights) + 0.9, layout="constrained")
    rows = figure.subplots(len(heights), 3, squeeze=False, height_ratios=heights)
    for row, pair in zip(rows, comparison.pairs, strict=False):
        _draw_readings(row[0], pair)
        ratios = [(one.ratio or None, one.ratio_interval or (None, None)) for one in pair.spreads]
        row[1].set_xscale("log")
        _draw_intervals(row[1], pair.spreads, ratios, none=1.0)
        row[1].set(xlabel="RP after / before", title="Repeatability: ratio with 95 % interval")
        row[1].xaxis.set_minor_formatter("")
        low, high = row[1].get_xlim()
        ticks = [tick for tick in _RATIOS if low <= tick <= high]
        row[1].set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        changes = [(one.difference, one.difference_interval) for one in pair.means]
        _draw_intervals(row[2], pair.means, changes, none=0.0)
        units = ", ".join(dict.fromkeys(one.unit for one in pair.means))
        row[2].locator_params(axis="x", nbins=5)
        row[2].set(xlabel=f"after − before [{units}]", title="Mean: change with 95 % interval")
    return figure


def _draw_readings(axes: Axes, pair: Pair) -> None:
    labels = []
    before, after = ({pose.label: pose for pose in run.poses} for run in (pair.before, pair.after))
    for k, one in enumerate(pair.means):
        old = before[one.pose] if one.pose in before else pair.before.poses[0]
        new = after[one.pose] if one.pose in after else pair.after.poses[0]
        for shift, pose, marker, colour in ((-0.16, old, "o", EDGE), (0.16, new, "D", PLANE)):
            found = pose.axes[one.figure]
            label = ("before" if shift < 0 else "after") if k == 0 else None
            row = k + shift + np.linspace(-0.13, 0.13, found.n)  # the first cycle on top
            axes.plot(
                found.readings - found.mean,
                row,
                marker,
                ms=3.5,
                mfc="none",
                color=colour,
                ls="none",
                label=label,
            )
        labels.append(_figure_name(one))
    axes.set_yticks(range(len(labels)), labels)
    axes.invert_yaxis()
    axes.locator_params(axis="x", nbins=6)
    axes.set(xlabel="reading − mean of its run [mm or deg]")
    names = [run.run.origin.source[-_LONGEST_NAME:] for run in (pair.before, pair.after)]
    axes.set_title(_label(" → ".join(names)), fontsize=9)
    axes.legend(fontsize=8, frameon=False, loc="best")


def _draw_intervals(
    axes: Axes,
    contrasts: Sequence[Contrast],
    found: Sequence[tuple[float | None, tuple[float | None, float | None]]],
    *,
    none: float,
) -> None:
    axes.axvline(none, color=ARM, lw=0.9, ls="--")
    inner = [value for middle, ends in found for value in (middle, *ends) if value]
    beyond = (min(inner, default=1.0) / 1.3, max(inner, default=1.0) * 1.3)
    for k, (one, (middle, ends)) in enumerate(zip(contrasts, found, strict=True)):
        shown = one.verdict in (ContrastVerdict.LESS, ContrastVerdict.MORE)
        colour = PLANE if shown else EDGE
        bounded = [bool(end) or (end is not None and not none) for end in ends]
        places = [
            e if b and e is not None else beyond[n]
            for n, (e, b) in enumerate(zip(ends, bounded, strict=True))
        ]
        axes.plot(places, [k, k], color=colour, lw=2)
        for place, b, arrow in zip(places, bounded, "<>", strict=True):
            axes.plot(place, k, "|" if b else arrow, color=colour, ms=7)
        if middle is not None:
            axes.plot(middle, k, "o", color=colour, mfc=colour if shown else "white", ms=6)
    axes.set_yticks(range(len(contrasts)), [_figure_name(one) for one in contrasts])
    axes.invert_yaxis()


def _figure_name(one: Contrast) -> str:
    return _label(one.figure if one.pose is None else f"{one.pose} {one.figure}")


def _label(text: str) -> str:
    """Return text of a file as a picture takes it: no mathematics, nothing without a shape."""
    return printable(text).replace("$", r"\$")
