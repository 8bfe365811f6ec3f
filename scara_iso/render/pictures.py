"""Pictures in one style, to be told apart without colour; the door to matplotlib.

It takes half a second and opens where a picture is drawn. Pictures have its own defaults and our
style, the same bytes everywhere: not the settings of the user, nor those that lie in a folder of
readings. A user's session keeps its own.
"""

from __future__ import annotations

import io
import os
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import chdir, contextmanager, nullcontext
from html import escape
from itertools import cycle
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from scara_iso.base import process
from scara_iso.reporting import Curve, Figure, Panel, printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing, FigureBase

_SESSION = {"backend", "date.epoch"}
"""Settings that a process has once: none that a picture here depends on."""
_FONT = {"font.sans-serif": ["DejaVu Sans"]}
"""It comes with matplotlib; the next ones of its list may be there or not."""


AREA, EDGE, SOLID, PLANE, INK = "#e8eef4", "#7f97ad", "#1f4e79", "#e69f00", "#444444"
COLOURS = {"ink": INK, "blue": SOLID, "orange": PLANE, "grey": EDGE}
_STYLE: dict[str, Any] = {
    "font.size": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": EDGE,
    "axes.grid": True,
    "grid.color": "#e3e8ed",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.labelcolor": INK,
    "axes.formatter.useoffset": False,
    "svg.fonttype": "none",
    "path.simplify": False,
}
_PAGE, _LEFT, _ABOVE, _BELOW = 7.1, 0.72, 0.2, 0.36  # [inch]
_SIDE_BY_SIDE = 5
"""Panels of several poses."""
_LABEL, _WORDS = 90, 0.25
"""Characters above the panels of a row; height of the words above a picture [inch]."""
_MOST_TICKS, _TICK = 40, 12
_MONTH = 30.0  # days
_LOOKS: dict[str, dict[str, Any]] = {
    "points": {"marker": "o", "ls": "none"},
    "joined": {"marker": "o", "lw": 0.7},
    "line": {"lw": 1.8},
    "dashed": {"lw": 1.3, "ls": (0, (5, 3))},
    "dotted": {"lw": 1.4, "ls": (0, (2, 2))},
    "hollow": {"marker": "o", "ls": "none", "mfc": "none"},
    "above": {"marker": "^", "ls": "none", "mfc": "none", "clip_on": False},
    "below": {"marker": "v", "ls": "none", "mfc": "none", "clip_on": False},
    "ring": {"marker": "o", "ls": "none", "mfc": "none", "mew": 1.6},
    "cross": {"marker": "+", "ls": "none", "mew": 1.4},
}
_SIZES = {"hollow": 4.2, "above": 4.2, "below": 4.2, "ring": 7.0, "cross": 11.0}
_IN_TURN = (("o-", SOLID), ("s--", COLOURS["orange"]), ("^:", INK), ("D-.", EDGE))
_DASHES = ("-", "--", ":", ":")
_OWN_STYLE = re.compile(r"<metadata>.*?</metadata>|<defs>\s*<style.*?</defs>", re.DOTALL)
_NAMES = re.compile(
    r' id="(?:figure|axes|patch|line2d|text|xtick|ytick|matplotlib|legend|Path)[^"]*"'
)


def in_picture(text: str) -> str:
    """Return text of a file as a picture takes it: no mathematics, nothing without a shape."""
    return printable(text).replace("$", r"\$")


def new_figure(
    width: float, height: float, *, layout: Literal["constrained"] | None = None
) -> Drawing:
    """Return an empty figure of a size in inches, which a notebook shows as its picture."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - half a second, for pictures only

    class Picture(Figure):
        def _repr_png_(self) -> bytes:
            file = io.BytesIO()
            self.savefig(file, format="png")
            return file.getvalue()

    return Picture(figsize=(width, height), layout=layout)


@contextmanager
def own_style(style: Mapping[str, Any] = MappingProxyType({})) -> Iterator[None]:
    """Draw by matplotlib's defaults and a style while this lasts; afterwards as before."""
    mpl = _matplotlib()
    defaults = {key: mpl.rcParamsDefault[key] for key in mpl.rcParamsDefault.keys() - _SESSION}
    with mpl.rc_context({**defaults, **_FONT, **style}), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing")  # a box stands for it
        yield


def font_file(name: str) -> Path:
    """Return the file of one of the fonts that come with matplotlib."""
    return Path(_matplotlib().get_data_path()) / "fonts" / "ttf" / name


