"""The screen of a recording in progress, and a progress bar on a terminal.

Large signs, three by five points, are read from two metres; a character shows two points.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.padding import Padding
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn
from rich.text import Text

from scara_iso.render.terminal import DIGITS, encodes
from scara_iso.reporting import LEVELS, printable, sparkline

_GLYPHS = {
    "0": ("###", "# #", "# #", "# #", "###"),
    "1": ("  #", "  #", "  #", "  #", "  #"),
    "2": ("###", "  #", "###", "#  ", "###"),
    "3": ("###", "  #", "###", "  #", "###"),
    "4": ("# #", "# #", "###", "  #", "  #"),
    "5": ("###", "#  ", "###", "  #", "###"),
    "6": ("###", "#  ", "###", "# #", "###"),
    "7": ("###", "  #", "  #", "  #", "  #"),
    "8": ("###", "# #", "###", "# #", "###"),
    "9": ("###", "# #", "###", "  #", "###"),
    "-": ("   ", "   ", "###", "   ", "   "),
    ".": (" ", " ", " ", " ", "#"),
    " ": (" ", " ", " ", " ", " "),
    "X": ("# #", "# #", " # ", "# #", "# #"),
    "Y": ("# #", "# #", " # ", " # ", " # "),
    "Z": ("###", "  #", " # ", "#  ", "###"),
    "θ": (" # ", "# #", "###", "# #", " # "),
}
_HEIGHT = 5
_HALVES = {"  ": " ", "# ": "▀", " #": "▄", "##": "█"}
_LARGEST = 4


def large(text: str, width: int, height: int) -> list[str]:
    """Return the lines of ``text``, the largest that fit; none where not even the smallest do."""
    if not text or not set(text) <= set(_GLYPHS):
        return []
    points = [" ".join(_GLYPHS[sign][row] for sign in text) for row in range(_HEIGHT)]
    for scale in range(_LARGEST, 0, -1):
        lines = _halved(["".join(p * scale for p in row) for row in points for _ in range(scale)])
        if len(lines) <= height and len(lines[0]) <= width:
            return lines
    return []


def _halved(rows: list[str]) -> list[str]:
    if len(rows) % 2:
        rows = [*rows, " " * len(rows[0])]
    pairs = zip(rows[::2], rows[1::2], strict=True)
    return ["".join(_HALVES[a + b] for a, b in zip(*pair, strict=True)) for pair in pairs]


Item = TypeVar("Item")


def track(items: Iterable[Item], total: int, console: Console) -> Iterator[Item]:
    """Yield ``items`` and show how many of ``total`` came; the bar goes away at the end."""
    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    shown = console.is_terminal and total > 0
    with Progress(*columns, console=console, transient=True, disable=not shown) as progress:
        yield from progress.track(items, total=total)


_TONES = {"good": "bold green", "bad": "bold red", "quiet": "dim", "plain": ""}
_INDENT = "  "
_WIDE = 60
_OTHER_ROWS = 9
"""Rows of the screen that are not of an axis: head, progress, place, status and keys."""


@dataclass(frozen=True, slots=True)
class AxisView:
    """One axis: what its indicator showed last, and the readings stored [mm or deg]."""

    name: str
    shown: str = ""
    unit: str = ""
    stored: int = 0
    """The last cycle whose reading of this axis is on disk."""
    readings: tuple[float, ...] = ()
    """Those that count for the repeatability: without the first cycle."""
    figures: str = ""
    """Count, mean and repeatability of them, as far as so many readings have any."""


@dataclass(frozen=True, slots=True)
class LiveView:
    """What the screen shows, decided elsewhere."""

    title: str
    stored: int
    planned: int
    axes: Sequence[AxisView]
    place: str = ""
    """Where in a whole test this recording is."""
    status: tuple[str, str] = ("", "plain")
    """The last thing that happened, and its tone: good, bad, quiet or plain."""
    troubles: str = ""
    next_step: str = ""
    keys: str = ""
    prompt: str = ""
    """A question and what was typed so far, in the place of the keys."""
    warning: tuple[str, ...] = ()
    """What the readings show besides scatter, and what to do about it."""
    large: bool = False
    """Whether the readings are shown in large digits, as far as there is room."""
    counted: str = "cycles"
    """What ``stored`` and ``planned`` count."""


class LiveScreen:
    """Redraws one view over the other; leaves the last one standing when closed."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._live = Live(console=console, auto_refresh=False, transient=False)

    def __enter__(self) -> LiveScreen:
        return self

    def __exit__(self, *_: object) -> None:
        self._live.stop()

    def ring(self) -> None:
        """Sound the terminal's bell."""
        self._console.bell()

    def show(self, view: LiveView) -> None:
        """Draw the view in the place of the one before."""
        self._live.start()
        self._live.update(draw(view, self._console), refresh=True)


