"""The pictures of a report: inline SVG in one style, to be told apart without colour."""

from __future__ import annotations

import io
import re
from contextlib import AbstractContextManager
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scara_iso.render.plots import AREA, ARM, EDGE, PLANE, SOLID
from scara_iso.reporting import Course, DriftPicture, Figure, Plane, Prediction, printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing

_STYLE: dict[str, Any] = {
    "font.size": 8.5, "axes.spines.top": False, "axes.spines.right": False,
    "axes.edgecolor": EDGE, "axes.grid": True, "grid.color": "#e3e8ed", "grid.linewidth": 0.6,
    "axes.axisbelow": True, "xtick.color": ARM, "ytick.color": ARM, "axes.labelcolor": ARM,
    "axes.formatter.useoffset": False, "svg.fonttype": "none", "path.simplify": False,
}  # fmt: skip
_OWN_STYLE = re.compile(r"<metadata>.*?</metadata>|<defs>\s*<style.*?</defs>", re.DOTALL)
_NAMES = re.compile(
    r' id="(?:figure|axes|patch|line2d|text|xtick|ytick|matplotlib|legend|Path)[^"]*"'
)


def picture(figure: Figure, number: int) -> str:
    """Return a figure of a report as inline SVG, with its words for those who cannot see it.

    ``number`` makes the picture's identifiers its own within a page.
    """
    file = io.StringIO()
    with _style(number):
        _drawn(figure).savefig(file, format="svg", metadata={"Date": None, "Creator": None})
    return _inline(file.getvalue(), figure)


def picture_png(figure: Figure) -> bytes:
    """Return a figure of a report as PNG."""
    file = io.BytesIO()
    with _style(0):
        _drawn(figure).savefig(file, format="png", dpi=200, metadata={"Software": None})
    return file.getvalue()


def picture_size(figure: Figure) -> tuple[float, float]:
    """Return width and height of a figure in inches."""
    return (4.4, 4.0) if isinstance(figure.data, Plane) else (4.4, 2.3)


def _style(number: int) -> AbstractContextManager[None]:
    import matplotlib as mpl  # noqa: PLC0415 - half a second, for pictures only

    style: dict[Any, Any] = {**_STYLE, "svg.hashsalt": f"scara-iso-{number}"}
    return mpl.rc_context(style)


def _drawn(figure: Figure) -> Drawing:
    from matplotlib.figure import Figure as Drawing  # noqa: PLC0415 - half a second, likewise

    drawing = Drawing(figsize=picture_size(figure))
    match figure.data:
        case Course() as data:
            _draw_course(drawing.add_axes((0.18, 0.20, 0.80, 0.76)), data)
        case Plane() as data:
            _draw_plane(drawing.add_axes((0.18, 0.12, 0.80, 0.85)), data)
        case Prediction() as data:
            _draw_prediction(drawing.add_axes((0.18, 0.20, 0.80, 0.69)), data)
        case DriftPicture() as data:
            _draw_drift(drawing.add_axes((0.18, 0.20, 0.80, 0.69)), data)
    return drawing


def _draw_course(axes: Axes, data: Course) -> None:
    if data.resolution is not None:
        half = data.resolution / 2
        axes.axhspan(data.mean - half, data.mean + half, color=AREA, lw=0)
    axes.axhline(data.mean, color=SOLID, lw=1.2, ls=(0, (5, 3)))
    axes.plot(data.cycle, data.readings, "o-", color=ARM, lw=0.6, ms=3.2)
    axes.set(xlabel="cycle", ylabel=f"{data.axis} [{data.unit}]")


def _draw_plane(axes: Axes, data: Plane) -> None:
    turn = np.linspace(0, 2 * np.pi, 121)
    places, counts = np.unique(data.positions.round(9), axis=1, return_counts=True)
    x, y = data.barycentre
    axes.plot(x + data.RP * np.cos(turn), y + data.RP * np.sin(turn), color=SOLID, lw=1.2)
    axes.scatter(
        places[0], places[1], s=22 * counts, facecolor=PLANE, edgecolor=ARM, lw=0.7, alpha=0.75
    )
    axes.plot(x, y, "+", color=SOLID, ms=11, mew=1.6)
    reach = 1.1 * max(data.RP, float(np.abs(data.positions - data.barycentre[:, None]).max()))
    if reach > 0:
        axes.set(xlim=(x - reach, x + reach), ylim=(y - reach, y + reach))
    axes.set(xlabel="X [mm]", ylabel="Y [mm]", aspect="equal")
    axes.locator_params(nbins=5)


def _draw_prediction(axes: Axes, data: Prediction) -> None:
    axes.plot(data.cycle, data.measured, "o", color=ARM, ms=3.2, label="measured")
    axes.plot(data.cycle, data.before, color=SOLID, lw=1.3, ls=(0, (5, 3)), label="before")
    axes.plot(data.cycle, data.after, color=PLANE, lw=2, label="after")
    axes.set(xlabel="cycle", ylabel=f"{data.axis} [{data.unit}]")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.98), ncols=3, frameon=False)


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


def font_file(name: str) -> Path:
    """Return the file of one of the fonts that come with matplotlib."""
    import matplotlib as mpl  # noqa: PLC0415 - half a second, for pictures only

    return Path(mpl.get_data_path()) / "fonts" / "ttf" / name
