"""Reports on a terminal: the one home of rich.

Text from files is never markup, and its control characters are shown, not obeyed. A table that is
too wide for the terminal is printed row by row, one figure a line. A report has everything; a
screen has room for so much of it, and what is left out is counted.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby
from typing import TextIO

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table as RichTable
from rich.text import Text as RichText

from scara_iso.reporting import (
    LEVELS,
    Block,
    Facts,
    Figure,
    NextStep,
    Notice,
    Report,
    Section,
    Signature,
    Strip,
    Table,
    Text,
    printable,
    sparkline,
)
from scara_iso.run import FloatArray

# Yellow and cyan have a contrast of 2 on white, blue and magenta on black: what matters is bold, or
# in the terminal's own colour, and the marks say the rest.
_STYLES = {
    "plain": "",
    "quiet": "dim",
    "strong": "bold",
    "good": "bold green",
    "warn": "bold",
    "bad": "bold red",
}
_MARKS = {"error": ("x", "bold red"), "warning": ("!", "bold"), "info": ("-", "dim")}
DIGITS = "0123456789"
_INDENT = 2
_GAP = " " * 3
_ENDLESS = 10_000
_GLUE = "\ue000"  # no text holds it: `printable` makes it visible
_TOGETHER = re.compile(r"\[\S+, \S+\]|--[a-z][-a-z]* (?!-)\S+|\d (?:mm|deg|µrad)\b")
"""What no line is broken in: an interval, an option with its value, a figure with its unit."""
_MOST_POSES, _MOST_ROWS, _MOST_NOTES, _LONGEST = 10, 100, 6, 2000
"""Poses (or tables) of a report, rows of a table or texts in a row, quiet ones, letters of one."""


def open_console(stream: TextIO, *, no_color: bool = False) -> Console:
    """Return a console on ``stream``: colour only where it is a terminal and wants it."""
    return Console(
        file=stream,
        no_color=True if no_color else None,
        highlight=False,
        markup=False,
        emoji=False,
        soft_wrap=False,
    )


def show(report: Report, console: Console, *, full: bool = False) -> None:
    """Print a report, as much of it as a screen has room for; notes all where it is ``full``."""
    most_notes = _MOST_ROWS if full else _MOST_NOTES
    for k, section in enumerate(_shortened(report)):
        if k and section.depth != "more":
            console.print()
        if section.heading:
            console.print(RichText(printable(section.heading), "bold underline"))
        label_width = max((len(b.label) for b in section.blocks if isinstance(b, Strip)), default=0)
        for block in _some(section.blocks, most_notes):
            _show_block(block, console, label_width)
    console.print()


def _shortened(report: Report) -> Iterator[Section]:
    for _, sections in groupby(report, key=lambda section: bool(section.one_of)):
        like = list(sections)
        names = list(dict.fromkeys(section.one_of for section in like))
        yield from (section for section in like if section.one_of in names[:_MOST_POSES])
        if len(names) > _MOST_POSES:
            yield Section("", (_left_out(names[_MOST_POSES:], "more like these"),))


def _some(blocks: Sequence[Block], most_notes: int) -> Iterator[Block]:
    def kind(block: Block) -> tuple[type[Block], int]:
        return type(block), _most(block, most_notes)

    for (_, most), group in groupby(blocks, key=kind):
        like = list(group)
        shown = most if len(like) > most + 1 else len(like)  # a line says how many are left out
        yield from like[:shown]
        if len(like) > shown:
            yield _left_out(like[shown:])


def _most(block: Block, most_notes: int) -> int:
    match block:
        case Text(tone="quiet"):
            return most_notes
        case Notice() | Text(tone="plain"):
            return _MOST_ROWS
    return _ENDLESS


def _left_out(what: Sequence[object], text: str = "more") -> Text:
    return Text(f"{len(what)} {text}; --json gives them all", "quiet")


def _show_block(block: Block, console: Console, label_width: int) -> None:
    match block:
        case Table(readings=()):
            _show_table(block, console)
        case Table():
            _show_with_readings(block, console)
        case Facts():
            _show_table(Table((block.heading, ""), block.rows), console)
        case NextStep():
            _print_next(block, console)
        case _:
            _print_indented(_in_lines(block, console, label_width), console)


def _in_lines(
    block: Text | Strip | Notice | Signature | Figure, console: Console, label_width: int
) -> RichText:
    match block:
        case Text():
            return RichText(_cut(_in_one_line(block, console)), _STYLES[block.tone])
        case Strip():
            return _strip(block, console, label_width)
        case Notice():
            return _notice(block)
        case Signature():
            return RichText("; ".join(block.lines), "dim")
        case Figure():
            return RichText(printable(f"{block.title}: {block.caption}"), "dim")


def _in_one_line(block: Text, console: Console) -> str:
    text, *parts = map(printable, (block.text, *block.parts))
    for part in parts:
        if cell_len(f"{text}{_GAP}{part}") <= console.width - _INDENT:
            text = f"{text}{_GAP}{part}"
    return text


def _print_next(step: NextStep, console: Console) -> None:
    """Print a command on one line, however long: the terminal wraps it, and it can be copied."""
    line = RichText("Next: ")
    line.append(printable(step.command))
    why = f"{_GAP}{printable(step.once or step.why)}"
    if why.strip() and _INDENT + line.cell_len + cell_len(why) <= console.width:
        line.append(why, "dim")
    elif step.once:
        line.append(f"\n{_GAP}{why}", "dim")
    line.pad_left(_INDENT)
    console.print(line, no_wrap=True, crop=False, overflow="ignore")


def _cut(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ...; --json gives all of it"


def _show_table(whole: Table, console: Console) -> None:
    table = replace(whole, rows=whole.rows[:_MOST_ROWS])
    grid = _grid(table)
    unbounded = console.options.update(max_width=_ENDLESS)
    if Measurement.get(console, unbounded, grid).maximum <= console.width:
        console.print(grid)
    else:
        _show_rows(table, console)
    if len(whole.rows) > _MOST_ROWS:
        _show_block(_left_out(whole.rows[_MOST_ROWS:]), console, 0)
    if table.note:
        _print_indented(RichText(printable(table.note), "dim"), console)


def _show_with_readings(table: Table, console: Console) -> None:
    """Print the rows with their pictures next to the figures, or below where readings lack room."""
    heads, *texts = ([printable(str(cell)) for cell in row] for row in (table.header, *table.rows))
    widths = [max(map(cell_len, column)) for column in zip(heads, *texts, strict=True)]
    room = console.width - _INDENT - sum(widths) - 2 * len(widths)
    longest = max((len(one) for one in table.readings if one is not None), default=0)
    in_line = room >= min(longest, console.width - 2 * _INDENT)
    line = partial(_aligned, widths=widths) if room + widths[-1] >= 0 else _run_together
    _print_row(line(heads), "over the cycles" if in_line else "", console, "bold")
    for readings, cells in zip(table.readings, texts, strict=True):
        picture = _drawn(readings, console, room if in_line else console.width - 2 * _INDENT)
        _print_row(line(cells), picture if in_line else "", console)
        if picture and not in_line:
            _print_row("", picture, console)


def _aligned(cells: Sequence[str], widths: Sequence[int]) -> str:
    first, *others = zip(cells, widths, strict=False)
    return "  ".join([f"{first[0]:<{first[1]}}", *(f"{cell:>{width}}" for cell, width in others)])


def _run_together(cells: Sequence[str]) -> str:
    return "  ".join(filter(None, map(str.strip, cells)))


def _print_row(line: str, picture: str, console: Console, style: str = "") -> None:
    text = RichText(line, style)
    text.append(f"  {picture}", style)
    text.rstrip()
    _print_indented(text, console)


def _drawn(readings: FloatArray | None, console: Console, room: int) -> str:
    if readings is None:
        return ""
    return sparkline(readings, LEVELS if encodes(console, LEVELS) else DIGITS, max(room, 10))


def _grid(table: Table) -> RichTable:
    grid = RichTable(
        box=SIMPLE_HEAD, header_style="bold", show_edge=False, pad_edge=False, padding=(0, 1, 0, 0)
    )
    grid.show_header = any(table.header)
    for k, heading in enumerate(table.header):
        grid.add_column(
            RichText(printable(heading)), justify="right" if k else "left", no_wrap=True
        )
    for row in table.rows:
        grid.add_row(*(RichText(printable(str(cell))) for cell in row))
    return grid


def _show_rows(table: Table, console: Console) -> None:
    """Print each row below its name: headings and cells, on lines of their own without room."""
    headings = [printable(heading) for heading in table.header[1:]]
    width = max(map(len, headings)) if len(headings) > 1 else 0
    for name, *cells in table.rows:
        _print_indented(RichText(printable(str(name)), "bold"), console)
        for heading, cell in zip(headings, (printable(str(c)) for c in cells), strict=True):
            lines = [f"{heading:<{width}}  {cell}" if width else cell]
            if width and 2 * _INDENT + cell_len(lines[0]) > console.width:
                lines = [heading, f"  {cell}"]
            for line in lines if cell else ():
                _print_indented(RichText(line), console, indent=2 * _INDENT)


def _strip(strip: Strip, console: Console, label_width: int) -> RichText:
    room = max(console.width - label_width - _INDENT - 1, 10)
    drawn = _drawn(strip.readings, console, room)
    line = RichText().append(f"{printable(strip.label):<{label_width}} ", "bold").append(drawn)
    caption = f"  {printable(strip.caption)}"
    if len(drawn) + len(caption) > room:
        caption = f"\n{' ' * label_width}{caption}"
    line.append(caption, "dim")
    return line


def encodes(console: Console, text: str) -> bool:
    """Say whether the console can show every character of ``text``."""
    try:
        text.encode(console.encoding)
    except (UnicodeEncodeError, LookupError):
        return False
    return True


def _notice(notice: Notice) -> RichText:
    mark, style = _MARKS[notice.severity]
    line = RichText(f"{mark} ", style)
    line.append(printable(notice.subject), "bold")
    line.append(": " if notice.subject else "")
    line.append(printable(notice.text))
    line.append(f" [{printable(notice.code)}]", "dim")
    return line


def _print_indented(text: RichText, console: Console, *, indent: int = _INDENT) -> None:
    text.plain = _TOGETHER.sub(lambda found: found[0].replace(" ", _GLUE), text.plain)
    for line in text.wrap(console, max(console.width - indent, 1)):
        line.plain = line.plain.replace(_GLUE, " ")
        line.rstrip()
        line.pad_left(indent)
        console.print(line, no_wrap=True, crop=False, overflow="ignore")
