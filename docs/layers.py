"""Draw docs/figures/layers.svg from the layer contract; `docs/generate.py` calls it."""

from __future__ import annotations

import configparser
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "scara_iso"
ROLES = {
    "#cfe3f3": ("commands", "recorder", "render", "tables", "rawfile", "testfolder"),
    "#f6e3c5": ("reporting", "diagnosis", "comparison", "gauge", "fleets"),
    "#dcebd5": ("robot", "effects"),
    "#eeeeee": ("iso9283", "run", "signals"),
}
KEY = {
    "#cfe3f3": "files, ports, screens",
    "#f6e3c5": "analysis and reports",
    "#dcebd5": "the robot",
    "#eeeeee": "the test",
    "#ffffff": "basics",
}
WIDTH, HEIGHT, GAP, LEFT = 960, 34, 10, 36


def layers() -> list[list[str]]:
    """Return the packages of each layer, the highest first, as the layer contract has them."""
    contract = configparser.ConfigParser()
    contract.read(ROOT / ".importlinter", encoding="utf-8")
    found = contract["importlinter:contract:layers"]["layers"].strip().splitlines()
    return [[name.strip(" ()") for name in layer.split("|")] for layer in found]


def picture() -> str:
    """Return the layers as an SVG, whose boxes may import only from boxes below them."""
    rows = layers()
    bottom = len(rows) * (HEIGHT + GAP)
    size = f'viewBox="0 0 {WIDTH} {bottom + 34}"'
    text = 'font-family="sans-serif" font-size="14" text-anchor="middle"'
    down = f"M16 8V{bottom - 14}m-6 -10l6 12l6 -12"
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" {text}>',
        "<title>The layers of scara_iso: a package imports only from the layers below it</title>",
        f'<rect width="{WIDTH}" height="{bottom + 34}" fill="white"/>',
        f'<path d="{down}" fill="none" stroke="#333" stroke-width="2"/>',
    ]
    for k, row in enumerate(rows):
        lines += _row(row, k * (HEIGHT + GAP) + 2)
    step = (WIDTH - LEFT) / len(KEY)
    for k, (colour, meaning) in enumerate(KEY.items()):
        x = LEFT + k * step
        lines.append(
            f'<rect x="{x:g}" y="{bottom + 8}" width="16" height="16" fill="{colour}" '
            'stroke="#888"/>'
        )
        lines.append(f'<text x="{x + 24:g}" y="{bottom + 21}" text-anchor="start">{meaning}</text>')
    return "\n".join([*lines, "</svg>\n"])


def _row(packages: list[str], y: int) -> list[str]:
    width = (WIDTH - LEFT - GAP * (len(packages) - 1)) / len(packages)
    drawn = []
    for k, package in enumerate(packages):
        x = LEFT + k * (width + GAP)
        colour = next((c for c, names in ROLES.items() if package in names), "#ffffff")
        drawn.append(
            f'<rect x="{x:.1f}" y="{y}" width="{width:.1f}" height="{HEIGHT}" rx="4" '
            f'fill="{colour}" stroke="#888"/>'
            f'<text x="{x + width / 2:.1f}" y="{y + 22}">{package}</text>'
        )
    return drawn