def draw(view: LiveView, console: Console) -> RenderableType:
    """Return the view for the console's width and characters."""
    blocks = encodes(console, LEVELS)
    width = max(console.width, 20)
    lines: list[RenderableType] = [
        _head(view, width),
        _progress(view, width, blocks=blocks),
        *([Text(f"{_INDENT}{printable(view.place)}")] if view.place else []),
        Text(),
    ]
    rows = _OTHER_ROWS + sum(len(line) // (width - len(_INDENT)) + 1 for line in view.warning)
    besides = 2 if width >= _WIDE else 3  # name and strip, and the figures where it is narrow
    room = (console.height - rows) // max(len(view.axes), 1) - besides if view.large else 0
    for axis in view.axes:
        lines += _named(axis, width, blocks=blocks)
        lines += _large(axis, width, room) if blocks else []
        lines += _strip(axis, width, blocks=blocks)
    return Group(*lines, Text(), *_foot(view, blocks=blocks))


def _foot(view: LiveView, *, blocks: bool) -> list[RenderableType]:
    text, tone = view.status
    mark = {"good": "✔ " if blocks else "OK ", "bad": "✘ " if blocks else "!! "}.get(tone, "")
    last = (f"{view.prompt}_", "bold") if view.prompt else (view.keys, "dim")
    lines = [
        (f"{mark}{text}", _TONES[tone]),
        (view.troubles, "bold"),
        *((f"! {line}" if not k else line, "bold reverse") for k, line in enumerate(view.warning)),
        (view.next_step, "bold"),
    ]
    return [
        Padding(Text(printable(text), style), (0, 0, 0, len(_INDENT)))
        for text, style in [*lines, last]
        if text
    ]


def _head(view: LiveView, width: int) -> Text:
    words = f"{view.counted} stored" if width >= _WIDE else "stored"
    count = f"{view.stored} of {view.planned} {words}"
    title = printable(view.title)
    room = width - len(count) - 2 * len(_INDENT) - 1
    if len(title) > room:
        title = "…" + title[len(title) - room + 1 :] if room > 4 else ""
    line = Text(f"{_INDENT}{title:<{room}} ", "bold")
    line.append(f"{count}", "bold" if view.stored < view.planned else "bold green")
    return line


def _progress(view: LiveView, width: int, *, blocks: bool) -> Text:
    room = width - 2 * len(_INDENT)
    done = min(room, room * view.stored // max(view.planned, 1))
    full, empty = ("━", "─") if blocks else ("#", ".")
    return Text.assemble(_INDENT, (full * done, "green"), (empty * (room - done), "dim"))


def _large(axis: AxisView, width: int, room: int) -> list[Text]:
    name = "θ" if axis.name == "theta" else axis.name
    signs = large(axis.shown and f"{name} {axis.shown}", width - 2 * len(_INDENT), room)
    return [Text(f"{_INDENT}{row}", "bold green") for row in signs]


def _named(axis: AxisView, width: int, *, blocks: bool) -> list[Text]:
    name = Text(f"{_INDENT}{axis.name:<6}", "bold")
    value = f"{axis.shown} {axis.unit}".strip() or "-"
    name.append(f"{printable(value):>14} ", "bold green" if axis.stored else "")
    mark = "✔" if blocks else "OK"
    name.append(f"{mark} {axis.stored:<3}" if axis.stored else " " * 5, "bold green")
    figures = Text(f"  {axis.figures}" if axis.figures else "")
    return [name + figures] if len(name) + len(figures) <= width else [name, _below(figures)]


def _strip(axis: AxisView, width: int, *, blocks: bool) -> list[Text]:
    if not axis.readings:
        return []
    shown = np.array(axis.readings[-(width - 10) :])
    return [_below(Text(sparkline(shown, LEVELS if blocks else DIGITS, width)))]


def _below(text: Text) -> Text:
    return Text(f"{_INDENT}{'':<6}") + text