def _matplotlib() -> Any:
    """Return matplotlib, which reads the settings of the folder that it is first imported in.

    In a process of the program that is a folder of ours, where they say nothing.
    """
    with _among_our_settings() if process.program else nullcontext():
        import matplotlib as mpl  # noqa: PLC0415 - half a second, for pictures only
    return mpl


@contextmanager
def _among_our_settings() -> Iterator[None]:
    try:
        os.chdir(Path.cwd())  # whether there is a way back
    except OSError:  # it is gone or closed to us, and no settings can be read there
        yield
        return
    with chdir(Path(__file__).parent / "settings"):
        yield


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
        drawing = _drawn(figure)
        drawing.savefig(file, format="png", dpi=200, metadata={"Software": None})
    return file.getvalue()


def picture_size(figure: Figure) -> tuple[float, float]:
    """Return width and height in inches: half a page, or a page for several poses."""
    columns, rows = _grid(figure)
    if figure.wide:
        return (_PAGE, 2.9)
    if columns == 1:
        return (4.4, 4.0) if figure.square else (4.4, 2.3)
    width = (_PAGE - _LEFT) / columns
    flat = 1.02 if columns > 2 else 1.5
    return _PAGE, _ABOVE + _BELOW + rows * min(width, 2.2 if figure.square else flat)


