"""Curves and points over one scale: the picture of a gauge study."""

from __future__ import annotations

from itertools import cycle
from typing import TYPE_CHECKING

from scara_iso.render.drawing import new_figure, own_style
from scara_iso.render.plots import ARM, EDGE, PLANE, SOLID
from scara_iso.reporting import Chart, printable, study_picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from scara_iso.measurement_system import GaugeStudy

_LOOKS = (("o-", SOLID), ("s--", PLANE), ("^:", ARM), ("D-.", EDGE))
_DASHES = ("-", "--", ":", ":")
_MOST_LABELS, _LABEL = 20, 12


@own_style()
def plot_gauge_study(found: GaugeStudy) -> Figure:
    """Return the picture of each dial's study below each other."""
    figure = new_figure(7, 3.4 * len(found.axes), layout="constrained")
    rows = figure.subplots(len(found.axes), 1, squeeze=False)
    for (axes,), study in zip(rows, found.axes.values(), strict=True):
        picture = study_picture(study)
        if isinstance(picture.data, Chart):
            draw_chart(axes, picture.data)
        axes.set_title(f"{picture.title}: {picture.caption}", fontsize=9)
    return figure


def draw_chart(axes: Axes, chart: Chart) -> None:
    """Draw curves, points and levels; no two look alike without colour."""
    for (look, colour), curve in zip(cycle(_LOOKS), chart.curves, strict=False):
        style = look if curve.joined else look[0]
        axes.plot(
            curve.x,
            curve.y,
            style,
            color=colour,
            ms=3.5,
            lw=1.2,
            label=printable(curve.name) or None,
        )
    for dash, (name, level) in zip(cycle(_DASHES), chart.levels.items(), strict=False):
        axes.axhline(level, ls=dash, color=EDGE, lw=1.0, label=name)
    axes.set(xlabel=chart.x_label, ylabel=f"[{chart.unit}]")
    if chart.ticks and len(chart.ticks) <= _MOST_LABELS:
        names = [printable(name)[:_LABEL].replace("$", r"\$") for name in chart.ticks]
        axes.set_xticks(range(1, len(names) + 1), names)
    axes.legend(fontsize=7, frameon=False, ncols=2)
