"""The pictures of a report: inline SVG in one style, to be told apart without colour.

Pictures of one robot over months: a figure with its intervals, and control charts.
"""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from scara_iso.render.drawing import new_figure, own_style
from scara_iso.render.plots import AREA, ARM, EDGE, PLANE, SOLID, draw_chart
from scara_iso.reporting import (
    Chart,
    ControlPicture,
    Course,
    Courses,
    DriftPicture,
    Figure,
    MonthsPicture,
    Plane,
    Planes,
    Prediction,
    Predictions,
    printable,
)
from scara_iso.run import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing


_MARKS = ("o-", "s-")
_MONTH = 30.0  # days


def draw_months(axes: Axes, data: MonthsPicture) -> None:
    """Draw a figure by date, its intervals, trend, limit and services."""
    zero = _first_day()
    when = data.days + zero
    below, above = data.values - data.ends[0], data.ends[1] - data.values
    reach = np.nan_to_num(np.maximum(np.stack([below, above]), 0))
    axes.errorbar(when, data.values, yerr=reach, fmt="o", color=ARM, ms=3, lw=0.7, label="95 %")
    if data.fitted is not None:
        last = when[-len(data.fitted) :]
        axes.plot(last, data.fitted, color=PLANE, lw=1.8, label="trend")
    if data.ahead is not None:
        axes.plot(data.ahead[0] + zero, data.ahead[1], color=PLANE, lw=1.4, ls=(0, (2, 2)))
    if data.limit is not None:
        axes.axhline(data.limit, color=SOLID, lw=1.2, ls=(0, (5, 3)), label="limit")
    axes.set_ylim(bottom=0)
    _finish(axes, data.label, when, [day + zero for day in data.events])


def draw_control(axes: Axes, data: ControlPicture) -> None:
    """Draw a control chart by date; a test at which it speaks is ringed."""
    zero = _first_day()
    when = data.days + zero
    axes.fill_between(when, data.low, data.high, color=AREA, lw=0, step="mid")
    axes.plot(when, data.centre, color=EDGE, lw=0.8)
    for (name, values), mark, colour in zip(data.lines.items(), _MARKS, (ARM, SOLID), strict=False):
        axes.plot(when, values, mark, color=colour, ms=2.6, lw=0.8, label=name)
        at = [k for k in data.alarms if values[k] > data.high[k] or values[k] < data.low[k]]
        axes.plot(when[at], values[at], "o", mfc="none", mec=PLANE, mew=1.6, ms=7)
    _finish(axes, data.label, when, [day + zero for day in data.events])


def _first_day() -> float:
    """Return 1970-01-01 as the session counts days, which may be set to begin elsewhere."""
    from matplotlib import dates  # noqa: PLC0415 - half a second, for pictures only

    return float(dates.date2num(np.datetime64("1970-01-01")))  # type: ignore[no-untyped-call]


def _finish(axes: Axes, label: str, days: FloatArray, events: Sequence[float]) -> None:
    from matplotlib import dates  # noqa: PLC0415 - half a second, for pictures only

    for day in events:
        axes.axvline(day, color=SOLID, lw=0.9, ls=":")
    axes.xaxis_date()
    axes.margins(x=0.07)
    if np.ptp(days) == 0:
        axes.set_xlim(days[0] - _MONTH, days[0] + _MONTH)
    locator = dates.AutoDateLocator(minticks=3, maxticks=7)  # type: ignore[no-untyped-call]
    formatter = dates.ConciseDateFormatter(locator, show_offset=False)  # type: ignore[no-untyped-call]
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(formatter)
    axes.set_ylabel(label)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.98), ncols=4, frameon=False)


_STYLE: dict[str, Any] = {
    "font.size": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": EDGE,
    "axes.grid": True,
    "grid.color": "#e3e8ed",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "xtick.color": ARM,
    "ytick.color": ARM,
    "axes.labelcolor": ARM,
    "axes.formatter.useoffset": False,
    "svg.fonttype": "none",
    "path.simplify": False,
}
_PAGE, _LEFT, _ABOVE, _BELOW = 7.1, 0.62, 0.2, 0.36  # [inch]
Panels = Courses | Planes | Predictions
OneAxes = DriftPicture | MonthsPicture | ControlPicture
_SIDE_BY_SIDE = 5  # panels of several poses
_LABEL = 18  # characters of a pose's name above its panel
_OWN_STYLE = re.compile(r"<metadata>.*?</metadata>|<defs>\s*<style.*?</defs>", re.DOTALL)
_NAMES = re.compile(
    r' id="(?:figure|axes|patch|line2d|text|xtick|ytick|matplotlib|legend|Path)[^"]*"'
)


