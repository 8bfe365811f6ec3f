"""Axes and numbers that are read from two metres: signs as large as there is room.

A sign is three by five points. A character shows two points, one above the other.
"""

from __future__ import annotations

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