def _grid(figure: Figure) -> tuple[int, int]:
    columns = min(len(figure.panels), _SIDE_BY_SIDE)
    return columns, -(-len(figure.panels) // columns)


def _drawn(figure: Figure) -> Drawing:
    drawing = new_figure(*picture_size(figure))
    _draw(drawing, figure)
    return drawing


@own_style(_STYLE)
def plot(figures: Iterable[Figure]) -> Drawing:
    """Return pictures below each other as one, under their words; a caption stands once."""
    shown = list(figures)
    sizes = [picture_size(figure) for figure in shown]
    heights = [one for _, height in sizes for one in (_WORDS, height)]
    drawing = new_figure(max(width for width, _ in sizes), sum(heights))
    parts = drawing.subfigures(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
    last = ""
    for words, part, figure in zip(parts[::2], parts[1::2], shown, strict=True):
        text = figure.title if figure.caption == last else f"{figure.title}: {figure.caption}"
        words.text(0.5, 0.1, in_picture(text), ha="center", va="bottom")
        _draw(part, figure)
        last = figure.caption
    return drawing


def _draw(drawing: FigureBase, figure: Figure) -> None:
    (width, height), (columns, rows) = picture_size(figure), _grid(figure)
    grid = drawing.subplots(rows, columns, sharex=True, sharey=columns > 1, squeeze=False)
    many, panels = columns > 1, grid.ravel().tolist()
    for axes in panels[len(figure.panels) :]:
        axes.remove()
    for axes, panel in zip(panels, figure.panels, strict=False):
        _draw_panel(axes, figure, panel)
        axes.tick_params(labelsize=7 if many else 8)
        if many:
            title = printable(panel.title)[: _LABEL // columns]
            axes.set_title(title, parse_math=False, fontsize=8, pad=2)
    if many:
        drawing.subplots_adjust(_LEFT / width, _BELOW / height, 1 - 0.05 / width)
        drawing.subplots_adjust(top=1 - _ABOVE / height, wspace=0.08, hspace=0.3)
        drawing.supxlabel(figure.x_label, fontsize=8, y=0.01, va="bottom")
        drawing.supylabel(figure.y_label, fontsize=8, x=0.004, ha="left")
        return
    (axes,) = panels
    axes.set(xlabel=figure.x_label, ylabel=figure.y_label)
    named = axes.get_legend_handles_labels()[1]
    left = 0.85 / width if figure.wide else 0.2
    top = 1 - (0.25 if named else 0.1) / height
    bottom = (0.8 if _is_crowded(figure) else 0.46) / height
    drawing.subplots_adjust(left=left, right=1 - 0.2 / width, bottom=bottom, top=top)
    if named:
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.98), ncols=4, frameon=False)


def _draw_panel(axes: Axes, figure: Figure, panel: Panel) -> None:
    """Draw bands, levels and curves; no two look alike without colour."""
    many, first = len(figure.panels) > 1, _first_day() if figure.dates else 0.0
    if panel.across is not None:
        axes.axhspan(*panel.across, color=AREA, lw=0)
    if panel.along is not None:
        axes.axvspan(*panel.along, color=AREA, lw=0)
    dashes: Any = cycle(_DASHES if figure.wide else [(0, (5, 3))])
    for dash, (name, level) in zip(dashes, panel.levels.items(), strict=False):
        colour = EDGE if figure.wide else SOLID
        axes.axhline(level, ls=dash, color=colour, lw=1.2, label=in_picture(name) or None)
    for place in panel.upright:
        axes.axvline(place + first, color=SOLID, lw=0.9, ls=":")
    for curve, look in zip(panel.curves, cycle(_IN_TURN), strict=False):
        _draw_curve(axes, curve, first, 0.6 if many else 1.0, look)
    _scale(axes, figure)
    if figure.dates:
        _name_days(axes, np.concatenate([curve.x for curve in panel.curves]) + first)


def _scale(axes: Axes, figure: Figure) -> None:
    many = len(figure.panels) > 1
    if figure.logarithmic:
        axes.set_yscale("log", subs=[])
        axes.locator_params(axis="y", subs=(1, 2, 5))
        axes.yaxis.set_major_formatter("{x:g}")
    if any(end is not None for end in figure.y_limits):
        axes.set_ylim(*figure.y_limits)
    if figure.x_limits is not None:
        axes.set_xlim(*figure.x_limits)
    if figure.square:
        axes.set_aspect("equal")
        axes.locator_params(nbins=5)
        if many and figure.x_limits is not None:  # beside each other: no label at the edge of one
            half = float(f"{figure.x_limits[1] / 2:.0e}")
            low, high = f"\N{MINUS SIGN}{half:g}", f"{half:g}"
            axes.set_xticks((-half, 0, half), (low, "", high))  # no room for all three
            axes.set_yticks((-half, 0, half), (low, "0", high))
    if figure.ticks and len(figure.ticks) <= _MOST_TICKS:
        names = [in_picture(name[:_TICK]) for name in figure.ticks]
        turned = 90 if _is_crowded(figure) else 0
        axes.set_xticks(range(1, len(names) + 1), names, rotation=turned)


def _is_crowded(figure: Figure) -> bool:
    """Say whether the names of the ticks lack room beside each other."""
    return len("  ".join(name[:_TICK] for name in figure.ticks)) > _LABEL


def _draw_curve(
    axes: Axes, curve: Curve, first: float, scale: float, in_turn: tuple[str, str]
) -> None:
    x, name, ends = curve.x + first, in_picture(curve.name) or None, curve.ends
    if curve.look == "band" and ends is not None:
        axes.fill_between(x, ends[0], ends[1], color=AREA, lw=0, step="mid")
        return
    if curve.hue is None:
        mark, colour = in_turn
        mark = mark[0] if curve.look == "points" else mark
        axes.plot(x, curve.y, mark, color=colour, ms=3.5, lw=1.2, label=name)
        return
    colour = COLOURS[curve.hue]
    if ends is not None:
        reach = np.nan_to_num(np.maximum(np.abs(ends - curve.y), 0))
        axes.errorbar(x, curve.y, yerr=reach, fmt="o", color=colour, ms=3, lw=0.7, label=name)
    elif curve.counts is not None:
        sizes = (22 if scale == 1 else 7) * curve.counts
        look: Any = {"facecolor": colour, "edgecolor": INK, "lw": 0.5, "alpha": 0.75}
        axes.scatter(x, curve.y, s=sizes, label=name, **look)
    else:
        size = scale * _SIZES.get(curve.look, 3.2)
        axes.plot(x, curve.y, color=colour, ms=size, label=name, **_LOOKS[curve.look])


def _first_day() -> float:
    """Return 1970-01-01 as the session counts days, which may be set to begin elsewhere."""
    from matplotlib import dates  # noqa: PLC0415 - half a second, for pictures only

    return float(dates.date2num(np.datetime64("1970-01-01")))  # type: ignore[no-untyped-call]


def _name_days(axes: Axes, days: Any) -> None:
    from matplotlib import dates  # noqa: PLC0415 - half a second, for pictures only

    axes.xaxis_date()
    axes.margins(x=0.07)
    if np.ptp(days) == 0:
        axes.set_xlim(days[0] - _MONTH, days[0] + _MONTH)
    locator = dates.AutoDateLocator(minticks=3, maxticks=7)  # type: ignore[no-untyped-call]
    formatter = dates.ConciseDateFormatter(locator, show_offset=False)  # type: ignore[no-untyped-call]
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(formatter)


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