def picture(figure: Figure, number: int) -> str:
    """Return a figure of a report as inline SVG, with its words for those who cannot see it.

    ``number`` makes the picture's identifiers its own within a page.
    """
    file = io.StringIO()
    with own_style({**_STYLE, "svg.hashsalt": f"scara-iso-{number}"}):
        _drawn(figure).savefig(file, format="svg", metadata={"Date": None, "Creator": None})
    return _inline(file.getvalue(), figure)


def picture_png(figure: Figure) -> bytes:
    """Return a figure of a report as PNG."""
    file = io.BytesIO()
    with own_style(_STYLE):
        _drawn(figure).savefig(file, format="png", dpi=200, metadata={"Software": None})
    return file.getvalue()


def picture_size(figure: Figure) -> tuple[float, float]:
    """Return width and height of a figure in inches: half a page, or a page for several poses."""
    if isinstance(figure.data, OneAxes):
        return (4.4, 2.3)
    if isinstance(figure.data, Chart):
        return (_PAGE, 2.9)
    columns, rows = _grid(figure.data)
    if columns == 1:
        return (4.4, 4.0) if isinstance(figure.data, Planes) else (4.4, 2.3)
    width = (_PAGE - _LEFT) / columns
    height = min(width, 2.2) if isinstance(figure.data, Planes) else min(width, 1.02)
    return _PAGE, _ABOVE + _BELOW + rows * height


def _grid(data: Panels) -> tuple[int, int]:
    """Return how many panels stand beside and below each other."""
    panels = len(data.panels)
    columns = min(panels, _SIDE_BY_SIDE)
    return columns, -(-panels // columns)


def _drawn(figure: Figure) -> Drawing:
    if isinstance(figure.data, OneAxes):
        drawing = new_figure(*picture_size(figure))
        _draw_one(drawing.add_axes((0.18, 0.20, 0.80, 0.69)), figure.data)
        return drawing
    if isinstance(figure.data, Chart):
        drawing = new_figure(*picture_size(figure))
        draw_chart(drawing.add_axes((0.10, 0.16, 0.88, 0.80)), figure.data)
        return drawing
    width, height = picture_size(figure)
    drawing = new_figure(width, height)
    columns, rows = _grid(figure.data)
    grid = drawing.subplots(rows, columns, sharex=True, sharey=columns > 1, squeeze=False)
    if columns > 1:
        drawing.subplots_adjust(
            left=_LEFT / width,
            right=1 - 0.05 / width,
            bottom=_BELOW / height,
            top=1 - _ABOVE / height,
            wspace=0.08,
            hspace=0.3,
        )
    else:
        drawing.subplots_adjust(left=0.2, right=0.98, bottom=0.46 / height, top=1 - 0.1 / height)
    panels = grid.ravel().tolist()
    shown: tuple[Course | Plane | Prediction, ...] = figure.data.panels
    for axes in panels[len(shown) :]:
        axes.remove()
    for k, panel in enumerate(shown):
        _panel(panels[k], figure.data, panel)
        if columns > 1:
            panels[k].set_title(
                printable(panel.pose or "")[:_LABEL], parse_math=False, fontsize=8, pad=2
            )
        panels[k].tick_params(labelsize=7 if columns > 1 else 8)
    _name_axes(figure.data, grid, drawing)
    return drawing


def _draw_one(axes: Axes, data: OneAxes) -> None:
    match data:
        case DriftPicture():
            _draw_drift(axes, data)
        case MonthsPicture():
            draw_months(axes, data)
        case ControlPicture():
            draw_control(axes, data)


def _panel(axes: Axes, data: Panels, panel: Course | Plane | Prediction) -> None:
    many = len(data.panels) > 1
    match panel:
        case Course():
            _draw_course(axes, panel, data.span, about=panel.mean if many else 0.0)
        case Plane():
            _draw_plane(axes, panel, data.span, about=panel.barycentre if many else np.zeros(2))
        case Prediction():
            _draw_prediction(axes, panel, about=float(panel.measured.mean()) if many else 0.0)


def _name_axes(data: Panels, grid: Any, drawing: Drawing) -> None:
    """Name the axes once for all panels: of several the readings stand about their mean."""
    many = len(data.panels) > 1
    minus = " - mean" if many else ""
    match data:
        case Planes():
            x, y = f"X{minus} [mm]", f"Y{minus} [mm]"
        case Courses() | Predictions():
            x, y = "cycle", f"{data.axis}{minus} [{data.unit}]"
    if many:
        drawing.supxlabel(x, fontsize=8, y=0.01, va="bottom")
        drawing.supylabel(y, fontsize=8, x=0.004, ha="left")
    else:
        grid[0][0].set(xlabel=x, ylabel=y)
    if isinstance(data, Predictions) and not many:
        grid[0][0].legend(loc="lower center", bbox_to_anchor=(0.5, 0.98), ncols=3, frameon=False)
        drawing.subplots_adjust(top=0.89)


def _draw_course(axes: Axes, data: Course, span: float, *, about: float) -> None:
    if data.resolution is not None:
        half = data.resolution / 2
        axes.axhspan(data.mean - half - about, data.mean + half - about, color=AREA, lw=0)
    axes.axhline(data.mean - about, color=SOLID, lw=1.2, ls=(0, (5, 3)))
    axes.plot(data.cycle, data.readings - about, "o-", color=ARM, lw=0.6, ms=_small(about, 3.2))
    reach = 1.15 * max(span, (data.resolution or 0) / 2, 1e-9)
    axes.set_ylim(data.mean - about - reach, data.mean - about + reach)
    for cycle, reading in zip(data.discarded_cycle, data.discarded, strict=True):
        off = float(np.clip(reading - data.mean, -0.94 * reach, 0.94 * reach))
        marker = "o" if off == reading - data.mean else "^" if off > 0 else "v"
        place = data.mean - about + off
        axes.plot(cycle, place, marker, mfc="none", mec=ARM, ms=_small(about, 4.2), clip_on=False)


def _small(about: float, size: float) -> float:
    return size if about == 0 else 0.6 * size


def _draw_plane(axes: Axes, data: Plane, span: float, *, about: FloatArray) -> None:
    turn = np.linspace(0, 2 * np.pi, 121)
    places, counts = np.unique(data.positions.round(9), axis=1, return_counts=True)
    places = places - about[:, np.newaxis]
    x, y = data.barycentre - about
    size = 22 if not about.any() else 7
    axes.plot(x + data.RP * np.cos(turn), y + data.RP * np.sin(turn), color=SOLID, lw=1.2)
    axes.scatter(
        places[0], places[1], s=size * counts, facecolor=PLANE, edgecolor=ARM, lw=0.5, alpha=0.75
    )
    axes.plot(x, y, "+", color=SOLID, ms=size / 2, mew=1.4)
    reach = 1.1 * max(span, 1e-9)
    axes.set(xlim=(x - reach, x + reach), ylim=(y - reach, y + reach), aspect="equal")
    axes.locator_params(nbins=4 if about.any() else 5, prune="both" if about.any() else None)


def _draw_prediction(axes: Axes, data: Prediction, *, about: float) -> None:
    axes.plot(
        data.cycle, data.measured - about, "o", color=ARM, ms=_small(about, 3.2), label="measured"
    )
    before, after = data.before - about, data.after - about
    axes.plot(data.cycle, before, color=SOLID, lw=1.3, ls=(0, (5, 3)), label="before")
    axes.plot(data.cycle, after, color=PLANE, lw=2, label="after")


def _draw_drift(axes: Axes, data: DriftPicture) -> None:
    if data.steady is not None:
        low, steady, high = data.steady
        axes.axvspan(low, high, color=AREA, lw=0)
        axes.axvline(steady, color=SOLID, lw=1.2, ls=(0, (5, 3)))
    marks = zip(data.moved.items(), ("o", "s", "^"), (ARM, PLANE, SOLID), strict=False)
    for (name, moved), mark, colour in marks:
        axes.plot(data.hours, moved, mark, color=colour, mfc="none", ms=3.6, label=name)
        if name in data.fitted:
            axes.plot(data.hours, data.fitted[name], color=colour, lw=1.3)
    axes.set(xlabel="hours", ylabel="moved [mm]")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.98), ncols=3, frameon=False)


def _inline(svg: str, figure: Figure) -> str:
    """Return an SVG as part of a page: attributes for styles, its own title, no names in it."""
    body = svg[svg.index("<svg") :]
    body = _OWN_STYLE.sub("", body)
    body = _NAMES.sub("", body)
    body = re.sub(r' style="([^"]*)"', lambda found: _attributes(found[1]), body)
    _, view, rest = re.split(r'(viewBox="[^"]*")[^>]*>', body, maxsplit=1)
    title, caption = (escape(printable(text)) for text in (figure.title, figure.caption))
    words = f"<title>{title}</title><desc>{caption}</desc>"
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        f'role="img" {view} stroke-linejoin="round" stroke-linecap="butt">{words}{rest}'
    )


def _attributes(style: str) -> str:
    """Return a style as presentation attributes, which a page's policy allows."""
    parts = (part.partition(":") for part in style.split(";") if part.strip())
    pairs = {name.strip(): value.strip() for name, _, value in parts}
    if "font-family" in pairs:
        pairs["font-family"] = "'DejaVu Sans', Verdana, Arial, sans-serif"
    return "".join(f' {name}="{value}"' for name, value in pairs.items())
